"""Orders of accuracy by regression of the logarithm of the error (case E5)."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.transient.integrators import INTEGRATORS


def curved(elements, order, damping=None, full=True):
    """A curved and twisted cantilever, coupled section, bent and twisted strongly in three dimensions."""
    stiffness = np.diag([800.0, 700.0, 2e3, 1.0, 1.4, 0.8])
    if full:
        stiffness[2, 3] = stiffness[3, 2] = 10.0
        stiffness[3, 5] = stiffness[5, 3] = 0.2
    section = vr.StiffnessSection(
        stiffness, [1, 1, 1, 1e-2, 1e-2, 2e-2], None if damping is None else damping * stiffness
    )
    model = vr.Model()
    rod = vr.Rod.arc(
        (0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, section=section, elements=elements, order=order, twist=0.8
    )
    model.add("rod", rod)
    model.clamp("rod.start")
    return model


def slope(sizes, errors):
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def loaded(elements, order):
    model = curved(elements, order)
    model.force("rod.end", (0.4, 0.8, 1.5))
    model.moment("rod.end", (0.3, 0.0, -0.4), following=True)
    model.distributed_force("rod", lambda s: (0.0, np.sin(s), 0.5))
    return model.equilibrium().position("rod.end")


@pytest.fixture(scope="module")
def exact_shape():
    return loaded(12, 9)


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_order_in_space_static(order, exact_shape):
    """At least p + 1 against a mesh of 12 elements of order 9."""
    counts = {1: (8, 16, 32, 64), 2: (4, 8, 16, 32), 3: (3, 6, 12), 4: (2, 4, 8)}[order]
    errors = [np.abs(loaded(n, order) - exact_shape).max() for n in counts]
    assert slope([1 / n for n in counts], errors) > order + 1 - 0.25


def swung(elements, order, time_step, **given):
    """Tip after a short, fast, damped motion."""
    model = curved(elements, order, damping=0.01)
    model.force("rod.end", (0.4, 0.8, 1.5), time=vr.Sine(1.0))
    model.moment("rod.end", (0.3, 0.0, -0.4), following=True, time=vr.Sine(0.7))
    run = model.simulate(
        0.8, time_step=time_step, initial="reference", integrator="generalized_alpha", errors=False, **given
    )
    return run.history("rod.end").values[-1]


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_order_in_space_dynamic(order):
    """At least p + 1 at a fixed small step (the time error is the same on every mesh)."""
    counts = {1: (8, 16, 32), 2: (4, 8, 16), 3: (2, 4, 8), 4: (1, 2, 4)}[order]
    exact = swung(8, 7, 0.01)
    errors = [np.abs(swung(n, order, 0.01) - exact).max() for n in counts]
    assert slope([1 / n for n in counts], errors) > order + 1 - 0.3


@pytest.mark.parametrize("radius", [1.0, 0.9, 0.5, 0.0])
@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_order_in_time(radius):
    """Two, against the same mesh at a step eight times smaller than the smallest."""
    steps = (0.02, 0.01, 0.005)
    exact = swung(3, 4, 0.005 / 8, spectral_radius=radius)
    errors = [np.abs(swung(3, 4, h, spectral_radius=radius) - exact).max() for h in steps]
    assert slope(steps, errors) == pytest.approx(2.0, abs=0.15)


def released(time_step):
    """A release: the load jumps at t = 0 and again at t = 0.25, which no step may straddle."""
    model = curved(3, 4, damping=0.02)
    model.force("rod.end", (0, 0, 1.0), until=0.0)
    model.force("rod.end", (0.5, 0, 0), time=vr.TimeTable([0.0, 0.25, 0.25], [0.0, 0.0, 1.0]))
    run = model.simulate(0.7, time_step=time_step, integrator="generalized_alpha", errors=False)
    return run.history("rod.end").values[-1]


def test_order_in_time_with_jumps():
    """Still two when loads jump inside the interval (a starting lag would make it one)."""
    steps = (0.02, 0.01, 0.005)
    exact = released(0.005 / 8)
    errors = [np.abs(released(h) - exact).max() for h in steps]
    assert slope(steps, errors) == pytest.approx(2.0, abs=0.3)


def whirled(time_step):
    """Prescribed motion of a clamp and a partly supported, moving far end."""
    model = curved(3, 4, damping=0.01)
    model.supports.clear()
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0, amplitude=0.1), "rz": vr.Sine(0.5, amplitude=0.8)})
    model.support("rod.end", ("ux",), motion={"uz": vr.Sine(0.8, amplitude=0.15)})
    given = {"initial": "reference", "integrator": "generalized_alpha", "errors": False}
    run = model.simulate(0.8, time_step=time_step, **given)
    return np.concatenate([run.history("rod@0.6").values[-1], run.history("rod.end").values[-1]]), run


@pytest.mark.filterwarnings("ignore:the numerical remainder")  # the steps are coarse on purpose
def test_order_in_time_with_prescribed_motion_and_partial_support():
    """Two, and the supported components follow exactly."""
    steps = (0.02, 0.01, 0.005)
    exact, run = whirled(0.005 / 8)
    t = run.time
    assert run.history("rod.end", "displacement").values[:, 2] == pytest.approx(
        0.15 * np.sin(2 * np.pi * 0.8 * t), abs=1e-9
    )
    assert run.history("rod.end", "velocity").values[:, 0] == pytest.approx(0 * t, abs=1e-9)
    errors = [np.abs(whirled(h)[0] - exact).max() for h in steps]
    assert slope(steps, errors) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("jump", [0.3, 0.1 + 0.2, 1 / 3, 0.7])
def test_no_step_straddles_a_jump(jump, integrator):
    """The load is on up to its jump and off from it on, whatever the rounding of the times of steps."""
    model = curved(2, 3, damping=0.02)
    model.force("rod.end", (0, 0, 1.0), until=jump)
    run = model.simulate(1.0, time_step=0.01, integrator=integrator, errors=False)
    k = int(np.argmin(np.abs(run.time - jump)))
    assert run.time[k] == pytest.approx(jump, abs=1e-12)
    held = run.history("rod.end").values[: k + 1]
    assert np.abs(held - held[0]).max() < 1e-9  # at rest in its equilibrium until the jump
    after = (run.time > jump) & (run.time < jump + 0.011)
    assert np.abs(run.history("rod.end").values[after] - held[0]).max() > 1e-6
