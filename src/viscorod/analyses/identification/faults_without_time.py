"""What often is wrong with responses, tables of modes and static loads that a model does not explain.

Nothing is changed by it. A sentence is said only of a record of which much is left: kind and sign of a response, modes
that are missing or swapped, sign and unit of what a load moved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.signal import find_peaks

from viscorod.analyses.identification.members import Member
from viscorod.analyses.identification.static_loop import static_loops
from viscorod.analyses.identification.static_zero import static_zero
from viscorod.analyses.identification.told import much_left
from viscorod.records.modes_record import ModesRecord
from viscorod.records.response_record import ResponseRecord
from viscorod.records.static_record import StaticRecord
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.solve.estimation.noise import MEDIAN_TO_DEVIATION
from viscorod.typing import Floats, Integers

__all__ = ["faults_without_time", "of_another_kind"]

ALIKE, BETTER = 1.0, 3.0
"""Median distance of logarithms, real and imaginary part, below which two responses are called alike, and times that
the distance of the model's own must be larger."""
MET, SHARPER, FEWEST = 0.03, 5.0, 3
"""Scatter of the logarithms of frequencies below which another order of modes is named, times that it is less, and of
how many modes."""
OTHER_SIZE = 20.0
"""Ratio of ranges from which on a unit is spoken of."""
LOOP = 0.1
"""Area, over the square of the largest distance from the middle, that a response must go round for its sense to be
compared."""
EXPLAINED, LEAST, DELAYS = 0.5, 10, 401
"""Part of the power of what is left that an unknown must explain to be named, of how many frequencies, and how many
delays are tried."""
CLEAR, FEWEST_CLEAR = 5.0, 5
"""Times its noise that a response must be to be compared, at how many frequencies."""
MOST_MOVED = 2.0
"""Ratio by which the peaks of a model may be elsewhere."""
OPPOSITE = -0.8
"""Correlation of what was measured and what the model says below which they go to opposite sides."""
OF_UNIT = 0.04
"""Relative distance from the factor of a unit within which it is named."""
TURN, GRAVITY = 2.0 * np.pi, 9.80665
FREQUENCY_UNITS = {
    TURN: "these are angular frequencies in rad/s: divide them by 2 pi",
    60.0: "these are turns per minute: divide them by 60",
    1e-3: "these are in kHz",
}
"""Sizes of frequencies over those of the model, and what they may be."""
LOAD_UNITS = {
    GRAVITY: "the loads are in kg: give them in N",
    GRAVITY * 1e-3: "the loads are in g: give them in N",
    1e3: "the values are in thousandths of their unit (mm), or the loads in thousands of theirs (kN)",
    1e-3: "the loads are in thousandths of their unit (mN)",
}
"""Sizes of what moved over that of the model, and what they may be."""
KINDS = {
    -2: "second integral (a displacement where the case has an acceleration)",
    -1: "integral (a displacement where the case has a velocity, or a velocity where it has an acceleration)",
    1: "rate (a velocity where the case has a displacement, or an acceleration where it has a velocity)",
    2: "second rate (an acceleration where the case has a displacement)",
}
"""What a record is of the model's response, by the power of i omega between them."""


def faults_without_time(members: Sequence[Member], best: Estimate) -> list[str]:
    """Return sentences on records that are no histories and of which much is left; see the module."""
    found: list[str] = []
    doubtful = {series.label for series in best.noise.series if much_left(best, series)}
    fitted, first = _named(best)
    begin = 0
    for member in members:
        for record in member.records:
            rows = slice(begin, begin + len(record.observed))
            begin = rows.stop
            if isinstance(record, ResponseRecord):
                found += _of_response(member, record, fitted, first, much=record.name in doubtful)
            if isinstance(record, ModesRecord | StaticRecord):
                found += _of_units(record, member.predicted(record, first))
            if not doubtful & {record.name, f"{record.name}: frequencies"}:
                if isinstance(record, StaticRecord):
                    found += static_zero(record, best, rows)
                continue
            if isinstance(record, ModesRecord):
                found += _of_modes(record, [member.compared(record, named) for named in (fitted, first)])
            elif isinstance(record, StaticRecord):
                said = list(_of_loads(record, member.predicted(record, fitted)))
                found += said or static_zero(record, best, rows)
    return found + list(static_loops(members, best))


def of_another_kind(members: Sequence[Member], best: Estimate) -> bool:
    """Return whether a response is an integral or a rate of what the model has, to which no search leads."""
    fitted, first = _named(best)
    return any(
        _nearest(_distances(member, record, [fitted, first])[0])[0] != 0
        for member in members
        for record in member.records
        if isinstance(record, ResponseRecord)
    )


def _named(best: Estimate) -> list[dict[str, float]]:
    """Return all unknowns by name: as they were fitted, and at the start."""
    unknowns = best.unknowns
    return [
        dict(zip(unknowns.names, map(float, values), strict=True))
        for values in (best.values, unknowns.values(unknowns.start))
    ]


def _of_response(
    member: Member,
    record: ResponseRecord,
    fitted: Mapping[str, float],
    first: Mapping[str, float],
    *,
    much: bool,
) -> Iterator[str]:
    """Compare a response with the model's: its sense of rotation, its kind and size, or an unknown gain or delay."""
    measured, count = record.values, len(record.frequencies)
    round_about = _area(measured)
    for named in (fitted, first) if much else (fitted,):
        values = member.predicted(record, named)
        model = values[:count] + 1j * values[count:]
        if not model.any():
            continue
        # what dissipates goes round clockwise; a fit that finds the opposite ends without damping
        if round_about * _area(model) < -(LOOP**2) or (round_about > LOOP and abs(_area(model)) < LOOP):
            yield _conjugate(record)
            return
        if not much:
            yield from _of_path(record, model)
            return
    yield from _kind_told(record.name, *_distances(member, record, [fitted, first]))


def _distances(
    member: Member, record: ResponseRecord, states: Sequence[Mapping[str, float]]
) -> tuple[dict[tuple[int, int], float], float]:
    """Return how far a response is from the model's, by power of i omega and sign, and its size over the model's.

    The start of the search is compared too: a search for a wrong kind ends far off. Medians over the frequencies, as
    peaks may be elsewhere.
    """
    measured, omega = record.values, 2.0 * np.pi * record.frequencies
    count, size = len(measured), 1.0
    good = (omega > 0.0) & (np.abs(measured) > 0.0) & _above_noise(record)
    told: dict[tuple[int, int], float] = {}
    for named in states:
        values = member.predicted(record, named)
        model = values[:count] + 1j * values[count:]
        if not (good & (np.abs(model) > 0.0)).any():
            continue
        for moved in _with_its_peaks(record.frequencies, model, np.where(good, np.abs(measured), 0.0)):
            both = good & (np.abs(moved) > 0.0)
            ratio = np.log(measured[both] / moved[both])
            for power in (-2, -1, 0, 1, 2):
                turned = ratio - power * np.log(1j * omega[both])
                for sign in (1, -1):
                    off = _distance(turned - (0.0 if sign > 0 else 1j * np.pi))
                    told[power, sign] = min(off, told.get((power, sign), np.inf))
            level = float(np.median(ratio.real))
            scaled = _distance(ratio - level)
            if scaled < ALIKE and abs(level) > BETTER * max(scaled, 0.5 * ALIKE):
                size = float(np.exp(level))
    return told, size


def _nearest(told: Mapping[tuple[int, int], float]) -> tuple[int, int]:
    """Return the power and sign that a response is told by; (0, 1) where none is clearly nearer."""
    best = min(told, key=lambda key: told[key], default=(0, 1))
    return (0, 1) if best == (0, 1) or told[best] > min(ALIKE, told[0, 1] / BETTER) else best


def _kind_told(name: str, told: Mapping[tuple[int, int], float], size: float) -> Iterator[str]:
    """Say which derivative or integral of the model's response a record looks like, or how much larger it is.

    Args:
        told: distance from the model's response, by power of i omega and sign; size: over the model's.
    """
    power, sign = _nearest(told)
    if (power, sign) == (0, 1):
        if size != 1.0:
            yield (
                f"{name} is some {size:.3g} times the response of the model: look at its unit and at the size "
                "of the input, or give it unknown = ['gain']."
            )
        return
    other = ", with the opposite sign" if sign < 0 else ""
    if power:
        yield (
            f"{name} looks like the {KINDS[power]} of the model's response{other}: name that output in the case "
            "(ux a displacement, vx a velocity, ax an acceleration)."
        )
    else:
        yield f"{name} looks like the model's response{other}: turn the direction of its output or its input."


def _above_noise(record: ResponseRecord) -> np.ndarray:
    """Return where a response is above its noise, as it was told, or as neighbouring frequencies scatter.

    Second differences of white noise have six times its variance. All frequencies where few are above it.
    """
    values = record.values
    if record.noise is not None:
        size = np.asarray(record.noise)[: len(values)]
    else:
        second = np.diff(values, 2)
        parts = np.abs(np.concatenate([second.real, second.imag]))
        scatter = float(np.median(parts)) if len(parts) else 0.0
        size = np.full(len(values), MEDIAN_TO_DEVIATION * scatter / np.sqrt(6.0))
    above = np.abs(values) > CLEAR * size
    return above if np.count_nonzero(above) >= FEWEST_CLEAR else np.ones(len(values), dtype=bool)


def _with_its_peaks(frequencies: Floats, model: np.ndarray, size: Floats) -> Iterator[np.ndarray]:
    """Yield the response of a model, and with all its frequencies in another proportion: its peaks at those measured.

    A stiffness that is not known yet moves all peaks alike; beside a sharp peak nothing can be compared.

    Args:
        frequencies: Hz; model: its response; size: of what was measured, 0 where that is not known.
    """
    yield model
    there, here = (_largest_peaks(one) for one in (np.abs(model), size))
    for one in here:
        for other in there:
            part = frequencies[one] / frequencies[other]
            if one != other and 1.0 / MOST_MOVED < part < MOST_MOVED:
                at = frequencies / part
                yield np.interp(at, frequencies, model.real) + 1j * np.interp(at, frequencies, model.imag)


def _largest_peaks(size: Floats) -> Integers:
    """Return where the largest peaks are, at most three."""
    peaks, _ = find_peaks(size)
    found: Integers = peaks[np.argsort(-size[peaks])[:3]]
    return found


def _area(response: np.ndarray) -> float:
    """Return the area that a response goes round in the complex plane over its size; resonances go round clockwise."""
    about = response - response.mean()
    area = 0.5 * float(np.sum(np.imag(np.conj(about[:-1]) * about[1:])))
    return area / float(np.abs(about).max() or 1.0) ** 2


def _of_path(record: ResponseRecord, model: np.ndarray) -> Iterator[str]:
    """Tell whether an unknown gain or delay would explain most of what is left."""
    measured = record.values
    if len(measured) < LEAST:
        return
    known = {one.name for one in record.nuisances.values()}
    left = float(np.sum(np.abs(measured - model) ** 2))
    gain = float(np.sum(np.real(measured * np.conj(model)))) / float(np.sum(np.abs(model) ** 2) or 1.0)
    reach = 0.25 / float(np.diff(record.frequencies).min())
    turns = np.exp(-2j * np.pi * np.outer(np.linspace(-reach, reach, DELAYS), record.frequencies))
    others = {
        "gain": float(np.sum(np.abs(measured - gain * model) ** 2)),
        "conjugate": float(np.sum(np.abs(measured - np.conj(model)) ** 2)),
        "delay": float(np.min(np.sum(np.abs(measured - turns * model) ** 2, axis=1))),
    }
    shares = {name: 1.0 - other / max(left, 1e-300) for name, other in others.items() if name not in known}
    name = max(shares, key=lambda one: shares[one], default="")
    if name == "conjugate" and shares[name] > EXPLAINED:
        yield _conjugate(record)
    elif name and shares[name] > EXPLAINED:
        yield (
            f"{100.0 * shares[name]:.0f} % of what is left of {record.name} is what another {name} would leave: if it "
            f"may have one, give it unknown = ['{name}']."
        )


def _conjugate(record: ResponseRecord) -> str:
    return (
        f"{record.name} turns the other way in the complex plane than the model: it may be one of exp(-i omega t); "
        "give its conjugate."
    )


def _distance(logarithms: np.ndarray) -> float:
    """Return the median distance of complex logarithms from zero, angles within half a turn."""
    angle = np.angle(np.exp(1j * logarithms.imag))
    return float(np.median(np.hypot(logarithms.real, angle)))


def _of_modes(record: ModesRecord, results: Sequence[Any]) -> Iterator[str]:
    """Look for the modes of the model, fitted or as at the start, to which the frequencies are in one proportion."""
    mine = np.log(record.frequencies)
    for result in results:
        rigid = int(result.rigid)
        there = np.log(np.asarray(result.frequencies, dtype=float)[rigid:])
        if len(mine) < FEWEST or len(there) < len(mine):
            continue
        now = [place - rigid for place in record.places_in(result)]
        best, order = np.inf, now
        for level in (mine[:, None] - there).ravel():
            rows, columns = linear_sum_assignment((mine[:, None] - there - level) ** 2)
            scatter = float(np.std(mine[rows] - there[columns]))
            if scatter < best:
                best, order = scatter, columns.tolist()
        if order != now and best < min(MET, float(np.std(mine - there[now])) / SHARPER):
            names = ", ".join(str(result.names[rigid + k]) for k in order)
            yield (
                f"The frequencies of {record.name} are in the proportion of other modes than they were said to be: "
                f"{names}, to {100.0 * best:.1g} %. If one was missed or two were exchanged, give modes = "
                f"{[k + 1 for k in order]}."
            )
            return


def _of_units(record: ModesRecord | StaticRecord, predicted: Floats) -> Iterator[str]:
    """Compare sizes with the model as it was at the start: a modulus that is sought takes up any factor of a unit."""
    if isinstance(record, ModesRecord):
        count = len(record.frequencies)
        if "clock" in {one.name for one in record.nuisances.values()}:
            return
        ratios = np.log(record.frequencies / predicted[:count])
        ratio, listed = float(np.median(ratios)), FREQUENCY_UNITS
        if float(np.ptp(ratios)) > OF_UNIT:
            return
        what, verb, those = "The frequencies of", "are", "those"
    else:
        known = {one.name for one in record.nuisances.values()}
        ranges = float(np.ptp(record.values)), float(np.ptp(predicted))
        if "gain" in known or min(ranges) == 0.0:
            return
        ratio, listed = float(np.log(ranges[0] / ranges[1])), LOAD_UNITS
        what, verb, those = "The way in", "is", "that"
    for size, reason in listed.items():
        if abs(ratio - np.log(size)) < OF_UNIT:
            yield (
                f"{what} {record.name} {verb} {np.exp(ratio):.3g} times "
                f"{those} of the model as it was at the start: if that was not far off, {reason}."
            )
            return


def _of_loads(record: StaticRecord, predicted: Floats) -> Iterator[str]:
    about = f"{record.place}, {record.quantity}"
    ranges = float(np.ptp(record.values)), float(np.ptp(predicted))
    if min(ranges) == 0.0:
        who = "Nothing moves in" if ranges[0] == 0.0 else "The model does not move where there is"
        yield f"{who} {record.name} ({about}): is that its place and direction?"
    elif float(np.corrcoef(record.values, predicted)[0, 1]) < OPPOSITE:
        yield (
            f"{record.name} goes to the other side than the model ({about}): its direction, or that of the load, may "
            "be the opposite one."
        )
    elif not 1.0 / OTHER_SIZE < ranges[0] / ranges[1] < OTHER_SIZE:
        yield (
            f"{record.name} moves {ranges[0] / ranges[1]:.3g} times as far as the model ({about}): look at the units "
            "of its values and loads."
        )
