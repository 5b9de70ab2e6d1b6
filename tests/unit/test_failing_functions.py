"""Functions of the user that fail: one message with what it is, where it failed, and the exception."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import viscorod as vr

RUBBER = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
SECTION = vr.Circle(0.01)
START, END = (0, 0, 0), (1, 0, 0)


def beam(rod: vr.Rod | None = None) -> vr.Model:
    model = vr.Model()
    model.add("beam", rod or vr.Rod.straight(START, END, section=SECTION, material=RUBBER, elements=2))
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, 1e-4))
    return model


def with_rod(**given: object) -> vr.Model:
    return beam(
        vr.Rod.straight(START, END, **{"section": SECTION, "material": RUBBER, "elements": 2} | given)
    )


def with_call(method: str, *args: object, **given: object) -> vr.Model:
    model = beam()
    getattr(model, method)(*args, **given)
    return model


def at_rest(model: vr.Model) -> object:
    return model.equilibrium()


def moving(model: vr.Model) -> object:
    return model.simulate(0.01, initial="reference")


CALLS: dict[str, tuple[Callable[[Callable[..., object]], vr.Model], Callable[[vr.Model], object]]] = {
    "the section": (lambda f: with_rod(section=f), at_rest),
    "the twist": (lambda f: with_rod(twist=f), at_rest),
    "the tilt": (lambda f: with_rod(tilt=f), at_rest),
    "the centre line": (
        lambda f: beam(vr.Rod.curve(f, section=SECTION, material=RUBBER, elements=2)),
        at_rest,
    ),
    "the load": (lambda f: with_call("distributed_force", "beam", f), at_rest),
    "the rest strain": (lambda f: with_call("rest_strain", "beam", f), at_rest),
    "the initial strain": (lambda f: with_call("strain", "beam", f), moving),
    "the initial velocity": (lambda f: with_call("velocity", "beam", field=f), moving),
    "the spring": (lambda f: with_call("spring", "beam.end", stiffness={"uz": f}), at_rest),
}


@pytest.mark.parametrize("what", CALLS)
def test_a_function_of_place_that_fails_is_one_message(what: str) -> None:
    build, analysis = CALLS[what]

    def failing(_x: float) -> float:
        raise KeyError("chord")

    with pytest.raises(vr.InputError, match=f"the function of {what} failed at .*KeyError: 'chord'"):
        analysis(build(failing))


@pytest.mark.parametrize("what", CALLS)
def test_ctrl_c_in_a_function_of_place_is_ctrl_c(what: str) -> None:
    build, analysis = CALLS[what]

    def interrupted(_x: float) -> float:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        analysis(build(interrupted))


def test_what_a_function_of_the_section_makes_is_refused_as_ever() -> None:
    with pytest.raises(vr.InputError, match=r"Circle\.radius: -?0"):
        at_rest(with_rod(section=lambda s: vr.Circle(0.01 - 0.02 * s)))


def test_a_spring_that_fails_on_the_way_keeps_the_motion_up_to_there() -> None:
    """Its law is asked for at 0 before; what fails later ends the run."""

    def law(x: float) -> float:
        return 0.01 * x if abs(x) < 1e-4 else 1 / 0

    model = with_call("spring", "beam.end", stiffness={"uz": law})
    with pytest.raises(vr.SolveError, match="the function of the spring failed") as caught:
        model.simulate(2.0, initial="reference")
    assert 0.0 < caught.value.run.time[-1] < 2.0
