"""BeamDyn and GXBeam: products of six times with the section stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.programs.axial_first import from_axial_first, to_axial_first
from viscorod.programs.energy_creation import check_product
from viscorod.programs.inputs.program_inputs import ProgramInputs, SectionData, number_text
from viscorod.typing import Floats

__all__ = ["BeamDyn", "GXBeam", "StiffnessProduct"]


@dataclass(frozen=True)
class StiffnessProduct(ProgramInputs):
    """Six times in the program's order.

    Attributes:
        mu: six times, s.
    """

    mu: tuple[float, ...]

    words = ("mu1", "mu2", "mu3", "mu4", "mu5", "mu6")
    units = ("s",) * 6
    axial_first: ClassVar[bool]
    """Whether the program's order is axial first, or viscorod's."""

    @property
    def times(self) -> Floats:
        """The six mu in viscorod's order, s, (6,)."""
        mu = np.array(self.mu)
        return from_axial_first(mu) if self.axial_first else mu

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        times = to_axial_first(data.times) if cls.axial_first else data.times
        return [float(time) for time in times]

    @classmethod
    def _of(cls, numbers: Sequence[float], _data: SectionData, _: Sequence[float], /) -> Self:
        return cls(tuple(numbers))

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Return whether the product creates energy and from which coupling on, and the program's notes."""
        check = check_product(data.stiffness, self.times)
        return ((check.text(),) if np.isfinite(check.factor) else ()) + self.notes


@known_arguments
@dataclass(frozen=True)
class BeamDyn(StiffnessProduct):
    """The six mu of a BeamDyn blade file, in its order, which is viscorod's: its local x, y, z are d1, d2, d3.

    Attributes:
        mu: six times (s; the file's header says "-") for shear x, shear y, extension, bending about x, bending
            about y and torsion.
    """

    program = "beamdyn"
    title = "BeamDyn"
    axial_first = False
    meaning = "F_d = mu S eps_t in the section's axes, mu = diag(mu1 ... mu6)"
    sources = (
        "OpenFAST/openfast: modules/beamdyn/src/BeamDyn.f90, BD_StifAtDeformedQP and BD_DissipativeForce",
        "OpenFAST/openfast: docs/source/user/beamdyn/input_files.rst, Damping Coefficient",
    )
    always_lost = ("the six mu hold for the whole blade",)
    notes = ("BeamDyn has its own numerical damping besides (rhoinf < 1)",)

    def law(self, stiffness: Floats) -> Floats:
        """Return mu S, not symmetric where coupled strains have different mu."""
        return np.asarray(self.times[:, None] * stiffness)

    def text(self) -> str:
        """Return the damping lines of the blade file, whose lines are read by their order, headings too."""
        names = "".join(f"{word:>18}" for word in self.words)
        values = "".join(f"{number_text(value):>18}" for value in self.mu)
        units = "".join(f"{'(s)':>18}" for _ in self.words)
        heading = "DAMPING COEFFICIENT".join(("-" * 22 + " ", " " + "-" * 35))
        return f"1   damp_type\n{heading}\n{names}\n{units}\n{values}"


@known_arguments
@dataclass(frozen=True)
class GXBeam(StiffnessProduct):
    """The six mu of a GXBeam element, in its order (axial, shear, shear | torsion, bending, bending).

    Attributes:
        mu: six times, s.
    """

    program = "gxbeam"
    title = "GXBeam.jl"
    axial_first = True
    meaning = "code: strain = S^-1 F - mu strain_t, hence F_d = S mu eps_t; its manual prints mu S"
    sources = (
        "byuflowlab/GXBeam.jl: src/element.jl, steady_element_properties (strains less mu times their rates)",
        "byuflowlab/GXBeam.jl: src/assembly.jl, keyword damping; docs/src/theory.md, Structural Damping",
        "byuflowlab/GXBeam.jl: src/analyses.jl, defaults of structural_damping",
    )
    notes = (
        "the mu are used where structural_damping = true, which is the default of time_domain_analysis but not of "
        "steady_state_analysis and eigenvalue_analysis",
    )

    def law(self, stiffness: Floats) -> Floats:
        """Return S mu, what the code does; not symmetric where coupled strains have different mu."""
        return np.asarray(stiffness * self.times[None, :])

    def text(self) -> str:
        """Return keywords of Assembly and of the analysis."""
        values = ", ".join(number_text(value) for value in self.mu)
        return (
            f"damping = fill([{values}], nelem)  # keyword of Assembly, s\n"
            "structural_damping = true  # keyword of the analysis"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return what is lost, and where the two orders of the product differ."""
        law, out = self.law(data.stiffness), super().losses(data)
        if float(np.abs(law - law.T).max()) <= 1e-9 * float(np.abs(law).max()):
            return out
        return (
            *out,
            "the manual's mu S and the code's S mu differ here; they take the same power from any strain rate, "
            "since one is the transpose of the other",
        )
