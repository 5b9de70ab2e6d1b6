"""Orders of elimination of the block rows of a matrix: for a narrow band, or for little fill of a sparse LU."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Integers


def half_bandwidth(pattern: Pattern, order: Integers) -> int:
    """Return how many places apart coupled block rows are at most, if eliminated in an order ``(N,)``."""
    place = np.argsort(order)
    return int(np.abs(place[pattern.rows] - place[pattern.columns]).max(initial=0))


def band_order(pattern: Pattern) -> Integers:
    """Return an order ``(N,)`` with a narrow band: as numbered, or reverse Cuthill-McKee if that is narrower."""
    natural = np.arange(pattern.size)
    # whatever comes first couples with so many others, all of them after it
    if half_bandwidth(pattern, natural) < np.diff(pattern.starts).min(initial=pattern.size):
        return natural
    found = cuthill_mckee(pattern)[::-1].copy()
    return found if half_bandwidth(pattern, found) < half_bandwidth(pattern, natural) else natural


def cuthill_mckee(pattern: Pattern) -> Integers:
    """Return the order of Cuthill and McKee ``(N,)``, every component from an end that is far from all others."""
    degrees = np.diff(pattern.starts)
    neighbours = [
        block[np.argsort(degrees[block], kind="stable")].tolist()
        for block in np.split(pattern.rows, pattern.starts[1:-1])
    ]
    order: list[int] = []
    placed = [False] * pattern.size
    for seed in range(pattern.size):
        if not placed[seed]:
            for k in _layers(neighbours, _far_end(neighbours, degrees, seed))[0]:
                placed[k] = True
                order.append(k)
    return np.array(order, dtype=np.int64)


def _layers(neighbours: list[list[int]], start: int) -> tuple[list[int], int, int]:
    """Return what is connected with ``start``, breadth first; the number of layers; where the last one begins."""
    seen, order = {start}, [start]
    depth = begin = 0
    while True:
        end = len(order)
        for place in range(begin, end):
            for k in neighbours[order[place]]:
                if k not in seen:
                    seen.add(k)
                    order.append(k)
        if len(order) == end:
            return order, depth, begin
        depth, begin = depth + 1, end


def _far_end(neighbours: list[list[int]], degrees: Integers, seed: int) -> int:
    """Return a row with nearly as many layers below as any (George and Liu)."""
    order, depth, begin = _layers(neighbours, seed)
    while True:
        last = order[begin:]
        candidate = min(last, key=lambda k: int(degrees[k]))
        order, deeper, begin = _layers(neighbours, candidate)
        if deeper <= depth:
            return candidate
        depth = deeper


def sparse_order(pattern: Pattern) -> tuple[Integers, float]:
    """Return an order ``(N,)`` of minimum degree, and the multiplications and additions of an LU without pivoting."""
    from scipy.sparse.linalg import splu

    # values that need no pivoting: the factors of this small matrix show the fill of the large one in blocks
    values = np.where(pattern.rows == pattern.columns, 2.0 * pattern.size, 1.0)
    rows, starts = pattern.rows.astype(np.int32), pattern.starts.astype(np.int32)
    graph = sparse.csc_matrix((values, rows, starts), shape=(pattern.size, pattern.size))
    factors = splu(graph, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    below = np.diff(factors.L.indptr).astype(float)
    return np.argsort(factors.perm_c).astype(np.int64), float(2.0 * 6.0**3 * np.sum(below**2))
