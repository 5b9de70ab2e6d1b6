"""Rigid motions that the supports leave free, in words."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from scipy import sparse

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

_NAMES = (
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
)


RESISTED = 1e-6
"""Stiffness against a motion, as a part of all forces over the length, from which on loads resist it."""
ROUND_OFF = 1e-8
"""The same for one translation, as a part of what adds up to it, that is no more than rounding."""
MANY = 120
"""Parts that joints join above which their free motions are not found one by one: full matrices would be too large."""


@dataclass(frozen=True)
class FreeMotion:
    """One rigid motion of an assembly that nothing holds; ``increments (n, 6)`` are the nodal body increments."""

    text: str
    translation: bool
    increments: Floats

    @property
    def size(self) -> float:
        """Largest nodal displacement of the motion [m]; 1 for a rotation about the rod's own axis."""
        return float(np.abs(self.increments[:, :3]).max()) or 1.0


def free_motions(problem: Problem) -> list[FreeMotion]:
    """Return the rigid motions of all parts that supports, joints and springs allow in the reference shape.

    A part is what shares nodes: rods with their attachments and bodies. Parts move together where joints join them.
    """
    r, q = problem.positions, problem.quaternions
    R, joints = matrices(q), problem.joints
    held = _held(problem, R)
    gradients = joints.measure(r, q, np.zeros((problem.size, 6)))[2]
    counted = (joints.arrays.place >= 0) | joints.has_spring
    parts = _Parts.of(problem, r, q)
    return [parts.motion(group, motion) for group, motion in parts.free(held, gradients, counted)]


def _held(problem: Problem, R: Floats) -> list[Floats]:
    """Return the derivatives ``(6, 6)`` of the motions of every support by the body increment of its node."""
    held = []
    for k, node in enumerate(problem.supports.nodes):
        A = R[node] if problem.supports.in_body[k] else problem.supports.axes[k]
        held.append(np.kron(np.eye(2), A.T @ R[node]))
    return held


def jointed_parts(problem: Problem) -> int:
    """Return how many parts joints and springs join at most: 1 where there are none."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    nodes = problem.joints.arrays.nodes
    pairs = nodes[(nodes >= 0).all(axis=1)]
    if not len(pairs):
        return 1
    count, labels = _parts(problem)
    joined = labels[pairs]
    graph = csr_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(count, count))
    return int(np.bincount(connected_components(graph, directed=False)[1]).max())


def many_parts(problem: Problem) -> int:
    """Return how many parts are joined where these are too many for their free motions to be listed, else 0."""
    count = jointed_parts(problem)
    return count if count > MANY else 0


def undetermined_of_many(
    problem: Problem, external: Floats, stiffness: sparse.csc_array
) -> list[FreeMotion] | None:
    """Return what :func:`undetermined` does without finding single motions: for models of very many joined parts.

    Loads keep them in place if they do no work on motions that supports and joints allow, and their tangent resists
    all of these. Springs count as no conditions here; they are in the stiffness. The work is that of the part of the
    forces on parts that conditions do not balance, and by Sylvester's law ``[[K - k 1, A'], [A, 0]]`` has as many
    negative pivots as conditions ``A`` where every motion allowed is stiffer than ``k``.

    Args:
        problem, external, stiffness: see :func:`undetermined`.

    Returns:
        none if loads keep all in place; one that stands for all, where some are left and none is a translation; None
        where that is not known.
    """
    r, q = problem.positions, problem.quaternions
    parts, joints = _Parts.of(problem, r, q), problem.joints
    gradients = joints.measure(r, q, np.zeros((problem.size, 6)))[2]
    conditions = parts.conditions(_held(problem, parts.R), gradients, joints.arrays.place >= 0)
    rows, columns, values, first = [], [], [], 0
    for condition in conditions:
        for part, row in condition:
            at = np.indices(row.shape)
            rows.append(first + at[0].ravel())
            columns.append(6 * part + at[1].ravel())
            values.append(row.ravel())
        first += len(condition[0][1])
    force = float(np.abs(external[:, :3]).sum()) + float(np.abs(external[:, 3:]).sum()) / problem.length
    if force == 0.0 or not first:
        return None
    size = 6 * parts.count
    A = sparse.coo_array(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=(first, size)
    ).tocsr()
    A.sum_duplicates()
    still = sparse.csr_array(A[:, np.flatnonzero(np.arange(size) % 6 < 3)])
    moved = sparse.csr_array(still.T @ still - 1e-12 * sparse.eye_array(size // 2))
    if negative_eigenvalues(Tangent(moved, sparse.csc_array(moved), None)):
        return None  # a translation is free
    text = f"motions of {parts.count} joined parts against each other, which are too many to be listed"
    loose = [FreeMotion(text, False, np.zeros((problem.size, 6)))]
    T = parts.moves()
    pushed = np.asarray(T.T @ external.ravel())
    K = sparse.csr_array(0.5 * (T.T @ (stiffness + stiffness.T) @ T))
    try:
        balance = SparseLU(sparse.block_array([[sparse.eye_array(size), A.T], [A, None]]))
    except RuntimeError:
        return loose
    left = balance.solve(np.concatenate([pushed, np.zeros(first)]))[:size]
    if not np.abs(left).max() <= 1e-9 * force:
        return loose
    least = RESISTED * force / problem.length
    tangent = Tangent(
        sparse.csr_array(K - least * sparse.eye_array(size)),
        sparse.csc_array(T),
        unit_rows(sparse.csr_array(A)),
    )
    return loose if negative_eigenvalues(tangent) else []


def rigid_share(problem: Problem, r: Floats, q: Floats, increments: np.ndarray) -> Floats:
    """Return the part ``(m,)`` of the kinetic energy of nodal velocities ``(6 n, m)`` in rigid motions of parts."""
    parts = _Parts.of(problem, r, q)
    T, M = parts.moves(), block_diagonal(problem.mass)
    momenta = T.T @ (M @ increments)
    inertia = sparse.bsr_array(T.T @ M @ T, blocksize=(6, 6))
    inertia.sort_indices()
    blocks = np.zeros((parts.count, 6, 6))
    blocks[inertia.indices] = inertia.data
    own = momenta.reshape(parts.count, 6, -1)
    moving = np.linalg.pinv(blocks, rcond=1e-12, hermitian=True) @ own
    energy = np.einsum("im,im->m", increments.conj(), M @ increments).real
    return np.asarray(np.einsum("pim,pim->m", own.conj(), moving).real / energy)


def motions_of_parts(
    problem: Problem, r: Floats, q: Floats, held: list[Floats], gradients: Floats
) -> RigidParts:
    """Return the rigid motions of all parts that supports and joints allow in a state; springs resist them.

    Elements do not, however they are strained, so that loads and springs alone decide which of them are free. Of very
    many joined parts only motions of single ones are found, such as the spin of a rod between ball joints.

    Args:
        problem: whose parts they are; r, q: poses of its nodes.
        held: derivatives ``(6, 6)`` of the motions of every support by the body increment of its node.
        gradients: of all coordinates of joints ``(c, 12)``.
    """
    parts = _Parts.of(problem, r, q)
    search = parts.free_alone if many_parts(problem) else parts.free
    return RigidParts(parts, search(held, gradients, problem.joints.arrays.place >= 0))


@dataclass(frozen=True)
class RigidParts:
    """Rigid motions of parts; ``increments (6 n, k)`` are their nodal body increments, in lengths of the model."""

    parts: _Parts
    found: list[tuple[list[int], Floats]]

    @cached_property
    def increments(self) -> Floats:
        """Nodal body increments ``(6 n, k)``."""
        moves = np.zeros((len(self.found), self.parts.count, 6))
        for k, (group, motion) in enumerate(self.found):
            moves[k, group] = motion.reshape(-1, 6)
        return self.parts.increments(moves).reshape(len(moves), -1).T.copy()

    def combined(self, weights: Floats) -> list[FreeMotion]:
        """Return as many motions as ``weights (k, m)`` combine, single ones of single parts where possible."""
        if weights.shape[1] == len(self.found):
            return [self.parts.motion(group, motion) for group, motion in self.found]
        every = list(range(self.parts.count))
        columns = np.zeros((6 * self.parts.count, len(self.found)))
        for k, (group, motion) in enumerate(self.found):
            columns.reshape(-1, 6, len(self.found))[group, :, k] = motion.reshape(-1, 6)
        allowed, _ = np.linalg.qr(columns @ weights)
        across = np.eye(len(allowed)) - allowed @ allowed.T
        return [self.parts.motion(every, motion) for motion in _null_space(across, 1e-6)]


Condition: TypeAlias = list[tuple[int, Floats]]
"""Parts and the rows ``(k, 6)`` by which their motions (velocity of the centre, spin times length) must vanish."""


@dataclass(frozen=True)
class _Parts:
    """Parts of a problem in a state: their number, the part of every node, and the mean positions of their nodes."""

    problem: Problem
    r: Floats
    R: Floats
    count: int
    labels: np.ndarray
    centres: Floats

    @classmethod
    def of(cls, problem: Problem, r: Floats, q: Floats) -> _Parts:
        count, labels = _parts(problem)
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
            found += [(group, motion) for motion in _null_space(matrix)]
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
            ([part], motion) for part, mine in enumerate(rows) for motion in _null_space(np.concatenate(mine))
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

    def motion(self, group: list[int], motion: Floats) -> FreeMotion:
        """Describe one motion of a group of parts and give its nodal increments."""
        problem, centres, labels = self.problem, self.centres, self.labels
        moves = motion.reshape(-1, 6)
        every = np.zeros((1, self.count, 6))
        every[0, group] = moves
        increments = self.increments(every)[0]
        size = np.linalg.norm(moves, axis=1)
        moving = [k for k in np.argsort(-size, kind="stable") if size[k] > 1e-6 * size.max()]
        first = moving[0]
        text = f"{_describe(moves[first] / size[first], centres[group[first]], problem.length)}"
        text += _name(problem, np.flatnonzero(labels == group[first]))
        if len(moving) > 1:
            others = len(moving) - 1
            text += f", with {others} more part{'s' if others > 1 else ''} moving along"
        still = float(np.abs(moves[:, 3:]).max()) < 1e-6 * float(np.abs(moves).max())
        return FreeMotion(text, still, increments)


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
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    pairs = np.array([(c[0][0], c[-1][0]) for c in conditions] or [(0, 0)])
    graph = csr_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(parts, parts))
    count, label = connected_components(graph, directed=False)
    groups: list[tuple[list[int], list[Condition]]] = [([], []) for _ in range(int(count))]
    for part, k in enumerate(label):
        groups[k][0].append(part)
    for condition in conditions:
        groups[label[condition[0][0]]][1].append(condition)
    return groups


def undetermined(
    problem: Problem, external: Floats, stiffness: sparse.csc_array, motions: list[FreeMotion]
) -> list[FreeMotion]:
    """Return the free motions to be named because no equilibrium is near the reference shape; none if there is one.

    Loads keep a motion in place if they do no work on it and their tangent resists it: a pendulum that hangs. If they
    drive one motion, all free ones are named.

    Args:
        problem: of the motions.
        external: external forces in the reference shape, body components ``(n, 6)``.
        stiffness: tangent there, loads included, before supports ``(6 n, 6 n)``.
        motions: from :func:`free_motions`.
    """
    if any(load.law.at_rest for load in problem.motion_loads):  # such as a foundation
        motions = [m for m in motions if not (m.translation and _resisted(m, stiffness))]
    if not motions:
        return []
    force = float(np.abs(external[:, :3]).sum()) + float(np.abs(external[:, 3:]).sum()) / problem.length
    driven = [
        m for m in motions if m.translation or abs(np.sum(m.increments * external)) > 1e-9 * force * m.size
    ]
    if driven or force == 0.0:
        return motions
    basis = np.array([m.increments.ravel() / m.size for m in motions]).T
    values, vectors = np.linalg.eigh(basis.T @ (stiffness + stiffness.T) @ basis / 2.0)
    loose = values < RESISTED * force / problem.length
    share = np.abs(vectors[:, loose]).max(axis=1, initial=0.0)
    return [m for m, part in zip(motions, share, strict=True) if part > 0.1]


def _resisted(motion: FreeMotion, stiffness: sparse.csc_array) -> bool:
    """Return whether a stiffness resists a motion by more than round-off."""
    x = motion.increments.ravel()
    return bool(x @ (stiffness @ x) > ROUND_OFF * (np.abs(x) @ (abs(stiffness) @ np.abs(x))))


def _parts(problem: Problem) -> tuple[int, np.ndarray]:
    """Number of parts, and the part of every node."""
    if len(problem.rods) == 1 and problem.size == len(problem.stations.nodes):
        return 1, np.zeros(problem.size, dtype=np.int64)
    rows = np.concatenate([s.nodes[:, :-1].ravel() for s in problem.sets])
    cols = np.concatenate([s.nodes[:, 1:].ravel() for s in problem.sets])
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    graph = csr_array((np.ones(len(rows)), (rows, cols)), shape=(problem.size, problem.size))
    count, labels = connected_components(graph, directed=False)
    return int(count), labels


def _name(problem: Problem, nodes: np.ndarray) -> str:
    if len(problem.rods) == 1 and not problem.bodies.names:
        return ""
    inside = np.isin(problem.stations.nodes, nodes)
    names = [problem.rods[i] for i in sorted(set(problem.stations.rod[inside].tolist()))]
    bodies = zip(problem.bodies.names, problem.bodies.nodes, strict=True)
    names += [name for name, node in bodies if node in nodes and "." not in name]
    return f" of {', '.join(names[:3])}{', ...' if len(names) > 3 else ''}"


def skew(a: Floats) -> Floats:
    """Return ``[a]x`` of vectors ``(..., 3)`` as matrices ``(..., 3, 3)``."""
    out = np.zeros((*a.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = a[..., 2], -a[..., 1], a[..., 0]
    return out


def _null_space(rows: Floats, tolerance: float = 1e-9) -> list[Floats]:
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


def _describe(motion: Floats, centre: Floats, length: float) -> str:
    main = int(np.argmax(np.abs(motion)))
    if abs(abs(motion[main]) - 1.0) < 1e-6 and main < 3:
        return _NAMES[main]
    t, w = motion[:3], motion[3:] / length
    if np.linalg.norm(w) * length < 1e-6:
        return f"translation along ({', '.join(f'{x:.3g}' for x in t / np.linalg.norm(t))})"
    point = centre + np.cross(w, t) / (w @ w)
    through = ", ".join(f"{x:.4g}" for x in np.where(np.abs(point) < 1e-9 * length, 0.0, point))
    direction = w / np.linalg.norm(w)
    axis = int(np.argmax(np.abs(direction)))
    if abs(direction[axis]) > 1.0 - 1e-6:
        return f"{_NAMES[3 + axis]} through ({through})"
    return f"rotation about ({', '.join(f'{x:.3g}' for x in direction)}) through ({through})"
