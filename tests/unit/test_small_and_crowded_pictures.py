"""Pictures of models of micrometres with many parts: prefixes on axes, names beside their rods, bodies, legends."""

import re
from itertools import pairwise

import numpy as np
import pytest
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from scipy.linalg import null_space
from scipy.spatial import ConvexHull

import viscorod as vr
from helpers import synthetic_results, viewer_pages
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.pictures.drawing.bodies_on_paper import corners_of
from viscorod.pictures.drawing.model_drawing import draw_assembly
from viscorod.pictures.plots.plot_energy import gravity_potential
from viscorod.pictures.plots.plot_modes import draw_modes
from viscorod.pictures.plots.swinging_shapes import Swing, after_turn
from viscorod.pictures.style import clean, figure, legend_above, with_prefixes
from viscorod.results.run import Run


@pytest.fixture(scope="module")
def comb():
    return load_case(shipped_case("comb_resonator")).description


def test_axes_take_the_prefix_of_what_they_show():
    picture = figure(5.0, 4.0)
    axes = picture.add_subplot()
    axes.plot([0.0, 4e-4], [0.0, 3e9])
    clean(axes, "time [s]", "pressure [Pa]")
    with_prefixes(picture)
    with_prefixes(picture)  # a second time changes nothing
    picture.draw_without_rendering()
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [µs]", "pressure [GPa]")
    assert "100" in [text.get_text() for text in axes.get_xticklabels()]
    assert axes.get_xlim()[1] > 4e-4  # what is drawn stays as it was
    decimals = {len(text.get_text().partition(".")[2]) for text in axes.get_yticklabels()}
    assert decimals == {1}, "0.0, 0.5, 1.0 ... as without a prefix, not 0, 0.5, 1"


def test_logarithmic_axes_and_units_that_fit_stay():
    picture = figure(5.0, 4.0)
    axes = picture.add_subplot()
    axes.semilogy([0.0, 2.0], [1e-5, 1e3])
    clean(axes, "time [s]", "size [m]")
    with_prefixes(picture)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [s]", "size [m]")


def drawn(axis, label, shown):
    """Draw the picture of an axis with prefixes, twice, and see its label, and these among the numbers beside it."""
    for _ in range(2):  # a second time changes nothing
        with_prefixes(axis.figure)
    axis.figure.draw_without_rendering()
    assert axis.get_label_text() == label
    assert shown <= {text.get_text() for text in axis.get_ticklabels()}


@pytest.mark.parametrize(
    ("band", "label", "shown"),
    [
        ((1e5, 1e6), "frequency [kHz]", {"100", "200", "500", "1000"}),
        ((5.0, 400.0), "frequency [Hz]", {"10", "20", "50", "100", "200"}),
        ((1.0, 1e7), "frequency [Hz]", {"$\\mathdefault{10^{0}}$", "$\\mathdefault{10^{6}}$"}),
    ],
)
def test_logarithmic_axes_of_frequencies_are_read_at_once(band, label, shown):
    axes = figure(9.0, 4.0).add_subplot()
    axes.loglog(band, [1.0, 2.0])
    clean(axes, "frequency [Hz]", "size")
    axes.set_xlim(*band)
    drawn(axes.xaxis, label, shown)


@pytest.mark.parametrize(
    ("values", "words", "label", "shown"),
    [
        ((14.0, 160.0), "amplification", "amplification", {"20", "50", "100"}),
        ((2.2, 7.5), "amplification", "amplification", {"3", "4", "6"}),
        ((101.0, 112.0), "amplification", "amplification", {"102", "110"}),
        ((2e-6, 5e-4), "size [m]", "size [µm]", {"2", "5", "10", "20", "50", "100", "200", "500"}),
        ((2e-6, 5e-5), "amplification", "amplification", {"$\\mathdefault{10^{-5}}$"}),
    ],
)
def test_logarithmic_axes_of_few_decades_have_plain_numbers(values, words, label, shown):
    axes = figure(9.0, 6.0).add_subplot()
    axes.semilogy([0.0, 1.0], values)
    clean(axes, "time [s]", words)
    axes.set_ylim(*values)
    drawn(axes.yaxis, label, shown)


@pytest.mark.parametrize(
    ("names", "columns"),
    [
        (("displacement y of plate.rim", "maxima", "envelope of the last cycles, exp(-t / 0.614 s)"), 3),
        (9 * ("a name of some thirty letters..",), 3),
        ((100 * "a", "b"), 1),
        (("lost to viscosity (none)", "elastic", "kinetic", "numerical remainder"), 4),
        (5 * ("some twenty letters .",), 3),
    ],
)
def test_a_legend_has_as_many_columns_as_end_within_the_picture(names, columns):
    picture = figure(10.0, 4.0)
    axes = picture.add_subplot()
    for name in names:
        axes.plot([0.0, 1.0], label=name)
    legend_above(axes, 4)
    picture.draw_without_rendering()
    box = axes.get_legend().get_window_extent()
    assert axes.get_legend()._ncols == columns
    assert box.x1 <= picture.bbox.x1


def test_a_legend_keeps_off_the_number_that_all_ticks_have_in_common():
    picture = figure(10.0, 4.0)
    axes = picture.add_subplot()
    axes.plot([1.0, 2.0], [0.3 + 1e-8, 0.3 + 3e-8], label="one of many names")
    legend_above(axes, 2, over_common=True)
    picture.draw_without_rendering()
    common = axes.yaxis.get_offset_text()
    assert common.get_text().startswith("1e")
    assert not axes.get_legend().get_window_extent().overlaps(common.get_window_extent())


def test_axes_of_one_scale_keep_one_unit():
    picture = figure(5.0, 4.0)
    axes = picture.add_subplot()
    axes.set_aspect("equal", adjustable="datalim")
    axes.plot([0.0, 1.0], [0.0, 1e-3])
    clean(axes, "x [m]", "z [m]")
    with_prefixes(picture)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "z [m]")


def boxes(texts, picture):
    renderer = picture.canvas.get_renderer()
    return [text.get_window_extent(renderer) for text in texts]


def test_names_of_crowded_rods_stand_beside_their_own(comb):
    """No name crosses a rod or another name; those between close rods are turned."""
    picture = draw_assembly(comb)
    picture.draw_without_rendering()
    (axes,) = picture.axes
    texts = {text.get_text(): text for text in axes.texts if text.get_text() in comb.rods}
    assert set(texts) == set(comb.rods)
    assert {name for name, text in texts.items() if text.get_rotation()} == {
        name for name in comb.rods if "inner" in name
    }
    found = boxes(texts.values(), picture)
    for k, box in enumerate(found):
        assert not any(box.overlaps(other) for other in found[k + 1 :])
    lines = [line for line in axes.lines if line.get_color() == "#0072B2" and line.get_linewidth() > 1.0]
    for box in found:
        for line in lines:
            pixels = axes.transData.transform(line.get_xydata())
            dense = pixels[:1] + (pixels[-1:] - pixels[:1]) * np.linspace(0.0, 1.0, 200)[:, None]
            assert not any(box.contains(*point) for point in dense)


def test_bodies_cover_what_their_shape_does(comb):
    picture = draw_assembly(comb)
    assert len(picture.axes[0].patches) == len(comb.bodies)
    corners = corners_of(comb.bodies["shuttle"])
    assert np.ptp(corners, axis=0) == pytest.approx(comb.bodies["shuttle"].sides)
    points = corners_of(vr.Sphere(radius=0.2, centre=(1.0, 2.0, 3.0), density=1000.0))
    assert np.linalg.norm(points - [1.0, 2.0, 3.0], axis=1) == pytest.approx(0.2)


@pytest.mark.parametrize("along", [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.3, -0.8, 0.4)])
def test_a_sphere_looks_like_a_circle_from_everywhere(along):
    points = corners_of(vr.Sphere(radius=0.2, centre=(1.0, 2.0, 3.0), density=1000.0))
    across = null_space(np.array([along])).T
    assert ConvexHull((across @ points.T).T).volume == pytest.approx(np.pi * 0.2**2, rel=0.01)  # its area


def test_the_legend_of_a_motion_is_above_its_rods():
    picture = Run(synthetic_results.swing(zeta=0.05)).plot()
    picture.draw_without_rendering()
    axes = picture.axes[1]
    assert axes.get_legend().get_window_extent().y0 >= axes.get_window_extent().y1 - 1.0


def test_cycles_of_hardly_falling_amplitudes_stand_beside_each_other():
    slow = Run(synthetic_results.swing(zeta=0.002)).plot()
    assert slow.axes[-1].get_xlabel() == "cycle" or slow.axes[2].get_xlabel() == "cycle"
    fast = Run(synthetic_results.swing(zeta=0.05)).plot()
    labels = [axes.get_xlabel() for axes in fast.axes]
    assert any(label.startswith("mean amplitude of the cycle") for label in labels)


def test_potential_of_gravity_of_a_fall():
    """Free fall from rest: the momentum is m g t, the potential falls by m g^2 t^2/2."""
    data = synthetic_results.swing(duration=2.0)
    run = Run(viewer_pages.described(data, loads=[{"kind": "gravity"}]))
    time, mass, g = run.time, 0.03, 9.80665
    momentum = np.zeros((time.size, 3))
    momentum[:, 2] = -mass * g * time
    fallen = Run(run.data.assign(linear_momentum=(("time", "axis"), momentum)))
    found = gravity_potential(fallen)
    assert found == pytest.approx(-0.5 * mass * g**2 * time**2, rel=1e-3, abs=1e-12)
    still = Run(viewer_pages.described(data))
    assert gravity_potential(still) is None


def test_turned_frames_follow_small_rotations():
    """A rotation about the own z axis by a small angle, on top of a quarter turn about x."""
    quarter = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0]])
    turned = matrices(after_turn(quarter, np.array([[0.0, 0.0, 0.1]])))[0]
    frame = matrices(quarter)[0]
    about = np.array([[np.cos(0.1), -np.sin(0.1), 0.0], [np.sin(0.1), np.cos(0.1), 0.0], [0.0, 0.0, 1.0]])
    assert turned == pytest.approx(frame @ about)


def test_modes_show_bodies_and_coils_side_by_side():
    model = vr.Model()
    section = vr.Circle(0.002)
    material = vr.Material(2e11, 0.3, 7850.0)
    model.add("coil", vr.Rod.helix(0.02, 0.03, 4.0, section=section, material=material, elements=4))
    model.clamp("coil.start")
    modes = model.modes(6)  # its end sways by almost half of its width
    picture = draw_modes(modes, modes)
    panels = [axes.get_position() for axes in picture.axes]
    assert (
        sum(box.width * box.height for box in panels) > 0.65
    )  # of the picture; titles take most of the rest
    assert not [title for title in titles_of(picture) for axes in picture.axes if title.overlaps(axes.bbox)]
    for axes in picture.axes:
        lines = {line.get_label(): line for line in axes.lines}
        drawn = [lines[name].get_xdata() for name in ("at rest", "mode", "half a period later")]
        assert all(np.nanmax(left) < np.nanmin(right) for left, right in pairwise(drawn))


def test_what_hardly_leaves_its_line_is_drawn_larger():
    """A beam that sags by a thousandth of its span: its picture has a scale of its own across, in a unit that fits."""
    section = vr.StiffnessSection(
        {"EA": 1e6, "GA1": 1e6, "GA2": 1e6, "EI1": 100.0, "EI2": 100.0, "GJ": 100.0}
    )
    rod = vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2)
    model = vr.Model()
    model.add("bar", rod)
    model.clamp("bar.start")
    model.force("bar.end", (0.0, 0.0, -0.3))
    axes = model.equilibrium().plot().axes[0]
    assert axes.get_aspect() == "auto"
    assert axes.get_ylabel() == "z [mm]"
    assert axes.get_title(loc="left").endswith("z enlarged")
    low, high = axes.get_ylim()
    assert low == pytest.approx(-1.0, abs=0.1)  # P L^3/(3 EI) = 1 mm
    assert high < 0.1
    model.loads[:] = [vr.Force("bar.end", (0.0, 0.0, -30.0))]
    bent = model.equilibrium().plot().axes[0]
    assert bent.get_aspect() == 1.0
    assert "enlarged" not in bent.get_title(loc="left")


def test_what_rounding_leaves_of_a_damping_ratio_is_not_drawn():
    """Undamped blades turn with damping ratios of 0, in the picture and in the table."""
    model = vr.Model()
    glass = vr.Material(30e9, 0.3, 1900.0)
    blade = vr.Rod.straight((1, 0, 0), (13, 0, 0), section=vr.Rectangle(0.9, 0.3), material=glass, elements=2)
    model.add("blade", blade)
    model.clamp("blade.start")
    diagram = model.campbell(axis=(0, 0, 1), band=(0.0, 6.0), count=3, modes=2, engine_orders=(3.0,))
    assert np.abs(diagram.damping_ratios).max() > 0.0  # as computed
    below = diagram.plot().axes[1]
    assert [line.get_ydata().any() for line in below.lines[:2]] == [False, False]
    assert re.search(r"bend_1 1 +\S+ +0 +\S+ +0 ", diagram.report())


def test_a_section_of_micrometres_is_drawn_in_them():
    silicon = vr.Material(160e9, 0.22, 2330.0)
    model = vr.Model()
    section = vr.Rectangle("10 um", "2 um")
    model.add(
        "beam", vr.Rod.straight((0, 0, 0), (200e-6, 0, 0), section=section, material=silicon, elements=2)
    )
    model.clamp("beam.start")
    model.force("beam.end", (0, 0, 1e-6))
    axes = model.equilibrium().plot_stress(place="beam.start").axes[0]
    assert axes.get_xlabel() == "d1 [µm]"
    assert axes.get_xlim() == pytest.approx((-5.0, 5.0), rel=0.2)


def a_beam():
    model = vr.Model()
    material = vr.Material(70e9, 0.3, 2700.0)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.4, 0, 0), section=vr.Rectangle(0.02, 0.002), material=material, elements=2
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    return model


def test_modes_of_springs_at_places_swing_in_a_page(tmp_path):
    """Joint values belong to the state that modes are about, not to their swings: the page asked for them in vain."""
    model = a_beam()
    model.spring("beam.end", None, stiffness={"uz": 10.0}, name="soft")
    path = vr.view(model.modes(2), tmp_path / "modes.html")
    meta, _ = viewer_pages.parts(path.read_text(encoding="utf-8"))
    assert not [group["label"] for group in meta["histories"] if "soft" in group["label"]]


def test_round_off_is_no_damping_in_the_picture_of_modes():
    modes = a_beam().modes(1)
    (s,) = modes.eigenvalues
    off = np.array([[1e-11 * abs(s), s.imag]])
    noisy = vr.Modes(modes.data.assign(eigenvalue=(modes.data["eigenvalue"].dims, off)))
    assert noisy.damping_ratios[0] == pytest.approx(-1e-11, rel=1e-3)
    assert "damping ratio 0\n" in draw_modes(noisy, noisy).axes[0].get_title("left")


def test_four_panels_stand_two_by_two():
    columns = [axes.get_subplotspec().get_gridspec().ncols for axes in a_beam().modes(4).plot().axes]
    assert columns == [2] * 4


def titles_of(picture):
    """Where the titles of panels stand, which are flush left."""
    shown = {axes.get_title(loc="left") for axes in picture.axes}
    return boxes([text for text in picture.findobj(Text) if text.get_text() in shown], picture)


@pytest.mark.parametrize("count", [1, 2])
def test_the_legend_of_few_modes_ends_before_the_picture_does(count):
    picture = a_beam().modes(count).plot()
    (legend,) = picture.legends
    box = legend.get_window_extent(picture.canvas.get_renderer())
    assert box.x1 <= picture.bbox.x1
    assert box.y0 >= max(title.y1 for title in titles_of(picture))


def test_no_band_is_left_for_a_title_that_there_is_not(tmp_path):
    """The first row of pixels with ink: both pictures begin with what stands on top of them."""
    import matplotlib.image

    data = synthetic_results.swing()
    heights, first = [], []
    for title in ("A swing", ""):
        path = tmp_path / f"{len(title)}.png"
        Run(data.assign_attrs(title=title)).plot(path)
        pixels = matplotlib.image.imread(path)[..., :3]
        heights.append(pixels.shape[0])
        first.append(int(np.flatnonzero((pixels < 0.9).any(axis=(1, 2)))[0]))
    assert heights[1] < heights[0] - 20
    assert first[1] < 20


def test_the_energies_of_a_single_state_are_a_bar():
    run = Run(synthetic_results.swing(duration=0.0))
    picture = run.plot_energy()
    picture.draw_without_rendering()
    upper = picture.axes[0]
    elastic = next(part for part in upper.collections if part.get_label() == "elastic")
    corners = elastic.get_paths()[0].vertices
    assert np.ptp(corners[:, 1]) == pytest.approx(upper_scale(upper) * run.energy.elastic[0], rel=1e-12)
    assert np.ptp(corners[:, 0]) > 0.0
    assert len(run.plot().axes) == 2  # and no bar of colours for one instant


def upper_scale(axes):
    """The factor from joules to the unit of an axis."""
    return {"J": 1.0, "mJ": 1e3, "µJ": 1e6}[axes.get_ylabel().partition("[")[2].rstrip("]")]


def test_strains_that_rounding_makes_are_not_drawn():
    """A rod bent into a half circle by a moment at its end is not stretched and not sheared: shown was 1e-8 µm/m."""
    model = a_beam()
    model.moment("beam.end", (0, 0, 70e9 * 0.02**3 * 0.002 / 12 * np.pi / 0.4))
    held = model.equilibrium(load_factors=[0.5, 1.0])
    assert 0.0 < np.abs(held.data["strain"].values[..., :3]).max() < 1e-12
    upper = held.plot_strain().axes[0]
    assert upper.get_ylabel().endswith("[%]")
    assert all(not np.asarray(line.get_ydata()).any() for line in upper.lines)


def test_the_only_speed_of_a_steady_rotation_has_its_unit():
    steady = a_beam().steady([0.0, 0.0, 5.0])
    texts = [text.get_text() for axes in steady.plot_strain().axes for text in axes.texts]
    assert texts == ["at 5 rad/s"]


def test_what_rests_has_no_swing_and_shows_how_far_it_sags():
    """Positions that rest change by rounding, to and fro, most along any axis."""
    data = synthetic_results.swing(zeta=1e-3, omega=2.4 * np.pi)
    position = np.broadcast_to(data["position"].values[:1], data["position"].shape).copy()
    position[1::2, -1, 0] += 1e-16
    rests = Run(data.assign(position=(data["position"].dims, position), velocity=0.0 * data["velocity"]))
    assert rests.rests
    site, axis = rests.main_motion
    assert (site.label, axis) == ("beam.end", "y")
    axes = rests.plot().axes[1]
    assert axes.get_title(loc="left") == "Rod in the xy plane"


@pytest.mark.parametrize("quickening", [False, True])
def test_snapshots_of_a_motion_that_goes_to_and_fro_without_a_decay_are_those_of_one_swing(
    monkeypatch, quickening
):
    # twelve equal periods: thirteen snapshots of the whole would all show the same shape; and what begins slowly
    monkeypatch.setattr(Run, "free_decay", lambda *_: None)
    data = synthetic_results.swing(zeta=1e-3, omega=2.4 * np.pi)
    if quickening:
        data = data.assign_coords(time=10.0 * np.sqrt(data["time"] / 10.0))
    axes = Run(data).plot().axes[1]
    assert "first swing" in axes.get_title(loc="left")
    tips = [line.get_ydata()[-1] for line in axes.lines if len(line.get_xdata()) > 5]
    assert min(tips) < -0.15  # of an amplitude of 0.2, to both sides
    assert max(tips) > 0.15


def test_names_keep_off_symbols_of_supports():
    # the arrow ends at the support, and "933 kN" stood on it
    description = load_case(shipped_case("prestressed_bridge")).description
    picture = draw_assembly(description)
    picture.draw_without_rendering()
    axes = picture.axes[0]
    marks = [line for line in axes.lines if line.get_label() == "held in part"]
    half = 0.5 * marks[0].get_markersize() * picture.dpi / 72.0
    words = [text for text in axes.texts if text.get_text()]
    for at in axes.transData.transform(marks[0].get_xydata()):
        symbol = Bbox([at - half, at + half])
        assert not [text.get_text() for text in words if symbol.overlaps(text.get_window_extent())]


@pytest.mark.parametrize(("pitch", "axis"), [(0.02, (0, 0, -1)), (0.1, (1, 0.3, 0))])
def test_directions_of_the_axes_keep_off_what_is_drawn_in_space(pitch, axis):
    coil = vr.Rod.helix(
        0.05, pitch, 6, axis=axis, section=vr.Circle(1e-3), material=vr.Material(1e9, 0.3, 1e3)
    )
    model = vr.Model()
    model.add("coil", coil)
    model.clamp("coil.start")
    picture = figure(2.6, 2.4)  # as small as one of several, where the directions are large
    axes = picture.add_subplot()
    model.equilibrium().plot(ax=axes)
    picture.draw_without_rendering()
    letters = [text for text in axes.texts if text.get_text() in ("x", "y", "z")]
    assert len(letters) == 3
    drawn = np.concatenate([axes.transData.transform(line.get_xydata()) for line in axes.lines])
    for letter in letters:
        box = letter.get_window_extent()  # with its arrow
        inside = np.all((drawn > [box.x0, box.y0]) & (drawn < [box.x1, box.y1]), axis=1)
        assert not inside.any()


def test_lines_to_the_names_of_equal_modes_cross_no_name():
    steel = vr.Material(2e11, 0.3, 7850.0)
    model = vr.Model()
    for name, end in (("a", (0, 2, 0)), ("b", (0, -2, 0))):  # alike: their frequencies come in pairs
        rod = vr.Rod.straight((0, 0, 0), end, section=vr.Circle(0.02), material=steel, elements=2)
        model.add(name, rod)
        model.clamp(f"{name}.start")
    diagram = model.campbell(axis=(0, 0, 1), band=(0.0, 1.0), count=2, modes=4)
    picture = diagram.plot()
    picture.draw_without_rendering()
    names = [text for text in picture.axes[0].texts if text.get_text() in diagram.modes]
    assert len(names) == 4
    for text in names:
        line = text.arrow_patch.get_path()
        start, end = text.arrow_patch.get_transform().transform(line.vertices[[0, -1]])
        between = start + (end - start) * np.linspace(0.02, 1.0, 50)[:, None]
        for other in names:
            box = Text.get_window_extent(other)
            assert not any(box.contains(*point) for point in between)


def rotor(along, across):
    """Three blades about an axis across both given directions, one of them along the first."""
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 7850.0)
    for k, angle in enumerate(2.0 * np.pi / 3.0 * np.arange(3)):
        way = np.cos(angle) * np.array(along) + np.sin(angle) * np.array(across)
        section = vr.Rectangle(0.1, 0.02)
        model.add(f"blade_{k}", vr.Rod.straight(0.2 * way, 2.0 * way, section=section, material=steel))
        model.clamp(f"blade_{k}.start")
    return model


@pytest.mark.parametrize(
    ("along", "across"),
    [((0, 0, 1), (1, 0, 0)), ((0, 0, 1), (0, 1, 0)), ((0, 0, 1), (0.8, 0.6, 0)), ((0.6, 0, 0.8), (0, 1, 0))],
)
def test_modes_of_a_rotor_are_seen(along, across):
    """Tips move on paper by more than a third of what they move, and not along their blades."""
    modes = rotor(along, across).modes(6)
    for k in range(6):
        picture = modes.plot(number=k + 1)
        at_rest, mode, _ = (
            line.get_xydata()
            for line in picture.axes[0].lines
            if line.get_label() in ("at rest", "mode", "half a period later")
        )
        moved = np.nan_to_num(mode - at_rest)
        tip = int(np.argmax(np.linalg.norm(moved, axis=1)))
        blade = at_rest[tip] - at_rest[tip - 1]
        aside = abs(blade[0] * moved[tip, 1] - blade[1] * moved[tip, 0]) / np.linalg.norm(blade)
        assert aside > 0.33 * 0.15 * np.max(np.ptp(modes.positions, axis=0))


def test_a_mode_that_twists_is_drawn_by_edges_and_not_by_rounding():
    """The centre line of a twisting beam rests: what solvers leave of it had been drawn as its shape."""
    silicon = vr.Material("169 GPa", 0.28, 2330.0)
    model = vr.Model()
    section = vr.Rectangle("20 um", "2 um")
    model.add("beam", vr.Rod.straight((0, 0, 0), ("200 um", 0, 0), section=section, material=silicon))
    model.clamp("beam.start")
    model.clamp("beam.end")
    modes = model.modes(4)
    assert modes.names[3] == "twist 1"
    real, turn = modes.shapes[3].real, modes.rotations[3].real
    swing = Swing.of(modes.positions, real, modes.data["rotation"].values[-1], turn, 3e-5)
    ahead, behind = swing.lines(1.0)
    s = modes.positions[:, 0]
    angle = np.arctan2(*(ahead - behind)[:, [2, 1]].T)
    np.testing.assert_allclose(np.abs(angle - angle[0]), 0.6 * np.sin(np.pi * s / 2e-4), atol=6e-4)
    assert np.abs(0.5 * (ahead + behind) - modes.positions).max() < 1e-9 * 2e-4
    bent = Swing.of(modes.positions, modes.shapes[0].real, swing.still, modes.rotations[0].real, 3e-5)
    assert bent.edge == 0.0
    assert np.abs(bent.moved).max() == pytest.approx(3e-5)


def test_states_of_a_coil_that_is_pulled_stand_side_by_side():
    """On top of each other, turns of many states are one area of ink."""
    model = vr.Model()
    wire = vr.Material(1e8, 0.3, 1000.0)
    model.add("spring", vr.Rod.helix(0.02, 0.01, 4, section=vr.Circle(0.001), material=wire, elements=8))
    model.clamp("spring.start")
    model.force("spring.end", (0.0, 0.0, -0.01))
    axes = model.equilibrium(load_factors=[0.2, 0.4, 0.6, 0.8, 1.0]).plot().axes[0]
    assert axes.get_title(loc="left").endswith("side by side")
    shown = [line for line in axes.lines if len(line.get_xdata()) > 20 and line.get_zorder() > 1]
    assert len(shown) == 5  # the reference shape, three on the way, and the equilibrium
    spans = [(np.nanmin(line.get_xdata()), np.nanmax(line.get_xdata())) for line in shown]
    assert all(before[1] < after[0] for before, after in pairwise(spans))


def test_images_of_many_rods_are_those_where_the_component_is_largest():
    """Six rods, each loaded more than the one before: the last four are shown, and it is said that there are six."""
    model = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    for k in range(6):
        rod = vr.Rod.straight(
            (0, 0.1 * k, 0), (0.2, 0.1 * k, 0), section=vr.Circle(0.005), material=rubber, elements=1
        )
        model.add(f"rod_{k}", rod)
        model.clamp(f"rod_{k}.start")
        model.force(f"rod_{k}.end", (0, 0, 1e-4 * (1 + k)), until=0.0)
    picture = model.simulate(0.05).plot_space_time(component="bend_1")
    names = [axes.get_title(loc="left") for axes in picture.axes if axes.get_title(loc="left")]
    assert [name.split(" along ")[1].split(":")[0] for name in names] == [f"rod_{k}" for k in range(2, 6)]
    assert names[0].endswith(": 4 of 6 rods, where it is largest")
