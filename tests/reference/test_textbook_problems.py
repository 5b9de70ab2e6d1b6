"""Problems of textbooks, computed as a new user would: meshes and settings are left to the program."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import iv, ive, jv, kv, kve, yv

import viscorod as vr

STEEL = vr.Material(2e11, 0.3, 7850.0)


def cone_frequencies(radius: float, tip: float, count: int) -> list[float]:
    """Frequencies [Hz] of a clamped cone of length 1 that is cut off at the part ``tip`` of its radius.

    With x from the apex, ``(x^4 y'')'' = k^4 x^2 y``: ``y = Z_2(z)/x`` with ``z = 2 k sqrt(x)``, and
    ``y'' = k^2 Z_4(z)/x^2``, ``(x^4 y'')' = k^3 x^(3/2) Z_3(z)``, with the signs of J, Y, I, K (Kirchhoff 1882).
    """
    long = 1.0 / (1.0 - tip)  # to the apex
    scale = np.sqrt(STEEL.youngs_modulus * radius**2 / (4.0 * STEEL.density)) / long

    def determinant(k: float) -> float:
        at, end = 2.0 * k * np.sqrt(long), 2.0 * k * np.sqrt(long * tip)
        first = [jv(2, at), yv(2, at), ive(2, at), kve(2, at)]
        slope = [-jv(3, at), -yv(3, at), ive(3, at), -kve(3, at)]
        # those of I and K are divided by what they are at the foot
        grown, fallen = np.exp(-at), np.exp(at)
        bent = [jv(4, end), yv(4, end), iv(4, end) * grown, kv(4, end) * fallen]
        sheared = [jv(3, end), yv(3, end), iv(3, end) * grown, -kv(3, end) * fallen]
        rows = np.array([first, slope, bent, sheared])
        return float(np.linalg.det(rows / np.abs(rows).max(axis=1, keepdims=True)))

    tried = np.linspace(0.5, 8.0, 400)
    signs = [determinant(k) for k in tried]
    pairs = zip(tried[:-1], tried[1:], signs[:-1], signs[1:], strict=True)
    roots = [brentq(determinant, a, b, xtol=1e-12) for a, b, p, q in pairs if p * q < 0.0]
    return [k**2 * scale / (2.0 * np.pi) for k in roots[:count]]


@pytest.mark.parametrize("tip", [0.2, 1e-3])
def test_a_cone_vibrates_as_kirchhoff_says(tip: float) -> None:
    """Its mesh has to reach modes at the tip; Euler and Bernoulli leave out 1e-4 of shear and rotary inertia."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Taper(vr.Circle(0.005), vr.Circle(0.005 * tip)), material=STEEL
    )
    model.add("cone", rod)
    model.clamp("cone.start")
    found = model.modes(6, about="reference")
    assert found.frequencies == pytest.approx(np.repeat(cone_frequencies(0.005, tip, 3), 2), rel=5e-4)
    assert not found.warnings


def test_frequencies_that_a_mesh_does_not_resolve_are_told() -> None:
    """One element of order 2 for three modes of each plane: the second ones are wrong, and listed."""
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=STEEL, elements=1, order=2)
    model.add("bar", rod)
    model.clamp("bar.start")
    coarse = model.modes(6, about="reference")
    (told,) = [text for text in coarse.warnings if "frequencies of modes" in text]
    assert "use more elements" in told
    exact = 22.0344916 * np.sqrt(2e11 * 0.005**2 / (4.0 * 7850.0)) / (2.0 * np.pi)  # Euler and Bernoulli
    assert abs(coarse.frequencies[2] / exact - 1.0) > 0.01
