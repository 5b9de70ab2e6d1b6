"""Told errors of positions, rotations and section forces are within a factor of three of the true ones.

Refinement: the same mesh with a tolerance of 1e-8 and at least 6000 steps, so that the vibrations that carry section
forces are followed, compared at 400 equal times from the start on.
"""

from __future__ import annotations

import functools
import warnings

import numpy as np
import pytest

import viscorod as vr
from viscorod.mechanics.rotations.quaternion import conjugate, product

from .independent.slider_crank import SliderCrank
from .test_mechanisms import slider_crank
from .test_step_errors import double_pendulum, pendulum, soft, steel, suddenly_loaded, tumbling

TIMES, FINE = 400, 6000


def swinging():
    """A soft cantilever, bent far and let go, undamped."""
    return soft(duration=0.5)


def relaxing():
    """The same with a Maxwell branch."""
    branch = vr.Prony(shear_ratios=[0.3], shear_times=[0.02], constant="poissons_ratio")
    return soft(branch, duration=0.5)


def pulled():
    """A bar that is suddenly pulled and bent: axial vibrations last."""
    model = steel()
    model.force("bar.end", (100.0, 0, 1.0))
    return model, {"duration": 0.1, "initial": "reference"}


def falling():
    """A steel bar that falls on a ball joint."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=material, elements=2, order=3
    )
    model.add("bar", rod)
    model.ball("bar.start", "ground")
    model.gravity((0, 0, -9.81))
    return model, {"duration": 1.0, "initial": "reference"}


def halves():
    """The same bar in two halves."""
    model = vr.Model()
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0)
    given = {"section": vr.Circle(0.01), "material": material, "elements": 1, "order": 4}
    model.add("one", vr.Rod.straight((0, 0, 0), (0.5, 0, 0), **given))
    model.add("two", vr.Rod.straight((0.5, 0, 0), (1, 0, 0), **given))
    model.attach("one.end", "two.start")
    model.ball("one.start", "ground")
    model.gravity((0, 0, -9.81))
    return model, {"duration": 1.0, "initial": "reference"}


def crank_turn(damping=0.0):
    """One turn of a slider-crank whose coupler is a rod."""
    case = SliderCrank(damping=damping)
    return slider_crank(case), {"duration": 2 * np.pi / case.speed, "initial": "reference"}


def damped_crank_turn():
    return crank_turn(5e-5)


def run_up_crank():
    """A slider-crank of steel rods, whose crank is run up to 10 turns per second: nothing jumps, all turns far."""
    damping = vr.KelvinVoigt(1e-6, 1e-6)
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0, damping=damping)
    given = {"section": vr.Circle(0.004), "material": material, "elements": 2, "order": 4}
    model = vr.Model()
    model.add("crank", vr.Rod.straight((0, 0, 0), (0.1, 0, 0), **given))
    model.add("coupler", vr.Rod.straight((0.1, 0, 0), (0.4, 0, 0), **given))
    model.add("slider", vr.Body(mass=0.5, inertia=(1e-4, 1e-4, 1e-4), centre=(0.4, 0, 0)))
    model.revolute(
        "crank.start", "ground", (0, 1, 0), motion={"rz": vr.SpinUp(speed=20 * np.pi, duration=0.1)}
    )
    model.revolute("coupler.start", "crank.end", (0, 1, 0))
    model.revolute("slider", "coupler.end", (0, 1, 0))
    model.support("slider", fixed=["uz"])
    return model, {"duration": 0.2, "initial": "reference"}


def suddenly_spun():
    """The first tenth of a second of the plate below: its spin begins at once, and it rings along itself undamped."""
    model, given = middle_axis()
    return model, given | {"duration": 0.1}


def middle_axis():
    """A plate that spins about the axis of its middle inertia, and a little about the others: it turns over."""
    model = vr.Model()
    material = vr.Material(2e9, poissons_ratio=0.3, density=1000.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=vr.Rectangle(0.1, 0.02), material=material, elements=1, order=3
    )
    model.add("plate", rod)
    model.velocity("plate", angular=(0.01, 10.0, 0.01), point=(0.15, 0, 0))
    return model, {"duration": 3.0, "initial": "reference"}


def linked(joint):
    """Two bars of plastic, one behind the other."""
    model = vr.Model()
    material = vr.Material(2e9, poissons_ratio=0.3, density=1000.0)
    given = {"section": vr.Circle(0.01), "material": material, "elements": 1, "order": 3}
    model.add("one", vr.Rod.straight((0, 0, 0), (0.3, 0, 0), **given))
    model.add("two", vr.Rod.straight((0.3, 0, 0), (0.6, 0, 0), **given))
    model.revolute("two.start", "one.end", joint)
    return model


def flung():
    """Two hinged bars that turn and fly free."""
    model = linked((0, 0, 1))
    for name in ("one", "two"):
        model.velocity(name, angular=(1.0, 0.5, 6.0), point=(0.15, 0, 0))
    return model, {"duration": 3.0, "initial": "reference"}


def chaotic():
    """A double pendulum that goes over the top, 5 s long."""
    model = linked((0, 1, 0))
    model.revolute("one.start", "ground", (0, 1, 0))
    model.gravity()
    return model, {"duration": 5.0, "initial": "reference"}


def snapping():
    """A shallow arch of steel that a force beside its middle makes snap through."""
    height, span = 0.02, 0.4
    radius = (span**2 / 4 + height**2) / (2 * height)
    angles = np.linspace(-1.0, 1.0, 15) * np.arcsin(span / 2 / radius)
    points = [(radius * np.sin(a) + span / 2, 0, radius * np.cos(a) - radius + height) for a in angles]
    damping = vr.KelvinVoigt(1e-5, 1e-5)
    material = vr.Material(2e11, poissons_ratio=0.3, density=7850.0, damping=damping)
    model = vr.Model()
    section = vr.Rectangle(0.02, 0.001)
    model.add("arch", vr.Rod.through(points, section=section, material=material, elements=4, order=3))
    model.pin("arch.start")
    model.pin("arch.end")
    model.force("arch@0.15", (0, 0, -40.0), time=vr.SmoothRamp(0.0, 0.1))
    return model, {"duration": 0.2, "initial": "reference"}


def compared(run, fine):
    """Largest differences of positions, rotations, section forces and moments."""
    moved = np.linalg.norm(run.data["position"].values - fine.data["position"].values, axis=2).max()
    q, exact = (one.data["rotation"].values.reshape(-1, 4) for one in (run, fine))
    turned = 2.0 * np.arcsin(np.linalg.norm(product(conjugate(exact), q)[:, 1:], axis=1).max())
    away = run.data["section_force"].values - fine.data["section_force"].values
    return moved, turned, *np.linalg.norm(away.reshape(-1, 2, 3), axis=2).max(axis=0)


MOTIONS = (
    swinging, relaxing, suddenly_loaded, pulled, tumbling, falling, halves, double_pendulum, crank_turn,
    damped_crank_turn, run_up_crank, suddenly_spun,
)  # fmt: skip


@pytest.mark.parametrize("motion", MOTIONS, ids=lambda motion: motion.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # of the forces that vibrations carry
def test_told_errors_are_within_a_factor_of_three(motion):
    """See the module's text."""
    model, given = motion()
    given |= {"output_interval": given["duration"] / TIMES}
    run = model.simulate(**given)
    fine = model.simulate(**given, tolerance=1e-8, time_step=given["duration"] / FINE, errors=False)
    for kind, error in zip(run.step_errors, compared(run, fine), strict=True):
        assert 1.0 / 3.0 < run.step_errors[kind] / error < 3.0, (kind, run.step_errors[kind], error)


def bent_far():
    """The soft cantilever with damping: it swings to the other side of where it started."""
    return soft(vr.KelvinVoigt(0.02, 0.02), duration=2.0)


def hanging_wire():
    """A steel wire that falls from the horizontal: it ends across the shape that it began with."""
    model = vr.Model()
    damping = [0.1, 0.1, 2.0, 2e-4, 2e-4, 8e-6]
    stiffness, _, inertia = vr.Circle(1e-3).matrices(vr.Material(2.1e11, poissons_ratio=0.2, density=7850.0))
    section = vr.StiffnessSection(stiffness.tolist(), inertia.tolist(), damping)
    model.add("wire", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=4))
    model.clamp("wire.start")
    model.gravity((0, 0, -9.81))
    return model, {"duration": 1.0, "initial": "reference"}


def pushed_frame():
    """A right-angle frame that is pushed out of its plane, undamped, and turns by more than a radian."""
    model = vr.Model()
    section = vr.StiffnessSection([1e6, 1e6, 1e6, 1e3, 1e3, 1e3], [1, 1, 1, 10, 10, 20])
    given = {"section": section, "elements": 1, "order": 5}
    model.add("one", vr.Rod.straight((0, 0, 0), (0, 10, 0), **given))
    model.add("two", vr.Rod.straight((0, 10, 0), (10, 10, 0), **given))
    model.attach("one.end", "two.start")
    model.clamp("one.start")
    model.force("one.end", (0, 0, 50), time=vr.TimeTable([0, 1, 2], [0, 1, 0]), until=2.0)
    return model, {"duration": 5.0, "initial": "reference"}


@pytest.mark.parametrize("motion", [bent_far, hanging_wire, pushed_frame], ids=lambda motion: motion.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_told_errors_of_tight_tolerances(motion):
    """As above, in shapes that are far from the start: positions had been told up to 35 times too large."""
    model, given = motion()
    given |= {"output_interval": given["duration"] / TIMES}
    fine = model.simulate(**given, tolerance=1e-10, errors=False)
    for tolerance in (1e-5, 1e-7):
        run = model.simulate(**given, tolerance=tolerance)
        moved, turned, _, _ = compared(run, fine)
        assert 1.0 / 3.0 < run.step_errors["position"] / moved < 4.0, (tolerance, moved)
        assert 1.0 / 3.0 < run.step_errors["rotation"] / turned < 5.0, (tolerance, turned)


@pytest.mark.parametrize(("motion", "tolerance"), [(bent_far, 1e-3), (pendulum, 1e-6)])
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_errors_that_fade_within_a_step_are_not_spread(motion, tolerance):
    """As above: forces had been told 25 and 13 times too large, by vibrations whose errors cancel in each step."""
    model, given = motion()
    given |= {"output_interval": given["duration"] / TIMES}
    fine = model.simulate(**given, tolerance=1e-3 * tolerance, errors=False)
    run = model.simulate(**given, tolerance=tolerance)
    for kind, error in zip(run.step_errors, compared(run, fine), strict=True):
        assert 1.0 / 3.0 < run.step_errors[kind] / error < 5.0, (kind, run.step_errors[kind], error)


@pytest.mark.parametrize("motion", [middle_axis, flung, chaotic], ids=lambda motion: motion.__name__)
@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")  # errors of these are as large as they are
def test_errors_that_a_motion_makes_grow_are_told(motion):
    """Of these motions 0.0002 to 0.01 of the true errors of positions had been told, but for the second one.

    Steps of half a thousandth of the duration or less and a tolerance of 1e-8 leave 1/1000 of the errors or less.
    """
    model, given = motion()
    given |= {"output_interval": given["duration"] / TIMES}
    run = model.simulate(**given)
    fine = model.simulate(**given, tolerance=1e-8, time_step=given["duration"] / FINE, errors=False)
    moved, turned, _, moment = compared(run, fine)
    assert 1.0 / 3.0 < run.step_errors["position"] / moved < 3.0
    assert 1.0 / 3.0 < run.step_errors["rotation"] / turned < 3.0
    assert run.step_errors["section_moment"] > moment / 3.0


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_errors_of_an_arch_that_snaps_are_told():
    """What is wrong when it snaps is a time, by which all that comes after is late."""
    model, given = snapping()
    given |= {"output_interval": given["duration"] / TIMES}
    run = model.simulate(**given)
    moved, turned, _, _ = compared(run, model.simulate(**given, tolerance=1e-7, errors=False))
    assert 1.0 / 3.0 < run.step_errors["position"] / moved < 3.0
    assert 1.0 / 3.0 < run.step_errors["rotation"] / turned < 3.0


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_grown_errors_are_told_with_few_states_and_from_disk(tmp_path):
    """The second run is compared where states are stored and at the end, where errors that grow are largest."""
    model, given = chaotic()
    every, some = model.simulate(**given), model.simulate(**given, output_interval=0.3)
    stored = model.simulate(**given, folder=tmp_path / "run")
    assert stored.step_errors == every.step_errors
    assert some.step_errors["position"] == pytest.approx(every.step_errors["position"], rel=0.01)
    assert every.mesh_errors["one"] > 1e-4  # 9e-6 where the motion makes no more of them


FIRST_OF_IT = {"duration": 1.5, "output_interval": 0.01}


@functools.cache
def fine_and_chaotic():
    model, given = chaotic()
    return model.simulate(**given | FIRST_OF_IT, tolerance=1e-8, time_step=1e-3, errors=False)


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
@pytest.mark.parametrize("integrator", ["midpoint", "generalized_alpha"])
def test_grown_errors_of_equal_steps_are_told(integrator):
    """The same as above, with equal steps that are fine enough for the two bars to be where they are known."""
    model, given = chaotic()
    run = model.simulate(**given | FIRST_OF_IT, integrator=integrator, time_step=1e-3)
    moved, turned, _, _ = compared(run, fine_and_chaotic())
    assert 1.0 / 3.0 < run.step_errors["position"] / moved < 3.0
    assert 1.0 / 3.0 < run.step_errors["rotation"] / turned < 3.0


@pytest.mark.filterwarnings("ignore::viscorod.AccuracyWarning")
def test_a_motion_alone_has_the_same_numbers_and_no_second_run():
    """Without estimates nothing is told of errors; where they choose the mesh they cannot be left out."""
    model, given = middle_axis()
    known, reached = model.simulate(**given), []
    alone = model.simulate(**given, errors=False, progress=lambda t, _: reached.append(t))
    for name in ("position", "rotation", "section_force"):
        np.testing.assert_array_equal(alone.data[name].values, known.data[name].values)
    assert reached == sorted(reached)
    assert alone.step_errors == alone.mesh_errors == {}
    assert known.step_errors
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=vr.Material(2e11, 0.3, 7850.0)
    )
    model.add("free", rod)
    with pytest.raises(vr.InputError, match="errors: False: the program chooses the mesh of 'free'"):
        model.simulate(0.1, errors=False)


def test_a_second_run_that_is_stopped_tells_that_errors_are_not_known():
    """The motion is over, and whole; the run that would tell how its errors grow is stopped after its first step."""
    model, given = middle_axis()
    over = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is told is in the result
        run = model.simulate(
            **given,
            progress=lambda t, _: over.append(t) if t >= given["duration"] else None,
            stop=lambda: "enough" if over else "",
        )
    assert run.outcome == "completed"
    assert [one for one in run.warnings if one.startswith("the second run")]


@pytest.mark.filterwarnings("ignore:the numerical remainder")
@pytest.mark.parametrize("interval", [None, 0.05, 1.0])
def test_a_motion_that_an_event_ends_is_computed_again_up_to_there(interval):
    """What is told covers the true error at the event, within a step; nothing beyond is computed."""
    model, _ = middle_axis()
    run = model.simulate(
        1e6, initial="reference", events=[vr.Crossing("plate.end", "x", 0.2)], output_interval=interval
    )
    until = float(run.time[-1])
    fine = model.simulate(until, initial="reference", tolerance=1e-8, errors=False)
    away = run.history("plate.end", "position").values[-1] - fine.history("plate.end", "position").values[-1]
    assert until < 0.2
    assert np.linalg.norm(away) / 3.0 < run.step_errors["position"] < 1e-3 * 0.3
