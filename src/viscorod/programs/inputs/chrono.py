"""Chrono (Project Chrono): four damping models of its beam sections."""

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
    number_text,
)
from viscorod.programs.times import symmetric_damping
from viscorod.typing import Floats

__all__ = ["ChronoLinear", "ChronoRayleigh", "ChronoTapered"]

_COSSERAT = "projectchrono/chrono: src/chrono/fea/ChBeamSectionCosserat.cpp"


@dataclass(frozen=True)
class ChronoRayleigh(ProgramInputs):
    """beta of ChDampingCosseratRayleigh (IGA beams), or of the Rayleigh damping of a ChBeamSectionEuler.

    Attributes:
        beta: s.
    """

    beta: float

    program: ClassVar[str] = "chrono-rayleigh"
    title: ClassVar[str] = "Chrono, Rayleigh beta"
    meaning: ClassVar[str] = "(n, m) = beta E6x6 (strain rates): one time for all six strains"
    words: ClassVar[tuple[str, ...]] = ("beta",)
    sources: ClassVar[tuple[str, ...]] = (
        f"{_COSSERAT}, ChDampingCosseratRayleigh::ComputeStress",
        "projectchrono/chrono: src/chrono/fea/ChBeamSectionEuler.h (default beta 0.01)",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """The time of bending, (tau_4 + tau_5)/2: what slender rods do most."""
        checked_options(cls, options)
        return cls(float(data.times[3:5].mean()))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """One number."""
        del data
        checked_options(cls, options)
        return cls(*listed(cls, numbers))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The one number beta."""
        return (self.beta,)

    def law(self, stiffness: Floats) -> Floats:
        """The product beta C."""
        return np.asarray(self.beta * stiffness)

    def text(self) -> str:
        """C++ lines for both kinds of sections."""
        beta = number_text(self.beta)
        return (
            f"auto damping = chrono_types::make_shared<ChDampingCosseratRayleigh>(elasticity, {beta});\n"
            f"// or, for ChElementBeamEuler: section->SetBeamRaleyghDamping({beta});  // as named in the source read"
        )

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """Chrono's silent default."""
        return (
            *super().warnings(data),
            "a ChBeamSectionEuler on which nothing is set has beta = 0.01 s: say so also when you want none",
        )


@dataclass(frozen=True)
class ChronoLinear(ProgramInputs):
    """R_e and R_k of ChDampingCosseratLinear, in Chrono's order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        coefficients: six numbers, N s and N m^2 s.
    """

    coefficients: tuple[float, ...]

    program: ClassVar[str] = "chrono-linear"
    title: ClassVar[str] = "Chrono, linear Cosserat damping"
    meaning: ClassVar[str] = "n = R_e e_t, m = R_k k_t, component by component: a diagonal damping matrix"
    words: ClassVar[tuple[str, ...]] = ("R_e.x", "R_e.y", "R_e.z", "R_k.x", "R_k.y", "R_k.z")
    sources: ClassVar[tuple[str, ...]] = (f"{_COSSERAT}, ChDampingCosseratLinear::ComputeStress",)

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """The diagonal of D."""
        checked_options(cls, options)
        return cls(tuple(to_axial_first(np.diag(data.damping)).tolist()))

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Six numbers."""
        del data
        checked_options(cls, options)
        return cls(listed(cls, numbers))

    @property
    def numbers(self) -> tuple[float, ...]:
        """R_e and R_k."""
        return self.coefficients

    def law(self, stiffness: Floats) -> Floats:
        """The diagonal matrix."""
        del stiffness
        return np.diag(from_axial_first(np.array(self.coefficients)))

    def text(self) -> str:
        """C++ lines."""
        force, moment = (", ".join(map(number_text, self.coefficients[k : k + 3])) for k in (0, 3))
        return (
            "auto damping = chrono_types::make_shared<ChDampingCosseratLinear>();\n"
            f"damping->SetDampingCoefficientsRe(ChVector3d({force}));\n"
            f"damping->SetDampingCoefficientsRk(ChVector3d({moment}));"
        )


@dataclass(frozen=True)
class ChronoTapered(ProgramInputs):
    """bx, by, bz, bt of the tapered Timoshenko beams: square roots of times.

    Attributes:
        bx: axial, s^(1/2).
        by: shear along y and bending about z, s^(1/2).
        bz: shear along z and bending about y, s^(1/2).
        bt: torsion, s^(1/2).
    """

    bx: float
    by: float
    bz: float
    bt: float

    program: ClassVar[str] = "chrono-tapered"
    title: ClassVar[str] = "Chrono, tapered Timoshenko beam"
    meaning: ClassVar[str] = (
        "R = b^T K b with b = diag(bx, by, bz, bt, bz, by): the coefficients enter squared"
    )
    words: ClassVar[tuple[str, ...]] = ("bx", "by", "bz", "bt")
    sources: ClassVar[tuple[str, ...]] = (
        "projectchrono/chrono: src/chrono/fea/ChElementBeamTaperedTimoshenko.cpp, ComputeDampingMatrix",
        "projectchrono/chrono: src/chrono/fea/ChElementBeamTaperedTimoshenkoFPM.cpp, ComputeDampingMatrix",
        "projectchrono/chrono: src/chrono/fea/ChBeamSectionTaperedTimoshenko.h, DampingCoefficients (default 0.001)",
    )

    @classmethod
    def from_section(cls, data: SectionData, **options: float) -> Self:
        """Square roots of the times of stretch, bending about z (d2), bending about y (d1) and twist."""
        checked_options(cls, options)
        _, _, stretch, bend_1, bend_2, twist = np.sqrt(data.times).tolist()
        return cls(stretch, bend_2, bend_1, twist)

    @classmethod
    def from_numbers(cls, numbers: Sequence[float], data: SectionData, **options: float) -> Self:
        """Four numbers."""
        del data
        checked_options(cls, options)
        return cls(*listed(cls, numbers))

    @property
    def numbers(self) -> tuple[float, ...]:
        """The four coefficients."""
        return (self.bx, self.by, self.bz, self.bt)

    @property
    def times(self) -> Floats:
        """Six times in viscorod's order, s, (6,); Chrono's y is d1 and its z is d2."""
        return from_axial_first(
            np.array([self.bx, self.by, self.bz, self.bt, self.bz, self.by], dtype=np.float64) ** 2
        )

    def law(self, stiffness: Floats) -> Floats:
        """T C T: the symmetric law, couplings included (the FPM element)."""
        return symmetric_damping(stiffness, self.times)

    def text(self) -> str:
        """C++ lines."""
        lines = [
            f"coefficients.{word} = {number_text(value)};"
            for word, value in zip(self.words, self.numbers, strict=True)
        ]
        return "\n".join(
            ["DampingCoefficients coefficients;", *lines, "section->SetBeamRaleyghDamping(coefficients);"]
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Shear takes the time of the bending it shares its coefficient with."""
        return (
            *super().losses(data),
            "shear along y shares its coefficient with bending about z, shear along z with bending about y",
        )

    def warnings(self, data: SectionData) -> tuple[str, ...]:
        """The silent default, and the trap of the squares."""
        return (
            *super().warnings(data),
            "the coefficients are square roots of times: 0.01 means a time of 1e-4 s; left alone they "
            "are 0.001 (1e-6 s)",
        )
