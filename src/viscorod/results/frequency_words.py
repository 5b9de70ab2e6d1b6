"""Which of two frequencies of a damped mode a table lists, where they differ."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["frequency_note"]

APART = 0.1
"""Damping ratio from which on both differ by more than 0.5 %: it swings at sqrt(1 - ratio^2) of the natural one."""


def frequency_note(ratios: Floats, *, natural: bool) -> list[str]:
    """Return the sentence below a table of modes, none where both frequencies are nearly the same or nothing swings.

    Args:
        ratios: damping ratios of all that is listed; natural: the table has ``|s|/2 pi``, not ``|Im s|/2 pi``.
    """
    size = np.abs(ratios)
    if not ((size > APART) & (size < 1.0)).any():
        return []
    listed, other = ("natural ones, |s|/2 pi", "that of the oscillation, |Im s|/2 pi, is")
    if not natural:
        listed, other = ("those of oscillations, |Im s|/2 pi", "the natural one, |s|/2 pi, is")
    how = "lower" if natural else "higher"
    return [
        f"Frequencies are {listed}; {other} {how} by more than 0.5 % where the damping ratio is above {APART:g}"
    ]
