"""Rigid motions that the supports leave free, in words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.mechanics.joints import measure
from viscorod.mechanics.quaternion import matrices
from viscorod.solve.problem import Problem
from viscorod.typing import Floats

_NAMES = (
    "translation along x",
    "translation along y",
    "translation along z",
    "rotation about x",
    "rotation about y",
    "rotation about z",
)


@dataclass(frozen=True)
class FreeMotion:
    """One motion of rigid pieces that nothing holds; ``increments (n, 6)`` are the nodal body increments."""

    text: str
    translation: bool
    increments: Floats

    @property
    def size(self) -> float:
        """Largest nodal displacement of the motion [m]; 1 for a turning about the rod's own axis."""
        return float(np.abs(self.increments[:, :3]).max()) or 1.0


def free_motions(problem: Problem) -> list[FreeMotion]:
    """Return the motions that supports, joints and springs allow rigid assemblies in the reference shape.

    What joints or springs connect moves together: as one, or as a mechanism.
    """
    found: list[FreeMotion] = []
    assemblies, labels = _assemblies(problem)
    R = matrices(problem.quaternions)
    groups = _groups(problem, assemblies, labels)
    for pieces in groups:
        if len(pieces) > 1 or _linked(problem, labels, pieces).any():
            found += _mechanisms(problem, labels, pieces, R)
    alone = [
        pieces[0] for pieces in groups if len(pieces) == 1 and not _linked(problem, labels, pieces).any()
    ]
    for label in alone:
        nodes = np.flatnonzero(labels == label)
        centre = problem.positions[nodes].mean(axis=0)
        name = _name(problem, nodes)
        rows = []
        for k, node in enumerate(problem.supports.nodes):
            if labels[node] != label:
                continue
            A = R[node] if problem.supports.in_body[k] else problem.supports.axes[k]
            arm = problem.positions[node] - centre
            moves = np.zeros((6, 6))
            moves[:3, :3] = A.T
            moves[:3, 3:] = A.T @ skew(-arm) / problem.length
            moves[3:, 3:] = A.T
            rows.append(moves[problem.supports.fixed[k] > 0.0])
        for motion in _null_space(np.concatenate([np.zeros((1, 6)), *rows])):
            t, w = motion[:3], motion[3:] / problem.length
            increments = np.zeros((problem.size, 6))
            velocity = t + np.cross(w, problem.positions[nodes] - centre)
            increments[nodes, :3] = np.einsum("nji,nj->ni", R[nodes], velocity)
            increments[nodes, 3:] = np.einsum("nji,j->ni", R[nodes], w)
            still = float(np.abs(w).max()) * problem.length < 1e-6
            found.append(FreeMotion(f"{_describe(motion, centre, problem.length)}{name}", still, increments))
    return found


def _linked(problem: Problem, labels: np.ndarray, pieces: list[int]) -> np.ndarray:
    """Tell which coordinates of joints, and of springs with a stiffness, are at one of some pieces."""
    arrays = problem.joints.arrays
    acts = (arrays.place >= 0) | (arrays.stiffness != 0.0) | (arrays.law >= 0)
    at = np.isin(np.append(labels, -1)[arrays.nodes], pieces).any(axis=1)
    return np.asarray(acts & at)


def _groups(problem: Problem, assemblies: int, labels: np.ndarray) -> list[list[int]]:
    """Assemblies that joints and springs connect."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    ends = np.append(labels, -1)[problem.joints.arrays.nodes]
    a, b = ends[(ends >= 0).all(axis=1)].T
    graph = csr_array((np.ones(len(a)), (a, b)), shape=(assemblies, assemblies))
    count, group = connected_components(graph, directed=False)
    return [np.flatnonzero(group == k).tolist() for k in range(count)]


def _mechanisms(problem: Problem, labels: np.ndarray, pieces: list[int], R: Floats) -> list[FreeMotion]:
    """Return the motions of pieces that joints or springs connect: those as one first, then the others."""
    inside = np.flatnonzero(np.isin(labels, pieces))
    centre = problem.positions[inside].mean(axis=0)
    # nodal body increments per rigid motion (t, w length) of the node's piece about the common centre
    moves = np.zeros((problem.size, 6, 6))
    moves[:, :3, :3] = np.swapaxes(R, 1, 2)
    moves[:, :3, 3:] = np.swapaxes(R, 1, 2) @ skew(centre - problem.positions) / problem.length
    moves[:, 3:, 3:] = np.swapaxes(R, 1, 2) / problem.length
    rows = [np.zeros((1, 6 * len(pieces)))]

    def add(node: int, gradient: Floats, row: Floats) -> None:
        k = pieces.index(int(labels[node]))
        row[..., 6 * k : 6 * k + 6] += gradient @ moves[node]

    for k, node in enumerate(problem.supports.nodes):
        if labels[node] not in pieces:
            continue
        own = np.eye(3) if problem.supports.in_body[k] else problem.supports.axes[k].T @ R[node]
        gradient = np.zeros((6, 6))
        gradient[:3, :3], gradient[3:, 3:] = own, problem.length * own
        held = np.zeros((6, 6 * len(pieces)))
        add(int(node), gradient, held)
        rows.append(held[problem.supports.fixed[k] > 0.0])
    arrays = problem.joints.arrays
    gradients, unit = np.zeros((problem.joints.count, 12)), problem.length / problem.joints.unit
    still, (near, value, rate) = np.zeros((problem.size, 6)), np.zeros((3, problem.joints.count))
    measure(
        arrays.nodes,
        arrays.kind,
        arrays.geometry,
        problem.positions,
        problem.quaternions,
        still,
        near,
        value,
        rate,
        gradients,
    )
    for c in np.flatnonzero(_linked(problem, labels, pieces)):
        row = np.zeros((1, 6 * len(pieces)))
        for side, node in enumerate(arrays.nodes[c]):
            if node >= 0:
                add(int(node), unit[c] * gradients[c : c + 1, 6 * side : 6 * side + 6], row)
        rows.append(row)
    conditions = np.concatenate(rows)
    together = np.tile(np.eye(6), (len(pieces), 1))
    as_one = _null_space(conditions @ together) if len(pieces) > 1 else _null_space(conditions)
    _, values, basis = np.linalg.svd(conditions)
    null = basis[int(np.count_nonzero(values > 1e-9)) :]
    rigid = np.array([together @ motion for motion in as_one]).reshape(-1, 6 * len(pieces))
    if len(rigid):
        known, _ = np.linalg.qr(rigid.T)
        null = null - (null @ known) @ known.T
    _, values, basis = np.linalg.svd(null)
    others = basis[: int(np.count_nonzero(values > 1e-6))]
    found = []
    for motion, one in [*((m, True) for m in rigid), *((m, False) for m in others)]:
        increments = np.zeros((problem.size, 6))
        parts = motion.reshape(-1, 6)
        increments[inside] = np.einsum(
            "nij,nj->ni", moves[inside], parts[np.searchsorted(pieces, labels[inside])]
        )
        moving = inside[np.abs(increments[inside]).max(axis=1) > 1e-6 * np.abs(increments).max()]
        name = _name(problem, moving)
        text = _describe(parts[0], centre, problem.length) if one else "a motion in the joints"
        still_turn = one and float(np.abs(parts[0, 3:]).max()) < 1e-6
        found.append(FreeMotion(f"{text}{name}", still_turn, increments))
    return found


def undetermined(
    problem: Problem, external: Floats, stiffness: sparse.csc_array, motions: list[FreeMotion]
) -> list[FreeMotion]:
    """Return the free motions to be named because no equilibrium is near the reference shape; none if there is one.

    Loads keep a motion in place if they do no work on it and their tangent resists it: a pendulum that hangs. If they
    drive one motion, all free ones are named.

    Args:
        problem: what the motions belong to.
        external: external forces in the reference shape, body components ``(n, 6)``.
        stiffness: tangent there, loads included, before supports ``(6 n, 6 n)``.
        motions: from :func:`free_motions`.
    """
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
    loose = values < 1e-6 * force / problem.length
    share = np.abs(vectors[:, loose]).max(axis=1, initial=0.0)
    return [m for m, part in zip(motions, share, strict=True) if part > 0.1]


def _assemblies(problem: Problem) -> tuple[int, np.ndarray]:
    if len(problem.rods) == 1 and not problem.bodies.names:
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
    rods = [problem.rods[i] for i in sorted(set(problem.stations.rod[inside].tolist()))]
    bodies = problem.bodies
    rods += [n for n, node in zip(bodies.names, bodies.nodes, strict=True) if "." not in n and node in nodes]
    shown = ", ".join(rods[:3]) + (", ..." if len(rods) > 3 else "")
    return f" of {shown}"


def skew(a: Floats) -> Floats:
    """Return ``[a]x`` of vectors ``(..., 3)`` as matrices ``(..., 3, 3)``."""
    out = np.zeros((*a.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = a[..., 2], -a[..., 1], a[..., 0]
    return out


def _null_space(rows: Floats) -> list[Floats]:
    """Basis of the null space, along the six coordinate motions where possible."""
    _, values, basis = np.linalg.svd(rows)
    rank = int(np.count_nonzero(values > 1e-9))
    null = basis[rank:]
    result: list[Floats] = []
    for i in range(6):
        unit = np.eye(6)[i]
        if len(null) and np.linalg.norm(null @ unit) > 1.0 - 1e-9:
            result.append(unit)
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
