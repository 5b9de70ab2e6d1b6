"""Cross sections of one isotropic material: their base class, and the section given by its numbers.

The section lies in the plane of d1 and d2, its principal axes; widths are along d1, heights along d2.
``I1 = <xi2^2>`` resists bend_1 (about d1), ``I2 = <xi1^2>`` resists bend_2 (about d2).
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Literal

import numpy as np
from pydantic import Field

from viscorod.errors import Fault, InputError
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Positive
from viscorod.model.materials.material import Material
from viscorod.model.sections.section_base import AnySection, Branches, Matrices
from viscorod.typing import Floats

__all__ = ["MaterialSection", "SectionProperties"]


class MaterialSection(AnySection):
    """A section that gets stiffness, damping and inertia from a `Material`."""

    @abstractmethod
    def moments(self) -> tuple[float, float, float]:
        """Return the area A (m^2) and second moments I1 = <xi2^2>, I2 = <xi1^2> (m^4)."""

    @abstractmethod
    def torsion(self) -> float:
        """Return Saint-Venant's torsion constant J, m^4."""

    @abstractmethod
    def shear_factors(self, poissons_ratio: float) -> tuple[float, float]:
        """Return the factors k1, k2 of the shear stiffnesses k1 G A and k2 G A."""

    def geometry(self, poissons_ratio: float) -> Matrices:
        """Return C_E (m^2, m^4), C_G (likewise) and inertia per density, which follow from the shape, (6, 6) each.

        C_E = diag(0, 0, A, I1, I2, 0), C_G = diag(k1 A, k2 A, 0, 0, 0, J) and diag(A, A, A, I1, I2, I1 + I2)
        (Linn, Lang and Tuganov 2013, equations 3-5), about the centre of the section and its principal axes.
        """
        area, inertia_1, inertia_2 = self.moments()
        k1, k2 = self.shear_factors(poissons_ratio)
        extensional = np.diag([0.0, 0.0, area, inertia_1, inertia_2, 0.0])
        shearing = np.diag([k1 * area, k2 * area, 0.0, 0.0, 0.0, self.torsion()])
        inertia = np.diag([area, area, area, inertia_1, inertia_2, inertia_1 + inertia_2])
        return extensional, shearing, inertia

    def _shape(self, poissons_ratio: float) -> Matrices:
        """Return the :meth:`geometry`, kept for one Poisson's ratio: members of a sweep share their sections."""
        known: tuple[float, Matrices] | None = vars(self).get("_known_geometry")
        if known is None or known[0] != poissons_ratio:
            known = poissons_ratio, self.geometry(poissons_ratio)
            for matrix in known[1]:
                matrix.flags.writeable = False
            vars(self)["_known_geometry"] = known
        return known[1]

    def by_material(self, material: Material | None) -> list[tuple[Material, Floats, Floats]]:
        """See `AnySection.by_material`: one."""
        material = required(material)
        extensional, shearing, _ = self.geometry(material.poissons_ratio)
        return [(material, extensional, shearing)]

    def matrices(self, material: Material | None = None) -> Matrices:
        """Return stiffness C, damping D and inertia M per length, (6, 6) each.

        C = E C_E + G C_G, D = eta_E C_E + eta C_G and M = density times the inertia of the :meth:`geometry`.
        The order is (shear_1, shear_2, stretch, bend_1, bend_2, twist) in C (N, N m^2) and D (N s, N m^2 s),
        and (v1, v2, v3, w1, w2, w3) in M (kg/m, kg m). A material with Maxwell branches has D = 0 here; its
        viscosity is in the :meth:`branch_matrices`.

        Raises:
            InputError: there is no material.
        """
        material = required(material)
        extensional, shearing, inertia = self._shape(material.poissons_ratio)
        stiffness = material.youngs_modulus * extensional + material.shear_modulus * shearing
        damping = np.zeros((6, 6))
        if not material.branches:
            damping = material.extensional_viscosity * extensional + material.shear_viscosity * shearing
        return stiffness, damping, material.inertial_density * inertia

    def branch_matrices(self, material: Material | None = None) -> Branches:
        """Return Maxwell branches: relaxation times (n,), s, and their stiffnesses E_j C_E + G_j C_G (n, 6, 6).

        Raises:
            InputError: there is no material.
        """
        material = required(material)
        extensional, shearing, _ = self._shape(material.poissons_ratio)
        branches = material.branches
        times = np.array([branch.time for branch in branches])
        stiffness = [b.youngs_modulus * extensional + b.shear_modulus * shearing for b in branches]
        return times, np.array(stiffness).reshape(-1, 6, 6)


def required(material: Material | None) -> Material:
    """Return `material`, or raise an `InputError` where there is none."""
    if material is None:
        raise InputError(
            Fault("material", "", "this section needs one for its stiffness and mass", "add material")
        )
    return material


class SectionProperties(MaterialSection):
    """A section given by its numbers."""

    shape: Literal["given"] = Field(default="given", kw_only=True, repr=False)
    area: Positive = Key("", "m^2")
    second_moment_1: Positive = Key("I1 = <xi2^2>, {}, resists bend_1 (about d1)", "m^4")
    second_moment_2: Positive = Key("I2 = <xi1^2>, {}, resists bend_2 (about d2)", "m^4")
    torsion_constant: Positive = Key("resistance to twisting over the shear modulus", "m^4")
    shear_factor_1: Positive = Key("k1 of the shear stiffness k1 G A along d1", default=1.0)
    shear_factor_2: Positive = Key("k2 of the shear stiffness k2 G A along d2", default=1.0)

    def moments(self) -> tuple[float, float, float]:
        """Return the given area and second moments, m^2 and m^4."""
        return self.area, self.second_moment_1, self.second_moment_2

    def torsion(self) -> float:
        """Return the given torsion constant, m^4."""
        return self.torsion_constant

    def shear_factors(self, poissons_ratio: float) -> tuple[float, float]:
        """Return the given shear factors, whatever Poisson's ratio is."""
        del poissons_ratio
        return self.shear_factor_1, self.shear_factor_2
