"""Chrono (Project Chrono): three damping models of its beam sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.programs.axial_first import VISCOSITIES, from_axial_first, to_axial_first
from viscorod.programs.inputs.program_inputs import ProgramInputs, SectionData, number_text
from viscorod.programs.times import symmetric_damping
from viscorod.typing import Floats

__all__ = ["ChronoLinear", "ChronoRayleigh", "ChronoTapered"]

_COSSERAT = "projectchrono/chrono: src/chrono/fea/ChBeamSectionCosserat.cpp"


@known_arguments
@dataclass(frozen=True)
class ChronoRayleigh(ProgramInputs):
    """beta of ChDampingCosseratRayleigh (IGA beams), or of the Rayleigh damping of a ChBeamSectionEuler.

    Attributes:
        beta: s.
    """

    beta: float

    program = "chrono-rayleigh"
    title = "Chrono, Rayleigh beta"
    meaning = "(n, m) = beta E6x6 (strain rates): one time for all six strains"
    words = ("beta",)
    units = ("s",)
    sources = (
        f"{_COSSERAT}, ChDampingCosseratRayleigh::ComputeStress",
        "projectchrono/chrono: src/chrono/fea/ChBeamSectionEuler.h (default beta 0.01)",
    )
    notes = (
        "a ChBeamSectionEuler on which nothing is set has beta = 0.01 s: set 0 if you want no damping",
        "versions whose vectors are ChVector<> instead of ChVector3d name the method SetBeamRaleyghDamping",
    )

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        """Return the time of bending, (tau_4 + tau_5)/2: what slender rods do most."""
        return [float(data.times[3:5].mean())]

    def law(self, stiffness: Floats) -> Floats:
        """Return beta C."""
        return np.asarray(self.beta * stiffness)

    def text(self) -> str:
        """Return C++ lines for both kinds of sections."""
        beta = number_text(self.beta)
        return (
            f"auto damping = chrono_types::make_shared<ChDampingCosseratRayleigh>(elasticity, {beta});\n"
            f"// or, for ChElementBeamEuler: section->SetRayleighDamping({beta});  // before: SetBeamRaleyghDamping"
        )


@known_arguments
@dataclass(frozen=True)
class ChronoLinear(ProgramInputs):
    """R_e and R_k of ChDampingCosseratLinear, in Chrono's order (axial, shear y, z | torsion, bend y, z).

    Attributes:
        coefficients: six numbers, N s and N m^2 s.
    """

    coefficients: tuple[float, ...]

    program = "chrono-linear"
    title = "Chrono, linear Cosserat damping"
    meaning = "n = R_e e_t, m = R_k k_t, component by component: a diagonal damping matrix"
    words = ("R_e.x", "R_e.y", "R_e.z", "R_k.x", "R_k.y", "R_k.z")
    units = VISCOSITIES
    sources = (f"{_COSSERAT}, ChDampingCosseratLinear::ComputeStress",)
    notes = ("older versions name the vector ChVector<> instead of ChVector3d",)

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        return [float(value) for value in to_axial_first(np.diag(data.damping))]

    @classmethod
    def _of(cls, numbers: Sequence[float], _data: SectionData, _: Sequence[float], /) -> Self:
        return cls(tuple(numbers))

    def law(self, stiffness: Floats) -> Floats:
        """Return the diagonal matrix."""
        del stiffness
        return np.diag(from_axial_first(np.array(self.coefficients)))

    def text(self) -> str:
        """Return C++ lines."""
        force, moment = (", ".join(map(number_text, self.coefficients[k : k + 3])) for k in (0, 3))
        return (
            "auto damping = chrono_types::make_shared<ChDampingCosseratLinear>();\n"
            f"damping->SetDampingCoefficientsRe(ChVector3d({force}));\n"
            f"damping->SetDampingCoefficientsRk(ChVector3d({moment}));"
        )


@known_arguments
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

    program = "chrono-tapered"
    title = "Chrono, tapered Timoshenko beam"
    meaning = "R = b^T K b with b = diag(bx, by, bz, bt, bz, by): the coefficients enter squared"
    words = ("bx", "by", "bz", "bt")
    units = ("s^(1/2)",) * 4
    sources = (
        "projectchrono/chrono: src/chrono/fea/ChElementBeamTaperedTimoshenko.cpp, ComputeDampingMatrix",
        "projectchrono/chrono: src/chrono/fea/ChElementBeamTaperedTimoshenkoFPM.cpp, ComputeDampingMatrix",
        "projectchrono/chrono: src/chrono/fea/ChBeamSectionTaperedTimoshenko.h, DampingCoefficients (default 0.001)",
    )
    always_lost = (
        "shear along y shares its coefficient with bending about z, shear along z with bending about y",
    )
    notes = (
        "the coefficients are square roots of times: 0.01 means a time of 1e-4 s; their default is 0.001 (1e-6 s)",
        "newer versions have two more numbers, which must keep their defaults: alpha = 0 (damping by the mass) and "
        "SetArtificialFactorForShearDamping(1)",
    )

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        """Return square roots of the times of stretch, bending about z (d2), bending about y (d1) and twist."""
        _, _, stretch, bend_1, bend_2, twist = np.sqrt(data.times).tolist()
        return stretch, bend_2, bend_1, twist

    @property
    def times(self) -> Floats:
        """Six times in viscorod's order, s, (6,); Chrono's y is d1 and its z is d2."""
        return from_axial_first(
            np.array([self.bx, self.by, self.bz, self.bt, self.bz, self.by], dtype=np.float64) ** 2
        )

    def law(self, stiffness: Floats) -> Floats:
        """Return T C T: the symmetric law, couplings included (the FPM element)."""
        return symmetric_damping(stiffness, self.times)

    def text(self) -> str:
        """Return C++ lines."""
        lines = [
            f"coefficients.{word} = {number_text(value)};"
            for word, value in zip(self.words, self.numbers, strict=True)
        ]
        return "\n".join(
            ["DampingCoefficients coefficients;", *lines, "section->SetBeamRaleyghDamping(coefficients);"]
        )
