"""Equal steps that the program chooses, of motions that are mostly those of rigid parts."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import viscorod as vr
from viscorod.analyses.motion_stepping import many_steps
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.step_control import ErrorControl, FixedSteps


def falling(young: float) -> vr.Model:
    """A bar on a ball joint, let go level."""
    material = vr.Material(young, poissons_ratio=0.3, density=7850.0)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model.add("bar", rod)
    model.ball("bar.start", "ground")
    model.gravity((0, 0, -9.81))
    return model


def level(model: vr.Model, **given) -> tuple[vr.Run, np.ndarray]:
    """A run of 0.9 s, in which the bar falls and rises, and places of the far end at thirty times [m]."""
    run = model.simulate(0.9, initial="reference", output_interval=0.03, **given)
    return run, run.history("bar.end").values


@pytest.mark.parametrize("integrator", ["generalized_alpha", "midpoint"])
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of section forces, carried by vibrations
def test_equal_steps_of_a_falling_bar_follow_the_fall(integrator):
    """Radau at 1e-7, on the same mesh. Vibrations of 2e-4 of the length asked for 54 000 steps in 1.5 s and more."""
    model = falling(2e11)
    run, places = level(model, integrator=integrator)
    assert run.data.attrs["steps"] < 1800
    _, exact = level(model, tolerance=1e-7)
    assert np.abs(places - exact).max() < 3e-4


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_equal_steps_of_a_soft_falling_bar_follow_its_vibrations():
    """Radau at 1e-7: bending of some hundredths of the length is part of the motion."""
    model = falling(2e9)
    run, places = level(model, integrator="generalized_alpha")
    assert run.data.attrs["steps"] > 1200  # the fall alone takes 917 in 1.5 s
    _, exact = level(model, tolerance=1e-7)
    assert np.abs(places - exact).max() < 3e-4


def test_very_many_equal_steps_are_told_beforehand():
    settings = SimulateSettings(duration=3.0, integrator="midpoint")
    told = many_steps(FixedSteps(1e-5), 3.0, settings)
    assert told.startswith("the midpoint rule takes 300000 equal steps of 10 µs")
    assert "integrator = 'radau'" in told
    assert many_steps(FixedSteps(1e-3), 3.0, settings) == ""
    assert many_steps(FixedSteps(1e-5), 3.0, SimulateSettings(duration=3.0, time_step=1e-5)) == ""
    assert many_steps(ErrorControl(3, 1e-5, 3.0), 3.0, settings) == ""


def test_very_many_periods_of_a_load_are_told_beforehand():
    """A gigahertz where a kilohertz was meant: six steps of each of a million periods, before the first one."""
    model = falling(2e11)
    model.force("bar.end", (0.0, 1.0, 0.0), time=vr.Sine(1e9))
    said = "of 1 GHz asks for at least 6000000 steps, 6 of each period"
    with pytest.warns(vr.AccuracyWarning, match=said), pytest.raises(vr.SolveError) as stopped:
        model.simulate(1e-3, stop=lambda: "seen enough")
    assert any(said in text for text in stopped.value.run.warnings)
    settings = SimulateSettings(duration=1.0)
    assert many_steps(ErrorControl(3, 1e-4, 1.0), 1.0, settings, (1e-3,)) == ""


@pytest.mark.parametrize(
    ("time", "duration", "told"),
    [(None, 60.0, True), (None, 0.5, True), (None, 0.05, False), (vr.Ramp(0.0, 0.1), 60.0, False)],
)
def test_a_load_that_begins_at_once_and_rings_for_very_long_is_told(time, duration, told):
    """A stiff plastic bar creeps for a minute, and rings along its line at 1/4 sqrt(E/rho)/L with the storage modulus.

    Two branches of a tenth of the modulus each are stiff at that frequency: E = 2.4 GPa.
    """
    law = vr.Prony(extension_moduli=[2e8, 2e8], extension_times=[10.0, 1.0], constant="poissons_ratio")
    plastic = vr.Material(2e9, 0.4, 1100.0, damping=law)
    model = vr.Model()
    bar = vr.Rod.straight((0, 0, 0), (0.2, 0, 0), section=vr.Circle(0.003), material=plastic)
    model.add("bar", bar)
    model.clamp("bar.start")
    model.force("bar.end", (100.0, 0, 0), time=time)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        with pytest.raises(vr.SolveError, match="enough"):
            model.simulate(duration, initial="reference", stop=lambda: "enough")
    texts = [str(one.message) for one in caught if "ring" in str(one.message)]
    assert bool(texts) == told
    if told:
        frequency = float(re.search(r"ring at ([\d.]+) Hz", texts[0])[1])
        assert frequency == pytest.approx(np.sqrt(2.4e9 / 1100.0) / 0.8, rel=5e-3)
