"""Modes in which bending is coupled with torsion by the mass centre, and with bending by a pre-twist: by Ritz."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss
from scipy.linalg import eigh

import viscorod as vr

STIFF = 1e12
"""Stiffness against what Ritz's functions leave out."""
PLACES, WEIGHTS = (0.5 * leggauss(60)[0] + 0.5, 0.5 * leggauss(60)[1])


def _functions(lowest: int, derivative: int, count: int = 12) -> np.ndarray:
    """Return derivatives of polynomials with the factor ``x^lowest`` at the places, ``(count, n)``."""
    factor = Polynomial([0.0] * lowest + [1.0])
    functions = [factor * Legendre.basis(k, domain=[0, 1]).convert(kind=Polynomial) for k in range(count)]
    return np.array([one.deriv(derivative)(PLACES) for one in functions])


def test_a_wing_whose_mass_centre_is_off_its_axis() -> None:
    """Goland 1945: w and the twist t with ``m (w' + x t')^2 + (I - m x^2) t'^2``; published 49.6, 97.0, 248.9 rad/s."""
    length, m, inertia, off, bending, torsion = 6.0, 35.75, 8.65, 0.18, 9.75e6, 9.88e5
    w, t = _functions(2, 0), _functions(1, 0)
    bent, twisted = _functions(2, 2) / length**2, _functions(1, 1) / length
    zero = np.zeros((len(w), len(t)))
    stiffness = np.block(
        [[bending * (bent * WEIGHTS) @ bent.T, zero], [zero.T, torsion * (twisted * WEIGHTS) @ twisted.T]]
    )
    both = m * off * (w * WEIGHTS) @ t.T
    mass = np.block([[m * (w * WEIGHTS) @ w.T, both], [both.T, inertia * (t * WEIGHTS) @ t.T]])
    expected = np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:6])
    assert expected[:3] == pytest.approx([49.6, 97.0, 248.9], rel=1e-3)

    matrix = np.diag([m, m, m, 1e-6, inertia, inertia])
    matrix[1, 5] = matrix[5, 1] = m * off
    matrix[2, 4] = matrix[4, 2] = -m * off
    section = vr.StiffnessSection([STIFF, STIFF, STIFF, bending, STIFF, torsion], matrix)
    model = vr.Model()
    model.add("wing", vr.Rod.straight((0, 0, 0), (0, length, 0), d1=(1, 0, 0), section=section))
    model.clamp("wing.start")
    found = model.modes(6)
    assert found.frequencies * 2.0 * np.pi == pytest.approx(expected, rel=1e-4)


def test_a_pretwisted_strip_bends_in_both_directions_at_once() -> None:
    """A clamped strip turned by 45 degrees towards its end, stiffnesses 1 to 64, after Euler and Bernoulli by Ritz."""
    angle, weak, strong = np.pi / 4.0, 1.0, 64.0
    c, s = np.cos(angle * PLACES), np.sin(angle * PLACES)
    u, bent = _functions(2, 0), _functions(2, 2)
    across, along = np.vstack([-s * bent, c * bent]), np.vstack([c * bent, s * bent])
    stiffness = weak * (across * WEIGHTS) @ across.T + strong * (along * WEIGHTS) @ along.T
    mass = np.kron(np.eye(2), (u * WEIGHTS) @ u.T)
    expected = np.sqrt(eigh(stiffness, mass, eigvals_only=True)[:4])

    section = vr.StiffnessSection([1e8, 1e8, 1e8, weak, strong, 1e6], [1, 1, 1, 1e-9, 1e-9, 2e-9])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0, 0, 1), d1=(1, 0, 0), section=section, twist=angle)
    model.add("strip", rod)
    model.clamp("strip.start")
    assert model.modes(4).frequencies * 2.0 * np.pi == pytest.approx(expected, rel=2e-4)
