"""What often is wrong with a measurement that a model does not explain: direction, sign, unit, range, nuisances.

Nothing is changed by it. A sentence is said only of a history whose residuals are no white noise, or of which they die
out along with it, or are nearly all of it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from viscorod.analyses.identification.members import Member
from viscorod.analyses.identification.record_frequencies import vibrating
from viscorod.analyses.identification.told import CORRELATED, whiteness
from viscorod.errors import InputError, SolveError
from viscorod.records.clipping import clipped_samples
from viscorod.records.dying_noise import dying_rate, said_of_window
from viscorod.records.free_decay import decay
from viscorod.records.motion_record import Record
from viscorod.records.read_off import direction_text
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.typing import Floats

__all__ = ["common_faults", "nuisances_left"]

STILL = 1e-6
"""Part of the measured range below which the model does not move."""
OTHER_SIZE = 20.0
"""Ratio of ranges from which on a unit or gain is spoken of."""
STAYS, FIRST, WAITS = 0.05, 5, 0.25
"""Part of its range within which a history stands still, of where its first samples are, and for how many cycles it
must be so to be held before a release."""
OFF_REST = 0.2
"""Part of the range by which a record must begin beside its rest for its sign to be compared."""
LONG = 0.1
"""Part of a cycle for which a record at its extreme value is clipped, whatever its resolution."""
EXPLAINED = 0.6
"""Part of the power of what is left that an unknown must explain to be named."""
NEXT_TO_NOTHING = 0.1
"""Part of a record's variance that a model explains below which it is next to nothing."""
PARTLY, MOVES = 0.25, 3.0
"""The same of an unknown that would move a number by so many of its standard errors: noise may be the rest."""
HINTS = {
    "offset": "an offset of its zero",
    "drift": "a drift of its zero",
    "gain": "another gain",
    "release_time": "another time of release",
}


def common_faults(members: Sequence[Member], best: Estimate) -> list[str]:
    """Return sentences on the histories that the model does not explain; see the module."""
    found = []
    begin = 0
    doubtful = {
        series.label
        for series, probability in zip(best.noise.series, whiteness(best), strict=True)
        if probability < CORRELATED
    }
    for member in members:
        for record in member.records:
            rows = slice(begin, begin + len(record.observed))
            begin = rows.stop
            if isinstance(record, Record):
                wrong = list(_faults(record, best, rows)) if record.name in doubtful else []
                found += [] if wrong else _of_noise(record, best, rows)
                found += _windowed(record, best, rows, swings=record.name in doubtful) + wrong
    return found


def _of_noise(record: Record, best: Estimate, rows: slice) -> list[str]:
    """Return a sentence where the model explains next to nothing of a record: what is left is white, but so is noise.

    A search among noise ends where some of it looks like a motion, with intervals of that minimum alone.
    """
    measured = best.measured[rows]
    spread = float(np.sum((measured - measured.mean()) ** 2))
    left = float(np.sum((measured - best.predicted[rows]) ** 2))
    if spread == 0.0 or left < (1.0 - NEXT_TO_NOTHING) * spread:
        return []
    return [
        f"The model explains {100.0 * max(1.0 - left / spread, 0.0):.2g} % of the variance of {record.name}: next to "
        "all of it is noise to the model, and a search among noise may end far off, with intervals that do not know "
        f"of it. Is {record.place}, {record.quantity} {direction_text(record.direction)} its place and direction? If "
        "so, leave it out, or give the numbers from another record and compare."
    ]


def _faults(record: Record, best: Estimate, rows: slice) -> Iterator[str]:
    measured, predicted = best.measured[rows], best.predicted[rows]
    range_of, model = float(np.ptp(measured)), float(np.ptp(predicted))
    if range_of == 0.0:
        yield f"Nothing moves in {record.name}: all its values are {record.values[0]:g}."
        return
    if model <= STILL * range_of:
        yield (
            f"The model hardly moves where {record.name} was measured ({record.place}, {record.quantity} "
            f"{direction_text(record.direction)}): is that its place and direction?"
        )
        return
    # before a release a rod is held where it is, and not clipped there
    if _clipped(measured[_stays(measured) :]):
        yield (
            f"The largest values of {record.name} come several times in a row: it is clipped there. Cut a window in "
            "which it is not."
        )
        return
    waits, model_waits = (record.times[_stays(one)] - record.times[0] for one in (measured, predicted))
    released = any(one.name == "release_time" for one in record.nuisances.values())
    long = max(WAITS / vibrating(record)[0], 2.0 * model_waits)
    if waits > long and not released:
        yield (
            f"{record.name} stands still for its first {waits:.3g} s, and the model does not: if that is before the "
            "release, give it unknown = ['release_time'], or cut it off and count times from the release."
        )
        return
    sides = [_off_rest(values) for values in (measured, predicted)]
    if sides[0] * sides[1] < 0.0 and min(map(abs, sides)) > OFF_REST:
        yield (
            f"{record.name} begins on the other side of its rest than the model: its direction may be the opposite one."
        )
        return
    if not 1.0 / OTHER_SIZE < range_of / model < OTHER_SIZE:
        yield (
            f"{record.name} moves {range_of / model:.3g} times as far as the model: look at the unit of its values, or "
            "give it an unknown gain with bounds about that."
        )
        return
    yield from nuisances_left(record, best, rows)


def _windowed(record: Record, best: Estimate, rows: slice, *, swings: bool) -> list[str]:
    """Tell of noise that dies out along a record: damping that is fitted to a weighed one has the window's in it.

    Args:
        swings: whether the model leaves more than noise: then it is that of damped sines through the record.
    """
    instead = "if there was one, take it off (window_time of its table, record.without_exponential)"
    if swings:
        try:
            told = decay(record)
        except (InputError, SolveError):  # it does not swing freely
            return []
        dying = dying_rate(told.data["time"].values, told.data["value"].values - told.data["model"].values)
        motion = 2.0 * np.pi * float(told.frequencies[0] * told.damping_ratios[0])
    else:
        dying, motion = dying_rate(record.times, best.residuals[rows]), _rate(best.predicted[rows], record)
    return [f"The noise of {record.name} {said_of_window(dying, motion, instead)}."] if dying else []


def _rate(predicted: Floats, record: Record) -> float:
    """Return the rate at which a motion dies out, from its two halves, 1/s."""
    about = predicted - predicted[-max(len(predicted) // 10, 1) :].mean()
    first, second = (float(np.sqrt(np.mean(part**2))) for part in np.array_split(about, 2))
    return float(np.log(max(first, 1e-300) / max(second, 1e-300)) / (0.5 * np.ptp(record.times)))


def _clipped(values: Floats) -> bool:
    """Return whether a history stays at an extreme value; what stood still before it was let go does not count."""
    cycle = _samples_per_cycle(values)
    if clipped_samples(values, cycle).any():
        return True
    for extreme in (values.max(), values.min()):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], values == extreme, [False]]).astype(int)))
        runs = (edges[1::2] - edges[::2])[edges[::2] > 0]
        if len(runs) and int(runs.max()) > max(LONG * cycle, 2.0):
            return True
    return False


def _stays(values: Floats) -> int:
    """Return how many samples of a history stay within a part of its range of where it begins."""
    return int(np.argmax(np.abs(values - np.median(values[:FIRST])) > STAYS * np.ptp(values)))


def _samples_per_cycle(values: Floats) -> float:
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)))) ** 2
    return len(values) / max(int(np.argmax(power)), 1)


def _off_rest(values: Floats) -> float:
    """Return how far the first values are from the rest, over the range."""
    count = len(values)
    rest = float(np.median(values[-max(count // 3, 1) :]))
    return (float(np.mean(values[: max(count // 50, 1)])) - rest) / max(float(np.ptp(values)), 1e-300)


def nuisances_left(record: Record, best: Estimate, rows: slice) -> Iterator[str]:
    """Tell which number of the measurement, not sought so far, would explain most of what is left."""
    known = {one.name for one in record.nuisances.values()}
    residual, predicted = best.residuals[rows], best.predicted[rows]
    shapes = {
        "offset": np.ones(len(residual)),
        "drift": record.times - record.times[0],
        "gain": predicted - predicted.mean(),
        "release_time": np.gradient(predicted, record.times),
    }
    slopes = best.slopes[rows]
    q, r = np.linalg.qr(slopes)
    left = residual - q @ (q.T @ residual)
    power = max(float(left @ left), 1e-300)
    shares, moves = {}, {}
    for name, shape in shapes.items():
        own = shape - q @ (q.T @ shape)
        size = float(own @ own)
        if name not in known and size > 1e-6 * float(shape @ shape):
            part = float(own @ left) / size
            shares[name] = part**2 * size / power
            inverse = np.linalg.pinv(r)
            errors = np.linalg.norm(inverse, axis=1) * np.sqrt(power / len(left))
            moves[name] = np.abs(inverse @ (q.T @ shape)) * abs(part) / np.maximum(errors, 1e-300)
    name = max(shares, key=lambda one: shares[one], default="")
    if not name or shares[name] <= PARTLY:
        return
    most = int(np.argmax(moves[name]))
    moved = float(moves[name][most])
    if shares[name] > EXPLAINED or moved > MOVES:
        text = (
            f"{100.0 * shares[name]:.0f} % of what is left of {record.name} is what {HINTS[name]} would leave"
        )
        if moved > MOVES:
            text += f", which would move {best.unknowns.names[most]} by {moved:.2g} standard errors"
        yield f"{text}: if it may have one, give it unknown = ['{name}']."
