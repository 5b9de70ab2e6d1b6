"""Single pictures: what they show is what is stored, in units that are said."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.rigid_motions import LENGTH, along, rigid
from helpers.synthetic_results import LENGTH as ARC
from helpers.synthetic_results import oscillator, rolled_up, swing
from viscorod.cli.app import app
from viscorod.pictures.plots.plot_modes import draw_modes
from viscorod.pictures.plots.plot_motion import draw_tip
from viscorod.pictures.plots.plot_phase import draw_phase
from viscorod.pictures.plots.plot_strain import draw_space_time, draw_strain
from viscorod.results.array_pieces import extremes, largest
from viscorod.results.components import chosen_component
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run
from viscorod.solve.modes.vibrations import Vibrations


def test_tip_is_the_history_alone():
    figure = draw_tip(Run(swing()))
    assert len(figure.axes) == 1
    assert figure.axes[0].get_ylabel() == "displacement y of beam.end [m]"
    labels = figure.axes[0].get_legend_handles_labels()[1]
    assert any(label.startswith("envelope of the last cycles") for label in labels)


def test_phase_portrait_is_velocity_over_displacement():
    run = Run(swing())
    figure = draw_phase(run)
    axes = figure.axes[0]
    assert axes.get_xlabel() == "displacement y of beam.end [m]"
    assert axes.get_ylabel() == "velocity y [m/s]"
    points = axes.collections[0].get_segments()
    time = np.linspace(0.0, 10.0, len(points) + 1)[:-1]
    x, v = oscillator(time, 0.05, 3.6, 0.2)
    assert np.array([segment[0] for segment in points]) == pytest.approx(np.stack([x, v], axis=-1), abs=1e-6)
    assert draw_phase(run, "beam@0.1", "x").axes[0].get_xlabel() == "displacement x of beam@0.1 [m]"


def test_space_time_shows_the_section_force():
    figure = draw_space_time(Run(rigid(0.02)), component="stretch")
    axes, bar = figure.axes
    assert axes.get_title(loc="left") == "Normal force along rod"
    assert bar.get_ylabel() == "force [N]"
    image = axes.collections[0]
    values = np.asarray(image.get_array()).reshape(120, 600)
    s, t = np.linspace(0.0, LENGTH, 120), np.linspace(0.0, 2.0, 600)
    assert values == pytest.approx(along(s)[0][:, None] * np.cos(3.0 * t), abs=1e-4)
    low, high = image.get_clim()
    assert low == -high  # white is zero
    assert high == pytest.approx(np.abs(values).max())


def test_dissipation_is_shown_from_zero():
    image = draw_space_time(Run(rigid(0.02)), "dissipation").axes[0].collections[0]
    assert image.get_clim()[0] == 0.0


def test_strain_shows_the_largest_of_every_component_and_profiles():
    run = Run(swing())
    figure = draw_strain(run)
    left, right, profile = figure.axes[:3]
    assert left.get_ylabel() == "largest size along the rods [%]"
    assert right.get_ylabel() == "largest size along the rods [1/m]"
    bend = next(line for line in right.lines if line.get_label() == "bend 1")
    q, _ = oscillator(run.time, 0.05, 3.6, 0.2)
    assert bend.get_ydata() == pytest.approx(2.0 / ARC**2 * np.abs(q))
    assert profile.get_ylabel() == "curvature about d1 [1/m]"
    assert profile.get_xlabel() == "arc length of beam [m]"
    lines = [line for line in profile.lines if len(line.get_xdata()) > 2]
    at, _ = oscillator(np.linspace(0.0, 10.0, 9), 0.05, 3.6, 0.2)
    assert [line.get_ydata()[60] for line in lines] == pytest.approx(-2.0 / ARC**2 * at, abs=1e-3)


def test_component_that_changes_most():
    data = rigid(0.05)
    run = Run(data)
    # 0.1 m times a range of 5 N, against one of 0.2 N m
    assert chosen_component(run, "section_force", None).name == "normal force"
    data["section_force"] = data["section_force"] * np.array([1.0, 1.0, 1.0, 10.0, 1.0, 1.0])
    assert chosen_component(Run(data), "section_force", None).name == "bending moment about d1"
    assert chosen_component(run, "section_force", "stretch").unit == "N"
    low, high = extremes(run, "section_force")
    assert high[:, 2] == pytest.approx(along(run.data["point_s"].values)[0])
    assert np.all(low <= high)
    assert largest(run, "section_force")[0, 2] == pytest.approx(high[:, 2].max())


@pytest.mark.parametrize(
    ("draw", "message"),
    [
        (lambda run: draw_strain(run, "bend"), "component = 'bend' is none; it can be shear_1"),
        (lambda run: draw_strain(run, rod="x"), "rod = 'x': no rod is called so; it can be rod"),
        (lambda run: draw_space_time(run, "stress"), "quantity = 'stress' is not stored"),
        (lambda run: draw_space_time(run, "dissipation", "twist"), "dissipation has no components"),
        (lambda run: draw_phase(run, axis="w"), "axis = 'w' is not a global axis"),
    ],
)
def test_wrong_questions(draw, message):
    with pytest.raises(vr.InputError, match=message):
        draw(Run(rigid(0.1)))


def test_modes_are_drawn_in_their_planes_with_their_numbers():
    run = Run(swing())
    s = run.data["station_s"].values
    shapes = np.zeros((3, s.size, 3), dtype=complex)
    shapes[0, :, 1] = 1j * (s / ARC) ** 2  # whatever the phase
    shapes[1, :, 2] = (s / ARC) ** 2
    shapes[2, :, 1] = s / ARC
    rest = run.data["reference_position"].values
    values = np.array([0.0j, -0.1 + 2.0j, -9.0 + 0.0j])
    modes = Vibrations(
        eigenvalues=values,
        frequencies=np.abs(values) / (2 * np.pi),
        damping_ratios=np.array([0.0, 0.1 / 2.0025, 1.0]),
        shapes=shapes,
        rotations=shapes,
        positions=rest,
        residuals=np.zeros(3),
        names=("translation along y", "bend_1 1", "bend_2 1"),
        shares=np.zeros((3, 6)),
        rigid=1,
        certified=True,
    )
    figure = draw_modes(run, modes)
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == [
        "1: translation along y\nnothing resists it\nin the xy plane",
        "2: bend_1 1\n0.3187 Hz, damping ratio 0.0499\nin the xz plane",
        "3: bend_2 1\noverdamped, decays at 9 1/s\nin the xy plane",
    ]
    line = next(line for line in figure.axes[0].lines if line.get_label() == "mode")
    assert np.abs(line.get_ydata()).max() == pytest.approx(0.15 * ARC)


def invoke(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.parametrize("what", ["tip", "energy", "strain", "space-time", "phase"])
def test_command_writes_a_picture_beside_the_result(what, tmp_path):
    Run(swing(duration=4.0)).save(tmp_path / "run.nc")
    result = invoke("plot", tmp_path / "run.nc", "--what", what)
    assert result.exit_code == 0, result.output
    assert (tmp_path / f"{what}.png").stat().st_size > 10_000


def test_modes_of_the_model_in_a_result(tmp_path):
    """The first bending modes of a slender cantilever: frequencies in the ratio (4.6941/1.8751)^2."""
    case = {
        "rods": {
            "beam": {
                "shape": "straight",
                "start": [0, 0, 0],
                "end": [ARC, 0, 0],
                "section": {"shape": "rectangle", "width": 0.002, "height": 0.003},
                "material": {"youngs_modulus": 2e9, "poissons_ratio": 0.3, "density": 1000.0},
                "elements": 2,
                "order": 5,
            }
        },
        "supports": [{"kind": "clamp", "at": "beam.start"}],
    }
    data = swing(duration=1.0).assign_attrs(case=json.dumps(case))
    Run(data).save(tmp_path / "run.nc")
    result = invoke(
        "plot",
        tmp_path / "run.nc",
        "--what",
        "modes",
        "--count",
        4,
        "--about",
        "reference",
        "-o",
        tmp_path / "m.svg",
    )
    assert result.exit_code == 0, result.output
    assert (tmp_path / "m.svg").stat().st_size > 10_000
    # Euler-Bernoulli: f = (1.8751/L)^2 sqrt(E h^2/(12 rho))/(2 pi)
    lowest = (1.8751 / ARC) ** 2 * np.sqrt(2e9 * 0.002**2 / 12.0 / 1000.0) / (2.0 * np.pi)
    text = (tmp_path / "m.svg").read_text()
    said = [line.strip("<!- >") for line in text.splitlines() if "<!-- " in line]
    first = said[said.index("1: bend_2 1") + 1]
    assert float(first.split(" Hz")[0]) == pytest.approx(lowest, rel=2e-3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run.nc", "--what", "colours"], "--what: colours: no such picture"),
        (["run.nc", "--what", "energy", "--place", "beam.end"], "--place: beam.end: goes with tip and phase"),
        (["run.nc", "--what", "phase", "--count", "3"], "--count: 3: goes with modes"),
        (["arc.nc", "--what", "tip"], "--what tip needs a motion over time"),
        (["run.nc", "--what", "modes"], "cannot be rebuilt for its modes"),
        (["run.nc", "--what", "tip", "-o", "tip.doc"], "is not a picture format"),
    ],
)
def test_wrong_commands(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Run(swing(duration=1.0)).save("run.nc")
    Equilibrium(rolled_up()).save("arc.nc")
    result = invoke("plot", *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert "Traceback" not in result.output
