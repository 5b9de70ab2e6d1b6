"""What static loads show of their beginning: a zero that is off, and slack before the load is carried.

A modulus takes up both; so each is compared with what chance does (F test), whatever is left otherwise.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy import stats

from viscorod.records.static_record import StaticRecord
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.typing import Floats

__all__ = ["static_zero"]

EXPLAINED = 0.5
"""Part of the power of what is left that an offset must explain to be named."""
BY_CHANCE = 1e-3
"""Probability below which it is not by chance that something explains what is left."""
LEAST_LEFT = 4
"""Loads beside those of a slack, at least: three that tell its size, one that tells their scatter."""
BETTER = 4.0
"""Times that loads without the first ones must leave less than loads without as many of the last ones: where a pull
bends all along, both ends are alike."""
MATTERS = 0.01
"""Part by which a slack must change what a load moves to be named."""


def static_zero(record: StaticRecord, best: Estimate, rows: slice) -> Iterator[str]:
    """Tell whether the first loads stand beside what the others tell, or all are off by one number.

    Args:
        record: of static loads; best: the fit; rows: of the record in it.
    """
    slopes, left = best.slopes[rows], best.residuals[rows]
    slopes = slopes[:, np.abs(slopes).max(axis=0) > 0.0]
    slopes = slopes / np.linalg.norm(slopes, axis=0)
    if "offset" not in {one.name for one in record.nuisances.values()}:
        slopes = np.column_stack([slopes, np.ones(len(left))])
        whole = _left(slopes[:, :-1], left)
        free = len(left) - slopes.shape[1]
    else:
        whole, free = _left(slopes, left), -1
    slack = _slack(slopes, left)
    if slack:
        part = _way_per_load(best, rows, slack)
        if abs(part - 1.0) > MATTERS:
            some = "The first load" if slack == 1 else f"The first {slack} loads"
            yield (
                f"{some} of {record.name} ({_up_to(record, slack)}) stand{'s' if slack == 1 else ''} beside what the "
                f"other {len(left) - slack} tell, of which each moves {part:.3g} times as far as the fit says: slack, "
                "or a grip that settles. Take what is slack out of the record, and give it unknown = ['offset']."
            )
            return
    if free < 2 or whole == 0.0:
        return
    share = min(1.0 - _left(slopes, left) / whole, 1.0 - 1e-12)
    if share > EXPLAINED and float(stats.f.sf(share / (1.0 - share) * free, 1, free)) < BY_CHANCE:
        q = np.linalg.qr(slopes[:, :-1])[0]
        own = 1.0 - q @ (q.T @ np.ones(len(left)))
        offset = float(own @ left) / float(own @ own)
        zero = "" if record.quantity != "displacement" else ", or a load that was there before"
        yield (
            f"{100.0 * share:.0f} % of what is left of {record.name} is what an offset of its zero of {offset:.3g} "
            f"{record.axes[0][1]}{zero}, would leave: if it may have one, give it unknown = ['offset']."
        )


def _left(slopes: Floats, values: Floats) -> float:
    """Return the sum of squares that directions do not explain."""
    if slopes.shape[1] == 0:
        return float(values @ values)
    found = values - slopes @ np.linalg.lstsq(slopes, values, rcond=1e-10)[0]
    return float(found @ found)


def _slack(slopes: Floats, left: Floats) -> int:
    """Return how many of the first loads stand beside the others, 0 if none.

    Without them the others must be left with so much less, that chance does it in none of many records, all counts that
    are tried together; and with less than where as many of the last ones are left out.
    """
    count, own = slopes.shape
    whole, best, found = _left(slopes, left), BY_CHANCE, 0
    counts = range(1, count - max(own + 1, LEAST_LEFT) + 1)
    for k in counts:
        free = count - k - own
        rest, last = _left(slopes[k:], left[k:]), _left(slopes[:-k], left[:-k])
        if rest <= 0.0 or last < BETTER * rest:
            continue
        chance = len(counts) * float(stats.f.sf((whole - rest) / k / (rest / free), k, free))
        if chance < best:
            best, found = chance, k
    return found


def _way_per_load(best: Estimate, rows: slice, first: int) -> float:
    """Return how far the loads after the first ones move, over what the fit says, whatever their zero is."""
    predicted, measured = best.predicted[rows][first:], best.measured[rows][first:]
    about = predicted - predicted.mean()
    size = float(about @ about)
    return float(about @ measured) / size if size > 0.0 else 1.0


def _up_to(record: StaticRecord, count: int) -> str:
    return f"{record.loads[0]:.4g}" + (f" to {record.loads[count - 1]:.4g}" if count > 1 else "")
