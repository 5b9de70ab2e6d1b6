"""What is doubtful about a free decay, in sentences."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2

from viscorod.records.damped_sines import SineFit
from viscorod.records.motion_record import Record
from viscorod.results.text_numbers import per_cent
from viscorod.typing import Floats

__all__ = ["clipped_samples", "doubts", "half_power_width", "lasts"]

CYCLES = 3.0
"""Cycles below which a ratio rests on too little."""
PER_CYCLE = 5.0
"""Samples per cycle below which aliasing is spoken of."""
RUN = 3
"""Equal samples at an extreme that mean clipping."""
BINS = 2.0
"""Bins of the spectrum that a half-power width must have."""
CREEP = 0.02
"""Way of the rest over the first amplitude that is told."""
NEAR = 0.25
"""Relative distance of two frequencies that is called a beat."""
LEVEL = 1e-3
LASTING, MANY = 0.05, 20.0
"""Part by which a vibration dies out over the record, and its cycles, by which it is called a lasting one."""


def lasts(fit: SineFit) -> np.ndarray:
    """Return which modes (k,) do not die out within many cycles, as what something else drives."""
    span = float(fit.times[-1])
    cycles = np.abs(fit.poles.imag) * span / (2.0 * np.pi)
    return np.asarray((np.abs(fit.poles.real) * span < LASTING) & (cycles > MANY))


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
        found.append(
            f"the largest values come several times in a row: the record is clipped until {held[-1]:.4g} s, and used "
            f"from {part.times[0]:.4g} s on"
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
    if not fit.is_white:
        found.append(
            f"the residual of {fit.noise:.3g}{unit} is not white noise (its samples are correlated): the noise is "
            "coloured, which the intervals account for, or damped sines with constant ratios leave something over, "
            "which they do not"
        )
    trend = _trend(pieces)
    if trend:
        found.append(trend)
    return found


def half_power_width(frequency: float, ratio: float) -> float:
    """Return the width of a resonance at half the power, Hz."""
    return 2.0 * abs(ratio) * frequency


def clipped_samples(values: Floats, per_cycle: float) -> np.ndarray:
    """Return which samples (n,) hold an extreme while a sine would have moved by more than the resolution."""
    found = np.zeros(len(values), dtype=bool)
    known = np.unique(values)
    if per_cycle < 4.0 or len(known) < 8:
        return found
    step = float(np.min(np.diff(known)))
    reach = float(known[-1] - known[0])
    moved = 0.5 * reach * (1.0 - np.cos(np.pi * (RUN - 1) / per_cycle))
    if moved < 3.0 * step:
        return found
    for extreme in (known[-1], known[0]):
        at = np.abs(values - extreme) <= 1e-9 * reach
        runs = np.flatnonzero(np.diff(np.concatenate([[False], at, [False]]).astype(int)))
        if len(runs) and int(np.max(runs[1::2] - runs[::2])) >= RUN:
            found |= at
    return found


def _trend(pieces: dict[str, Floats]) -> str:
    """Return a sentence if the ratios of the pieces are not one number."""
    ratio, width = pieces["ratio"], pieces["ratio_width"] / 1.96
    if len(ratio) < 3:
        return ""
    weight = 1.0 / np.maximum(width, 1e-300) ** 2
    mean = float(np.sum(weight * ratio) / np.sum(weight))
    if chi2.sf(float(np.sum(weight * (ratio - mean) ** 2)), len(ratio) - 1) > LEVEL:
        return ""
    if np.ptp(ratio) < 0.005 * abs(mean):
        return ""
    # those two that are farthest apart for their doubt: the last ones are the least certain
    apart = np.abs(ratio[:, None] - ratio) / np.hypot(width[:, None], width)
    first, last = np.unravel_index(int(np.argmax(np.triu(apart))), apart.shape)
    amplitude = pieces["amplitude"]
    return (
        f"the damping ratio is not one number: {ratio[first]:.4g} at the amplitude {amplitude[first]:.3g}, "
        f"{ratio[last]:.4g} at {amplitude[last]:.3g}; take that of the amplitude in question"
    )
