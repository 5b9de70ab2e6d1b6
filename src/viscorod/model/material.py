"""Isotropic Kelvin-Voigt materials (Linn, Lang and Tuganov 2013, called LLT, equations 3-4)."""

from __future__ import annotations

import math
from typing import Annotated, Any, NamedTuple, Self

from pydantic import Field, PlainValidator, model_validator

from viscorod.model.described import Described, RefusedError, show
from viscorod.model.values import NOT_GIVEN, OptionalNonNegative, PoissonsRatio, Positive

__all__ = ["Branch", "KelvinVoigt", "Material"]


class Branch(NamedTuple):
    """A Maxwell branch of an isotropic material: spring and dashpot in series, beside the equilibrium moduli.

    Attributes:
        time: relaxation time, s.
        youngs_modulus: what it adds to Young's modulus in fast extension, Pa.
        shear_modulus: what it adds to the shear modulus in fast shear, Pa.
    """

    time: float
    youngs_modulus: float
    shear_modulus: float


class KelvinVoigt(Described):
    """Viscosity of a material in shear and in volume change: one pair of times or one pair of viscosities.

    Args:
        shear_time: retardation time in shear, viscosity over shear modulus, s.
        bulk_time: retardation time in volume change, viscosity over bulk modulus, s.
        shear_viscosity: Pa s.
        bulk_viscosity: Pa s.
    """

    shear_time: OptionalNonNegative = None
    bulk_time: OptionalNonNegative = None
    shear_viscosity: OptionalNonNegative = None
    bulk_viscosity: OptionalNonNegative = None

    @model_validator(mode="after")
    def _one_pair(self) -> Self:
        times = (self.shear_time, self.bulk_time)
        viscosities = (self.shear_viscosity, self.bulk_viscosity)
        given = [name for name in type(self).model_fields if getattr(self, name) is not None]
        complete = [pair for pair in (times, viscosities) if None not in pair]
        if len(given) != 2 or len(complete) != 1:
            raise RefusedError(
                "the viscosity needs one complete pair",
                "give shear_time and bulk_time (s), or shear_viscosity and bulk_viscosity (Pa s)",
                found=f"given: {', '.join(given) or 'nothing'}",
            )
        return self


def _damping(value: Any) -> KelvinVoigt | None:
    return value if value is None or isinstance(value, KelvinVoigt) else KelvinVoigt.model_validate(value)


class Material(Described):
    """Isotropic, linearly elastic material with Kelvin-Voigt viscosity.

    Young's modulus E is given, and one of Poisson's ratio nu and shear modulus G = E/2(1+nu); both can be
    read afterwards.

    Args:
        youngs_modulus: E > 0, Pa.
        poissons_ratio: nu in (-1, 0.5]; 0.5 is incompressible.
        density: mass per volume > 0, kg/m^3.
        shear_modulus: G > 0, Pa, instead of Poisson's ratio.
        damping: the viscosity; None for a purely elastic material.
    """

    youngs_modulus: Positive = Field(description="Young's modulus, Pa")
    poissons_ratio: PoissonsRatio = NOT_GIVEN
    density: Positive = NOT_GIVEN
    shear_modulus: Positive = NOT_GIVEN
    damping: Annotated[KelvinVoigt | None, PlainValidator(_damping)] = None

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if math.isnan(self.density):
            raise RefusedError(
                "this key is required and missing", "add density (kg/m^3)", found="", at=("density",)
            )
        young, nu, shear = self.youngs_modulus, self.poissons_ratio, self.shear_modulus
        if math.isnan(nu) == math.isnan(shear):
            given = "neither" if math.isnan(nu) else f"both, {show(nu)} and {show(shear)}"
            raise RefusedError(
                "with Young's modulus exactly one of Poisson's ratio and shear modulus is needed",
                "give poissons_ratio, or shear_modulus (Pa)",
                found=f"given: {given}",
            )
        if math.isnan(shear):
            self.__dict__["shear_modulus"] = young / (2.0 * (1.0 + nu))
            return self
        nu = young / (2.0 * shear) - 1.0
        if not -1.0 < nu <= 0.5 + 1e-12:
            raise RefusedError(
                f"with E = {young:.6g} Pa it means a Poisson's ratio of {nu:.6g}, outside (-1, 0.5]",
                f"give a shear modulus of at least a third of Young's modulus, {young / 3.0:.6g} Pa",
                found=show(shear),
                at=("shear_modulus",),
            )
        self.__dict__["poissons_ratio"] = min(nu, 0.5)
        return self

    @property
    def bulk_modulus(self) -> float:
        """K = E/3(1-2nu), Pa; infinite for nu = 0.5."""
        compressibility = 1.0 - 2.0 * self.poissons_ratio
        return self.youngs_modulus / (3.0 * compressibility) if compressibility > 0.0 else math.inf

    @property
    def branches(self) -> tuple[Branch, ...]:
        """Maxwell branches, by time; none in a Kelvin-Voigt material."""
        return ()

    @property
    def shear_time(self) -> float:
        """Retardation time in shear, tau_S = eta/G, s."""
        if self.damping is None:
            return 0.0
        if self.damping.shear_time is not None:
            return self.damping.shear_time
        return (self.damping.shear_viscosity or 0.0) / self.shear_modulus

    @property
    def bulk_time(self) -> float:
        """Retardation time in volume change, tau_B = zeta/K, s."""
        if self.damping is None:
            return 0.0
        if self.damping.bulk_time is not None:
            return self.damping.bulk_time
        return (self.damping.bulk_viscosity or 0.0) / self.bulk_modulus

    @property
    def shear_viscosity(self) -> float:
        """Viscosity in shear eta = G tau_S, Pa s."""
        return self.shear_modulus * self.shear_time

    @property
    def bulk_viscosity(self) -> float:
        """Viscosity in volume change zeta = K tau_B, Pa s; infinite for nu = 0.5 and a positive bulk time."""
        if self.damping is not None and self.damping.bulk_viscosity is not None:
            return self.damping.bulk_viscosity
        return self.bulk_modulus * self.bulk_time if self.bulk_time > 0.0 else 0.0

    @property
    def extensional_time(self) -> float:
        """Retardation time in uniaxial extension, s (LLT 4): tau_E = [(1-2nu) tau_B + 2(1+nu) tau_S]/3."""
        nu = self.poissons_ratio
        return ((1.0 - 2.0 * nu) * self.bulk_time + 2.0 * (1.0 + nu) * self.shear_time) / 3.0

    @property
    def extensional_viscosity(self) -> float:
        """Viscosity in extension eta_E = E tau_E = zeta (1-2nu)^2 + 4/3 eta (1+nu)^2, Pa s (LLT 3)."""
        return self.youngs_modulus * self.extensional_time
