"""Time-temperature shift: how many times longer a material's relaxation takes than at a reference temperature."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.limits import SMALLEST_NUMBER
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import Positive, bounded, numbers

__all__ = ["SHIFTS", "WLF", "Arrhenius", "OptionalTemperature", "ShiftTable", "TemperatureShift"]

ZERO = -273.15
"""Absolute zero, degrees C."""
GAS_CONSTANT = 8.314462618
"""J/(mol K) (CODATA 2018, exact to the digits given)."""
MOST_DECADES = 30.0
"""Decades of a shift beyond which nothing was measured."""

_celsius = bounded("> -273.15", exclusiveMinimum=ZERO)
Temperature = Annotated[float, _celsius]
OptionalTemperature = Annotated[float | None, optional(_celsius)]


@accepts(listed(quantity(bounds={"exclusiveMinimum": ZERO}), 2), "list of 2 numbers or more > -273.15")
def _temperatures(value: Any) -> tuple[float, ...]:
    items = numbers(value, at_least=2)
    for index, item in enumerate(items):
        if item <= ZERO:
            raise RefusedError(
                "below absolute zero", "give degrees C > -273.15", found=show(item), at=(index,)
            )
    if not (np.diff(items) > 0.0).all():
        raise RefusedError("temperatures of a table increase", "sort the table, each temperature once")
    return items


@accepts(listed(quantity(bounds=POSITIVE), 2), "list of numbers > 0")
def _factors(value: Any) -> tuple[float, ...]:
    items = numbers(value, at_least=2)
    for index, item in enumerate(items):
        if item < SMALLEST_NUMBER:
            raise RefusedError("outside what is allowed", "give numbers > 0", found=show(item), at=(index,))
    return items


class TemperatureShift(Definition):
    """Base class of the descriptions of a time-temperature shift."""

    @property
    @abstractmethod
    def origin(self) -> float:
        """The temperature at which the shift factor is 1 and the data of the damping hold, degrees C."""

    @abstractmethod
    def decades(self, temperature: float) -> float:
        """Return the decimal logarithm of the shift factor a_T at a temperature, degrees C.

        Raises:
            RefusedError: the shift does not reach this temperature.
        """

    def factor(self, temperature: float, data: float | None = None) -> float:
        """Return relaxation times at a temperature over those at another, degrees C; by default the reference.

        Raises:
            RefusedError: the shift does not reach there, or is absurdly large.
        """
        decades = self.decades(temperature) - (0.0 if data is None else self.decades(data))
        if not abs(decades) <= MOST_DECADES:
            raise RefusedError(
                f"it shifts relaxation times by {decades:.4g} decades",
                f"give a temperature within {MOST_DECADES:g} decades of the data",
                found=show(temperature),
            )
        return float(10.0**decades)


class WLF(TemperatureShift):
    """Shift of Williams, Landel and Ferry (1955): log10 a_T = -c1 (T - T_ref)/(c2 + T - T_ref).

    It describes polymers from their glass transition to about 100 K above it, with constants of the material and of
    the reference temperature. (17.44 and 51.6 K at the glass transition are means over many polymers.)
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["wlf"] = Field(default="wlf", kw_only=True, repr=False)
    c1: Positive = Key("the first constant")
    c2: Positive = Key("the second constant", "K")
    reference: Temperature = Key("temperature of the data of the damping, degrees C")

    @property
    def origin(self) -> float:
        """The reference temperature, degrees C."""
        return self.reference

    def decades(self, temperature: float) -> float:
        """Return the logarithm of the shift factor."""
        above = temperature - self.reference
        if not above > -self.c2:
            raise RefusedError(
                f"the formula of Williams, Landel and Ferry ends at {self.reference - self.c2:.6g} degrees C, "
                "the reference less c2",
                "give a higher temperature, or a table of shift factors",
                found=show(temperature),
            )
        return -self.c1 * above / (self.c2 + above)


class Arrhenius(TemperatureShift):
    """Shift of a thermally activated process: ln a_T = E_a/R (1/T - 1/T_ref), with absolute temperatures."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["arrhenius"] = Field(default="arrhenius", kw_only=True, repr=False)
    activation_energy: Positive = Key("E_a", "J/mol")
    reference: Temperature = Key("temperature of the data of the damping, degrees C")

    @property
    def origin(self) -> float:
        """The reference temperature, degrees C."""
        return self.reference

    def decades(self, temperature: float) -> float:
        """Return the logarithm of the shift factor."""
        inverse = 1.0 / (temperature - ZERO) - 1.0 / (self.reference - ZERO)
        return self.activation_energy / GAS_CONSTANT * inverse / math.log(10.0)


class ShiftTable(TemperatureShift):
    """Shift factors over temperature, straight lines of their logarithms between; 1 where the data hold."""

    tag: ClassVar[str | None] = "kind"

    kind: Literal["table"] = Field(default="table", kw_only=True, repr=False)
    temperatures: Annotated[Sequence[float], _temperatures] = Key("increasing, degrees C")
    factors: Annotated[Sequence[float], _factors] = Key("a_T: relaxation times over those of the data")

    @model_validator(mode="after")
    def _as_many(self) -> Self:
        if len(self.factors) != len(self.temperatures):
            raise RefusedError(
                "each temperature has one factor",
                f"give {len(self.temperatures)}",
                found=f"{len(self.factors)} numbers",
                at=("factors",),
            )
        decades = np.log10(self.factors)
        if not (np.diff(decades) < 0.0).all():
            raise RefusedError(
                "relaxation is faster the warmer it is",
                "give factors that fall with temperature",
                found=show(list(self.factors)),
                at=("factors",),
            )
        if not decades[-1] <= 0.0 <= decades[0]:
            raise RefusedError(
                "none of the temperatures is that of the data, where the factor is 1",
                "give factors that pass 1",
                found=f"from {self.factors[0]:.4g} to {self.factors[-1]:.4g}",
                at=("factors",),
            )
        return self

    @property
    def origin(self) -> float:
        """The temperature at which the factor is 1, degrees C."""
        return float(np.interp(0.0, -np.log10(self.factors), self.temperatures))

    def decades(self, temperature: float) -> float:
        """Return the logarithm of the shift factor."""
        low, high = self.temperatures[0], self.temperatures[-1]
        if not low <= temperature <= high:
            raise RefusedError(
                f"the table of shift factors goes from {low:.6g} to {high:.6g} degrees C",
                "give a temperature within it",
                found=show(temperature),
            )
        return float(np.interp(temperature, self.temperatures, np.log10(self.factors)))


SHIFTS: dict[str, type[TemperatureShift]] = {"wlf": WLF, "arrhenius": Arrhenius, "table": ShiftTable}
"""The shifts by their word in a case file."""
