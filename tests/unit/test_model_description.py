"""The model as a whole: places, joints, clashes, and what is told when the parts do not fit."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.errors import InputError
from viscorod.model.actions.time_function import Ramp
from viscorod.model.connections.place import Place
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.stiffness_section import StiffnessSection

MATRIX = StiffnessSection((1,) * 6, (1,) * 6)


def rod(start=(0, 0, 0), end=(2, 0, 0), section=MATRIX):
    return Rod.straight(start, end, section=section)


@pytest.fixture(name="model")
def _model():
    """Two rods that meet at a right angle in (2, 0, 0)."""
    model = ModelDescription()
    model.add("arm", rod())
    model.add("leg", rod((2, 0, 0), (2, 1, 0)))
    model.attach("arm.end", "leg.start")
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


def test_places(model):
    assert model.place("arm.start") == Place("arm", 0.0)
    assert model.place("leg.end") == Place("leg", 1.0)
    assert model.place("arm@1.5") == Place("arm", 1.5)
    assert model.place("arm@2.0000000001") == Place("arm", 2.0)
    assert model.place("arm@1e-12") == Place("arm", 0.0)


def test_a_whole_model_validates_and_comes_back_as_a_table(model):
    model.clamp("arm.start", motion={"rz": Ramp(0, 1)})
    model.roller("leg.end", (0, 0, 1))
    model.force("arm@0.5", (1, 2, 3), True)
    model.moment("leg.end", (1, 2, 3), until=1.0)
    model.distributed_force("arm", (0, 0, 1), from_s=0.25, to_s=1.25)
    model.distributed_moment("leg", lambda s: (0, 0, s))
    model.moving_force("leg", (0, 0, 1), speed=2.0)
    model.gravity()
    model.velocity("arm", angular=(0, 0, 1))
    model.validate()
    assert model.stations("arm") == (0.0, 0.25, 0.5, 1.25, 2.0)
    assert model.stations("leg") == (0.0, 1.0)
    assert model.nodes() == [(Place("arm", 2.0), Place("leg", 0.0))]
    table = model.to_dict()
    assert table["supports"][0] == {
        "kind": "clamp",
        "at": "arm.start",
        "motion": {"rz": {"kind": "ramp", "start": 0.0, "end": 1.0}},
    }
    assert [load["kind"] for load in table["loads"]] == [
        "force",
        "moment",
        "distributed_force",
        "distributed_moment",
        "moving_force",
        "gravity",
    ]
    assert table["loads"][3]["value"].startswith("<Python function")
    assert table["attachments"] == [{"a": "arm.end", "b": "leg.start"}]


def test_resolved_supports(model):
    model.clamp("arm.start")
    model.support("leg.end", ["ux"], frame="node")
    clamp, node = model.resolved_supports()
    assert (clamp.place, clamp.path) == (Place("arm", 0.0), "supports[0]")
    assert node.axes[:, 2] == pytest.approx([0, 1, 0])
    assert node.label == "support at leg.end"


def test_attachments_join_transitively(model):
    model.add("up", rod((2, 0, 0), (2, 0, 1)))
    model.add("far", rod((0, 0, 0), (0, 0, 1)))
    model.attach("up.start", "leg.start")
    model.attach("far.start", "arm.start")
    model.attach("arm.end", "up.start")
    model.validate()
    first, second = model.nodes()
    assert set(first) == {Place("far", 0.0), Place("arm", 0.0)} or set(second) == {
        Place("far", 0.0),
        Place("arm", 0.0),
    }
    assert {len(first), len(second)} == {2, 3}


def test_section_breaks_are_stations():
    model = ModelDescription()
    model.add("arm", rod(section=Piecewise([(0.5, MATRIX), (2.0, MATRIX)])))
    assert model.stations("arm") == (0.0, 0.5, 2.0)


def test_parts_make_the_same_model(model):
    class Other(ModelDescription):
        pass

    model.clamp("arm.start")
    other = Other.of(model.rods, model.supports, model.loads, model.attachments, model.velocities)
    assert isinstance(other, Other)
    assert other.to_dict() == model.to_dict()


def test_no_rods():
    only_problem(ModelDescription(), "rods", "no rod")


def test_names_of_rods(model):
    with pytest.raises(InputError, match=r"rods\.arm: 'arm': there is already a rod"):
        model.add("arm", rod())
    with pytest.raises(InputError, match=r"rods: 'an arm': not usable as a name"):
        model.add("an arm", rod())
    with pytest.raises(InputError, match="this is not a rod"):
        model.add("third", MATRIX)


def test_a_load_on_a_place_that_does_not_exist(model):
    with pytest.raises(InputError, match=r"Force\.at: 'amr': .*did you mean 'arm'\?"):
        model.force("amr.end", (1, 0, 0))
    assert not model.loads
    model.loads.append(vr.Force("amr.end", (1, 0, 0)))
    only_problem(model, "loads[0].at", "'amr'", "did you mean 'arm'?", "arm, leg")


def test_a_station_beyond_the_end(model):
    with pytest.raises(InputError, match=r"Moment\.at: .*only 2 m long"):
        model.moment("arm@2.5", (1, 0, 0))
    model.loads.append(vr.Moment("arm@2.5", (1, 0, 0)))
    only_problem(model, "loads[0].at", "only 2 m long", "0 to 2")


def test_a_support_on_a_rod_that_does_not_exist(model):
    with pytest.raises(InputError, match=r"Pin\.at: .*did you mean 'leg'\?"):
        model.pin("legs.end")
    model.supports.append(vr.Pin("legs.end"))
    only_problem(model, "supports[0].at", "did you mean 'leg'?")


def test_distributed_loads_need_their_rod_and_their_span(model):
    with pytest.raises(InputError, match=r"DistributedForce\.to_s"):
        model.distributed_force("arm", (1, 0, 0), to_s=2.5)
    model.loads += [
        vr.DistributedForce("am", (1, 0, 0)),
        vr.DistributedForce("arm", (1, 0, 0), to_s=2.5),
        vr.DistributedForce("arm", lambda s: (1, 0)),
        vr.MovingForce("legg", (1, 0, 0), speed=1.0),
    ]
    paths = [problem.where for problem in problems(model)]
    assert paths == ["loads[0].rod", "loads[1].to_s", "loads[2].value", "loads[3].rod"]


def test_attached_places_must_coincide(model):
    model.attach("arm.start", "leg.end")
    only_problem(model, "attachments[1]", "gap is 2.23607 m", "(0, 0, 0)", "(2, 1, 0)")


def test_attachments_within_a_millionth_are_accepted():
    model = ModelDescription()
    model.add("arm", rod())
    model.add("leg", rod((2, 1e-6, 0), (2, 1, 0)))
    model.attach("arm.end", "leg.start")
    model.validate()


def test_attachments_twice_and_to_itself(model):
    model.attach("leg.start", "arm.end")
    only_problem(model, "attachments[1]", "attached already")
    with pytest.raises(InputError, match="to itself"):
        model.attach("arm.end", "arm.end")
    del model.attachments[:]
    model.attach("arm.end", "arm@2.0")
    only_problem(model, "attachments[0]", "to itself")


def test_a_rod_may_close_on_itself():
    model = ModelDescription()
    model.add("ring", Rod.helix(1.0, 0.0, 1.0, section=MATRIX))
    model.attach("ring.start", "ring.end")
    model.validate()


def test_supports_that_clash_at_one_place(model):
    model.clamp("arm.start")
    model.pin("arm.start")
    only_problem(model, "supports[1].at", "pin at arm.start", "clamp at arm.start", "ux, uy, uz")


def test_supports_that_clash_through_an_attachment(model):
    model.support("arm.end", ["ux", "rz"])
    model.support("leg.start", ["uy", "rz"])
    only_problem(model, "supports[1].at", "both hold rz")


def test_a_prescribed_motion_clashes_as_well(model):
    model.pin("arm.start")
    model.support("arm.start", ["rx"], motion={"uz": Ramp(0, 1)})
    only_problem(model, "supports[1].at", "both hold uz")


def test_clashes_in_different_axes_are_found_by_rank(model):
    model.support("arm.start", ["ux", "uy"])
    model.roller("arm.start", (0, 0, 1))
    model.validate()
    model.roller("leg.end", (1, 1, 0))
    model.support("leg.end", ["ux"])
    model.support("leg.end", ["rx"])
    model.validate()
    model.roller("arm.start", (1, 1, 0))
    only_problem(model, "supports[5].at", "roller at arm.start", "both hold a displacement")


def test_supports_that_share_a_node_without_clashing(model):
    model.support("arm.end", ["ux", "uy"])
    model.support("leg.start", ["uz", "rz"])
    model.validate()


def test_one_initial_velocity_for_each_rod(model):
    model.velocity("arm", (1, 0, 0))
    model.velocity("leg", field=lambda s: (np.zeros(3), np.zeros(3)))
    model.validate()
    model.velocity("arm")
    model.velocities.append(vr.InitialVelocity("amr"))
    first, second = problems(model)
    assert (first.where, second.where) == ("velocities[2].rod", "velocities[3].rod")
    assert "velocities[0]" in first.why


def test_everything_that_is_wrong_is_told_at_once(model):
    model.supports.append(vr.Clamp("x.start"))
    model.loads.append(vr.Force("y.end", (1, 0, 0)))
    model.velocities.append(vr.InitialVelocity("z"))
    with pytest.raises(InputError, match="3 problems") as caught:
        model.validate()
    assert str(caught.value).count("\n  - ") == 3


def test_methods_refuse_wrong_values_at_once(model):
    with pytest.raises(InputError, match=r"Force\.value"):
        model.force("arm.end", (1, 2))
    with pytest.raises(InputError, match=r"Clamp\.at"):
        model.clamp("arm@middle")
    with pytest.raises(InputError, match=r"Roller\.normal"):
        model.roller("arm.end", (0, 0, 0))
    assert not model.loads
    assert not model.supports
