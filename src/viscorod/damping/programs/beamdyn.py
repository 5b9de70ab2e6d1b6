"""BeamDyn (OpenFAST): six stiffness-proportional coefficients of a blade."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.damping.creation import check_product
from viscorod.damping.programs.base import ProgramInputs, SectionData, listed, number_text
from viscorod.typing import Floats

__all__ = ["BeamDyn"]


@dataclass(frozen=True)
class BeamDyn(ProgramInputs):
    """The six mu of a BeamDyn blade file, in its order, which is viscorod's: its local x, y, z are d1, d2, d3.

    Attributes:
        mu: six times (s; the file's header says "-") for shear x, shear y, extension, bending about x, bending
            about y and torsion.
    """

    mu: tuple[float, ...]

    program: ClassVar[str] = "beamdyn"
    title: ClassVar[str] = "BeamDyn"
    meaning: ClassVar[str] = "F_d = mu S eps_t in the section's axes, mu = diag(mu1 ... mu6)"
    words: ClassVar[tuple[str, ...]] = ("mu1", "mu2", "mu3", "mu4", "mu5", "mu6")
    sources: ClassVar[tuple[str, ...]] = (
        "OpenFAST/openfast: modules/beamdyn/src/BeamDyn.f90, BD_StifAtDeformedQP and BD_DissipativeForce",
        "OpenFAST/openfast: docs/source/user/beamdyn/input_files.rst, Damping Coefficient",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """mu_i = D_ii/C_ii."""
        del options
        return cls(tuple(data.times.tolist()))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Six numbers."""
        del data, options
        return cls(listed(cls, numbers, 6))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The six mu."""
        return self.mu

    def law(self, stiffness: Floats) -> Floats:
        """The product mu S, not symmetric where coupled strains have different mu."""
        return np.asarray(np.array(self.mu)[:, None] * stiffness)

    def text(self) -> str:
        """The damping lines of the blade file."""
        names = "".join(f"{word:>18}" for word in self.words)
        values = "".join(f"{number_text(value):>18}" for value in self.mu)
        units = "".join(f"{'(s)':>18}" for _ in self.words)
        return f"1   damp_type\n{names}\n{units}\n{values}"

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """One set of mu serves the whole blade, so it cannot follow times that change along the rod."""
        return (*super().losses(data), "the six mu hold for the whole blade")

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Whether mu S creates energy, and from which coupling on."""
        return (
            *_product_warning(data, self.mu),
            "BeamDyn has its own numerical damping besides (rhoinf < 1)",
        )


def _product_warning(data: SectionData, mu: tuple[float, ...]) -> tuple[str, ...]:
    check = check_product(data.stiffness, mu)
    return (check.text(),) if check.couplings and np.isfinite(check.factor) else ()
