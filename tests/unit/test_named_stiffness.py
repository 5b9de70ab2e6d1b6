"""Sections by named numbers are those by lists; without inertia there is statics, and nothing that moves."""

import numpy as np
import pytest

import viscorod as vr
from viscorod.casefile.case import case_from_dict

NAMED = {"EA": 2e3, "GJ": 0.3, "EI2": 0.2, "GA1": 1e3, "EI1": 0.1, "GA2": 1.1e3}


def model(section):
    found = vr.Model()
    found.add("strip", vr.Rod.straight([0, 0, 0], [1, 0, 0], section=section, elements=2, order=3))
    found.clamp("strip.start")
    return found


def test_names_stand_for_places_in_the_lists():
    """The order of the lists is shear 1, shear 2, stretch, bend 1, bend 2, twist."""
    by_list = vr.StiffnessSection(
        [1e3, 1.1e3, 2e3, 0.1, 0.2, 0.3],
        [0.5, 0.5, 0.5, 1e-6, 2e-6, 3e-6],
        damping=[0, 0, 1.0, 0.5, 0, 0],
        branches=[vr.MaxwellBranch(0.1, [0, 0, 0, 0, 7.0, 0])],
    )
    by_name = vr.StiffnessSection(
        NAMED,
        {"mass": 0.5, "J1": 1e-6, "J2": 2e-6},
        damping={"EA": 1.0, "EI1": 0.5},
        branches=[vr.MaxwellBranch(0.1, {"EI2": 7.0})],
    )
    assert by_name == by_list
    timed = vr.StiffnessSection(NAMED, times={"GJ": 0.3, "GA1": 0.1})
    assert timed.times == (0.1, 0.0, 0.0, 0.0, 0.0, 0.3)
    with_own = vr.StiffnessSection(NAMED, {"mass": 0.5, "J1": 1e-6, "J2": 2e-6, "J3": 9e-6})
    assert with_own.matrices()[2][5, 5] == 9e-6


def test_files_name_them_too_with_units():
    section = {
        "shape": "stiffness",
        "stiffness": NAMED | {"EA": "2 kN", "EI1": "1000 N cm^2"},
        "inertia": {"mass": "500 g/m", "J1": 1e-6, "J2": "2 mg m"},
    }
    case = case_from_dict(
        {
            "rods": {
                "strip": {"shape": "straight", "start": [0, 0, 0], "end": [1, 0, 0], "section": section}
            },
            "supports": [{"kind": "clamp", "at": "strip.start"}],
            "modes": {},
        }
    )
    assert case.description.rods["strip"].section == vr.StiffnessSection(
        NAMED, {"mass": 0.5, "J1": 1e-6, "J2": 2e-6}
    )


def test_statics_need_no_inertia():
    """The tip under a small force F sinks by F L^3/(3 EI) + F L/GA, with shear along d2 and bending about d1."""
    found = model(vr.StiffnessSection(NAMED | {"EI2": 50.0}))
    found.force("strip.end", [0, 0, -1e-4])
    bent = found.equilibrium()
    frame = found.rods["strip"].frames([0.0])[1][0]
    soft = NAMED["EI1"] if abs(frame[2, 1]) > 0.5 else 50.0
    shear = NAMED["GA2"] if abs(frame[2, 1]) > 0.5 else NAMED["GA1"]
    assert bent.displacement("strip.end")[2] == pytest.approx(
        -1e-4 * (1.0 / (3.0 * soft) + 1.0 / shear), rel=1e-5
    )
    assert bent.stable
    with_inertia = model(vr.StiffnessSection(NAMED | {"EI2": 50.0}, [5.0, 5.0, 5.0, 1e-3, 1e-3, 2e-3]))
    with_inertia.force("strip.end", [0, 0, -1e-4])
    np.testing.assert_array_equal(with_inertia.equilibrium().field("position"), bent.field("position"))


def test_stability_that_inertia_might_change_says_so():
    found = model(vr.StiffnessSection(NAMED))
    found.moment("strip.end", [0, 0.01, 0])
    assert "a section was given without" in found.equilibrium().stability


@pytest.mark.parametrize(
    "compute",
    [
        lambda m: m.simulate(1.0),
        lambda m: m.modes(2),
        lambda m: m.frequency_response(inputs="base uz", outputs="strip.end uz", band=(1.0, 2.0)),
        lambda m: m.compare_theories(),
    ],
)
def test_motions_need_inertia(compute):
    with pytest.raises(
        vr.InputError, match=r"rods.strip.section.inertia: it was left out, and something moves"
    ):
        compute(model(vr.StiffnessSection(NAMED)))


def test_weight_needs_inertia():
    found = model(vr.StiffnessSection(NAMED))
    with pytest.raises(vr.InputError, match="the weight of strip is not known"):
        found.gravity()
    with pytest.raises(vr.InputError, match="without inertia"):
        _ = found.mass


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"EA": 1.0}, "GA1, GA2, EI1, EI2, GJ are missing"),
        (NAMED | {"GA": 2.0}, r"stiffness.GA: 2.0: no such name; did you mean 'GA2'\?"),
        (NAMED | {"EI1": -1.0}, "bend_1"),
        (NAMED | {"EA": "2 N m"}, "EA needs a force"),
    ],
)
def test_wrong_names_are_told(given, words):
    with pytest.raises(vr.InputError, match=words):
        vr.StiffnessSection(given)


def test_a_name_as_a_keyword_is_told_where_it_belongs():
    with pytest.raises(vr.InputError, match="give the stiffnesses as one table"):
        vr.StiffnessSection(EA=1.0)
