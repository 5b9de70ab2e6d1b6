"""MBDyn and Exudyn: a 6x6 damping matrix, axial first."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.programs.axial_first import STRAINS, VISCOSITIES, from_axial_first, to_axial_first
from viscorod.programs.inputs.program_inputs import (
    ProgramInputs,
    SectionData,
    listed,
    matrix_of,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["DampingMatrix", "Exudyn", "MBDyn"]

Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class DampingMatrix(ProgramInputs):
    """A damping matrix that the program takes as it is."""

    nothing_lost: ClassVar[str]
    """What to say where nothing is lost."""

    @property
    @abstractmethod
    def matrix(self) -> Rows:
        """The damping matrix (6, 6), in the program's order."""

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        return [float(value) for value in to_axial_first(data.damping).ravel()]

    @classmethod
    def _checked(cls, numbers: Sequence[float]) -> Sequence[float]:
        return [float(value) for value in matrix_of(cls, numbers).ravel()]

    @property
    def numbers(self) -> tuple[float, ...]:
        """The six diagonal entries, in the program's order."""
        return tuple(row[k] for k, row in enumerate(self.matrix))

    def law(self, stiffness: Floats) -> Floats:
        """Return the damping matrix."""
        del stiffness
        return from_axial_first(np.array(self.matrix))

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return what of the section's law is lost; usually nothing."""
        return super().losses(data) or (self.nothing_lost,)


@known_arguments
@dataclass(frozen=True)
class MBDyn(DampingMatrix):
    """The 6D law `linear viscoelastic generic` of a beam, in MBDyn's order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        stiffness: 6x6; N, N m, N m^2.
        viscosity: 6x6; the same times s.
    """

    stiffness: Rows
    viscosity: Rows

    program = "mbdyn"
    title = "MBDyn"
    meaning = "F = S eps + S' eps_t with any 6x6 S' (or S' = factor S, `proportional`)"
    words = ("factor, or 6, 21 or 36 entries of the viscosity",)
    units = VISCOSITIES
    sources = (
        "alex-marinov/mbdyn: mbdyn/base/constltp_impl.cc, LinearViscoElasticGenericCLR",
        "alex-marinov/mbdyn: manual/input/beam.tex, Beam Elements (order of the six components)",
    )
    nothing_lost = "nothing: the 6x6 damping matrix is taken as it is"

    @classmethod
    def _checked(cls, numbers: Sequence[float]) -> Sequence[float]:
        """Return the factor of `proportional` (s), or the matrix: 6, 21 (`sym`) or 36 (`matr`) numbers."""
        return listed(cls, numbers) if len(numbers) == 1 else super()._checked(numbers)

    @classmethod
    def _of(cls, numbers: Sequence[float], data: SectionData, _: Sequence[float], /) -> Self:
        stiffness = to_axial_first(data.stiffness)
        viscosity = numbers[0] * stiffness if len(numbers) == 1 else np.reshape(numbers, (6, 6))
        return cls(_rows(stiffness), _rows(viscosity))

    @property
    def matrix(self) -> Rows:
        """The viscosity."""
        return self.viscosity

    @property
    def named_numbers(self) -> tuple[tuple[str, str, float], ...]:
        """The diagonal of the viscosity, by strain."""
        return tuple(
            (f"viscosity, {strain}", unit, value)
            for strain, unit, value in zip(STRAINS, self.units, self.numbers, strict=True)
        )

    def text(self) -> str:
        """Return the law of one evaluation point, as it is pasted into a beam2 or beam3 element."""
        return (
            "linear viscoelastic generic,\n"
            f"\t# stiffness: axial, shear y, shear z, torsion, bending y, bending z\n\t{_matrix(self.stiffness)},\n"
            f"\t# viscosity, the same order, times s\n\t{_matrix(self.viscosity)}"
        )


@known_arguments
@dataclass(frozen=True)
class Exudyn(DampingMatrix):
    """The 6x6 damping matrix of exudyn.BeamSection, in its order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        damping_matrix: N s, N m s, N m^2 s.
    """

    damping_matrix: Rows

    program = "exudyn"
    title = "Exudyn"
    meaning = "(n, m) = D (eps_t, kappa_t) with the 6x6 dampingMatrix D; a cable has bending and axial only"
    words = ("D_axial", "D_shear_y", "D_shear_z", "D_torsion", "D_bend_y", "D_bend_z")
    units = VISCOSITIES
    sources = (
        "jgerstmayr/EXUDYN: docs/RST/structures/PyStructuralElementsDataStructures.rst, PyBeamSection",
        "jgerstmayr/EXUDYN: main/src/Objects/CObjectBeamGeometricallyExact.cpp; the package exudyn 1.13.6, run",
    )
    nothing_lost = "nothing in dampingMatrix itself"
    notes = (
        "ObjectBeamGeometricallyExact of exudyn 1.13.6 drops dampingMatrix without a message (it reads back as "
        "zeros); read it back from the object before you rely on it",
    )

    @classmethod
    def _of(cls, numbers: Sequence[float], _data: SectionData, _: Sequence[float], /) -> Self:
        return cls(_rows(np.reshape(numbers, (6, 6))))

    @property
    def matrix(self) -> Rows:
        """The damping matrix."""
        return self.damping_matrix

    def text(self) -> str:
        """Return Python lines for a beam section, and for a cable with the same bending about y."""
        rows = ",\n    ".join(
            "[" + ", ".join(number_text(value) for value in row) + "]" for row in self.damping_matrix
        )
        diagonal = self.numbers
        return (
            f"sectionData.dampingMatrix = np.array([\n    {rows}])\n"
            "# ObjectANCFCable takes two numbers instead (one bending direction); in older versions they are\n"
            "# physicsBendingDamping and physicsAxialDamping, which exudyn 1.13.6 still takes:\n"
            f"#   bendingDamping={number_text(diagonal[4])}, axialDamping={number_text(diagonal[0])}"
        )


def _rows(matrix: Floats) -> Rows:
    return tuple(map(tuple, matrix.tolist()))


def _matrix(rows: Rows) -> str:
    """Write a matrix in MBDyn's words: `diag`, `sym` with the upper triangle, or `matr`."""
    array = np.array(rows)
    if not np.any(array - np.diag(np.diag(array))):
        return "diag, " + ", ".join(number_text(value) for value in np.diag(array))
    if np.any(array != array.T):
        return "matr, " + ",\n\t\t".join(", ".join(number_text(value) for value in row) for row in array)
    lines = [", ".join(number_text(value) for value in row[k:]) for k, row in enumerate(array)]
    return "sym, " + ",\n\t\t".join(lines)
