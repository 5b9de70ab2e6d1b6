"""Sweeps and ensembles as strangers ask for them: odd tables, units, discrete and correlated values, what fails."""

import json
import sys

import numpy as np
import pandas as pd
import pytest
import scipy.stats
import xarray as xr

import viscorod as vr
from helpers.strip import content
from viscorod.analyses.sweeps.points import distribution_text, points_of
from viscorod.analyses.sweeps.rows import rows_of
from viscorod.casefile.case import case_from_dict
from viscorod.errors import InputError
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.sweep_members import SweepRun
from viscorod.results.sweep_result import Sweep
from viscorod.results.values_in_si import in_si

FORCE, MODULUS, WIDTH = "loads[0].value[1]", "materials.rubber.youngs_modulus", "sections.thin.width"
TIP = {"tip": ("displacement", "beam.end", "y", "last")}


@pytest.fixture
def held():
    return case_from_dict(content("equilibrium"))


class PolarsLike:
    """A table whose columns are a list of names, as those of Polars."""

    def __init__(self):
        self.columns = [FORCE]

    def to_dict(self):
        raise AssertionError("its columns are read one by one")

    def __getitem__(self, key):
        return iter([1e-4, 2e-4])


@pytest.mark.parametrize(
    "values",
    [
        {FORCE: np.array([1e-4, 2e-4], dtype=np.float64)},
        {FORCE: xr.DataArray([1e-4, 2e-4], dims="member")},
        {FORCE: pd.Series([1e-4, 2e-4], index=[7, 7])},
        pd.DataFrame({FORCE: pd.array([1e-4, 2e-4], dtype="Float64")}, index=[3, 3]),
        PolarsLike(),
        [{FORCE: 1e-4}, {FORCE: np.float64(2e-4)}],
    ],
)
def test_columns_of_all_kinds_of_tables(values):
    rows = rows_of(values)
    assert rows.columns == {FORCE: [1e-4, 2e-4]}
    assert all(type(value) is float for value in rows.columns[FORCE])


def test_rows_may_name_their_keys_in_any_order():
    rows = rows_of([{FORCE: 1.0, MODULUS: 2.0}, {MODULUS: 4.0, FORCE: 3.0}])
    assert rows.columns == {FORCE: [1.0, 3.0], MODULUS: [2.0, 4.0]}


@pytest.mark.parametrize("value", [1e6, "2 MPa", 3])
def test_one_value_is_a_constant(value):
    with pytest.raises(vr.InputError, match="one value for all members goes into constants"):
        rows_of({MODULUS: value})


@pytest.mark.parametrize(("mark", "word"), [(";", "semicolons"), ("\t", "tabs")])
def test_cells_between_other_marks_are_told(mark, word, tmp_path):
    path = tmp_path / "rows.csv"
    path.write_text(f"{FORCE}{mark}{MODULUS}\n1,5{mark}2\n")  # as offices of many countries write it
    with pytest.raises(vr.InputError, match=f"there are {word} between its cells"):
        rows_of(path)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({MODULUS: [1e6, 2e6, float("nan")]}, r"the number must be finite \(member 2\); give"),
        ({MODULUS: [1e6, -1.0, -1.0]}, r"outside what is allowed \(member 1 and 1 more\); give"),
        ({MODULUS: [-1.0, -1.0]}, "outside what is allowed; give"),
        (
            {"rods.beam.elements": [1, 1, 2], "rods.beam.material": ["rubber", "rubber", "none"]},
            r"there is no material of this name \(member 2\)",
        ),
    ],
)
def test_wrong_values_name_their_members(held, values, words):
    with pytest.raises(vr.InputError, match=words):
        vr.sweep(held, values, quantities=TIP, workers=1)


def test_what_another_value_makes_wrong_names_that_value():
    swing = case_from_dict(content("simulate", duration=0.1, tolerance=1e-3))
    values = {FORCE: [1e-4, 1e-4], "simulate.integrator": ["radau", "midpoint"]}
    words = r"no error estimate \(member 1, where simulate.integrator = 'midpoint'\)"
    with pytest.raises(vr.InputError, match=words):
        vr.sweep(swing, values, quantities=TIP, workers=1)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (content("equilibrium"), r"case: dict: this is the content of a case file.*viscorod.load_case\("),
        (None, r"case: None: a case is needed here, or the path of its file; give \"case.toml\""),
        (3, "case: 3: a case is needed here"),
    ],
    ids=["content", "nothing", "a number"],
)
def test_what_is_no_case_is_refused_by_its_name(given, words):
    with pytest.raises(vr.InputError, match=words):
        vr.sweep(given, {FORCE: [1e-4]}, quantities=TIP, workers=1)
    with pytest.raises(vr.InputError, match=words):
        vr.ensemble(given, {FORCE: scipy.stats.norm(1e-4, 1e-5)}, n=4, quantities=TIP, workers=1)


def give_up(result):
    """Ends the program, as scripts do that were not written to be called."""
    sys.exit(3)


def test_a_quantity_that_ends_the_program_costs_its_number_alone(held):
    table = vr.sweep(held, {FORCE: [1e-4]}, quantities=TIP | {"mine": give_up}, workers=1).table()
    assert table["outcome"].tolist() == ["completed"]
    assert table["tip"].notna().all()
    assert table["mine"].isna().all()
    assert table["message"].tolist() == ["mine: SystemExit: 3"]


@pytest.mark.parametrize(
    ("given", "numbers"),
    [
        (["1 mm", "2.5 cm", 0.5], [1e-3, 2.5e-2, 0.5]),
        (["1 MPa", "2 N/mm^2"], [1e6, 2e6]),
        (["1 mm", "2 N"], ["1 mm", "2 N"]),  # not of one kind
        (["60 rpm"], ["60 rpm"]),  # 1 Hz or 6.28 rad/s, as the key needs
        (["20 degC"], ["20 degC"]),
        (["rubber", "steel"], ["rubber", "steel"]),
        (["1 mm", True], ["1 mm", True]),
        ([1, 2], [1, 2]),
        ([[1.0, 2.0], "1 mm"], [[1.0, 2.0], "1 mm"]),
    ],
)
def test_values_with_units_are_numbers_in_a_table(given, numbers):
    assert in_si(given) == numbers


def test_a_table_with_units_can_be_drawn_and_is_kept_as_given(held, tmp_path):
    path = tmp_path / "rows.csv"
    path.write_text(f"{WIDTH} [mm]\n10\n20\n")
    sweep = vr.sweep(held, path, quantities=TIP, workers=1)
    assert sweep.table()[WIDTH].tolist() == [0.01, 0.02]
    assert sweep.table(as_given=True)[WIDTH].tolist() == ["10 mm", "20 mm"]
    assert vr.load(sweep.save(tmp_path / "sweep.nc")) == sweep
    assert vr.load(sweep.save(tmp_path / "sweep.parquet")) == sweep
    lines = sweep.plot(x=WIDTH, name="tip").axes[0].lines  # in the unit that was given
    assert [10.0, 20.0] in [np.asarray(line.get_xdata()).tolist() for line in lines]


UNIFORM = np.array([[0.1], [0.4], [0.9]])


@pytest.mark.parametrize(
    ("distribution", "values", "text"),
    [
        (
            scipy.stats.rv_discrete(values=([1, 2, 5], [0.2, 0.5, 0.3])),
            [1, 2, 5],
            "one of 1: 0.2, 2: 0.5, 5: 0.3",
        ),
        (
            scipy.stats.rv_discrete(values=([0.01, 0.02], [0.3, 0.7])),
            [0.01, 0.02, 0.02],
            "one of 0.01: 0.3, 0.02: 0.7",
        ),
        (scipy.stats.randint(1, 4), [1, 2, 3], "randint(1, 4)"),
        (
            scipy.stats.rv_histogram(([1, 1], [0.0, 1.0, 3.0]), density=False),
            [0.2, 0.8, 2.6],
            "histogram from 0 to 3",
        ),
        (scipy.stats.uniform(1.0, 2.0), [1.2, 1.8, 2.8], "uniform(1, 2)"),
    ],
)
def test_values_of_distributions_are_not_cut_to_whole_numbers(distribution, values, text):
    found = points_of(UNIFORM, {"key": distribution})["key"]
    np.testing.assert_allclose(found, values, rtol=1e-12)
    assert found.dtype.kind == ("i" if all(isinstance(value, int) for value in values) else "f")
    assert distribution_text(distribution) == text


@pytest.mark.skipif(not hasattr(scipy.stats, "Normal"), reason="of SciPy 1.15 and later")
def test_newer_distributions_of_scipy():
    normal = scipy.stats.Normal(mu=1e6, sigma=5e4)
    found = points_of(UNIFORM, {"key": normal})["key"]
    np.testing.assert_allclose(found, scipy.stats.norm(1e6, 5e4).ppf(UNIFORM[:, 0]), rtol=1e-12)
    assert found.dtype.kind == "f"
    assert distribution_text(normal) == "Normal(mu=1e+06, sigma=50000)"


@pytest.mark.parametrize("still", [scipy.stats.norm(1e6, 0.0), scipy.stats.uniform(loc=1e6, scale=0.0)])
def test_what_does_not_vary_is_a_constant(held, still):
    with pytest.raises(vr.InputError, match="a deviation of 0 leaves one value; give it in constants"):
        vr.ensemble(held, {MODULUS: still}, 8, quantities=TIP, workers=1)


def test_correlations_are_told_and_kept(held, tmp_path):
    drawn = {MODULUS: scipy.stats.norm(1e6, 5e4), WIDTH: scipy.stats.norm(0.01, 2e-4)}
    found = vr.ensemble(
        held, drawn, 8, quantities=TIP, correlation=[[1.0, 0.9], [0.9, 1.0]], workers=1, errors=0
    )
    assert f"{WIDTH}  {MODULUS}          0.9" in found.report()
    assert vr.load(found.save(tmp_path / "found.nc")).design == found.design
    earlier = '{"keys": ["a"], "distributions": ["norm(0, 1)"], "n": 2, "seed": 0, "indices": false}'
    assert Design.of_record(earlier, "a file of version 0.3").correlation == ()


def test_an_ensemble_with_a_unit_behind_a_key_stays_one_in_its_folder(held, tmp_path):
    """Its key was sought with the unit, so that what was loaded from the folder had no quantiles any more."""
    widths = {WIDTH + " [mm]": scipy.stats.uniform(9.0, 2.0)}
    found = vr.ensemble(held, widths, 8, quantities=TIP, workers=1, errors=0, folder=tmp_path)
    assert found.design.keys == (WIDTH,)
    assert found.design.distributions == ("uniform(9, 2) mm",)
    again = vr.load(tmp_path)
    assert isinstance(again, Ensemble)
    assert again.report() == found.report()
    shown = again.table()[WIDTH]
    assert shown.between(0.009, 0.011).all()
    with pytest.raises(vr.InputError, match=r"norm\(1, 2\) mm gives such values; truncnorm"):
        vr.ensemble(held, {WIDTH + " [mm]": scipy.stats.norm(1.0, 2.0)}, 8, quantities=TIP, workers=1)
    with pytest.raises(vr.InputError, match=r"two columns have this key; leave one of them out$"):
        vr.ensemble(held, widths | {WIDTH: scipy.stats.norm(0.01, 1e-4)}, 8, quantities=TIP, workers=1)


def test_a_mode_beyond_those_that_are_sought_says_how_many_to_seek():
    case = case_from_dict(content("modes", count=2))
    member = vr.sweep(
        case, {MODULUS: [1e6]}, quantities={"f": ("frequency", 5)}, workers=1, errors=0
    ).members[0]
    assert member.message == "f: there are 2; there is no number 5; modes.count = 5 seeks more of them"


def partial():
    """32 points of f = a, which no member with f > 0.9 has, and of a constant."""
    rows = np.random.default_rng(1).random((32, 3))
    members = [
        SweepRun(k, {"a": value}, None, "", "completed", {"c": 1.0} | ({"f": value} if value <= 0.9 else {}))
        for k, value in enumerate(rows.ravel().tolist())
    ]
    return Ensemble.of_sweep(Sweep(members), Design(("a",), ("uniform",), 32, 1, True)), rows


def test_what_only_some_members_have_is_told_beside_its_quantiles_and_indices(tmp_path):
    found, rows = partial()
    have = int((rows[:, :2] <= 0.9).sum())
    whole = int((rows <= 0.9).all(axis=1).sum())
    assert have < 64
    text = " ".join(found.report().split())
    assert f"f: {have} of 64 samples have it, and quantiles are those of these alone" in text
    assert f"f: {whole} of 32 points have all their members; the others are left out of its indices" in text
    assert "c does not vary; it has no Sobol' indices" in text
    assert found.quantiles((0.5,)).loc[("f", 0.5), "value"] == pytest.approx(
        np.median(rows[:, :2][rows[:, :2] <= 0.9])
    )


def test_a_picture_leaves_out_numbers_without_indices():
    found, rows = partial()
    assert [axes.get_xlabel() for axes in found.plot_indices().axes] == ["part of the variance of the f"]
    with pytest.raises(vr.InputError, match="c does not vary"):
        found.plot_indices(name="c")
    have = int((rows[:, :2] <= 0.9).sum())
    labels = {axes.get_xlabel(): axes.get_ylabel() for axes in found.plot().axes}
    assert labels == {"c": "part of the members below", "f": f"part of the {have} members that have it"}


def test_heads_have_units_in_tables_of_all_kinds(held):
    """Of a table, of columns, of rows, of a product and of constants; lists have the unit in each of their numbers."""
    head = f"{WIDTH} [mm]"
    frame = pd.DataFrame({head: [10.0, 20.0]})
    for values in (
        frame,
        {head: [10.0, 20.0]},
        frame.to_dict("records"),
        [row for _, row in frame.iterrows()],
    ):
        assert rows_of(values).columns == {WIDTH: ["10.0 mm", "20.0 mm"]}
    whole = rows_of(
        {"loads[0].value [mN]": [[0.0, 0.1, 0.0]]}, grid={head: [10]}, constants={"rods.beam.d1 [1]": 2}
    )
    assert whole.columns == {
        "loads[0].value": [["0.0 mN", "0.1 mN", "0.0 mN"]],
        WIDTH: ["10 mm"],
        "rods.beam.d1": ["2 1"],
    }
    found = vr.sweep(held, frame, quantities=TIP, workers=1, errors=0).table()
    assert found[WIDTH].tolist() == [0.01, 0.02]
    assert found["tip"].is_monotonic_decreasing
    with pytest.raises(InputError, match=r"two columns have this key"):
        rows_of({head: [10.0], WIDTH: [0.02]})
    with pytest.raises(InputError, match=r"10 kg"):
        vr.sweep(held, {f"{WIDTH} [kg]": [10]}, quantities=TIP, workers=1)


def test_a_shipped_case_that_was_not_copied_is_named(tmp_path):
    for name in ("cantilever_swing", "cantilever_swing.toml"):
        with pytest.raises(InputError, match="viscorod example cantilever_swing copies it"):
            vr.sweep(tmp_path / name, {FORCE: [1e-4]})


def ishigami(result):
    """Ishigami and Homma (1990) of the three components of a small force [micronewton], read from the result's case."""
    x, y, z = 1e6 * np.array(json.loads(result.data.attrs["case"])["loads"][0]["value"])
    return np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)


def test_sobol_indices_of_a_function_of_results_are_those_in_closed_form(held):
    """Saltelli et al. 2008, section 4.7, with a = 7 and b = 0.1; 320 members are computed for them."""
    force = {f"loads[0].value[{k}]": scipy.stats.uniform(-np.pi * 1e-6, 2e-6 * np.pi) for k in range(3)}
    found = vr.ensemble(held, force, 64, quantities={"f": ishigami}, indices=True, workers=1, errors=0)
    table = found.indices().loc["f"]
    for name, exact in (("first", (0.3139, 0.4424, 0.0)), ("total", (0.5576, 0.4424, 0.2437))):
        for key, value in zip(force, exact, strict=True):
            low, high = table.loc[key, f"{name}_lower"], table.loc[key, f"{name}_upper"]
            assert low <= value <= high, (name, key)
            assert high - low < 0.6


def test_numbers_of_modes_that_are_followed():
    """Against the diagram itself, and at rest against a search for modes, which is another solution."""
    still = content("modes", count=2) | {"loads": []}
    hertz = (
        vr.sweep(case_from_dict(still), {MODULUS: [1e6]}, workers=1, errors=0).members[0].result.frequencies
    )
    asked = {"c": ("critical_speed", 1), "rest": ("frequency", 1, 0), "named": ("frequency", "bend_1 1", 0.0)}
    asked |= {"none": ("frequency", 1, 5.0), "limit": ("limit", 1)}
    turning = content("campbell", axis=[0.0, 0.0, 1.0], speeds=[0.0, 10.0, 20.0]) | {"loads": []}
    given = {"workers": 1, "errors": 0, "quantities": asked, "fields": True}
    member = vr.sweep(case_from_dict(turning), {MODULUS: [1e6]}, **given).members[0]
    found, diagram = member.quantities, member.result
    # at rest |s| is more than |Im s| by half the square of the damping ratio
    ratio = diagram.damping_ratios[0, 0]
    assert found["rest"] == pytest.approx(hertz[0] * np.sqrt(1.0 - ratio**2), rel=1e-8)
    assert found["named"] == diagram.frequencies[0, diagram.modes.index("bend_1 1")]
    assert found["c"] == diagram.critical_speeds[0].speed
    assert "none: nothing is computed at 5; modes are followed at 0, 10, 20" in member.message
    assert "limit: there is none" in member.message
    for words, why in [
        (("frequency", 1), "2 more words are needed"),
        (("limit", "bend_1 1"), "numbers only"),
    ]:
        with pytest.raises(vr.InputError, match=why):
            vr.sweep(case_from_dict(turning), {MODULUS: [1e6]}, quantities={"f": words}, workers=1)


def test_small_motions_of_a_steady_rotation_are_numbers_of_members():
    """Independent: a Campbell diagram at the same speed, whose frequencies are |Im s|."""
    spin = content("steady", spin=[0.0, 0.0, 10.0]) | {"loads": []}
    asked = {"f": ("frequency", 1), "named": ("frequency", "bend_1 1"), "ratio": ("damping_ratio", 1)}
    found = vr.sweep(case_from_dict(spin), {MODULUS: [1e6]}, workers=1, errors=0, quantities=asked).members[0]
    turning = content("campbell", axis=[0.0, 0.0, 1.0], speeds=[0.0, 10.0]) | {"loads": []}
    asked = {"f": ("frequency", 1, 10.0)}
    other = vr.sweep(
        case_from_dict(turning), {MODULUS: [1e6]}, workers=1, errors=0, quantities=asked
    ).members[0]
    first = found.quantities["f"] * np.sqrt(1.0 - found.quantities["ratio"] ** 2)
    assert first == pytest.approx(other.quantities["f"], rel=1e-7)
    assert found.quantities["named"] > 0.0
