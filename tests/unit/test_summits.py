"""Tops between computed points, against the closed form of one degree of freedom."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.results.summits import largest_in_cycle, summit_of


def amplitude(ratio, zeta):
    return 1.0 / np.hypot(1.0 - ratio**2, 2.0 * zeta * ratio)


@pytest.mark.parametrize("shift", [0.0, 0.2, 0.5, 0.8])
def test_a_resonance_has_its_top_between_the_points(shift):
    """1/(2 zeta sqrt(1 - zeta^2)) at sqrt(1 - 2 zeta^2); ten points lie in the half-power band."""
    zeta = 0.05
    ratios = 0.9 + 0.01 * (np.arange(20) + shift)
    top = summit_of(ratios, amplitude(ratios, zeta))
    assert top.frequency == pytest.approx(np.sqrt(1.0 - 2.0 * zeta**2), rel=5e-5)
    assert top.amplitude == pytest.approx(0.5 / zeta / np.sqrt(1.0 - zeta**2), rel=5e-5)
    assert abs(ratios[top.point] - top.frequency) < 0.01
    assert amplitude(ratios, zeta).max() < top.amplitude * (1.0 - 4e-5)


def test_a_top_beside_which_the_curve_turns_back():
    """Points of the curve beyond its fold have frequencies of those before: f = 1 - x^2, a = 2 - (x - 0.4)^2."""
    x = np.arange(-0.5, 1.01, 0.1) + 0.03
    top = summit_of(1.0 - x**2, 2.0 - (x - 0.4) ** 2)
    assert (top.frequency, top.amplitude) == pytest.approx((0.84, 2.0), abs=1e-12)


def test_at_an_end_and_between_uneven_steps_the_top_is_a_point():
    ratios = np.linspace(0.8, 0.95, 10)
    sizes = amplitude(ratios, 0.05)
    assert summit_of(ratios, sizes) == (9, ratios[-1], sizes[-1])
    uneven = np.array([0.9, 0.95, 0.99, 0.991, 1.03, 1.07])
    sizes = amplitude(uneven, 0.05)
    assert summit_of(uneven, sizes) == (3, 0.991, sizes[3])


def test_the_largest_of_a_cycle_lies_between_its_instants():
    """A sine that is sampled half an instant off: 1 - cos(pi/n) of it would be missed."""
    instants = 2.0 * np.pi * np.arange(100) / 100
    waves = np.sin(instants + np.array([[0.0], [0.5], [0.31]]) * 2.0 * np.pi / 100)
    assert largest_in_cycle(waves) == pytest.approx(1.0, abs=2e-6)
    assert waves.max(axis=1)[1] < 1.0 - 4e-4
    assert largest_in_cycle(np.full((2, 8), 3.0)).tolist() == [3.0, 3.0]
