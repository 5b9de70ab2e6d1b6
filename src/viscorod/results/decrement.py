"""The decay of a swing, cycle by cycle: maxima, periods, logarithmic decrements, damping ratios."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.attributes import WellNamed
from viscorod.checks import checked_with
from viscorod.checks import numbers as checked_numbers
from viscorod.errors import InputError
from viscorod.results.extremes import creeping_rest, maxima, resting_value
from viscorod.results.text_numbers import quantity
from viscorod.results.text_table import Column, numbers, tabulated, words
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

_FLOOR = 1e-6  # maxima below this part of the largest amplitude are what the solver's tolerance left
_LAST = 2  # cycles that the drawn envelope follows, and that represent the decay where no line does
_FITTED = 3  # cycles from which the limit of small amplitude is extrapolated
_CURVED = 0.05  # largest distance of ratios from the extrapolating line, as a part of their own range
_FLAT = 2e-3  # the same as a part of the ratio: so near to it that the line does no harm
_AGREEING = 1.3  # largest ratio of two periods in what is called a decay
_GROWING = 0.02  # logarithmic growth of a maximum in what is called a decay: numerical errors, beats
_SCATTER = 0.5  # change of the ratio between cycles, as a part of the largest, that indicates several modes
_UNDAMPED = 1e-3  # ratios below it scatter by the errors of the integration


@known_arguments
@dataclass(frozen=True, repr=False, eq=False)
class Decrement(WellNamed, Shown, Alike):
    """Successive maxima (or minima) of a decaying motion; n of them bound n - 1 cycles.

    Attributes:
        place: the place, "beam.end".
        axis: the global axis, "x", "y" or "z".
        rest: displacement about which it swings [m]; where it creeps, at each of the maxima, shape (n,).
        time: times of the maxima [s], shape (n,).
        value: displacements at the maxima [m], shape (n,).
    """

    place: str
    axis: str
    rest: float | Floats
    time: Floats
    value: Floats

    def _facts(self) -> Iterator[str]:
        yield f"{self.place} along {self.axis}"
        yield counted(len(self.period), "cycle")
        if len(self.period):
            name, ratio = self.limit
            yield f"damping ratio {ratio:.4g} ({name})"

    def _drawing(self) -> str:
        drawing = Drawing(equal=False)
        drawing.line(np.stack([self.time, self.rest_at(self.time)], axis=-1), faint=True)
        drawing.line(np.stack([self.time, self.value], axis=-1))
        drawing.dots(np.stack([self.time, self.value], axis=-1))
        return drawing.svg()

    @property
    def amplitude(self) -> Floats:
        """Distance of each maximum from rest [m], shape (n,); cycle k starts with maximum k."""
        return np.abs(self.value - self.rest)

    @checked_with(time=checked_numbers)
    def rest_at(self, time: Floats) -> Floats:
        """Return the displacement about which it swings [m] at times ``(k,)`` [s]; beyond the maxima the nearest."""
        return np.asarray(np.interp(time, self.time, np.broadcast_to(self.rest, self.time.shape)))

    @property
    def mean_amplitude(self) -> Floats:
        """Geometric mean of the amplitudes that bound each cycle [m], shape (n - 1,)."""
        mean: Floats = np.sqrt(self.amplitude[:-1] * self.amplitude[1:])
        return mean

    @property
    def period(self) -> Floats:
        """Time from maximum to maximum [s], shape (n - 1,)."""
        return np.diff(self.time)

    @property
    def log_decrement(self) -> Floats:
        """``delta = ln(amplitude at the start / at the end)`` of each cycle, shape (n - 1,)."""
        return -np.diff(np.log(self.amplitude))

    @property
    def damping_ratios(self) -> Floats:
        """``zeta`` from ``delta = 2 pi zeta / sqrt(1 - zeta^2)`` of each cycle, shape (n - 1,)."""
        delta = self.log_decrement
        ratio: Floats = delta / np.sqrt(4.0 * np.pi**2 + delta**2)
        return ratio

    @property
    def damping_ratio(self) -> Floats:
        """The same as ``damping_ratios``, by its name of version 0.1."""
        return self.damping_ratios

    @property
    def regular(self) -> bool:
        """True if this is a decay: two periods or more that agree within 30 %, and no amplitude that grows."""
        if len(self.period) < 2:
            return False
        steady = float(np.max(self.period)) < _AGREEING * float(np.min(self.period))
        return steady and bool(np.all(self.log_decrement > -_GROWING))

    @property
    def scattered(self) -> bool:
        """True if the ratios jump from cycle to cycle, as they do where several modes take part."""
        ratio = self.damping_ratio
        largest = float(np.max(np.abs(ratio)))
        return largest > _UNDAMPED and bool(np.any(np.abs(np.diff(ratio)) > _SCATTER * largest))

    @property
    def envelope(self) -> tuple[float, float]:
        """``(a, b)`` of ``a exp(-b t)`` [m, 1/s] fitted to the last two cycles, to all if they are scattered."""
        last = slice(None) if self.scattered else slice(-_LAST - 1, None)
        slope, intercept = np.polyfit(self.time[last], np.log(self.amplitude[last]), 1)
        return float(np.exp(intercept)), -float(slope)

    @property
    def small_amplitude_ratio(self) -> float:
        """Limit of the damping ratio for small amplitude, extrapolated from the last three cycles.

        A motion that is symmetric about rest departs from linear with the square of its amplitude, so the
        limit is that of a straight line through ratio over mean amplitude squared. Where the ratios leave
        that line by more than 5 % of their range (and 0.2 % of their size) it is the ratio of the last two
        cycles taken as one: higher modes, which a sudden release starts, are in the first one most. With
        fewer cycles, or an amplitude that changes by less than a tenth, it is that of all three.
        """
        return self._of_last_cycles[1]

    @property
    def _of_last_cycles(self) -> tuple[str, float]:
        square = self.mean_amplitude[-_FITTED:] ** 2
        ratio = self.damping_ratio[-_FITTED:]
        if ratio.size == _FITTED and np.ptp(square) > 0.2 * np.max(square):
            line = np.polyfit(square, ratio, 1)
            off = np.max(np.abs(ratio - np.polyval(line, square)))
            if off < max(_CURVED * np.ptp(ratio), _FLAT * np.max(np.abs(ratio))):
                return "small amplitude", float(line[1])
            ratio = ratio[-_LAST:]
        return f"last {ratio.size} cycles taken as one", _ratio(self.log_decrement[-ratio.size :])

    @property
    def limit(self) -> tuple[str, float]:
        """The representative damping ratio of the decay, and in words of which cycles."""
        if self.scattered:
            return "all cycles taken as one", self.mean_damping_ratio
        return self._of_last_cycles

    @property
    def mean_damping_ratio(self) -> float:
        """The ratio of all cycles taken as one."""
        return _ratio(self.log_decrement)

    def __str__(self) -> str:
        first, *_, last = self.rest_at(self.time)
        about = f" about {quantity(float(last), 'm')}" if last else ""
        if first != last:
            about = f" about a rest that creeps from {quantity(float(first), 'm')} to {quantity(float(last), 'm')}"
        # a row for each maximum, whose cycle the last one only ends
        cycles = [str(number) for number in range(1, len(self.time))]
        table = tabulated(
            f"Decay of {self.place} along {self.axis}{about}",
            words("cycle", [*cycles, "end"]),
            numbers(("starts",), "s", self.time, aligned=True),
            numbers(("amplitude",), "m", self.amplitude),
            _ended(numbers(("period",), "s", self.period, aligned=True)),
            _ended(numbers(("log decrement",), "", self.log_decrement, digits=5)),
            _ended(numbers(("damping ratio",), "", self.damping_ratio, digits=5)),
        )
        name, limit = self.limit
        lines = [table, f"  {name}: damping ratio {limit:.5g}"]
        if self.scattered:
            lines.append("  (the ratios jump from cycle to cycle: several modes take part)")
        return "\n".join(lines)


def _ended(columns: list[Column]) -> list[Column]:
    """Return columns of cycles with an empty cell beside the maximum that ends the last one."""
    return [(name, [*cells, ""]) for name, cells in columns]


def decrement(
    time: Floats,
    value: Floats,
    rate: Floats,
    *,
    rest: float | None = 0.0,
    below: bool = False,
    place: str = "",
    axis: str = "",
) -> Decrement:
    """Find the maxima of every swing past ``rest``.

    Between stored times the motion is the cubic Hermite polynomial through values and rates, so a maximum
    falls where it is and not on a sample. One maximum counts per swing to the positive side (the largest,
    whatever ripple rides on it); a start from rest counts, a swing cut off by the end of the record does not.

    Args:
        time: times [s], increasing, shape (m,).
        value: displacement [m], shape (m,).
        rate: its rate [m/s], shape (m,).
        rest: displacement about which it swings [m], or None to take it from the extremes: from the last three,
            or from three at a time where they show that it creeps (see ``creeping_rest``).
        below: count the swings to the negative side, minima instead of maxima.
        place: name for messages and tables.
        axis: name for messages and tables.

    Raises:
        InputError: fewer than two maxima.
    """
    if rest is None:
        creeping = creeping_rest(time, value, rate)
        if creeping is not None:
            times, values, rests = creeping
            counted = values < rests if below else values > rests
            return Decrement(place, axis, rests[counted], times[counted], values[counted])
        rest = resting_value(time, value, rate)
    sign, extreme = (-1.0, "minimum") if below else (1.0, "maximum")
    value, rate, level = sign * value, sign * rate, sign * rest
    times, values, intervals = maxima(time, value, rate)
    above = value > level
    swing = np.cumsum(np.concatenate([[0], (above[1:] & ~above[:-1]).astype(np.int64)]))
    on_sample = np.where(above[intervals], intervals, np.minimum(intervals + 1, above.size - 1))
    number = swing[on_sample]
    complete = number < swing[-1] if above[-1] else np.ones(number.size, dtype=bool)
    floor = _FLOOR * float(np.max(np.abs(value - level), initial=0.0))
    valid = complete & above[on_sample] & (values - level > floor)

    chosen = []
    for k in np.unique(number[valid]):
        mine = np.flatnonzero(valid & (number == k))
        best = mine[np.argmax(values[mine])]
        cut_off = k == swing[0] and above[0] and values[best] < value[0]
        if not cut_off:
            chosen.append(best)
    if len(chosen) < 2:
        count = f"{('no', 'one')[len(chosen)]} complete {extreme}"
        raise InputError(
            f"{place or 'the motion'} along {axis or 'this axis'} passes {count} about "
            f"{rest:g} m between {time[0]:g} and {time[-1]:g} s; a decrement needs two: "
            "simulate longer, or name another place, axis or rest"
        )
    return Decrement(place, axis, float(rest), times[chosen], sign * values[chosen])


def _ratio(deltas: Floats) -> float:
    """Return the damping ratio of cycles with the given logarithmic decrements, taken as one."""
    delta = float(np.mean(deltas))
    return float(delta / np.hypot(2.0 * np.pi, delta))
