"""Prescribed rotations of any size, against the closed form of torsion: torque GJ phi/L, energy GJ phi^2/2L."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

RADIUS, YOUNG = 0.01, 1e6
GJ = YOUNG / 3.0 * np.pi * RADIUS**4 / 2.0


def rubber_rod(held, motion, *, young=YOUNG, poisson=0.5, radius=RADIUS, damping=None, **mesh):
    """A straight rod of 1 m along x, clamped at its start."""
    material = vr.Material(young, poisson, 1000.0, damping=damping)
    model = vr.Model()
    model.add(
        "rod",
        vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(radius), material=material, **mesh),
    )
    model.clamp("rod.start")
    if held == "clamp":
        model.clamp("rod.end", motion=motion)
    else:
        model.support("rod.end", held, motion=motion)
    return model


@pytest.mark.parametrize("turns", [0.5, 0.75, 1.0, -2.0, 5.0, 27.0])
def test_turns_of_a_clamp_are_followed(turns):
    """Beyond Greenhill's torque the straight rod is unstable, but still the equilibrium that was asked for."""
    phi = 2.0 * np.pi * turns
    found = rubber_rod("clamp", {"rx": phi}).equilibrium()
    assert found.reactions.values[1, 3] == pytest.approx(GJ * phi, rel=1e-8)
    assert found.elastic_energy == pytest.approx(0.5 * GJ * phi**2, rel=1e-8)


@pytest.mark.parametrize(
    "held",
    [
        ("uy", "uz", "ry", "rz"),
        ("uy", "uz"),
        ("ux", "uy", "uz", "ry", "rz"),
        ("uy", "uz", "ry"),
        ("uz", "ry", "uy"),
    ],
)
@pytest.mark.parametrize("turns", [0.75, 3.0])
def test_ends_that_are_held_in_part_turn_as_far(held, turns):
    phi = 2.0 * np.pi * turns
    found = rubber_rod(held, {"rx": phi}).equilibrium()
    assert found.reactions.values[1, 3] == pytest.approx(GJ * phi, rel=1e-8)
    assert found.position("rod.end") == pytest.approx([1, 0, 0], abs=1e-9)


@pytest.mark.parametrize("ux", [0.1, -0.02])
def test_an_end_that_turns_may_move_as_well(ux):
    """Torsion and stretch of a linear section do not know of each other: EA u + GJ phi."""
    found = rubber_rod("clamp", {"rx": 4.0 * np.pi, "ux": ux}).equilibrium()
    force = YOUNG * np.pi * RADIUS**2 * ux
    assert found.reactions.values[1, [0, 3]] == pytest.approx([force, GJ * 4.0 * np.pi], rel=1e-8)


def test_a_motion_starts_from_the_turned_equilibrium():
    """The torsion that the ends hold does not change in a second of damped motion."""
    model = rubber_rod("clamp", {"rx": 2.0 * np.pi}, damping=vr.KelvinVoigt(0.01, 0.01))
    run = model.simulate(1.0)
    assert run.data["reaction"].values[[0, -1], 1, 3] == pytest.approx(2.0 * np.pi * GJ, rel=1e-7)
    assert run.data["elastic"].values[-1] == pytest.approx(0.5 * GJ * (2.0 * np.pi) ** 2, rel=1e-7)


@pytest.mark.parametrize("integrator", ["radau", "generalized_alpha", "midpoint"])
def test_a_sliding_end_turns_thrice_in_time(integrator):
    """A torsion rig with a sliding end, slowly: the torque of statics, and work that is stored or dissipated."""
    damping = vr.KelvinVoigt(0.01, 0.01)
    ramp = {"rx": vr.Ramp(0.0, 2.0, level=6.0 * np.pi)}
    model = rubber_rod(("uy", "uz", "ry", "rz"), ramp, damping=damping)
    step = {} if integrator == "radau" else {"time_step": 0.02}
    run = model.simulate(2.5, initial="reference", integrator=integrator, **step)
    if integrator != "midpoint":  # its reactions swing about the right ones from step to step
        assert run.data["reaction"].values[-1, 1, 3] == pytest.approx(GJ * 6.0 * np.pi, rel=1e-3)
    stored = run.data["elastic"].values[-1]
    assert stored == pytest.approx(0.5 * GJ * (6.0 * np.pi) ** 2, rel=1e-3)
    # the ramp starts with a jump of the velocity, whose work the method of second order takes to O(time_step)
    spent, accuracy = run.data["external"].values[-1], 5e-3 if integrator == "generalized_alpha" else 1e-4
    assert spent == pytest.approx(stored + run.data["viscous"].values[-1], rel=accuracy)


def test_a_mesh_that_cannot_tell_which_way_it_turns_is_refused():
    """Two elements of order 1: a whole turn is half a turn from node to node."""
    with pytest.raises(vr.SolveError, match=r"half a turn.*more elements"):
        rubber_rod("clamp", {"rx": 2.0 * np.pi}, elements=2, order=1).equilibrium()


def test_twist_is_judged_like_bending():
    """Twist strain times the outer radius, 2 pi 5 0.01 = 0.31, is beyond the linear law's 0.1."""
    found = rubber_rod("clamp", {"rx": 10.0 * np.pi}).equilibrium()
    assert any(
        text.startswith("twist times the half width of the section reaches 0.31") for text in found.warnings
    )
    assert not any("twist" in text for text in rubber_rod("clamp", {"rx": 3.0}).equilibrium().warnings)


def half_ring(**motion):
    """Half a ring in the plane x-z between clamps, of which one turns."""
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1.0, 1.0, 1.0], [1.0] * 6)
    model = vr.Model()
    model.add("ring", vr.Rod.arc((0, 0, 0), (0, 0, 1), (1, 0, 0), 1.0, np.pi, section=section))
    model.clamp("ring.start")
    model.clamp("ring.end", motion=motion)
    return model


def test_two_turns_of_a_half_ring_come_undone():
    """Topology (Dirac's belt): two whole turns about any axis can be undone while the ends stay where they are."""
    found = half_ring(ry=4.0 * np.pi).equilibrium()
    assert found.stable
    assert "settling" in found.found_by
    assert found.elastic_energy < 1e-12
    assert np.abs(found.displacement("ring@1.5")).max() < 1e-6


def test_turns_of_a_half_ring_less_two_are_the_same():
    """Independent way: two turns each about y and z, and the same turn of the end less two whole ones by load steps."""
    turn = 4.0 * np.pi
    found = half_ring(ry=turn, rz=turn).equilibrium()
    less = turn - 4.0 * np.pi / np.sqrt(2.0)
    other = half_ring(ry=less, rz=less).equilibrium(search=False)
    assert found.stable
    assert other.stable
    assert found.elastic_energy == pytest.approx(other.elastic_energy, rel=1e-8)
    assert found.position("ring@1.5") == pytest.approx(other.position("ring@1.5"), abs=1e-6)


@pytest.mark.parametrize("analysis", ["equilibrium", "path"])
@pytest.mark.parametrize("turn", [2.9, 3.3, 2.0 * np.pi, 2.0 * np.pi + 0.7, 4.0 * np.pi + 1.0])
def test_motors_of_a_ball_joint_turn_a_rod_by_any_angle(analysis, turn):
    """Closed form: a rod on a ball joint turns rigidly, by the rotation vector that the three motors make."""
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    section = vr.StiffnessSection([1e4] * 3 + [1.0] * 3, [1.0] * 6)
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2))
    model.ball("rod.start", "ground", motion=dict(zip(("rx", "ry", "rz"), turn * axis, strict=True)))
    found = getattr(model, analysis)(
        **({"load_factors": (0.5, 1.0)} if analysis == "path" else {"load_steps": 2})
    )
    for part in (0.5, 1.0):
        at = int(np.flatnonzero(found.load_factor == part)[-1])
        c, s = np.cos(part * turn), np.sin(part * turn)
        end = c * np.eye(3)[0] + s * np.cross(axis, np.eye(3)[0]) + (1.0 - c) * axis[0] * axis
        assert found.data["position"].values[at, -1] == pytest.approx(end, abs=1e-8)
        assert found.data["joint_value"].values[at, -3:] == pytest.approx(part * turn * axis, abs=1e-9)
    assert found.elastic_energy < 1e-12


def test_motors_of_a_ball_joint_twist_a_rod_by_whole_turns():
    """Closed form: the torque ``GJ angle/L``, and the energy."""
    section = vr.StiffnessSection([1e6] * 3 + [100.0, 100.0, 0.8], [1.0] * 6)
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=6))
    model.clamp("rod.start")
    model.ball("rod.end", "ground", motion={"rx": 9.0, "ry": 0.0, "rz": 0.0})
    found = model.equilibrium()
    assert found.elastic_energy == pytest.approx(0.5 * 0.8 * 9.0**2, rel=1e-9)
    assert found.data["joint_force"].values[-1, -3:] == pytest.approx([7.2, 0.0, 0.0], abs=1e-8)


@pytest.mark.parametrize("integrator", ["radau", "midpoint", "generalized_alpha"])
def test_motors_of_a_ball_joint_turn_a_moving_rod_by_any_angle(integrator):
    """Closed forms: the held end is turned by the rotation vector that the motors make, through two whole turns.

    The torque of the motors turns what is nearly a rigid body: about the fixed axis of their rotation vector it is the
    moment of inertia times the angular acceleration, and the work that it does is the kinetic energy.
    """
    axis, section = np.array([2.0, 1.0, 2.0]) / 3.0, vr.StiffnessSection([1e7] * 3 + [1e5] * 3, [1.0] * 6)
    model, turn, duration = vr.Model(), 4.5 * np.pi, 2.0
    model.add("rod", vr.Rod.straight((-0.5, 0, 0), (0.5, 0, 0), section=section, elements=2))

    def motor(part):
        c = part * turn / duration**2
        return vr.FunctionOfTime(lambda t: c * t**2, lambda t: 2.0 * c * t, lambda t: 2.0 * c)

    motors = {motion: motor(part) for motion, part in zip(("rx", "ry", "rz"), axis, strict=True)}
    model.ball("rod@0.5", "ground", motion=motors)
    steps = {} if integrator == "radau" else {"time_step": 0.005, "errors": False}
    run = model.simulate(duration, integrator=integrator, initial="reference", output_interval=0.03, **steps)
    angle = turn * (run.time / duration) ** 2
    end = 0.5 * (
        np.cos(angle)[:, None] * np.eye(3)[0]
        + np.sin(angle)[:, None] * np.cross(axis, np.eye(3)[0])
        + (1.0 - np.cos(angle))[:, None] * axis[0] * axis
    )
    assert run.data["position"].values[:, -1] == pytest.approx(end, abs=1e-3)
    assert run.data["joint_value"].values[:, -3:] == pytest.approx(angle[:, None] * axis, abs=1e-5)
    rate = 2.0 * turn * run.time / duration**2
    inertia = (1.0 + 1.0 / 12.0) - axis[0] ** 2 / 12.0
    kinetic = 0.5 * inertia * rate**2
    assert run.data["kinetic"].values == pytest.approx(kinetic, abs=2e-3 * kinetic[-1])
    assert run.data["external"].values[-1] == pytest.approx(kinetic[-1], rel=2e-3)


def test_motors_of_a_ball_joint_twist_a_moving_rod():
    """Closed form: ``GJ angle/L`` once the twist has come to rest, and its energy."""
    section = vr.StiffnessSection(
        [1e6] * 3 + [100.0, 100.0, 0.8], [1.0] * 3 + [1e-3] * 3, damping=[0.0] * 5 + [0.05]
    )
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3))
    model.clamp("rod.start")
    model.ball("rod.end", "ground", motion={"rx": vr.Ramp(0.0, 1.0, 9.0), "ry": 0.0, "rz": 0.0})
    run = model.simulate(4.0, initial="reference")
    assert run.data["elastic"].values[-1] == pytest.approx(0.5 * 0.8 * 9.0**2, rel=1e-4)
    assert run.data["joint_force"].values[-1, -3:] == pytest.approx([7.2, 0.0, 0.0], abs=1e-3)
