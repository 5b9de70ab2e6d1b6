"""Functions of time given by values at times, from lists or from a file."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.errors import warn
from viscorod.model.actions.record_file import TIME_UNITS, VALUE_UNITS, read_record
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import TEXT, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import OptionalText, numbers, one_of, word
from viscorod.typing import Floats

__all__ = ["TimeTable"]

OVERSHOOT = 0.1
"""How far a spline may leave the range of the two values that it joins, as a part of the range of all values."""


@accepts(listed(quantity(), 2), "list of 2 numbers or more")
def _several(value: Any) -> tuple[float, ...]:
    return numbers(value, at_least=2)


@accepts({"anyOf": [{"type": "integer", "minimum": 1}, TEXT]}, "number from 1, or name in quotes")
def _column(value: Any) -> str | int:
    return value if isinstance(value, int) and not isinstance(value, bool) else word(value)


class TimeTable(TimeFunction):
    """Values at given times, with the first and last held constant outside; from two lists or from a file.

    A time that is given twice is a jump: its first value is the one before, its second the one after.
    "linear" joins the values by straight lines, "cubic" by a cubic spline between the jumps (twice
    continuously differentiable; not-a-knot ends), "monotone" by cubics that never leave the range of the two
    values that they join (Fritsch and Butland 1984; once differentiable). A spline that leaves that range by
    more than a tenth of the range of all values is not taken: the table is monotone then, and a warning says so.
    """

    kind: Literal["table"] = Field(default="table", kw_only=True, repr=False)
    times: Annotated[Sequence[float] | None, optional(_several)] = Key(
        "at least two, not decreasing", "s", default=None
    )
    values: Annotated[Sequence[float] | None, optional(_several)] = Key("as many", "*", default=None)
    interpolation: Annotated[
        Literal["linear", "cubic", "monotone"], one_of("linear", "cubic", "monotone")
    ] = Key('"linear", "cubic" or "monotone"', default="linear")
    file: OptionalText = Key(
        "in place of the lists, a text file with columns, such as record.csv; its path from the case file on",
        default=None,
        kw_only=True,
    )
    time_column: Annotated[str | int, _column] = Key(
        "of the file: its name or number", default=1, kw_only=True
    )
    value_column: Annotated[str | int, _column] = Key(
        "of the file: its name or number", default=2, kw_only=True
    )
    time_unit: Annotated[str | None, optional(one_of(*TIME_UNITS))] = Key(
        'such as "ms", where the head of the file does not say; s unless given', default=None, kw_only=True
    )
    value_unit: Annotated[str | None, optional(one_of(*VALUE_UNITS))] = Key(
        'such as "mm", "kN" or "g", where the head of the file does not say; SI unless given',
        default=None,
        kw_only=True,
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.file is None:
            for name in ("times", "values"):
                if getattr(self, name) is None:
                    raise RefusedError(
                        "a table comes from lists or from a file",
                        f"give {name}, or file",
                        found="missing",
                        at=(name,),
                    )
            for name in ("time_unit", "value_unit"):
                if getattr(self, name) is not None:
                    raise RefusedError(
                        "lists are in SI units", "leave it out", found=show(getattr(self, name)), at=(name,)
                    )
        elif self.times is not None or self.values is not None:
            raise RefusedError(
                "a table comes from lists or from a file",
                "leave out times and values",
                found="both",
                at=("file",),
            )
        times, values = self._points
        if len(times) != len(values):
            raise RefusedError(
                "there must be as many values as times",
                f"give {len(times)} values",
                found=f"{len(values)} values for {len(times)} times",
                at=("values",),
            )
        for index, (before, after) in enumerate(pairwise(times)):
            thrice = index > 0 and times[index - 1] == after
            if after < before or thrice:
                raise RefusedError(
                    "the same time three times or more" if thrice else "times must not decrease",
                    f"give a time after {show(before)}, or the same once more for a jump",
                    found=show(after),
                    at=("times", index + 1) if self.file is None else ("file",),
                )
        if not np.isfinite(self._coefficients).all():
            raise RefusedError(
                "values and times are too large or too close for a curve through them", "change the units"
            )
        if self.doubt:
            warn(self.doubt)
        return self

    @cached_property
    def _points(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times and values."""
        if self.file is None:
            return tuple(self.times or ()), tuple(self.values or ())
        times, values = read_record(
            self.file,
            time_column=self.time_column,
            value_column=self.value_column,
            time_unit=self.time_unit,
            value_unit=self.value_unit,
        )
        if not np.isfinite([times, values]).all():
            raise RefusedError(
                "times and values must be finite", "complete the table", found=show(self.file), at=("file",)
            )
        return times, values

    @cached_property
    def _rows(self) -> tuple[Floats, Floats]:
        """Times and values in arrays."""
        times, values = self._points
        return np.array(times), np.array(values)

    @property
    def doubt(self) -> str:
        """Why the table is not the spline that was asked for; empty where it is."""
        return self._curve[1]

    @property
    def _coefficients(self) -> Floats:
        return self._curve[0]

    @cached_property
    def _curve(self) -> tuple[Floats, str]:
        """Coefficients of the powers 0 to 3 of (t - times[k]), (n - 1, 4), the rows of jumps not used; and a doubt."""
        times, values = map(np.array, self._points)
        coefficients = np.zeros((len(times) - 1, 4))
        coefficients[:, 0] = values[:-1]
        steps = np.diff(times)
        doubt = ""
        with np.errstate(over="ignore", invalid="ignore"):
            if self.interpolation == "linear":
                np.divide(np.diff(values), steps, out=coefficients[:, 1], where=steps > 0.0)
                return coefficients, doubt
            from scipy.interpolate import CubicSpline, PchipInterpolator

            edges = [0, *(np.flatnonzero(steps == 0.0) + 1), len(times)]
            for first, last in pairwise(edges):
                if last - first > 1:
                    through, heights = times[first:last], values[first:last]
                    curve: Any = None
                    if self.interpolation == "cubic":
                        curve = CubicSpline(through, heights)
                        doubt = doubt or _overshoot(curve.c[::-1].T, through, heights, float(np.ptp(values)))
                    if doubt or curve is None:
                        curve = PchipInterpolator(through, heights)
                    coefficients[first : last - 1] = curve.c[::-1].T
        return coefficients, doubt

    @property
    def smooth(self) -> bool:
        """Whether its acceleration is continuous between jumps: it is a spline."""
        return self.interpolation == "cubic" and not self.doubt

    @cached_property
    def knots(self) -> Floats:
        """The times (n,), each once, increasing, s."""
        return np.unique(self._points[0])

    @property
    def corners(self) -> tuple[float, ...]:
        """Ends and repeated times, s: what is left of the breakpoints if the rows are taken as samples."""
        times = self._points[0]
        return tuple(dict.fromkeys((times[0], *self._doubled, times[-1])))

    @property
    def numbers(self) -> list[float]:
        """How many rows there are, their times and values, and coefficients of the powers 0 to 3 between them."""
        times, values = self._points
        return [float(len(times)), *times, *values, *self._coefficients.ravel().tolist()]

    @property
    def straight(self) -> bool:
        """Whether its pieces are straight lines."""
        return self.interpolation == "linear"

    def at(self, t: Floats) -> Floats:
        """Return the values at many times, after jumps."""
        times, values = self._rows
        k = np.searchsorted(times, t, side="right") - 1
        inside = np.clip(k, 0, len(times) - 2)
        x = t - times[inside]
        c0, c1, c2, c3 = np.moveaxis(self._coefficients[inside], -1, 0)
        found = c0 + x * (c1 + x * (c2 + x * c3))
        return np.asarray(np.where(k < 0, values[0], np.where(k >= len(times) - 1, values[-1], found)))

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """All times of a linear or monotone table; ends and jumps of a spline."""
        return self.corners if self.smooth else tuple(dict.fromkeys(self._points[0]))

    @property
    def jumps(self) -> tuple[float, ...]:
        """The times that are given twice with different values."""
        return tuple(
            time
            for (time, after), (low, high) in zip(*map(pairwise, self._points), strict=True)
            if time == after and low != high
        )

    @property
    def _doubled(self) -> tuple[float, ...]:
        return tuple(time for time, after in pairwise(self._points[0]) if time == after)

    def _derivative(self, t: float, before: bool, order: int) -> float:
        times, values = self._points
        interval = (bisect_left if before else bisect_right)(times, t) - 1
        if interval < 0 or interval >= len(times) - 1:
            end = values[0] if interval < 0 else values[-1]
            return end if order == 0 else 0.0
        c0, c1, c2, c3 = self._coefficients[interval].tolist()
        x = t - times[interval]
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


def _overshoot(coefficients: Floats, times: Floats, values: Floats, whole: float) -> str:
    """Say by how much cubics leave the range of the two values that they join, if by more than a tenth of all."""
    _, c1, c2, c3 = coefficients.T
    root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
    furthest, worst = 0.0, 0
    for sign in (1.0, -1.0):  # extremes where c1 + 2 c2 x + 3 c3 x^2 = 0
        q = -(c2 + np.copysign(root, c2))
        x = (
            np.divide(q, 3.0 * c3, out=np.zeros_like(q), where=c3 != 0.0)
            if sign > 0.0
            else c1 / np.where(q, q, np.inf)
        )
        x = np.clip(np.nan_to_num(x), 0.0, np.diff(times))
        height = values[:-1] + x * (c1 + x * (c2 + x * c3))
        low, high = np.minimum(values[:-1], values[1:]), np.maximum(values[:-1], values[1:])
        beyond = np.maximum(low - height, height - high)
        if beyond.max() > furthest:
            worst = int(beyond.argmax())
            furthest, reached, at = float(beyond[worst]), float(height[worst]), float(times[worst] + x[worst])
    if not furthest > OVERSHOOT * whole:
        return ""
    return (
        f"a cubic spline through the table would reach {reached:.3g} at t = {at:.6g} s, between the values "
        f"{values[worst]:.3g} and {values[worst + 1]:.3g}: the table is taken as interpolation = 'monotone', which "
        "stays between them; write that, or give more points"
    )
