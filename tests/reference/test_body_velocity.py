"""Velocities held along the axes of the moving section (AWP's boundary conditions) in both formulations."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

from .cases import methods, stiff

METHODS = methods(1e-8, 0.002, without={"generalized_alpha": "it refuses such supports"})


def hinged(hold):
    """AWP V.B for 0.4 s."""
    stiffness = np.diag([5e3, 5e3, 1e5, 1.0, 2.0, 1.0])
    section = vr.StiffnessSection(stiffness, np.diag([1, 1, 1, 2e-4, 2e-4, 4e-4]), 1e-3 * stiffness)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=5))
    hold(model)
    model.moment("beam.end", (0.5, 0.5, 0), following=True, time=vr.Sine(2.0), until=0.5)
    return model


@METHODS
def test_three_zero_velocities_are_a_ball_joint(method):
    """Independent formulation: positions held by a pin. The same motion, and the same reactions."""
    pinned = hinged(lambda model: model.pin("beam.start"))
    held = hinged(lambda model: model.body_velocity("beam.start", ["v1", "v2", "v3"]))
    runs = [
        model.simulate(0.4, initial="reference", output_interval=0.02, **method).data
        for model in (pinned, held)
    ]
    a, b = (run["position"].values for run in runs)
    assert np.abs(a - b).max() < (1e-4 if "time_step" in method else 1e-6)
    forces = [run["reaction"].values[1:, 0, :3] for run in runs]
    assert np.abs(forces[0] - forces[1]).max() < 2e-2 * np.abs(forces[0]).max()
    assert np.abs(runs[1]["position"].values[:, 0]).max() < 1e-8


@METHODS
def test_prescribed_spin_about_the_own_axis(method):
    """Closed form: a straight rod whose end turns about d3 at the rate 20 t/0.5 up to 20 rad/s: angle 5 + 20 (t - 0.5).

    The driven end works what the rod gains: rho J Omega^2 L/2 and the elastic remainder.
    """
    model = vr.Model()
    section = stiff(1e3, 1e3, 1.0, 50.0, damping=0.02)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=1, order=4))
    speed = vr.TimeTable([0.0, 0.5], [0.0, 20.0], "linear")
    model.body_velocity("rod.start", ["v1", "v2", "v3", "w1", "w2"], velocity={"w3": speed})
    run = model.simulate(2.0, initial="reference", **method)
    spin = run.data["angular_velocity"].values[-1]
    assert spin[:, 2] == pytest.approx(np.full(len(spin), 20.0), rel=1e-5)
    q = run.data["rotation"].values[-1, 0]
    q0 = run.data["reference_rotation"].values[0]
    turned = 2.0 * np.arccos(np.clip(abs(q @ q0), 0.0, 1.0))
    angle = (5.0 + 20.0 * 1.5) % (2 * np.pi)
    assert turned == pytest.approx(min(angle, 2 * np.pi - angle), abs=1e-4)
    assert float(run.data["kinetic"][-1]) == pytest.approx(0.5 * 2e-3 * 400.0, rel=1e-5)
    assert run.energy.numerical_fraction < 1e-3


@METHODS
def test_a_skate_moves_along_its_own_axis_only(method):
    """Constraint and conservation law: v1 = v2 = 0 at an end, which wanders; ideal supports do no work."""
    model = vr.Model()
    section = stiff(1e3, 1e3, 5.0, 5.0, rotary=(1e-2, 1e-2, 2e-2), damping=0.005)
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=4))
    model.body_velocity("rod.start", ["v1", "v2"])
    model.velocity("rod", angular=(0.0, 0.3, 1.0), linear=(0.5, 0.0, 0.0))
    run = model.simulate(3.0, initial="reference", **method)
    start = run.data["rotation"].values[:, 0]
    velocity = run.data["velocity"].values[:, 0]
    w, x, y, z = start.T
    across = [
        np.column_stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]),
        np.column_stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)]),
    ]
    for axis in across:
        assert np.abs(np.sum(axis * velocity, axis=1)).max() < (2e-3 if "time_step" in method else 1e-5)
    assert np.ptp(run.data["position"].values[:, 0, 0]) > 0.2
    assert float(np.abs(run.data["external"]).max()) < 1e-9
    assert float(np.abs(run.data["numerical"]).max()) < 1e-6 * float(run.data["kinetic"][0])


def test_generalised_alpha_refuses():
    """The message names the support and what to take instead."""
    model = hinged(lambda model: model.body_velocity("beam.start", ["v1", "v2", "v3"]))
    with pytest.raises(vr.InputError, match=r"body_velocity at beam\.start.*'radau' or 'midpoint'"):
        model.simulate(0.1, initial="reference", integrator="generalized_alpha")
