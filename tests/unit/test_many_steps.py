"""Many steps in one compiled call are, bit for bit, those that Python takes one by one."""

from __future__ import annotations

import numpy as np
import pytest
from numba import types

import viscorod as vr
from helpers.steps_at_once import count_taken, require_same_rest, require_same_steps, transient
from viscorod.analyses.warmup import compile_loop
from viscorod.errors import InputError
from viscorod.mechanics.compilation.by_address import address_of
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.rotations.rotation import motion_extent
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient import many_steps, transient_solver
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.many_steps import ManySteps

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")


@pytest.fixture(scope="module", autouse=True)
def loop():
    """The loop is used where it is there, so it is compiled first."""
    compile_loop()


@pytest.fixture
def taken(monkeypatch):
    """How many steps were taken at once, call by call; of one run, also where errors would be told by a second one."""
    return count_taken(monkeypatch)


def soft(damping):
    """A soft rod."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(damping, damping))
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.01, 0.01), material=material, elements=1, order=4
    )
    model = vr.Model()
    model.add("rod", rod)
    return model


def falling(damping=0.02):
    """A soft rod that falls from rest."""
    model = soft(damping)
    model.gravity((0, 0, -9.81))
    return model


def clamped():
    """Its clamp holds still, and nothing changes."""
    model = falling()
    model.clamp("rod.start")
    return model


def pushed():
    """A small sudden load, of whose motion the tolerance is a part."""
    model = soft(0.002)
    model.clamp("rod.start")
    model.force("rod.end", (0, 0.002, 0.001))
    return model


def thrust():
    """A following force that grows, and another that ends, with a jump."""
    model = clamped()
    model.force("rod.end", (0, 0.02, 0), following=True, time=vr.Sine(2.0))
    model.force("rod.end", (0, 0.05, 0), until=0.15)
    return model


def pulsed():
    """Forces at a node and along the rod, whose functions of time have corners, jumps and an end."""
    model = clamped()
    table = [0.0, 0.05, 0.12, 0.12, 0.3], [0.0, 1.0, 0.5, -0.5, 0.0]
    model.force("rod.end", (0, 0.04, 0), time=vr.TimeTable(*table))
    model.force("rod.end", (0, 0.01, 0.02), following=True, time=vr.Ramp(0.1, 0.2, 1.0), until=0.4)
    model.distributed_force("rod", (0, 0, 0.2), time=vr.TimeTable(*table, interpolation="monotone"))
    model.distributed_force("rod", (0, 0.1, 0), time=vr.Until(0.45))
    return model


def driven():
    """The clamp turns to and fro."""
    model = falling()
    model.clamp("rod.start", motion={"rz": vr.Sine(2.0, amplitude=0.5)})
    return model


class OwnSine(vr.Sine):
    """A function that Python is asked for, since it might be another one."""


def driven_by(*, load=None, **motion):
    """The clamp of a falling rod follows functions of time, beside a force that may be one."""
    model = falling()
    model.clamp("rod.start", motion=motion)
    model.force("rod.end", (0, 0.01, 0), time=load or vr.Sine(3.0))
    return model


def driven_in_all_ways():
    """By every kind of function of time that the loop knows, with corners and jumps of the velocity."""
    return driven_by(
        ux=vr.Ramp(0.1, 0.3, 0.02),
        uy=vr.SmoothRamp(0.05, 0.4, 0.03),
        uz=vr.Sine(1.5, amplitude=0.01, phase=0.4, offset=-0.01 * np.sin(0.4)),
        ry=vr.SpinUp(0.5, 0.3),
        rz=vr.Sine(2.0, amplitude=0.5),
    )


def driven_by_python():
    """Python is asked for the motion, but for no Jacobian."""
    return driven_by(rz=OwnSine(2.0, amplitude=0.5))


def loaded_by_python():
    """Python is asked for loads, and for Jacobians."""
    return driven_by(rz=vr.Sine(2.0, amplitude=0.5), load=OwnSine(3.0))


TABLE = [0.0, 0.1, 0.2, 0.3, 0.4, 0.5], [0.0, 0.2, 0.25, 0.0, -0.2, -0.1]


def driven_by_tables():
    """By a spline, by straight lines with jumps of the velocity, and by cubics that are monotone."""
    times, values = TABLE
    small = [0.05 * value for value in values]
    return driven_by(
        rz=vr.TimeTable(times, values, "cubic"),
        uy=vr.TimeTable(times, small),
        ux=vr.TimeTable(times, small, "monotone"),
    )


class OwnTable(vr.TimeTable):
    """A table that Python is asked for, since it might be another function."""


def driven_by_a_table_in_python():
    """Python is asked for the motion, and for what it does within steps."""
    return driven_by(rz=OwnTable(*TABLE, "cubic"))


def shaken_by_a_record():
    """A force of so many rows that steps see its moments, and what these leave out."""
    model = clamped()
    times = np.linspace(0.0, 0.5, 1001)
    model.force("rod.end", (0, 0.01, 0), time=vr.TimeTable(times, np.sin(60.0 * times) * np.sin(9.0 * times)))
    return model


def dragged():
    """Through a medium that resists, and in a wind that grows and stops, beside a force."""
    model = clamped()
    model.drag("rod", linear_across=0.02, linear_along=0.01, linear_about=1e-6)
    wind = {"velocity": (0, 3.0, 0.5), "density": 1.2, "width": 0.01}
    table = vr.TimeTable([0.0, 0.2, 0.4], [0.0, 1.0, 0.5])
    model.drag("rod", coefficient_across=1.2, coefficient_along=0.01, time=table, until=0.5, **wind)
    model.force("rod.end", (0, 0.01, 0), time=vr.Sine(3.0))
    return model


def dragged_by_python():
    """Python is asked for the factor of the drag, and for Jacobians."""
    model = falling()
    model.drag("rod", linear_across=0.05, time=OwnSine(3.0, amplitude=0.2, offset=1.0))
    return model


def held_in_part():
    """A pin lets it turn, and a guide along an oblique axis slide."""
    model = falling()
    model.pin("rod.start")
    model.guide("rod.end", along=(1.0, 0.2, 0.0))
    return model


def held_in_part_and_moved():
    """What holds its start moves and turns, the guide of its end moves across, and a load changes."""
    model = falling()
    shaking = {"uy": vr.Sine(3.0, amplitude=0.01), "uz": vr.Ramp(0.1, 0.3, 0.02)}
    model.support("rod.start", fixed=["ux", "rx"], motion=shaking | {"rz": vr.SpinUp(1.0, 0.3)})
    model.guide("rod.end", along=(1.0, 0.2, 0.0), motion={"uz": vr.Sine(2.0, amplitude=0.02)})
    model.force("rod@0.3", (0, 0.01, 0), time=vr.Sine(3.0))
    return model


def shaken_by_a_table():
    """The pin follows a table, at whose rows velocities jump."""
    model = falling()
    times, values = TABLE
    model.pin("rod.start", motion={"uy": vr.TimeTable(times, [0.05 * value for value in values])})
    return model


def hardly_shaken():
    """The clamp shakes so little that the tolerance is a part of the motion beside what it carries along."""
    model = soft(0.002)
    model.clamp("rod.start", motion={"uz": vr.Sine(3.0, amplitude=2e-4), "ry": vr.Sine(2.0, amplitude=1e-3)})
    return model


def hardly_slid():
    """Its start slides freely across an oblique axis, and is moved along it so little: nothing turns with it."""
    model, slope = soft(0.002), ((1, 0.02, 0.02), (0, 1, -1))
    held = ["uz", "rx", "ry", "rz"]
    model.support("rod.start", fixed=held, axes=slope, motion={"ux": vr.Ramp(0.0, 0.3, 1e-3)})
    return model


def sleeve():
    """The velocity of the start along the moving section's axes is held."""
    model = falling()
    model.body_velocity("rod.start", fixed=["v2", "v3"])
    return model


def free():
    """A spinning rod in flight."""
    model = falling(0.0)
    model.velocity("rod", linear=(0, 1.0, 1.0), angular=(0, 3.0, 9.0))
    return model


def relaxing(motion=None):
    """Let go with two Maxwell branches, pushed with a jump, and a second rod of another order without branches."""
    stiffness, _, mass = vr.Rectangle(0.01, 0.01).matrices(
        vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
    )
    pairs = (0.4, 0.02), (0.6, 0.4)
    branches = [vr.MaxwellBranch(time=time, stiffness=part * stiffness) for part, time in pairs]
    section = vr.StiffnessSection(stiffness, mass, damping=2e-3 * stiffness, branches=branches)
    model = vr.Model()
    rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, elements=1, order=4)
    model.add("rod", rod)
    stiff = vr.StiffnessSection(2.0 * stiffness, mass, damping=4e-3 * stiffness)
    tip = vr.Rod.straight((0.3, 0, 0), (0.4, 0.1, 0), section=stiff, elements=2, order=2)
    model.add("tip", tip)
    model.attach("rod.end", "tip.start")
    model.clamp("rod.start", motion=motion)
    model.gravity((0, 0, -9.81))
    model.force("rod.end", (0, 0.02, 0), until=0.15)
    return model


def relaxing_and_driven():
    """The same, whose clamp turns to and fro."""
    return relaxing({"rz": vr.Sine(2.0, amplitude=0.5)})


def bent_out_of_two():
    """Two rods of elements of other orders."""
    model = clamped()
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    rod = vr.Rod.straight((0.3, 0, 0), (0.4, 0.1, 0), section=section, material=material, elements=2, order=2)
    model.add("tip", rod)
    model.attach("rod.end", "tip.start")
    return model


@pytest.mark.parametrize(
    ("make", "given"),
    [
        (clamped, {"tolerance": 1e-4, "output_interval": 0.02}),
        (bent_out_of_two, {"tolerance": 1e-4}),
        (clamped, {}),
        (pushed, {}),
        (thrust, {"tolerance": 1e-3}),
        (pulsed, {"tolerance": 1e-4, "output_interval": 0.02}),
        (pulsed, {"tolerance": 1e-3}),
        (driven, {"tolerance": 1e-4, "output_interval": 0.013}),
        (relaxing, {"tolerance": 1e-4, "output_interval": 0.02}),
        (relaxing, {"tolerance": 1e-3}),
        (relaxing, {}),
        (relaxing_and_driven, {"tolerance": 1e-4, "output_interval": 0.013}),
        (driven_in_all_ways, {"tolerance": 1e-4, "output_interval": 0.02}),
        (driven_in_all_ways, {"tolerance": 1e-3, "output_interval": 0.04}),
        (driven_by_python, {"tolerance": 1e-4}),
        (loaded_by_python, {"tolerance": 1e-4}),
        (driven_by_tables, {"tolerance": 1e-4, "output_interval": 0.02}),
        (driven_by_tables, {"tolerance": 1e-2}),
        (driven_by_a_table_in_python, {"tolerance": 1e-4}),
        (shaken_by_a_record, {"tolerance": 1e-4, "output_interval": 0.02}),
        (dragged, {"tolerance": 1e-4, "output_interval": 0.02}),
        (dragged, {}),
        (dragged_by_python, {"tolerance": 1e-3}),
        (held_in_part, {"tolerance": 1e-4, "output_interval": 0.02}),
        (held_in_part, {}),
        (held_in_part_and_moved, {"tolerance": 1e-4, "output_interval": 0.013}),
        (held_in_part_and_moved, {"tolerance": 1e-2}),
        (shaken_by_a_table, {"tolerance": 1e-3}),
        (hardly_shaken, {"output_interval": 0.02}),
        (hardly_slid, {}),
        (sleeve, {"tolerance": 1e-3}),
        (free, {}),
        (free, {"tolerance": 1e-3}),  # a third of the attempts do not converge
        (clamped, {"tolerance": 1e-6, "output_interval": 0.02, "stages": 5}),
        (clamped, {"tolerance": 1e-4, "stages": 7}),
        (driven_in_all_ways, {"tolerance": 1e-5, "output_interval": 0.02, "stages": 5}),
        (relaxing, {"tolerance": 1e-5, "stages": 5}),
        (held_in_part_and_moved, {"tolerance": 1e-4, "output_interval": 0.013, "stages": 5}),
    ],
)
def test_steps_taken_at_once_are_those_taken_one_by_one(make, given, taken):
    """All data, and all that a result says of its steps and of their errors."""
    require_same_steps(make, 0.6, taken, **given)


def test_elements_of_several_orders_are_linearised_in_the_loop(taken, monkeypatch):
    """Python makes the Jacobians of the steps that it takes, one after each start, and no others."""
    renewed, renew = [], Radau.renew_jacobian
    monkeypatch.setattr(
        Radau, "renew_jacobian", lambda self, h, **given: renewed.append(h) or renew(self, h, **given)
    )
    run = bent_out_of_two().simulate(0.6, initial="reference", tolerance=1e-4)
    alone = run.data.attrs["steps"] - sum(taken)
    assert len(renewed) <= alone + 2  # and of both halves of a step that is tried again
    assert run.data.attrs["jacobians"] > alone + 2


def test_attempts_that_do_not_converge_stay_in_the_loop(taken):
    """Python takes no step, however many attempts fail with a new Jacobian."""
    run = free().simulate(0.6, initial="reference", tolerance=1e-3)
    assert run.data.attrs["rejected"] > 3
    assert sum(taken) == run.data.attrs["steps"]


def test_corners_are_passed_at_once(taken, monkeypatch):
    """From one jump to the next, however many corners are between; or no more than are known beforehand."""
    corners = np.linspace(0.01, 0.5, 50)
    table = vr.TimeTable([*corners, 0.5, 0.6], [*np.abs(np.sin(40.0 * corners)), 2.0, 2.0])
    model = clamped()
    model.force("rod.end", (0, 0.01, 0), time=table)
    run = model.simulate(0.7, initial="reference", tolerance=1e-2, output_interval=0.01)
    assert run.data.attrs["steps"] > 50
    assert len(taken) < 6
    assert sum(taken) == run.data.attrs["steps"]
    count = len(taken)
    monkeypatch.setattr(many_steps, "MOST_CORNERS", 3)
    again = model.simulate(0.7, initial="reference", tolerance=1e-2, output_interval=0.01)
    assert len(taken) > count + 12
    assert again.data.equals(run.data)


@pytest.mark.parametrize("make", [thrust, relaxing])
def test_a_run_goes_on_from_a_step_that_was_taken_with_others(make, taken, monkeypatch):
    """Bit for bit, from a checkpoint in the middle."""
    monkeypatch.setattr(many_steps, "MOST_STEPS", 5)
    account = require_same_rest(make, 0.4)
    assert sum(taken) > 0
    assert len(account.branches) == (2 if make is relaxing else 0)


class Told:
    """Times that a run tells, all or where it is patient."""

    def __init__(self, patient):
        self.patient, self.ends, self.lengths = patient, [], []

    def __call__(self, end, h):
        self.ends.append(end)
        self.lengths.append(h)


def test_who_is_patient_is_told_the_last_of_some_steps(taken, monkeypatch):
    monkeypatch.setattr(many_steps, "MOST_STEPS", 7)
    every, last = Told(False), Told(True)
    for told in (every, last):
        run, state = transient(clamped(), 0.2)
        run.run(state, 0.2, progress=told)
    ends = np.cumsum(taken[: len(taken) // 2]) - 1
    assert len(every.ends) == run.effort.steps > len(last.ends) > 1
    assert last.ends == [every.ends[k] for k in ends]
    assert last.lengths == [every.lengths[k] for k in ends]


def test_functions_of_the_user_are_told_of_every_step(taken):
    """What they do may depend on it, so their steps are taken one by one, and each is told before the next."""
    told, seen = [], []

    def time(t):
        seen.append(len(told))
        return np.sin(40.0 * t)

    model = clamped()
    model.force("rod.end", (0, 0.01, 0), time=time)
    run = model.simulate(0.2, initial="reference", tolerance=1e-3, progress=lambda t, h: told.append(t))
    assert not taken
    assert len(told) == run.data.attrs["steps"]
    assert set(range(len(told))) <= set(seen)


def test_machine_code_is_loaded_for_long_runs_only(taken, monkeypatch):
    """From disk it takes longer than a short run: of that all steps are taken one by one, of a long one the first."""
    monkeypatch.setattr(KnownTypes, "loaded", property(lambda _: False))
    monkeypatch.setattr(KnownTypes, "kept", property(lambda _: True))
    short, state = transient(clamped(), 0.2)
    assert short.run(state, 0.2).effort.steps > 10
    assert not taken
    monkeypatch.setattr(transient_solver, "LONG", 10)
    long, state = transient(clamped(), 0.2)
    assert long.run(state, 0.2).effort.steps == short.effort.steps
    assert 0 < sum(taken) <= long.effort.steps - 10


def test_what_goes_wrong_in_python_ends_the_run(taken):
    """An error in a Jacobian, which Python makes where it is asked for loads, leaves the states so far."""
    run, state = transient(loaded_by_python(), 0.6)
    renew, renewed = run.integrator.renew_jacobian, []

    def fails(h, *, at_start):
        renewed.append(run.integrator.t)
        if len(renewed) > 4:
            raise InputError("no more of these")
        renew(h, at_start=at_start)

    run.integrator.renew_jacobian = fails
    result = run.run(state, 0.6, output_interval=0.01)
    assert result.outcome is Outcome.INTERRUPTED
    assert result.reason == "no more of these"
    assert sum(taken) > 0
    assert 0.0 < result.history.instant[-1] < 0.6
    assert np.isfinite(result.history.snapshots[-1].state.r).all()


def test_a_kernel_is_only_called_for_what_it_returns():
    """The types are part of the call: others are refused before anything is called."""
    where = np.zeros((2, 3)), np.zeros((2, 4))
    given = (*where, *where, np.zeros((2, 6)), 1.0)
    two = types.UniTuple(types.float64, 2)
    assert address_of(KnownTypes(motion_extent), two, lambda: given) > 0
    with pytest.raises(TypeError, match=r"motion_extent returns .*float64.* not int64"):
        address_of(KnownTypes(motion_extent), types.int64, lambda: given)


@pytest.mark.parametrize("at_once", [True, False])
def test_a_record_at_a_jump_is_the_state_before_it(at_once, taken, monkeypatch):
    """The clamp moves evenly from 0.1 s to 0.3 s; its velocity there is that of the way to these instants."""
    if not at_once:
        monkeypatch.setattr(ManySteps, "of", lambda *_, **__: None)
    model = falling()
    model.clamp("rod.start", motion={"ux": vr.Ramp(0.1, 0.3, 0.02)})
    run = model.simulate(0.4, initial="reference", tolerance=1e-3, output_interval=0.1)
    assert bool(sum(taken)) is at_once
    speed = run.history("rod.start", "velocity").values[:, 0]
    assert speed == pytest.approx([0.0, 0.0, 0.1, 0.1, 0.0], abs=1e-12)
