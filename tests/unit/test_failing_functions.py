"""Python functions of the user that fail: one message with the key or the owner, the place, and the exception."""

from __future__ import annotations

import pytest

import viscorod as vr

SECTION = vr.Rectangle(0.01, 0.01)
RUBBER = vr.Material(1e6, poissons_ratio=0.3, density=1000.0)
ENDS = (0, 0, 0), (0.3, 0, 0)


def fails(*_):
    raise LookupError("no data there")


def fails_away_from_zero(at):
    return 0.0 if at == 0.0 else fails()


def fails_later(t):
    return 0.0 if t < 0.02 else fails()


LATER = vr.FunctionOfTime(fails_later, fails_later, fails_later)


def rod(**given):
    return vr.Rod.straight(*ENDS, **{"section": SECTION, "material": RUBBER, "elements": 1} | given)


def beam(held=True):
    model = vr.Model()
    model.add("beam", rod())
    if held:
        model.clamp("beam.start")
    return model


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: rod(twist=fails), r"Rod\.twist: the function of the twist failed at s = 0 m"),
        (lambda: rod(tilt=fails), r"Rod\.tilt: the function of the tilt failed at s = 0 m"),
        (lambda: rod(section=fails), r"Rod\.section: the function of the section failed at s = 0 m"),
        (
            lambda: vr.Rod.curve(fails, section=SECTION, material=RUBBER),
            r"ParametricCurve\.function: the function of the curve failed at u = ",
        ),
        (
            lambda: vr.LineSpring("beam.end", (0, 0, 0), stiffness=fails),
            r"LineSpring\.stiffness: the function failed at 0",
        ),
    ],
)
def test_functions_of_parts_fail_where_the_part_is_made(make, said):
    with pytest.raises(vr.InputError, match=f"{said}.*LookupError: no data there"):
        make()


@pytest.mark.parametrize(
    ("add", "said"),
    [
        (
            lambda model: model.distributed_force("beam", fails),
            r"DistributedForce\.value: the function of the distributed_force along 'beam' failed at s = 0\.15 m",
        ),
        (
            lambda model: model.velocity("beam", field=fails),
            r"field: the function of the initial velocity of 'beam' failed at s = 0 m",
        ),
        (
            lambda model: model.strain("beam", fails),
            r"value: the function of the initial strain of 'beam' failed at s = 0\.0\d* m",
        ),
        (
            lambda model: model.rest_strain("beam", fails),
            r"value: the function of the rest strain of 'beam' failed at s = 0\.0\d* m",
        ),
        (
            lambda model: model.rest_strain("beam", lambda s, t: fails()),
            r"value: the function of the rest strain of 'beam' failed at s = 0\.0\d* m, t = 0 s",
        ),
        (
            lambda model: model.rest_strain("beam", (0, 0, 0, 1, 0, 0), time=fails),
            r"the time of the rest strain of 'beam': the function of time failed at t = 0 s",
        ),
        (
            lambda model: model.spring("beam.end", stiffness={"uy": fails_away_from_zero}),
            r"the stiffness uy of bushing beam\.end - ground failed at ",
        ),
        (
            lambda model: model.line_spring(
                "beam.end", (0.3, 0.1, 0), damping=fails_away_from_zero, stiffness=1
            ),
            r"the damping of line beam\.end - ground failed at ",
        ),
    ],
)
def test_functions_of_a_model_fail_with_their_owner(add, said):
    def loaded():
        model = beam()
        add(model)
        model.simulate(0.01, initial="reference")

    with pytest.raises(vr.InputError, match=f"{said}.*LookupError: no data there"):
        loaded()


def moved(model):
    model.support("beam.start", fixed=("ux", "uz", "rx", "ry", "rz"), motion={"uy": LATER})


def driven(model):
    model.body_velocity("beam.start", fixed=("v1", "v2", "v3", "w1", "w2"), velocity={"w3": LATER})


def turned(model):
    model.clamp("beam.start")
    model.add("arm", vr.Rod.straight((0.3, 0, 0), (0.6, 0, 0), section=SECTION, material=RUBBER, elements=1))
    model.revolute("beam.end", "arm.start", axis=(0, 0, 1), motion={"rz": LATER})


@pytest.mark.parametrize(
    ("add", "said"),
    [
        (moved, r"the motion uy of the support at beam\.start"),
        (driven, r"the velocity w3 of the body_velocity at beam\.start"),
        (turned, r"the motion rz of revolute beam\.end - arm\.start"),
    ],
)
def test_prescribed_motions_that_fail_name_what_they_move(add, said):
    model = beam(held=False)
    add(model)
    with pytest.raises(
        (vr.InputError, vr.SolveError),
        match=rf"{said}: the function of time failed at t = 0\.02\d* s: LookupError: no data there",
    ):
        model.simulate(0.05, initial="reference")


def test_what_is_no_section_or_point_is_shown():
    with pytest.raises(vr.InputError, match=r"Rod\.section: 0\.01: .* at s = 0 m: this is no section"):
        rod(section=lambda s: 0.01)
    with pytest.raises(
        vr.InputError, match=r"ParametricCurve\.function: 1\.0: the function of the curve gave"
    ):
        vr.Rod.curve(lambda u: 1.0, section=SECTION, material=RUBBER)


def test_a_named_function_of_time_is_the_same_function():
    named = LATER.of("the motion of something")
    assert named.value(0.01) == LATER.value(0.01)
    assert named.value_function is LATER.value_function


@pytest.mark.parametrize(
    "add",
    [
        lambda model, f: model.distributed_force("beam", f),
        lambda model, f: model.velocity("beam", field=f),
        lambda model, f: model.rest_strain("beam", f),
        lambda model, f: model.spring("beam.end", stiffness={"uz": f}),
        lambda model, f: model.add("other", rod(twist=f)),
    ],
)
def test_ctrl_c_in_a_function_of_place_is_ctrl_c(add):
    def interrupted(*_):
        raise KeyboardInterrupt

    def loaded():
        model = beam()
        add(model, interrupted)
        model.simulate(0.01, initial="reference")

    with pytest.raises(KeyboardInterrupt):
        loaded()


def test_what_a_function_of_the_section_makes_is_refused_as_ever():
    with pytest.raises(vr.InputError, match=r"Circle\.radius: -?0"):
        rod(section=lambda s: vr.Circle(0.01 - 0.04 * s))


def test_a_spring_that_fails_on_the_way_keeps_the_motion_up_to_there():
    """Its law is asked for at 0 before; what fails later ends the run."""

    def law(x):
        return 0.01 * x if abs(x) < 1e-4 else fails()

    model = beam()
    model.force("beam.end", (0, 0, 1e-4))
    model.spring("beam.end", stiffness={"uz": law})
    with pytest.raises(vr.SolveError, match=r"the stiffness uz of bushing .* failed") as caught:
        model.simulate(2.0, initial="reference")
    assert 0.0 < caught.value.run.time[-1] < 2.0
