"""Rods that meet or cross where nothing joins them, told with every result."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.centrelines.line_shapes import Straight
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.model.rod import Rod
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["unjoined_rods"]

TOGETHER = 1e-4
"""Distance of two places over the length of the shorter rod up to which they are the same."""
CHORD = 0.05
"""Turning [rad] of the tangent along a chord that stands for a part of a curved rod."""
MOST_CHORDS, MOST_PAIRS = 20_000, 2_000_000
"""Chords, and pairs of them that may be near each other, beyond which rods that cross are not sought."""
ALONG = 0.02
"""Sine of the angle of two rods below which they lie along each other, as a core does in a tube."""
NEWTON = 8


def unjoined_rods(model: ModelDescription, problem: Problem) -> Iterator[str]:
    """Yield which rods meet by their ends, or cross, without being joined there."""
    if len(problem.rods) < 2:
        return
    part = _joined(problem)
    yield from _loose_ends(problem, part)
    yield from _crossing(model, problem, part)


class _Chords(NamedTuple):
    """Straight pieces of all rods: index of the rod, arc lengths [m] and positions [m] of both ends."""

    rod: Integers
    s: Floats
    a: Floats
    b: Floats


class _Crossing(NamedTuple):
    """Where two rods cross: their names and indices, arc lengths [m], position [m]."""

    names: tuple[str, str]
    rods: tuple[int, int]
    s: tuple[float, float]
    at: Floats

    def place(self, which: int, length: float) -> str:
        """Return the place of the crossing on one of the rods."""
        near = TOGETHER * length
        s = self.s[which]
        end = "start" if s <= near else "end" if s >= length - near else ""
        return f"{self.names[which]}.{end}" if end else f"{self.names[which]}@{s:.6g}"


def _crossing(model: ModelDescription, problem: Problem, part: Integers) -> Iterator[str]:
    """Yield which rods cross, or end on another one, where no node of the one is joined to a node of the other."""
    lengths = problem.rod_lengths
    texts = []
    for found in _crossings(model, problem):
        places = [found.place(k, float(lengths[found.rods[k]])) for k in (0, 1)]
        if all(place.endswith((".start", ".end")) for place in places):
            continue  # ends that meet are told as such
        reach = TOGETHER * float(lengths[list(found.rods)].min())
        if not _joined_there(problem, part, found, reach):
            point = ", ".join(f"{x:.4g}" for x in found.at + 0.0)
            texts.append(f"{places[0]} and {places[1]} (at ({point}) m)")
    if texts:
        yield (
            f"{some_of(texts)} cross at the same place, and nothing joins them there: they pass through each other as "
            "if the other were not there; attach them (rigid), or give a joint or a spring, if they touch"
        )


def _joined_there(problem: Problem, part: Integers, found: _Crossing, reach: float) -> bool:
    """Return whether nodes of the two rods near their crossing are joined, directly or by others."""
    stations = problem.stations
    near = [
        set(part[stations.nodes[(stations.rod == rod) & (np.abs(stations.s - s) <= 2.0 * reach)]].tolist())
        for rod, s in zip(found.rods, found.s, strict=True)
    ]
    return bool(near[0] & near[1])


def _crossings(model: ModelDescription, problem: Problem) -> list[_Crossing]:
    """Return one crossing of each pair of rods that cross: where they are nearest to each other."""
    rods = [model.rods[name] for name in problem.rods]
    chords = _chords(rods)
    lengths = problem.rod_lengths
    pairs = _near_chords(chords, TOGETHER * lengths)
    if not len(pairs):
        return []
    i, j = pairs.T
    distance, x, y = _between(chords.a[i], chords.b[i], chords.a[j], chords.b[j])
    reach = TOGETHER * np.minimum(lengths[chords.rod[i]], lengths[chords.rod[j]])
    sag = CHORD / 8.0 * (_size(chords, i) + _size(chords, j))
    straight = np.array([isinstance(rod.centreline, Straight) for rod in rods])
    exact = straight[chords.rod[i]] & straight[chords.rod[j]]
    by_ends = ((x == 0.0) | (x == 1.0)) & ((y == 0.0) | (y == 1.0))
    near = (distance <= reach + np.where(exact, 0.0, sag)) & ~(exact & by_ends)
    best: dict[tuple[int, int], tuple[float, _Crossing]] = {}
    for k in np.flatnonzero(near).tolist():
        a, b = int(chords.rod[i[k]]), int(chords.rod[j[k]])
        s = (_at(chords, int(i[k]), float(x[k])), _at(chords, int(j[k]), float(y[k])))
        apart, s, at, sine = _nearest(rods[a], rods[b], s)
        if apart <= reach[k] and sine > ALONG and apart < best.get((a, b), (np.inf, None))[0]:
            best[a, b] = apart, _Crossing((problem.rods[a], problem.rods[b]), (a, b), s, at)
    return [crossing for _, crossing in best.values()]


def _nearest(a: Rod, b: Rod, s: tuple[float, float]) -> tuple[float, tuple[float, float], Floats, float]:
    """Return distance [m], arc lengths, position and sine of the angle where two rods are nearest, from near there."""
    first, second = s
    for _ in range(NEWTON):
        (p, frame), (q, other) = (
            a.centreline.bishop(np.array([first])),
            b.centreline.bishop(np.array([second])),
        )
        t, u, apart = frame[0][:, 2], other[0][:, 2], q[0] - p[0]
        cosine = float(t @ u)
        sine2 = max(1.0 - cosine**2, 1e-12)
        step = (float(apart @ t) - cosine * float(apart @ u)) / sine2
        back = (cosine * float(apart @ t) - float(apart @ u)) / sine2
        moved = min(max(first + step, 0.0), a.length), min(max(second + back, 0.0), b.length)
        if moved == (first, second):
            break
        first, second = moved
    p, q = a.centreline.bishop(np.array([first]))[0][0], b.centreline.bishop(np.array([second]))[0][0]
    return float(np.linalg.norm(q - p)), (first, second), p, float(np.sqrt(sine2))


def _at(chords: _Chords, k: int, x: float) -> float:
    return float(chords.s[k, 0] + x * (chords.s[k, 1] - chords.s[k, 0]))


def _size(chords: _Chords, k: Integers) -> Floats:
    return np.asarray(np.linalg.norm(chords.b[k] - chords.a[k], axis=1))


def _chords(rods: list[Rod]) -> _Chords:
    """Return chords of all rods; of straight ones the rod itself."""
    rod, s, a, b = [], [], [], []
    for index, one in enumerate(rods):
        count = 1
        if not isinstance(one.centreline, Straight):
            samples = np.linspace(0.0, one.length, 33)
            bent = np.linalg.norm(one.centreline.curvature(samples), axis=1)
            count = int(np.clip(np.ceil(float(bent.max()) * one.length / CHORD), 8, MOST_CHORDS))
        at = np.linspace(0.0, one.length, count + 1)
        points = one.centreline.bishop(at)[0]
        rod.append(np.full(count, index))
        s.append(np.column_stack([at[:-1], at[1:]]))
        a.append(points[:-1])
        b.append(points[1:])
    return _Chords(*(np.concatenate(part) for part in (rod, s, a, b)))


def _near_chords(chords: _Chords, reach: Floats) -> Integers:
    """Return pairs (m, 2) of chords of different rods whose boxes overlap; none if there are too many."""
    none = np.zeros((0, 2), dtype=np.int64)
    if len(chords.rod) > MOST_CHORDS:
        return none
    margin = reach[chords.rod][:, None] + CHORD / 8.0 * np.linalg.norm(chords.b - chords.a, axis=1)[:, None]
    low = np.minimum(chords.a, chords.b) - margin
    high = np.maximum(chords.a, chords.b) + margin
    axis = int(np.argmax(high.max(axis=0) - low.min(axis=0)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high, rod = low[order], high[order], chords.rod[order]
    until = np.searchsorted(low[:, axis], high[:, axis], side="right")
    count = np.maximum(until - np.arange(len(order)) - 1, 0)
    if count.sum() > MOST_PAIRS:
        return none
    i = np.repeat(np.arange(len(order)), count)
    j = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + i + 1
    kept = (rod[i] != rod[j]) & (low[i] <= high[j]).all(axis=1) & (low[j] <= high[i]).all(axis=1)
    pairs = order[np.column_stack([i[kept], j[kept]])]
    turned = chords.rod[pairs[:, 0]] > chords.rod[pairs[:, 1]]
    pairs[turned] = pairs[turned][:, ::-1]
    return np.asarray(pairs, dtype=np.int64)


def _between(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the distances [m] of segments a-b and c-d (m, 3), and where on them (0 to 1) they are nearest."""
    u, v, w = b - a, d - c, c - a
    uu, vv, uv = (np.einsum("ki,ki->k", p, q) for p, q in ((u, u), (v, v), (u, v)))
    uw, vw = (np.einsum("ki,ki->k", p, w) for p in (u, v))
    area = uu * vv - uv**2
    x = np.where(area > 1e-12 * uu * vv, (uw * vv - vw * uv) / np.where(area > 0.0, area, 1.0), 0.5)
    x = np.clip(x, 0.0, 1.0)
    y = np.clip((uv * x - vw) / vv, 0.0, 1.0)
    x = np.clip((uv * y + uw) / uu, 0.0, 1.0)
    return np.linalg.norm(w + y[:, None] * v - x[:, None] * u, axis=1), x, y


def _loose_ends(problem: Problem, joined: Integers) -> Iterator[str]:
    """Yield which ends of rods are at the same place without being joined there."""
    nodes, positions, lengths = _ends(problem)
    pairs = _near(positions, TOGETHER * lengths)
    if not len(pairs):
        return
    part = joined[nodes]
    loose = {tuple(sorted(part[pair].tolist())): pair for pair in pairs if part[pair[0]] != part[pair[1]]}
    if loose:
        names = [f"{rod}.{end}" for rod in problem.rods for end in ("start", "end")]
        couples = some_of([f"{names[a]} and {names[b]}" for a, b in loose.values()])
        yield (
            f"{couples} are at the same place, and nothing joins them there: they move apart; attach them (rigid), or "
            "give a joint or a support, if they belong together"
        )


def _ends(problem: Problem) -> tuple[Integers, Floats, Floats]:
    """Return node, position [m] and length of the rod [m] of the start and end of every rod, one after the other."""
    stations = problem.stations
    first = np.searchsorted(stations.rod, np.arange(len(problem.rods)))
    last = np.append(first[1:], len(stations.rod)) - 1
    at = np.column_stack([first, last]).ravel()
    nodes, links = stations.nodes[at], stations.links[at]
    positions = problem.positions[nodes].copy()
    away = links >= 0
    turn = matrices(problem.quaternions[nodes[away]])
    positions[away] += np.einsum("kij,kj->ki", turn, problem.link_positions[links[away]])
    return nodes, positions, np.repeat(problem.rod_lengths, 2)


def _near(positions: Floats, reach: Floats) -> Integers:
    """Return pairs of places (m, 2), a < b, no farther from each other than the reach of both."""
    from scipy.spatial import KDTree

    pairs = KDTree(positions).query_pairs(float(reach.max()), output_type="ndarray")
    distance = np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)
    return np.asarray(pairs[distance <= reach[pairs].min(axis=1)], dtype=np.int64)


def _joined(problem: Problem) -> Integers:
    """Return a number of every node; nodes that joints, springs or supports at the ground connect have the same."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    ground = problem.size
    links = np.where(problem.joints.arrays.nodes < 0, ground, problem.joints.arrays.nodes)
    held = problem.supports.nodes
    a, b = np.append(links[:, 0], held), np.append(links[:, 1], np.full(len(held), ground))
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(ground + 1, ground + 1))
    return np.asarray(connected_components(graph, directed=False)[1])
