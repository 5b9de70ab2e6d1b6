"""Supports: prescribed or fixed displacements and rotations of a node, imposed exactly on the rows of the node.

A support measures, along constant axes ``A = [e1 e2 e3]`` (global), the displacement ``u = A^T (r - r0)`` and how the
node has turned from where its held rotations alone would put it: with the prescribed rotation vector ``eta`` (zero
along free axes) ``R_t = exp(A eta) R0`` and ``R = R_t exp(psi)``, ``A^T R_t psi`` vanishes along held axes. So the
prescribed rotation may be of any size, and the free ones are measured from there, by less than half a turn from one
iterate to the target. With ``T`` the tangent of the exponential, body increments change these components by
``G = [A^T R, A^T R_t T^-1]``; the dual directions are ``Z = [R^T A, T R_t^T A]``. Free components keep the balance
projected on their dual direction, the others are replaced by ``G dx = target - value``; reactions are the residuals of
the projected balance there. This is Newton's method for the saddle-point system with the reactions eliminated.

Axes that are all zero mean those of the moving section, along which velocities are held: then G = Z = 1, there is no
position to measure, and the target is the error of the velocities, integrated over the step.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.nodes.prescribed_motion import step_to_target
from viscorod.mechanics.rotations.exponential_map import inverse_coefficients
from viscorod.mechanics.rotations.rotation import (
    add_skew,
    inverse_rotation_tangent,
    relative_rotation,
    rotate,
    rotation_matrix,
    rotation_tangent,
    turned,
)
from viscorod.mechanics.rotations.vectors import cross, entries
from viscorod.typing import Floats, Integers

ROUND_OFF = 1e-9


class SupportedNodes(NamedTuple):
    """Supports of ``m`` nodes.

    Attributes:
        nodes: ``(m,)``; fixed: 1.0 where a component is fixed or prescribed ``(m, 6)``.
        axes: ``(m, 3, 3)`` columns, global; all zero: those of the moving section.
        r0, q0: reference poses ``(m, 3)`` [m], ``(m, 4)``.
    """

    nodes: Integers
    fixed: Floats
    axes: Floats
    r0: Floats
    q0: Floats


class Directions(NamedTuple):
    """Directions of supports: derivatives ``G`` and duals ``Z (m, 6, 6)``, and the free rotations ``psi (m, 3)``."""

    G: Floats
    Z: Floats
    psi: Floats

    @classmethod
    def of(cls, count: int) -> Directions:
        """Allocate for a number of supports."""
        return cls(np.zeros((count, 6, 6)), np.zeros((count, 6, 6)), np.zeros((count, 3)))


@part
def in_body(axes: Floats) -> bool:
    """Return whether a support with these axes ``(3, 3)`` holds velocities along those of the moving section."""
    for i in range(3):
        for j in range(3):
            if axes[i, j] != 0.0:
                return False
    return True


@part
def target_frame(axes: Floats, q0: Floats, fixed: Floats, target: Floats, out: Floats) -> None:
    """Write the quaternion of a node that has turned by the held components of its target alone."""
    R = np.empty((3, 3))
    rotation_matrix(q0, R)
    theta = np.zeros(3)
    for a in range(3):
        for i in range(3):
            for b in range(3):
                theta[a] += R[b, a] * axes[b, i] * fixed[3 + i] * target[3 + i]
    turned(q0, theta, out)


@kernel
def support_directions(
    supports: SupportedNodes,
    s: int,
    target: Floats,
    r: Floats,
    q: Floats,
    value: Floats,
    to: int,
    directions: Directions,
) -> None:
    """Write the measured components ``value`` of support ``s`` and its directions, as number ``to`` of them.

    Args:
        target: prescribed values of all supports ``(m, 6)`` [m, rad]; r, q: poses of all nodes.
    """
    node, fixed, axes, r0 = supports.nodes[s], supports.fixed[s], supports.axes[s], supports.r0[s]
    G, Z, psi = directions.G[to], directions.Z[to], directions.psi[to]
    if in_body(axes):
        for i in range(6):
            value[i] = 0.0
            for j in range(6):
                G[i, j] = Z[i, j] = 1.0 if i == j else 0.0
        for i in range(3):
            psi[i] = 0.0
        return
    R = np.empty((3, 3))
    Rt = np.empty((3, 3))
    T = np.empty((3, 3))
    Ti = np.empty((3, 3))
    qt = np.empty(4)
    target_frame(axes, supports.q0[s], fixed, target[s], qt)
    rotation_matrix(q[node], R)
    rotation_matrix(qt, Rt)
    relative_rotation(qt, q[node], psi)
    rotation_tangent(psi, T)
    inverse_rotation_tangent(psi, Ti)
    for i in range(6):
        for j in range(6):
            G[i, j] = Z[i, j] = 0.0
    for i in range(3):
        value[i] = 0.0
        value[3 + i] = fixed[3 + i] * target[s, 3 + i]
        for a in range(3):
            value[i] += axes[a, i] * (r[node, a] - r0[a])
            e = 0.0  # component a of axis i in the frame of the target
            for b in range(3):
                e += Rt[b, a] * axes[b, i]
            value[3 + i] += e * psi[a]
            for j in range(3):
                G[i, j] += axes[a, i] * R[a, j]
                Z[j, i] += axes[a, i] * R[a, j]
                G[3 + i, 3 + j] += e * Ti[a, j]
                Z[3 + j, 3 + i] += e * T[j, a]


@part
def reaction_stiffness(G: Floats, psi: Floats, reaction: Floats, out: Floats) -> None:
    """Write the derivative of ``G^T reaction`` per body increment ``(6, 6)`` at constant reaction components.

    The force turns with the node, ``d(R^T f) = (R^T f) x theta``; the moment is ``T^-T m`` with m constant in the
    frame of the target and ``T^-T m = m - psi x m/2 + c psi x (psi x m)``.
    """
    T = np.empty((3, 3))
    Ti = np.empty((3, 3))
    D = np.zeros((3, 3))
    f = np.zeros(3)
    m = np.zeros(3)
    rotation_tangent(psi, T)
    inverse_rotation_tangent(psi, Ti)
    for i in range(3):
        for a in range(3):
            f[i] += G[a, i] * reaction[a]
            for j in range(3):
                m[i] += T[j, i] * G[3 + a, 3 + j] * reaction[3 + a]
    c, slope = inverse_coefficients(psi[0] ** 2 + psi[1] ** 2 + psi[2] ** 2)
    turn = entries(psi, 0)
    once = cross(turn, entries(m, 0))
    twice = cross(turn, once)
    add_skew(m, 0.5, D)
    add_skew(once, -c, D)
    for i in range(3):
        for j in range(3):
            D[i, j] += slope * twice[i] * psi[j] - c * m[i] * psi[j]
        D[i, i] += c * (psi[0] * m[0] + psi[1] * m[1] + psi[2] * m[2])
    for i in range(6):
        for j in range(6):
            out[i, j] = 0.0
    add_skew(f, 1.0, out[0:3, 3:6])
    for i in range(3):
        for j in range(3):
            for a in range(3):
                out[3 + i, 3 + j] += D[i, a] * Ti[a, j]


@kernel
def impose(
    supports: SupportedNodes,
    target: Floats,
    r: Floats,
    q: Floats,
    residual: Floats,
    reaction: Floats,
    directions: Directions,
) -> None:
    """Replace the rows of supported nodes in the residual.

    Args:
        target: prescribed values ``(m, 6)`` [m, rad]; r, q: present poses of all nodes.
        residual: ``(n, 6)``; on return free rows hold the projected balance, fixed rows the gap to be closed.
        reaction: output ``(m, 6)``, force and moment components along the axes that the support exerts.
        directions: output of :func:`support_directions` for all.
    """
    nodes, fixed, axes, r0, q0 = supports
    Z = directions.Z
    value = np.empty(6)
    for s in range(nodes.shape[0]):
        k = nodes[s]
        support_directions(supports, s, target, r, q, value, s, directions)
        complete = not in_body(axes[s])
        for i in range(6):
            reaction[s, i] = 0.0
            for j in range(6):
                reaction[s, i] += Z[s, j, i] * residual[k, j]
            if fixed[s, i] == 0.0:
                complete = False
        if complete:
            step_to_target(axes[s], r0[s], q0[s], target[s], r[k], q[k], residual[k])
            for i in range(6):
                residual[k, i] = -residual[k, i]
        else:
            for i in range(6):
                if fixed[s, i] == 0.0:
                    residual[k, i] = reaction[s, i]
                    reaction[s, i] = 0.0
                else:
                    residual[k, i] = value[i] - target[s, i]


@kernel
def impose_tangent(
    supports: SupportedNodes,
    directions: Directions,
    reaction: Floats,
    residual: Floats,
    blocks: Floats,
    starts: Integers,
    across: Integers,
    diagonal: Integers,
) -> None:
    """Replace the rows of supported nodes in the matrix, after :func:`impose`; held rows of both are weighted.

    Args:
        directions, reaction: as :func:`impose` left them.
        residual: ``(n, 6)``; blocks: of the matrix ``(b, 6, 6)`` (see ``geometric_element.assemble``).
        starts, across, diagonal: numbers of the blocks: column k has those from ``starts[k]`` to ``starts[k + 1]``,
            row k those that are ``across`` from them, and both have the block ``diagonal[k]``.
    """
    nodes, fixed, axes = supports[:3]
    G, Z, psi = directions
    old = np.empty((6, 6))
    block = np.empty((6, 6))
    weight = np.empty(6)
    for s in range(nodes.shape[0]):
        k = nodes[s]
        own = diagonal[k]
        # constraint rows as large as the balance rows they replace, so that scale does not affect pivoting; where
        # multipliers hold the strains of all elements at the node, its own block is round-off
        weight_move = weight_turn = all_move = all_turn = 0.0
        for transposed in range(starts[k], starts[k + 1]):
            slot = across[transposed]
            for j in range(6):
                for i in range(3):
                    all_move = max(all_move, abs(blocks[slot, j, i]))
                    all_turn = max(all_turn, abs(blocks[slot, j, 3 + i]))
        for j in range(3):
            for i in range(3):
                weight_move = max(weight_move, abs(blocks[own, j, i]))
                weight_turn = max(weight_turn, abs(blocks[own, 3 + j, 3 + i]))
        if weight_move < ROUND_OFF * all_move:
            weight_move = all_move
        if weight_turn < ROUND_OFF * all_turn:
            weight_turn = all_turn
        in_section_axes = in_body(axes[s])
        complete = not in_section_axes
        for i in range(6):
            weight[i] = weight_move if i < 3 else weight_turn
            if weight[i] == 0.0:
                weight[i] = 1.0
            if fixed[s, i] != 0.0:
                residual[k, i] *= weight[i]
            else:
                complete = False
        if not complete and not in_section_axes:
            reaction_stiffness(G[s], psi[s], reaction[s], block)
            for j in range(6):
                for i in range(6):
                    blocks[own, j, i] -= block[i, j]
        for transposed in range(starts[k], starts[k + 1]):
            slot = across[transposed]
            for j in range(6):
                for i in range(6):
                    old[i, j] = blocks[slot, j, i]
                for i in range(6):
                    new = 0.0
                    if complete:
                        new = weight[i] if slot == own and i == j else 0.0
                    elif fixed[s, i] == 0.0:
                        for a in range(6):
                            new += Z[s, a, i] * old[a, j]
                    elif slot == own:
                        new = weight[i] * G[s, i, j]
                    blocks[slot, j, i] = new


@kernel
def reaction_wrenches(
    supports: SupportedNodes,
    target: Floats,
    r: Floats,
    q: Floats,
    reaction: Floats,
    directions: Directions,
    out: Floats,
) -> None:
    """Write the forces and moments (global axes) of the reaction components of :func:`impose`.

    Several states are handled at once: the first index of ``target``, ``r``, ``q``, ``reaction`` and
    ``out (states, m, 6)``; ``directions`` of one support are scratch.
    """
    nodes, fixed, G = supports.nodes, supports.fixed, directions.G
    value = np.empty(6)
    wrench = np.empty(6)
    for state in range(r.shape[0]):
        for s in range(nodes.shape[0]):
            qk = q[state, nodes[s]]
            support_directions(supports, s, target[state], r[state], q[state], value, 0, directions)
            for j in range(6):
                wrench[j] = 0.0
                for i in range(6):
                    wrench[j] += G[0, i, j] * fixed[s, i] * reaction[state, s, i]
            rotate(qk, wrench[0:3], out[state, s, 0:3])
            rotate(qk, wrench[3:6], out[state, s, 3:6])


@part
def lacking_motion(
    supports: SupportedNodes,
    weights: Floats,
    h: float,
    rate: Floats,
    twist: Floats,
    target: Floats,
) -> None:
    """Write the targets of supports in body axes: the error of their velocities, integrated up to every stage.

    Args:
        weights: of the stages in the integrals ``(s, s)``; h: step [s].
        rate: prescribed velocities ``(s, m, 6)``; twist: of all nodes ``(s, n, 6)``; target: output ``(s, m, 6)``.
    """
    nodes, fixed, axes = supports[:3]
    for m in range(nodes.shape[0]):
        if in_body(axes[m]):
            for i in range(twist.shape[0]):
                for a in range(6):
                    target[i, m, a] = 0.0
                    if fixed[m, a] != 0.0:
                        for j in range(twist.shape[0]):
                            target[i, m, a] += h * weights[i, j] * (rate[j, m, a] - twist[j, nodes[m], a])
