"""LLT 2.6, "a detailed comparison remains to be done": the rod beside the same bar as a solid in ANCF.

The solid is independent of the package: other unknowns, strains of three dimensions, lambda and mu, a law at every
point.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import viscorod as vr
from viscorod import programs as vd

from .independent.ancf import Ancf, Bar, uniaxial_modulus

SHEAR, BULK = 0.02, 0.03
TAU_E = (0.4 * BULK + 2.6 * SHEAR) / 3  # LLT (4), nu = 0.3
LOCKED = 0.7 / (1.3 * 0.4)
"""(lambda + 2 mu)/E."""


@lru_cache
def solid(enriched, shear=SHEAR, bulk=BULK, elements=2, order=4):
    return Ancf(Bar(shear_time=shear, bulk_time=bulk, enriched=enriched, elements=elements, order=order))


@lru_cache
def rod(shear=SHEAR, bulk=BULK):
    damping = vr.KelvinVoigt(shear_time=shear, bulk_time=bulk)
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=damping)
    line = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber, elements=2, order=5
    )
    model = vr.Model()
    model.add("beam", line)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model


def slow_mode(beam):
    """The first bending mode of a solid."""
    found = beam.eigenvalues()
    return found[found.imag > 0][0]


def time_of(mode):
    """The retardation time of a mode, 2 zeta/omega."""
    return -2 * mode.real / abs(mode) ** 2


@pytest.mark.parametrize("enriched", [False, True])
def test_forces_of_the_solid_have_their_tangents(enriched):
    """The independent code against itself: central differences; rigid rotation gives no force."""
    beam = solid(enriched, elements=1)
    rng = np.random.default_rng(1)
    q, rate, way = beam.start.copy(), *np.zeros((2, beam.start.size))
    q[beam.free] += 1e-3 * rng.normal(size=beam.free.size)
    rate[beam.free], way[beam.free] = rng.normal(size=(2, beam.free.size))
    for k, (a, b) in enumerate(((1e-6, 0.0), (0.0, 1e-6))):
        slope = (beam.forces(q + a * way, rate + b * way) - beam.forces(q - a * way, rate - b * way)) / 2e-6
        exact = beam.tangents(q, rate)[k] @ way[beam.free]
        assert slope == pytest.approx(exact, abs=1e-6 * np.abs(exact).max())
    turned, n = beam.start.copy(), beam.nodes
    turned[: 4 * n] = np.concatenate(
        [0.6 * turned[:n], 0.8 * turned[:n], -0.8 * turned[3 * n : 4 * n], 0.6 * turned[3 * n : 4 * n]]
    )
    assert np.abs(beam.forces(turned, np.zeros_like(turned))).max() < 1e-10


def test_the_solid_has_the_constants_that_the_translation_gives():
    """lambda_v and mu_v of ``programs.ANCF``; lambda_v = zeta - 2/3 eta."""
    inputs = vd.ANCF.from_section(vd.SectionData.of(rod().rods["beam"]))
    bar = solid(True).bar
    assert inputs.lame == pytest.approx((bar.lam, bar.mu), rel=1e-12)
    assert inputs.viscosities == pytest.approx((bar.lam_v, bar.mu_v), rel=1e-12)


@pytest.mark.parametrize("enriched", [False, True])
def test_stretching_agrees(enriched):
    """Both elements contract freely when pulled: E A, not (lambda + 2 mu) A."""
    beam = solid(enriched)
    pulled = beam.equilibrium(beam.end_load(np.array([1e-4, 0.0])), 1)
    assert pulled[beam.nodes - 1] - 0.3 == pytest.approx(1e-4 * 0.3 / 100.0, rel=1e-5)


def test_bending_agrees_only_if_the_section_can_bulge():
    """Closed forms (Timoshenko): E I where it can; (lambda + 2 mu) I, 35 % more, where it cannot: Poisson locking."""
    force, area, inertia = 1e-6, 1e-4, 1e-8 / 12
    shear = force * 0.3 / (1e6 / 2.6 * area)
    for enriched, modulus in ((True, 1e6), (False, LOCKED * 1e6)):
        beam = solid(enriched)
        bent = beam.equilibrium(beam.end_load(np.array([0.0, force])), 1)
        deflection = force * 0.3**3 / 3 / modulus / inertia + shear
        assert bent[2 * beam.nodes - 1] == pytest.approx(deflection, rel=1e-4)


def test_small_vibrations_agree_only_if_the_section_can_bulge():
    """Frequency and damping of the first bending mode: those of the rod, or of lambda + 2 mu and its own time."""
    mode = slow_mode(solid(True))
    found = rod().modes(1, about="reference").eigenvalues[0]
    assert mode == pytest.approx(found, rel=3e-4)
    assert time_of(mode) == pytest.approx(TAU_E, rel=1e-3)
    locked = slow_mode(solid(False))
    inputs = vd.ANCF.from_section(vd.SectionData.of(rod().rods["beam"]))
    assert abs(locked / mode) ** 2 == pytest.approx(LOCKED, rel=1e-3)
    assert time_of(locked) == pytest.approx(inputs.time_of_rigid_section, rel=1e-3)
    assert inputs.time_of_rigid_section / TAU_E > 1.2
    # with equal times the lock changes the frequency only
    assert time_of(slow_mode(solid(False, bulk=SHEAR))) == pytest.approx(SHEAR, rel=1e-9)


def test_fast_stretching_shows_the_relaxation_in_the_section():
    """First longitudinal mode, bulk time ten times the shear time: rho s^2 + E*(s) k^2 = 0 with k = pi/2L.

    The solid has 1/E* = 1/(9 K*) + 1/(3 G*): its lateral contraction lags. The rod prescribes the contraction,
    E* = E (1 + s tau_E), which is the same to first order in s tau only.
    """
    shear, bulk = 0.0005, 0.005
    bar = solid(False, shear, bulk).bar
    wave = np.pi / 2 / 0.3

    def root(modulus):
        s = 1j * wave * np.sqrt(1e6 / 1000.0)
        for _ in range(200):
            s = 0.5 * (s + 1j * wave * np.sqrt(modulus(s) / 1000.0))
        return s

    expected = root(lambda s: uniaxial_modulus(bar, s))
    extension = (0.4 * bulk + 2.6 * shear) / 3
    slow = root(lambda s: 1e6 * (1 + s * extension))
    for enriched in (False, True):
        found = solid(enriched, shear, bulk).eigenvalues()
        assert np.abs(found - expected).min() < 1e-3 * abs(expected)
    modes = rod(shear, bulk).modes(12, about="reference")
    stretch = modes.eigenvalues[list(modes.names).index("stretch 1")]
    assert stretch == pytest.approx(slow, rel=1e-4)
    assert slow.real / expected.real == pytest.approx(1.174, abs=1e-3)


def test_large_swing_agrees_only_if_the_section_can_bulge():
    """The first half second of LLT's swing: within 0.2 % of the length; the locked element is off by a tenth of it."""
    times = np.linspace(0, 0.5, 11)
    run = rod(SHEAR, SHEAR).simulate(0.5, tolerance=1e-6, output_interval=0.05)
    tip = run.history("beam.end").values[:, :2]
    gaps = []
    for enriched, elements, order in ((True, 1, 5), (False, 1, 4)):
        beam = solid(enriched, bulk=SHEAR, elements=elements, order=order)
        bent = beam.equilibrium(beam.end_load(np.array([0.0, 0.035])))
        gaps.append(np.abs(beam.release(bent, times, 1e-4).tip - tip).max() / 0.3)
    assert gaps[0] < 2e-3
    assert gaps[1] > 0.1
