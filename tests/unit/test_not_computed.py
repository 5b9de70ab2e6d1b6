"""What nobody reads of a result is not made: members of sweeps are asked for numbers, not for their case as text."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import viscorod as vr
from helpers.strip import content
from viscorod.analyses import provenance
from viscorod.casefile.case import case_from_dict
from viscorod.mechanics.rotations.quaternion import product
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.late_attributes import LateAttributes, Later
from viscorod.results.state_arrays import StateArrays
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics import node_turns

TIP = ("displacement", "beam.end", "y", "last")
ASKED = {
    "equilibrium": ({}, TIP),
    "simulate": ({"duration": 0.05}, TIP),
    "modes": ({"count": 2}, ("frequency", 1)),
    "steady": ({"spin": [0.0, 0.0, 1.0]}, ("displacement", "beam.end", "x", "last")),
}
MODULUS = "materials.rubber.youngs_modulus"


@pytest.mark.parametrize("kind", ASKED)
def test_members_of_which_a_number_is_asked_have_no_text_and_no_data_set(monkeypatch, kind):
    settings, words = ASKED[kind]
    strip = content(kind, **settings)
    if kind == "steady":
        del strip["loads"]
    made = []

    def counted(owner, name):
        own = getattr(owner, name)
        monkeypatch.setattr(owner, name, lambda *given, **named: (made.append(name), own(*given, **named))[1])

    counted(ModelDescription, "to_dict")
    counted(provenance, "material_record")
    counted(StateArrays, "data_set")
    case = case_from_dict(strip)
    values = {MODULUS: [1e6, 2e6]}
    asked = vr.sweep(case, values, quantities={"asked": words}, workers=1, errors=0)
    assert len(asked.completed) == 2
    assert not made
    whole = vr.sweep(case, values, quantities={"asked": words}, workers=1, errors=0, fields=True)
    for member in whole.members:
        attrs = member.result.data.attrs
        known = json.loads(attrs["case"])["rods"]["beam"]["material"]
        assert known["youngs_modulus"] == member.values[MODULUS]
        # tau of bending, as the times of shear and bulk are the same
        assert json.loads(attrs["damping_laws"])["beam"]["times"][3] == pytest.approx(0.02, rel=1e-12)
    assert set(made) == {"to_dict", "material_record", "data_set"}
    np.testing.assert_array_equal(asked.table()["asked"], whole.table()["asked"])


def test_a_result_tells_of_the_model_as_it_was():
    """The model changes between the computation and the first look at where the result comes from."""
    section, rubber = vr.Circle(0.01), vr.Material(1e6, 0.3, 1000.0)
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=rubber))
    model.clamp("bar.start")
    model.force("bar.end", (0, 1e-3, 0))
    found = [model.equilibrium(), model.simulate(0.01), model.modes(2)]
    coupled = model.co_simulation(["bar.end"])
    model.remove("bar")
    stiff = rubber.replaced(youngs_modulus=2e6)
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=stiff))
    model.loads.clear()
    coupled.step(0.01)
    for one in (*found, coupled.run()):
        case = json.loads(one.data.attrs["case"])
        assert case["rods"]["bar"]["material"]["youngs_modulus"] == 1e6
        assert len(case["loads"]) == 1


def test_attributes_are_made_by_name():
    made = []

    def maker(word, **values):
        return Later(tuple(values), lambda: (made.append(word), values)[1])

    found = LateAttributes({"a": 1, "b": 1}, maker("first", c=1, d=1))
    assert found["a"] == 1
    assert found.get("e") is None
    assert not made
    joined = {"a": 0, "z": 0} | found | {"b": 2} | LateAttributes({}, maker("second", a=3))
    assert joined["b"] == 2
    assert not made
    assert joined["a"] == 3  # the right one counts, though it is made later
    assert made == ["second"]
    assert dict(joined) == {"z": 0, "a": 3, "b": 2, "c": 1, "d": 1}
    both = LateAttributes({}, maker("left", a=1, b=1)) | LateAttributes({}, maker("right", b=2, c=2))
    assert dict(both) == {"a": 1, "b": 2, "c": 2}
    assert dict(LateAttributes({}, maker("left", a=1)) | LateAttributes({}, maker("right", a=2))) == {"a": 2}
    anything = LateAttributes({}, lambda: {"a": 1, "b": 1}) | LateAttributes({}, lambda: {"b": 2})
    assert dict(anything) == {"a": 1, "b": 2}
    assert dict(LateAttributes({}, lambda: {"a": 1, "b": 1}) | {"a": 2}) == {"a": 2, "b": 1}
    assert found["d"] == 1
    other = found.copy()
    other["d"] = 5
    del other["c"]
    assert (found["d"], "c" in found, "c" in other) == (1, True, False)
    with pytest.raises(KeyError):
        found["e"]


def test_nodes_that_turn_little_have_the_verdict_of_all(monkeypatch):
    """Random turns of a bent rod between two states, from small ones to more than a whole one."""
    rubber = vr.Material(1e6, 0.3, 1000.0)
    model = vr.Model()
    arc = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.01), material=rubber, elements=2, order=3)
    model.add("arc", arc)
    problem = discretise(model)
    turns = node_turns.NodeTurns(problem)
    random = np.random.default_rng(5)
    verdicts = []
    for size in np.repeat([0.1, 0.3, 0.6, 1.2, 3.0, 6.0], 50):
        old, new = State.reference(problem), State.reference(problem)
        for state in (old, new):
            vectors = size * random.uniform(-1.0, 1.0, (problem.size, 3))
            state.q[:] = product(state.q, np.roll(Rotation.from_rotvec(vectors).as_quat(), 1, axis=-1))
        quick = turns.jumped(old, new)
        with monkeypatch.context() as change:
            change.setattr(node_turns, "SURELY_SMALL", 2.0)
            assert turns.jumped(old, new) == quick
        verdicts.append(quick)
    assert not any(verdicts[:100])
    assert any(verdicts[-100:])


def test_a_section_is_that_of_every_material_in_turn():
    """Timoshenko's factor depends on Poisson's ratio (Cowper 1966): 6 (1 + nu) / (7 + 6 nu) of a circle."""
    section = vr.Circle(0.01)
    for nu in (0.1, 0.4, 0.1):
        material = vr.Material(1e6, nu, 1000.0)
        factor = section.shear_factors(nu)[0]
        stiffness, _, inertia = section.matrices(material)
        assert stiffness[0, 0] == pytest.approx(factor * 1e6 / (2.0 * (1.0 + nu)) * section.moments()[0])
        stiffness[:] = inertia[:] = 0.0  # its own, nobody else's
    assert section.shear_factors(0.1) != section.shear_factors(0.4)
