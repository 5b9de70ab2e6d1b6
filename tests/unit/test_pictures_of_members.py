"""Pictures of sweeps and ensembles: what is written stays in the picture, and rounding is drawn as nothing."""

import itertools

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.strip import content
from viscorod.analyses.sweeps.points import uniform_points
from viscorod.casefile.case import case_from_dict
from viscorod.cli.app import app
from viscorod.pictures.style import figure, without_round_off
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.sweep_members import SweepRun
from viscorod.results.sweep_result import Sweep

FORCE, MODULUS = "loads[0].value[1]", "materials.rubber.youngs_modulus"


def swept(others):
    """Members over a force and so many values of a modulus, with one number each."""
    members = [
        SweepRun(k, {FORCE: force, MODULUS: modulus}, None, "", "completed", {"tip [m]": force / modulus})
        for k, (force, modulus) in enumerate(
            itertools.product((1.0, 2.0, 3.0), np.linspace(1e6, 2e6, others))
        )
    ]
    return Sweep(members)


def drawn(values, n, indices=False):
    members = [SweepRun(k, {"a": 1.0}, None, "", "completed", dict(one)) for k, one in enumerate(values)]
    return Ensemble.of_sweep(Sweep(members, "A case"), Design(("a",), ("norm(1, 2)",), n, 1, indices))


def inside(picture, artist):
    """Whether a text or a legend lies in the picture."""
    box = artist.get_window_extent(picture.canvas.get_renderer())
    width, height = picture.canvas.get_width_height()
    return box.x0 >= 0 and box.y0 >= 0 and box.x1 <= width and box.y1 <= height


@pytest.mark.parametrize("others", [2, 3, 5, 6])
def test_a_legend_stays_in_the_picture_and_below_the_title(others):
    """Names of parameters are long: the fifth line's ran out on the right."""
    sweep = swept(others)
    sweep.title = "A case"
    picture = sweep.plot()
    picture.canvas.draw()
    legend = picture.axes[0].get_legend()
    assert len(legend.get_texts()) == others
    assert inside(picture, legend)
    render = picture.canvas.get_renderer()
    title = picture._suptitle.get_window_extent(render)
    assert legend.get_window_extent(render).y1 <= title.y0 + 0.3 * title.height
    assert picture.axes[0].get_window_extent(render).height > 300  # pixels: the axes keep their size


def test_axes_have_units(tmp_path):
    """Those of the case file's keys, also of a sweep that was kept; a key without one has none."""
    pytest.importorskip("pyarrow")
    case = case_from_dict(content("equilibrium"))
    values = {FORCE: [1e-4, 2e-4], "rods.beam.elements": [1, 2], "sections.thin.width": ["9 mm", "10 mm"]}
    grid = {MODULUS: [1e6, 2e6]}
    tip = {"tip [m]": ("displacement", "beam.end", "y")}
    sweep = vr.sweep(case, values, grid=grid, quantities=tip, workers=1, errors=0, folder=tmp_path / "sweep")
    kept = [tmp_path / "sweep", sweep.save(tmp_path / "sweep.nc"), sweep.save(tmp_path / "sweep.parquet")]
    for one in (sweep, *(vr.load(path, Sweep) for path in kept)):
        assert one.members.rows.units == {FORCE: "N", "sections.thin.width": "m", MODULUS: "Pa"}
        assert one.plot(x=MODULUS).axes[0].get_xlabel() == f"{MODULUS} [MPa]"
        assert one.plot(x="sections.thin.width").axes[0].get_xlabel() == "sections.thin.width [mm]"
        assert one.plot(x="rods.beam.elements").axes[0].get_xlabel() == "rods.beam.elements"
        label = one.plot(x=FORCE).axes[0].get_legend().get_texts()[0].get_text()
        assert "youngs_modulus = 1e+06 Pa" in label
        assert "width = 9 mm" in label
        assert one.data[MODULUS].attrs["units"] == "Pa"
        assert "units" not in one.data["rods.beam.elements"].attrs


@pytest.mark.parametrize("n", [8, 1024])
def test_intervals_without_bounds_are_arrows_and_are_told(n):
    """Of 8 members none bounds the outer quantiles, of 1024 all are bounded; each caption stays in its picture."""
    picture = drawn([{"f": value} for value in uniform_points(n, 1, seed=1)[:, 0]], n).plot()
    picture.canvas.draw()
    marks = [line.get_marker() for line in picture.axes[0].lines]
    few = n == 8
    assert ("<" in marks and ">" in marks) == few
    caption = picture.texts[-1]
    assert ("too few members for a bound" in " ".join(caption.get_text().split())) == few
    assert inside(picture, caption)


def test_a_scatter_of_an_ensemble_with_indices_shows_its_samples():
    """Of every point the rows A and B; the others repeat their values but for one, and would count as more members."""
    rng = np.random.default_rng(1)
    found = drawn([{"f": one} for one in rng.normal(size=3 * 16)], 16, indices=True)
    assert found.samples == 32
    shown = found.plot(x="a").axes[0].lines[0].get_ydata()
    assert sorted(shown) == sorted(found.values("f"))


def test_indices_of_all_quantities_have_one_scale():
    rng = np.random.default_rng(1)
    values = [{"f": value, "g": 100.0 * value + other} for value, other in rng.normal(size=(3 * 16, 2))]
    picture = drawn(values, 16, indices=True).plot_indices()
    one, other = (axes.get_xlim() for axes in picture.axes)
    assert one == other
    assert one[0] < 0.0
    assert one[1] > 1.0


@pytest.mark.parametrize(("spread", "flat"), [(1e-11, True), (0.0, True), (1e-6, False)])
def test_rounding_is_drawn_as_nothing(spread, flat):
    """A reaction that all members share was drawn as a zigzag over an axis of equal numbers."""
    axes = figure(4.0, 3.0).add_subplot()
    values = -1e-3 * (1.0 + spread * np.array([0.0, 1.0, 0.3]))
    axes.plot(values)
    without_round_off(axes.set_ylim, values)
    low, high = axes.get_ylim()
    assert (high - low > 1e-4) == flat
    assert low < values.min() < values.max() + 1e-12 < high


def test_the_command_draws_fans(tmp_path, monkeypatch):
    """A history that was asked for has its picture."""
    monkeypatch.chdir(tmp_path)
    model = case_from_dict(content("equilibrium")).model(vr.Model)
    (tmp_path / "strip.toml").write_text(model.to_toml(None, "simulate", duration=0.05))
    asked = [
        "--quantity",
        "tip [m]=displacement beam.end y history",
        "-n",
        "4",
        "--workers",
        "1",
        "--errors",
        "0",
    ]
    draw = ["--draw", "loads[0].value[1]=norm(1e-3, 1e-4)"]
    done = CliRunner().invoke(app, ["ensemble", "strip.toml", *draw, *asked])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "strip" / "fan.png").stat().st_size > 5000
