"""Functions of time given by values or by a Python function, and the parser for all kinds."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.actions.time_function import Constant, Ramp, Sine, SpinUp, TimeFunction, Until
from viscorod.model.fields.definition import Definition, RefusedError, base_init, show
from viscorod.model.fields.forms import listed, of_kind, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import choose, function, number, numbers, one_of
from viscorod.typing import Floats

__all__ = ["TIME_FUNCTIONS", "FunctionOfTime", "TimeField", "TimeTable", "time_function"]


@accepts(listed(quantity(), 2), "list of 2 numbers or more")
def _several(value: Any) -> tuple[float, ...]:
    return numbers(value, at_least=2)


class TimeTable(TimeFunction):
    """Values at given times, with the first and last held constant outside.

    A time that is given twice is a jump: its first value is the one before, its second the one after.
    "linear" joins the values by straight lines, "cubic" by a cubic spline between the jumps (twice
    continuously differentiable; not-a-knot ends).
    """

    kind: Literal["table"] = Field(default="table", kw_only=True, repr=False)
    times: Annotated[Sequence[float], _several] = Key("at least two, not decreasing", "s")
    values: Annotated[Sequence[float], _several] = Key("as many", "*")
    interpolation: Annotated[Literal["linear", "cubic"], one_of("linear", "cubic")] = Key(
        '"linear" or "cubic"', default="linear"
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if len(self.times) != len(self.values):
            raise RefusedError(
                "there must be as many values as times",
                f"give {len(self.times)} values",
                found=f"{len(self.values)} values for {len(self.times)} times",
                at=("values",),
            )
        for index, (before, after) in enumerate(pairwise(self.times)):
            thrice = index > 0 and self.times[index - 1] == after
            if after < before or thrice:
                raise RefusedError(
                    "the same time three times or more" if thrice else "times must not decrease",
                    f"give a time after {show(before)}, or the same once more for a jump",
                    found=show(after),
                    at=("times", index + 1),
                )
        if not np.isfinite(self._coefficients).all():
            raise RefusedError(
                "values and times are too large or too close for a curve through them", "change the units"
            )
        return self

    @cached_property
    def _coefficients(self) -> Floats:
        """Coefficients of the powers 0 to 3 of (t - times[k]), (n - 1, 4); the rows of jumps are not used."""
        times, values = np.array(self.times), np.array(self.values)
        coefficients = np.zeros((len(times) - 1, 4))
        coefficients[:, 0] = values[:-1]
        steps = np.diff(times)
        with np.errstate(over="ignore", invalid="ignore"):
            if self.interpolation == "linear":
                np.divide(np.diff(values), steps, out=coefficients[:, 1], where=steps > 0.0)
                return coefficients
            from scipy.interpolate import CubicSpline

            edges = [0, *(np.flatnonzero(steps == 0.0) + 1), len(times)]
            for first, last in pairwise(edges):
                if last - first > 1:
                    spline = CubicSpline(times[first:last], values[first:last])
                    coefficients[first : last - 1] = spline.c[::-1].T
        return coefficients

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All times of a linear table; ends and jumps of a cubic one."""
        if self.interpolation == "linear":
            return tuple(dict.fromkeys(self.times))
        return tuple(dict.fromkeys((self.times[0], *self._doubled, self.times[-1])))

    @property
    def jumps(self) -> tuple[float, ...]:
        """The times that are given twice with different values."""
        return tuple(
            time
            for (time, after), (low, high) in zip(pairwise(self.times), pairwise(self.values), strict=True)
            if time == after and low != high
        )

    @property
    def _doubled(self) -> tuple[float, ...]:
        return tuple(time for time, after in pairwise(self.times) if time == after)

    def _derivative(self, t: float, before: bool, order: int) -> float:
        interval = (bisect_left if before else bisect_right)(self.times, t) - 1
        if interval < 0 or interval >= len(self.times) - 1:
            end = self.values[0] if interval < 0 else self.values[-1]
            return end if order == 0 else 0.0
        c0, c1, c2, c3 = self._coefficients[interval].tolist()
        x = t - self.times[interval]
        if order == 0:
            return float(c0 + x * (c1 + x * (c2 + x * c3)))
        return float(c1 + x * (2.0 * c2 + x * 3.0 * c3) if order == 1 else 2.0 * c2 + x * 6.0 * c3)

    def value(self, t: float, before: bool = False) -> float:
        """Return the interpolated value."""
        return self._derivative(t, before, 0)

    def rate(self, t: float, before: bool = False) -> float:
        """Return the first derivative, without the spikes of jumps."""
        return self._derivative(t, before, 1)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the second derivative, without the spikes of jumps and corners."""
        return self._derivative(t, before, 2)


@accepts(None)
def _times(value: Any) -> tuple[float, ...]:
    return tuple(sorted(set(numbers(value, at_least=0))))


OptionalFunction = Annotated[Callable[[float], float] | None, optional(function)]


class FunctionOfTime(TimeFunction):
    """A Python function of the time (not in case files).

    Args:
        function: t -> value.
        rate: t -> first derivative; needed for prescribed motions.
        acceleration: t -> second derivative; needed for prescribed motions.
        breakpoints: times at which one of the three is not smooth, s; the function gives there the value
            after.
    """

    kind: Literal["function"] = Field(default="function", kw_only=True, repr=False)
    value_function: Annotated[Callable[[float], float], function]
    rate_function: OptionalFunction = None
    acceleration_function: OptionalFunction = None
    break_times: Annotated[Sequence[float], _times] = ()

    @base_init
    def __init__(
        self,
        function: Callable[[float], float],
        rate: Callable[[float], float] | None = None,
        acceleration: Callable[[float], float] | None = None,
        breakpoints: Sequence[float] = (),
    ) -> None:
        given: dict[str, Any] = {
            "value_function": function,
            "rate_function": rate,
            "acceleration_function": acceleration,
            "break_times": breakpoints,
        }
        super().__init__(**given)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The given times."""
        return tuple(self.break_times)

    @property
    def jumps(self) -> tuple[float, ...]:
        """The given times at which the value before differs from the value after."""
        return tuple(
            t
            for t in self.break_times
            if not math.isclose(self.value(t), self.value(t, before=True), rel_tol=1e-9)
        )

    def value(self, t: float, before: bool = False) -> float:
        """Call the function."""
        return self._call(self.value_function, t, before)

    def rate(self, t: float, before: bool = False) -> float:
        """Call the function `rate`."""
        self.require_derivatives()
        return self._call(self.rate_function, t, before)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Call the function `acceleration`."""
        self.require_derivatives()
        return self._call(self.acceleration_function, t, before)

    def require_derivatives(self) -> None:
        """Refuse missing derivatives."""
        if self.rate_function is None or self.acceleration_function is None:
            raise RefusedError(
                "a prescribed motion needs its velocity and acceleration",
                "give FunctionOfTime(function, rate, acceleration) with both derivatives",
                found="a function of time without rate and acceleration",
            )

    def _call(self, function: Callable[[float], float] | None, t: float, before: bool) -> float:
        assert function is not None
        result = function(math.nextafter(t, -math.inf) if before and t in self.break_times else t)
        try:
            return number(result)
        except RefusedError as error:
            raise RefusedError(
                f"the function of time gave this at t = {t:.9g} s: {error.why}",
                "make it return a finite number at all times",
                found=show(result),
            ) from None


TIME_FUNCTIONS: dict[str, type[Definition]] = {
    "constant": Constant,
    "until": Until,
    "ramp": Ramp,
    "sine": Sine,
    "table": TimeTable,
    "spin_up": SpinUp,
}
"""The functions of time by their word in a case file; a new one is one class and one line here."""

_from_table = choose("kind", TIME_FUNCTIONS)


@accepts(quantity(of_kind("time")), "number, or table with `kind`, see Functions of time")
def time_function(value: Any) -> TimeFunction:
    """Return `value` as a function of time: one of the kinds, a plain number (constant) or a Python function."""
    if isinstance(value, TimeFunction):
        return value
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        return Constant(number(value))
    if isinstance(value, Mapping):
        parsed = _from_table(value)
        assert isinstance(parsed, TimeFunction)
        return parsed
    if callable(value) and not isinstance(value, Definition | type):
        return FunctionOfTime(value)
    raise RefusedError(
        "a function of time is needed here",
        f"give a number or a table with kind = one of {', '.join(TIME_FUNCTIONS)}",
    )


TimeField = Annotated[TimeFunction | None, optional(time_function)]
