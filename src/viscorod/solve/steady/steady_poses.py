"""Poses of the nodes from the strains of a steady rotation, and from the stations of a result."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.problem import Problem
from viscorod.solve.steady.rigid_rotation import RotationAxis
from viscorod.typing import Floats


def integrate_poses(
    problem: Problem, elements: Elements, strain: Floats, root: int, position: Floats, rotation: Floats
) -> tuple[Floats, Floats]:
    """Return the poses ``(n, 3)``, ``(n, 4)`` that have given strains, from that of the node ``root`` on.

    Along an element ``q' = q U/2`` and ``r' = R(q) V`` hold at the Gauss points.

    Args:
        strain: from the unstressed shape ``(e, points, 6)``.
    """
    n = problem.size
    r, q = np.zeros((n, 3)), np.zeros((n, 4))
    known = np.zeros(n, dtype=bool)
    r[root], q[root], known[root] = position, rotation, True
    waiting = list(range(len(elements.order)))
    while waiting:
        e = next(
            e for e in waiting if known[elements.nodes[e, : elements.order[e] + 1]].any()
        )  # one that touches what is known; all rods are connected
        waiting.remove(e)
        count = int(elements.order[e]) + 1
        nodes, links = elements.nodes[e, :count], elements.links[e, :count]
        k = int(np.flatnonzero(known[nodes])[0])
        base = _attached(problem, r[nodes[k]], q[nodes[k]], int(links[k]))
        along_r, along_q = _element(elements, e, strain[e], k, *base)
        for j in np.flatnonzero(~known[nodes]):
            r[nodes[j]], q[nodes[j]] = _detached(problem, along_r[j], along_q[j], int(links[j]))
            known[nodes[j]] = True
    return r, q


def poses_about(
    problem: Problem,
    elements: Elements,
    strain: Floats,
    guess: State,
    root: int,
    twist: Floats,
    line: RotationAxis,
) -> tuple[Floats, Floats]:
    """Return the poses with given strains that turn about a line.

    The angular velocity of the node ``root`` is turned into the line by the smallest rotation from its ``guess``, and
    its velocity ``twist (6,)`` tells how far from the line it is; along the line it stays with the guess.
    """
    q = product(_between(matrices(guess.q[root][None])[0] @ twist[3:], line.direction), guess.q[root])
    radius = np.cross(matrices(q[None])[0] @ twist[:3], line.direction) / np.linalg.norm(twist[3:])
    height = float((guess.r[root] - line.centre) @ line.direction)
    return integrate_poses(problem, elements, strain, root, line.centre + radius + height * line.direction, q)


def _element(
    elements: Elements, e: int, strain: Floats, k: int, r: Floats, q: Floats
) -> tuple[Floats, Floats]:
    """Return the poses of an element's nodes from that of its node ``k``."""
    p = int(elements.order[e])
    N, dN = elements.shapes[p, :p, : p + 1], elements.slopes[p, :p, : p + 1] / elements.half_lengths[e]
    total = elements.reference[e, :p] + strain[:p]
    # q U/2 = W(U) q
    W = np.zeros((p, 4, 4))
    U = 0.5 * total[:, 3:]
    W[:, 0, 1:], W[:, 1:, 0] = -U, U
    W[:, 1, 2], W[:, 2, 3], W[:, 3, 1] = U[:, 2], U[:, 0], U[:, 1]
    W[:, 2, 1], W[:, 3, 2], W[:, 1, 3] = -U[:, 2], -U[:, 0], -U[:, 1]
    others = [j for j in range(p + 1) if j != k]
    operator = np.einsum("gj,ab->gajb", dN, np.eye(4)) - np.einsum("gj,gab->gajb", N, W)
    right = -np.einsum("gab,b->ga", operator[:, :, k], q)
    solution = np.linalg.solve(operator[:, :, others].reshape(4 * p, 4 * p), right.ravel())
    along_q = np.empty((p + 1, 4))
    along_q[k], along_q[others] = q, solution.reshape(p, 4)
    inside = N @ along_q
    R = matrices(inside / np.linalg.norm(inside, axis=1, keepdims=True))
    slope = np.einsum("gij,gj->gi", R, total[:, :3])
    along_r = np.empty((p + 1, 3))
    along_r[k] = r
    along_r[others] = np.linalg.solve(dN[:, others], slope - dN[:, k, None] * r)
    return along_r, along_q / np.linalg.norm(along_q, axis=1, keepdims=True)


def _attached(problem: Problem, r: Floats, q: Floats, link: int) -> tuple[Floats, Floats]:
    """Return the pose of a rod end that is attached to a node by ``link`` (-1: the node itself)."""
    if link < 0:
        return r, q
    return r + matrices(q[None])[0] @ problem.link_positions[link], product(q, problem.link_quaternions[link])


def _detached(problem: Problem, r: Floats, q: Floats, link: int) -> tuple[Floats, Floats]:
    """Return the pose of the node from that of a rod end: the inverse of :func:`_attached`."""
    if link < 0:
        return r, q
    node = product(q, conjugate(problem.link_quaternions[link]))
    return r - matrices(node[None])[0] @ problem.link_positions[link], node


def nodal_state(
    problem: Problem, position: Floats, rotation: Floats, velocity: Floats, spin: Floats
) -> State:
    """Return the nodal state that has these fields at the stations.

    Args:
        position ``(stations, 3)`` [m], rotation ``(stations, 4)``; velocity: global axes; spin: body axes of the
            stations.
    """
    n, stations, bodies = problem.size, problem.stations, problem.bodies
    state = State(np.zeros((n, 3)), np.zeros((n, 4)), np.zeros((n, 6)), np.zeros(6 * problem.multipliers))
    nodes = np.concatenate([stations.nodes, bodies.nodes]).astype(np.int64)
    turn, arm = np.zeros((len(nodes), 4)), np.zeros((len(nodes), 3))
    turn[:, 0] = 1.0
    linked = np.flatnonzero(stations.links >= 0)
    turn[linked] = problem.link_quaternions[stations.links[linked]]
    arm[linked] = problem.link_positions[stations.links[linked]]
    turn[len(stations.nodes) :], arm[len(stations.nodes) :] = bodies.turns, bodies.arms
    q = product(rotation, conjugate(turn))
    R = matrices(q)
    offset = np.einsum("kij,kj->ki", R, arm)
    angular = np.einsum("kij,kj->ki", matrices(rotation), spin)
    linear = velocity - np.cross(angular, offset)
    state.r[nodes] = position - offset
    state.q[nodes] = q / np.linalg.norm(q, axis=1, keepdims=True)
    state.twist[nodes, :3] = np.einsum("kji,kj->ki", R, linear)
    state.twist[nodes, 3:] = np.einsum("kji,kj->ki", R, angular)
    return state


def _between(a: Floats, b: Floats) -> Floats:
    """Return the quaternion of the smallest rotation that turns the direction of ``a`` into the unit vector ``b``."""
    a = a / np.linalg.norm(a)
    cosine = float(a @ b)
    if cosine < -1.0 + 1e-12:
        other = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return np.concatenate([[0.0], other / np.linalg.norm(other)])
    q = np.concatenate([[1.0 + cosine], np.cross(a, b)])
    result: Floats = q / np.linalg.norm(q)
    return result
