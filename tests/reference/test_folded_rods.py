"""Whips that are swung: elements that fold, because the program chose too few, are halved."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.call_options import CallOptions
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.folded_rods import on_unfolded
from viscorod.analyses.motion import motion
from viscorod.errors import SolveError
from viscorod.solve.problem.division import Division, divisions_of
from viscorod.solve.settings.motion import SimulateSettings


def whip(**mesh: Any) -> vr.Model:
    """Return a tapered whip whose handle turns by half a turn."""
    damping = vr.KelvinVoigt(1e-4, 1e-4)
    rubber = vr.Material(5e7, 0.45, 1100.0, damping=damping)
    model = vr.Model()
    section = vr.Taper(vr.Circle(5e-3), vr.Circle(5e-4))
    model.add("whip", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=rubber, **mesh))
    model.clamp("whip.start", motion={"ry": vr.Ramp(0.0, 0.157, np.pi)})
    return model


def alone(discrete: DiscreteModel, settings: SimulateSettings) -> vr.Run:
    """Compute the motion of the whip on this mesh, without the runs that tell its errors."""
    count = len(divisions_of(discrete.problem)["whip"].ends) - 1
    given = whip(elements=count, order=5)
    return motion(DiscreteModel.of(given, settings, replace(discrete.options, errors=False)), settings)


def test_the_mesh_of_a_whip_follows_its_loop():
    """On 4 elements it folds; on those that it gets the tip is where it is on 40 elements of another order."""
    settings = SimulateSettings(duration=0.142, initial="reference")
    coarse = DiscreteModel.of(whip(), settings, CallOptions())
    coarse = coarse.on_mesh({"whip": Division(5, np.linspace(0.0, 1.0, 5))})
    run, used = on_unfolded(alone, coarse, settings)
    assert len(used.problem.positions) > len(coarse.problem.positions)
    fine = whip(elements=40, order=3).simulate(0.142, initial="reference", errors=False)
    off = run.history("whip.end").values[-1] - fine.history("whip.end").values[-1]
    assert np.abs(off).max() < 0.01  # of 1 m; folded elements leave it anywhere
    assert run.data.strain.values[..., 2].min() > -0.01


def test_rods_that_loads_press_together_keep_their_mesh():
    """What folds on every mesh is computed as it was: a block of foam under three quarters of EA."""
    model = vr.Model()
    foam = vr.Material(1e4, 0.3, 100.0, damping=vr.KelvinVoigt(0.1, 0.1))
    model.add("block", vr.Rod.straight((0, 0, 0), (0, 0, 0.1), section=vr.Circle(0.05), material=foam))
    model.clamp("block.start")
    area = np.pi * 0.05**2
    model.force("block.end", (0, 0, -0.75 * 1e4 * area), time=vr.SmoothRamp(0.0, 1.0))
    settings = SimulateSettings(duration=3.0, initial="reference")
    coarse = DiscreteModel.of(model, settings, CallOptions(errors=False))
    run, used = on_unfolded(motion, coarse, settings)
    assert len(used.problem.positions) == len(coarse.problem.positions)
    assert run.history("block.end").values[-1, 2] == pytest.approx(
        0.025, rel=1e-3
    )  # F = EA times the shortening


def test_other_failures_are_told():
    def fails(_: DiscreteModel, __: SimulateSettings) -> vr.Run:
        raise SolveError("it failed")

    settings = SimulateSettings(duration=1.0)
    with pytest.raises(SolveError, match="it failed"):
        on_unfolded(fails, DiscreteModel.of(whip(), settings, CallOptions()), settings)
