"""Newton (newton-physics): the rod joints of ModelBuilder.add_rod."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.programs.inputs.program_inputs import (
    ProgramInputs,
    SectionData,
    checked_options,
    listed,
    number_text,
)
from viscorod.typing import Floats

__all__ = ["Newton"]


@dataclass(frozen=True)
class Newton(ProgramInputs):
    """Constants of the joints between the capsules of a rod; per joint, not per length.

    Attributes:
        damping: stretch (N s/m), shear (N s/m), bend (N m s/rad), twist (N m s/rad).
        stiffness: the same four (N/m, N/m, N m/rad, N m/rad).
        segment_length: rest length of the capsules, m.
    """

    damping: tuple[float, ...]
    stiffness: tuple[float, ...]
    segment_length: float

    program: ClassVar[str] = "newton"
    title: ClassVar[str] = "Newton rod"
    meaning: ClassVar[str] = (
        "joint force = -damping times rate of the joint's displacement or relative rotation"
    )
    words: ClassVar[tuple[str, ...]] = ("stretch_damping", "shear_damping", "bend_damping", "twist_damping")
    options: ClassVar[tuple[str, ...]] = ("segment_length",)
    sources: ClassVar[tuple[str, ...]] = (
        "newton-physics/newton: newton/_src/sim/builder.py, add_rod and add_joint_rod (package newton 1.8.0)",
        "newton-physics/newton: newton/_src/solvers/vbd/rigid_vbd_kernels.py (package newton 1.8.0)",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """D over the segment length; both shears and both bendings by their means."""
        (length,) = checked_options(cls, options)
        return cls(_four(np.diag(data.damping), length), _four(np.diag(data.stiffness), length), length)

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Four numbers."""
        (length,) = checked_options(cls, options)
        return cls(listed(cls, numbers), _four(np.diag(data.stiffness), length), length)

    @property
    def numbers(self) -> tuple[float, ...]:
        """The four damping constants."""
        return self.damping

    def law(self, stiffness: Floats) -> Floats:
        """Diagonal: the constants times the segment length."""
        del stiffness
        stretch, shear, bend, twist = (value * self.segment_length for value in self.damping)
        return np.diag([shear, shear, stretch, bend, bend, twist])

    def text(self) -> str:
        """Keywords of add_rod."""
        lines = [
            f"# rod with segments of {number_text(self.segment_length)} m",
            "builder.add_rod(",
            "    rod=rod,",
        ]
        for word, stiff, damp in zip(self.words, self.stiffness, self.damping, strict=True):
            mode = word.removesuffix("_damping")
            lines.append(f"    {mode}_stiffness={number_text(stiff)}, {word}={number_text(damp)},")
        return "\n".join([*lines, ")"])

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Four numbers for six strains."""
        return (
            *super().losses(data),
            "one constant for both shears and one for both bendings; with other segments all must be "
            "scaled by 1/length",
        )

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """What changed between versions, and the integrator."""
        return (
            *super().warnings(data),
            "read in newton 1.8.0, where the constants are absolute; the threads 1058 and 1097 of its "
            "repository describe "
            "them as factors of the stiffness: with another version, check which it has",
            "its VBD solver takes the rate from implicit Euler, which damps by itself, more with larger steps",
        )


def _four(diagonal: Floats, length: float) -> tuple[float, ...]:
    shear_1, shear_2, stretch, bend_1, bend_2, twist = (diagonal / length).tolist()
    return stretch, (shear_1 + shear_2) / 2.0, (bend_1 + bend_2) / 2.0, twist
