"""The independent solutions of mechanisms, checked against closed forms, against each other and for their energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from .independent.comb_resonator import UM, Resonator
from .independent.double_pendulum import DoublePendulum
from .independent.four_bar import POINTS, crank_angle, equilibrium, path
from .independent.mechanism_data import table
from .independent.rotor import Overhung, Top, quartic
from .independent.slider_crank import SliderCrank, solve


def test_double_pendulum_energy_and_small_oscillations():
    pendulum, times = DoublePendulum((1.0, 2.0), (0.7, 1.1)), np.linspace(0, 3, 31)
    states = pendulum.solve(times)
    assert np.ptp(pendulum.energy(states)) < 1e-9
    # both hang nearly straight: the exact motion of the linear problem
    small = pendulum.solve(times, (np.pi / 2 - 1e-5, np.pi / 2))
    w = pendulum.frequencies()
    basis = np.cos(np.outer(times, w))
    q = np.pi / 2 - small[:, :2]
    assert basis @ np.linalg.lstsq(basis, q, rcond=None)[0] == pytest.approx(q, abs=1e-10)


def test_double_pendulum_hinged_at_the_end_of_a_light_bar_is_a_pendulum():
    """A first bar of no mass under the second one's end: frequencies of equal rods are the textbook's."""
    w = DoublePendulum().frequencies() ** 2 / 9.81
    assert w == pytest.approx([3 - 6 / np.sqrt(7), 3 + 6 / np.sqrt(7)], rel=1e-12)


def test_double_pendulum_table():
    rows = table("double_pendulum")
    found = DoublePendulum().solve(rows["t"])
    assert found[:, 0] == pytest.approx(rows["angle1"], abs=1e-9)
    elbow, tip = DoublePendulum().places(found)
    assert elbow[:, 1] == pytest.approx(rows["elbow_z"], abs=1e-9)
    assert tip[:, 0] == pytest.approx(rows["tip_x"], abs=1e-9)


def test_four_bar_without_tilt_is_a_parallelogram():
    for pose in path(np.array([-0.5, -1.2]), tilt=0.0, stride=0.3):
        B = [-0.12 * np.sin(pose.crank), 0.12 * np.cos(pose.crank), 0]
        assert pose.B == pytest.approx(B, abs=1e-12)
        assert pose.C - pose.B == pytest.approx(np.subtract(POINTS["C"], POINTS["B"]), abs=1e-12)
        assert np.abs(pose.force).max() < 1e-7


def test_four_bar_motor_does_the_elastic_work():
    """For small angles the torque is linear in the angle; backwards the same with the other sign of the tilt."""
    first, x = equilibrium(-1e-4)
    second, _ = equilibrium(-2e-4, 2 * x)
    assert second.force[2] == pytest.approx(2 * first.force[2], rel=1e-3)
    mirrored, _ = equilibrium(-1e-4, tilt=-np.radians(5))
    assert mirrored.motor == pytest.approx(first.motor, rel=1e-9)
    assert mirrored.force * [1, 1, -1] == pytest.approx(first.force, rel=1e-9)


def test_four_bar_shooting_is_converged_and_gives_the_table():
    rows = table("four_bar")
    found = path(rows["crank"][:5], stride=0.05, steps=4)
    for k, pose in enumerate(found):
        assert pose.crank == pytest.approx(crank_angle(rows["t"][k]), abs=1e-8)
        assert pose.C == pytest.approx([rows[f"C_{i}"][k] for i in "xyz"], abs=3e-9)
        assert pose.force == pytest.approx([rows[f"force_{i}"][k] for i in "xyz"], abs=1e-5)
    fine, _ = equilibrium(-0.3, steps=12)
    coarse, _ = equilibrium(-0.3, steps=4)
    assert coarse.force == pytest.approx(fine.force, rel=1e-7)


def test_slider_crank_energy_and_rigid_limit():
    times = np.linspace(0, np.pi / 150, 9)
    case = SliderCrank(damping=2e-5)
    motion = solve(case, times, degree=8, steps=20)
    assert motion.imbalance < 1e-4
    # slower: nearly the rigid mechanism, deflections with the square of the speed
    slow = replace(case, speed=15.0, damping=1e-3)
    found = solve(slow, times * 10, degree=6, steps=40)
    assert found.slider == pytest.approx(slow.rigid_slider(times * 10), abs=1e-6)
    assert np.abs(found.deflection).max() < 0.015 * np.abs(motion.deflection).max()


def test_slider_crank_table():
    rows = table("slider_crank")
    found = solve(SliderCrank(damping=2e-5), rows["t"][:16], degree=8, steps=10)
    assert found.deflection == pytest.approx(rows["deflection_damped"][:16], abs=2e-5)
    assert found.slider == pytest.approx(rows["slider_damped"][:16], abs=2e-5)


def test_whirl_of_the_overhung_disc():
    rotor = Overhung()
    for spin in (0.0, 120.0, 700.0):
        assert rotor.whirl(spin) == pytest.approx(quartic(rotor, spin), rel=1e-9)
    # fast spin: the disc cannot tilt, the shaft is guided at its end, and one mode precesses at Ip W/Id
    fast = rotor.whirl(1e6)
    guided = np.sqrt(12 * rotor.EI / rotor.length**3 / rotor.mass)
    assert fast[[0, 2]] == pytest.approx([-guided, guided], rel=1e-3)
    assert fast[3] == pytest.approx(rotor.polar / rotor.diametral * 1e6, rel=1e-6)


def test_whirl_with_the_mass_of_the_shaft():
    """No disc: the cantilever's 3.51602; a light shaft: the consistent mass; without shear the limit of shear."""
    bare = Overhung(line_mass=1.0, mass=0.0, polar=0.0, diametral=1e-12)
    first = 1.875104068711961**2 / bare.length**2 * np.sqrt(bare.EI)
    assert np.min(np.abs(np.linalg.det(bare.dynamic_stiffness(first)))) < 1e-6 * np.linalg.det(
        bare.stiffness()
    )
    w = 20.0
    light = Overhung(line_mass=0.5)
    expected = light.stiffness() - w * w * light.consistent_mass()
    assert light.dynamic_stiffness(w) == pytest.approx(expected, rel=1e-6)
    assert Overhung(GA=1e12).whirl(300.0) == pytest.approx(Overhung().whirl(300.0), rel=1e-6)
    drop = Overhung(line_mass=0.01).whirl(300.0) / Overhung().whirl(300.0) - 1
    assert np.all(drop < 0)
    assert np.all(drop > -2e-3)


def test_steady_precession_of_the_top():
    top = Top(mass=1.0, axial=0.002, transverse=0.012, distance=0.1)
    slow, fast = top.precession(0.5, 200.0)
    weight = top.mass * top.gravity * top.distance
    for rate in (slow, fast):
        balance = top.transverse * np.cos(0.5) * rate**2 - top.axial * 200.0 * rate + weight
        assert balance == pytest.approx(0, abs=1e-12 * top.axial * 200 * rate)
        # moment of momentum turns with the precession: its change is the moment of the weight
        omega, axis = top.angular_velocity(0.5, 200.0, rate), np.array([np.sin(0.5), 0, np.cos(0.5)])
        assert omega @ axis == pytest.approx(200.0)
        momentum = top.transverse * omega + (top.axial - top.transverse) * (omega @ axis) * axis
        change = np.cross([0, 0, rate], momentum)
        moment = np.cross(top.distance * axis, [0, 0, -top.mass * top.gravity])
        assert change == pytest.approx(moment, abs=1e-10)
        # nutation: curvature of the effective potential, by differences
        b, p = top.axial * 200.0, top.transverse * rate * np.sin(0.5) ** 2 + top.axial * 200.0 * np.cos(0.5)
        q = 0.5 + 1e-3 * np.arange(-1, 2)
        V = (p - b * np.cos(q)) ** 2 / (2 * top.transverse * np.sin(q) ** 2) + weight * np.cos(q)
        curvature = (V[0] - 2 * V[1] + V[2]) / 1e-6 / top.transverse
        assert top.nutation(0.5, 200.0, rate) == pytest.approx(np.sqrt(curvature), rel=1e-4)


def test_comb_resonator_formulas_against_exact_frequencies():
    for length in (146 * UM, 170 * UM):
        plain = Resonator(length=length)
        assert plain.folded_exact() == pytest.approx(plain.folded_lumped(), rel=1e-4)
        heavy = replace(plain, trusses=0.2 * plain.plate_mass)
        assert heavy.folded_exact() == pytest.approx(heavy.folded_lumped(), rel=2e-3)
    assert Resonator().folded_lumped() == pytest.approx(16770.92, abs=0.01)
    assert Resonator(length=170 * UM).folded_lumped() == pytest.approx(13319.46, abs=0.01)


def test_comb_resonator_numbers_of_the_published_model():
    """They are formulas without the mass of the flexures; frame elements give lower frequencies."""
    straight = Resonator(length=200 * UM)
    assert straight.straight_lumped(flexures=False) == pytest.approx(14989, abs=1)
    assert straight.straight_exact() == pytest.approx(straight.straight_lumped(), rel=1e-4)
    length = (170.0**3 + 146.0**3 + 10 * 2.25**2 / 4) ** (1 / 3)
    assert Resonator(length=length * UM).straight_lumped(flexures=False) == pytest.approx(14966, abs=1)


def test_hairpins_without_a_link_are_folded_flexures():
    """Both guided by symmetry, if the link has no length: the truss without mass."""
    plain = Resonator()
    assert plain.hairpins(146 * UM, 0.02 * UM, 146 * UM, elements=6) == pytest.approx(
        plain.folded_exact(), rel=1e-3
    )
    coarse, fine = (plain.hairpins(170 * UM, 10 * UM, 146 * UM, elements=n) for n in (4, 8))
    assert coarse == pytest.approx(fine, rel=1e-5)


def test_right_angle_table_begins_at_the_reference():
    rows = table("right_angle")
    assert [rows[f"{p}_{i}"][0] for p in ("elbow", "tip") for i in "xyz"] == pytest.approx(
        [10, 0, 0, 10, 10, 0]
    )
    assert rows["error"].max() < 5e-3
