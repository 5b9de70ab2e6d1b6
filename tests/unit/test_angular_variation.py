"""The calculus of rotations by complex steps: independent of the package, and against its element.

D. Liu and C. H.-T. Wang check their variational principle with the changes (23)-(25) that an angular variation Phi
makes, in components along the moving section: of the angular velocity dPhi/dt + w x Phi, of bending and twisting
dPhi/ds + u x Phi, and of the other strains dr'.d_i - Phi.(r' x d_i).
"""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.mechanics.elements.basis import gauss, lagrange
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise

STEP = 1e-30  # of complex steps, which have no cancellation


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def coefficients(square):
    """sin(x)/x, (1 - cos x)/x^2 and (x - sin x)/x^3 as power series of x^2: analytic, so complex numbers may pass."""
    first = second = third = 0.0
    term = 1.0
    for k in range(25):
        first, second, third = (
            first + term,
            second + term / (2 * k + 2),
            third + term / ((2 * k + 2) * (2 * k + 3)),
        )
        term = -term * square / ((2 * k + 2) * (2 * k + 3))
    return first, second, third


def exponential(a):
    A, B, _ = coefficients(a @ a)
    return np.eye(3) + A * skew(a) + B * skew(a) @ skew(a)


def tangent(a):
    """axial(R^T dR) = tangent(a) da."""
    _, B, C = coefficients(a @ a)
    return np.eye(3) - B * skew(a) + C * skew(a) @ skew(a)


POLYNOMIAL = np.random.default_rng(3).normal(size=(4, 3, 3))


def rotation_vector(x, y):
    """A smooth field of rotation vectors over x (time or arc length) and a parameter y, and its slope over x."""
    a = POLYNOMIAL[0, 0] + POLYNOMIAL[0, 1] * x + POLYNOMIAL[0, 2] * x**2
    b = POLYNOMIAL[1, 0] + POLYNOMIAL[1, 1] * x + POLYNOMIAL[1, 2] * x**3
    return a + y * b + y**2 * POLYNOMIAL[2, 0], POLYNOMIAL[0, 1] + 2 * POLYNOMIAL[0, 2] * x + y * (
        POLYNOMIAL[1, 1] + 3 * POLYNOMIAL[1, 2] * x**2
    )


def rate(x, y):
    """axial(R^T R_x): the angular velocity, or bending and twisting."""
    a, slope = rotation_vector(x, y)
    return tangent(a) @ slope


def variation(x, y=0.0):
    """axial(R^T R_y)."""
    b = POLYNOMIAL[1, 0] + POLYNOMIAL[1, 1] * x + POLYNOMIAL[1, 2] * x**3 + 2 * y * POLYNOMIAL[2, 0]
    return tangent(rotation_vector(x, y)[0]) @ b


@pytest.mark.parametrize("x", [0.0, 0.3, -0.7])
def test_change_of_a_rate(x):
    """(23) and (24): over y and along x by complex steps."""
    change = np.imag(rate(x, 1j * STEP)) / STEP
    Phi = variation(x)
    Phi_x = np.imag(variation(x + 1j * STEP)) / STEP
    assert change == pytest.approx(Phi_x + np.cross(rate(x, 0.0), Phi), abs=1e-12)


@pytest.mark.parametrize("x", [0.0, 0.3, -0.7])
def test_change_of_shear_and_stretch(x):
    """(25): v_i = r'.d_i."""

    def slope(y):
        return POLYNOMIAL[3, 0] + x * POLYNOMIAL[3, 1] + y * POLYNOMIAL[3, 2]

    def strain(y):
        return exponential(rotation_vector(x, y)[0]).T @ slope(y)

    change = np.imag(strain(1j * STEP)) / STEP
    R = exponential(rotation_vector(x, 0.0)[0])
    Phi = R @ variation(x)
    expected = [POLYNOMIAL[3, 2] @ d - Phi @ np.cross(slope(0.0), d) for d in R.T]
    assert change == pytest.approx(expected, abs=1e-12)


def multiply(p, q):
    scalar = p[0] * q[0] - p[1:] @ q[1:]
    return np.concatenate([[scalar], p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])])


def matrix(q):
    return (q[0] ** 2 - q[1:] @ q[1:]) * np.eye(3) + 2 * np.outer(q[1:], q[1:]) + 2 * q[0] * skew(q[1:])


def turned(q, angle):
    """A quaternion times the exponential of a small body rotation, to first order: enough for a complex step."""
    return multiply(q, np.concatenate([[1.0], 0.5 * angle]))


CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def element(r, q, N, slopes):
    """Strains (V, U) of the geometric element at a point, and its unit quaternion, for complex nodes too."""
    mean, change = N @ q, slopes @ q
    size = mean @ mean
    unit = mean / np.sqrt(size)
    return np.concatenate(
        [matrix(unit).T @ (slopes @ r), 2 * multiply(CONJUGATE * mean, change)[1:] / size]
    ), unit


@pytest.mark.parametrize("order", [1, 2, 4])
def test_element_against_complex_steps(order):
    """The rows of held strains are the changes of the strains, and these are (24) and (25)."""
    section = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
    model = vr.Model()
    words = ["shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"]
    rod = vr.Rod.arc(
        (0, 0, 0),
        (1, 0, 0),
        (0, 1, 0),
        1.0,
        1.0,
        section=section,
        elements=1,
        order=order,
        twist=0.5,
        constraints=words,
    )
    model.add("bow", rod)
    problem = discretise(model)
    system = GeometricSystem(problem)
    state = State.reference(problem)
    random = np.random.default_rng(order)
    state.r += 0.2 * random.normal(size=state.r.shape)
    for k in range(problem.size):
        state.q[k] = turned(state.q[k], 0.4 * random.normal(size=3))
        state.q[k] /= np.linalg.norm(state.q[k])
    rows = system.constraint_gradients(state).toarray()
    half = problem.sets[0].half_lengths[0]
    increment = random.normal(size=(problem.size, 6))
    moved = (
        [state.r[k] + 1j * STEP * matrix(state.q[k]) @ increment[k, :3] for k in range(problem.size)],
        [turned(state.q[k], 1j * STEP * increment[k, 3:]) for k in range(problem.size)],
    )
    r, q = map(np.array, moved)
    places, beside = gauss(order)[0], 1e-5

    def at(xi):
        values, slopes = lagrange(order, np.array([xi]))
        return element(r, q, values[0], slopes[0] / half)

    def angular(xi):
        """Angular variation of the interpolated rotation."""
        unit = at(xi)[1]
        return 2 * multiply(CONJUGATE * np.real(unit), np.imag(unit) / STEP)[1:]

    for g, xi in enumerate(places):
        strain, unit = at(xi)
        change = np.imag(strain) / STEP
        assert rows[6 * g : 6 * g + 6] @ increment.ravel() == pytest.approx(change, abs=1e-12)
        R, u, Phi = matrix(np.real(unit)), np.real(strain[3:]), angular(xi)
        Phi_s = (angular(xi + beside) - angular(xi - beside)) / (2 * beside * half)
        assert change[3:] == pytest.approx(Phi_s + np.cross(u, Phi), abs=1e-6)
        slopes = lagrange(order, np.array([xi]))[1][0] / half
        r_s, dr_s = np.real(slopes @ r), np.imag(slopes @ r) / STEP
        expected = [dr_s @ d - R @ Phi @ np.cross(r_s, d) for d in R.T]
        assert change[:3] == pytest.approx(expected, abs=1e-11)
