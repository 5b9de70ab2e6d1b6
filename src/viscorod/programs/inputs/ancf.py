"""Beams in the absolute nodal coordinate formulation (ANCF) whose law is that of three-dimensional strains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.errors import Fault, InputError
from viscorod.model.materials.material import Material
from viscorod.programs.inputs.program_inputs import ProgramInputs, SectionData, number_text
from viscorod.programs.times import symmetric_damping
from viscorod.typing import Floats

__all__ = ["ANCF"]


@known_arguments
@dataclass(frozen=True)
class ANCF(ProgramInputs):
    """The dissipation factors of a solid of Kelvin-Voigt material, and its Lame constants.

    With stress and strain of three dimensions, S = (lambda tr E + lambda_v tr E_t) I + 2 (mu E + mu_v E_t), and
    gamma_v1 = tau_B, gamma_v2 = tau_S (LLT 2.6).

    Attributes:
        gamma_v1: dissipation factor of volume change, s.
        gamma_v2: dissipation factor of shear, s.
        youngs_modulus: of the material, Pa.
        poissons_ratio: of the material.
    """

    gamma_v1: float
    gamma_v2: float
    youngs_modulus: float
    poissons_ratio: float

    program = "ancf"
    title = "ANCF"
    meaning = "S = lambda tr(E) I + 2 mu E + lambda_v tr(E_t) I + 2 mu_v E_t at every point of the solid"
    words = ("gamma_v1", "gamma_v2")
    units = ("s", "s")
    sources = (
        "J. Linn, H. Lang, A. Tuganov, section 2.6, on the damping of A. M. Abdel-Nasser and A. A. Shabana; their "
        "paper itself was not read",
    )
    notes = (
        "check how your code forms lambda_v: here it is K gamma_v1 - 2/3 G gamma_v2; where it is gamma_v1 lambda, give "
        "lambda_v/lambda for gamma_v1",
        "elements whose section cannot bulge (position and section vectors only) bend with lambda + 2 mu instead of E: "
        "too stiff, and with another time",
    )

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        material = _compressible(cls, data)
        return [material.bulk_time, material.shear_time]

    @classmethod
    def _of(cls, numbers: Sequence[float], data: SectionData, _: Sequence[float], /) -> Self:
        material = _compressible(cls, data)
        bulk, shear = numbers
        return cls(bulk, shear, material.youngs_modulus, material.poissons_ratio)

    @property
    def lame(self) -> tuple[float, float]:
        """Lambda and mu, Pa."""
        nu = self.poissons_ratio
        mu = self.youngs_modulus / 2.0 / (1.0 + nu)
        return 2.0 * mu * nu / (1.0 - 2.0 * nu), mu

    @property
    def viscosities(self) -> tuple[float, float]:
        """lambda_v = K tau_B - 2/3 G tau_S, which may be negative, and mu_v = G tau_S, Pa s (LLT 2.6)."""
        first, mu = self.lame
        bulk = first + 2.0 / 3.0 * mu
        return bulk * self.gamma_v1 - 2.0 / 3.0 * mu * self.gamma_v2, mu * self.gamma_v2

    @property
    def times(self) -> Floats:
        """Six times, s, (6,), of a solid free to contract: gamma_v2 in shear and twist, else tau_E (LLT 4)."""
        nu, shear = self.poissons_ratio, self.gamma_v2
        extension = ((1.0 - 2.0 * nu) * self.gamma_v1 + 2.0 * (1.0 + nu) * shear) / 3.0
        return np.array([shear, shear, extension, extension, extension, shear])

    @property
    def time_of_rigid_section(self) -> float:
        """(lambda_v + 2 mu_v)/(lambda + 2 mu), s: bending of elements whose section cannot bulge."""
        (first, mu), (first_v, mu_v) = self.lame, self.viscosities
        return (first_v + 2.0 * mu_v) / (first + 2.0 * mu)

    def law(self, stiffness: Floats) -> Floats:
        """Return T C T on the section's own stiffness, for slow motion: the law of LLT (3)."""
        return symmetric_damping(stiffness, self.times)

    def text(self) -> str:
        """Return the four constants of the solid and the two factors."""
        (first, mu), (first_v, mu_v) = self.lame, self.viscosities
        return (
            f"gamma_v1 = {number_text(self.gamma_v1)}  # s\n"
            f"gamma_v2 = {number_text(self.gamma_v2)}  # s\n"
            f"lambda = {number_text(first)}  # Pa\n"
            f"mu = {number_text(mu)}  # Pa\n"
            f"lambda_v = {number_text(first_v)}  # Pa s\n"
            f"mu_v = {number_text(mu_v)}  # Pa s"
        )

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return that nothing of the law is lost, and what elements of the lowest order make of it."""
        (first, mu), extension = self.lame, float(self.times[2])
        lost = super().losses(data) or ("nothing of the law, if the section can contract and bulge",)
        if self.poissons_ratio == 0.0:
            return lost
        stiffer = (first + 2.0 * mu) / self.youngs_modulus
        slower = "" if extension == 0.0 else f" ({self.time_of_rigid_section / extension - 1.0:+.1%})"
        return (
            *lost,
            f"elements whose section cannot bulge bend {stiffer:.4g} times as stiffly (Poisson locking), with the time "
            f"{self.time_of_rigid_section:.6g} s{slower}",
        )


def _compressible(program: type[ProgramInputs], data: SectionData) -> Material:
    """Return the material of a section, which must have finite Lame constants."""
    material = data.material
    if material is None:
        raise InputError(
            Fault(
                program.program,
                "a section given by its stiffness",
                "the viscosities are those of a material, and this section has none",
                "give a section by its shape and a material",
            )
        )
    if material.poissons_ratio >= 0.5:
        raise InputError(
            Fault(
                program.program,
                f"nu = {material.poissons_ratio:g}",
                "lambda of an incompressible material is infinite",
                "give a Poisson's ratio below 0.5, such as 0.499",
            )
        )
    return material
