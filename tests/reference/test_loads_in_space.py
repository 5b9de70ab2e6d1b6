"""Forces towards points and on lines of space, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

import viscorod as vr
from viscorod.model.actions.loads_in_space import _law, _on_line, _towards

E, R = 2e11, 1.0
STEEL = vr.Material(E, 0.3, 7850.0)
STRIP = vr.Rectangle(0.02, 0.005)
EI = E * 0.02 * 0.005**3 / 12.0


def ring() -> vr.Model:
    """A quarter of a ring in the xy plane that becomes an oval, between two planes of symmetry."""
    model = vr.Model()
    line = vr.Arc((R, 0, 0), (0, 1, 0), (-1, 0, 0), R, np.pi / 2)
    model.add("ring", vr.Rod(line, STRIP, STEEL, d1=(0, 0, 1), elements=2, order=5))
    model.support("ring.start", ("uy", "uz", "rx", "ry", "rz"))
    model.support("ring.end", ("ux", "uz", "rx", "ry", "rz"))
    return model


def test_a_ring_is_buckled_by_pressure_towards_its_centre_or_of_a_fluid() -> None:
    """Timoshenko and Gere: 4.5 EI/R^3 towards the centre, 3 EI/R^3 by a fluid, which follows the ring.

    What a ring of this thickness gives way before, by its shortening, is (h/R)^2 of it.
    """
    central, fluid = ring(), ring()
    central.distributed_force_towards("ring", 1.0, (0, 0, 0))
    fluid.distributed_force("ring", (0, -1.0, 0), following=True)  # d2 points outwards
    for model, times in ((central, 4.5), (fluid, 3.0)):
        found = model.buckling(count=1, exact=False)
        assert found.load_factors[0] == pytest.approx(times * EI / R**3, rel=1e-4)


@pytest.mark.parametrize("below", [0.0, 1.0])
def test_a_column_whose_load_points_to_one_place(below: float) -> None:
    """Timoshenko and Gere: EI y'' + P y = P y_tip (1 - (L - x)/c), so that tan u = u (1 - c/L), with u = L sqrt(P/EI).

    c is how far from the tip the point is: at the foot (c = L) u = pi, far away Euler's pi/2.
    """
    u = np.pi if below == 0.0 else brentq(lambda u: np.sin(u) + below * u * np.cos(u), 1.6, 3.1)
    column = vr.Model()
    section = vr.StiffnessSection({"EA": 1e8, "GA1": 1e8, "GA2": 1e8, "EI1": 1.0, "EI2": 2.0, "GJ": 1.0})
    column.add("column", vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section))
    column.clamp("column.start")
    column.force_towards("column.end", 1.0, (0, 0, -below))
    found = column.buckling(count=1)
    assert found.load_factors[0] == pytest.approx(u**2, rel=1e-5)
    assert not found.warnings


def follower_column() -> vr.Model:
    section = vr.StiffnessSection([1.0, 1.0, 1.0, 1.0, 5.0, 1.0], [1, 1, 1, 1e-9, 1e-9, 2e-9])
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0, 0, 1), section=section, elements=4, order=4, constraints="kirchhoff")
    model.add("column", rod)
    model.clamp("column.start")
    return model


def test_reuts_column_has_the_frequencies_of_becks() -> None:
    """Its problem is the adjoint of Beck's (Bolotin 1963): equal frequencies under every load, flutter at 20.05095."""
    reut, beck = follower_column(), follower_column()
    reut.force_on_line("column.end", (0, 0, -12.0), (0, 0, 0))
    beck.force("column.end", (0, 0, -12.0), following=True)
    assert reut.modes(6).frequencies == pytest.approx(beck.modes(6).frequencies, rel=1e-7)
    (limit,) = reut.stability(band=(0.0, 2.0), count=5, modes=3).limits
    assert 12.0 * limit.at == pytest.approx(20.05095, rel=1e-6)


def test_a_body_goes_round_a_point_that_pulls_it() -> None:
    """On a circle F = m v^2/r; on other ways its energy m v^2/2 + F r, and the work of the load is -F dr."""
    mass, force, radius = 2.0, 8.0, 1.5
    light = vr.StiffnessSection([1e4, 1e4, 1e4, 1.0, 1.0, 1.0], [1e-4, 1e-4, 1e-4, 1e-8, 1e-8, 2e-8])
    model = vr.Model()
    model.add("stub", vr.Rod.straight((radius, 0, 0), (radius, 0, 0.1), section=light, elements=1, order=2))
    model.add("ball", vr.Body(mass, (1e-3, 1e-3, 1e-3), centre=(radius, 0, 0)))
    model.attach("stub.start", "ball")
    model.force_towards("ball", force, (0, 0, 0))
    for part in (1.0, 0.7):
        speed = part * np.sqrt(force * radius / mass)
        model.velocities.clear()
        for name in ("ball", "stub"):
            model.velocity(name, linear=(0, speed, 0))
        run = model.simulate(
            2.0 * np.pi * radius / speed, initial="reference", tolerance=1e-6, errors=False, accuracy=1e-3
        )
        distance = np.linalg.norm(run.history("ball").values, axis=1)
        velocity = run.history("ball", "velocity").values
        energy = 0.5 * mass * (velocity**2).sum(axis=1) + force * distance
        assert energy == pytest.approx(np.full(len(energy), energy[0]), rel=1e-4)
        assert run.energy.external == pytest.approx(-force * (distance - radius), abs=1e-3 * force)
        if part == 1.0:
            assert distance == pytest.approx(np.full(len(distance), radius), rel=1e-4)
        else:
            assert distance.min() < 0.8 * radius


def test_points_that_give_no_direction_are_refused() -> None:
    model = ring()
    with pytest.raises(vr.InputError, match=r"ForceTowards\.point.*0 m from this point, too near"):
        model.force_towards("ring.start", 1.0, (R, 0, 0))
    with pytest.raises(
        vr.InputError, match=r"DistributedForceTowards\.point.*give a point at least 1e-09 m away"
    ):
        model.distributed_force_towards("ring", 1.0, (0, R, 1e-10))
    with pytest.raises(vr.InputError, match="did you mean 'ring'"):
        model.distributed_force_towards("rign", 1.0, (0, 0, 0))


def test_derivatives_by_the_pose_are_those_of_differences() -> None:
    """Central differences of the wrench, at a random pose."""
    rng = np.random.default_rng(1)
    R, r = Rotation.random(random_state=1).as_matrix(), rng.normal(size=3)
    for in_space in (
        _towards(np.array([1.0, 2.0, 3.0]), 2.5),
        _on_line(np.array([1.0, 2, 3]), np.array([-1, 0.4, 2])),
    ):
        law = _law(in_space)
        assert law.by_pose is not None
        exact, h = law.by_pose(r, R, np.zeros(6)), 1e-6
        for k, unit in enumerate(h * np.eye(6)):
            ends = [
                law.wrench(r + R @ x[:3], R @ Rotation.from_rotvec(x[3:]).as_matrix(), np.zeros(6))
                for x in (unit, -unit)
            ]
            assert exact[:, k] == pytest.approx((ends[0] - ends[1]) / (2.0 * h), abs=1e-8)


@pytest.mark.parametrize("length", [1.0, 1e-4])
def test_a_column_as_small_as_a_hair_is_as_right(length: float) -> None:
    """pi^2 EI/L^2, less what shear leaves out; differences over 1e-6 m were 1e-4 off at 0.1 mm."""
    column = vr.Model()
    bar = vr.Rod.straight((0, 0, 0), (0, 0, length), section=vr.Circle(0.005 * length), material=STEEL)
    column.add("column", bar)
    column.clamp("column.start")
    euler = np.pi**2 * E * np.pi * (0.005 * length) ** 4 / 4.0 / length**2
    column.force_towards("column.end", euler, (0, 0, 0))
    assert column.buckling(count=1).load_factors[0] == pytest.approx(1.0 - 1.193e-4, abs=2e-6)
