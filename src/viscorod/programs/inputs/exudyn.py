"""Exudyn: `dampingMatrix` of a beam section, and the two constants of its cable."""

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
    matrix_of,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["Exudyn"]


@dataclass(frozen=True)
class Exudyn(ProgramInputs):
    """The 6x6 damping matrix of exudyn.BeamSection, in its order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        damping_matrix: N s, N m s, N m^2 s.
    """

    damping_matrix: tuple[tuple[float, ...], ...]

    program: ClassVar[str] = "exudyn"
    title: ClassVar[str] = "Exudyn"
    meaning: ClassVar[str] = (
        "(n, m) = D (eps_t, kappa_t) with the 6x6 dampingMatrix D; a cable has bending and axial only"
    )
    words: ClassVar[tuple[str, ...]] = (
        "D_axial",
        "D_shear_y",
        "D_shear_z",
        "D_torsion",
        "D_bend_y",
        "D_bend_z",
    )
    sources: ClassVar[tuple[str, ...]] = (
        "jgerstmayr/EXUDYN: docs/RST/structures/PyStructuralElementsDataStructures.rst, PyBeamSection",
        "jgerstmayr/EXUDYN: main/src/Objects/CObjectBeamGeometricallyExact.cpp; the package exudyn 1.13.6, run",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """D itself, reordered."""
        checked_options(cls, options)
        return cls(tuple(map(tuple, to_axial_first(data.damping).tolist())))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """The matrix: 6 (its diagonal), 21 or 36 numbers."""
        del data
        checked_options(cls, options)
        return cls(tuple(map(tuple, matrix_of(cls, numbers).tolist())))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The six diagonal entries."""
        return tuple(row[k] for k, row in enumerate(self.damping_matrix))

    def law(self, stiffness: Floats) -> Floats:
        """The damping matrix."""
        del stiffness
        return from_axial_first(np.array(self.damping_matrix))

    def text(self) -> str:
        """Python lines for a beam section, and for a cable with the same bending about y."""
        rows = ",\n    ".join(
            "[" + ", ".join(number_text(value) for value in row) + "]" for row in self.damping_matrix
        )
        diagonal = self.numbers
        return (
            f"sectionData.dampingMatrix = np.array([\n    {rows}])\n"
            "# ObjectANCFCable takes two numbers instead (one bending direction):\n"
            f"#   bendingDamping={number_text(diagonal[4])}, axialDamping={number_text(diagonal[0])}"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Nothing of the section's law; a cable has no torsion, no shear and one bending stiffness."""
        return super().losses(data) or ("nothing in dampingMatrix itself",)

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Elements that drop the matrix."""
        return (
            *super().warnings(data),
            "ObjectBeamGeometricallyExact of exudyn 1.13.6 drops dampingMatrix without a message (it "
            "reads back as zeros); "
            "read it back from the object before you rely on it",
        )
