"""Inputs that move supports or joints are refused in the same words by linear and by periodic analyses."""

import pytest

import viscorod as vr


def model():
    made = vr.Model()
    steel = vr.Material(210e9, 0.3, 7850.0, damping=vr.KelvinVoigt(1e-5, 1e-5))
    made.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=steel))
    return made


def response(made, source):
    return made.frequency_response(inputs=source, outputs=["beam@0.5 uz"], frequencies=[10.0])


def periodic(made, source):
    return made.periodic(inputs=source, amplitudes=[1e-4], outputs=["beam@0.5 uz"], frequencies=[10.0, 11.0])


@pytest.mark.parametrize("analysis", [response, periodic])
def test_only_what_is_held_can_be_moved(analysis):
    made = model()
    made.pin("beam.start")
    made.clamp("beam.end")
    for source, why in [
        ("beam@0.3 uz", "only supports and joints can be moved"),
        ("beam.start ry", "does not hold ry"),
    ]:
        with pytest.raises(vr.InputError, match=why):
            analysis(made, source)


@pytest.mark.parametrize("analysis", [response, periodic])
def test_axes_of_a_moving_section_are_no_axes_of_space(analysis):
    """A support of velocities holds those along d1, d2, d3: "uz" would move it along d3."""
    made = model()
    made.body_velocity("beam.start", ["v1", "v2", "v3", "w1", "w2", "w3"])
    for source in ("beam.start uz", "base uz"):
        with pytest.raises(vr.InputError, match="along axes of the section"):
            analysis(made, source)


@pytest.mark.parametrize("analysis", [response, periodic])
def test_joints_on_the_ground_do_not_move_with_supports(analysis):
    made = model()
    made.clamp("beam.start")
    made.spring("beam.end", "ground", stiffness={"uz": 10.0})
    with pytest.raises(vr.InputError, match="does not move with the supports"):
        analysis(made, "base uz")
