"""What members of a sweep share of their discretisation, and numbers that are read without a data set."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from viscorod.analyses.case_run import discretised_case, run_case
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.sweeps.member_work import member_case, member_content
from viscorod.casefile.case import case_from_dict, load_case
from viscorod.casefile.known_parts import KnownParts
from viscorod.casefile.shipped import shipped_case
from viscorod.results.quantities import evaluated, quantities_of
from viscorod.results.state_arrays import PlainArray, StateArrays
from viscorod.solve.constraints.rigid_motions import free_motions, surely_held
from viscorod.solve.formulations.system import State
from viscorod.solve.problem import chosen_divisions, layout
from viscorod.solve.problem.model_parts import token
from viscorod.solve.statics.tangent import negative_eigenvalues

SWING = {"simulate.duration": 0.1, "simulate.tolerance": 1e-4}


def members(name, rows):
    """Return the cases of members of a sweep, read with the parts of those before."""
    case, known = load_case(shipped_case(name)), KnownParts()
    contents = (member_content(case.content, case.source, row, False, known)[0] for row in rows)
    return [case_from_dict(content, case.source, known=known) for content in contents]


def forgotten():
    """Let the next model find its layout anew, and how its rods are divided."""
    layout._kept.cache_clear()
    layout._kept_as_chosen.cache_clear()
    chosen_divisions._kept.cache_clear()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("materials.rubber.youngs_modulus", 2e6),
        ("materials.rubber.damping.shear_time", 0.01),
        ("sections.square.width", 0.02),
        ("loads[0].value", [0.0, 0.01, 0.0]),
        ("simulate.duration", 0.2),
    ],
)
def test_members_share_where_their_nodes_are(key, value):
    forgotten()
    one, other = (
        discretised_case(case).problem for case in members("cantilever_swing", [SWING, SWING | {key: value}])
    )
    assert other.of_layout is one.of_layout
    assert other.positions is one.positions
    assert other.supports is one.supports


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("rods.beam.end", [0.4, 0.0, 0.0]),
        ("rods.beam.elements", 3),
        ("rods.beam.order", 4),
        ("rods.beam.twist", 0.5),
        ("rods.beam.tilt", [0.0, 0.1, 0.0]),
        ("rods.beam.constraints", "inextensible"),
        ("supports[0].kind", "pin"),
        ("supports[0].at", "beam.end"),
    ],
)
def test_members_whose_nodes_or_supports_differ_share_nothing(key, value):
    forgotten()
    one, other = (
        discretised_case(case).problem for case in members("cantilever_swing", [SWING, SWING | {key: value}])
    )
    assert other.of_layout is not one.of_layout
    forgotten()
    alone = discretised_case(members("cantilever_swing", [SWING | {key: value}])[0]).problem
    for name in ("positions", "quaternions", "mass"):
        np.testing.assert_array_equal(getattr(other, name), getattr(alone, name))
    np.testing.assert_array_equal(other.supports.fixed, alone.supports.fixed)


@pytest.mark.parametrize(
    ("name", "rows"),
    [
        (
            "cantilever_swing",
            [
                SWING,
                SWING | {"materials.rubber.youngs_modulus": 2e6},
                SWING | {"loads[0].value[1]": 0.01},
                SWING | {"sections.square.height": 0.02},
            ],
        ),
        (
            "four_bar",
            [
                {"simulate.duration": 0.2},
                {"simulate.duration": 0.2, "sections.thin.stiffness[3]": 100.0},
                {"simulate.duration": 0.2, "joints[2].axis": [0.0, 0.0, 1.0]},
            ],
        ),
    ],
)
def test_what_is_shared_changes_no_bit(name, rows):
    """Independent: the same cases, each with a layout of its own."""
    forgotten()
    together = [run_case(case) for case in members(name, rows)]
    for row, found in zip(rows, together, strict=True):
        forgotten()
        alone = run_case(members(name, [row])[0])
        assert found == alone


@pytest.mark.parametrize("name", ["twist", "tilt"])
def test_functions_of_the_arc_length_are_asked_every_time(name):
    """A user may change what they return; nodes turn by it: half of it, from the identity, is in their quaternions."""
    angle = [0.2]
    given = {
        "twist": lambda s: angle[0] * s,
        "tilt": lambda s: (0.0, 0.0, angle[0] * s),
    }
    model = vr.Model()
    section = vr.Rectangle(width=0.01, height=0.02)
    material = vr.Material(youngs_modulus=1e6, poissons_ratio=0.3)
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section, material=material, elements=1, **{name: given[name]}
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    found = []
    for angle[0] in (0.2, 0.4):
        quaternions = DiscreteModel.of(model).problem.quaternions
        found.append(2.0 * math.acos(abs(float(quaternions[0] @ quaternions[-1]))))
    assert found == pytest.approx([0.2, 0.4], rel=1e-6)


def test_a_table_of_a_joint_that_was_changed_in_place_counts():
    """The energy of a spring in a hinge goes with its stiffness."""
    model = vr.Model()
    section = vr.Rectangle(width=0.01, height=0.02)
    material = vr.Material(youngs_modulus=1e6, poissons_ratio=0.3)
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=material, elements=1))
    model.revolute("beam.start", "ground", (0, 0, 1), stiffness={"rz": 1.0})
    found = []
    for stiffness in (1.0, 3.0):
        model.joints[0].stiffness["rz"] = stiffness
        found.append(float(DiscreteModel.of(model).problem.joints.arrays.stiffness.max()))
    assert found == [1.0, 3.0]


WRITTEN = {
    "nothing": ({}, True),
    "a modulus": ({"modulus": 2e6}, True),
    "where it ends": ({"end": (1.0, 0.0, 0.1)}, False),
    "which axis is first": ({"d1": (0.0, 1.0, 0.1)}, False),
    "its elements": ({"elements": 2}, False),
    "a spring": ({"spring": 2.0}, False),
    "an axis": ({"axis": (0.0, 0.0, 1.0)}, False),
    "where a mass is": ({"mass_at": (1.0, 0.1, 0.0)}, False),
}


def written(
    modulus=1e6,
    end=(1.0, 0.0, 0.0),
    d1=None,
    elements=1,
    spring=1.0,
    axis=(0.0, 1.0, 0.0),
    mass_at=(1.0, 0.0, 0.0),
):
    """Return a model of parts that are all made anew."""
    material = vr.Material(youngs_modulus=modulus, poissons_ratio=0.3)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), end, section=vr.Rectangle(0.01, 0.02), material=material, d1=d1, elements=elements
    )
    model.add("beam", rod)
    model.revolute("beam.start", "ground", axis, stiffness={"rz": spring})
    model.add("weight", vr.Sphere(0.1, mass=1.0, centre=mass_at))
    model.attach("weight", "beam.end")
    return model


@pytest.mark.parametrize(("changes", "shared"), WRITTEN.values(), ids=WRITTEN)
def test_models_that_are_written_anew_share_what_they_have_in_common(changes, shared):
    """Independent: the arrays of the same model with a layout of its own."""
    forgotten()
    one, other = (DiscreteModel.of(written(**given)).problem for given in ({}, changes))
    assert (other.of_layout is one.of_layout) == shared
    forgotten()
    alone = DiscreteModel.of(written(**changes)).problem
    for name in ("positions", "quaternions", "mass"):
        np.testing.assert_array_equal(getattr(other, name), getattr(alone, name))
    for mine, its in zip(other.joints.arrays, alone.joints.arrays, strict=True):
        np.testing.assert_array_equal(mine, its)


def test_parts_of_a_users_own_class_are_what_they_are_alone():
    """What such a class computes from may be anything."""

    class Own(vr.Clamp):
        pass

    assert token(vr.Clamp("beam.start")) == token(vr.Clamp("beam.start"))
    assert token(Own("beam.start")) != token(Own("beam.start"))


def test_a_problem_made_of_another_shares_nothing_with_it():
    problem = discretised_case(members("cantilever_swing", [SWING])[0]).problem
    assert free_motions(problem) == []
    assert problem.of_layout
    assert not replace(problem, positions=2.0 * problem.positions).of_layout


def test_numbers_of_a_motion_are_read_without_making_a_data_set(tmp_path):
    """Independent: the same numbers of the file, whose data set xarray reads."""
    words = {
        "tip": "displacement beam.end y max",
        "rate": "velocity beam@0.15 size rms",
        "at a time": "position beam.end x 0.05",
        "bent": "strain beam.start bend_2 min",
        "lost": "dissipation beam@0.1 mean",
        "held": "reaction beam.start mz last",
        "energy": "energy elastic last",
    }
    run = run_case(members("cantilever_swing", [SWING])[0])
    quantities = quantities_of(words, "simulate")
    numbers, wrong = evaluated(quantities, run)
    assert not wrong
    assert "data" not in vars(run)
    assert (run.outcome, run.title) == ("completed", "Cantilever, released")
    path = run.save(tmp_path / "run.nc")
    assert evaluated(quantities, vr.load(path)) == (numbers, [])


def test_what_few_ask_for_is_made_once_when_it_is_asked_for():
    made = []

    def lost():
        made.append(1)
        return np.arange(6.0).reshape(3, 2)

    arrays = {"kinetic": ("time", np.ones(3)), "dissipation": (("time", "point"), lost)}
    stored = StateArrays(arrays, {"point_s": ("point", np.zeros(2))}, {}, ("time", np.arange(3.0)))
    assert "dissipation" in stored
    assert stored.sizes == {"time": 3, "point": 2}
    np.testing.assert_array_equal(stored["kinetic"].values, 1.0)
    assert not made
    data = stored.data_set()
    assert list(data.data_vars) == ["kinetic", "dissipation"]
    np.testing.assert_array_equal(data["dissipation"].values, lost())
    assert stored["dissipation"].isel(point=1).values.tolist() == [1.0, 3.0, 5.0]
    assert len(made) == 2  # one of them here


def test_arrays_are_cut_as_variables_of_xarray_are():
    values = np.arange(24.0).reshape(4, 3, 2)
    plain, variable = (
        PlainArray(("time", "station", "axis"), values),
        xr.Variable(("time", "station", "axis"), values),
    )
    for part in ({"time": 2}, {"station": np.array([2, 0])}, {"time": slice(1, 3)}, {"time": 0, "axis": 1}):
        mine, theirs = plain.isel(part), variable.isel(part)
        assert mine.dims == theirs.dims
        assert mine.sizes == dict(theirs.sizes)
        np.testing.assert_array_equal(mine.values, theirs.values)
    with pytest.raises(ValueError, match="place"):
        plain.isel(place=0)
    with pytest.raises(IndexError):
        plain.isel(time=7)


@pytest.mark.parametrize("part", [0.5, 0.99, 1.01, 1.5])
def test_a_column_is_surely_stable_below_its_critical_load_only(part):
    """Euler: F = pi^2 EI / (4 L^2) of a clamped column; shear of this slender one takes 1e-4 of it."""
    length, width, modulus = 1.0, 0.01, 1e9
    force = math.pi**2 * modulus * width**4 / 12.0 / (4.0 * length**2)
    material = vr.Material(youngs_modulus=modulus, poissons_ratio=0.3)
    section = vr.Rectangle(width=width, height=width)
    model = vr.Model()
    model.add(
        "column",
        vr.Rod.straight((0, 0, 0), (length, 0, 0), section=section, material=material, elements=4, order=5),
    )
    model.clamp("column.start")
    model.force("column.end", (-part * force, 0.0, 0.0))
    discrete = DiscreteModel.of(model)
    state = State.reference(discrete.problem)
    discrete.static.solve(state)
    stable = discrete.static.surely_stable(state, 0.0, before=True, scale=1.0)
    assert stable == (part < 1.0)
    assert negative_eigenvalues(discrete.static.tangent(state)) == (0 if part < 1.0 else 2)


CHOSEN = SWING | {"rods.beam.elements": "auto"}
DIVIDED = {
    "another order": {"rods.beam.order": 4},
    "a load within the rod": {"loads[0].at": "beam@0.1"},
    "a support within the rod": {"supports[0].at": "beam@0.17"},
    "elements that are given": {"rods.beam.elements": 5},
    "another shape": {"rods.beam.end": [0.2, 0.0, 0.0]},
}


@pytest.mark.parametrize("changes", DIVIDED.values(), ids=DIVIDED)
def test_rods_are_divided_anew_where_it_matters(changes):
    forgotten()
    rows = [CHOSEN, CHOSEN | {"loads[0].value[1]": 0.02}, CHOSEN | changes]
    models = [case.description for case in members("cantilever_swing", rows)]
    one, again, new = map(chosen_divisions.chosen_divisions, models)
    assert again is one
    fresh = chosen_divisions._chosen(models[-1])["beam"]
    assert (new["beam"].order, new["beam"].ends.tolist()) == (fresh.order, fresh.ends.tolist())
    assert (new["beam"].order, new["beam"].ends.tolist()) != (one["beam"].order, one["beam"].ends.tolist())


def test_a_support_that_turns_is_asked_every_time_how_far():
    turn = [0.0]

    def still(_t):
        return 0.0

    rubber = vr.Material(youngs_modulus=1e6, poissons_ratio=0.3)
    model = vr.Model()
    model.add(
        "beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.01, 0.01), material=rubber)
    )
    model.clamp("beam.start")
    model.clamp("beam.end", motion={"rx": vr.FunctionOfTime(lambda t: turn[0], still, still)})
    resting = chosen_divisions.chosen_divisions(model)["beam"].count
    turn[0] = 30.0
    assert chosen_divisions.chosen_divisions(model)["beam"].count > resting


@pytest.mark.parametrize("value", [0.01, "10 mm", "1 cm"])
def test_members_of_numbers_and_of_quantities_are_read_alike(value):
    rows = [SWING, SWING | {"sections.square.width": 0.01}, SWING | {"sections.square.width": value}]
    case, known = load_case(shipped_case("cantilever_swing")), KnownParts()
    read = [member_case(case.content, case.source, case.title, row, False, known)[0] for row in rows]
    assert read[2].description == read[1].description == read[0].description


@pytest.mark.parametrize("name", ["_of_nobody", "at"])
def test_an_object_that_was_refused_says_what_it_lacks(name):
    with pytest.raises(AttributeError, match=f"no attribute '{name}'"):
        getattr(vr.Clamp.__new__(vr.Clamp), name)


def test_one_part_with_a_clamp_has_no_rigid_motion_left():
    held, loose = (
        discretised_case(load_case(shipped_case(name))).problem for name in ("cantilever_swing", "flying_rod")
    )
    assert surely_held(held)
    assert free_motions(held) == []
    assert not surely_held(loose)
