"""Frequencies chosen so that straight lines between them follow all responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from viscorod.solve.statics.newton import interruption
from viscorod.typing import Floats

__all__ = ["Followed", "StoppedError", "followed", "reason_of"]

FIRST = 40
"""Frequencies at least, evenly on a logarithmic scale."""
MOST = 20_000
"""Frequencies at most."""
FAINT = 1e-6
"""Part of the largest response below which one, in an antiresonance, need not be followed."""
CLOSEST = 1e-10
"""Relative distance of two frequencies at least."""
UNDAMPED = 1e-12
"""Decay of a vibration, as a part of its frequency, that is none."""
LADDER = (0.25, 1.0, 4.0, 16.0, 64.0)
"""Distances from a pole, in its half widths, at which frequencies are put at first."""


@dataclass(frozen=True)
class Followed:
    """Responses at frequencies that follow them.

    Attributes:
        hertz: increasing frequencies ``(m,)`` [Hz]; responses: ``(m, outputs, inputs)``.
        error: largest distance of a response from the lines, where it was looked at last, as a part of it.
        reached: frequency [Hz] up to which they are followed; stopped: why it ended there; empty if it did not.
    """

    hertz: Floats
    responses: np.ndarray
    error: float
    reached: float
    stopped: str = ""


class StoppedError(Exception):
    """Something asks to end."""


def reason_of(asked: BaseException) -> str:
    """Return why responses end before the highest frequency."""
    return interruption(asked) if isinstance(asked, KeyboardInterrupt) else str(asked)


def followed(
    response: Callable[[float], np.ndarray],
    band: tuple[float, float],
    poles: Sequence[complex],
    tolerance: float,
    told: Callable[[float, float], None] | None = None,
) -> Followed:
    """Return responses over a band, at frequencies between which straight lines err by less than a tolerance.

    Every interval is halved while the response in its middle is further from the chord of its ends (in the complex
    plane) than the tolerance allows.

    Args:
        response: of a frequency [Hz], ``(outputs, inputs)``; it may raise ``StoppedError``.
        band: lowest and highest frequency [Hz]; poles: ``s`` [1/s] of the resonances, where peaks are sought first.
        tolerance: part of the response; told: called with the frequency up to which it is done, and the step there.
    """
    known: dict[float, np.ndarray] = {}

    def at(f: float) -> np.ndarray:
        if f not in known:
            known[f] = response(f)
        return known[f]

    # at the frequency of what nothing damps there is no response
    sharp = np.array([abs(s.imag) / (2.0 * np.pi) for s in poles if abs(s.real) <= UNDAMPED * abs(s)])
    start = sorted({float(f) for f in _first(band, poles)})
    worst, reached, stopped = 0.0, band[0], ""
    try:
        values = np.array([at(f) for f in start])
        size = np.abs(values).max(axis=0)
        pending = list(pairwise(start))[::-1]
        while pending:
            a, b = pending.pop()
            middle = 0.5 * (a + b) if b < 1.5 * a else float(np.sqrt(a * b))
            if np.any(np.abs(sharp - middle) <= UNDAMPED * middle):
                middle += 0.25 * (b - middle)
            here = at(middle)
            part = (middle - a) / (b - a)
            chord = (1.0 - part) * known[a] + part * known[b]
            floor = np.maximum(np.maximum(np.abs(here), FAINT * size), np.finfo(float).tiny)
            error = float((np.abs(here - chord) / floor).max())
            size = np.maximum(size, np.abs(here))
            if error > tolerance and b - a >= CLOSEST * b and len(known) < MOST:
                pending += [(middle, b), (a, middle)]
                continue
            # the half intervals have a quarter of this error
            worst, reached = max(worst, 0.25 * error), b
            if told is not None:
                told(b, b - a)
    except (StoppedError, KeyboardInterrupt) as asked:
        stopped = reason_of(asked)
    hertz = np.array(sorted(known))
    return Followed(hertz, np.array([known[float(f)] for f in hertz]), worst, reached, stopped)


def _first(band: tuple[float, float], poles: Sequence[complex]) -> Floats:
    low, high = band
    found = [np.geomspace(low, high, FIRST)]
    for s in poles:
        centre, half = abs(s.imag) / (2.0 * np.pi), max(abs(s.real), 1e-7 * abs(s)) / (2.0 * np.pi)
        around = np.array(LADDER) * half
        middle = [centre] if abs(s.real) > UNDAMPED * abs(s) else []
        near = np.concatenate([centre - around, middle, centre + around])
        found.append(near[(near > low) & (near < high)])
    return np.concatenate(found)
