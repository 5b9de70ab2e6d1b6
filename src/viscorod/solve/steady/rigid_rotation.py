"""Rigid rotation of a deformed body: its twists, its mass centre and its inertia."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.nodes import inertia
from viscorod.mechanics.rotations.adjoint_maps import skew
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.formulations.system import State
from viscorod.typing import Floats


@dataclass(frozen=True)
class RotationAxis:
    """A line in space: unit vector ``direction (3,)`` through the point ``centre (3,)`` [m], global axes."""

    direction: Floats
    centre: Floats


def rigid_twists(
    r: Floats, q: Floats, linear: Floats | list[float], angular: Floats | list[float], centre: Floats
) -> Floats:
    """Return the body twists ``(n, 6)`` of nodes that move as one rigid body.

    Args:
        r, q: poses; linear: velocity of the point ``centre`` [m/s]; angular: angular velocity [rad/s], global axes.
    """
    R, spin = matrices(q), np.asarray(angular, dtype=float)
    motion = np.empty((len(r), 2, 3))
    motion[:, 0] = np.asarray(linear) + (r - centre) @ skew(spin[None])[0].T
    motion[:, 1] = spin
    twists: Floats = np.matmul(motion, R).reshape(-1, 6)
    return twists


def spatial_momenta(
    mass: Floats, r: Floats, q: Floats, twist: Floats, centre: Floats
) -> tuple[Floats, Floats]:
    """Return linear momentum [N s] and angular momentum about ``centre`` [N m s], global axes, each ``(3,)``."""
    nodal = np.empty((len(r), 6))
    inertia.momenta(mass, r, q, twist, nodal)
    total = nodal.sum(axis=0)
    return total[:3], total[3:] - np.cross(centre, total[:3])


def mass_centre(mass: Floats, r: Floats, q: Floats) -> Floats:
    """Return the mass centre ``(3,)`` [m]."""
    origin = np.zeros(3)
    first = np.zeros(3)  # sum of mass times position, from the momenta of turning about the origin
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        linear, _ = spatial_momenta(mass, r, q, rigid_twists(r, q, [0.0] * 3, np.eye(3)[i], origin), origin)
        first[k] -= 0.5 * linear[j]
        first[j] += 0.5 * linear[k]
    total, _ = spatial_momenta(mass, r, q, rigid_twists(r, q, [1.0, 0.0, 0.0], [0.0] * 3, origin), origin)
    centre: Floats = first / total[0]
    return centre


def inertia_about(mass: Floats, r: Floats, q: Floats, centre: Floats) -> Floats:
    """Return the inertia tensor ``(3, 3)`` [kg m^2] about a point, global axes."""
    columns = [
        spatial_momenta(mass, r, q, rigid_twists(r, q, [0.0] * 3, unit, centre), centre)[1]
        for unit in np.eye(3)
    ]
    return np.array(columns).T


def mean_spin(mass: Floats, state: State, centre: Floats) -> Floats:
    """Return the angular velocity [rad/s] of the rigid body that has the same angular momentum about ``centre``."""
    _, momentum = spatial_momenta(mass, state.r, state.q, state.twist, centre)
    return np.asarray(np.linalg.solve(inertia_about(mass, state.r, state.q, centre), momentum), dtype=float)


def coriolis(mass: Floats, twist: Floats) -> Floats:
    """Return the inertial forces ``L1(x1) M x1 (n, 6)`` of a steady motion."""
    out = np.zeros_like(twist)
    inertia.add_coriolis(mass, twist, out)
    return out


def gyroscopic(mass: Floats, twist: Floats) -> Floats:
    """Return ``d(L1(x1) M x1)/dx1`` of every node ``(n, 6, 6)``."""
    v, w = skew(twist[:, :3]), skew(twist[:, 3:])
    L1 = np.zeros_like(mass)
    L1[:, :3, :3], L1[:, 3:, :3], L1[:, 3:, 3:] = w, v, w
    momentum = np.einsum("nij,nj->ni", mass, twist)
    p, h = skew(momentum[:, :3]), skew(momentum[:, 3:])
    turned = np.zeros_like(mass)  # L1(x1) p at constant momentum, as a matrix on x1
    turned[:, :3, 3:], turned[:, 3:, :3], turned[:, 3:, 3:] = -p, -p, -h
    return L1 @ mass + turned
