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
from viscorod.mechanics.nodes.prescribed_motion import axis, step_to_target, turned_by
from viscorod.mechanics.rotations.exponential_map import inverse_coefficients, logarithm, pulled, tangent_of
from viscorod.mechanics.rotations.vectors import (
    conjugate,
    cross,
    difference,
    dot,
    plus,
    product,
    put,
    put_stage,
    quaternion,
    rotated,
    rotated_back,
    scaled,
    stage_quaternion,
    unit,
    vector,
)
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
    """Directions of supports: derivatives ``G`` and duals ``Z (m, 6, 6)``; free rotations and components in a state.

    Attributes:
        psi: free rotations ``(m, 3)``; value: measured components ``(m, 6)``.
    """

    G: Floats
    Z: Floats
    psi: Floats
    value: Floats

    @classmethod
    def of(cls, count: int) -> Directions:
        """Allocate for a number of supports."""
        square = np.zeros((2, count, 6, 6))
        return cls(square[0], square[1], np.zeros((count, 3)), np.zeros((count, 6)))


@part
def in_body(axes: Floats) -> bool:
    """Return whether a support with these axes ``(3, 3)`` holds velocities along those of the moving section."""
    for i in range(3):
        for j in range(3):
            if axes[i, j] != 0.0:
                return False
    return True


@kernel
def support_directions(
    supports: SupportedNodes,
    s: int,
    target: Floats,
    r: Floats,
    q: Floats,
    to: int,
    directions: Directions,
) -> None:
    """Write the directions of support ``s`` and the components that it measures, as number ``to`` of them.

    Args:
        target: prescribed values of all supports ``(m, 6)`` [m, rad]; r, q: poses of all nodes.
    """
    nodes, fixed, axes, r0, q0 = supports
    G, Z, psi, value = directions
    if in_body(axes[s]):
        for i in range(6):
            value[to, i] = 0.0
            for j in range(6):
                G[to, i, j] = Z[to, i, j] = 1.0 if i == j else 0.0
        put(psi, to, 0, (0.0, 0.0, 0.0))
        return
    node = nodes[s]
    turn = (0.0, 0.0, 0.0)  # that the held components of the target make alone
    for i in range(3):
        turn = plus(turn, fixed[s, 3 + i] * target[s, 3 + i], axis(axes, s, i))
    here, there = quaternion(q, node), turned_by(quaternion(q0, s), turn)
    free = logarithm(product(conjugate(there), here))
    away = difference(vector(r, node, 0), vector(r0, s, 0))
    put(psi, to, 0, free)
    for i in range(3):
        e = axis(axes, s, i)
        own, turned = rotated_back(here, e), rotated_back(there, e)
        up, down = tangent_of(free, turned), pulled(free, turned, 1.0)
        value[to, i] = dot(e, away)
        value[to, 3 + i] = fixed[s, 3 + i] * target[s, 3 + i] + dot(turned, free)
        for j in range(3):
            G[to, i, j] = Z[to, j, i] = own[j]
            G[to, 3 + i, 3 + j] = down[j]
            Z[to, 3 + j, 3 + i] = up[j]
            G[to, i, 3 + j] = G[to, 3 + i, j] = Z[to, 3 + j, i] = Z[to, j, 3 + i] = 0.0


@part
def subtract_reaction_stiffness(
    s: int, directions: Directions, reaction: Floats, slot: int, blocks: Floats
) -> None:
    """Subtract the derivative of ``G^T reaction`` per body increment, at constant ``reaction (m, 6)``, from a block.

    The force turns with the node, ``d(R^T f) = (R^T f) x theta``; the moment is ``T^-T m`` with m constant in the
    frame of the target and ``T^-T m = m - psi x m/2 + c psi x (psi x m)``.
    """
    G, free = directions.G, vector(directions.psi, s, 0)
    f = moment = (0.0, 0.0, 0.0)
    for i in range(3):
        f = plus(f, reaction[s, i], (G[s, i, 0], G[s, i, 1], G[s, i, 2]))
        moment = plus(moment, reaction[s, 3 + i], (G[s, 3 + i, 3], G[s, 3 + i, 4], G[s, 3 + i, 5]))
    m = tangent_of(scaled(-1.0, free), moment)
    c, slope = inverse_coefficients(dot(free, free))
    once = cross(free, m)
    twice = cross(free, once)
    for j in range(3):
        x = pulled(free, unit(j), -1.0)  # change of psi
        along = dot(free, x)
        change = plus(scaled(0.5, cross(m, x)), -c, cross(once, x))
        change = plus(plus(change, slope * along, twice), c * dot(free, m), x)
        change = plus(change, -c * along, m)
        push = cross(f, unit(j))
        for i in range(3):
            blocks[slot, 3 + j, i] -= push[i]
            blocks[slot, 3 + j, 3 + i] -= change[i]


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
    Z, value = directions.Z, directions.value
    for s in range(nodes.shape[0]):
        k = nodes[s]
        support_directions(supports, s, target, r, q, s, directions)
        complete = not in_body(axes[s])
        for i in range(6):
            reaction[s, i] = 0.0
            for j in range(6):
                reaction[s, i] += Z[s, j, i] * residual[k, j]
            if fixed[s, i] == 0.0:
                complete = False
        if complete:
            step_to_target(s, axes, r0, q0, target, r, q, k, residual)
            for i in range(6):
                residual[k, i] = -residual[k, i]
        else:
            for i in range(6):
                if fixed[s, i] == 0.0:
                    residual[k, i] = reaction[s, i]
                    reaction[s, i] = 0.0
                else:
                    residual[k, i] = value[s, i] - target[s, i]


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
    G, Z = directions.G, directions.Z
    old = np.empty((6, 6))
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
            subtract_reaction_stiffness(s, directions, reaction, own, blocks)
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
    for state in range(r.shape[0]):
        for s in range(nodes.shape[0]):
            support_directions(supports, s, target[state], r[state], q[state], 0, directions)
            force = moment = (0.0, 0.0, 0.0)
            for i in range(6):
                exerted = fixed[s, i] * reaction[state, s, i]
                force = plus(force, exerted, vector(G[0], i, 0))
                moment = plus(moment, exerted, vector(G[0], i, 3))
            here = stage_quaternion(q, state, nodes[s])
            put_stage(out, state, s, 0, rotated(here, force))
            put_stage(out, state, s, 3, rotated(here, moment))


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
