"""GXBeam.jl: six coefficients per element, axial first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from viscorod.programs.axial_first import from_axial_first, to_axial_first
from viscorod.programs.inputs.products import ProductInputs
from viscorod.programs.inputs.program_inputs import SectionData, number_text
from viscorod.typing import Floats

__all__ = ["GXBeam"]


@dataclass(frozen=True)
class GXBeam(ProductInputs):
    """The six mu of a GXBeam element, in its order (axial, shear, shear | torsion, bending, bending).

    Attributes:
        mu: six times, s.
    """

    program: ClassVar[str] = "gxbeam"
    title: ClassVar[str] = "GXBeam.jl"
    meaning: ClassVar[str] = (
        "code: strain = S^-1 F - mu strain_t, hence F_d = S mu eps_t; its manual prints mu S"
    )
    sources: ClassVar[tuple[str, ...]] = (
        "byuflowlab/GXBeam.jl: src/element.jl, steady_element_properties (strains less mu times their rates)",
        "byuflowlab/GXBeam.jl: src/assembly.jl, keyword damping; docs/src/theory.md, Structural Damping",
    )

    @staticmethod
    def reordered(times: Floats) -> Floats:
        """Six times axial first."""
        return to_axial_first(times)

    @property
    def times(self) -> Floats:
        """The six mu in viscorod's order, s, (6,)."""
        return from_axial_first(np.array(self.mu))

    def law(self, stiffness: Floats) -> Floats:
        """S mu, what the code does; not symmetric where coupled strains have different mu."""
        return np.asarray(stiffness * self.times[None, :])

    def text(self) -> str:
        """Keywords of Assembly and of the analysis."""
        values = ", ".join(number_text(value) for value in self.mu)
        return (
            f"damping = fill([{values}], nelem)  # keyword of Assembly, s\n"
            "structural_damping = true  # keyword of the analysis"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """The two orders of the product, where they differ."""
        law = self.law(data.stiffness)
        skew = float(np.abs(law - law.T).max())
        out = super().losses(data)
        if skew > 1e-9 * float(np.abs(law).max()):
            out = (
                *out,
                "the manual's mu S and the code's S mu differ here; they take the same power from any strain rate, "
                "since one is the transpose of the other",
            )
        return out

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Whether S mu creates energy, and from which coupling on."""
        return (*super().warnings(data), "without structural_damping = true the mu are not used")
