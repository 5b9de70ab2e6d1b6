"""Loads given as samples cost what they move, and nothing of them is stepped over."""

from __future__ import annotations

import math

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.problem import discretise

STEEL = vr.Material(2e11, 0.3, 7850.0, damping=vr.MeasuredDamping(ratio=0.02))


def bar(**support):
    """A damped steel bar of 1 m, clamped at its start; 16 Hz."""
    model = vr.Model()
    section = vr.Rectangle(0.02, 0.02)
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=STEEL, elements=2))
    model.clamp("bar.start", **support)
    return model


def tip(run, times):
    """Return how far the end is along y [m]."""
    return run.probe(["bar.end"], times)["position"].values.reshape(len(times), 3)[:, 1]


def noise(rows, duration, highest):
    """Return times and values of a record with content up to a frequency [Hz]."""
    random = np.random.default_rng(16)
    frequencies = np.fft.rfftfreq(rows, duration / rows)
    phases = np.exp(2j * math.pi * random.random(len(frequencies)))
    values = np.fft.irfft(np.where(frequencies < highest, phases, 0.0), rows)
    return np.arange(rows) * duration / rows, values / np.abs(values).max()


@pytest.mark.parametrize(
    ("dynamics", "highest", "duration"),
    [("nonlinear", 25.0, 0.4), ("nonlinear", 400.0, 0.4), ("linear", 25.0, 0.1)],
)
def test_the_rows_of_a_record_are_no_corners(monkeypatch, dynamics, highest, duration):
    """Independent run: a step for every row, at a tenth of the tolerance. What is far above the bar adds few."""
    model = bar()
    model.gravity((0, 3.0, 0), time=vr.TimeTable(*noise(int(4000 * duration), duration, highest)))
    linear = {"dynamics": "linear", "formulation": "intrinsic", "damping": "linearised"}
    given = {} if dynamics == "nonlinear" else linear
    run = model.simulate(duration, initial="reference", **given)
    monkeypatch.setattr(discretise, "MANY_ROWS", 10_000)
    finer = 0.1 * run.data.attrs["tolerance"]
    every = model.simulate(duration, initial="reference", tolerance=finer, **given)
    times = np.linspace(0.0, duration, 801)
    exact = tip(every, times)
    assert run.data.attrs["steps"] < every.data.attrs["steps"] / (8 if highest < 100.0 else 3)
    assert np.abs(tip(run, times) - exact).max() < 0.01 * np.ptp(exact) / 2.0


def test_equal_steps_keep_the_impulse_of_what_they_skip():
    """Momentum: midpoint steps of 21 ms over a shock of 1 ms in a record give a free bar its velocity, exactly."""
    model = vr.Model()
    model.add(
        "bar",
        vr.Rod.straight(
            (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=vr.Material(2e11, 0.3, 7850.0)
        ),
    )
    times = np.concatenate([[0.0], np.linspace(0.1, 0.101, 201), [0.2]])
    heights = np.where((times > 0.1) & (times < 0.101), np.sin(math.pi * (times - 0.1) / 1e-3), 0.0)
    model.gravity((0, 100.0, 0), time=vr.TimeTable(times, heights))
    run = model.simulate(0.2, initial="reference", integrator="midpoint", time_step=0.19 / 9.0)
    assert float(run.history("bar.end", "velocity")[-1, 1]) == pytest.approx(
        100.0 * np.trapezoid(heights, times), rel=1e-9
    )


def shock(t):
    """A half sine of 2 ms at 4 s."""
    return math.sin(math.pi * (t - 4.0) / 2e-3) if 4.0 < t < 4.002 else 0.0


def jerk(order):
    """Return a smooth displacement of 1 mm within 20 ms at 4 s, or a derivative of it."""

    def function(t):
        x = 2.0 * math.pi * min(max((t - 4.0) / 0.02, 0.0), 1.0)
        waves = (x - math.sin(x)) / (2.0 * math.pi), (1.0 - math.cos(x)) / 0.02
        return 1e-3 * (*waves, 2.0 * math.pi * math.sin(x) / 0.02**2)[order]

    return function


@pytest.mark.parametrize("what", ["force", "support"])
def test_a_short_pulse_in_a_function_is_not_stepped_over(what):
    """Independent run: the same pulse with its times named, at a tenth of the tolerance."""
    runs, tolerance = [], None
    for named in (False, True):
        if what == "force":
            model = bar()
            breaks = (4.0, 4.002) if named else ()
            model.force("bar.end", (0, 20.0, 0), time=vr.FunctionOfTime(shock, breakpoints=breaks))
        else:
            breaks = (4.0, 4.02) if named else ()
            model = bar(motion={"uy": vr.FunctionOfTime(jerk(0), jerk(1), jerk(2), breakpoints=breaks)})
        run = model.simulate(4.2, tolerance=tolerance)
        tolerance = 0.1 * run.data.attrs["tolerance"]
        runs.append(run)
    times = np.linspace(3.9, 4.2, 601)
    exact = tip(runs[1], times)
    assert np.ptp(exact) > 1e-4
    assert np.abs(tip(runs[0], times) - exact).max() < 0.01 * np.ptp(exact) / 2.0


def test_a_base_record_joined_by_straight_lines_is_warned_of():
    """Its velocity jumps at every row. As a spline it is the smooth motion that was sampled: a sine, itself exact."""
    times = np.linspace(0.0, 0.12, 121)
    values = 1e-4 * (1.0 - np.cos(2.0 * math.pi * 12.0 * times))
    with pytest.warns(vr.AccuracyWarning, match="its velocity jumps at every row"):
        bar(motion={"uy": vr.TimeTable(times[:101], values[:101])}).simulate(0.01)
    spline = bar(motion={"uy": vr.TimeTable(times, values, "cubic")}).simulate(0.11)
    wave = vr.Sine(12.0, -1e-4, phase=math.pi / 2.0, offset=1e-4)
    exact = tip(bar(motion={"uy": wave}).simulate(0.11), at := np.linspace(0.0, 0.11, 401))
    assert np.abs(tip(spline, at) - exact).max() < 0.01 * np.ptp(exact) / 2.0
    assert spline.data.attrs["steps"] < 60
