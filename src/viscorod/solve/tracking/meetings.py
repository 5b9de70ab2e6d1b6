"""Where the frequencies of two followed modes cross, and where they veer away from each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.solve.tracking.mode_tracking import Sample
from viscorod.solve.tracking.special_values import growing

__all__ = ["Meeting", "meetings"]

NEAR = 0.1
"""Distance of two frequencies, as a part of them, from which on modes may veer."""
EXCHANGED = 0.4
"""Likeness of the shape of one mode before with that of the other after from which on they have veered."""
APART = 3.0
"""Times of the least distance of two frequencies at which shapes before and after are compared."""
COINCIDE = 1e-6
"""Distance of frequencies, as a part of them, within which modes coincide throughout."""


@dataclass(frozen=True)
class Meeting:
    """Two modes whose frequencies meet.

    Attributes:
        parameter: about where; modes: numbers of both; crosses: they cross, else they veer; gap: the least distance
            that was seen [rad/s]; frequency: there [rad/s].
    """

    parameter: float
    modes: tuple[int, int]
    crosses: bool
    gap: float
    frequency: float


def meetings(samples: list[Sample], mass: sparse.csr_array) -> list[Meeting]:
    """Return where two modes cross or veer, in order of the parameter."""
    p = np.array([sample.parameter for sample in samples])
    frequencies = np.array([np.abs(sample.roots.imag) for sample in samples])
    unstable = growing(samples)
    found = []
    count = frequencies.shape[1]
    for i in range(count):
        for j in range(i + 1, count):
            apart = frequencies[:, i] - frequencies[:, j]
            mean = 0.5 * (frequencies[:, i] + frequencies[:, j])
            if not (mean > 0.0).all() or (np.abs(apart) <= COINCIDE * mean).any():
                continue
            calm = ~(unstable[:, i] | unstable[:, j])  # two that flutter have one frequency
            for k in np.flatnonzero((apart[:-1] * apart[1:] < 0.0) & calm[:-1] & calm[1:]):
                part = apart[k] / (apart[k] - apart[k + 1])
                where = float(p[k] + part * (p[k + 1] - p[k]))
                at = float(mean[k] + part * (mean[k + 1] - mean[k]))
                found.append(Meeting(where, (i, j), True, 0.0, at))
            last = len(calm) if calm.all() else int(np.argmin(calm))
            found += _veerings(samples[:last], mass, (i, j), (apart[:last], mean[:last]))
    return sorted(found, key=lambda one: one.parameter)


def _veerings(
    samples: list[Sample],
    mass: sparse.csr_array,
    pair: tuple[int, int],
    course: tuple[np.ndarray, np.ndarray],
) -> list[Meeting]:
    apart, mean = course
    size, (i, j), found = np.abs(apart), pair, []
    for k in range(1, len(size) - 1):
        least = size[k] <= size[k - 1] and size[k] < size[k + 1] and size[k] < NEAR * mean[k]
        if not least or apart[k - 1] * apart[k] < 0.0 or apart[k] * apart[k + 1] < 0.0:
            continue
        wide = size >= APART * size[k]
        before = max(np.flatnonzero(wide[:k]), default=0)
        after = k + 1 + min(np.flatnonzero(wide[k + 1 :]), default=len(size) - k - 2)
        one, other = samples[before].shapes[:, i], samples[after].shapes[:, j]
        if abs(np.vdot(one, mass @ other)) ** 2 > EXCHANGED:
            found.append(Meeting(samples[k].parameter, pair, False, float(size[k]), float(mean[k])))
    return found
