"""Pictures: what is in them, that they are written, that nothing warns or touches global state."""

import numpy as np
import pytest
from matplotlib.text import Text

from helpers.pictures import written
from helpers.synthetic_results import rolled_up, swing
from viscorod import InputError
from viscorod.pictures.plots.plot_energy import draw_energy
from viscorod.pictures.plots.plot_motion import draw_motion
from viscorod.pictures.plots.plot_shape import draw_shape
from viscorod.pictures.plots.projection_view import View
from viscorod.pictures.style import legend_over, titled
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run
from viscorod.results.text_numbers import scaled


def texts(figure):
    return [axes.get_title(loc="left") for axes in figure.axes], [axes.get_ylabel() for axes in figure.axes]


def test_motion_has_history_snapshots_and_damping():
    figure = draw_motion(Run(swing()))
    titles, labels = texts(figure)
    assert "displacement y of beam.end [m]" in labels
    assert "damping ratio" in labels
    assert "Rod in the xy plane, first period" in titles
    history = figure.axes[0]
    legend = [text.get_text() for text in history.get_legend().get_texts()]
    assert legend[2] == "envelope of the last cycles, exp(\N{MINUS SIGN}t / 5.56 s)"
    envelope = next(line for line in history.lines if line.get_linestyle() == "--")
    time = envelope.get_xdata()
    assert envelope.get_ydata() == pytest.approx(0.2 * np.exp(-0.05 * 3.6 * time), rel=1e-5)


def test_motion_out_of_plane_is_drawn_in_space():
    data = swing(rods=("left", "right"), duration=4.0)
    figure = draw_motion(Run(data))
    assert "Rods in space, first period" in texts(figure)[0]


def test_motion_of_another_place():
    _, labels = texts(draw_motion(Run(swing()), "beam@0.1"))
    assert "displacement y of beam@0.1 [m]" in labels
    _, labels = texts(draw_motion(Run(swing()), "beam.end", "x"))
    assert any(label.startswith("displacement x") for label in labels)


@pytest.mark.parametrize("states", [1, 2, 40])
def test_short_runs_are_drawn_without_cycles(states, tmp_path):
    run = Run(swing().isel(time=slice(0, states)))
    assert "damping ratio" not in texts(draw_motion(run))[1]
    assert written(run.plot, tmp_path / "motion.png").stat().st_size > 10_000
    assert written(run.plot_energy, tmp_path / "energy.png").stat().st_size > 10_000


def test_energy_shows_the_account_and_its_remainder():
    figure = draw_energy(Run(swing(leak=1e-3)))
    upper, lower = figure.axes
    legend = [text.get_text() for text in upper.get_legend().get_texts()]
    assert legend == [
        "lost to viscosity",
        "elastic",
        "kinetic",
        "numerical remainder",
        "initial energy + work done",
    ]
    assert upper.get_ylabel() == "energy [mJ]"
    assert lower.get_yscale() == "log"
    assert lower.get_title(loc="left").startswith("Numerical remainder: at most 0.097 %")


def test_shape_shows_the_way_to_the_equilibrium(tmp_path):
    equilibrium = Equilibrium(rolled_up())
    legend = draw_shape(equilibrium).axes[0].get_legend()
    assert [text.get_text() for text in legend.get_texts()] == [
        "reference",
        "on the way",
        "equilibrium",
        "support",
    ]
    assert written(equilibrium.plot, tmp_path / "new" / "shape.svg").stat().st_size > 10_000


@pytest.mark.parametrize("title", ["", "A strip that is rolled up"])
@pytest.mark.parametrize("rows", [1, 2, 3])
def test_headings_over_legends_are_within_the_picture(title, rows):
    """However many rows the legend has: below the title of the case, and above its legend."""
    picture = titled(Run(swing().assign_attrs(title=title)), 8.0, 6.4)
    axes = picture.add_subplot()
    for number in range(2 * rows):
        axes.plot([0, 1], [0, 1], label=f"line {number}")
    axes.set_title("Heading", loc="left")
    legend_over(axes, 2)
    renderer = picture.canvas.get_renderer()
    picture.draw(renderer)
    (heading,) = (text for text in axes.findobj(Text) if text.get_text() == "Heading")
    box, legend = heading.get_window_extent(renderer), axes.get_legend().get_window_extent(renderer)
    above = picture.bbox.y1
    if title:
        (name,) = (text for text in picture.texts if text.get_text() == title)
        above = name.get_window_extent(renderer).y0
    assert legend.y1 <= box.y0 + 4.0
    assert box.y1 <= above


def test_pictures_leave_no_global_figures(tmp_path):
    import matplotlib.pyplot as plt

    Run(swing(duration=4.0)).plot(tmp_path / "motion.png")
    assert plt.get_fignums() == []


def test_unknown_format_is_an_input_error(tmp_path):
    with pytest.raises(InputError, match=r"'\.docx' is not a picture format; use .*\.png"):
        Equilibrium(rolled_up()).plot(tmp_path / "shape.docx")


@pytest.mark.parametrize("place", ["beam.end", "beam@0.1", "beam"])
def test_a_place_in_the_place_of_the_file_is_told_its_name(place):
    with pytest.raises(
        InputError, match="The first argument is the file; a place is given by its name, place ="
    ):
        Run(swing(duration=4.0)).plot_phase(place)


def test_view_is_the_plane_of_the_motion():
    points = np.random.default_rng(1).normal(size=(5, 7, 3))
    assert View.of(points).name == "in space"
    points[..., 1] *= 1e-6
    view = View.of(points)
    assert (view.plane, view.name) == ((0, 2), "in the xz plane")


def test_no_branch_hides_behind_the_trunk():
    """Of three branches at 120 degrees one is in the plane of the trunk and the usual eye, at whichever angle it is."""
    along = np.linspace(0.0, 1.0, 40)[:, None]
    trunk = along * [0.0, 0.0, 1.0]
    for first in (0.0, 30.0, 75.0):
        angles = np.radians(first + np.array([0.0, 120.0, 240.0]))
        directions = np.stack([np.cos(angles), np.sin(angles), np.zeros(3)], axis=1)
        lines = np.concatenate([trunk, *(0.5 * trunk[-1] + 0.4 * along * d for d in directions)])
        aside = np.abs(View.of(lines, lines=lines).projection @ directions.T)[0]
        assert aside.min() > np.sin(np.radians(10.0))
    hidden = [np.cos(np.radians(120.0)), np.sin(np.radians(120.0)), 0.0]
    assert abs((View.of(lines).projection @ hidden)[0]) < 1e-12  # the usual eye


@pytest.mark.parametrize(
    ("largest", "expected"),
    [(0.3, (1.0, "m")), (2e-3, (1e3, "mm")), (5e-6, (1e6, "µm")), (3e4, (1e-3, "km")), (0, (1, "m"))],
)
def test_prefixes(largest, expected):
    factor, unit = scaled("m", [0.0, -largest])
    assert (pytest.approx(factor), unit) == expected
