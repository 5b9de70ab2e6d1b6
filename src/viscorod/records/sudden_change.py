"""Where a swing changes at once: a blow, a bounce, samples that are missing and nobody marked.

About every time a few cycles are fitted twice with the pole of the whole record: by one amplitude whose change is
steady, and by one that jumps at that time too. Damping that depends on the amplitude changes steadily, so a jump takes
nothing off; what a blow leaves, a jump takes off at once.
"""

from __future__ import annotations

import numpy as np

from viscorod.records.damped_sines import SineFit
from viscorod.typing import Floats

__all__ = ["changes_at"]

BEFORE = 4.0
"""Cycles on each side of a change, by which it is told from a steady one."""
FINE = 8
"""Times within a cycle at which a change is looked for."""
LESS = 0.3
"""Part of the squares that is left by a jump, for it to be one."""
LARGE = 0.03
"""Size of a jump over the amplitude at least."""
FEWEST = 24
"""Samples about a change at least."""


def changes_at(fit: SineFit) -> float | None:
    """Return the time from the first sample at which the strongest mode jumps; None where it does not."""
    times, values = fit.times, fit.model + fit.residual
    pole = fit.poles[int(np.argmax(np.abs(fit.amplitudes)))]
    period = 2.0 * np.pi / float(pole.imag)
    best: tuple[float, float] | None = None
    middles = np.arange(BEFORE * period, float(times[-1]) - BEFORE * period, period / FINE)
    first = np.searchsorted(times, middles - BEFORE * period)
    last = np.searchsorted(times, middles + BEFORE * period, side="right")
    for middle, begin, end in zip(middles, first, last, strict=True):
        if end - begin < FEWEST:
            continue
        about = slice(begin, end)
        left, size = _by_jump(times[about] - middle, values[about], pole)
        if left < LESS and size > LARGE and (best is None or left < best[0]):
            best = left, float(middle)
    return None if best is None else best[1]


def _by_jump(t: Floats, values: Floats, pole: complex) -> tuple[float, float]:
    """Return the part of the squares that a jump at zero leaves, and its size over the amplitude."""
    wave = np.exp(pole * t)
    columns = np.column_stack([wave.real, wave.imag])
    steady = np.column_stack([columns, t[:, None] * columns, np.ones_like(t), t])
    jumping = np.column_stack([columns * (t >= 0.0)[:, None], steady])
    one = np.linalg.lstsq(steady, values, rcond=None)[0]
    two = np.linalg.lstsq(jumping, values, rcond=None)[0]
    before = float(np.sum((values - steady @ one) ** 2))
    after = float(np.sum((values - jumping @ two) ** 2))
    if before == 0.0:
        return 1.0, 0.0
    return after / before, float(np.hypot(two[0], two[1]) / max(np.hypot(two[2], two[3]), 1e-300))
