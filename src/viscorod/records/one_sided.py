"""The lines from 0 Hz on of spectra with two sides, as transforms give them: the others say the same once more."""

from __future__ import annotations

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

__all__ = ["mirrored_from", "one_sided"]

FEWEST = 16
"""Lines that must be there to tell a mirror."""
SAME = 1e-6
"""Part of the largest value by which a mirrored one may be off, as numbers are written."""


def mirrored_from(frequencies: Floats, values: np.ndarray) -> int | None:
    """Return the first line that repeats a lower one as its conjugate, up to the sampling rate; None if none does.

    Args:
        frequencies: increasing from 0 or the first line on, Hz (n,).
        values: complex (n,).
    """
    steps = np.diff(frequencies)
    if len(frequencies) < FEWEST or np.ptp(steps) > 1e-3 * float(steps.mean()):
        return None
    first = round(float(frequencies[0] / steps.mean()))
    if first not in (0, 1) or not np.imag(values).any():
        return None
    lines = np.asarray(values)[1 - first :]
    if float(np.abs(lines - lines[::-1].conj()).max()) > SAME * float(np.abs(lines).max()):
        return None
    return 1 - first + (len(lines) + 1) // 2


def one_sided(where: str, frequencies: Floats, values: np.ndarray) -> np.ndarray:
    """Return which lines (n,) of a response are its upper side; all, where it has one.

    Raises:
        InputError: lines below 0 Hz are other than those above.
    """
    kept = frequencies >= 0.0
    if kept.all():
        first = mirrored_from(frequencies, values) if (np.diff(frequencies) > 0.0).all() else None
        return kept if first is None else np.arange(len(frequencies)) < first
    order = np.argsort(frequencies[kept])
    above, there = frequencies[kept][order], values[kept][order]
    below, here = -frequencies[~kept], np.conj(values[~kept])
    at = np.searchsorted(above, below * (1.0 - 1e-9))
    paired = (at < len(above)) & np.isclose(above[np.minimum(at, len(above) - 1)], below, rtol=1e-6)
    off = np.abs(here - there[np.minimum(at, len(above) - 1)])[paired]
    if not paired.any() or float(off.max()) > SAME * float(np.abs(values).max()):
        raise InputError(
            Fault(
                f"{where}: frequencies", f"{-below.max():g}", "lines below 0 Hz are not the mirror of those above",
                "give the positive ones",
            )
        )  # fmt: skip
    return kept
