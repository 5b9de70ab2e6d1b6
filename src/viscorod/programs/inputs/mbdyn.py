"""MBDyn: the 6D law `linear viscoelastic generic` of a beam."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.programs.axial_first import from_axial_first, to_axial_first
from viscorod.programs.inputs.program_inputs import (
    ProgramInputs,
    SectionData,
    checked_options,
    listed,
    matrix_of,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["MBDyn"]

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class MBDyn(ProgramInputs):
    """Stiffness and viscosity matrices of the law, in MBDyn's order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        stiffness: 6x6; N, N m, N m^2.
        viscosity: 6x6; the same times s.
    """

    stiffness: Rows
    viscosity: Rows

    program: ClassVar[str] = "mbdyn"
    title: ClassVar[str] = "MBDyn"
    meaning: ClassVar[str] = "F = S eps + S' eps_t with any 6x6 S' (or S' = factor S, `proportional`)"
    words: ClassVar[tuple[str, ...]] = ("factor, or 6, 21 or 36 entries of the viscosity",)
    sources: ClassVar[tuple[str, ...]] = (
        "alex-marinov/mbdyn: mbdyn/base/constltp_impl.cc, LinearViscoElasticGenericCLR",
        "alex-marinov/mbdyn: manual/input/beam.tex, Beam Elements (order of the six components)",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """C and D themselves, reordered."""
        checked_options(cls, options)
        return cls(_rows(to_axial_first(data.stiffness)), _rows(to_axial_first(data.damping)))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """One number, the factor of `proportional` (s), or the matrix: 6, 21 (`sym`) or 36 (`matr`) numbers."""
        checked_options(cls, options)
        stiffness = to_axial_first(data.stiffness)
        if len(numbers) == 1:
            (factor,) = listed(cls, numbers)
            return cls(_rows(stiffness), _rows(factor * stiffness))
        return cls(_rows(stiffness), _rows(matrix_of(cls, numbers)))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The six diagonal entries of the viscosity, in MBDyn's order."""
        return tuple(row[k] for k, row in enumerate(self.viscosity))

    def law(self, stiffness: Floats) -> Floats:
        """The viscosity matrix."""
        del stiffness
        return from_axial_first(np.array(self.viscosity))

    def text(self) -> str:
        """The law of one evaluation point, as it is pasted into a beam2 or beam3 element."""
        return (
            "linear viscoelastic generic,\n"
            f"\t# stiffness: axial, shear y, shear z, torsion, bending y, bending z\n\t{_matrix(self.stiffness)},\n"
            f"\t# viscosity, the same order, times s\n\t{_matrix(self.viscosity)}"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Nothing of the section's law."""
        return super().losses(data) or ("nothing: the 6x6 damping matrix is taken as it is",)


def _rows(matrix: Floats) -> Rows:
    return tuple(map(tuple, matrix.tolist()))


def _matrix(rows: Rows) -> str:
    """A matrix in MBDyn's words: `diag` or `sym` with the upper triangle."""
    array = np.array(rows)
    if not np.any(array - np.diag(np.diag(array))):
        return "diag, " + ", ".join(number_text(value) for value in np.diag(array))
    if np.any(array != array.T):
        return "matr, " + ",\n\t\t".join(", ".join(number_text(value) for value in row) for row in array)
    lines = [", ".join(number_text(value) for value in row[k:]) for k, row in enumerate(array)]
    return "sym, " + ",\n\t\t".join(lines)
