"""Springs: what they act along, between what; what is refused."""

import re

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError
from viscorod.model.bodies.body import Body
from viscorod.model.connections.place import BodyPlace, Place
from viscorod.model.connections.spring import LineSpring, Spring, spring
from viscorod.model.connections.spring_laws import law_value
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.sections.stiffness_section import StiffnessSection

MATRIX = StiffnessSection((1,) * 6, (1,) * 6)


@pytest.fixture(name="model")
def _model():
    """A rod and a plate above its end."""
    model = ModelDescription()
    model.add("arm", Rod.straight((0, 0, 0), (2, 0, 0), section=MATRIX))
    model.add(
        "plate", Body(2.0, (1, 1, 2), centre=(2, 0, 1), points={"corner": (2, 0, 0.5), "low": (2, 0, 0)})
    )
    model.clamp("plate")
    return model


def only_problem(model, where, *texts):
    with pytest.raises(InputError) as caught:
        model.validate()
    (problem,) = caught.value.problems
    assert problem.where == where
    for text in texts:
        assert text in str(problem)
    assert problem.instead


def test_bushings(model):
    model.spring("arm.end", stiffness={"rz": 2, "ux": 3}, damping={"ux": 1}, rest={"ux": 0.1})
    model.spring("arm@0.5", "plate", {"uz": lambda x: x**3}, axes=[(0, 1, 0), (0, 0, 1)], name="soft")
    model.spring("plate", "ground", damping={"ux": 1})
    model.validate()
    first, second, third = model.resolved_springs()
    assert (first.path, first.kind, first.label) == ("springs[0]", "bushing", "bushing arm.end - ground")
    assert (first.a, first.b) == (Place("arm", 2.0), None)
    assert list(first.stiffness) == ["ux", "rz"]
    assert (first.damping, first.rest, first.length) == ({"ux": 1.0}, {"ux": 0.1}, 0.0)
    assert (second.label, second.b) == ("soft", BodyPlace("plate"))
    assert second.at_a == pytest.approx([0.5, 0, 0])
    assert second.at_b == pytest.approx([0.5, 0, 0])
    assert second.frame[:, 0] == pytest.approx([0, 1, 0])
    assert law_value(second.stiffness["uz"], 2.0) == 8.0
    assert law_value(3.0, 2.0) == 6.0
    assert third.at_a == pytest.approx([2, 0, 1])
    assert model.stations("arm") == (0.0, 0.5, 2.0)
    again = ModelDescription.of(**model.parts())
    assert again.to_dict() == model.to_dict()


def test_line_springs(model):
    model.line_spring("arm.end", "plate", 10.0, 0.5)
    model.line_spring("arm.start", (0, 0, 2), lambda x: 4 * x, length=1.5, name="stay")
    model.validate()
    first, second = model.resolved_springs()
    assert first.label == "line arm.end - plate"
    assert (first.stiffness, first.damping, first.length) == ({"ux": 10.0}, {"ux": 0.5}, 1.0)
    assert first.at_b == pytest.approx([2, 0, 1])
    assert (second.b, second.length, second.damping) == (None, 1.5, {})
    assert second.at_b == pytest.approx([0, 0, 2])
    assert model.springs[1].ends == ("arm.start", "ground")


@pytest.mark.parametrize(
    "given",
    [
        Spring("arm.end", stiffness={"ux": 1.0}),
        Spring("arm.end", "plate.corner", {"ux": 1.0}, {"ux": 2.0}, {"ux": 0.1}, [(0, 1, 0), (0, 0, 1)]),
        LineSpring("arm.end", "plate", 1.0, 2.0, 0.1, name="stay"),
        LineSpring("arm.end", np.array([1.0, 2.0, 3.0]), damping=2.0),
    ],
)
def test_springs_come_back_from_their_tables(given):
    assert spring(given.to_dict()) == given


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Spring("arm.end"), "Spring.stiffness", "does nothing"),
        (lambda: Spring("ground", "arm.end", {"ux": 1}), "Spring.at", "the ground is not a place"),
        (lambda: Spring("arm.end", "arm.end", {"ux": 1}), "Spring.to", "two different things"),
        (lambda: Spring("arm.end", stiffness={"x": 1}), "Spring.stiffness.x", "not a motion"),
        (lambda: Spring("arm.end", stiffness={"ux": "1"}), "Spring.stiffness.ux", "in quotes has no unit"),
        (lambda: Spring("arm.end", damping={"ux": -1}), "Spring.damping.ux", "negative damping"),
        (
            lambda: Spring("arm.end", damping={"ux": lambda rate: np.inf}),
            "Spring.damping.ux",
            "return a finite number",
        ),
        (lambda: Spring("arm.end", damping={"ux": 1}, rest={"ux": 1}), "Spring.rest.ux", "with a stiffness"),
        (lambda: Spring("arm.end", damping={"ux": 1}, axes=[(1, 0, 0)]), "Spring.axes", "two directions"),
        (lambda: LineSpring("arm.end", "plate"), "LineSpring.stiffness", "does nothing"),
        (lambda: LineSpring("arm.end", stiffness=1.0), "LineSpring.to", "missing"),
        (lambda: LineSpring("arm.end", "ground", 1.0), "LineSpring.to", "a point fixed in space"),
        (lambda: LineSpring("arm.end", "a b", 1.0), "LineSpring.to", "not a place"),
        (lambda: LineSpring("arm.end", (1, 2), 1.0), "LineSpring.to", "2 were given"),
        (lambda: LineSpring("arm.end", 3, 1.0), "LineSpring.to", "neither a place nor a point"),
        (lambda: LineSpring("arm.end", "arm.end", 1.0), "LineSpring.to", "two different things"),
        (lambda: LineSpring("arm.end", "plate", 1.0, -1.0), "LineSpring.damping", "negative damping"),
        (lambda: LineSpring("arm.end", "plate", 1.0, length=0), "LineSpring.length", "> 0"),
        (lambda: spring({"kind": "lin", "at": "x"}), "kind", "did you mean 'line'"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=re.escape(text)) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_springs_between_what_does_not_exist(model):
    with pytest.raises(InputError, match=r"LineSpring\.to: 'palte'.*did you mean 'plate'"):
        model.line_spring("arm.end", "palte", 1.0)
    model.springs.append(vr.LineSpring("arm.end", "palte", 1.0))
    only_problem(model, "springs[0].to", "did you mean 'plate'")


def test_springs_of_one_thing(model):
    model.line_spring("plate.corner", "plate", 1.0)
    only_problem(model, "springs[0]", "both sides of the spring are the same body")
    model.springs.clear()
    model.attach("arm.end", "plate")
    model.spring("arm.end", "plate", {"ux": 1})
    only_problem(model, "springs[0]", "leave the attachment or the spring out")


def test_a_line_needs_two_ends_that_are_apart(model):
    model.line_spring("arm.end", "plate.low", 1.0)
    only_problem(model, "springs[0]", "no direction", "(2, 0, 0)")
    model.springs.clear()
    model.line_spring("arm.end", (2, 0, 0), 1.0)
    only_problem(model, "springs[0]", "no direction", "kind 'bushing'")


def test_a_bushing_between_two_centres_is_nowhere(model):
    model.add("lump", Body(1.0, (1, 1, 1)))
    model.spring("plate", "lump", {"ux": 1})
    only_problem(model, "springs[0]", "nothing says where the spring")
    model.springs.clear()
    model.line_spring("plate", "lump", 1.0)
    model.validate()


def test_names_are_shared_with_joints(model):
    model.ball("arm.start", "ground", name="root")
    model.spring("arm.end", stiffness={"ux": 1}, name="root")
    only_problem(model, "springs[0].name", "joints[0] has this name already")
