"""Isotropic materials: elastic constants, density, and the damping that one of several kinds of data gives."""

from __future__ import annotations

import math
from typing import Annotated, Any, Self, cast

import numpy as np
from pydantic import PrivateAttr, model_validator

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import Definition, RefusedError, plain_value, show
from viscorod.model.fields.forms import of_kind
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    NOT_GIVEN,
    OptionalNumber,
    OptionalPositive,
    PoissonsRatio,
    Positive,
    choose,
)
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.damping_model import Behaviour, Branch, Damping, Elastic
from viscorod.model.materials.kelvin_voigt import KelvinVoigt
from viscorod.model.materials.loss_factor import LossFactor
from viscorod.model.materials.measured_damping import MeasuredDamping
from viscorod.model.materials.prony import Prony
from viscorod.model.materials.relaxation_modulus import RelaxationModulus
from viscorod.model.materials.temperature_shift import SHIFTS, OptionalTemperature, TemperatureShift

__all__ = ["DAMPINGS", "Branch", "KelvinVoigt", "Material"]

DAMPINGS: dict[str, type[Definition]] = {
    "kelvin_voigt": KelvinVoigt,
    "loss_factor": LossFactor,
    "complex_moduli": ComplexModuli,
    "prony": Prony,
    "modal": MeasuredDamping,
}
"""The kinds of damping by their word in a case file; a new one is one class and one line here."""

_one_shift = choose("kind", SHIFTS)
_one_damping = choose("kind", DAMPINGS, "kelvin_voigt")


@accepts(of_kind("damping"), "table, see below")
def _damping(value: Any) -> Damping | None:
    return None if value is None else cast(Damping, _one_damping(value))


@accepts(of_kind("shift"), "table, see below")
def _shift(value: Any) -> TemperatureShift | None:
    return None if value is None else cast(TemperatureShift, _one_shift(value))


_STAND_IN = 1000.0


class Material(Definition):
    """Isotropic, linearly viscoelastic material.

    Young's modulus E is given, and one of Poisson's ratio nu and shear modulus G = E/2(1+nu); both can be
    read afterwards. Read back, they are the moduli in equilibrium, also if instantaneous ones were given (`Prony`).
    """

    youngs_modulus: Positive = Key(
        "E > 0, {}; may be left out where complex moduli give it", "Pa", default=NOT_GIVEN
    )
    poissons_ratio: PoissonsRatio = Key("nu in (-1, 0.5]; 0.5 is incompressible", default=NOT_GIVEN)
    density: Positive = Key(
        "mass per volume > 0, {}; may be left out where nothing moves", "kg/m^3", default=NOT_GIVEN
    )
    shear_modulus: Positive = Key("G > 0, {}, instead of Poisson's ratio", "Pa", default=NOT_GIVEN)
    damping: Annotated[Damping | None, _damping] = Key(
        "`KelvinVoigt`, `LossFactor`, `ComplexModuli`, `Prony` or `MeasuredDamping`; left out, an elastic material",
        default=None,
    )
    temperature: OptionalTemperature = Key("of the motion, degrees C, with shift", default=None)
    shift: Annotated[TemperatureShift | None, _shift] = Key(
        "how relaxation times depend on temperature, `WLF`, `Arrhenius` or `ShiftTable`", default=None
    )
    specific_heat: OptionalPositive = Key(
        "heat capacity per mass, {}, to tell how much a motion warms the rod", "J/(kg K)", default=None
    )
    thermal_expansion: OptionalNumber = Key(
        "strain per temperature, for rest strains by temperature", "1/K", default=None
    )

    _behaviour: Behaviour = PrivateAttr()
    _given: dict[str, float] = PrivateAttr(default_factory=dict)
    _elastic: Elastic = PrivateAttr()

    @model_validator(mode="after")
    def _complete(self) -> Self:
        young, nu, shear = self.youngs_modulus, self.poissons_ratio, self.shear_modulus
        self._require_temperature()
        if math.isnan(young) and not isinstance(self.damping, ComplexModuli):
            raise RefusedError(
                "this key is required and missing",
                "add youngs_modulus (Young's modulus, Pa)",
                found="",
                at=("youngs_modulus",),
            )
        if math.isnan(young) and not math.isnan(shear):
            raise RefusedError(
                "a shear modulus goes with Young's modulus only",
                "give poissons_ratio in its place, or youngs_modulus with it",
                found=show(shear),
                at=("shear_modulus",),
            )
        if not math.isnan(young) and math.isnan(nu) == math.isnan(shear):
            given = "neither" if math.isnan(nu) else f"both, {show(nu)} and {show(shear)}"
            raise RefusedError(
                "with Young's modulus exactly one of Poisson's ratio and shear modulus is needed",
                "give poissons_ratio, or shear_modulus (Pa)",
                found=f"given: {given}",
            )
        self._given = {
            name: value
            for name, value in (("youngs_modulus", young), ("poissons_ratio", nu), ("shear_modulus", shear))
            if not math.isnan(value)
        }
        if not math.isnan(shear):
            nu = self._ratio(young, shear)
        self._elastic = Elastic(young, nu)
        self._behaviour = self._resolved(self._elastic)
        found = self._behaviour
        self.__dict__["youngs_modulus"] = found.youngs_modulus
        self.__dict__["poissons_ratio"] = found.poissons_ratio
        if math.isnan(shear) or found.youngs_modulus != young:
            self.__dict__["shear_modulus"] = found.youngs_modulus / (2.0 * (1.0 + found.poissons_ratio))
        return self

    def _require_temperature(self) -> None:
        """Refuse a shift without a temperature, and what no shift applies to."""
        if (self.shift is None) != (self.temperature is None):
            missing = "temperature" if self.shift is not None else "shift"
            raise RefusedError(
                "a temperature and a shift of relaxation times go together",
                "give temperature (degrees C) and shift, or neither",
                found="",
                at=(missing,),
            )
        if self.shift is not None and (self.damping is None or isinstance(self.damping, MeasuredDamping)):
            why = (
                "nothing relaxes in an elastic material"
                if self.damping is None
                else "a damping ratio measured on the rod is that at the temperature of the measurement"
            )
            raise RefusedError(why, "leave out shift and temperature", found="", at=("shift",))

    @property
    def has_density(self) -> bool:
        """Whether its density is known, without which nothing moves."""
        return not math.isnan(self.density)

    @property
    def inertial_density(self) -> float:
        """The density, kg/m^3; where it is not known one for statics, which do not depend on it."""
        return self.density if self.has_density else _STAND_IN

    @property
    def shift_factor(self) -> float:
        """Relaxation times over those of the data of the damping, a_T; 1 without a shift.

        The data are those of the reference temperature of the shift, a table of complex moduli with a temperature
        those of that temperature.
        """
        if self.shift is None or self.temperature is None:
            return 1.0
        return self.shift.factor(self.temperature, self._data_temperature)

    @property
    def _data_temperature(self) -> float | None:
        return self.damping.temperature if isinstance(self.damping, ComplexModuli) else None

    @staticmethod
    def _ratio(young: float, shear: float) -> float:
        """Return Poisson's ratio from the two moduli."""
        nu = young / (2.0 * shear) - 1.0
        if not -1.0 < nu <= 0.5 + 1e-12:
            raise RefusedError(
                f"with E = {young:.6g} Pa it means a Poisson's ratio of {nu:.6g}, outside (-1, 0.5]",
                f"give a shear modulus of at least a third of Young's modulus, {young / 3.0:.6g} Pa",
                found=show(shear),
                at=("shear_modulus",),
            )
        return min(nu, 0.5)

    def _resolved(self, elastic: Elastic) -> Behaviour:
        """Derive the behaviour from the damping and the elastic constants."""
        if self.damping is None:
            return Behaviour(*elastic)
        try:
            shift = self.shift_factor
        except RefusedError as error:
            raise RefusedError(error.why, error.instead, found=error.found, at=("temperature",)) from None
        try:
            with np.errstate(all="ignore"):
                found = (
                    self.damping.behaviour_at(elastic, shift)
                    if self.shift
                    else self.damping.behaviour(elastic)
                )
        except RefusedError as error:
            raise RefusedError(
                error.why, error.instead, found=error.found, at=("damping", *error.at)
            ) from None
        except InputError as error:
            raise RefusedError(str(error), "change the values", found="", at=("damping",)) from None
        except ArithmeticError:
            found = Behaviour(*elastic, math.nan)
        numbers = [found.youngs_modulus, found.poissons_ratio, found.shear_time, found.bulk_time]
        numbers += [value for branch in found.branches for value in branch]
        if not found.pending and not all(map(math.isfinite, numbers)):
            raise RefusedError(
                "its times and moduli leave double precision",
                "give values in SI units",
                found="",
                at=("damping",),
            )
        return found.assuming(*self._told_of_temperature(shift))

    def _told_of_temperature(self, shift: float) -> list[str]:
        if self.shift is None:
            return []
        data = self.shift.origin if self._data_temperature is None else self._data_temperature
        words = f"at {self.temperature:.6g} degrees C all relaxation and retardation times are {shift:.4g} times those"
        return [
            f"{words} of the data at {data:.6g} degrees C; the elastic constants are taken as those at "
            f"{self.temperature:.6g} degrees C"
        ]

    def to_dict(self) -> dict[str, Any]:
        """Return the material as it was given, in the words of the case file."""
        given = {name: plain_value(value) for name, value in self._given.items()}
        return {name: given.get(name, value) for name, value in super().to_dict().items()}

    @property
    def pending(self) -> bool:
        """Whether the damping follows from a mode (`MeasuredDamping`) and is known only once a model has been built."""
        return self._behaviour.pending

    @property
    def _known(self) -> Behaviour:
        if self._behaviour.pending:
            raise InputError(
                Fault(
                    "damping",
                    show(self.damping),
                    "its times follow from a mode of a model, and this material stands alone",
                    "ask the materials of Model.with_known_times()",
                )
            )
        return self._behaviour

    def with_damping(self, damping: Damping | None, *assumptions: str) -> Material:
        """Return the same material with another damping, and sentences about how it was found.

        Raises:
            InputError: the damping does not go with the elastic constants.
        """
        more = {
            name: getattr(self, name)
            for name in ("temperature", "shift", "specific_heat", "thermal_expansion")
        }
        kept = {
            name: value
            for name, value in more.items()
            if value is not None and (damping is not None or name not in ("temperature", "shift"))
        }
        kept |= {"density": self.density} if self.has_density else {}
        other = Material.model_validate({**self._given, "damping": damping, **kept})
        other._behaviour = other._behaviour.assuming(*assumptions)
        return other

    @property
    def bulk_modulus(self) -> float:
        """K = E/3(1-2nu), Pa; infinite for nu = 0.5."""
        compressibility = 1.0 - 2.0 * self.poissons_ratio
        return self.youngs_modulus / (3.0 * compressibility) if compressibility > 0.0 else math.inf

    @property
    def branches(self) -> tuple[Branch, ...]:
        """Maxwell branches, by time; none in a Kelvin-Voigt material."""
        return self._behaviour.branches

    @property
    def given_moduli(self) -> Elastic:
        """The elastic constants as they were given, with a loss factor over a band the storage moduli; NaN if not."""
        return self._elastic

    @property
    def assumptions(self) -> tuple[str, ...]:
        """The assumptions about the damping, one sentence each."""
        return self._behaviour.assumptions

    @property
    def doubts(self) -> tuple[str, ...]:
        """How the damping differs from the data that it stands for, if by much: every result tells it."""
        return self._behaviour.doubts

    @property
    def loss_band(self) -> tuple[float, float] | None:
        """The band over which a loss factor holds (`LossFactor`), Hz; None of any other damping."""
        if not isinstance(self.damping, LossFactor) or self.damping.holds is None:
            return None
        low, high = self.damping.holds
        return low / self.shift_factor, high / self.shift_factor

    def relaxation(self, strain: str) -> RelaxationModulus | None:
        """Return the relaxation modulus of "extension" or "shear"; None where only times are known."""
        return self._behaviour.extension if strain == "extension" else self._behaviour.shear

    @property
    def shear_time(self) -> float:
        """Retardation time in shear, tau_S = eta/G, s; of a Maxwell material that of slow motion."""
        return self._known.shear_time

    @property
    def bulk_time(self) -> float:
        """Retardation time in volume change, tau_B = zeta/K, s; of a Maxwell material that of slow motion."""
        return self._known.bulk_time

    @property
    def expansion(self) -> float:
        """Thermal expansion, 1/K.

        Raises:
            RefusedError: it was not given.
        """
        if self.thermal_expansion is None:
            raise RefusedError(
                "a temperature strains it by the thermal expansion of its material",
                "give the material thermal_expansion (1/K)",
                found="",
                at=("temperature",),
            )
        return self.thermal_expansion

    @property
    def shear_viscosity(self) -> float:
        """Viscosity in shear eta = G tau_S, Pa s."""
        return self.shear_modulus * self.shear_time

    @property
    def bulk_viscosity(self) -> float:
        """Viscosity in volume change zeta = K tau_B, Pa s; infinite for nu = 0.5 and a positive bulk time."""
        if self._behaviour.bulk_viscosity is not None:
            return self._behaviour.bulk_viscosity
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
