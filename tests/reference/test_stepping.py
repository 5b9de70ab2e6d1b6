"""Another program moves a model step by step: equal to one run, convergent coupling, exact return."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat

from .cases import cantilever, slope


def beam():
    material = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    return cantilever(vr.Rectangle(0.01, 0.01), 0.3, elements=2, order=4, material=material)


def test_steps_without_forces_are_one_run():
    """Identity: a released rod, whatever the steps; the error is that of the tolerance."""
    model = beam()
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    whole = model.simulate(1.0, tolerance=1e-7)
    system = model.co_simulation(tolerance=1e-7)
    for _ in range(25):
        system.step(0.04)
    assert system.time == pytest.approx(1.0, rel=1e-12)
    end = whole.data.position[-1, -1].values
    assert system.position("beam.end") == pytest.approx(end, abs=1e-6)
    assert system.velocity("beam.end") == pytest.approx(whole.data.velocity[-1, -1].values, abs=1e-5)
    run = system.run()
    assert run.energy.numerical_fraction < 1e-4
    assert run.time[-1] == system.time
    assert "1 s simulated" in flat(run.report())
    assert any("not estimated in a co-simulation" in text for text in run.warnings)
    assert not any("not estimated" in text for text in whole.warnings)


def test_forces_at_a_port_do_work():
    """Closed form: a free rod under a constant force at its middle, momentum F t and energy F^2 t^2/2m."""
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Circle(0.01), material=vr.Material(1e9, 0.3, 1000.0)
    )
    model.add("rod", rod)
    mass = 1000.0 * np.pi * 1e-4 * 0.3
    system = model.co_simulation(["rod@0.15"], initial="reference")
    system.apply("rod@0.15", force=(0, 0, 2.0))
    for _ in range(10):
        system.step(0.01)
    momentum = system.run().data.linear_momentum[-1].values
    assert momentum == pytest.approx([0, 0, 0.2], abs=1e-5)
    assert system.run().data.external[-1] == pytest.approx(0.2**2 / (2 * mass), rel=1e-3)  # it bends a little
    system.apply("rod@0.15")
    system.step(0.05)
    assert system.run().data.linear_momentum[-1].values == pytest.approx([0, 0, 0.2], abs=1e-5)


def spring(system, stiffness):
    return -stiffness * (system.position("beam.end") - np.array([0.3, 0, 0]))


def test_coupling_converges_to_the_spring_it_stands_for():
    """Equivalence: a spring in the other program, explicit (order 1) and repeated until it agrees (order 2)."""
    model = beam()
    model.force("beam.end", (0, 0.02, 0), until=0.0)
    stiffness, duration = 0.2, 0.2

    def coupled(step, repeats):
        system = model.co_simulation(["beam.end"], tolerance=1e-8)
        before = spring(system, stiffness)
        for _ in range(round(duration / step)):
            state, force = system.saved(), before
            for number in range(repeats):
                if number:
                    force = 0.5 * (before + spring(system, stiffness))
                    system.restore(state)
                system.apply("beam.end", force=force)
                system.step(step)
            before = spring(system, stiffness)
        return system.position("beam.end")

    steps = np.array([0.04, 0.02, 0.01])
    repeated = [coupled(step, 3) for step in steps]
    reference = (4.0 * coupled(0.005, 3) - repeated[-1]) / 3.0  # extrapolated to no step at all
    explicit = [np.abs(coupled(step, 1) - reference).max() for step in steps]
    repeated = [np.abs(tip - reference).max() for tip in repeated]
    assert slope(steps, explicit) == pytest.approx(1.0, abs=0.25)
    assert slope(steps, repeated) == pytest.approx(2.0, abs=0.35)
    assert repeated[-1] < 0.1 * explicit[-1]


@pytest.mark.parametrize("integrator", ["radau", "midpoint", "generalized_alpha"])
def test_return_is_exact(integrator):
    """Identity, bit for bit: going back and on again, records included."""
    given = {} if integrator == "radau" else {"time_step": 0.005}
    model = beam()
    model.force("beam.end", (0, 0.02, 0), until=0.0)
    system = model.co_simulation(["beam.end"], integrator=integrator, **given)
    for _ in range(5):
        system.step(0.01)
    state = system.saved()
    found = []
    for _ in range(2):
        system.restore(state)
        assert system.time == pytest.approx(0.05)
        system.apply("beam.end", force=(0, 0, 0.01), moment=(1e-4, 0, 0))
        for _ in range(5):
            system.step(0.02)
        found.append(system.run().data)
    assert np.array_equal(found[0].position, found[1].position)
    assert np.array_equal(found[0].time, found[1].time)
    assert found[0].time.size == found[1].time.size


def test_frames_and_angular_velocities_are_global():
    """Closed form: a rod on a spinning clamp turns with it."""
    model = beam()
    model.supports.clear()
    model.clamp("beam.start", motion={"rz": vr.SpinUp(2.0, 0.1)})
    system = model.co_simulation(initial="reference")
    system.step(0.3)
    angle = 2.0 * (0.3 - 0.05)
    turned = np.array([np.cos(angle), np.sin(angle), 0.0])
    assert system.frame("beam.start")[:, 2] == pytest.approx(turned, abs=1e-9)
    assert system.angular_velocity("beam.start") == pytest.approx([0, 0, 2.0], abs=1e-9)


def test_wrong_use_is_one_message():
    system = beam().co_simulation(["beam.end"])
    with pytest.raises(vr.InputError, match=r"not a port.*beam.end"):
        system.apply("beam.start", (0, 0, 1))
    with pytest.raises(vr.InputError, match="three finite numbers"):
        system.apply("beam.end", (0, 1))
    with pytest.raises(vr.InputError, match="three finite numbers"):
        system.apply("beam.end", (0, 1, np.nan))
    with pytest.raises(vr.InputError, match="give a time > 0"):
        system.step(0.0)
    with pytest.raises(vr.InputError, match="bem"):
        system.position("bem.end")
    with pytest.raises(vr.InputError, match="bem"):
        beam().co_simulation(["bem.end"])


def test_a_step_that_fails_keeps_the_motion():
    system = beam().co_simulation(["beam.end"])
    system.step(0.01)
    system.apply("beam.end", force=(0, 1e12, 0))

    def push():
        for _ in range(100):
            system.step(0.01)

    with pytest.raises(vr.SolveError, match="could not be followed beyond") as error:
        push()
    assert error.value.run.time[-1] >= 0.01
    assert np.isfinite(error.value.run.data.position).all()
