"""Free decays by themselves: frequencies and damping ratios with intervals, by amplitude, and what is doubtful."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np

from viscorod.argument_names import telling
from viscorod.errors import Fault, InputError
from viscorod.one_thread import one_blas_thread
from viscorod.records.any_record import finite, increasing
from viscorod.records.arguments import described
from viscorod.records.damped_sines import SineFit, fit_sines
from viscorod.records.decay_doubts import doubts, lasts
from viscorod.records.decay_fits import MOST_MODES, best_fit
from viscorod.records.decay_span import FEWEST, DecaySpan
from viscorod.records.motion_record import Record
from viscorod.records.read_off import QUANTITIES, Direction
from viscorod.results.decay_result import Decay
from viscorod.typing import Floats
from viscorod.wording import show

__all__ = ["decay", "fitted_decay"]

MOST_WINDOWS = 12
ABOVE_NOISE = 3.0
"""Amplitude of a window over the noise, below which its ratio is not shown."""
CONFIDENCE = 0.95


@described
@one_blas_thread()
@telling
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
    window_time: float | None = None,
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
        window_time: time constant of an exponential window that the record was multiplied by, s: at the end of a record
            of length T where it is down to the part p this is -T/ln p. Ratios and amplitudes are without it.

    Raises:
        InputError: the record does not swing, or is too short.
    """
    record = _record_of(source, values, place, direction)
    for key, number, most in (("modes", modes, MOST_MODES), ("cycles", cycles, 10_000)):
        if number is not None and not (isinstance(number, int) and 1 <= number <= most):
            raise InputError(Fault(key, repr(number), "no such number", f"give 1 to {most}"))
    if window_time is not None and not 0.0 < window_time < np.inf:
        raise InputError(
            Fault("window_time", f"{window_time:g}", "a time constant is positive", "give it in s")
        )
    span = DecaySpan.of(record, start, end)
    if len(span.part.times) < FEWEST:
        raise InputError(
            Fault(
                f"record {record.name}", f"{len(span.part.times)} samples from {span.part.times[0]:g} s",
                f"a decay needs {FEWEST} at least", "give start and end, or a record with more samples",
            )
        )  # fmt: skip
    return fitted_decay(span, modes, cycles, 0.0 if window_time is None else 1.0 / window_time)


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
                show(source),
                "no decay can be read from it",
                "give a Record (Record.read of a file), a Run, or times and values",
            )
        )
    times = increasing("times", source)
    return Record(
        times, finite("values", values), place="decay", quantity="displacement", direction="x", name="decay"
    )


def fitted_decay(span: DecaySpan, modes: int | None, cycles: int | None, weighed: float = 0.0) -> Decay:
    """Return the decay of a part of a record, which is narrowed until it is one free decay; see `decay`.

    Args:
        span: the part; modes, cycles: as there.
        weighed: decay rate of an exponential window, 1/s.
    """
    while True:
        part = span.part
        first, last = float(part.times[0]), float(part.times[-1])
        if float(np.ptp(part.values)) == 0.0:
            raise InputError(f"record {part.name}: nothing moves from {first:g} to {last:g} s")
        fit = best_fit(part.times, part.values, modes)
        narrower = span.narrower(fit, modes)
        if narrower is not None:
            span = narrower
            continue
        if fit is None:
            raise InputError(
                f"record {part.name}: no motion that swings about a rest, and does not grow, was found from {first:g} "
                f"to {last:g} s; cut a window in which it swings freely for two cycles or more"
            )
        fit = replace(fit, weighed=weighed) if weighed else fit
        order = _order(fit)
        return _result(span, fit, order, _pieces(fit, int(order[0]), cycles))


def _order(fit: SineFit) -> np.ndarray:
    """Return the modes by their energy; those that do not die out, as the hum of the mains, come last."""
    energy = np.array([float(np.sum(fit.mode(k) ** 2)) for k in range(len(fit.poles))])
    lasting = lasts(fit)
    return np.lexsort((-energy, lasting if not lasting.all() else np.zeros(len(energy), dtype=bool)))


def _pieces(fit: SineFit, mode: int, cycles: int | None) -> dict[str, Floats]:
    """Return amplitude, frequency and ratio of pieces of a few cycles of one mode, with half-widths of intervals."""
    alone = fit.residual + fit.mode(mode)  # what a rest that creeps leaves over is a line in each piece
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
        piece = replace(piece, weighed=fit.weighed) if fit.weighed else piece
        size = abs(piece.amplitudes[0]) * np.exp(piece.poles[0].real * (middle - fit.times[inside][0]))
        if size < ABOVE_NOISE * max(fit.noise, piece.noise):
            break
        found.append((middle, float(size * np.exp(fit.weighed * middle)), piece))
    columns: dict[str, list[float]] = {name: [] for name in PIECE}
    for middle, size, piece in found:
        wide, wider = (float(column[0]) for column in piece.half_widths(CONFIDENCE, fit.told.noise))
        row = (middle, size, float(piece.frequencies[0]), wide, float(piece.ratios[0]), wider)
        for name, number in zip(PIECE, row, strict=True):
            columns[name].append(number)
    return {name: np.array(column) for name, column in columns.items()}


PIECE = ("time", "amplitude", "frequency", "frequency_width", "ratio", "ratio_width")


def _result(span: DecaySpan, fit: SineFit, order: np.ndarray, pieces: dict[str, Floats]) -> Decay:
    import xarray as xr

    record, part = span.record, span.part
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
            "warnings": json.dumps(span.notes() + doubts(record, part, fit, order, pieces)),
        },
    )  # fmt: skip
    return Decay(data)
