"""How many damped sines a record has, about which rest: fits by Bayes' criterion."""

from __future__ import annotations

import numpy as np

from viscorod.records.coarse_samples import Coarse
from viscorod.records.damped_sines import SineFit, fit_sines, pencil_poles, residual_peak
from viscorod.typing import Floats

__all__ = ["MOST_MODES", "best_fit"]

MOST_MODES = 6
BETTER = 10.0
"""Fall of Bayes' criterion from which on another number of modes, or another polynomial of the rest, is taken."""
WITHIN_A_BEAT = 1.5
"""Periods of a beat in a record up to which two modes on either side of a third may be how that one dies out."""
FAINT = 1e-7
"""Part of all energy below which a mode is what rounding and interpolation left."""


def best_fit(times: Floats, values: Floats, modes: int | None) -> SineFit | None:
    """Return the fit with the number of modes and the rest that Bayes' criterion prefers.

    Of long records both are chosen by means over blocks of samples, which have the same poles; the fit is one of all
    samples.
    """
    coarse = Coarse.of(times, values)
    while coarse is not None:
        chosen = _chosen(coarse.times, coarse.values, modes)
        fit = None if chosen is None else fit_sines(times, values, chosen.poles, chosen.resting)
        if fit is None or not (modes is not None or _sensible(fit, 0.0)):
            break
        finer = coarse.for_what_is_left(fit)
        if finer is coarse:
            return fit
        coarse = finer
    return _chosen(times, values, modes)


def _chosen(times: Floats, values: Floats, modes: int | None) -> SineFit | None:
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
    return best if best is None or modes is not None else _without_sides(times, values, best)


def _without_sides(times: Floats, values: Floats, fit: SineFit) -> SineFit:
    """Return the fit without pairs of modes as far on either side of the strongest that the record ends before a beat.

    They are how the amplitude of one mode falls that has no constant ratio, such as under dry friction, and what is
    told of its ratio by amplitude must not be without them.
    """
    first = int(np.argmax([float(np.sum(fit.mode(k) ** 2)) for k in range(len(fit.poles))]))
    hertz, width = fit.frequencies, fit.half_widths(0.95)[0]
    off = hertz - hertz[first]
    near = np.flatnonzero((off != 0.0) & (np.abs(off) * fit.times[-1] < WITHIN_A_BEAT))
    sides = {
        int(k)
        for low in near[off[near] < 0.0]
        for high in near[off[near] > 0.0]
        if abs(off[low] + off[high]) < width[low] + width[high] + 2.0 * width[first]
        for k in (low, high)
    }
    if not sides:
        return fit
    kept = np.delete(fit.poles, sorted(sides))
    return fit_sines(times, values, kept, fit.resting) or fit


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
        fewer = _chosen(times, values, count - 1)
        if fewer is not None:
            starts.append(np.append(fewer.poles, residual_peak(times, fewer.residual)))
    return starts


def _fit(times: Floats, values: Floats, poles: np.ndarray) -> SineFit | None:
    """Return the fit with the rest that Bayes' criterion prefers."""
    best: SineFit | None = None
    for rest in ("constant", "sloping", "relaxing", "curved"):
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
    if len(fit.poles) > 1 and ordered[0].imag * fit.times[-1] < 2.0 * np.pi:
        return False  # less than one cycle is the rest
    nyquist = np.pi * (len(fit.times) - 1) / float(fit.times[-1])
    for k, pole in enumerate(fit.poles):
        energy = float(np.sum(fit.mode(k) ** 2))
        if energy < max(25.0 * fit.noise**2, least) or pole.imag > nyquist or pole.real * fit.times[-1] > 0.5:
            return False
        if -pole.real > 0.7 * abs(pole):  # no swing: what creeps, or what the release left
            return False
    return True
