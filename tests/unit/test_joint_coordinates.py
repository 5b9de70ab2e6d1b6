"""Coordinates of joints against plain NumPy, gradients and their turning against finite differences."""

from __future__ import annotations

import numba
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from helpers.finite_differences import slope_of
from viscorod.mechanics.joints import joint_coordinates as jc
from viscorod.mechanics.rotations.rotation import retract

KINDS = [jc.TRANSLATION, jc.ALIGNMENT, jc.ANGLE, jc.ROTATION, jc.DISTANCE]
coordinate, add_gradient_change, place_of = jc.coordinate, jc.add_gradient_change, jc.place_of


@numba.njit
def value_and_gradient(kind, geometry, r, q, a, b, near, gradient):
    ra, qa = place_of(r, q, a)
    rb, qb = place_of(r, q, b)
    return coordinate(0, kind, geometry, ra, qa, rb, qb, near, gradient)


@numba.njit
def turning(kind, geometry, r, q, a, b, factor, out):
    ra, qa = place_of(r, q, a)
    rb, qb = place_of(r, q, b)
    add_gradient_change(0, kind, geometry, ra, qa, rb, qb, factor, np.empty((2, 12)), out)


def setting(kind, seed, *, angle=None):
    """Two poses and a coordinate between them; ``angle`` sets the size of the relative rotation."""
    rng = np.random.default_rng(seed)
    r, q = rng.normal(size=(2, 3)), rng.normal(size=(2, 4))
    q /= np.linalg.norm(q, axis=1)[:, None]
    geometry = rng.normal(size=(1, jc.GEOMETRY))
    for at in (jc.AT_Q_A, jc.AT_Q_B):
        geometry[0, at : at + 4] /= np.linalg.norm(geometry[0, at : at + 4])
    geometry[0, jc.AT_COMPONENT] = seed % 3
    if angle is not None:
        own_a, own_b = (rotation(geometry[0, at : at + 4]) for at in (jc.AT_Q_A, jc.AT_Q_B))
        turn = Rotation.from_rotvec(angle * np.array([0.48, -0.6, 0.64]))
        x, y, z, w = (rotation(q[0]) * own_a * turn * own_b.inv()).as_quat()
        q[1] = w, x, y, z
    return np.array([kind]), geometry, r, q


def rotation(q):
    return Rotation.from_quat([*q[1:], q[0]])


def by_hand(kind, geometry, r, q):
    g = geometry[0]
    Ra, Rb = (rotation(x) for x in q)
    points = r[0] + Ra.apply(g[0:3]), r[1] + Rb.apply(g[3:6])
    u1, v1, u2, v2 = Ra.apply(g[6:9]), Rb.apply(g[9:12]), Ra.apply(g[12:15]), Rb.apply(g[15:18])
    psi = ((Ra * rotation(g[18:22])).inv() * (Rb * rotation(g[22:26]))).as_rotvec()
    d = points[1] - points[0]
    return [u1 @ d, u1 @ v1, np.arctan2(u1 @ v1, u2 @ v2), psi[int(g[26])], np.linalg.norm(d)][kind]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_values_are_those_of_plain_numpy(kind, seed):
    kinds, geometry, r, q = setting(kind, seed)
    found = value_and_gradient(kinds, geometry, r, q, 0, 1, 0.0, np.empty(12))
    assert found == pytest.approx(by_hand(kind, geometry, r, q), abs=1e-13)


@pytest.mark.parametrize("ground", [None, 0, 1])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(3))
def test_gradients_and_their_turning_are_derivatives(kind, seed, ground):
    """Central differences of order 4 along body increments; a grounded side has the identity as its pose."""
    kinds, geometry, r, q = setting(kind, seed, angle=[1e-5, 0.3, 2.8][seed] if ground is None else None)
    nodes = [0, 1]
    if ground is not None:
        nodes[ground] = -1
        r[ground], q[ground] = 0.0, (1.0, 0.0, 0.0, 0.0)

    def moved(x):
        r1, q1 = np.empty_like(r), np.empty_like(q)
        retract(r, q, x.reshape(2, 6), r1, q1)
        return r1, q1

    def at(x):
        r1, q1 = moved(x)
        gradient = np.empty(12)
        value = value_and_gradient(kinds, geometry, r1, q1, 0, 1, 0.0, gradient)
        return np.concatenate([[value], gradient])

    slopes = slope_of(at, 12, h=4e-4)
    out, gradient = np.zeros((12, 12)), np.empty(12)
    turning(kinds, geometry, r, q, *nodes, 1.7, out)
    value_and_gradient(kinds, geometry, r, q, *nodes, 0.0, gradient)
    assert gradient == pytest.approx(slopes[0], rel=1e-8, abs=1e-9)
    assert out == pytest.approx(1.7 * slopes[1:], rel=1e-8, abs=1e-9)


def test_angles_come_with_their_turns():
    kinds, geometry, r, q = setting(jc.ANGLE, 5)
    first = value_and_gradient(kinds, geometry, r, q, 0, 1, 0.0, np.empty(12))
    for turns in (-3, 1, 40):
        near = first + 2.0 * np.pi * turns + 2.9
        assert value_and_gradient(kinds, geometry, r, q, 0, 1, near, np.empty(12)) == pytest.approx(
            first + 2.0 * np.pi * turns, abs=1e-12
        )
