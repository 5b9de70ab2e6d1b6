"""Derivatives by the times at which loads jump, begin and end: steps move with these."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr

WEIGHT = 1100.0 * 0.02 * 0.01
"""Mass per length [kg/m]."""
FORCE = 0.3
"""Per length [N/m]."""


def flying(time, **given):
    """A free rod that a uniform force moves along z, without any strain."""
    model = vr.Model()
    rubber = vr.Material(2.5e6, 0.45, 1100.0, damping=vr.KelvinVoigt(0.004, 0.004))
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.02, 0.01), material=rubber, elements=1
    )
    model.add("rod", rod)
    model.distributed_force("rod", (0, 0, FORCE), time=time, **given)
    return model


@pytest.mark.parametrize("integrator", ["radau", "generalized_alpha"])
def test_a_push_that_lasts_longer_goes_farther(integrator):
    """Closed form: after T it moves by F T (t - T/2)/m, which changes by F (t - T)/m, its velocity by F/m."""
    model = flying(None, until=0.03)
    key, T = "loads[0].until", 0.03
    settings = {"time_step": 0.005} if integrator == "generalized_alpha" else {}
    run = model.simulate(
        0.1, initial="reference", integrator=integrator, output_interval=0.01, derivatives=[key], **settings
    )
    by, t = run.derivatives[key], run.time
    late = t > T + 1e-9
    moved, speed = (by.data[name].values[:, :, 2] for name in ("position", "velocity"))
    wanted = np.where(late, FORCE * (t - T) / WEIGHT, 0.0)
    if integrator == "radau":
        apart = (
            np.abs(t - T) > 1e-9
        )  # there a velocity has one derivative by a later T, and one by an earlier
        every = np.tile(wanted, (moved.shape[1], 1)).T
        np.testing.assert_allclose(moved[apart], every[apart], atol=1e-6 * wanted.max())
        np.testing.assert_allclose(speed[late], FORCE / WEIGHT, rtol=1e-6)
    else:  # of second order in its steps
        np.testing.assert_allclose(moved, np.tile(wanted, (moved.shape[1], 1)).T, atol=0.05 * wanted.max())


@pytest.mark.parametrize("end", ["start", "end"])
def test_a_ramp_that_begins_or_ends_later(end):
    """Closed form: x = F/m ((t - T)^2/2 + D (t - T)/2 + D^2/6) after a ramp from T - D to T, D = T - S."""
    S, T = 0.01, 0.04
    model = flying(vr.Ramp(S, T))
    key = f"loads[0].time.{end}"
    run = model.simulate(0.1, initial="reference", output_interval=0.01, derivatives=[key])
    t = run.time[run.time > T + 1e-9]
    D, after = T - S, t - T
    by_length = after / 2.0 + D / 3.0  # at the same T
    wanted = -by_length if end == "start" else -after - D / 2.0 + by_length
    found = run.derivatives[key].data["position"].values[run.time > T + 1e-9, 0, 2]
    np.testing.assert_allclose(
        found, FORCE / WEIGHT * wanted, atol=1e-6 * FORCE / WEIGHT * np.abs(wanted).max()
    )


def test_the_adjoint_leaves_instants_to_neighbours():
    """What a stage of a step sees jumps where a corner passes it: the gradient comes from neighbours then."""
    model, key = flying(None, until=0.03), "loads[0].until"

    def height(run):
        weights = np.zeros(run.data["position"].shape)
        weights[-1, 0, 2] = 1.0
        return float(run.data["position"].values[-1, 0, 2]), {"position": weights}

    f = model.value_and_gradient(
        [key], height, adjoint=True, duration=0.1, initial="reference", output_interval=0.05
    )
    _, gradient = f(f.values)
    assert gradient == pytest.approx(FORCE * 0.07 / WEIGHT, rel=1e-6)
    assert "jumps or corners" in f.way


def test_what_passes_when_does_not_matter_to_vibrations():
    """A load that travels comes to the end of a longer beam later: its modes have the derivative without it."""

    def beam():
        model = vr.Model()
        rubber = vr.Material(2.5e6, 0.45, 1100.0, damping=vr.KelvinVoigt(0.004, 0.004))
        rod = vr.Rod.straight(
            (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.02, 0.01), material=rubber, elements=2
        )
        model.add("rod", rod)
        model.clamp("rod.start")
        return model

    model, key = beam(), "rods.rod.end[0]"
    model.moving_force("rod", (0, 0, -0.01), speed=0.5, start=0.05)
    found = model.modes(2, about="reference", derivatives=[key]).derivatives[key].frequencies
    wanted = beam().modes(2, about="reference", derivatives=[key]).derivatives[key].frequencies
    np.testing.assert_allclose(found, wanted, rtol=1e-9)


def test_an_instant_may_not_leave_the_motion_or_part_from_another():
    model = flying(None, until=0.03)
    with pytest.raises(vr.InputError, match="out of the motion"):
        model.simulate(0.03, initial="reference", derivatives=["loads[0].until"])
    model.distributed_force("rod", (0, 0.1, 0), until=0.03)
    with pytest.raises(vr.InputError, match="at one time"):
        model.simulate(0.1, initial="reference", derivatives=["loads[0].until"])
