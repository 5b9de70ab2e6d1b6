"""Nodal inertia: momentum, kinetic energy and inertial forces of nodes with a constant 6x6 mass in their body frame."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.rotations.rotation import rotate
from viscorod.mechanics.rotations.vectors import cross, plus, quaternion, rotated, vector
from viscorod.typing import Floats, Integers


@kernel
def momenta(mass: Floats, r: Floats, q: Floats, twist: Floats, out: Floats) -> float:
    """Write the spatial momenta (linear, angular about the global origin) of all nodes; return the kinetic energy [J].

    Args:
        mass: body-frame inertia ``(n, 6, 6)``; r, q: poses; twist: body twists ``(n, 6)``.
        out: ``(n, 6)`` [N s, N m s], global axes.
    """
    energy = 0.0
    body = np.empty(6)
    for k in range(r.shape[0]):
        for i in range(6):
            body[i] = 0.0
            for j in range(6):
                body[i] += mass[k, i, j] * twist[k, j]
            energy += 0.5 * body[i] * twist[k, i]
        rotate(q[k], body[0:3], out[k, 0:3])
        rotate(q[k], body[3:6], out[k, 3:6])
        out[k, 3] += r[k, 1] * out[k, 2] - r[k, 2] * out[k, 1]
        out[k, 4] += r[k, 2] * out[k, 0] - r[k, 0] * out[k, 2]
        out[k, 5] += r[k, 0] * out[k, 1] - r[k, 1] * out[k, 0]
    return energy


@kernel
def kinetic_energy(mass: Floats, twist: Floats) -> float:
    """Return the kinetic energy [J] of nodes with body twists ``(n, 6)``."""
    total = 0.0
    for k in range(twist.shape[0]):
        for i in range(6):
            for j in range(6):
                total += 0.5 * mass[k, i, j] * twist[k, i] * twist[k, j]
    return total


@kernel
def add_momentum_rate(
    mass: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
    factor: float,
    history: Floats,
    rate_map: Floats,
    with_tangent: bool,
    residual: Floats,
    blocks: Floats,
    diagonal: Integers,
) -> None:
    """Add the momentum rate ``factor * momentum + history`` (spatial) in body components, and its tangent.

    Any time scheme that is linear in the spatial momenta has this form; because internal forces have no spatial
    resultant, such a scheme conserves linear and angular momentum to round-off.

    Args:
        mass, r, q, twist: as in :func:`momenta`.
        factor: [1/s]; history: ``(n, 6)`` spatial wrenches known from the past [N, N m].
        rate_map: d(twist)/d(body increment) ``(n, 6, 6)``.
        residual: ``(n, 6)``, added to.
        blocks: of the matrix ``(b, 6, 6)`` (see ``geometric_element.assemble``); diagonal: those of the nodes ``(n,)``.
    """
    block = np.zeros((6, 6))
    for k in range(r.shape[0]):
        # body components, at the node, of the spatial wrench from the past
        f = vector(history, k, 0)
        m = plus(vector(history, k, 3), -1.0, cross(vector(r, k, 0), f))
        q0, (q1, q2, q3) = quaternion(q, k)
        back = q0, (-q1, -q2, -q3)
        f, m = rotated(back, f), rotated(back, m)
        for i in range(6):
            total = 0.0
            for j in range(6):
                total += mass[k, i, j] * twist[k, j]
            residual[k, i] += factor * total + (f[i] if i < 3 else m[i - 3])
        if not with_tangent:
            continue
        for i in range(6):
            own = factor * mass[k, i, i]
            for j in range(6):
                block[i, j] = own * rate_map[k, i, j]
            for a in range(6):
                coupling = factor * mass[k, i, a]
                if a != i and coupling != 0.0:
                    for j in range(6):
                        block[i, j] += coupling * rate_map[k, a, j]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            # [f]x and [m]x: both turn with the node
            block[a, 3 + i] += f[b]
            block[b, 3 + i] -= f[a]
            block[3 + a, i] += f[b]
            block[3 + b, i] -= f[a]
            block[3 + a, 3 + i] += m[b]
            block[3 + b, 3 + i] -= m[a]
        slot = np.uint64(diagonal[k])
        for j in range(6):
            for i in range(6):
                blocks[slot, j, i] += block[i, j]


@kernel
def add_coriolis(mass: Floats, twist: Floats, out: Floats) -> None:
    """Add ``L1(x1) M x1`` of every node to ``out`` (the inertial force at zero acceleration)."""
    p = np.empty(6)
    for k in range(twist.shape[0]):
        for i in range(6):
            p[i] = 0.0
            for j in range(6):
                p[i] += mass[k, i, j] * twist[k, j]
        v = twist[k, 0:3]
        w = twist[k, 3:6]
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            out[k, i] += w[a] * p[b] - w[b] * p[a]
            out[k, 3 + i] += v[a] * p[b] - v[b] * p[a] + w[a] * p[3 + b] - w[b] * p[3 + a]


@part
def balance(
    mass: Floats,
    twist: Floats,
    acceleration: Floats,
    internal: Floats,
    external: Floats,
    force: Floats,
    residual: Floats,
) -> None:
    """Write the forces that accelerate the nodes, ``f_ext - f_int - L1(x1) M x1``, and the residual ``M x1' - force``.

    Args:
        mass: ``(n, 6, 6)``; twist, acceleration: body twists and their rates at all stages ``(s, n, 6)``, as the rest.
        internal, external: forces; force, residual: outputs.
    """
    for s in range(twist.shape[0]):
        for k in range(twist.shape[1]):
            v0, v1, v2 = twist[s, k, 0], twist[s, k, 1], twist[s, k, 2]
            w0, w1, w2 = twist[s, k, 3], twist[s, k, 4], twist[s, k, 5]
            for a in range(6):
                force[s, k, a] = external[s, k, a] - internal[s, k, a]
                residual[s, k, a] = 0.0  # the momentum, for the moment
                for b in range(6):
                    residual[s, k, a] += mass[k, a, b] * twist[s, k, b]
            p0, p1, p2 = residual[s, k, 0], residual[s, k, 1], residual[s, k, 2]
            h0, h1, h2 = residual[s, k, 3], residual[s, k, 4], residual[s, k, 5]
            force[s, k, 0] -= w1 * p2 - w2 * p1
            force[s, k, 1] -= w2 * p0 - w0 * p2
            force[s, k, 2] -= w0 * p1 - w1 * p0
            force[s, k, 3] -= v1 * p2 - v2 * p1 + w1 * h2 - w2 * h1
            force[s, k, 4] -= v2 * p0 - v0 * p2 + w2 * h0 - w0 * h2
            force[s, k, 5] -= v0 * p1 - v1 * p0 + w0 * h1 - w1 * h0
            for a in range(6):
                total = -force[s, k, a]
                for b in range(6):
                    total += mass[k, a, b] * acceleration[s, k, b]
                residual[s, k, a] = total
