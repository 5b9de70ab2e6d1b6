"""BeamDyn (OpenFAST): six stiffness-proportional coefficients of a blade."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from viscorod.programs.inputs.products import ProductInputs
from viscorod.programs.inputs.program_inputs import SectionData, number_text
from viscorod.typing import Floats

__all__ = ["BeamDyn"]


@dataclass(frozen=True)
class BeamDyn(ProductInputs):
    """The six mu of a BeamDyn blade file, in its order, which is viscorod's: its local x, y, z are d1, d2, d3.

    Attributes:
        mu: six times (s; the file's header says "-") for shear x, shear y, extension, bending about x, bending
            about y and torsion.
    """

    program: ClassVar[str] = "beamdyn"
    title: ClassVar[str] = "BeamDyn"
    meaning: ClassVar[str] = "F_d = mu S eps_t in the section's axes, mu = diag(mu1 ... mu6)"
    sources: ClassVar[tuple[str, ...]] = (
        "OpenFAST/openfast: modules/beamdyn/src/BeamDyn.f90, BD_StifAtDeformedQP and BD_DissipativeForce",
        "OpenFAST/openfast: docs/source/user/beamdyn/input_files.rst, Damping Coefficient",
    )

    def law(self, stiffness: Floats) -> Floats:
        """The product mu S, not symmetric where coupled strains have different mu."""
        return np.asarray(self.times[:, None] * stiffness)

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
            *super().warnings(data),
            "BeamDyn has its own numerical damping besides (rhoinf < 1)",
        )
