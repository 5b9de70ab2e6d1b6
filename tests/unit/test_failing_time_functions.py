"""Functions of time of the user that fail: one message with the load, the time and the exception."""

from __future__ import annotations

import pytest

import viscorod as vr


def beam(time, **given):
    """A soft cantilever, whose tip is loaded by a function of time."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=1))
    model.clamp("beam.start")
    model.force("beam.end", (0, 1e-3, 0), time=time, **given)
    return model


def test_a_function_that_fails_somewhere_is_refused_before_the_run():
    """It says where: the samples of the run are looked at first."""
    said = r"force at beam\.end.*failed at t = 0\.5 s: ZeroDivisionError: (float )?division by zero"
    with pytest.raises(vr.InputError, match=said):
        beam(lambda t: 1.0 / (t - 0.5)).simulate(1.0, initial="reference")
    with pytest.raises(vr.InputError, match=r"force at beam\.end.*at t = 0 s: ZeroDivisionError"):
        beam(lambda t: 1.0 / t).equilibrium()


def test_what_is_not_used_of_a_function_may_fail():
    """The load ends before."""
    run = beam(lambda t: 1.0 / (0.5 - t) if t != 0.5 else {}[t], until=0.01).simulate(
        0.02, initial="reference"
    )
    assert run.outcome == "completed"


def test_results_are_kept_where_a_function_fails_on_the_way():
    """It works when it is looked at first, and no more later."""
    reached = []

    def time(t):
        if reached and reached[-1] > 0.01:
            raise RuntimeError("the sensor is gone")
        return 1.0

    with pytest.raises(vr.SolveError, match=r"force at beam\.end.*RuntimeError: the sensor is gone") as error:
        beam(time).simulate(0.05, initial="reference", progress=lambda t, h: reached.append(t))
    assert 0.01 < error.value.run.time[-1] < 0.05
