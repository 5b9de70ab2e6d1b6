"""The integrators through ``simulate``: exact energy of the midpoint rule, what runs report, what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat


def swing(damping=None):
    """A soft cantilever that is thrown far round."""
    stiffness = np.diag([300.0, 300.0, 500.0, 0.5, 0.7, 0.4])
    stiffness[2, 3] = stiffness[3, 2] = 2.0
    section = vr.StiffnessSection(
        stiffness, [1, 1, 1, 1e-2, 1e-2, 2e-2], None if damping is None else damping * stiffness
    )
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=3, order=3))
    return model


def thrown():
    """Undamped, from initial velocities that bend it strongly."""
    model = swing()
    model.clamp("rod.start")
    model.velocity("rod", field=lambda s: ((0.0, 3.0 * s * s, 2.0 * s), (0.0, 0.0, 0.0)))
    return model


def driven():
    """Damped, with a driven clamp, gravity, a following force and couple, a moving force."""
    model = swing(0.01)
    model.clamp("rod.start", motion={"rz": vr.Sine(0.7, amplitude=0.8), "ux": vr.Sine(0.4, amplitude=0.1)})
    model.gravity((0, 0, -2.0))
    model.force("rod.end", (0.3, 0.1, 0), following=True, time=vr.Sine(1.0))
    model.moment("rod.end", (0.02, 0.0, 0.05), following=True)
    model.moving_force("rod", (0, 0.2, 0), speed=1.5)
    return model


def propped():
    """Damped, a driven clamp and a far end that is held and driven in part."""
    model = swing(0.01)
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0, amplitude=0.1)})
    model.support("rod.end", ("uz",), motion={"ux": vr.Sine(0.8, amplitude=0.05)})
    model.gravity((0, -3.0, 0.0))
    return model


@pytest.mark.parametrize("step", [0.04, 0.01])
@pytest.mark.parametrize("make", [thrown, driven])
def test_midpoint_energy_is_exact(make, step):
    """Conservation law: what the account lacks is below 1e-8 of what moved, at any step."""
    run = make().simulate(2.0, integrator="midpoint", time_step=step, initial="reference", errors=False)
    energy = run.energy
    assert energy.moved > 0.05
    assert np.abs(energy.numerical).max() < 1e-8 * energy.moved


def test_midpoint_energy_with_partly_held_places():
    """Conservation law: exact but for the few steps in which the iteration at the driven slide ends early."""
    energy = (
        propped()
        .simulate(2.0, integrator="midpoint", time_step=0.01, initial="reference", errors=False)
        .energy
    )
    assert np.abs(energy.numerical).max() < 1e-5 * energy.moved


def test_a_large_motion_was_tested():
    """The tip of the thrown rod turns by more than a right angle."""
    run = thrown().simulate(2.0, tolerance=1e-4, initial="reference")
    q = run.data["rotation"].values[:, -1]
    assert np.abs(q @ q[0]).min() < np.cos(np.pi / 4)


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"tolerance": 1e-3},
        {"integrator": "generalized_alpha", "time_step": 0.01},
        {"integrator": "generalized_alpha", "tolerance": 1e-2},
        {"integrator": "midpoint", "time_step": 0.01},
    ],
)
def test_effort_is_reported(given):
    """Counters of every run, and where the smallest step was and why."""
    run = driven().simulate(0.5, initial="reference", **given)
    a = run.data.attrs
    assert a["steps"] > 0
    assert a["rejected"] >= 0
    assert a["evaluations"] >= a["iterations"] >= a["steps"]
    assert 1 <= a["jacobians"]
    assert 1 <= a["factorisations"]
    smallest = run.data["step_size"].values[1:].min()
    assert a["smallest_step"] == pytest.approx(smallest)
    assert 0.0 <= a["smallest_step_at"] < 0.5
    assert a["smallest_step_why"]
    report = run.report()
    assert f"limited by {a['smallest_step_why']}" in flat(report)
    assert f"{a['steps']} steps" in flat(report)
    if a["integrator"] != "generalized_alpha":
        assert a["factorisations"] < a["iterations"]  # factors serve several iterations
    if "tolerance" in a:
        assert f"tolerance {a['tolerance']:g}" in flat(report)
        assert a["smallest_step_why"] != "the given step"
    else:
        assert a["smallest_step_why"] == "the given step"


@pytest.mark.filterwarnings("ignore:the numerical remainder")  # a tolerance of 0.1 on purpose
def test_tolerance_of_radau_unless_given():
    """The default, and the largest step of a run and of a harmonic motion."""
    a = driven().simulate(0.5, initial="reference").data.attrs
    assert (a["integrator"], a["tolerance"]) == ("radau", 1e-4)
    assert a["largest_step"] == pytest.approx(0.05)
    a = driven().simulate(20.0, tolerance=0.1, initial="reference").data.attrs
    assert a["largest_step"] == pytest.approx(1.0 / 6)  # period of the following force


def test_time_step_is_the_largest_where_steps_follow_the_error():
    run = driven().simulate(0.5, time_step=0.004, tolerance=1e-2, initial="reference")
    assert run.data["step_size"].values.max() <= 0.004 * (1 + 1e-12)


@pytest.mark.parametrize("integrator", ["radau", "generalized_alpha", "midpoint"])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_states_at_equal_times(integrator):
    """``output_interval``: states at its multiples and at the end, whatever the steps are."""
    given = {} if integrator == "radau" else {"time_step": 0.013}
    run = driven().simulate(0.5, integrator=integrator, output_interval=0.03, initial="reference", **given)
    assert run.time == pytest.approx([*(0.03 * np.arange(17)), 0.5], abs=1e-12)


@pytest.mark.parametrize(
    ("given", "parts"),
    [
        ({"integrator": "midpoint", "tolerance": 1e-4}, ("tolerance", "0.0001", "time_step", "radau")),
        ({"spectral_radius": 0.5}, ("spectral_radius", "0.5", "leave it out", "generalized_alpha")),
        ({"integrator": "midpoint", "spectral_radius": 0.5}, ("spectral_radius", "0.5", "leave it out")),
        ({"stages": 4}, ("stages", "4", "give 3, 5 or 7")),
        ({"stages": 5, "integrator": "midpoint"}, ("stages", "5", "leave it out", "radau")),
        ({"tolerance": 0.5}, ("tolerance", "0.5", "1e-10", "0.1")),
        ({"tolerance": 1e-12}, ("tolerance", "1e-12", "1e-10", "0.1")),
        ({"tolerance": -1e-3}, ("tolerance", "-0.001", "give")),
        ({"integrator": "euler"}, ("integrator", "euler", "radau", "generalized_alpha", "midpoint")),
        ({"time_step": 2.0}, ("time_step", "2", "at most the duration")),
    ],
)
def test_wrong_settings_are_refused(given, parts):
    """The message names key, value, what is allowed and what to do."""
    with pytest.raises(vr.InputError) as error:
        thrown().simulate(1.0, **given)
    for part in parts:
        assert part in str(error.value)
