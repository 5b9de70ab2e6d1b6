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


@pytest.mark.parametrize("relaxing", [0.0, 1.0])
def test_modes_about_an_unstable_state_are_about_that_and_say_what_grows(relaxing: float) -> None:
    """Euler's column under 1.5 times what its relaxed stiffness bears: ``s^2 = (1.5 - 1) pi^4`` without relaxation.

    With a branch as stiff as the rest it bears that at once, and swings as ``s^2 + pi^4 (1 + g - 1.5) = 0``, with
    ``g = t s/(1 + t s)``, whose real root grows: it creeps away (Rabotnov and Shesterikov 1957, creep buckling).
    """
    stiffness = {"EA": 1e6, "GA1": 1e6, "GA2": 1e6, "EI1": 1.0, "EI2": 4.0, "GJ": 1.0}
    time = 10.0
    branches = [vr.MaxwellBranch(time, {key: relaxing * value for key, value in stiffness.items()})]
    section = vr.StiffnessSection(
        stiffness, [1.0] * 3 + [1e-7, 1e-7, 2e-7], branches=branches if relaxing else []
    )
    column = vr.Model()
    column.add("column", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section))
    column.support("column.start", ("ux", "uy", "uz", "rx"))
    column.support("column.end", ("uy", "uz"))
    column.force("column.end", (-1.5 * np.pi**2, 0, 0))
    straight = column.equilibrium(search=False)
    assert straight.negative_eigenvalues == 1
    found = column.modes(2, about=straight)
    # s^2 (1 + t s) + pi^4 (t s - 0.5 (1 + t s)) = 0; t = 0 is no branch
    t = time if relaxing else 0.0
    roots = np.roots([t, 1.0, np.pi**4 * 0.5 * t, -0.5 * np.pi**4])
    growing = roots[np.argmax(roots.real)]
    assert growing.real == pytest.approx(0.1 if relaxing else np.pi**2 * np.sqrt(0.5), rel=1e-3)
    swing = roots[np.argmax(roots.imag)] if relaxing else growing
    assert np.abs(found.eigenvalues / swing - 1.0).min() < 1e-4
    (told,) = found.warnings
    assert told.startswith("the equilibrium is unstable: a small motion grows from it")
    assert ("grows" in found.report().split("Warnings")[0]) is not bool(relaxing)


def strut() -> vr.Model:
    """A clamped strut of length 1 and EI = 1, pressed by twice Euler's load."""
    section = vr.StiffnessSection({"EA": 1e6, "GA1": 1e6, "GA2": 1e6, "EI1": 1.0, "EI2": 2.0, "GJ": 1.0})
    model = vr.Model()
    model.add("strut", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, elements=3, order=4))
    model.clamp("strut.start")
    model.force("strut.end", (0, 0, -2.0 * np.pi**2 / 4.0))
    return model


def test_states_on_the_way_that_are_unstable_are_told() -> None:
    """Euler: straight from half the load on it is unstable; load steps go straight on, and the last one buckles."""
    (told,) = strut().equilibrium(load_factors=(0.3, 0.49, 0.51, 0.7, 1.0)).warnings
    assert told.startswith("the states at 0.51, 0.7 are unstable")
    assert not strut().equilibrium(load_factors=(0.3, 0.49)).warnings
    assert not strut().equilibrium().warnings


def test_a_slender_spring_bows_at_haringxs_compression() -> None:
    """Haringx 1948, both ends clamped: ``x (1 - G/E) = 1/2 (1 - sqrt(1 - (1 - G/E)/(1/2 + G/E) (2 pi D/L)^2))``.

    x is the part of its length by which it is shorter. A coil is never quite straight: it bows a little beforehand, and
    what keeps the bow small on the way is lost at that compression, where straight states begin to be unstable.
    """
    D, d, turns, length = 0.02, 0.001, 20, 0.16
    ratio = 1.0 / 2.6
    root = np.sqrt(1.0 - (1.0 - ratio) / (0.5 + ratio) * (2.0 * np.pi * D / length) ** 2)
    compression = 0.5 * (1.0 - root) / (1.0 - ratio)
    spring = vr.Model()
    coil = vr.Rod.helix(
        D / 2, length / turns, turns, section=vr.Circle(d / 2), material=STEEL, elements=60, order=4
    )
    spring.add("coil", coil)
    spring.clamp("coil.start")
    spring.support("coil.end", ("ux", "uy", "rx", "ry", "rz"))
    spring.force("coil.end", (0, 0, -STEEL.youngs_modulus * ratio * d**4 / (8 * D**3 * turns) * length))
    factors = compression * np.array([0.95, 1.06])
    below, above = (spring.equilibrium(load_factor=float(factor), search=False) for factor in factors)
    assert below.negative_eigenvalues == 0
    assert above.negative_eigenvalues > 0
    short = -below.displacement("coil.end")[2] / length
    assert short == pytest.approx(factors[0], rel=0.02)
