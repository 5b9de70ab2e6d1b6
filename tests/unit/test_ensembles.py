"""Ensembles against closed forms: the Ishigami function, a beam whose load and modulus are lognormal."""

import math

import numpy as np
import pytest
import scipy.stats
from typer.testing import CliRunner

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat
from helpers.strip import content
from viscorod.analyses.ensemble import _saltelli_rows
from viscorod.analyses.sweeps.points import points_of, uniform_points
from viscorod.casefile.case import case_from_dict
from viscorod.cli.app import app
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.sweep_members import SweepRun
from viscorod.results.sweep_result import Sweep

FORCE, MODULUS = "loads[0].value[1]", "materials.rubber.youngs_modulus"
TIP = {"tip": ("displacement", "beam.end", "y")}
SPREAD = {
    FORCE: scipy.stats.lognorm(0.3, scale=1e-4),
    MODULUS: scipy.stats.lognorm(0.1, scale=1e6),
}


@pytest.fixture
def held():
    return case_from_dict(content("equilibrium"))


@pytest.fixture(scope="module")
def beam():
    """A beam that stays linear: its tip is F L^3 / 3 E I (1 + shear), a lognormal number of deviation sqrt(0.1)."""
    case = case_from_dict(content("equilibrium"))
    return vr.ensemble(case, SPREAD, 16, quantities=TIP, seed=3, indices=True, workers=1, errors=2)


def ishigami(n, seed):
    """f = sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, of uniform numbers from -pi to pi (Ishigami and Homma 1990)."""
    distributions = dict.fromkeys("abc", scipy.stats.uniform(-math.pi, 2.0 * math.pi))
    rows = points_of(_saltelli_rows(uniform_points(n, 6, seed), 3), distributions)
    x, y, z = rows.values()
    values = np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
    members = [
        SweepRun(k, {key: rows[key][k] for key in rows}, None, "", "completed", {"f": value})
        for k, value in enumerate(values)
    ]
    return Ensemble.of_sweep(Sweep(members), Design(("a", "b", "c"), ("uniform",) * 3, n, seed, True)), values


def test_indices_of_the_ishigami_function():
    """Closed forms: variance 13.8446; first indices 0.3139, 0.4424, 0; total ones 0.5576, 0.4424, 0.2437."""
    found, values = ishigami(1024, 1)
    table = found.indices().loc["f"]
    np.testing.assert_allclose(table["first"], [0.3139, 0.4424, 0.0], atol=0.02)
    np.testing.assert_allclose(table["total"], [0.5576, 0.4424, 0.2437], atol=0.02)
    for kind in ("first", "total"):
        assert (table[f"{kind}_lower"] < table[kind]).all()
        assert (table[kind] < table[f"{kind}_upper"]).all()
        assert (table[f"{kind}_upper"] - table[f"{kind}_lower"] < 0.3).all()
    rows = values.reshape(-1, 5)
    given = {"f_A": rows[:, 0][None], "f_B": rows[:, 1][None], "f_AB": rows[:, 2:].T[:, None, :]}
    other = scipy.stats.sobol_indices(func=given, n=1024)
    np.testing.assert_allclose(table["first"], other.first_order, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(table["total"], other.total_order, rtol=1e-12, atol=1e-14)
    assert found.moments().loc["f", "mean"] == pytest.approx(3.5, abs=0.02)
    assert found.moments().loc["f", "deviation"] == pytest.approx(math.sqrt(13.8446), rel=0.02)


def test_quantiles_of_a_lognormal_tip(beam):
    """ln tip has the deviation sqrt(0.3^2 + 0.1^2); indices (e^a - 1)/(e^(a + b) - 1) of a product of lognormals."""
    a, b = 0.09, 0.01
    median = 1e-4 * 0.3**3 / (3.0 * 1e6 * 0.01**4 / 12.0) * (1.0 + 0.5 * 1.3 * (0.01 / 0.3) ** 2 * 6 / 5)
    exact = scipy.stats.lognorm(math.sqrt(a + b), scale=median)
    table = beam.quantiles((0.25, 0.5, 0.75)).loc["tip"]
    for level, row in table.iterrows():
        assert row["lower"] <= exact.ppf(level) <= row["upper"]
        assert row["value"] == pytest.approx(exact.ppf(level), rel=0.1)
    indices = beam.indices().loc["tip"]
    first = [math.expm1(a) / math.expm1(a + b), math.expm1(b) / math.expm1(a + b)]
    np.testing.assert_allclose(indices["first"], first, atol=0.2)
    assert (indices["first_lower"] < first).all()
    assert (first < indices["first_upper"]).all()
    assert beam.quantiles((0.001,)).iloc[0]["lower"] == -np.inf


@pytest.mark.parametrize("way", ["independent", "sobol"])
def test_intervals_of_quantiles_hold(way):
    """Of 128 independent lognormal numbers 95 % of the intervals hold the exact quantile, of Sobol' points more."""
    kind, levels, count = scipy.stats.lognorm(0.5), (0.05, 0.5, 0.95), 100
    hits = np.zeros(3)
    for seed in range(count):
        if way == "independent":
            values = kind.rvs(size=128, random_state=seed)
        else:
            values = points_of(uniform_points(128, 1, seed), {"a": kind})["a"]
        members = [SweepRun(k, {"a": one}, None, "", "completed", {"f": one}) for k, one in enumerate(values)]
        found = Ensemble.of_sweep(Sweep(members), Design(("a",), ("lognorm",), 128, seed, False))
        table = found.quantiles(levels).loc["f"]
        exact = kind.ppf(levels)
        hits += (table["lower"] <= exact) & (exact <= table["upper"])
    part = hits / count
    spread = math.sqrt(0.95 * 0.05 / count)
    assert (part > 0.95 - 3.0 * spread).all()
    if way == "sobol":
        assert (part == 1.0).all()


def sum_of_normals(seed, n, d=4, missing=0.0):
    """An ensemble of the sum of independent normal numbers, whose quantiles and mean are known."""
    z = scipy.stats.norm.ppf(uniform_points(n, d, seed)).sum(axis=1) / math.sqrt(d)
    lost = np.random.default_rng(seed).random(n) < missing
    members = [
        SweepRun(k, {"a": 0.0}, None, "", "completed", {} if gone else {"f": one})
        for k, (one, gone) in enumerate(zip(z, lost, strict=True))
    ]
    return Ensemble.of_sweep(Sweep(members), Design(("a",), ("norm",), n, seed, False))


@pytest.mark.parametrize("missing", [0.0, 0.3])
def test_intervals_tell_how_evenly_sobol_points_lie(missing):
    """Of 256 points in four dimensions: 95 % hold the exact quantile, and that of the median is a third narrower."""
    levels, count, n = (0.05, 0.5, 0.95), 60, 256
    exact = scipy.stats.norm.ppf(levels)
    hits, widths, independent = np.zeros(3), [], []
    for seed in range(count):
        found = sum_of_normals(seed, n, missing=missing)
        table = found.quantiles(levels).loc["f"]
        hits += (table["lower"] <= exact) & (exact <= table["upper"])
        widths.append(table["upper"][0.5] - table["lower"][0.5])
        interval = scipy.stats.quantile_test(found.values("f"), p=0.5).confidence_interval(0.95)
        independent.append(interval.high - interval.low)
    assert (hits / count > 0.95 - 3.0 * math.sqrt(0.95 * 0.05 / count)).all()
    ratio = np.mean(widths) / np.mean(independent)
    assert ratio < 0.75 if not missing else ratio < 1.1


def test_errors_of_means_tell_how_evenly_sobol_points_lie():
    """The root mean square error of 60 ensembles is at most what they tell, which is a fourth of 1/sqrt(n)."""
    tables = [sum_of_normals(seed, 256).moments().loc["f"] for seed in range(60)]
    told = math.sqrt(np.mean([table["error"] ** 2 for table in tables]))
    real = math.sqrt(np.mean([table["mean"] ** 2 for table in tables]))
    assert real < 1.1 * told
    assert told < 0.25 / 16.0


def test_quantiles_of_few_values_lie_between_them():
    """Of two values of the same probability the median is one or the other, and the interval has both."""
    values = (uniform_points(256, 2, 3)[:, 0] < 0.5).astype(float)
    members = [SweepRun(k, {"a": 0.0}, None, "", "completed", {"f": one}) for k, one in enumerate(values)]
    found = Ensemble.of_sweep(Sweep(members), Design(("a",), ("uniform",), 256, 3, False))
    row = found.quantiles((0.5,)).iloc[0]
    assert (row["lower"], row["upper"]) == (0.0, 1.0)


def test_counts_are_whole_numbers():
    column = points_of(uniform_points(64, 1, 1), {"rods.beam.elements": scipy.stats.randint(1, 4)})
    values = column["rods.beam.elements"]
    assert values.dtype == int
    assert np.bincount(values).tolist()[1:] in ([21, 22, 21], [22, 21, 21], [21, 21, 22])  # a third each


def test_impossible_draws_say_what_to_draw_from(held):
    spread = {"sections.thin.width": scipy.stats.norm(0.01, 0.01)}
    with pytest.raises(
        vr.InputError, match=r"norm\(0.01, 0.01\) gives such values; truncnorm, lognorm or uniform"
    ):
        vr.ensemble(held, spread, 32, quantities=TIP, workers=1)


def test_a_report_has_prefixes_and_begins_with_what_matters_most(held):
    named = {"tip [m]": TIP["tip"]}
    found = vr.ensemble(held, SPREAD, 16, quantities=named, seed=3, indices=True, workers=1, errors=0)
    lines = found.report().splitlines()
    at = next(k for k, line in enumerate(lines) if line.startswith("Quantiles of tip [mm]"))
    shown = [float(line.split("%")[1].split()[0]) for line in lines[at + 2 : at + 5]]
    np.testing.assert_allclose(shown, 1e3 * found.quantiles((0.05, 0.5, 0.95))["value"], rtol=1e-5)
    at = next(k for k, line in enumerate(lines) if line.startswith("Sobol' indices of tip,"))
    first = found.indices()["total"].idxmax()[1]
    assert lines[at + 2].split()[0] == first


def test_an_ensemble_is_kept(beam, tmp_path):
    loaded = vr.load(beam.save(tmp_path / "ensemble.nc"))
    assert isinstance(loaded, vr.Ensemble)
    assert loaded.report() == beam.report()
    assert loaded.design == beam.design
    for words in (
        "64 members, 64 completed",
        "lognorm(0.3, scale=0.0001)",
        "first half",
        "Sobol' indices",
        "(2 of 64 members)",
    ):
        assert words in flat(beam.report())
    assert written(beam.plot, tmp_path / "quantiles.png").stat().st_size > 5000
    assert written(beam.plot_indices, tmp_path / "indices.svg").stat().st_size > 5000


def test_a_larger_ensemble_goes_on_with_a_smaller_one(held, tmp_path):
    given = {"quantities": TIP, "workers": 1, "seed": 5, "errors": 1}
    small = vr.ensemble(held, SPREAD, 4, folder=tmp_path / "e", **given)
    lines = [path.read_text().count("name") for path in (tmp_path / "e" / "members").iterdir()]
    large = vr.ensemble(held, SPREAD, 8, folder=tmp_path / "e", **given)
    again = [path.read_text().count("name") for path in (tmp_path / "e" / "members").iterdir()]
    assert (sum(lines), sum(again)) == (4, 8)
    assert (
        large.table()[:4]
        .drop(columns=["wall_time_s", "mesh_error"])
        .equals(small.table().drop(columns=["wall_time_s", "mesh_error"]))
    )
    assert large.table()["tip"].tolist() == vr.ensemble(held, SPREAD, 8, **given).table()["tip"].tolist()
    assert vr.load(tmp_path / "e").report() == large.report()


def test_a_gaussian_copula():
    """Correlated normals have the correlation itself; a lognormal made of one keeps its quantiles and its ranks."""
    uniform = uniform_points(4096, 2, 1)
    kinds = {"x": scipy.stats.norm(2.0, 3.0), "y": scipy.stats.lognorm(0.5)}
    points = points_of(uniform, kinds, [[1.0, -0.7], [-0.7, 1.0]])
    assert np.corrcoef(points["x"], np.log(points["y"]))[0, 1] == pytest.approx(-0.7, abs=0.01)
    spearman = scipy.stats.spearmanr(points["x"], points["y"]).statistic
    assert spearman == pytest.approx(6.0 / math.pi * math.asin(-0.35), abs=0.01)
    for key, kind in kinds.items():
        np.testing.assert_allclose(
            np.quantile(points[key], (0.1, 0.5, 0.9)), kind.ppf((0.1, 0.5, 0.9)), rtol=0.02
        )


def test_failed_members_are_left_out_of_indices():
    found, _ = ishigami(64, 2)
    members = list(found.members)
    members[7] = SweepRun(7, members[7].values, None, "it broke", "failed")
    lacking = Ensemble.of_sweep(Sweep(members), found.design)
    whole = Ensemble.of_sweep(
        Sweep([m for k, m in enumerate(found.members) if k // 5 != 1]), Design("abc", ("",) * 3, 63, 2, True)
    )
    assert lacking.indices()[["first", "total"]].equals(whole.indices()[["first", "total"]])
    assert len(lacking.values("f")) == 128
    assert "member 7: it broke" in flat(lacking.report())


def test_a_picture_of_too_few_members_says_how_many_are_needed(held):
    """It said that no member had a number."""
    found = vr.ensemble(held, SPREAD, 4, quantities=TIP, workers=1, errors=0)
    with pytest.raises(vr.InputError, match="tip: 4 members have it; 8 are needed"):
        found.plot()


def test_a_number_that_few_members_have_leaves_the_others_theirs(held, tmp_path):
    """What of the whole ensemble can be told is told."""
    found = vr.ensemble(
        held,
        SPREAD,
        16,
        quantities=TIP | {"never": lambda _: math.nan, "same": lambda _: 2.0},
        workers=1,
        errors=0,
        indices=True,
    )
    assert found.numbers == ("tip", "same")
    assert found.scarce == ("never: 0 members have it; 8 are needed",)
    assert list(found.quantiles([0.5]).index) == [("tip", 0.5), ("same", 0.5)]
    assert found.quantiles(0.5).loc[("same", 0.5), "value"] == 2.0
    assert list(found.indices().index.unique(level="quantity")) == ["tip"]  # the other does not vary
    assert list(found.moments().index) == ["tip", "same"]
    assert "Quantiles of tip" in found.report()
    assert "never: 0 members have it; 8 are needed" in found.report()
    found.plot(tmp_path / "all.png")
    with pytest.raises(vr.InputError, match="never: 0 members have it"):
        found.values("never")
    for levels in ("tip", [1.5], [0.5, "a"], None):
        with pytest.raises(vr.InputError, match="levels"):
            found.quantiles(levels)


WRONG = [
    ({"n": 100}, "n: 100: Sobol' points are balanced in powers of two only; give 128"),
    ({"seed": -1}, "seed: -1: a whole number from 0 on"),
    ({"distributions": {FORCE: 3.0}}, "this is no distribution; give a frozen distribution of SciPy"),
    (
        {"distributions": {FORCE: scipy.stats.norm}},
        "scipy.stats.norm: this is a kind of distribution; its param",
    ),
    ({"distributions": {FORCE: scipy.stats.norm(0.0, -1.0)}}, "its parameters give no numbers"),
    ({"distributions": {}}, "keys of the case file with their distributions are needed"),
    ({"quantities": {}}, "there is nothing to tell of"),
    ({"correlation": [[1.0, 2.0], [2.0, 1.0]]}, "it is not positive definite"),
    ({"correlation": [1.0, 0.5]}, "no matrix of the correlations of 2 numbers"),
    ({"correlation": np.eye(2), "indices": True}, "parts of a variance belong to independent numbers"),
    ({"distributions": {"rods.beam.lenght": SPREAD[FORCE]}}, "no such key"),
]


@pytest.mark.parametrize(("changes", "words"), WRONG)
def test_what_is_wrong_is_refused(held, changes, words):
    given = {"distributions": SPREAD, "n": 8, "quantities": TIP, "workers": 1} | changes
    with pytest.raises(vr.InputError) as caught:
        vr.ensemble(held, **given)
    assert words in str(caught.value)


def test_a_fan_of_histories(tmp_path):
    case = case_from_dict(content("simulate", duration=0.1, time_step=0.01))
    way = {"way": ("displacement", "beam.end", "y", "history")}
    found = vr.ensemble(
        case, {FORCE: scipy.stats.uniform(5e-4, 1e-3)}, 4, quantities=way, workers=1, errors=1
    )
    assert found.data["way"].shape == (4, 201)
    start = found.data["way"].values[:, 0]
    assert np.argsort(start).tolist() == np.argsort(found.data[FORCE].values).tolist()
    assert written(found.plot_fan, tmp_path / "fan.png", "way").stat().st_size > 5000
    with pytest.raises(vr.InputError, match="is no history"):
        found.plot_fan(tmp_path / "fan.png", "tip")


def test_command_line(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(app, ["example", "bend_45"]).exit_code == 0
    arguments = ["ensemble", "bend_45.toml", "--draw", "loads[0].value[2]=norm(300, scale=10)", "-n", "8"]
    asked = ["--quantity", "tip=displacement bend.end z", "--workers", "1", "--set", "rods.bend.elements=2"]
    part = CliRunner().invoke(app, [*arguments, *asked, "--members", "0:2"])
    assert part.exit_code == 0, part.output
    assert "2 of 2 members" in part.stderr  # of its own, not of all
    assert "6 members were not run" in part.stdout
    found = CliRunner().invoke(app, [*arguments, *asked])
    assert found.exit_code == 0, found.output
    assert "8 members, 8 completed" in found.stdout
    assert "not run" not in found.stdout
    assert "norm(300, scale=10)" in found.stdout
    assert len(vr.load(tmp_path / "out" / "bend_45" / "ensemble").values("tip")) == 8
    for wrong in ("loads[0].value[2]", "loads[0].value[2]=nrom(1, 2)", "loads[0].value[2]=norm(a)"):
        refused = CliRunner().invoke(app, ["ensemble", "bend_45.toml", "--draw", wrong, *asked])
        assert refused.exit_code == 2, refused.output
