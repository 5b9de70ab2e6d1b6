"""Steps of a neighbour of a motion, whose loads and prescribed motions may jump or have corners at other times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

__all__ = ["moved_ends", "moves_corners"]

APART = 0.02
"""Part of the duration within which steps move with a corner, at least."""


def moves_corners(here: Sequence[float], there: Sequence[float]) -> bool:
    """Return whether corners are at other times."""
    return not np.array_equal(here, there)


def moved_ends(
    key: str, ends: Floats, times: Floats, here: Sequence[float], there: Sequence[float]
) -> Floats:
    """Return the ends of the steps of a neighbour [s]: those at a corner are at its own, and those about it move along.

    As elements of a longer rod keep their parts of it, steps keep theirs of the time between corners, or to the next
    stored time that a step ends at, which stays.

    Args:
        key: of the number; ends: of the steps; times: that are stored, all [s].
        here: times of the corners up to the end of the motion [s], which is the last; there: the same of the neighbour.

    Raises:
        InputError: corners come to lie beyond the motion, at another one, or past it.
    """
    if not moves_corners(here, there):
        return ends
    if len(here) == len(there):
        before, after = np.array(here), np.array(there)
        moving = before[before != after]
        stored = ends[np.isclose(ends[:, None], times, rtol=0.0, atol=1e-12 * ends[-1]).any(axis=1)]
        far = np.abs(stored[:, None] - moving).min(axis=1) > APART * ends[-1]
        fixed = np.setdiff1d(np.append(0.0, stored[far]), before)
        at = np.concatenate([fixed, before])
        order = np.argsort(at)
        at, to = at[order], np.concatenate([fixed, after])[order]
        if (np.diff(to) > 0.0).all() and after[-1] == before[-1]:
            found: Floats = np.interp(ends, at, to)
            return found
    raise InputError(
        Fault(
            "derivatives",
            repr(key),
            "it moves a jump or corner of loads or motions past another, or out of the motion",
            "let the motion end elsewhere, or the corners lie apart",
        )
    )
