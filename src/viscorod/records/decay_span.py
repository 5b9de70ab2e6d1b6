"""Which part of a record is one free decay: from its release on, without clipping, strays and a second release."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from viscorod.records.clipping import clipped_samples, resolution
from viscorod.records.damped_sines import SineFit, residual_peak
from viscorod.records.decay_fits import best_fit
from viscorod.records.held_samples import HELD, without_held
from viscorod.records.motion_record import Record
from viscorod.records.stray_samples import LEAST, MOST, STEPS, dropouts, spikes
from viscorod.records.sudden_change import changes_at
from viscorod.typing import Floats

__all__ = ["FEWEST", "DecaySpan", "start_of"]

FEWEST = 16
"""Samples of a decay at least."""
SWUNG = 0.05
"""Part of the largest deviation that is reached on the other side after a passage through rest; a dropout is none."""
MUCH_LEFT, LEFT_BEFORE = 0.1, 0.3
"""What a fit leaves over the amplitude from which on a second motion is looked for, and what it leaves before that."""
LEVELS = 2.0
"""Steps of a coarse record that a swing has at least where it is fitted."""
EARLY = (1.0, 2.0, 3.0, 4.0, 6.0)
"""Cycles from the first sample within which a second blow, or a hand that still touches, is looked for."""
EARLY_LEFT, EARLY_LESS = 0.02, 0.3
"""What a fit leaves over the amplitude from which on that is done, and the part that a later start leaves of it."""
GROWN, GROWN_TO = 1.8, 0.25
"""Growth of the level of a period within two periods that is a second motion, and its size over the first level."""


@dataclass(frozen=True)
class DecaySpan:
    """A part of a record.

    Attributes:
        record: the whole, without strays; part: what is fitted.
        begin_given, end_given: whether they stay.
        stray: samples of the part that were left out.
        again: time at which a second motion begins, s, or None.
        held: samples that each value of the record stood for, of which the first was taken.
        other: time until which it swings otherwise than later, s, or None.
    """

    record: Record
    part: Record
    begin_given: bool
    end_given: bool
    stray: int = 0
    again: float | None = None
    held: int = 1
    other: float | None = None

    @classmethod
    def of(cls, record: Record, start: float | None, end: float | None) -> DecaySpan:
        """Return the span from the first passage through rest, or what was given."""
        record, held = without_held(record)
        dropped = dropouts(record.values, STEPS * resolution(record.values) / LEAST)
        whole = _without(record, dropped)
        begin = start_of(whole.times, whole.values) if start is None else float(start)
        last = float(record.times[-1]) if end is None else float(end)
        inside = (record.times >= begin) & (record.times <= last)
        stray = int(np.count_nonzero(dropped & inside))
        return cls(whole, whole.window(begin, last), start is not None, end is not None, stray, held=held)

    def narrower(self, fit: SineFit | None, modes: int | None) -> DecaySpan | None:
        """Return what is left without what the fit shows to be no part of the decay; None if all of it is."""
        first = float(self.part.times[0])
        second = None if self.end_given else _set_in_motion_again(self.part, fit, modes)
        if second is not None:
            return replace(self, part=self.part.window(first, second), end_given=True, again=second)
        if fit is None:
            return None
        free = None if self.begin_given else _after_clipping(self.part, fit)
        if free is not None:
            return replace(self, part=free, begin_given=True)
        size = float(np.abs(fit.amplitudes).max())
        least = max(
            size, STEPS * resolution(self.part.values) / LEAST
        )  # steps of the resolution are no spikes
        far = spikes(fit.residual, least) | dropouts(fit.residual, least)
        stray, count = self.stray + int(far.sum()), len(far)
        if far.any() and stray <= MOST * (self.stray + count) and count - far.sum() >= FEWEST:
            record = _without(self.record, np.isin(self.record.times, self.part.times[far]))
            return replace(self, record=record, part=_without(self.part, far), stray=stray)
        low = _below_levels(fit, resolution(self.part.values))
        if not self.end_given and low < self.part.times[-1] - first:
            return replace(self, part=self.part.window(first, first + low), end_given=True)
        sudden = None if self.end_given or fit.is_white else changes_at(fit)
        if sudden is not None:
            part = self.part.window(first, first + sudden)
            return replace(self, part=part, end_given=True, again=first + sudden)
        later = None if self.begin_given else self._later_start(fit, modes)
        if later is not None:
            return replace(self, part=later, begin_given=True, other=float(later.times[0]))
        sunk = _sunk(fit)
        if not self.end_given and sunk < self.part.times[-1] - first:
            return replace(self, part=self.part.window(first, first + sunk), end_given=True)
        return None

    def _later_start(self, fit: SineFit, modes: int | None) -> Record | None:
        """Return the part from a few cycles later on where that alone is a decay; None if it is no better.

        Where the damping depends on the amplitude a later start leaves a little less, and no white noise.
        """
        strongest = int(np.argmax(np.abs(fit.amplitudes)))
        if fit.is_white or fit.noise < EARLY_LEFT * float(np.abs(fit.amplitudes[strongest])):
            return None
        period = 2.0 * np.pi / float(fit.poles[strongest].imag)
        first, last = float(self.part.times[0]), float(self.part.times[-1])
        for cycles in EARLY:
            begin = first + cycles * period
            if np.count_nonzero(self.part.times >= begin) < FEWEST or last - begin < EARLY[-1] * period:
                return None
            later = self.part.window(begin, last)
            found = best_fit(later.times, later.values, modes)
            if found is not None and found.is_white and found.noise < EARLY_LESS * fit.noise:
                return later
        return None

    def notes(self) -> list[str]:
        """Return what was left out, one sentence each."""
        found = []
        if self.held > 1:
            found.append(f"every value {HELD.format(self.held)}")
        if self.stray:
            found.append(
                f"{self.stray} sample{' stands' if self.stray == 1 else 's stand'} far off the others (spikes, or "
                f"dropouts), and {'is' if self.stray == 1 else 'are'} left out"
            )
        if self.again is not None:
            found.append(
                f"something sets it in motion again after {self.again:.4g} s, or samples are missing there: the record "
                "is used up to there; give start for the second decay"
            )
        if self.other is not None:
            found.append(
                f"until {self.other:.4g} s it swings otherwise than later, as after a second blow or under a hand that "
                "still touches it: the record is used from there on; give start to choose another time"
            )
        return found


def _without(record: Record, which: np.ndarray) -> Record:
    """Return a record without some samples."""
    if not which.any():
        return record
    noise = None if record.noise is None else record.noise[~which]
    return record.with_samples(record.times[~which], record.values[~which], noise)


def start_of(times: Floats, values: Floats) -> float:
    """Return the first passage through rest after the largest deviation from it.

    Where that leaves less than half of a record, the rest may have moved: a mean over one period follows it.
    """
    rest = float(np.median(values[-max(len(values) // 3, 4) :]))
    begin = _passage(times, values - rest)
    if begin > 0.5 * (times[0] + times[-1]) and len(values) >= 2 * FEWEST:
        line = np.polynomial.Polynomial.fit(times, values, 1)(times)
        pole = residual_peak(times - times[0], values - line)
        step = float(times[-1] - times[0]) / (len(times) - 1)
        period = round(2.0 * np.pi / float(pole.imag) / step)
        if 4 <= period <= len(values) // 3:
            begin = min(begin, _passage(times, values - uniform_filter1d(values, period, mode="mirror")))
    return begin


def _passage(times: Floats, off: Floats) -> float:
    """Return the first passage through zero after the largest deviation (n,)."""
    far = np.abs(off) >= 0.9 * float(np.abs(off).max(initial=0.0))
    first = int(np.argmax(far))
    passed = first + 1 + np.flatnonzero(off[first:-1] * off[first + 1 :] <= 0.0)
    if not len(passed):
        return float(times[0])
    side, least = -np.sign(off[first]), SWUNG * float(np.abs(off).max())
    ends = [*passed[1:], len(off)]
    through = [k for k, last in zip(passed, ends, strict=True) if (side * off[k:last]).max() > least]
    return float(times[through[0] if through else passed[0]])


def _set_in_motion_again(part: Record, fit: SineFit | None, modes: int | None) -> float | None:
    """Return the time at which a decay is set in motion again: much is left over, and it grows at once."""
    times, off = part.times - part.times[0], part.values - float(np.median(part.values))
    if fit is None:
        left, pole = float(np.std(off)), residual_peak(part.times, off)
    else:
        left, pole = fit.noise, fit.poles[int(np.argmax(np.abs(fit.amplitudes)))]
        if left < MUCH_LEFT * float(np.abs(fit.amplitudes).max()):
            return None
    period = 2.0 * np.pi / float(pole.imag)
    count = int(times[-1] / (0.5 * period)) - 1
    level = np.zeros(max(count, 0))
    for k in range(count):
        inside = (times >= 0.5 * k * period) & (times < (0.5 * k + 1.0) * period)
        level[k] = float(np.sqrt(np.mean(off[inside] ** 2))) if inside.any() else np.inf
    for k in range(8, count):
        if level[k] > GROWN * level[k - 4] and level[k] > GROWN_TO * level[0]:
            second = float(part.times[0] + 0.5 * (k - 4) * period)
            first = part.window(part.times[0], second)
            if len(first.times) < FEWEST:
                return None
            alone = best_fit(first.times, first.values, modes)
            return second if alone is not None and alone.noise < LEFT_BEFORE * left else None
    return None


def _after_clipping(part: Record, fit: SineFit) -> Record | None:
    """Return a record from the first passage through rest after its last clipped sample; None if none is clipped.

    What is left must have two cycles.
    """
    hertz = float(fit.poles.imag[int(np.argmax(np.abs(fit.amplitudes)))]) / (2.0 * np.pi)
    held = clipped_samples(part.values, len(part.times) / float(part.times[-1] - part.times[0]) / hertz)
    if not held.any():
        return None
    last = int(np.flatnonzero(held)[-1])
    off = part.values[last:] - float(np.median(part.values[last:]))
    passed = np.flatnonzero(off[:-1] * off[1:] <= 0.0)
    if last + 1 == len(part.times):
        return None
    begin = float(part.times[last + (int(passed[0]) + 1 if len(passed) else 1)])
    free = part.window(begin, part.times[-1]) if begin < part.times[-1] else None
    enough = free is not None and len(free.times) >= FEWEST and (free.times[-1] - begin) * hertz >= 2.0
    return free if enough else None


def _below_levels(fit: SineFit, step: float) -> float:
    """Return the time from the first sample at which all modes are within few levels of the record's resolution.

    What rounding to levels leaves over is no noise there, but a part of the swing that depends on where the rest lies.
    """
    size = np.abs(fit.amplitudes)
    if step == 0.0 or not (fit.poles.real < 0.0).all() or fit.is_white:
        return float("inf")  # noise of about a step makes noise of rounding, too
    sunk = float(np.max(np.log(np.maximum(size / (LEVELS * step), 1.0)) / -fit.poles.real))
    return max(sunk, _least(fit, float(fit.poles.imag[int(np.argmax(size))])))


def _least(fit: SineFit, omega: float) -> float:
    """Return the time that a decay keeps at least: four cycles of a frequency, and twice the fewest samples."""
    return max(4.0 * 2.0 * np.pi / omega, float(fit.times[min(2 * FEWEST, len(fit.times) - 1)]))


def _sunk(fit: SineFit) -> float:
    """Return the time from the first sample at which all modes are below what a fit leaves over that is not noise.

    Where it is noise later samples do no harm, and neither do they say anything.
    """
    if fit.is_white or not (fit.poles.real < 0.0).all():
        return float("inf")
    size = np.abs(fit.amplitudes)
    sunk = float(np.max(np.log(np.maximum(size / fit.noise, 1.0)) / -fit.poles.real))
    return max(sunk, _least(fit, float(fit.poles.imag.min())))
