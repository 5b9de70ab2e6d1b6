"""Rigid bodies: mass, inertia, points; where they may stand in a model; what is refused."""

import math
import re

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError
from viscorod.model.bodies.body import Body, one_body
from viscorod.model.bodies.body_shapes import Box, Cylinder, Sphere
from viscorod.model.connections.place import BodyPlace, Place, find_place
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.sections.stiffness_section import StiffnessSection

MATRIX = StiffnessSection((1,) * 6, (1,) * 6)


def rod(start=(0, 0, 0), end=(2, 0, 0)):
    return Rod.straight(start, end, section=MATRIX)


@pytest.fixture(name="model")
def _model():
    """A rod that ends at a corner of a plate whose centre is 1 m further along."""
    model = ModelDescription()
    model.add("arm", rod())
    model.add("plate", Body(2.0, (1, 1, 2), centre=(3, 0, 0), points={"corner": (2, 0, 0), "far": (4, 0, 0)}))
    model.attach("arm.end", "plate")
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


def test_a_body_by_its_mass():
    body = Body(2.0, (1, 2, 3), axes=[(0, 1, 0), (0, 0, 1)])
    assert body.mass_matrix() == pytest.approx(np.diag([2, 2, 2, 1, 2, 3]))
    assert body.frame() == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]))
    full = [[2, 0.5, 0], [0.5, 2, 0], [0, 0, 3]]
    assert Body(1.0, full).inertia_matrix() == pytest.approx(np.array(full))
    assert Body(1.0, np.array(full)).frame() == pytest.approx(np.eye(3))
    assert one_body({"mass": 2.0, "inertia": [1, 2, 3]}) == Body(2.0, (1, 2, 3))


def test_shapes():
    box = Body.box((0, 0, 1), (1, 2, 3), 10.0, points={"tip": (0, 0, 2.5)})
    assert isinstance(box, Box)
    assert np.diag(box.mass_matrix()) == pytest.approx([60, 60, 60, 65, 50, 25])
    assert box.position() == pytest.approx([0, 0, 1])
    assert box.position("tip") == pytest.approx([0, 0, 2.5])
    ball = Body.sphere((0, 0, 0), 0.5, mass=2.0, axes=[(0, 1, 0), (0, 0, 1)])
    assert isinstance(ball, Sphere)
    assert np.diag(ball.inertia_matrix()) == pytest.approx([0.2] * 3)
    assert Body.sphere((0, 0, 0), 0.5, 3.0).total_mass() == pytest.approx(math.pi / 2)
    drum = Body.cylinder((0, 0, 0), (2, 0, 0), 1.0, 6.0, mass=4.0)
    assert isinstance(drum, Cylinder)
    assert np.diag(drum.inertia_matrix()) == pytest.approx([13, 13, 2])
    assert drum.frame()[:, 2] == pytest.approx([1, 0, 0])
    assert np.linalg.det(drum.frame()) == pytest.approx(1.0)
    assert Body.cylinder((0, 0, 0), (2, 0, 0), 1.0, 6.0, 2.0).total_mass() == pytest.approx(12 * math.pi)


def test_flat_and_turned_bodies_are_possible():
    Body(1.0, (0.1, 0.2, 0.3))
    turn = np.linalg.qr(np.array([[1.0, 2, 3], [4, 5, 6], [7, 8, 10]]))[0]
    body = Body(1.0, turn @ np.diag([0.1, 0.2, 0.3]) @ turn.T)
    assert np.linalg.eigvalsh(body.inertia_matrix()) == pytest.approx([0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    "body",
    [
        Body(2.0, (1, 2, 3), centre=(1, 2, 3), axes=[(0, 1, 0), (0, 0, 1)], points={"a": (1, 0, 0)}),
        Body(2.0, [[2, 0.5, 0], [0.5, 2, 0], [0, 0, 3]]),
        Body.box((0, 0, 1), (1, 2, 3), 10.0),
        Body.sphere((0, 0, 1), 1.0, mass=10.0),
        Body.cylinder((0, 0, 1), (1, 1, 0), 1.0, 2.0, 10.0),
    ],
)
def test_bodies_come_back_from_their_tables(body):
    assert one_body(body.to_dict()) == body
    assert one_body(body) is body


@pytest.mark.parametrize(
    ("build", "path", "text"),
    [
        (lambda: Body(0.0, (1, 1, 1)), "Body.mass", "> 0"),
        (lambda: Body(1.0), "Body.inertia", "missing"),
        (lambda: Body(1.0, (1, 1)), "Body.inertia", "2 items were given"),
        (lambda: Body(1.0, (1, 1, "x")), "Body.inertia[2]", "number"),
        (lambda: Body(1.0, [[1, 0, 0], [0, 1], [0, 0, 1]]), "Body.inertia[1]", "2 were given"),
        (lambda: Body(1.0, [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]), "Body.inertia", "row 1, column 2"),
        (lambda: Body(1.0, (1, 0, 0.5)), "Body.inertia", "1 > 0 + 0.5"),
        (lambda: Body(1.0, (0, 0, 1)), "Body.inertia", "1 > 0 + 0"),
        (lambda: Body(1.0, (-1, 1, 1)), "Body.inertia", "principal inertia -1 kg"),
        (lambda: Body(1.0, [[1, 2, 0], [2, 1, 0], [0, 0, 1]]), "Body.inertia", "principal inertia -1 kg"),
        (lambda: Body(1.0, (1, 3.5, 2)), "Body.inertia", "3.5 > 1 + 2"),
        (lambda: Body(1.0, (1, 1, 1), centre=(0, 0)), "Body.centre", "2 were given"),
        (lambda: Body(1.0, (1, 1, 1), axes=[(1, 0, 0)]), "Body.axes", "two directions"),
        (lambda: Body(1.0, (1, 1, 1), axes=[(1, 0, 0), (1, 1, 0)]), "Body.axes", "not perpendicular"),
        (
            lambda: Body(1.0, (1, 1, 1), axes=[(1, 0, 0), (0, 1, 0), (0, 0, -1)]),
            "Body.axes[2]",
            "first cross the second",
        ),
        (lambda: Body(1.0, (1, 1, 1), points=[(0, 0, 0)]), "Body.points", "table of named points"),
        (
            lambda: Body(1.0, (1, 1, 1), points={"a b": (0, 0, 0)}),
            "Body.points.'a b'",
            "not usable as a name",
        ),
        (lambda: Body(1.0, (1, 1, 1), points={"a": (0, "z", 0)}), "Body.points.a[1]", "number"),
        (lambda: Body(1.0, (1, 1, 1), pionts={}), "Body.pionts", "did you mean points"),
        (lambda: Box((1, 1, 1)), "Box.density", "either a density or a mass"),
        (lambda: Box((1, 1, 1), density=1.0, mass=1.0), "Box.density", "both"),
        (lambda: Box((1, 0, 1), mass=1.0), "Box.sides[1]", "> 0"),
        (lambda: Sphere(1e-59, density=1e-59), "Sphere", "double precision"),
        (lambda: Cylinder(1.0, 1.0, (0, 0, 0), mass=1.0), "Cylinder.axis", "no direction"),
        (lambda: one_body({"shape": "bx"}), "shape", "did you mean 'box'"),
    ],
)
def test_refused(build, path, text):
    with pytest.raises(InputError, match=re.escape(text)) as caught:
        build()
    (problem,) = caught.value.problems
    assert problem.where == path
    assert problem.instead


def test_places_on_bodies(model):
    assert model.place("plate") == BodyPlace("plate")
    assert model.place("plate.corner") == BodyPlace("plate", "corner")
    assert (str(model.place("plate")), str(model.place("plate.corner"))) == ("plate", "plate.corner")
    assert model.position_of("plate") == pytest.approx([3, 0, 0])
    assert model.position_of("plate.far") == pytest.approx([4, 0, 0])
    assert model.position_of("arm@0.5") == pytest.approx([0.5, 0, 0])
    assert find_place("arm.end", model.rods) == Place("arm", 2.0)


@pytest.mark.parametrize(
    ("at", "text"),
    [
        ("plat", "no rod or body of this name; did you mean 'plate'? the rods are arm; the bodies are plate"),
        ("plate.conrer", "no point of this name; did you mean plate.corner? its points are corner, far"),
        ("plate@0.1", "a rigid body has no arc length"),
        ("arm", 'a rod is not a place; give "arm.start"'),
        ("arm.corner", "a rod has no such point"),
        ("arm@3", "only 2 m long"),
    ],
)
def test_places_that_are_none(model, at, text):
    with pytest.raises(InputError, match=rf"Force\.at: .*{re.escape(text)}"):
        model.force(at, (1, 0, 0))
    model.loads.append(vr.Force(at, (1, 0, 0)))
    only_problem(model, "loads[0].at", text)
    with pytest.raises(InputError):
        model.position_of(at)


def test_a_point_of_a_body_without_points(model):
    model.add("lump", Body(1.0, (1, 1, 1)))
    with pytest.raises(InputError, match=r"Clamp\.at: .*name it in the points of lump"):
        model.clamp("lump.tip")
    model.supports.append(vr.Clamp("lump.tip"))
    only_problem(model, "supports[0].at", "name it in the points of lump")


def test_names_are_shared_by_rods_and_bodies(model):
    with pytest.raises(InputError, match=r"rods\.plate: 'plate': there is already a rigid body"):
        model.add("plate", rod())
    with pytest.raises(InputError, match=r"bodies\.arm: 'arm': there is already a rod"):
        model.add("arm", Body(1.0, (1, 1, 1)))
    with pytest.raises(
        InputError, match=r"bodies\.ground: 'ground': this word stands for what does not move"
    ):
        model.add("ground", Body(1.0, (1, 1, 1)))
    with pytest.raises(InputError, match=r"bodies: 'a b': not usable"):
        model.add("a b", Body(1.0, (1, 1, 1)))


def test_a_model_of_bodies_only():
    """They may fly; what is empty is refused."""
    model = ModelDescription()
    only_problem(model, "rods", "no rod and no body")
    model.add("plate", Body(1.0, (1, 1, 1)))
    model.validate()


def test_loads_supports_and_velocities_of_bodies(model):
    model.force("plate.far", (1, 0, 0), following=True)
    model.moment("plate", (1, 0, 0))
    model.roller("plate", (0, 0, 1))
    model.support("plate", ["rx"], frame="node")
    model.clamp("arm.start")
    model.velocity("plate", angular=(0, 0, 1))
    model.validate()
    place = model.resolved_supports()[0].place
    assert place == BodyPlace("plate")
    assert model.nodes() == [(Place("arm", 2.0), BodyPlace("plate"))]
    assert model.velocities[0].at(0.0, model.position_of("plate"))[0] == pytest.approx([0, 3, 0])
    again = ModelDescription.of(**model.parts())
    assert again.to_dict() == model.to_dict()
    assert list(again.bodies) == ["plate"]


def test_a_point_beside_the_centre_is_clamped_or_not_supported(model):
    model.clamp("plate.corner")
    model.validate()
    model.supports.clear()
    model.pin("plate.corner")
    only_problem(model, "supports[0].at", "support the body at its centre, 'plate', or use a joint to ground")
    model.supports.clear()
    model.clamp("plate.corner", motion={"ux": 0.1})
    only_problem(model, "supports[0].at", "can be clamped only")


def test_supports_of_one_rigid_piece(model):
    model.roller("plate", (0, 0, 1))
    model.roller("arm.end", (0, 0, 1))
    model.validate()
    model.support("plate", ["rx"])
    model.support("arm.end", ["rx"])
    only_problem(model, "supports[3].at", "both hold rx of the same node")


@pytest.mark.parametrize(
    "load",
    [
        vr.DistributedForce("plate", (0, 0, 1)),
        vr.DistributedMoment("plate", (0, 0, 1)),
        vr.MovingForce("plate", (0, 0, 1), speed=1.0),
    ],
)
def test_loads_along_rods_only(model, load):
    model.loads.append(load)
    only_problem(model, "loads[0].rod", "acts along a rod", "a force or moment at 'plate'", "arm")


def test_wrong_velocities_and_strains_of_bodies(model):
    model.velocity("plate", field=lambda s: ((0, 0, 0), (0, 0, 0)))
    model.velocity("plate")
    with pytest.raises(InputError, match=r"InitialVelocity\.rod: 'plat'.*did you mean 'plate'"):
        model.velocity("plat")
    with pytest.raises(InputError, match=r"InitialStrain\.rod: 'plate'.*a rod is needed here"):
        model.strain("plate", (0,) * 6)
    model.velocities.append(vr.InitialVelocity("plat"))
    model.strains.append(vr.InitialStrain("plate", (0,) * 6))
    found = {problem.where: str(problem) for problem in problems(model)}
    assert set(found) == {"velocities[0].field", "velocities[1].rod", "velocities[2].rod", "strains[0].rod"}
    assert "the body has its initial velocity already" in found["velocities[1].rod"]
    assert "did you mean 'plate'" in found["velocities[2].rod"]
    assert "a rod is needed here" in found["strains[0].rod"]


def test_a_body_that_nothing_connects(model):
    model.add("lump", Body(1.0, (1, 1, 1)))
    model.force("lump", (1, 0, 0))
    only_problem(model, "bodies.lump", "connected to nothing")
    model.clamp("lump")
    model.validate()


def test_attachments_to_points_must_coincide(model):
    model.attachments.clear()
    model.attach("arm.end", "plate.corner")
    model.validate()
    model.attachments.clear()
    model.attach("arm.start", "plate.corner")
    only_problem(model, "attachments[0]", "the gap is 2 m", "attach the rod to 'plate'")


def test_attachments_twice_to_one_body(model):
    model.attach("plate.corner", "arm.end")
    only_problem(model, "attachments[1]", "attached already")


def test_bodies_may_be_attached_to_bodies_or_to_one_place(model):
    model.add("lump", Body(1.0, (0, 0, 0)))
    model.attach("plate", "lump")
    model.validate()
    model.attachments.pop()
    model.attach("lump", "arm.end")
    model.validate()
    model.ball("lump", "plate")
    only_problem(model, "joints[0]", "they are attached")


def test_round_off_of_an_inertia_matrix():
    tensor = [[2.0, 1e-17, 0.0], [-3e-17, 2.0, 0.0], [0.0, 0.0, 3.0]]
    assert Body(1.0, tensor).inertia_matrix()[0, 1] == pytest.approx(-1e-17)


def test_a_rod_may_have_both_ends_on_one_body(model):
    model.attach("arm.start", "plate")
    model.validate()
    assert set(model.nodes()[0]) == {Place("arm", 0.0), Place("arm", 2.0), BodyPlace("plate")}
