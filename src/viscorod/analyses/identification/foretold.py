"""What laws foretell of records that were left out: frequency and damping ratio of free decays.

A law that was fitted to other records says how a record swings and dies out before anybody has looked at it. Of what is
not known of the measurement only that is fitted to the record of which nothing was believed beforehand; numbers of a
case with a belief stay where they were believed, and its deviation is in the interval.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy import stats

from viscorod.analyses.identification.case_numbers import number_at
from viscorod.analyses.identification.members import Member
from viscorod.errors import InputError
from viscorod.records.free_decay import decay
from viscorod.records.motion_record import Record
from viscorod.results.decay_result import Decay
from viscorod.results.identified import Foretold
from viscorod.solve.estimation.intervals import Covariance

if TYPE_CHECKING:
    from viscorod.analyses.identification.search import Fitted

__all__ = ["Swing", "amplitude_sentences", "foretold", "foretold_sentences", "swings_of", "unlike"]

STEP = 0.02
"""Largest change of a logarithm, or of a number over its scale, by which a foretold decay is differentiated."""
RISES, WIDTHS = 1.2, 1.5
"""Ratio of the damping ratios at the ends of a decay, and their difference over both intervals, from which on the
ratio depends on the amplitude."""
MOVES = 0.01
"""Part by which the frequencies at the ends of a decay must differ for it not to be one number."""
MISSES = 0.1
"""Part of a damping ratio that a law may miss and not be excluded: the branches of a flat loss ripple by half of it."""
BOTH_SIDES = 0.95
MOSTLY = 0.5
"""Part of the square of an interval from which on it rests on what was believed."""


@dataclass(frozen=True, eq=False)
class Swing:
    """A record that is a free decay, and what it shows by itself.

    Attributes:
        record: of it; decay: taken apart; case: number of the case that it belongs to, the same of repeats.
    """

    record: Record
    decay: Decay
    case: int = 0

    @property
    def frequency(self) -> tuple[float, float]:
        """Natural frequency of the strongest mode, Hz, and half of its interval."""
        return self._number("frequency"), self._number("frequency_width")

    @property
    def ratio(self) -> tuple[float, float]:
        """Damping ratio of the strongest mode, and half of its interval."""
        return self._number("damping_ratio"), self._number("damping_ratio_width")

    @property
    def reach(self) -> tuple[float, float]:
        """Least and largest damping ratio that the record shows, at any amplitude, with their intervals."""
        centre, width = self.ratio
        ratios, widths = (
            np.append(self.decay.data[name].values, one)
            for name, one in (("piece_ratio", centre), ("piece_ratio_width", width))
        )
        return float((ratios - widths).min()), float((ratios + widths).max())

    @property
    def ends(self) -> tuple[float, float, float, float] | None:
        """Largest amplitude with the ratio there, and least; None unless the ratio is another there."""
        amplitude, ratio, width = (
            self.decay.data[f"piece_{name}"].values for name in ("amplitude", "ratio", "ratio_width")
        )
        if len(ratio) < 2:
            return None
        apart = abs(ratio[-1] - ratio[0])
        low, high = sorted((abs(float(ratio[0])), abs(float(ratio[-1]))))
        if apart <= WIDTHS * (width[0] + width[-1]) or high <= RISES * low:
            return None
        return float(amplitude[0]), float(ratio[0]), float(amplitude[-1]), float(ratio[-1])

    @property
    def frequency_ends(self) -> tuple[float, float, float, float] | None:
        """Largest amplitude with the frequency there, Hz, and least; None unless it is another there."""
        amplitude, hertz, width = (
            self.decay.data[f"piece_{name}"].values for name in ("amplitude", "frequency", "frequency_width")
        )
        if len(hertz) < 2:
            return None
        apart = abs(hertz[-1] - hertz[0])
        if apart <= max(WIDTHS * (width[0] + width[-1]), MOVES * hertz[0]):
            return None
        return float(amplitude[0]), float(hertz[0]), float(amplitude[-1]), float(hertz[-1])

    def _number(self, name: str) -> float:
        return float(self.decay.data[name].values[0])


def swings_of(pairs: Sequence[tuple[Any, Any]]) -> dict[str, Swing]:
    """Return by name those records of pairs (case, record) that are free decays."""
    cases: list[Any] = []
    found = {}
    for case, record in pairs:
        if not any(case is one for one in cases):
            cases.append(case)
        number = next(k for k, one in enumerate(cases) if one is case)
        if not isinstance(record, Record):
            continue
        try:
            found[record.name] = Swing(record, decay(record), number)
        except InputError:  # it does not swing about a rest, or not long enough
            continue
    return found


def foretold(
    law: str, found: Fitted, known: Covariance, held: Fitted, swings: Mapping[str, Swing]
) -> list[Foretold]:
    """Return what a law says of the records that are free decays.

    Args:
        law: its name; found: fitted to other records; known: what is known of its numbers.
        held: the records left out, with what is not known of their measurement.
        swings: what they show.
    """
    out = []
    for member in held.members:
        for record in member.records:
            if record.name not in swings:
                continue
            one = _one(law, found, known, member, {**held.named}, swings[record.name])
            if one is not None:
                out.append(one)
    return out


def _one(
    law: str,
    found: Fitted,
    known: Covariance,
    member: Member,
    named: dict[str, float],
    swing: Swing,
) -> Foretold | None:
    """Return what a law says of one record; None where the data do not tell it, or the record does not swing."""
    believed = {
        full: one
        for full, one in swing.record.nuisances.items()
        if one.key is not None and np.isfinite(one.deviation)
    }
    named |= {full: _believed(member, one) for full, one in believed.items()}
    centre = _swing(member, swing, named)
    slopes = None if centre is None else _slopes(found, known, member, named, swing, centre)
    if centre is None or slopes is None:
        return None
    square = np.zeros(2)
    for column, slope in enumerate(slopes.T):
        if slope.any():
            quantile = float(stats.t.ppf(0.5 + 0.5 * BOTH_SIDES, known.freedom_of(slope)))
            square[column] = (quantile * known.deviation(slope)) ** 2
    reach = float(stats.norm.ppf(0.5 + 0.5 * BOTH_SIDES))
    rests_on, most = "", 0.0
    for full, belief in believed.items():
        change = _change_by(belief.deviation, full, member, named, swing, centre)
        if change is None:
            return None
        square += (reach * change) ** 2
        if abs(change[0]) > most:
            most = float(abs(change[0]))
            rests_on = (
                f"what was believed of {full} ({named[full]:.4g} +- {belief.deviation:.2g} in SI): one such deviation "
                f"is {most:.2g} Hz"
            )
    widths = np.sqrt(square)
    (hertz, hertz_width), (ratio, ratio_width) = swing.frequency, swing.ratio
    return Foretold(
        law=law,
        record=swing.record.name,
        frequency=float(centre[0]),
        frequency_width=float(widths[0]),
        damping_ratio=float(centre[1]),
        damping_ratio_width=float(widths[1]),
        measured_frequency=hertz,
        measured_frequency_width=hertz_width,
        measured_ratio=ratio,
        measured_ratio_width=ratio_width,
        rests_on=rests_on if (reach * most) ** 2 > MOSTLY * square[0] else "",
    )


def _slopes(
    found: Fitted,
    known: Covariance,
    member: Member,
    named: dict[str, float],
    swing: Swing,
    centre: np.ndarray,
) -> np.ndarray | None:
    """Return the derivatives of frequency and ratio by the fitted numbers ``(k, 2)``; None if data do not tell them."""
    unknowns, z = found.unknowns, found.estimate.z
    slopes = np.zeros((len(z), 2))
    for k, one in enumerate(unknowns):
        if one.nuisance or member.key_of(one.name) is None:
            continue
        step = float(np.clip(known.deviations[k], 1e-3, STEP))
        value = float(unknowns.values(z + step * np.eye(len(z))[k])[k])
        beside = _swing(member, swing, {**named, one.name: value})
        if beside is None:
            return None
        slopes[k] = (beside - centre) / step
    told = all(known.told(row) for row in slopes.T if np.linalg.norm(row) > 0.0)
    return slopes if told else None


def _change_by(
    deviation: float, name: str, member: Member, named: dict[str, float], swing: Swing, centre: np.ndarray
) -> np.ndarray | None:
    """Return by how much frequency and ratio change with one standard deviation of what is believed of a number."""
    beside = _swing(member, swing, {**named, name: named[name] + 0.5 * deviation})
    change: np.ndarray | None = None if beside is None else 2.0 * (beside - centre)
    return change


def _believed(member: Member, one: Any) -> float:
    if one.start is not None:
        return float(one.start)
    return float(number_at(member.case, one.key) or 0.0)


def _swing(member: Member, swing: Swing, named: Mapping[str, float]) -> np.ndarray | None:
    """Return frequency and damping ratio of what a case says of a record, in the time in which it is a decay."""
    record, times = swing.record, swing.decay.data["time"].values
    whole = member.predicted(record, named)
    begin = int(np.searchsorted(record.times, times[0]))
    try:
        found = decay(
            times, whole[begin : begin + len(times)], start=float(times[0]), end=float(times[-1]), modes=1
        )
    except InputError:
        return None
    return np.array([found.frequencies[0], found.damping_ratios[0]])


def unlike(told: Sequence[Foretold], swings: Mapping[str, Swing]) -> dict[str, tuple[float, float, float]]:
    """Return by law those whose damping ratio is none that any repeat shows: theirs, and least and largest measured.

    What is between law and measurement must be more than the scatter of the repeats (or the interval of a single
    record) and the interval of the law.
    """
    found: dict[str, tuple[float, float, float]] = {}
    for one in told:
        alike = [swing for swing in swings.values() if swing.case == swings[one.record].case]
        ends = [end for swing in alike for end in swing.reach]
        whole = [swing.ratio[0] for swing in alike]
        scatter = max(max(whole) - min(whole), *(swing.ratio[1] for swing in alike))
        gap = max(min(ends) - one.damping_ratio, one.damping_ratio - max(ends))
        least = max(scatter + one.damping_ratio_width, MISSES * max(whole))
        if gap > least and one.law not in found:
            found[one.law] = one.damping_ratio, min(ends), max(ends)
    return found


def foretold_sentences(
    told: Sequence[Foretold], apart: Mapping[str, tuple[float, float, float]], best: str
) -> list[str]:
    """Return in words which laws the records left out exclude, and how near the best one comes."""
    out = []
    for law, (ratio, low, high) in apart.items():
        names = ", ".join(one.record for one in told if one.law == law)
        out.append(
            f"Excluded by what was left out: {law}. It foretells a damping ratio of {ratio:.3g} for {names}, and "
            f"{max(low, 0.0):.3g} to {high:.3g} was measured."
        )
    mine = [one for one in told if one.law == best]
    for one in mine:
        off = 100.0 * (one.frequency / one.measured_frequency - 1.0)
        out.append(
            f"{best} foretells {one.frequency:.4g} +- {one.frequency_width:.2g} Hz and a damping ratio of "
            f"{one.damping_ratio:.3g} +- {one.damping_ratio_width:.2g} for {one.record}; measured: "
            f"{one.measured_frequency:.4g} +- {one.measured_frequency_width:.2g} Hz ({off:+.2g} % from it to what was "
            f"foretold) and {one.measured_ratio:.3g} +- {one.measured_ratio_width:.2g}. " + _told_apart(one)
        )
    ratios = [one.measured_ratio for one in mine]
    if len(mine) > 1:
        out.append(
            f"Damping ratios of what was left out scatter by {max(ratios) - min(ratios):.2g} between records."
        )
    return out


def _told_apart(one: Foretold) -> str:
    """Return in words whether the frequencies differ by more than is known of them, and what would have to be known."""
    within = abs(one.frequency - one.measured_frequency) <= np.hypot(
        one.frequency_width, one.measured_frequency_width
    )
    text = f"The frequencies differ by {'no ' if within else ''}more than these intervals"
    if not one.rests_on:
        return f"{text}."
    return (
        f"{text}; that of what was foretold rests on {one.rests_on}. Measure it better to foretell it better."
    )


def amplitude_sentences(fitted: Mapping[str, Swing], left_out: Mapping[str, Swing], best: str) -> list[str]:
    """Return in words whose damping ratios and frequencies depend on the amplitude, which no law here has."""
    out = []
    for name, swing in left_out.items():
        if (ends := swing.frequency_ends) is not None:
            large, at_large, small, at_small = ends
            unit = swing.record.unit
            out.append(
                f"The frequency of {name} goes from {at_large:.4g} Hz at an amplitude of {large:.2g} {unit} to "
                f"{at_small:.4g} Hz at {small:.2g} {unit} ({100.0 * (at_small / at_large - 1.0):+.2g} %): as one "
                "number it is known no better than that, nor is what was foretold beside it."
            )
    steady = [name for name, swing in fitted.items() if swing.ends is None]
    for name, swing in {**fitted, **left_out}.items():
        if (ends := swing.ends) is None:
            continue
        large, at_large, small, at_small = ends
        way = "rises" if at_small > at_large else "falls"
        unit = swing.record.unit
        text = (
            f"The damping ratio of {name} {way} from {at_large:.3g} at an amplitude of {large:.2g} {unit} to "
            f"{at_small:.3g} at {small:.2g} {unit}"
        )
        if name in left_out and steady:
            text += f"; that of {' and '.join(steady)}, which {best} was fitted to, does not"
        text += (
            ". None of these laws depends on the amplitude: this is not called the material's. Look at clamps, joints, "
            "and at what hangs on the model."
        )
        out.append(text)
    return out
