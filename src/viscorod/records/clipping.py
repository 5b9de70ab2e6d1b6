"""Samples at the end of an instrument's range: equal values in a row, or flat tops with noise on them."""

from __future__ import annotations

import numpy as np

from viscorod.solve.estimation.noise import MEDIAN_TO_DEVIATION
from viscorod.typing import Floats

__all__ = ["clipped_samples", "resolution"]

RUN = 3
"""Equal samples at an extreme that mean clipping."""
TOP = 0.05
"""Part of the reach below an extreme in which the noise of a flat top is looked for."""
BAND, THIN = 8.0, 0.1
"""Deviations of this noise that a flat top has from its highest sample down, and the part of half the reach that it may
have at most: thicker ones are not told from the tops of sines."""
LONGER, MORE = 1.6, 2.0
"""How many times as long as a sine, and samples more, that flat tops last; there are two or more of them."""
COARSE = 4
"""Samples per level of a record whose values come in steps."""


def resolution(values: Floats) -> float:
    """Return the step of the levels in which values (n,) come; zero where hardly any come twice."""
    known = np.unique(values)
    if len(known) < 2 or COARSE * len(known) > len(values):
        return 0.0
    return float(np.min(np.diff(known)))


def clipped_samples(values: Floats, per_cycle: float) -> np.ndarray:
    """Return which samples (n,) hold an extreme while a sine would have moved by more than the resolution."""
    found = _flat_tops(values, per_cycle)
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


def _flat_tops(values: Floats, per_cycle: float) -> np.ndarray:
    """Return which samples (n,) lie on flat tops with noise on them, as those of an amplifier or a filter behind it.

    A sine of the reach stays within a band below its top for a known time. Two tops of a record that stay there for
    much longer, where the band is as thin as the noise on them, have met a limit. One that lasts for more than half a
    cycle is a rod that is held before its release.
    """
    found = np.zeros(len(values), dtype=bool)
    reach = float(np.ptp(values))
    if per_cycle < 8.0 or reach == 0.0:
        return found
    above = values > 0.5 * (values.max() + values.min())
    swing = np.cumsum(np.diff(above, prepend=above[0]))
    for side in (1.0, -1.0):
        below = float((side * values).max()) - side * values
        near = below < TOP * reach
        together = near[1:] & near[:-1]
        if np.count_nonzero(together) < 2 * RUN:
            continue
        changes = np.abs(np.diff(values))[together]
        band = BAND * MEDIAN_TO_DEVIATION * float(np.median(changes)) / np.sqrt(2.0)
        if not 0.0 < band < THIN * 0.5 * reach:
            continue
        usual = per_cycle / np.pi * np.arccos(1.0 - band / (0.5 * reach))
        at = np.flatnonzero(below <= band)
        _, first, count = np.unique(swing[at], return_index=True, return_counts=True)
        last = first + count - 1
        short = at[last] - at[first] <= 0.5 * per_cycle + MORE
        if np.count_nonzero(short & (count > LONGER * usual + MORE)) > 1:
            found[at[np.repeat(short, count)]] = True
    return found
