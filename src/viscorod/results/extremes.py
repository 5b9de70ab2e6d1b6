"""Extremes of a motion between its stored times, and the rest about which it swings."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats, Integers

_STANDSTILL = 1e-6  # initial speed below this part of the largest: released from rest, the start is a maximum
_SYMMETRIC = 0.02  # a rest closer to zero than this part of the last amplitude is taken as zero
_STILL = 0.02  # a rest that moves less than this part of what the amplitude loses, over the last cycle, is constant
_MOST = 0.5  # part of all extremes in which the rest creeps one way: that of a ripple on a slower swing turns
_LAST = 1000  # extremes at the end among which those of the swing are looked for
_RIPPLE = 0.1  # of a swing beside it, below which an extreme is that of a ripple
_ONE_WAY = 6  # so many rests of successive extremes move one way where it creeps: three cycles of maxima


def resting_value(time: Floats, value: Floats, rate: Floats) -> float:
    """Estimate the displacement about which a motion swings [m] from its last three extremes.

    Extremes of a linear decay are ``rest + a (-q)^k``, which three of them determine; those of ripples on it are left
    out. Values close to zero against the last amplitude become zero; with fewer than three extremes the answer is zero.
    """
    last = _without_ripples(extremes(time, value, rate)[1][-_LAST:])[-3:]
    if len(last) < 3:
        return 0.0
    a, b, c = last
    curvature = (c - b) - (b - a)
    if curvature == 0.0:
        return 0.0
    rest = float(c - (c - b) ** 2 / curvature)
    return 0.0 if abs(rest) < _SYMMETRIC * abs(c - rest) else rest


def _without_ripples(values: Floats) -> list[float]:
    """Return successive extremes without those of ripples: what turns back within a tenth of a swing beside it.

    These are closed cycles of rainflow counting, but small ones only; at the end of the record the cycle need not be
    closed. A swing of a single decay is more than a tenth of the one before up to the damping ratio 0.59.
    """
    kept: list[float] = []
    for value in values.tolist():
        kept.append(value)
        while len(kept) > 3:
            before, inner, after = np.abs(np.diff(kept[-4:]))
            if inner >= _RIPPLE * max(before, after):
                break
            del kept[-3:-1]
    while len(kept) > 3 and abs(kept[-1] - kept[-2]) < _RIPPLE * abs(kept[-2] - kept[-3]):
        del kept[-1]
    return kept


def creeping_rest(time: Floats, value: Floats, rate: Floats) -> tuple[Floats, Floats, Floats] | None:
    """Return extremes of a swing about a rest that creeps one way until the end, and the rest at each of them.

    Extremes ``r_k + a (-q)^k`` have the second differences ``x_(k-1) - 2 x_k + x_(k+1) = -a (-q)^k (2 + q + 1/q)``
    where the rest r_k is constant or moves by equal steps, and their quotients give q: the amplitude at each
    extreme follows from its two neighbours. Of a rest that creeps as ``exp(-t/T)`` its own second difference is
    left, about a quarter of (half a period/T)^2 of it.

    Returns:
        Times [s], values [m] and rests [m], each of shape (n,), n >= 6; the first and the last extreme of the
        motion have one neighbour only and are left out. None where the rest moves to and fro in the last three
        cycles or in half of all, as that of a ripple on a slower swing does, or by less than 2 % of what the
        amplitude loses in the last cycle: a constant serves there.
    """
    times, values = extremes(time, value, rate)
    second = np.diff(values, 2)
    if second.size < _ONE_WAY or not np.all(second):
        return None
    q = np.exp(np.gradient(np.log(np.abs(second))))
    swing = -second / (2.0 + q + 1.0 / q)
    rest = values[1:-1] - swing
    step = np.diff(rest)
    turned = np.flatnonzero(step * step[-1] <= 0.0)
    one_way = slice(turned[-1] + 1 if turned.size else 0, None)
    shift, loss = abs(rest[-1] - rest[-3]), abs(swing[-1] - swing[-3])
    if rest[one_way].size < max(_ONE_WAY, _MOST * rest.size) or shift < _STILL * loss:
        return None
    return times[1:-1][one_way], values[1:-1][one_way], rest[one_way]


def extremes(time: Floats, value: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Return times and values of all maxima and minima by increasing time; they alternate."""
    highs, lows = maxima(time, value, rate), maxima(time, -value, -rate)
    times = np.concatenate([highs[0], lows[0]])
    order = np.argsort(times)
    return times[order], np.concatenate([highs[1], -lows[1]])[order]


def maxima(time: Floats, value: Floats, rate: Floats) -> tuple[Floats, Floats, Integers]:
    """Return times and values of all local maxima of the Hermite interpolant, and the interval of each."""
    h = np.diff(time)
    f0, f1, d0, d1 = value[:-1], value[1:], h * rate[:-1], h * rate[1:]
    inside = np.flatnonzero((d0 > 0.0) & (d1 <= 0.0))
    h, f0, f1, d0, d1 = h[inside], f0[inside], f1[inside], d0[inside], d1[inside]
    # The slope over the interval is a u^2 + b u + d0, u in [0, 1]; it falls through zero once.
    a = 6.0 * (f0 - f1) + 3.0 * (d0 + d1)
    b = -6.0 * (f0 - f1) - 4.0 * d0 - 2.0 * d1
    root = np.sqrt(np.maximum(b * b - 4.0 * a * d0, 0.0))
    # two ways to write the same, neither with a difference of like numbers
    u = np.where(b > 0.0, b + root, 2.0 * d0) / np.where(b > 0.0, -2.0 * a, root - b)
    times = time[inside] + u * h
    values = hermite(u, f0, f1, d0, d1)
    slow = _STANDSTILL * float(np.max(np.abs(rate), initial=0.0))
    if value.size > 1 and abs(rate[0]) <= slow and value[1] < value[0]:
        # the start itself, not a maximum that round-off in the initial rate puts just after it
        start = inside != 0
        times = np.concatenate([time[:1], times[start]])
        values = np.concatenate([value[:1], values[start]])
        inside = np.concatenate([[0], inside[start]])
    return times, values, inside.astype(np.int64)


def hermite(u: Floats, f0: Floats, f1: Floats, d0: Floats, d1: Floats) -> Floats:
    """Return the cubic with values ``f0, f1`` and slopes ``d0, d1`` at 0 and 1, evaluated at ``u``."""
    rise = f1 - f0
    return f0 + u * (d0 + u * (3.0 * rise - 2.0 * d0 - d1 + u * (d0 + d1 - 2.0 * rise)))
