"""The parts of a model, each of which moves as one if nothing strains: what shares nodes, rods with all attached."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from viscorod.mechanics.rotations.adjoint_maps import skew
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["Parts", "count_of_parts", "held_motions", "jointed_parts", "many_parts", "null_space"]

MANY = 120
"""Parts that joints join above which their free motions are not found one by one: full matrices would be too large."""

Condition: TypeAlias = list[tuple[int, Floats]]
"""Parts and the rows ``(k, 6)`` by which their motions (velocity of the centre, spin times length) must vanish."""


@dataclass(frozen=True)
class Parts:
    """Parts of a problem in a state, whose motions are velocity of the centre and spin times the model's length.

    Attributes:
        r, R: positions ``(n, 3)`` and frames ``(n, 3, 3)`` of the nodes.
        count: number of parts; labels: the part of every node ``(n,)``; centres: means of their nodes ``(count, 3)``.
    """

    problem: Problem
    r: Floats
    R: Floats
    count: int
    labels: np.ndarray
    centres: Floats

    @classmethod
    def of(cls, problem: Problem, r: Floats, q: Floats) -> Parts:
        """Return the parts where nodes are at ``r (n, 3)`` with quaternions ``q (n, 4)``."""
        count, labels = _numbered(problem)
        centres = np.zeros((count, 3))
        np.add.at(centres, labels, r)
        centres /= np.bincount(labels, minlength=count)[:, None]
        return cls(problem, r, matrices(q), count, labels, centres)

    def free(
        self, held: list[Floats], gradients: Floats, counted: np.ndarray
    ) -> list[tuple[list[int], Floats]]:
        """Return groups of parts, each with a motion of them that supports and ``counted`` coordinates allow."""
        found = []
        conditions = self.conditions(held, gradients, counted)
        for group, mine in _groups(self.count, conditions):
            place = {part: 6 * k for k, part in enumerate(group)}
            rows = [_row(condition, place) for condition in mine]
            matrix = np.concatenate([np.zeros((1, 6 * len(group))), *rows])
            found += [(group, motion) for motion in null_space(matrix)]
        return found

    def free_alone(
        self, held: list[Floats], gradients: Floats, counted: np.ndarray
    ) -> list[tuple[list[int], Floats]]:
        """Return parts, each with a motion of this one alone that supports and ``counted`` coordinates allow."""
        rows: list[list[Floats]] = [[np.zeros((1, 6))] for _ in range(self.count)]
        for condition in self.conditions(held, gradients, counted):
            for part, values in condition:
                rows[part].append(values)
        return [
            ([part], motion) for part, mine in enumerate(rows) for motion in null_space(np.concatenate(mine))
        ]

    def node_increments(self, node: int) -> Floats:
        """Return the body increments (6, 6) of a node per motion of its part."""
        R, out, length = self.R[node], np.zeros((6, 6)), self.problem.length
        out[:3, :3] = R.T
        out[:3, 3:] = R.T @ skew(self.centres[self.labels[node]] - self.r[node]) / length
        out[3:, 3:] = R.T / length
        return out

    def moves(self) -> sparse.csr_array:
        """Return the body increments of all nodes per motion of the parts ``(6 n, 6 parts)``."""
        n = self.problem.size
        moves = np.array([self.node_increments(node) for node in range(n)])
        places = 6 * np.repeat(np.arange(n), 36) + np.tile(np.repeat(np.arange(6), 6), n)
        own = 6 * np.repeat(self.labels, 36) + np.tile(np.arange(6), 6 * n)
        return sparse.csr_array((moves.ravel(), (places, own)), shape=(6 * n, 6 * self.count))

    def conditions(self, held: list[Floats], gradients: Floats, counted: np.ndarray) -> list[Condition]:
        """Return the conditions of supports and of ``counted`` coordinates on the motions of parts."""
        problem, labels, found = self.problem, self.labels, []
        unit = np.repeat([1.0, problem.length], 3)
        for k, node in enumerate(problem.supports.nodes):
            moves = unit[:, None] * (held[k] @ self.node_increments(node))
            rows = moves[problem.supports.fixed[k] > 0.0]
            size = np.linalg.norm(rows, axis=1, keepdims=True)
            found.append([(int(labels[node]), rows / np.where(size > 0.0, size, 1.0))])
        for c in np.flatnonzero(counted):
            sides = [
                (side, int(node)) for side, node in enumerate(problem.joints.arrays.nodes[c]) if node >= 0
            ]
            rows = [
                (int(labels[n]), gradients[c, 6 * side : 6 * side + 6] @ self.node_increments(n))
                for side, n in sides
            ]
            size = max(float(np.abs(row).max()) for _, row in rows)
            if size > 0.0:
                found.append([(part, row[None] / size) for part, row in rows])
        return found

    def increments(self, moves: Floats) -> Floats:
        """Return the body increments ``(m, n, 6)`` of all nodes in motions of the parts ``(m, parts, 6)``."""
        each = moves[:, self.labels]
        w = each[..., 3:] / self.problem.length
        velocity = each[..., :3] + np.cross(w, self.r - self.centres[self.labels])
        turned = [np.einsum("nji,mnj->mni", self.R, v) for v in (velocity, w)]
        return np.concatenate(turned, axis=-1)

    def condition_matrix(self, conditions: list[Condition]) -> sparse.csr_array:
        """Return conditions as a matrix ``(rows, 6 parts)``."""
        rows, columns, values, first = [], [], [], 0
        for condition in conditions:
            for part, row in condition:
                at = np.indices(row.shape)
                rows.append(first + at[0].ravel())
                columns.append(6 * part + at[1].ravel())
                values.append(row.ravel())
            first += len(condition[0][1])
        shape = first, 6 * self.count
        if not first:
            return sparse.csr_array(shape)
        places = np.concatenate(rows), np.concatenate(columns)
        A = sparse.coo_array((np.concatenate(values), places), shape=shape).tocsr()
        A.sum_duplicates()
        return A


def held_motions(problem: Problem, R: Floats) -> list[Floats]:
    """Return the derivatives ``(6, 6)`` of the motions of every support by the body increment of its node."""
    held = []
    for k, node in enumerate(problem.supports.nodes):
        A = R[node] if problem.supports.in_body[k] else problem.supports.axes[k]
        held.append(np.kron(np.eye(2), A.T @ R[node]))
    return held


def jointed_parts(problem: Problem) -> int:
    """Return how many parts joints and springs join at most: 1 where there are none."""
    nodes = problem.joints.arrays.nodes
    pairs = nodes[(nodes >= 0).all(axis=1)]
    if not len(pairs):
        return 1
    count, labels = _numbered(problem)
    return int(np.bincount(_joined(labels[pairs], count)[1]).max())


def many_parts(problem: Problem) -> int:
    """Return how many parts are joined where these are too many for their free motions to be listed, else 0."""
    count = jointed_parts(problem)
    return count if count > MANY else 0


def null_space(rows: Floats, tolerance: float = 1e-9) -> list[Floats]:
    """Return a basis of the null space, along the coordinate motions of single parts where possible."""
    _, values, basis = np.linalg.svd(rows)
    rank = int(np.count_nonzero(values > tolerance))
    null = basis[rank:]
    count = rows.shape[1]
    result: list[Floats] = []
    for i in range(count):
        if len(null) and np.linalg.norm(null[:, i]) > 1.0 - tolerance:
            result.append(np.eye(1, count, i)[0])
    if result:
        known = np.array(result)
        null = null - (null @ known.T) @ known
    if len(null):
        _, values, basis = np.linalg.svd(null)
        result.extend(basis[k] for k in range(len(values)) if values[k] > 1e-6)
    return result


def count_of_parts(problem: Problem) -> int:
    """Return how many parts there are."""
    return _numbered(problem)[0]


def _numbered(problem: Problem) -> tuple[int, Integers]:
    """Return the number of parts, and the part of every node."""
    if len(problem.rods) == 1 and problem.size == len(problem.stations.nodes):
        return 1, np.zeros(problem.size, dtype=np.int64)
    pairs = [np.stack([s.nodes[:, :-1].ravel(), s.nodes[:, 1:].ravel()], axis=1) for s in problem.sets]
    return _joined(np.concatenate(pairs), problem.size)


def _joined(pairs: Integers, size: int) -> tuple[int, Integers]:
    """Return how many groups ``pairs (k, 2)`` make of ``size`` things, and the group of each."""
    graph = sparse.csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size))
    count, labels = connected_components(graph, directed=False)
    return int(count), labels


def _row(condition: Condition, place: dict[int, int]) -> Floats:
    """Return the rows of a condition in the motions of parts, whose first columns are those of ``place``."""
    row = np.zeros((len(condition[0][1]), 6 * len(place)))
    for part, values in condition:
        row[:, place[part] : place[part] + 6] += values
    return row


def _groups(parts: int, conditions: list[Condition]) -> list[tuple[list[int], list[Condition]]]:
    """Return groups of parts that conditions couple, each with its conditions."""
    if parts == 1:
        return [([0], conditions)]
    count, label = _joined(np.array([(c[0][0], c[-1][0]) for c in conditions] or [(0, 0)]), parts)
    groups: list[tuple[list[int], list[Condition]]] = [([], []) for _ in range(count)]
    for part, k in enumerate(label):
        groups[k][0].append(part)
    for condition in conditions:
        groups[label[condition[0][0]]][1].append(condition)
    return groups
