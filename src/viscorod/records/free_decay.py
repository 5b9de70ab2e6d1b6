"""Free decays by themselves: frequencies and damping ratios with intervals, by amplitude, and what is doubtful."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.records.any_record import finite, increasing
from viscorod.records.arguments import described
from viscorod.records.damped_sines import SineFit, fit_sines, pencil_poles, residual_peak
from viscorod.records.decay_doubts import clipped_samples, doubts
from viscorod.records.motion_record import Record
from viscorod.records.read_off import QUANTITIES, Direction
from viscorod.results.decay_result import Decay
from viscorod.typing import Floats

__all__ = ["decay", "fitted_decay"]

MOST_MODES = 6
MOST_WINDOWS = 12
BETTER = 10.0
"""Fall of Bayes' criterion from which on another number of modes, or another polynomial of the rest, is taken."""
FAINT = 1e-7
"""Part of all energy below which a mode is what rounding and interpolation left."""
FEWEST = 16
"""Samples of a decay at least."""
ABOVE_NOISE = 3.0
"""Amplitude of a window over the noise, below which its ratio is not shown."""
CONFIDENCE = 0.95


@described
def decay(
    source: Any,
    values: Any = None,
    *,
    place: str | None = None,
    direction: Direction | None = None,
    start: float | None = None,
    end: float | None = None,
    modes: int | None = None,
    cycles: int | None = None,
) -> Decay:
    """Take a free decay apart: frequencies, damping ratios with 95 % intervals, and both by amplitude.

    Damped sines and a rest that may creep are fitted by least squares (`viscorod.records.damped_sines`); the number of
    modes is the one that Bayes' criterion prefers. Of the mode with the most energy, pieces of some cycles are fitted
    again by themselves. Intervals account for noise, white or coloured (`viscorod.records.sine_noise`); they are those
    of this record, not of the scatter between trials.

    Args:
        source: a `Record`, a `Run` (with place and direction), or times, s (n,).
        values: at the times (n,), any unit.
        place, direction: of a run, such as "beam.end" and "y".
        start, end: of the decay, s; by default from the first passage through rest after the largest deviation.
        modes: number of modes; left out, as many as the record shows, at most 6.
        cycles: per piece; left out, 2 or more, for 12 pieces at most.

    Raises:
        InputError: the record does not swing, or is too short.
    """
    record = _record_of(source, values, place, direction)
    for key, number, most in (("modes", modes, MOST_MODES), ("cycles", cycles, 10_000)):
        if number is not None and not (isinstance(number, int) and 1 <= number <= most):
            raise InputError(Fault(key, repr(number), "no such number", f"give 1 to {most}"))
    begin = _start_of(record.times, record.values) if start is None else float(start)
    part = record.window(begin, record.times[-1] if end is None else float(end))
    if len(part.times) < FEWEST:
        raise InputError(
            Fault(
                f"record {record.name}", f"{len(part.times)} samples from {begin:g} s",
                f"a decay needs {FEWEST} at least", "give start and end, or a record with more samples",
            )
        )  # fmt: skip
    return fitted_decay(record, part, modes, cycles, end, later=start is None)


def _record_of(source: Any, values: Any, place: str | None, direction: Direction | None) -> Record:
    if isinstance(source, Record):
        return source
    if getattr(source, "kind", None) == "simulate":
        if place is None or direction is None:
            raise InputError("a run has many places: give place and direction, such as 'beam.end' and 'y'")
        along = QUANTITIES["displacement"].direction("direction", direction)
        times = np.linspace(source.time[0], source.time[-1], max(2 * len(source.time), 200))
        found = source.probe(place, times).isel(place=0)["displacement"].values @ np.asarray(along)
        return Record(times, found, place=str(place), quantity="displacement", direction=direction)
    if values is None:
        raise InputError(
            Fault(
                "source",
                type(source).__name__,
                "no decay can be read from it",
                "give a Record, a Run, or times and values",
            )
        )
    times = increasing("times", source)
    return Record(
        times, finite("values", values), place="decay", quantity="displacement", direction="x", name="decay"
    )


def _start_of(times: Floats, values: Floats) -> float:
    """Return the first passage through rest after the largest deviation from it."""
    rest = float(np.median(values[-max(len(values) // 3, 4) :]))
    off = values - rest
    far = np.abs(off) >= 0.9 * float(np.abs(off).max(initial=0.0))
    first = int(np.argmax(far))
    passed = np.flatnonzero(off[first:-1] * off[first + 1 :] <= 0.0)
    return float(times[first + int(passed[0]) + 1]) if len(passed) else float(times[0])


def fitted_decay(
    record: Record,
    part: Record,
    modes: int | None,
    cycles: int | None,
    end: float | None,
    *,
    later: bool = False,
) -> Decay:
    """Return the decay of a part of a record; see `decay`. It may begin later, where the record is clipped at first."""
    times, values = part.times, part.values
    if float(np.ptp(values)) == 0.0:
        raise InputError(f"record {record.name}: nothing moves from {times[0]:g} to {times[-1]:g} s")
    fit = _best(times, values, modes)
    if fit is None:
        raise InputError(
            f"record {record.name}: no motion that swings about a rest was found from {times[0]:g} to {times[-1]:g} s; "
            "cut a window in which it swings freely for two cycles or more"
        )
    free = _after_clipping(part, fit) if later else None
    if free is not None:
        return fitted_decay(record, free, modes, cycles, end)
    sunk = _sunk(fit)
    if end is None and sunk < times[-1] - times[0]:
        return fitted_decay(
            record, part.window(times[0], times[0] + sunk), modes, cycles, float(times[0] + sunk)
        )
    order = np.argsort(-np.array([float(np.sum(fit.mode(k) ** 2)) for k in range(len(fit.poles))]))
    pieces = _pieces(fit, int(order[0]), cycles)
    return _result(record, part, fit, order, pieces)


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
    begin = float(part.times[last + (int(passed[0]) + 1 if len(passed) else 1)])
    free = part.window(begin, part.times[-1]) if begin < part.times[-1] else None
    enough = free is not None and len(free.times) >= FEWEST and (free.times[-1] - begin) * hertz >= 2.0
    return free if enough else None


def _sunk(fit: SineFit) -> float:
    """Return the time from the first sample at which all modes are below what a fit leaves over that is not noise.

    Where it is noise later samples do no harm, and neither do they say anything.
    """
    if fit.is_white or not (fit.poles.real < 0.0).all():
        return float("inf")
    size = np.abs(fit.amplitudes)
    sunk = float(np.max(np.log(np.maximum(size / fit.noise, 1.0)) / -fit.poles.real))
    least = 4.0 * 2.0 * np.pi / float(fit.poles.imag.min())
    return max(sunk, least, float(fit.times[min(2 * FEWEST, len(fit.times) - 1)]))


def _best(times: Floats, values: Floats, modes: int | None) -> SineFit | None:
    """Return the fit with the number of modes and the rest that Bayes' criterion prefers."""
    best: SineFit | None = None
    last: SineFit | None = None
    for count in range(1, MOST_MODES + 1) if modes is None else (modes,):
        least = FAINT * float(np.sum((values - values.mean()) ** 2))
        fits = (_fit(times, values, poles) for poles in _starts(times, values, count, last))
        found = [fit for fit in fits if fit and (modes is not None or _sensible(fit, least))]
        if not found:
            break
        last = min(found, key=lambda fit: fit.information)
        if best is not None and last.information > best.information - BETTER:
            break
        best = last
    return best


def _starts(times: Floats, values: Floats, count: int, last: SineFit | None) -> list[np.ndarray]:
    """Return poles to start from: those of the matrix pencil, and those of fewer modes with one of the residual."""
    starts = []
    poles = pencil_poles(times, values, count)
    if len(poles) == count:
        starts.append(poles)
    if last is not None:
        starts.append(np.append(last.poles, residual_peak(times, last.residual)))
    elif count == 1:
        starts.append(np.array([residual_peak(times, values - values.mean())]))
    else:
        fewer = _best(times, values, count - 1)
        if fewer is not None:
            starts.append(np.append(fewer.poles, residual_peak(times, fewer.residual)))
    return starts


def _fit(times: Floats, values: Floats, poles: np.ndarray) -> SineFit | None:
    """Return the fit with the rest that Bayes' criterion prefers."""
    best: SineFit | None = None
    for rest in ("constant", "sloping", "relaxing"):
        found = fit_sines(times, values, poles if best is None else best.poles, rest)
        if found is not None and (best is None or found.information < best.information - BETTER):
            best = found
    return best


def _sensible(fit: SineFit, least: float) -> bool:
    """Return whether every mode stands out of the noise and of the others, and none grows without bound.

    Two modes whose half-power bands overlap decay before they beat: one mode whose ratio depends on the amplitude would
    look the same.
    """
    ordered = fit.poles[np.argsort(fit.poles.imag)]
    if (np.diff(ordered.imag) < np.abs(ordered.real[1:]) + np.abs(ordered.real[:-1])).any():
        return False
    nyquist = np.pi * (len(fit.times) - 1) / float(fit.times[-1])
    for k, pole in enumerate(fit.poles):
        energy = float(np.sum(fit.mode(k) ** 2))
        if energy < max(25.0 * fit.noise**2, least) or pole.imag > nyquist or pole.real * fit.times[-1] > 0.5:
            return False
        if -pole.real > 0.7 * abs(pole):  # no swing: what creeps, or what the release left
            return False
    return True


def _pieces(fit: SineFit, mode: int, cycles: int | None) -> dict[str, Floats]:
    """Return amplitude, frequency and ratio of pieces of a few cycles of one mode, with half-widths of intervals."""
    alone = fit.residual + fit.mode(mode) + fit.rest
    period = 2.0 * np.pi / fit.poles[mode].imag
    whole = int(fit.times[-1] / period)
    long = max(2, -(-whole // MOST_WINDOWS)) if cycles is None else cycles
    found: list[tuple[float, float, SineFit]] = []
    for k in range(whole // long):
        inside = (fit.times >= k * long * period) & (fit.times < (k + 1) * long * period)
        if np.count_nonzero(inside) < 8:
            continue
        rest = "sloping" if np.count_nonzero(inside) > 16 else "constant"
        piece = fit_sines(fit.times[inside], alone[inside], fit.poles[mode : mode + 1], rest)
        if piece is None or abs(piece.poles[0].imag - fit.poles[mode].imag) > 0.3 * fit.poles[mode].imag:
            break
        middle = float(np.mean(fit.times[inside]))
        size = abs(piece.amplitudes[0]) * np.exp(piece.poles[0].real * (middle - fit.times[inside][0]))
        if size < ABOVE_NOISE * max(fit.noise, piece.noise):
            break
        found.append((middle, float(size), piece))
    columns: dict[str, list[float]] = {name: [] for name in PIECE}
    for middle, size, piece in found:
        wide, wider = (float(column[0]) for column in piece.half_widths(CONFIDENCE, fit.told.noise))
        row = (middle, size, float(piece.frequencies[0]), wide, float(piece.ratios[0]), wider)
        for name, number in zip(PIECE, row, strict=True):
            columns[name].append(number)
    return {name: np.array(column) for name, column in columns.items()}


PIECE = ("time", "amplitude", "frequency", "frequency_width", "ratio", "ratio_width")


def _result(
    record: Record, part: Record, fit: SineFit, order: np.ndarray, pieces: dict[str, Floats]
) -> Decay:
    import xarray as xr

    widths = [column[order] for column in fit.half_widths(CONFIDENCE)]
    data = xr.Dataset(
        {
            "value": ("time", part.values),
            "model": ("time", fit.model),
            "rest": ("time", fit.rest),
            "frequency": ("mode", fit.frequencies[order]),
            "frequency_width": ("mode", widths[0]),
            "damping_ratio": ("mode", fit.ratios[order]),
            "damping_ratio_width": ("mode", widths[1]),
            "amplitude": ("mode", np.abs(fit.amplitudes[order])),
            **{f"piece_{name}": ("piece", column + (part.times[0] if name == "time" else 0.0))
               for name, column in pieces.items()},
        },
        {"time": part.times},
        {
            "kind": "decay",
            "title": "" if record.name == "decay" else record.name,
            "unit": "" if record.name == "decay" else record.unit,
            "noise": fit.noise,
            "white": int(fit.is_white),
            "warnings": json.dumps(doubts(record, part, fit, order, pieces)),
        },
    )  # fmt: skip
    return Decay(data)
