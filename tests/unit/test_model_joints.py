"""Joints: what they leave free, in which axes, between what; what is refused."""

import re

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError
from viscorod.model.actions.time_function import Ramp, Sine, Until
from viscorod.model.bodies.body import Body
from viscorod.model.connections.axis_joint import Cylindrical, Planar, Prismatic, Revolute
from viscorod.model.connections.joint import JOINTS, Ball, Joint, Rigid, Universal, joint
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import BodyPlace, Place
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.sections.stiffness_section import StiffnessSection
from viscorod.solve.settings.checks import require_fit, unfit_for_steady
from viscorod.solve.settings.motion import SimulateSettings

MATRIX = StiffnessSection((1,) * 6, (1,) * 6)
AXIS = (0, 3, 4)
ENDS = ("arm.end", "leg.start")


def rod(start=(0, 0, 0), end=(2, 0, 0), **options):
    return Rod.straight(start, end, section=MATRIX, **options)


@pytest.fixture(name="model")
def _model():
    """Two rods that meet in (2, 0, 0) and a plate 1 m further along."""
    model = ModelDescription()
    model.add("arm", rod())
    model.add("leg", rod((2, 0, 0), (2, 1, 0)))
    model.add("plate", Body(2.0, (1, 1, 2), centre=(3, 0, 0), points={"corner": (2, 0, 0)}))
    model.clamp("plate")
    return model


def problems(model):
    with pytest.raises(InputError) as caught:
        model.validate()
    return caught.value.problems


def only_problem(model, where, *texts):
    (problem,) = problems(model)
    assert problem.where == where
    for text in texts:
        assert text in str(problem)
    assert problem.instead


@pytest.mark.parametrize(
    ("given", "free", "column"),
    [
        (Rigid(*ENDS), (), None),
        (Ball(*ENDS), ("rx", "ry", "rz"), None),
        (Revolute(*ENDS, AXIS), ("rz",), 2),
        (Universal(*ENDS, [AXIS, (1, 0, 0)]), ("rx", "ry"), 0),
        (Cylindrical(*ENDS, AXIS), ("uz", "rz"), 2),
        (Prismatic(*ENDS, AXIS), ("uz",), 2),
        (Planar(*ENDS, AXIS), ("ux", "uy", "rz"), 2),
        (Joint(*ENDS, free=["rz", "ux"], axes=[AXIS, (1, 0, 0)]), ("ux", "rz"), 0),
    ],
)
def test_kinds(given, free, column):
    assert given.free_motions() == free
    assert set(given.held_motions()) == set(MOTIONS) - set(free)
    frame = given.frame()
    assert frame.T @ frame == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(frame) == pytest.approx(1.0)
    if column is None:
        assert (frame == np.eye(3)).all()
    else:
        assert frame[:, column] == pytest.approx([0, 0.6, 0.8])
    assert given.label == f"{given.kind} arm.end - leg.start"
    assert JOINTS[given.kind] is type(given)
    assert joint(given.to_dict()) == given


def test_names_springs_and_motors():
    hinge = Revolute("arm.end", "ground", AXIS, name="hinge", stiffness={"rz": 2}, rest={"rz": 0.1})
    assert hinge.label == "hinge"
    assert (hinge.stiffness, hinge.rest, hinge.damping) == ({"rz": 2.0}, {"rz": 0.1}, {})
    assert joint(hinge.to_dict()) == hinge
    slider = Cylindrical(*ENDS, AXIS, motion={"uz": Ramp(0, 1)}, damping={"rz": lambda rate: rate**3})
    assert slider.motion["uz"].value(0.5) == 0.5
    assert slider.damping["rz"](2.0) == 8.0
    assert slider.to_dict()["damping"]["rz"].startswith("<Python function")
    assert Prismatic(*ENDS, AXIS, stiffness={"uz": -3.0}).stiffness == {"uz": -3.0}


def test_the_methods_of_a_model(model):
    model.rigid("arm.end", "leg.start", name="weld")
    model.ball("arm.start", "ground", axes=[(0, 1, 0), (0, 0, 1)], damping={"rx": 0.1})
    model.revolute("leg.end", "ground", AXIS, stiffness={"rz": 1.0}, rest={"rz": 0.1})
    model.universal("arm@0.5", "ground", [(1, 0, 0), (0, 1, 0)])
    model.cylindrical("arm@0.6", "ground", (1, 0, 0))
    model.prismatic("arm@0.7", "ground", (1, 0, 0), motion={"uz": Ramp(0, 1)})
    model.planar("arm@0.8", "ground", (0, 0, 1))
    model.joint("general", "arm@0.9", "plate", free=["rx"])
    model.joint("revolute", "leg@0.5", "plate", axis=(0, 0, 1), name="pivot")
    model.validate()
    assert [part.kind for part in model.joints] == [
        "rigid",
        "ball",
        "revolute",
        "universal",
        "cylindrical",
        "prismatic",
        "planar",
        "general",
        "revolute",
    ]
    assert model.joints[-1].label == "pivot"
    assert model.stations("arm") == (0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 2.0)
    assert model.stations("leg") == (0.0, 0.5, 1.0)
    again = ModelDescription.of(**model.parts())
    assert again.to_dict() == model.to_dict()
    assert len(again.to_dict()["joints"]) == 9


def test_resolved_joints(model):
    model.revolute("ground", "arm.start", (0, 0, 1), motion={"rz": Ramp(0, 1)})
    model.ball("plate", "arm.end", name="tip")
    model.prismatic("leg.end", "plate.corner", (0, 1, 0), stiffness={"uz": 3.0}, damping={"uz": 1.0})
    model.rigid("plate", "ground")
    model.validate()
    hinge, tip, slider, held = model.resolved_joints()
    assert (hinge.path, hinge.kind, hinge.label) == ("joints[0]", "revolute", "revolute ground - arm.start")
    assert (hinge.a, hinge.b, hinge.free) == (Place("arm", 0.0), None, ("rz",))
    assert hinge.held == ("ux", "uy", "uz", "rx", "ry")
    assert (hinge.at_a == hinge.at_b).all()
    assert list(hinge.motion) == ["rz"]
    assert (tip.a, tip.b) == (BodyPlace("plate"), Place("arm", 2.0))
    assert tip.at_a == pytest.approx([2, 0, 0])
    assert tip.gap == pytest.approx([0, 0, 0])
    assert slider.b == BodyPlace("plate", "corner")
    assert slider.at_a - slider.at_b == pytest.approx([0, 1, 0])
    assert slider.gap == pytest.approx([0, 0, 0])
    assert (slider.stiffness, slider.damping, slider.rest) == ({"uz": 3.0}, {"uz": 1.0}, {})
    assert held.at_a == pytest.approx([3, 0, 0])


def test_a_gap_along_held_motions(model):
    model.ball("leg.end", "plate.corner")
    model.validate()
    assert model.resolved_joints()[0].gap == pytest.approx([0, 1, 0])
    model.add("far", rod((5, 0, 0), (6, 0, 0)))
    model.ball("far.start", "arm.start")
    only_problem(model, "joints[1]", "5 m apart", "the longest rod (2 m)", "(5, 0, 0)", "(0, 0, 0)")
    model.joints.pop()
    model.prismatic("far.start", "arm.start", (1, 0, 0))
    model.validate()


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Revolute(*ENDS), "Revolute.axis", "missing"),
        (lambda: Revolute(*ENDS, (0, 0, 0)), "Revolute.axis", "no direction"),
        (lambda: Universal(*ENDS, [(1, 0, 0), (1, 1, 0)]), "Universal.axes", "not perpendicular"),
        (lambda: Universal("ground", "arm.end", [(1, 0, 0), (0, 1, 0)]), "Universal.a", "carried by a"),
        (lambda: Rigid("arm.end", "arm.end"), "Rigid.b", "joins two different things"),
        (lambda: Rigid("ground", "ground"), "Rigid.b", "the ground on one side only"),
        (lambda: Rigid("arm end", "ground"), "Rigid.a", 'or "ground"'),
        (lambda: Rigid("arm.end", "graund!"), "Rigid.b", "not a place"),
        (lambda: Rigid(*ENDS, name="a b"), "Rigid.name", "not usable as a name"),
        (lambda: Joint(*ENDS), "Joint.free", "missing"),
        (lambda: Joint(*ENDS, free=["ux", "rw"]), "Joint.free[1]", "not a motion"),
        (lambda: Joint(*ENDS, free=list(MOTIONS)), "Joint.free", "holds nothing"),
        (
            lambda: Revolute(*ENDS, AXIS, stiffness=3),
            "Revolute.stiffness",
            "table from motions to stiffnesses",
        ),
        (lambda: Revolute(*ENDS, AXIS, stiffness={"rzz": 3}), "Revolute.stiffness.rzz", "did you mean 'rz'"),
        (lambda: Revolute(*ENDS, AXIS, stiffness={"rz": np.nan}), "Revolute.stiffness.rz", "finite"),
        (
            lambda: Revolute(*ENDS, AXIS, stiffness={"rz": lambda x: "x"}),
            "Revolute.stiffness.rz",
            "the function gave this at 0",
        ),
        (lambda: Revolute(*ENDS, AXIS, damping={"rz": -1}), "Revolute.damping.rz", "negative damping"),
        (
            lambda: Revolute(*ENDS, AXIS, stiffness={"rx": 1}),
            "Revolute.stiffness.rx",
            "does not let go of rx; the motions that it leaves free are rz",
        ),
        (lambda: Rigid(*ENDS, damping={"rx": 1}), "Rigid.damping.rx", "use a joint that leaves it free"),
        (lambda: Revolute(*ENDS, AXIS, rest={"rz": 1}), "Revolute.rest.rz", "goes with a stiffness"),
        (lambda: Revolute(*ENDS, AXIS, motion={"ux": 1.0}), "Revolute.motion.ux", "does not let go of ux"),
        (lambda: Revolute(*ENDS, AXIS, motion={"rz": Until(1)}), "Revolute.motion.rz", "must not jump"),
        (
            lambda: Revolute(*ENDS, AXIS, motion={"rz": 1.0}, stiffness={"rz": 1}),
            "Revolute.motion.rz",
            "has no stiffness",
        ),
        (
            lambda: Revolute(*ENDS, AXIS, motion={"rz": 1.0}, damping={"rz": 1}),
            "Revolute.motion.rz",
            "has no damping",
        ),
        (lambda: joint({"kind": "hinge"}), "kind", "give one of 'general'"),
        (lambda: joint({"kind": "revolut", "a": "x", "b": "y"}), "kind", "did you mean 'revolute'"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=re.escape(text)) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_joints_between_what_does_not_exist(model):
    with pytest.raises(InputError, match=r"Ball\.a: 'amr'") as caught:
        model.ball("amr.end", "plate.cornr")
    assert len(caught.value.problems) == 2
    model.joints.append(vr.Ball("amr.end", "plate.cornr"))
    first, second = problems(model)
    assert (first.where, second.where) == ("joints[0].a", "joints[0].b")
    assert "did you mean 'arm'? the rods are arm, leg; the bodies are plate" in str(first)
    assert "did you mean plate.corner" in str(second)


def test_joints_of_one_thing(model):
    model.ball("plate", "plate.corner")
    only_problem(model, "joints[0]", "both sides of the joint are the same body")
    model.joints.clear()
    model.ball("arm.end", "arm@2.0")
    only_problem(model, "joints[0]", "both sides of the joint are the same place")


def test_joints_of_attached_places(model):
    model.attach("arm.end", "leg.start")
    model.attach("leg.start", "plate")
    model.revolute("arm.end", "plate", (0, 0, 1))
    only_problem(model, "joints[0]", "they are attached", "leave the attachment or the joint out")


def test_joints_between_two_centres_say_nowhere(model):
    model.add("lump", Body(1.0, (1, 1, 1)))
    model.ball("plate", "lump")
    only_problem(model, "joints[0]", "nothing says where the joint", "plate.tip")
    model.bodies["lump"] = Body(1.0, (1, 1, 1), centre=(3, 0, 0))
    model.validate()


def test_two_joints_of_the_same_places(model):
    model.revolute("arm.end", "leg.start", (0, 0, 1))
    model.ball("leg.start", "arm@2.0")
    only_problem(model, "joints[1]", "have a joint already, revolute arm.end - leg.start (joints[0])")


def test_names_are_given_once(model):
    model.ball("arm.end", "leg.start", name="knee")
    model.ball("leg.end", "ground", name="knee")
    only_problem(model, "joints[1].name", "joints[0] has this name already")


def test_a_joint_connects_a_body(model):
    model.supports.clear()
    only_problem(model, "bodies.plate", "connected to nothing")
    model.ball("plate", "arm.end")
    model.validate()


def test_initial_strains_and_joints(model):
    model.strain("arm", (0, 0, 0, 0, 0, 1))
    model.ball("arm.start", "ground")
    model.validate()
    model.ball("arm.end", "leg.start")
    only_problem(model, "strains[0].rod", "joints[1] holds arm.end")


def test_initial_strains_and_constraints():
    model = ModelDescription()
    model.add("arm", rod(constraints="kirchhoff"))
    model.strain("arm", (0, 0, 0, 0, 0, 1))
    model.validate()
    model.strains.clear()
    model.strain("arm", lambda s: (0, 0, 0.1 * s, 0, 0, 1))
    only_problem(model, "strains[0].value", "not zero where the rod's constraints hold it")


def unfit(model, **settings):
    with pytest.raises(InputError) as caught:
        require_fit(model, SimulateSettings(1.0, **settings))
    return {problem.where: str(problem) for problem in caught.value.problems}


def test_what_the_solver_will_not_do():
    model = ModelDescription()
    model.add("arm", rod(constraints=["unshearable"]))
    model.ball("arm.start", "ground")
    model.spring("arm.end", stiffness={"ux": 1.0})
    require_fit(model, SimulateSettings(1.0))
    require_fit(model, SimulateSettings(1.0, formulation="intrinsic"))
    linear = {"formulation": "intrinsic", "damping": "linearised", "dynamics": "linear"}
    require_fit(model, SimulateSettings(1.0, **linear))
    assert not list(unfit_for_steady(model, "geometric", "full"))
    steady = {problem.where: str(problem) for problem in unfit_for_steady(model, "intrinsic", "full")}
    assert set(steady) == {"joints[0]", "springs[0]"}
    assert "no joints, which hold positions" in steady["joints[0]"]
    model.joints.clear()
    model.revolute("arm.start", "ground", (0, 0, 1), motion={"rz": Sine(1.0, 1.0)}, name="hub")
    found = unfit(model, **linear)
    assert set(found) == {"joints[0].motion.rz"}
    assert "function of time" in found["joints[0].motion.rz"]
    model.joints.clear()
    model.revolute("arm.start", "ground", (0, 0, 1), damping={"rz": 1.0}, name="hub")
    steady = {problem.where: str(problem) for problem in unfit_for_steady(model, "geometric", "full")}
    assert "its damper would stand still" in steady["joints[0]"]
