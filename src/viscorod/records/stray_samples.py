"""Samples that no motion has: spikes, and dropouts to another value and back.

A sample is a spike if it stands far off what its four neighbours lead to expect, by a cubic through them, in the usual
distance of that; a dropout is a run that is entered and left by a jump, far off what is about it. What only begins or
only ends with a jump is a motion: a release, a blow.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter, median_filter

from viscorod.solve.estimation.noise import MEDIAN_TO_DEVIATION
from viscorod.typing import Floats

__all__ = ["LEAST", "MOST", "STEPS", "dropouts", "spikes"]

ABOUT = 201
"""Samples about one, among which its distance is unusual."""
ROUNDS = 6
"""Passes, of which each takes the farthest of five samples."""
FAR = 8.0
"""Deviations from which on a sample is a spike."""
ALONE = 3.0
"""Distance of a spike over that of three of its four neighbours; what the model misses of a first swing is no spike."""
LEAST = 0.005
"""Part of the size of a motion that a spike has at least."""
SPAN = 12.0
"""Distance of a dropout from the median, in median distances; a sine reaches 1.4."""
LONGEST = 50
"""Samples of a dropout at most."""
JUMP = 0.7
"""Jump at both ends of a dropout over its distance."""
OFTEN, TIMES = 8, 20.0
"""Samples that have one and the same value, and how many times as often as others, from which on it means a dropout."""
STEPS, USUAL = 5.0, 3.0
"""Steps of the resolution, and usual changes from sample to sample, by which such a value is entered and left."""
MOST = 0.2
"""Part of the samples that may be stray; more are no strays but the record."""


def spikes(residual: Floats, size: float) -> np.ndarray:
    """Return which samples of what a fit leaves (n,) stand far off their neighbours.

    Args:
        residual: (n,), evenly spaced or nearly so; size: of the motion.
    """
    found = np.zeros(len(residual), dtype=bool)
    for _ in range(ROUNDS):
        kept = np.flatnonzero(~found)
        if len(kept) < ABOUT // 10:
            break
        x = np.pad(residual[kept], 2, mode="reflect", reflect_type="odd")
        off = np.abs(x[2:-2] - (4.0 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6.0)
        usual = np.maximum(median_filter(off, min(ABOUT, len(off)), mode="mirror"), float(np.median(off)))
        far = off > np.maximum(FAR * MEDIAN_TO_DEVIATION * usual, max(LEAST * size, 1e-300))
        far &= off >= maximum_filter(off, 5, mode="mirror")  # what stands beside it is off by it
        beside = np.sort([x[:-4], x[1:-3], x[3:-1], x[4:]], axis=0)
        far &= off > ALONE * np.minimum(beside[2] - beside[0], beside[3] - beside[1])
        if not far.any():
            break
        found[kept[far]] = True
    return found if found.mean() <= MOST else np.zeros(len(found), dtype=bool)


def dropouts(values: Floats, size: float = 0.0) -> np.ndarray:
    """Return which samples (n,) lie in short runs far off what is about them.

    Args:
        values: (n,), of a record or of what a fit leaves; size: of the motion.
    """
    found = _one_value(values)
    width = min(ABOUT, len(values) // 2 * 2 - 1)
    if width < ABOUT // 10:
        return found
    off = values - median_filter(values, width, mode="mirror")
    usual = median_filter(np.abs(off), width, mode="mirror")
    far = np.abs(off) > np.maximum(SPAN * usual, max(LEAST * size, 1e-300))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], far, [False]]).astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        if first == 0 or last == len(values) or last - first > LONGEST:
            continue
        entered, left = values[first] - values[first - 1], values[last - 1] - values[last]
        distance = off[first:last]
        if (
            entered * distance[0] > 0.0
            and left * distance[-1] > 0.0
            and abs(entered) > JUMP * abs(distance[0])
            and abs(left) > JUMP * abs(distance[-1])
        ):
            found[first:last] = True
    return found if found.mean() <= MOST else np.zeros(len(found), dtype=bool)


def _one_value(values: Floats) -> np.ndarray:
    """Return which samples (n,) have the one value that an instrument gives where it sees nothing, 0 for instance."""
    found = np.zeros(len(values), dtype=bool)
    known, counts = np.unique(values, return_counts=True)
    if len(known) < OFTEN or counts.max() < max(OFTEN, TIMES * float(np.median(counts))):
        return found
    same = values == known[int(np.argmax(counts))]
    change = np.abs(np.diff(values))
    least = max(STEPS * float(np.diff(known).min()), USUAL * float(np.median(change)))
    edges = np.flatnonzero(np.diff(np.concatenate([[False], same, [False]]).astype(int)))
    for first, last in zip(edges[::2], edges[1::2], strict=True):
        inside = first > 0 and last < len(values) and last - first <= LONGEST
        if inside and change[first - 1] > least and change[last - 1] > least:
            found[first:last] = True
    return found
