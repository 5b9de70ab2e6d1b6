"""Members with the same values are computed once and told; whole tables and lists are set before their parts."""

import pytest
import scipy.stats

import viscorod as vr
from helpers.strip import content
from helpers.sweep_records import records_in
from viscorod.analyses.case_run import run_case
from viscorod.analyses.sweeps.same_values import alike
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.set_values import with_values
from viscorod.results.sweep_members import Rows

FORCES, FORCE, MODULUS = "loads[0].value", "loads[0].value[1]", "materials.rubber.youngs_modulus"
TIP = {"tip": ("displacement", "beam.end", "y", "last")}


@pytest.fixture
def held():
    return case_from_dict(content("equilibrium"))


def tip_of(modulus=1e6, force=(0.0, 1e-3, 0.0)):
    """Displacement of the tip of the strip, computed alone."""
    given = content("equilibrium")
    given["materials"]["rubber"]["youngs_modulus"] = modulus
    given["loads"][0]["value"] = list(force)
    found = run_case(case_from_dict(given), errors=False)
    return float(found.displacement("beam.end")[1])


@pytest.mark.parametrize("executor", [None, "threads:2"])
def test_members_with_the_same_values_are_computed_once(held, executor, tmp_path):
    given = {MODULUS: [1e6, 2e6, 1e6, 1e6]}
    workers = 1 if executor is None else None
    asked = {"quantities": TIP, "folder": tmp_path / "s", "executor": executor, "workers": workers}
    found = vr.sweep(held, given, **asked)
    soft, stiff = (tip_of(modulus) for modulus in (1e6, 2e6))
    assert found.table()["tip"].tolist() == [soft, stiff, soft, soft]
    assert len(records_in(tmp_path / "s")) == 2
    assert "members with the same values are computed once: 2 is 0, 3 is 0" in str(found)
    again = vr.sweep(held, given, **asked)
    assert again.table()["tip"].tolist() == [soft, stiff, soft, soft]
    assert len(records_in(tmp_path / "s")) == 2
    assert again.notes == found.notes


def test_whole_results_and_failures_are_those_of_all_that_are_alike(held):
    """The second member and its like have no equilibrium: a rod of 1 Pa under that force."""
    found = vr.sweep(held, {MODULUS: [1e6, 1e-6, 1e6, 1e-6]}, workers=1)
    assert [run.outcome == "completed" for run in found.members] == [True, False, True, False]
    assert float(found.members[2].result.displacement("beam.end")[1]) == tip_of()
    assert found.members[3].message == found.members[1].message != ""


def test_a_part_of_the_members_computes_those_that_are_alike_elsewhere(held, tmp_path):
    given = {MODULUS: [1e6, 2e6, 1e6]}
    found = vr.sweep(
        held, given, quantities=TIP, workers=1, folder=tmp_path / "s", members=slice(2, 3)
    ).table()
    assert found["outcome"].tolist() == ["not run", "not run", "completed"]
    whole = vr.sweep(held, given, quantities=TIP, workers=1, folder=tmp_path / "s")
    assert whole.count_completed == 3
    assert len(records_in(tmp_path / "s")) == 2


def test_points_of_discrete_distributions_are_computed_once(held, tmp_path):
    drawn = {"rods.beam.elements": scipy.stats.randint(1, 3)}
    found = vr.ensemble(held, drawn, 8, quantities=TIP, seed=1, workers=1, folder=tmp_path / "s")
    assert found.count_completed == 8
    assert len(records_in(tmp_path / "s")) == 2


def test_what_is_the_same():
    """By how it is written: what a case does with 1 and 1.0 is not looked at."""
    rows = Rows({"a": [1, 1.0, "1 mm", [0, 1], 1, [0, 1]], "b": [2.0] * 6}, 6)
    assert alike(rows, range(6)) == {4: 0, 5: 3}
    assert alike(rows, [4, 5, 0]) == {0: 4}
    assert alike(Rows({"a": [1.0, 1.0], "b": [2.0, 3.0]}, 2), range(2)) == {}


@pytest.mark.parametrize("part_first", [True, False])
def test_whole_lists_are_set_before_their_parts(held, part_first):
    """A constant list took the place of the value that was varied within it, and all members were one."""
    part, whole = {FORCE: [5e-5, 2e-4]}, {FORCES: [0.0, 1e-4, 1e-5]}
    columns = {key: 2 * [value] for key, value in whole.items()}
    asked = {"quantities": TIP, "workers": 1}
    found = (
        vr.sweep(held, part, constants=whole, **asked)
        if part_first
        else vr.sweep(held, columns | part, **asked)
    )
    assert found.table()["tip"].tolist() == [tip_of(force=(0.0, y, 1e-5)) for y in (5e-5, 2e-4)]
    assert found.members[1].values[FORCES] == [0.0, 1e-4, 1e-5]
    named = [*part, *whole] if part_first else [*whole, *part]
    alone = with_values(held, {key: (whole | {FORCE: 5e-5})[key] for key in named})
    assert alone.content["loads"][0]["value"] == [0.0, 5e-5, 1e-5]
    assert whole[FORCES] == [0.0, 1e-4, 1e-5]
