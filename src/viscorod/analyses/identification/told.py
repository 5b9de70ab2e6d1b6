"""What a fit says in words: which unknowns it cannot tell apart, and what the residuals show."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from viscorod.analyses.identification.named_combinations import Combination
from viscorod.records.stray_samples import dropouts, spikes
from viscorod.results.text_numbers import scaled
from viscorod.solve.estimation.intervals import Covariance, Interval
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.solve.estimation.noise import LEAST_OWN, Series, ljung_box, neighbours_alike
from viscorod.typing import Floats

__all__ = [
    "CORRELATED",
    "at_signal",
    "missed",
    "much_left",
    "number_text",
    "sentences_of",
    "value_text",
    "whiteness",
]

CORRELATED = 0.01
"""Probability of such an autocorrelation below which residuals are called correlated."""
LEFT, LEFT_OF_FREQUENCIES = 0.3, 0.05
"""Part of the spread of values without a time, and of natural frequencies, that may be left before the model is said to
miss something, whatever their neighbours show."""
LARGER = 2.0
"""Times the noise that was told by which residuals must be larger to be called a miss of the model."""
PARTS = 0.15
"""Part of an unknown in a direction from which on it is named."""
UNSETTLED = (
    "The search did not come to rest: another step would move the numbers by {:.2g} standard errors. Start it nearer, "
    "give starts = 5, or seek fewer numbers."
)
SIGNAL, MISSED = 0.25, 0.2
"""Relative width of the band about the frequency of a record, and the part of the residuals' power there, above
what noise of its colour would have, from which on the model misses part of the motion."""
SPARSE = 20
"""Times as many places of samples as there are samples beyond which gaps leave no spectrum."""


def whiteness(best: Estimate) -> list[float]:
    """Return of every series the probability of such an autocorrelation of its raw residuals; 1 where it has none.

    Of responses, moduli, static loads and histories that are not evenly spaced it is that of neighbours.
    """
    found = []
    for series in best.noise.series:
        part = (best.measured - best.predicted)[series.rows] / series.noise
        if series.curves:
            found.append(neighbours_alike(part, series.curves))
        else:
            found.append(ljung_box(part)[1] if series.regular and series.count >= 20 else 1.0)
    return found


def at_signal(best: Estimate) -> list[float]:
    """Return of every history the part of the residuals' power that lies at the frequency of the record."""
    return [_at_signal(best, series) for series in best.noise.series]


def _at_signal(best: Estimate, series: Series) -> float:
    """Return that part of one series; samples that are missing add nothing to a spectrum."""
    if series.count < 20 or not (series.regular or series.times is not None):
        return 0.0
    measured, residual = best.measured[series.rows], best.residuals[series.rows]
    places = np.arange(series.count)
    if series.times is not None:
        places = np.rint((series.times - series.times[0]) / np.median(np.diff(series.times))).astype(int)
        if places[-1] > SPARSE * series.count:
            return 1.0  # nearly all are missing: nothing is told
    window = np.hanning(places[-1] + 1)
    signal, left = (_power(x - x.mean(), places, window) for x in (measured, residual))
    signal[0] = 0.0
    top = int(np.argmax(signal))
    reach = max(int(np.ceil(SIGNAL * top)), 2)
    band = slice(max(top - reach, 1), top + reach + 1)
    return float(left[band].sum() / max(left[1:].sum(), 1e-300))


def _power(values: Floats, places: np.ndarray, window: Floats) -> Floats:
    even = np.zeros(len(window))
    even[places] = values
    return np.asarray(np.abs(np.fft.rfft(even * window)) ** 2)


def missed(best: Estimate, *, moved: bool = False) -> list[str]:
    """Return the series of which the model misses part, so that intervals do not hold for what it leaves out.

    Residuals are correlated and lie at the frequency of the record, or they are larger than the noise that was told; of
    values without a time much is left, or neighbours go together, which no interval allows for. Where the colour of the
    noise has `moved` the numbers, all that is correlated counts.
    """
    listed = zip(best.noise.series, best.noise.found, whiteness(best), at_signal(best), strict=True)
    return [
        series.label
        for series, noise, probability, share in listed
        if not series.certain
        and (
            much_left(best, series)
            or (
                probability < CORRELATED
                and (
                    bool(series.curves) or moved or share > MISSED or (series.told and noise.factor > LARGER)
                )
            )
        )
    ]


def much_left(best: Estimate, series: Series) -> bool:
    """Return whether much is left of values without a time, over the noise that was told or their own spread.

    Of histories with gaps as much at the frequency of the record: noise is no miss of the model, however large.
    """
    if series.regular or series.certain:
        return False
    left = float(np.sqrt(np.mean((best.residuals[series.rows] / series.noise) ** 2)))
    most = LARGER if series.told else LEFT_OF_FREQUENCIES if series.group == "frequencies" else LEFT
    return left > most and (series.times is None or series.count < 20 or _at_signal(best, series) > MISSED)


def sentences_of(
    best: Estimate,
    known: Covariance,
    limits: Sequence[Interval],
    told: Sequence[Combination],
    units: Mapping[str, str],
) -> list[str]:
    """Return what the fit says in words, what matters most first.

    Args:
        best: the estimate; known: its covariance; limits: intervals of the unknowns.
        told: what the data tell of several together.
        units: of the unknowns by name, SI.
    """
    names = best.unknowns.names
    found: list[str] = [UNSETTLED.format(best.unsettled)] if best.unsettled else []
    named: list[set[str]] = []
    for direction in known.unseen:
        parts = [names[k] for k in np.argsort(-np.abs(direction)) if abs(direction[k]) > PARTS]
        if set(parts) in named:
            continue
        named.append(set(parts))
        if len(parts) == 1:
            found.append(f"The data do not tell {parts[0]}: the predictions hardly depend on it.")
            continue
        mine = [names.index(part) for part in parts]
        better = [one for one in told if sum(abs(one.powers[k]) > 1e-3 for k in mine) > 1]
        tells = "; ".join(
            f"the {one.name} can: {number_text(one.value, one.low, one.high, one.unit)}" for one in better[:3]
        )
        joined = " and ".join([", ".join(parts[:-1]), parts[-1]])
        found.append(f"{joined} cannot be separated{'; ' + tells if tells else ''}.")
    bounds = best.unknowns.bounds
    for k, (unknown, limit) in enumerate(zip(best.unknowns, limits, strict=True)):
        low, high = bounds[0][k], bounds[1][k]
        if np.isfinite(high - low) and min(best.z[k] - low, high - best.z[k]) < 1e-6 * (high - low):
            end = unknown.low if best.z[k] - low < high - best.z[k] else unknown.high
            text = value_text(end, units.get(unknown.name, ""))
            found.append(f"{unknown.name} is at its bound {text}: the data want it beyond.")
        elif not limit.told and known.told(np.eye(len(names))[k]):
            open_end = "above" if np.isfinite(limit.low) and limit.low > 0.0 else "below"
            found.append(f"Nothing limits {unknown.name} from {open_end}.")
    return found + _of_residuals(best)


def _of_residuals(best: Estimate) -> list[str]:
    found = []
    of_these = missed(best)
    probabilities = whiteness(best)
    shares = at_signal(best)
    for series, noise, probability, share in zip(
        best.noise.series, best.noise.found, probabilities, shares, strict=True
    ):
        if series.certain:
            continue
        strays = _strays(best, series) if noise.weights is None else 0
        if strays:
            found.append(
                f"{strays} sample{' of ' if strays == 1 else 's of '}{series.label} "
                f"{'stands' if strays == 1 else 'stand'} far off the others (spikes, or dropouts): leave them out, or "
                "give robust = true."
            )
        larger = series.told and noise.factor > LARGER
        level = f"{noise.factor:.3g} times the noise that was told" if larger else ""
        if probability < CORRELATED and series.curves:
            found.append(
                f"What is left of {series.label} goes together from one point to the next (p = {probability:.1g} if it "
                f"were noise){' and is ' + level if level else ''}: the model misses something of it. The intervals do "
                "not hold for that."
            )
        elif probability < CORRELATED:
            text = (
                f"What is left of {series.label} is correlated in time (p = {probability:.1g} if it were not)"
            )
            if series.label in of_these:
                text += f", {100.0 * share:.0f} % of its power at the frequency of the record"
                text += f" and {level}" if larger else ""
                text += ": the model misses part of the motion. The intervals allow for it as if it were noise; they "
                text += "do not hold for what the model leaves out."
            else:
                text += "; the intervals allow for it."
            found.append(text)
        elif larger or series.label in of_these:
            part = float(np.sqrt(np.mean((best.residuals[series.rows] / series.noise) ** 2)))
            level = (
                level or f"{_percent(part)} % of {'it' if series.group == 'frequencies' else 'its spread'}"
            )
            found.append(
                f"What is left of {series.label} is {level}: the model misses something, or the noise is larger."
            )
    return found


def _strays(best: Estimate, series: Series) -> int:
    """Return how many residuals of a history are no part of its motion or its noise."""
    if not series.regular or series.count < LEAST_OWN:
        return 0
    residual, size = best.residuals[series.rows], float(np.ptp(best.predicted[series.rows]))
    return int(np.count_nonzero(spikes(residual, size) | dropouts(residual, size)))


def _percent(part: float) -> str:
    """Return a part in percent, to two digits, without powers of ten."""
    return f"{100.0 * part:.2g}" if part < 0.995 else f"{100.0 * part:.0f}"


def value_text(value: float, unit: str) -> str:
    """Return a number with its unit, in the prefix in which a person reads it: "1 MPa"."""
    factor, shown = scaled(unit, [value]) if unit not in ("", "1") else (1.0, "")
    return f"{factor * value:.6g} {shown}".rstrip()


def number_text(value: float, low: float, high: float, unit: str = "") -> str:
    """Return a number with its interval: "0.0204 +- 0.0003 s", or with both ends where they are not alike."""
    factor, shown = scaled(unit, [value]) if unit not in ("", "1") else (1.0, "")
    value, low, high = factor * value, factor * low, factor * high
    unit = f" {shown}" if shown else ""
    if not np.isfinite(low) or not np.isfinite(high):
        return f"{value:.4g}{unit} ({low:.4g} to {high:.4g})"
    below, above = value - low, high - value
    if below > 0.0 and above > 0.0 and 0.8 < above / below < 1.25:
        half = 0.5 * (below + above)
        digits = max(0, 1 - int(np.floor(np.log10(half / abs(value))))) if value else 2
        return f"{value:.{min(max(digits + 1, 3), 10)}g} +- {half:.2g}{unit}"
    return f"{value:.4g}{unit} ({low:.4g} to {high:.4g})"
