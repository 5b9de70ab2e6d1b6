"""Joints, springs and held strains in the compiled loop of steps: bit for bit as in steps that are taken one by one."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.steps_at_once import count_taken, require_same_rest, require_same_steps
from viscorod.analyses.warmup import compile_loop
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.solve.transient import many_steps

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")


@pytest.fixture(scope="module", autouse=True)
def loop():
    """The loop is used where it is there, so it is compiled first."""
    compile_loop()


@pytest.fixture
def taken(monkeypatch):
    """How many steps were taken at once, call by call."""
    return count_taken(monkeypatch)


def rods(start, damping=0.02, **more):
    """Two soft rods that fall, the first held at its start; the second one begins where it ends."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(damping, damping))
    given = {"section": vr.Rectangle(0.01, 0.01), "material": material, "elements": 1, "order": 4}
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given, **more))
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.5, 0, 0), **given))
    start(model)
    model.gravity((0, 0, -9.81))
    return model


def clamped(**more):
    """The first one is clamped."""
    return rods(lambda model: model.clamp("rod.start"), **more)


def hinged():
    """A hinge about an oblique axis."""
    model = clamped()
    model.revolute("arm.start", "rod.end", (0, 1, 0.3))
    return model


def sprung():
    """A hinge with a spring and a damper, and a spring from the tip to the ground, at first without force."""
    model = clamped()
    model.revolute("arm.start", "rod.end", (0, 1, 0), stiffness={"rz": 1e-3}, damping={"rz": 1e-5})
    model.spring("arm.end", "ground", stiffness={"ux": 1.0, "uz": 0.5}, damping={"uz": 0.01})
    return model


def only_sprung():
    """No joint: springs alone, so that nothing has a multiplier."""
    model = clamped()
    model.spring("arm.start", "rod.end", stiffness={"ux": 50.0, "uy": 50.0, "uz": 50.0}, damping={"uz": 0.05})
    return model


def universal():
    """A universal joint, and a ball at the start in place of a clamp."""
    model = rods(lambda model: model.ball("rod.start", "ground"))
    model.universal("arm.start", "rod.end", [(0, 1, 0), (0, 0, 1)])
    return model


def loop_of_bars():
    """Two hinges to the ground more than a plane mechanism needs: some conditions are redundant."""
    model = rods(lambda model: model.revolute("rod.start", "ground", (0, 1, 0)))
    model.revolute("arm.start", "rod.end", (0, 1, 0))
    model.prismatic("arm.end", "ground", (1, 0, 0))
    return model


def lifted(model):
    """A slider at its start follows a ramp, with corners."""
    model.prismatic("rod.start", "ground", (0, 0, 1), motion={"uz": vr.Ramp(0.1, 0.3, 0.02)})


def motors():
    """A hinge that turns by a spline, and a slider."""
    model = rods(lifted)
    times = np.linspace(0.0, 0.5, 11)
    turn = vr.TimeTable(times, 0.5 * np.sin(9.0 * times), "cubic")
    model.revolute("arm.start", "rod.end", (0, 1, 0.3), motion={"rz": turn})
    return model


def carried():
    """The clamp turns to and fro, a hinge turns at an even speed, and loads change: one of them is Python's."""
    model = rods(lambda model: model.clamp("rod.start", motion={"rz": vr.Sine(2.0, amplitude=0.5)}))
    model.revolute("arm.start", "rod.end", (0, 1, 0), motion={"rz": vr.SpinUp(6.0, 0.2)})
    model.force("arm.end", (0, 0.01, 0), time=vr.TimeTable([0.0, 0.1, 0.3], [0.0, 1.0, 0.5]))
    return model


class OwnSine(vr.Sine):
    """A function that Python is asked for, since it might be another one."""


def loaded_by_python():
    """Python is asked for loads, and for Jacobians."""
    model = motors()
    model.force("arm.end", (0, 0.01, 0), time=OwnSine(3.0))
    return model


def inextensible():
    """A rod whose ends turn only, beside a hinge with a spring."""
    model = clamped(constraints=("unshearable", "inextensible"))
    model.revolute("arm.start", "rod.end", (0, 1, 0), stiffness={"rz": 1e-3}, damping={"rz": 1e-5})
    return model


def inextensible_alone():
    """No joint."""
    model = clamped(constraints=("unshearable", "inextensible"))
    model.attach("rod.end", "arm.start")
    return model


def relaxing():
    """Maxwell branches in one of the rods, and a pin that holds it in part."""
    stiffness, _, mass = vr.Rectangle(0.01, 0.01).matrices(
        vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    )
    branch = vr.MaxwellBranch(time=0.05, stiffness=0.5 * stiffness)
    section = vr.StiffnessSection(stiffness, mass, damping=2e-3 * stiffness, branches=[branch])
    model = vr.Model()
    model.add("rod", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=1, order=4))
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.5, 0, 0), section=section, elements=1, order=3))
    model.pin("rod.start")
    model.revolute("arm.start", "rod.end", (0, 1, 0.3))
    model.gravity((0, 0, -9.81))
    return model


@pytest.mark.parametrize(
    ("make", "given"),
    [
        (hinged, {"tolerance": 1e-4, "output_interval": 0.013}),
        (hinged, {}),
        (sprung, {"tolerance": 1e-3}),
        (only_sprung, {"tolerance": 1e-3, "output_interval": 0.02}),
        (universal, {"tolerance": 1e-3}),
        (loop_of_bars, {"tolerance": 1e-3, "output_interval": 0.02}),
        (motors, {"tolerance": 1e-3, "output_interval": 0.013}),
        (motors, {}),
        (carried, {"tolerance": 1e-3}),
        (carried, {}),
        (loaded_by_python, {"tolerance": 1e-2, "output_interval": 0.02}),
        (inextensible, {"tolerance": 1e-3, "output_interval": 0.013}),
        (inextensible_alone, {}),
        (relaxing, {"tolerance": 1e-3, "output_interval": 0.013}),
        (hinged, {"tolerance": 1e-5, "output_interval": 0.013, "stages": 5}),
        (inextensible, {"tolerance": 1e-4, "stages": 5}),
    ],
)
def test_steps_taken_at_once_are_those_taken_one_by_one(make, given, taken):
    """All data, joints and drifts among them."""
    require_same_steps(make, 0.4, taken, **given)


def test_a_run_goes_on_from_a_step_that_was_taken_with_others(taken, monkeypatch):
    """Bit for bit, from a checkpoint in the middle, joints and multipliers among them."""
    monkeypatch.setattr(many_steps, "MOST_STEPS", 5)
    require_same_rest(motors, 0.3)
    assert sum(taken) > 20


def own_law(model):
    """A spring that is a Python function."""
    model.revolute("arm.start", "rod.end", (0, 1, 0), stiffness={"rz": lambda turn: 1e-3 * turn})


def own_motor(model):
    """A motor that is a Python function."""
    model.revolute("arm.start", "rod.end", (0, 1, 0), motion={"rz": OwnSine(2.0)})


def turned_ball(model):
    """Motors of a rotation vector, whose axes are turned between steps."""
    model.ball("arm.start", "rod.end", motion={"rx": vr.Sine(2.0), "ry": vr.Sine(1.0), "rz": vr.Sine(3.0)})


@pytest.mark.parametrize("joint", [own_law, own_motor, turned_ball])
def test_what_is_pythons_in_joints_keeps_steps_one_by_one(joint, taken):
    """Nothing of it is left out."""
    model = clamped()
    joint(model)
    run = model.simulate(0.05, initial="reference", tolerance=1e-2)
    assert taken == []
    assert run.data.attrs["steps"] > 1


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of the axial force that the start sets off
def test_a_pendulum_on_a_hinge_swings_as_a_rigid_one(taken):
    """Its angle after one quarter of the period of large swings, from rest at a right angle to where it hangs.

    That is ``K(sin(45 degrees)) / omega`` with ``omega^2 = (g l/2) / (l^2/3 + r^2/4)`` of a round rod (elliptic
    integral); without r it would come 4e-5 of the length too late.
    """
    length, gravity = 0.3, 9.81
    # ten times as stiff as steel, whose bending, set off by the start, moves the end by 2e-5 of the length
    material = vr.Material(2e12, poissons_ratio=0.3, density=7800.0)
    model = vr.Model()
    radius = 0.002
    section = vr.Circle(radius)
    rod = vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, material=material, elements=1, order=3)
    model.add("rod", rod)
    model.revolute("rod.start", "ground", (0, 1, 0))
    model.gravity((0, 0, -gravity))
    quarter = 1.8540746773013719 * np.sqrt((length**2 / 3.0 + radius**2 / 4.0) / (0.5 * gravity * length))
    run = model.simulate(quarter, initial="reference", tolerance=1e-6)
    assert sum(taken) == run.data.attrs["steps"]
    end = run.history("rod.end", "position").values[-1]
    assert end == pytest.approx([0.0, 0.0, -length], abs=5e-6 * length)
