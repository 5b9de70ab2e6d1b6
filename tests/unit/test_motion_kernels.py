"""Coordinates of a step and interpolation in time against the matrix exponential and finite differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from helpers.kernel_parts import from_python
from viscorod.mechanics.compilation import shared
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes.carried_motion import Carrier, carry_along
from viscorod.mechanics.rotations.exponential_map import versine_coefficients, versine_slopes
from viscorod.mechanics.rotations.nodal_motion import (
    coordinate_rates,
    coordinates,
    extrapolate,
    place,
)
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, hermite, interpolate
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.mechanics.rotations.rotation import motion_extent

ANGLES = [0.0, 1e-9, 1e-3, 0.19, 0.21, 1.0, 2.5]


def at(angle, seed=0):
    """A start pose, coordinates of this angle and their rate."""
    rng = np.random.default_rng(seed)
    q0 = rng.normal(size=4)
    X, rate = rng.normal(size=(2, 6))
    X[3:] *= angle / np.linalg.norm(X[3:])
    return rng.normal(size=3), q0 / np.linalg.norm(q0), X, rate


def placed(r0, q0, X, rate, split):
    r, q, twist = np.empty(3), np.empty(4), np.empty(6)
    place(r0, q0, X, rate, split, r, q, twist)
    return r, q, twist


def hat(X):
    """The 4x4 matrix of an element of se(3)."""
    out = np.zeros((4, 4))
    out[:3, :3] = np.cross(np.eye(3), X[3:])
    out[:3, 3] = X[:3]
    return out


def pose(r0, q0, X, split):
    """4x4 pose by the matrix exponential."""
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = matrices(q0[None])[0], r0
    if not split:
        return H @ expm(hat(X))
    out = H @ expm(hat(np.concatenate([np.zeros(3), X[3:]])))
    out[:3, 3] = r0 + H[:3, :3] @ X[:3]
    return out


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("angle", ANGLES)
def test_place_is_the_exponential(angle, split):
    """Independent code: scipy's matrix exponential on SE(3), or displacement and rotation apart."""
    r0, q0, X, rate = at(angle)
    r, q, _ = placed(r0, q0, X, rate, split)
    expected = pose(r0, q0, X, split)
    assert r == pytest.approx(expected[:3, 3], abs=1e-13)
    assert matrices(q[None])[0] == pytest.approx(expected[:3, :3], abs=1e-13)
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("angle", ANGLES)
def test_twist_of_place(angle, split):
    """Finite differences in time of the matrix exponential: the body twist is H^-1 H_t."""
    r0, q0, X, rate = at(angle)
    twist = placed(r0, q0, X, rate, split)[2]
    h = 1e-3
    H = {k: pose(r0, q0, X + k * h * rate, split) for k in (-2, -1, 0, 1, 2)}
    slope = (8 * (H[1] - H[-1]) - (H[2] - H[-2])) / (12 * h)
    body = np.linalg.solve(H[0], slope)
    assert twist[:3] == pytest.approx(body[:3, 3], abs=1e-9)
    assert twist[3:] == pytest.approx([body[2, 1], body[0, 2], body[1, 0]], abs=1e-9)


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("angle", ANGLES)
def test_coordinate_rates_are_the_inverse(angle, split):
    """Closed form: the rates that give a twist give it back."""
    r0, q0, X, rate = at(angle)
    back = np.empty(6)
    from_python(coordinate_rates)(X, placed(r0, q0, X, rate, split)[2], split, back)
    assert back == pytest.approx(rate, abs=1e-12)


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("angle", ANGLES)
def test_coordinates_round_trip(angle, split):
    """Closed form: the coordinates of the pose that coordinates lead to, for either sign of the quaternion."""
    r0, q0, X, rate = at(angle)
    r, q, _ = placed(r0, q0, X, rate, split)
    for sign in (1.0, -1.0):
        back = np.empty(6)
        coordinates(r0, q0, r, sign * q, split, back)
        assert back == pytest.approx(X, abs=1e-12)


@pytest.mark.parametrize("phi", [1e-4, 0.05, 0.199, 0.201, 1.0, 2.5])
def test_versine_slopes(phi):
    """Finite differences of the coefficients over the angle, on both sides of the change to series."""
    h = 1e-3 * max(phi, 0.1)
    coefficients = from_python(versine_coefficients)
    values = {k: np.array(coefficients((phi + k * h) ** 2)) for k in (-2, -1, 1, 2)}
    slope = (8 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12 * h)
    a, b = coefficients(phi * phi)
    assert phi * np.array(from_python(versine_slopes)(phi * phi, a, b)) == pytest.approx(slope, abs=1e-11)


def test_extrapolate_continues_a_steady_screw():
    """Closed form: coordinates linear in time are those of a steady screw, seen from anywhere on it."""
    r0, q0, X, _ = at(1.0)
    c = np.array([0.2, 0.6, 1.0])
    values = (X[None, :] * c[:, None])[:, None, :]
    r1, q1, _ = placed(r0, q0, X, np.zeros(6), False)
    weights = np.array(
        [np.linalg.solve(np.vander(c, 3, increasing=True).T, [1, x, x * x]) for x in 1 + 0.7 * c]
    )
    # half of the motion by the twist at the start, half by the stages
    weights = np.column_stack([0.5 * weights, 0.5 * (1 + 0.7 * c)])
    out = np.empty((3, 2, 6))
    two = [np.array([v, v]) for v in (r0, q0, r1, q1)]
    from_python(extrapolate)(
        two[0],
        two[1],
        np.array([X, X]),
        np.repeat(values, 2, axis=1),
        weights,
        two[2],
        two[3],
        np.zeros(2),
        np.array([0.0, 1.0]),
        out,
    )
    assert out[:, 0] == pytest.approx(0.7 * c[:, None] * X, abs=1e-12)
    assert np.all(out[:, 1] == 0.0)


@pytest.mark.parametrize(("smooth", "degree"), [(False, 3), (True, 5)])
def test_hermite_reproduces_polynomials(smooth, degree):
    """Closed form: polynomials up to the degree, and not beyond."""
    for k in range(degree + 2):
        p = np.polynomial.Polynomial.basis(k)
        v, a = p.deriv(), p.deriv(2)
        h, start = 0.7, 0.4
        ends = [f(t) for t in (start, start + h) for f in (p, v, a)]
        y, slope = from_python(hermite)(0.3, h, *ends, smooth)
        t = start + 0.3 * h
        if k <= degree:
            assert (y, slope) == pytest.approx((p(t), v(t)), abs=1e-13)
        else:
            assert abs(y - p(t)) > 1e-5


@pytest.mark.parametrize("smooth", [False, True])
def test_interpolation_follows_a_steady_screw(smooth):
    """Closed form: constant body twist, turning by 2.4 rad in the interval."""
    r0, q0, _, _ = at(0.0)
    twist = np.array([0.3, -1.0, 2.0, 1.0, 0.5, -0.7])
    h = 2.4 / np.linalg.norm(twist[3:])
    r1, q1, _ = placed(r0, q0, h * twist, twist, False)
    still = np.zeros((1, 6))
    parts = np.array([0.0, 0.35, 1.0])
    r, q, x = np.empty((3, 1, 3)), np.empty((3, 1, 4)), np.empty((3, 1, 6))
    for k, part in enumerate(parts):
        start = MovingPoses(r0[None], q0[None], twist[None], still)
        end = MovingPoses(r1[None], q1[None], twist[None], still)
        interpolate(parts, h, start, end, np.zeros(1), smooth, r, q, x, np.empty((10, 6)))
        expected = placed(r0, q0, part * h * twist, twist, False)
        for found, value in zip((r[k, 0], q[k, 0], x[k, 0]), expected, strict=True):
            assert found == pytest.approx(value, abs=1e-8 if smooth else 1e-13)


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize(("smooth", "order"), [(False, 4), (True, 6)])
def test_order_of_interpolation(smooth, order, split):
    """Order by regression: a pose whose coordinates are a cubic plus a sine, twist rates by finite differences."""
    r0, q0, a, b = at(0.8, seed=4)

    def motion(t):
        X = a * t + b * np.sin(1.3 * t + 0.2)
        return placed(r0, q0, X, a + 1.3 * b * np.cos(1.3 * t + 0.2), split)

    def rate(t, d=1e-3):
        return (8 * (motion(t + d)[2] - motion(t - d)[2]) - motion(t + 2 * d)[2] + motion(t - 2 * d)[2]) / (
            12 * d
        )

    steps, errors = np.array([0.4, 0.2, 0.1]), []
    for h in steps:
        ends = [MovingPoses(*(v[None] for v in motion(t)), rate(t)[None]) for t in (0.1, 0.1 + h)]
        r, q, x = np.empty((1, 1, 3)), np.empty((1, 1, 4)), np.empty((1, 1, 6))
        interpolate(np.array([0.45]), h, *ends, np.array([float(split)]), smooth, r, q, x, np.empty((10, 6)))
        exact = motion(0.1 + 0.45 * h)
        errors.append(max(np.abs(r[0, 0] - exact[0]).max(), np.abs(q[0, 0] - exact[1]).max()))
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=0.6)


def test_extent_of_a_motion():
    """Independent code: norms of NumPy; a rotation is no larger for the other sign of its quaternion."""
    rng = np.random.default_rng(3)
    r0, r = rng.normal(size=(2, 7, 3))
    twist = rng.normal(size=(7, 6))
    q0 = np.tile([1.0, 0.0, 0.0, 0.0], (7, 1))
    q = q0 + 0.2 * rng.normal(size=(7, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    q[::2] *= -1.0
    chord = np.minimum(np.linalg.norm(q - q0, axis=1), np.linalg.norm(q + q0, axis=1))
    for length in (0.1, 10.0):
        far = max(np.linalg.norm(r - r0, axis=1).max() / length, 2.0 * chord.max())
        speeds = np.linalg.norm(twist.reshape(7, 2, 3), axis=2).max(axis=0)
        found = motion_extent(r0, q0, r, q, twist, length)
        assert found == pytest.approx((far, max(speeds[0] / length, speeds[1])), rel=1e-14)


def moving_nodes():
    """Poses of five nodes where a motion begins, and elsewhere, with body twists."""
    rng = np.random.default_rng(5)
    r0, r = rng.normal(size=(2, 5, 3))
    q0, q = rng.normal(size=(2, 5, 4))
    q0 /= np.linalg.norm(q0, axis=1, keepdims=True)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return r0, q0, r, q, rng.normal(size=(5, 6))


def carried(carrier, r0, q0, r, q, twist):
    found = np.empty_like(r0), np.empty_like(q0), np.empty_like(twist)
    carry_along(carrier, r0, q0, r, q, twist, *found)
    return found


def test_a_rigid_motion_is_all_carried_along():
    """By any of its nodes; what one of the others does beside it is all that is left (rotations by SciPy)."""
    r0, q0, *_ = moving_nodes()
    turn, moved = Rotation.from_rotvec([0.4, -1.9, 1.1]), np.array([0.3, 2.0, -1.0])
    velocity, spin = np.array([1.0, -2.0, 0.5]), np.array([3.0, 0.2, -1.0])
    r = moved + turn.apply(r0)
    now = turn * Rotation.from_quat(np.roll(q0, -1, axis=1))
    q = np.roll(now.as_quat(), 1, axis=1)
    twist = np.hstack([now.inv().apply(velocity + np.cross(spin, r)), now.inv().apply(np.tile(spin, (5, 1)))])
    own = np.array([0.1, 0.2, -0.3, 0.4, 0.5, 0.6])
    for node in (0, 3):
        moving = twist.copy()
        moving[2] += own
        there, turned, relative = carried(Carrier(node, 1, np.eye(3)), r0, q0, r, q, moving)
        np.testing.assert_allclose(there, r, atol=1e-14)
        np.testing.assert_allclose(np.abs(np.sum(turned * q, axis=1)), 1.0, atol=1e-14)
        expected = np.zeros((5, 6))
        expected[2] = own
        np.testing.assert_allclose(relative, expected, atol=1e-13)


def test_what_does_not_turn_is_carried_in_some_directions():
    """All nodes go as far as theirs goes in a plane, whichever way it turns."""
    r0, q0, r, q, twist = moving_nodes()
    plane = np.eye(3) - np.outer([0.6, 0.0, 0.8], [0.6, 0.0, 0.8])
    there, turned, relative = carried(Carrier(1, 0, plane), r0, q0, r, q, twist)
    np.testing.assert_allclose(there, r0 + plane @ (r[1] - r0[1]), atol=1e-14)
    np.testing.assert_array_equal(turned, q0)
    now = Rotation.from_quat(np.roll(q, -1, axis=1))
    speed = now.apply(twist[:, :3])
    np.testing.assert_allclose(now.apply(relative[:, :3]), speed - plane @ speed[1], atol=1e-14)
    np.testing.assert_array_equal(relative[:, 3:], twist[:, 3:])


def test_kernels_are_called_with_types_that_are_known():
    """The same as the kernel itself, also for another layout at the first call, and for numbers of NumPy."""
    rng = np.random.default_rng(4)
    r0, r = rng.normal(size=(2, 7, 3))
    q0, q = rng.normal(size=(2, 7, 4))
    for twist in (rng.normal(size=(7, 6)), rng.normal(size=(6, 7)).T):
        known = KnownTypes(motion_extent)
        for length in (1.0, np.float64(0.5), 2.0):
            assert known.call(r0, q0, r, q, twist, length) == motion_extent(r0, q0, r, q, twist, length)


@pytest.mark.parametrize("numbers", ["of Numba", "none"])
def test_types_are_told_apart_as_numba_does(numbers, monkeypatch):
    """Kinds, dimensions, layouts, arrays that may not be written, in bundles too, with Numba's numbers or without."""
    if numbers == "none":
        monkeypatch.setattr(shared, "_fingerprint", shared._unknown)
    array = np.zeros((2, 3))
    frozen = array.copy()
    frozen.flags.writeable = False
    one, other = MovingPoses(*[array] * 4), MovingPoses(array, array, array, frozen)
    single = [
        array,
        array.T,
        array[0],
        array.astype(complex),
        array.astype(np.int64),
        frozen,
        None,
        1.0,
        2,
        True,
    ]
    kinds = [*[(value,) for value in single], (one,), (other,), (one, 1.0)]
    found = shared.kinds_of
    assert len({found(arguments) for arguments in kinds}) == len(kinds)
    assert found((array, one)) == found((np.ones((5, 2)), one))
