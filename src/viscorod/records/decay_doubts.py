"""What is doubtful about a free decay, in sentences."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from viscorod.records.clipping import clipped_samples
from viscorod.records.damped_sines import SineFit
from viscorod.records.dying_noise import dying_rate, said_of_window
from viscorod.records.motion_record import Record
from viscorod.results.text_numbers import per_cent
from viscorod.typing import Floats

__all__ = ["doubts", "half_power_width", "lasts"]

CYCLES = 3.0
"""Cycles below which a ratio rests on too little."""
PER_CYCLE = 5.0
"""Samples per cycle below which aliasing is spoken of."""
BINS = 2.0
"""Bins of the spectrum that a half-power width must have."""
CREEP = 0.02
"""Way of the rest over the first amplitude that is told."""
NEAR = 0.25
"""Relative distance of two frequencies that is called a beat."""
LEVEL, OTHER = 1e-3, 0.005
"""Probability below which numbers of the pieces are not one by chance, and the relative difference that is told."""
TIMES_FIRST = 3e-3
"""Relative distance from a whole multiple of the first frequency within which a faint mode may be its harmonic."""
FAINT = 0.2
"""Amplitude of a harmonic over that of the first mode at most."""
LASTING, MANY = 0.05, 20.0
"""Part by which a vibration dies out over the record, and its cycles, by which it is called a lasting one."""

SAME_RATE, TWICE, HEARD = 1.5, 2.0, 0.03
"""Ratio of rates below which modes of twice the frequency or more die out alike, and their size over the first."""
COMPUTED = 1e-6
"""What is left over the amplitude that is rounding or a step of a computed motion, and no noise."""
LASTING_AT_MOST = 0.3
"""The same by the upper end of its interval, where that has zero in it, too."""


def lasts(fit: SineFit) -> np.ndarray:
    """Return which modes (k,) do not die out within many cycles, as what something else drives."""
    span = float(fit.times[-1])
    many = np.abs(fit.poles.imag) * span / (2.0 * np.pi) > MANY
    lost = np.abs(fit.own_poles.real) * span
    lasting = many & (lost < LASTING)
    if (open_ones := many & ~lasting & (lost < LASTING_AT_MOST)).any():
        width = fit.half_widths(0.95)[1] * np.abs(fit.poles) * span
        lasting |= open_ones & (lost < width) & (lost + width < LASTING_AT_MOST)
    return np.asarray(lasting)


def doubts(
    record: Record, part: Record, fit: SineFit, order: np.ndarray, pieces: dict[str, Floats]
) -> list[str]:
    """Return what is doubtful, one sentence each; see `viscorod.decay`."""
    frequency, ratio = fit.frequencies[order], fit.ratios[order]
    span = float(fit.times[-1])
    first = float(frequency[0])
    unit = "" if record.name == "decay" else f" {record.unit}"
    found = []
    held = record.times[clipped_samples(record.values, len(part.times) / (span * first))]
    if len(held) and held[-1] < part.times[0]:
        or_held = ", or the rod held there," if held[0] == record.times[0] else ""
        found.append(
            f"the largest values come several times in a row: the record is clipped until {held[-1]:.4g} s{or_held} "
            f"and used from {part.times[0]:.4g} s on"
        )
    elif len(held):
        found.append(
            "the largest values come several times in a row: the record is clipped there; a range that is not reached "
            "is needed, or a later start"
        )
    if span * first < CYCLES:
        found.append(
            f"there are only {span * first:.2g} cycles: intervals are wide, and the rest is part of the fit"
        )
    rate = (len(fit.times) - 1) / span
    for f in frequency[rate / frequency < PER_CYCLE]:
        found.append(
            f"{f:.4g} Hz has {rate / f:.2g} samples per cycle: it may be an alias of {rate - f:.4g} or "
            f"{rate + f:.4g} Hz, unless a filter stood before the sampling"
        )
    way, size = float(np.ptp(fit.rest)), float(np.abs(fit.amplitudes[order[0]]))
    if way > CREEP * size:
        found.append(
            f"the rest moves by {way:.3g}{unit} meanwhile, {per_cent(100.0 * way / size)} of the first amplitude; it "
            "is fitted along"
        )
    for k in range(1, len(frequency)):
        gap = abs(frequency[k] - first)
        if gap < NEAR * first:
            found.append(
                f"modes at {first:.5g} and {frequency[k]:.5g} Hz beat with a period of {1.0 / gap:.3g} s: ratios read "
                "off maxima or an envelope would be wrong"
                + (
                    ""
                    if gap * span > 1.0
                    else ", and the record is shorter than that: the two are hard to tell apart"
                )
            )
    found += _harmonics(fit, order)
    found += _driven(fit, order)
    lasting = frequency[1:][lasts(fit)[order][1:]]
    if len(lasting):
        found.append(
            f"what swings at {', '.join(f'{one:.5g}' for one in lasting)} Hz does not die out: something else drives "
            "it, such as the mains, and it is no mode of the rod"
        )
    width = half_power_width(first, float(ratio[0]))
    bin_width = 1.0 / float(record.times[-1] - part.times[0])
    if width < BINS * bin_width:
        found.append(
            f"half-power: refused; the width of {width:.3g} Hz has {width / bin_width:.2g} bins of {bin_width:.3g} Hz, "
            "and would be that of the bins"
        )
    windowed = _windowed(fit, order)
    if not fit.is_white and not any("noise dies out" in one for one in windowed):
        found.append(
            f"the residual of {fit.noise:.3g}{unit} is not white noise (its samples are correlated): the noise is "
            "coloured, which the intervals account for, or damped sines with constant ratios leave something over, "
            "which they do not"
        )
    found += windowed
    found += _trend(pieces, "ratio", "damping ratio", "")
    found += _trend(pieces, "frequency", "frequency", " Hz")
    return found


def _harmonics(fit: SineFit, order: np.ndarray) -> list[str]:
    """Return a sentence on faint modes at whole multiples of the first, if what is left over is no white noise."""
    frequency, size = fit.frequencies[order], np.abs(fit.amplitudes[order])
    times = np.round(frequency / frequency[0])
    near = np.abs(frequency / np.maximum(times, 1.0) / frequency[0] - 1.0) < TIMES_FIRST
    which = np.flatnonzero(near & (times > 1.0) & (size < FAINT * size[0]))
    if fit.is_white or not len(which):
        return []
    listed = ", ".join(f"{frequency[k]:.5g} Hz ({times[k]:.0f} times)" for k in which)
    return [
        f"{listed} may be harmonics of {frequency[0]:.5g} Hz and no modes: clipping, a sensor that is not linear, or a "
        "motion that is not, make such, and so does the size of what swings (a magnitude, of twice its frequency)"
    ]


def _driven(fit: SineFit, order: np.ndarray) -> list[str]:
    """Return a sentence if the strongest mode grows, or does not die out over many cycles."""
    first = int(order[0])
    ratio, hertz = float(fit.ratios[first]), float(fit.frequencies[first])
    if ratio < 0.0 and ratio + float(fit.half_widths(0.95)[1][first]) < 0.0:
        return [f"{hertz:.4g} Hz grows meanwhile: something drives it, and this is no free decay"]
    if lasts(fit)[first]:
        return [
            f"{hertz:.4g} Hz hardly dies out meanwhile: where something drives it this is no free decay, and the ratio "
            "none of the rod; else a longer record tells more"
        ]
    return []


def _windowed(fit: SineFit, order: np.ndarray) -> list[str]:
    """Return a sentence where noise, or all modes, die out as an exponential window makes them, and none is told."""
    if fit.weighed:
        return []
    rates = -fit.poles.real[order]
    noisy = fit.noise > COMPUTED * float(np.abs(fit.amplitudes).max())
    dying = dying_rate(fit.times, fit.residual) if noisy else None
    if dying is not None:
        return [
            f"the noise {said_of_window(dying, float(rates[0]), 'if there was one, give its window_time')}"
        ]
    free = ~lasts(fit)[order] & (np.abs(fit.amplitudes[order]) > HEARD * np.abs(fit.amplitudes[order[0]]))
    frequency, rates = fit.frequencies[order][free], rates[free]
    if len(rates) < 2 or frequency.max() < TWICE * frequency.min():
        return []
    if 0.0 < rates.max() < SAME_RATE * rates.min() and rates.min() * float(fit.times[-1]) > 1.0:
        return [
            f"all modes die out at nearly the same rate, {rates.min():.3g} to {rates.max():.3g} 1/s, as an exponential "
            f"window with a time constant of {1.0 / rates.min():.3g} s or a little more makes them: if the record was "
            "weighed by one, give its window_time, else something outside damps"
        ]
    return []


def half_power_width(frequency: float, ratio: float) -> float:
    """Return the width of a resonance at half the power, Hz."""
    return 2.0 * abs(ratio) * frequency


def _trend(pieces: dict[str, Floats], name: str, words: str, unit: str) -> list[str]:
    """Return a sentence if the ratios or the frequencies of the pieces are not one number."""
    values, width = pieces[name], pieces[f"{name}_width"] / 1.96
    if len(values) < 3:
        return []
    weight = 1.0 / np.maximum(width, 1e-300) ** 2
    mean = float(np.sum(weight * values) / np.sum(weight))
    if chi2.sf(float(np.sum(weight * (values - mean) ** 2)), len(values) - 1) > LEVEL:
        return []
    # those two that are farthest apart for their doubt: the last ones are the least certain
    apart = np.abs(values[:, None] - values) / np.hypot(width[:, None], width)
    first, last = np.unravel_index(int(np.argmax(np.triu(apart))), apart.shape)
    if abs(values[first] - values[last]) < OTHER * abs(mean):
        return []
    amplitude = pieces["amplitude"]
    return [
        f"the {words} is not one number: {values[first]:.4g}{unit} at the amplitude {amplitude[first]:.3g}, "
        f"{values[last]:.4g}{unit} at {amplitude[last]:.3g}; take that of the amplitude in question"
    ]
