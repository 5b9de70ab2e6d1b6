"""SoRoSim and SoRoMoX: one viscosity, with the constants of an incompressible material."""

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

__all__ = ["SoRoMoX", "SoRoSim"]


@known_arguments
@dataclass(frozen=True)
class SoRoSim(ProgramInputs):
    """The material damping Eta of a soft link.

    Attributes:
        eta: Pa s.
        youngs_modulus: of the link's material, Pa.
        shear_modulus: of the link's material, Pa.
    """

    eta: float
    youngs_modulus: float
    shear_modulus: float

    program = "sorosim"
    title = "SoRoSim"
    meaning = "damping matrix Eta diag(Ix, 3 Iy, 3 Iz, 3 A, A, A): extension has 3 Eta, as for nu = 1/2"
    words = ("Eta",)
    units = ("Pa s",)
    sources = (
        "Ikhlas-Ben-Hmida/SoRoSim: SoRoSim Live/SorosimTwist files/MEG.m (Ix = Iy + Iz)",
        "SoRoSim/SoRoSim: Differentiable_SoRoSim/SorosimLink_files/SorosimLink.m (Eta, Pa s)",
    )

    @classmethod
    def _numbers(cls, data: SectionData, _: Sequence[float], /) -> Sequence[float]:
        """Return Eta = eta_E/3, which keeps bending and stretching as they are, since slender rods bend."""
        return [_material(cls, data).extensional_viscosity / 3.0]

    @classmethod
    def _of(cls, numbers: Sequence[float], data: SectionData, _: Sequence[float], /) -> Self:
        material = _material(cls, data)
        (eta,) = numbers
        return cls(eta, material.youngs_modulus, material.shear_modulus)

    @property
    def times(self) -> Floats:
        """Six times, s, (6,): Eta/G for shear and twist, 3 Eta/E for stretch and bending."""
        shear, extension = self.eta / self.shear_modulus, 3.0 * self.eta / self.youngs_modulus
        return np.array([shear, shear, extension, extension, extension, shear])

    def law(self, stiffness: Floats) -> Floats:
        """Return T C T on the section's own stiffness; the program has its own shear factors and torsion constant."""
        return symmetric_damping(stiffness, self.times)

    def text(self) -> str:
        """Return a MATLAB line."""
        return f"Link.Eta = {number_text(self.eta)};  % Pa s"

    def losses(self, data: SectionData) -> tuple[str, ...]:
        """Return the error of the constants of nu = 1/2, for the choice made and for the other one."""
        material = _material(type(self), data)
        shear, extension = material.shear_viscosity, material.extensional_viscosity
        out = super().losses(data)
        if data.section is not None:
            _, first, second = data.section.moments()
            ratio = (first + second) / data.section.torsion()
            if abs(ratio - 1.0) > 1e-9:
                out = (
                    *out,
                    f"its torsion stiffness is G (I1 + I2), {ratio:.4g} times G J of this section, and its shear "
                    "factors are 1",
                )
        if abs(extension - 3.0 * shear) <= 1e-9 * extension:
            return out or (f"nothing: eta_E = 3 eta for this material (nu = {material.poissons_ratio:g})",)
        if shear == 0.0:
            return (*out, "the material has no shear viscosity, but the program gives shear and twist one")
        (word,) = self.words
        return (
            *out,
            f"eta_E = 3 eta holds for nu = 1/2; here nu = {material.poissons_ratio:g} and eta_E/eta = "
            f"{extension / shear:.4g}. {word} = eta_E/3 = {number_text(extension / 3.0)} Pa s keeps bending and "
            f"stretching; {word} = eta = {number_text(shear)} Pa s would keep shear and twist, and make the times of "
            f"bending and stretching wrong by {3.0 * shear / extension - 1.0:+.1%}",
        )


@known_arguments
@dataclass(frozen=True)
class SoRoMoX(SoRoSim):
    """The material damping coefficient of a SoRoMoX link; the law is SoRoSim's."""

    program = "soromox"
    title = "SoRoMoX"
    meaning = "damping matrix eta diag(Ix, 3 Iy, 3 Iz, 3 A, A, A): extension has 3 eta, as for nu = 1/2"
    words = ("material_damping_coefficient",)
    sources = (
        "tud-phi/soromox: src/soromox/systems/pcs/pcs.py and gvs/construction.py, damping_operator (package 0.5.0)",
        "tud-phi/soromox: src/soromox/systems/components/cross_sections.py (Ix = Iy + Iz)",
    )

    def text(self) -> str:
        """Return a Python keyword."""
        return f"material_damping_coefficient={number_text(self.eta)}  # Pa s"


def _material(program: type[ProgramInputs], data: SectionData) -> Material:
    if data.material is None:
        raise InputError(
            Fault(
                program.program,
                "a section given by its stiffness",
                "the viscosity is that of a material, and this section has none",
                "give a section by its shape and a material",
            )
        )
    return data.material
