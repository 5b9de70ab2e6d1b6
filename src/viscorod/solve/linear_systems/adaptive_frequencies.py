"""Frequencies chosen so that straight lines between them follow all responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np

from viscorod.typing import Floats

__all__ = ["Followed", "followed"]

FIRST = 40
"""Frequencies at least, evenly on a logarithmic scale."""
MOST = 20_000
"""Frequencies at most."""
FAINT = 1e-6
"""Part of the largest response below which one, in an antiresonance, need not be followed."""
CLOSEST = 1e-10
"""Relative distance of two frequencies at least."""
LADDER = (0.25, 1.0, 4.0, 16.0, 64.0)
"""Distances from a pole, in its half widths, at which frequencies are put at first."""


class Followed:
    """Responses at frequencies that follow them.

    Attributes:
        hertz: increasing frequencies ``(m,)`` [Hz]; responses: ``(m, outputs, inputs)``.
        error: largest distance of a response from the lines, where it was looked at last, as a part of it.
    """

    def __init__(self, hertz: Floats, responses: np.ndarray, error: float) -> None:
        self.hertz, self.responses, self.error = hertz, responses, error


def followed(
    response: Callable[[float], np.ndarray],
    band: tuple[float, float],
    poles: Sequence[complex],
    tolerance: float,
) -> Followed:
    """Return responses over a band, at frequencies between which straight lines err by less than a tolerance.

    Every interval is halved while the response in its middle is further from the chord of its ends (in the complex
    plane) than the tolerance allows.

    Args:
        response: of a frequency [Hz], ``(outputs, inputs)``.
        band: lowest and highest frequency [Hz]; poles: ``s`` [1/s] of the resonances, where peaks are sought first.
        tolerance: part of the response.
    """
    known: dict[float, np.ndarray] = {}

    def at(f: float) -> np.ndarray:
        if f not in known:
            known[f] = response(f)
        return known[f]

    start = sorted({float(f) for f in _first(band, poles)})
    values = np.array([at(f) for f in start])
    size = np.abs(values).max(axis=0)
    pending = list(pairwise(start))[::-1]
    worst = 0.0
    while pending:
        a, b = pending.pop()
        middle = 0.5 * (a + b) if b < 1.5 * a else float(np.sqrt(a * b))
        here = at(middle)
        part = (middle - a) / (b - a)
        chord = (1.0 - part) * known[a] + part * known[b]
        floor = np.maximum(np.maximum(np.abs(here), FAINT * size), np.finfo(float).tiny)
        error = float((np.abs(here - chord) / floor).max())
        size = np.maximum(size, np.abs(here))
        if error <= tolerance or b - a < CLOSEST * b or len(known) >= MOST:
            # the half intervals have a quarter of this error
            worst = max(worst, 0.25 * error)
            continue
        pending += [(middle, b), (a, middle)]
    hertz = np.array(sorted(known))
    return Followed(hertz, np.array([known[float(f)] for f in hertz]), worst)


def _first(band: tuple[float, float], poles: Sequence[complex]) -> Floats:
    low, high = band
    found = [np.geomspace(low, high, FIRST)]
    for s in poles:
        centre, half = abs(s.imag) / (2.0 * np.pi), max(abs(s.real), 1e-7 * abs(s)) / (2.0 * np.pi)
        around = np.array([0.0, *LADDER]) * half
        near = np.concatenate([centre - around[1:], centre + around])
        found.append(near[(near > low) & (near < high)])
    return np.concatenate(found)
