"""Times at which a travelling load is on its rod."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from itertools import pairwise

from viscorod.model.actions.load_effects import TimeFactor
from viscorod.model.actions.time_function import TimeFunction

__all__ = ["on_rod", "passages"]


def passages(position: TimeFunction, length: float) -> list[float]:
    """Return the times at which an arc length, m, passes an end of a rod, between its breakpoints, increasing, s."""
    from scipy.optimize import brentq

    times = set(position.jumps)
    for a, b in pairwise(position.breakpoints):
        for end in (0.0, length):
            low, high = position.value(a) - end, position.value(b, before=True) - end
            if low * high < 0.0:
                times.add(
                    float(brentq(lambda t, end=end: position.value(t) - end, a, b, xtol=1e-15, rtol=1e-14))
                )
            times.update(t for t, gap in ((a, low), (b, high)) if gap == 0.0)
    return sorted(times)


def on_rod(
    arc_length: TimeFactor, load_factor: TimeFactor, length: float, ends: list[float]
) -> tuple[TimeFactor, TimeFactor]:
    """Return an arc length kept on the rod, and a factor that is zero beside it.

    Whether a load acts is decided by which of its passages over the rod's ends a time lies between, not by the rounding
    of its arc length there.

    Args:
        arc_length: m, as a function of time.
        load_factor: as a function of time.
        length: of the rod, m.
        ends: the passages, s.
    """
    if not ends:
        return arc_length, load_factor
    middles = [0.5 * (a + b) for a, b in pairwise(ends)]
    samples = [ends[0] - 1.0, *middles, ends[-1] + 1.0]
    inside = [0.0 <= arc_length(t, False) <= length for t in samples]

    def position(t: float, before: bool) -> float:
        return min(max(arc_length(t, before), 0.0), length)

    def factor(t: float, before: bool) -> float:
        acts = inside[(bisect_left if before else bisect_right)(ends, t)]
        return load_factor(t, before) if acts else 0.0

    return position, factor
