"""The page of a result, read back without a browser: numbers, budget, text from files that must stay text."""

import base64
import hashlib
import json
import re
from html.parser import HTMLParser
from importlib.resources import files

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod
from helpers import synthetic_results, viewer_pages
from helpers.effort import counted_calls
from helpers.viewer_pages import EVIL
from viscorod.cli.app import app
from viscorod.errors import InputError
from viscorod.pictures.viewer import view
from viscorod.pictures.viewer.frames import Frames
from viscorod.pictures.viewer.packing import LEVELS
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run
from viscorod.results.sweep_result import Sweep


@pytest.fixture
def page(tmp_path):
    def make(result, **options):
        path = view(result, tmp_path / "page.html", **options)
        text = path.read_text(encoding="utf-8")
        return (*viewer_pages.parts(text), text)

    return make


# --- numbers


def test_positions_follow_the_closed_form_between_stored_times_too(page):
    step, zeta, omega, size = 0.02, 0.05, 3.6, 0.2
    meta, data, _ = page(Run(synthetic_results.swing(zeta, omega, 4.0, step, size)))
    time, _ = viewer_pages.array(meta, data, "instants")
    positions, half = viewer_pages.array(meta, data, "positions")
    assert len(time) > 4 * meta["stored"]  # several frames from one stored time to the next
    q, _ = synthetic_results.oscillator(time.astype(float), zeta, omega, size)
    s, _ = viewer_pages.array(meta, data, "node_s")
    expected = (s / synthetic_results.LENGTH) ** 2 * q[:, None]
    # a cubic through values and slopes is off by h^4/384 times the fourth derivative at most; instants are float32
    bound = half[1] + size * (omega * step) ** 4 / 384.0 + size * omega * 4.0 * 2.0**-24
    assert np.max(np.abs(positions[:, :, 1] - expected)) <= 1.05 * bound
    assert half[1] == pytest.approx(np.ptp(expected) / LEVELS / 2.0, rel=1e-3)


def test_stored_states_are_in_the_page_within_half_a_step(page):
    run = Run(synthetic_results.swing(duration=4.0))
    meta, data, _ = page(run)
    numbers, _ = viewer_pages.array(meta, data, "numbers")
    whole = numbers == np.rint(numbers)
    assert np.array_equal(numbers[whole], np.arange(run.time.size))
    for name, stored in (
        ("positions", run.data["position"].values),
        ("rotations", run.data["rotation"].values),
        ("field_strain3", run.data["strain"].values[..., 3]),
        ("field_force3", run.data["section_force"].values[..., 3]),
        ("field_dissipation", run.data["dissipation"].values),
        ("field_speed", np.linalg.norm(run.data["velocity"].values, axis=-1)),
    ):
        values, half = viewer_pages.array(meta, data, name)
        assert np.all(np.abs(values[whole] - stored) <= 1.001 * np.max(half) + 1e-15), name


def test_more_states_than_frames_are_shown_at_even_times(page):
    run = Run(synthetic_results.swing(duration=10.0))
    meta, data, _ = page(run, frames=100)
    instants, _ = viewer_pages.array(meta, data, "instants")
    assert instants == pytest.approx(np.linspace(0.0, 10.0, 100), abs=1e-6)
    positions, half = viewer_pages.array(meta, data, "positions")
    for k in (0, 13, 57, 99):
        assert np.abs(positions[k] - run.positions_at(10.0 * k / 99)).max() <= 1.01 * half.max() + 1e-12
    assert meta["notes"][0] == "100 frames shown of 501 stored times"


def test_states_of_an_equilibrium_are_shown_as_they_are(page):
    result = Equilibrium(synthetic_results.rolled_up())
    meta, data, _ = page(result)
    instants, _ = viewer_pages.array(meta, data, "instants")
    assert instants.tolist() == [0.25, 0.5, 0.75, 1.0]
    positions, half = viewer_pages.array(meta, data, "positions")
    assert np.all(np.abs(positions - result.data["position"].values) <= 1.001 * half)
    assert meta["decay"] is None
    assert meta["energy"]["stacked"] == ["elastic"]


def test_histories_hold_stored_values(page):
    run = Run(synthetic_results.swing())
    meta, data, _ = page(run)
    group = meta["histories"][0]
    assert (group["label"], group["unit"], group["curves"]) == (
        "displacement of beam.end",
        "m",
        ["x", "y", "z"],
    )
    curves, _ = viewer_pages.array(meta, data, group["array"])
    assert curves.T == pytest.approx(run.history("beam.end", "displacement").values, abs=1e-7)
    assert {f"force of support {name}" for name in ("beam.start",)} < {g["label"] for g in meta["histories"]}


def test_energy_and_decay_are_those_of_the_run(page):
    run = Run(synthetic_results.swing(leak=0.001))
    meta, data, _ = page(run)
    rows, _ = viewer_pages.array(meta, data, "energy")
    scale = {"J": 1.0, "mJ": 1e3}[meta["energy"]["unit"]]
    lost, elastic, kinetic, supplied, numerical = rows / scale
    assert lost == pytest.approx(run.energy.viscous, rel=1e-5, abs=1e-9)
    assert lost + elastic + kinetic - numerical == pytest.approx(supplied, rel=1e-5)
    assert meta["energy"]["fraction"] == run.energy.numerical_fraction
    assert meta["decay"]["limit"] == pytest.approx(0.05, rel=1e-4)  # of the oscillator
    assert meta["decay"]["period"][0] == pytest.approx(2 * np.pi / 3.6 / np.sqrt(1 - 0.05**2), rel=1e-4)


def test_rings_lie_on_the_elements_own_polynomials(page):
    meta, data, _ = page(Run(synthetic_results.swing(duration=0.2)))
    first, weights, s, nodes = (
        viewer_pages.array(meta, data, name)[0] for name in ("ring_first", "ring_weights", "ring_s", "node_s")
    )
    rows = first[:, None].astype(int) + np.arange(weights.shape[1])
    for power in range(synthetic_results.ORDER + 1):  # of order 5: powers up to the fifth are met
        found = np.sum(weights * nodes[rows] ** power, axis=1)
        assert found == pytest.approx(s**power, abs=2e-6)


# --- sections and loads


def test_sections_are_those_of_the_model(page):
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=0.2))))
    assert meta["lines"][0]["outline"] == "box"
    halves, _ = viewer_pages.array(meta, data, "halves")
    assert halves == pytest.approx(np.tile([0.005, 0.01], (len(halves), 1)))


def test_polygons_are_drawn_about_the_centre_line(page):
    pytest.importorskip("sectionproperties")
    corners = [
        [0, 0],
        [0.03, 0],
        [0.03, 0.004],
        [0.004, 0.004],
        [0.004, 0.036],
        [0.03, 0.036],
        [0.03, 0.04],
        [0, 0.04],
    ]
    section = {"shape": "outline", "points": corners[::-1]}
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=0.2), section=section)))
    halves, _ = viewer_pages.array(meta, data, "halves")
    ((contour,),) = meta["lines"][0]["contours"]
    x, y = halves[0, 0] * np.array(contour).T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    assert np.sum(cross) / 2.0 == pytest.approx(2 * 0.03 * 0.004 + 0.032 * 0.004)  # anticlockwise
    for along in (x, y):  # the centroid is on the centre line
        assert np.sum((along + np.roll(along, -1)) * cross) / 6.0 == pytest.approx(0.0, abs=1e-10)
    assert np.ptp(x) == pytest.approx(0.03)
    assert np.ptp(y) == pytest.approx(0.04)


@pytest.mark.parametrize(
    ("section", "outline", "half", "hole"),
    [
        ({"shape": "annulus", "outer_radius": 0.01, "inner_radius": 0.008}, "round", 0.01, 0.8),
        ({"shape": "square_tube", "width": 0.03, "thickness": 0.003}, "box", 0.015, 0.8),
        ({"shape": "circle", "radius": 0.01}, "round", 0.01, 0.0),
    ],
)
def test_tubes_are_hollow(section, outline, half, hole, page):
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=0.2), section=section)))
    assert meta["lines"][0]["outline"] == outline
    assert viewer_pages.array(meta, data, "halves")[0] == pytest.approx(
        np.full((meta["lines"][0]["rings"], 2), half)
    )
    assert viewer_pages.array(meta, data, "holes")[0] == pytest.approx(
        np.full(meta["lines"][0]["rings"], hole)
    )


def test_a_tapered_tube_has_its_own_hole_on_every_ring(page):
    """Outer and inner radius are straight from end to end: their ratio is not."""
    tube = {"shape": "annulus", "outer_radius": 0.01, "inner_radius": 0.009}
    end = {"shape": "annulus", "outer_radius": 0.006, "inner_radius": 0.002}
    taper = {"start": tube, "end": end}
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=0.2), taper=taper)))
    along = viewer_pages.array(meta, data, "ring_s")[0] / synthetic_results.LENGTH
    outer, inner = 0.01 - 0.004 * along, 0.009 - 0.007 * along
    assert viewer_pages.array(meta, data, "halves")[0] == pytest.approx(
        np.stack([outer, outer], axis=1), rel=1e-5
    )
    assert viewer_pages.array(meta, data, "holes")[0] == pytest.approx(inner / outer, rel=1e-5)


def test_holes_of_polygons_run_the_other_way_round(page):
    """Area and centroid of a plate with a hole beside its middle, by the formulas for closed polygons."""
    pytest.importorskip("sectionproperties")
    section = {
        "shape": "outline",
        "points": [[0, 0], [0.04, 0], [0.04, 0.02], [0, 0.02]],
        "holes": [[[0.02, 0.005], [0.03, 0.005], [0.03, 0.015], [0.02, 0.015]]],
    }
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=0.2), section=section)))
    half = viewer_pages.array(meta, data, "halves")[0][0, 0]
    ((outer, hole),) = (
        [half * np.array(contour) for contour in region] for region in meta["lines"][0]["contours"]
    )
    areas, moments = [], np.zeros(2)
    for corners in (outer, hole):
        x, y = corners.T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        areas.append(np.sum(cross) / 2.0)
        moments += [np.sum((along + np.roll(along, -1)) * cross) / 6.0 for along in (x, y)]
    assert areas == pytest.approx([8e-4, -1e-4])
    assert moments == pytest.approx(np.zeros(2), abs=1e-10)  # the centroid is on the centre line


def test_sections_without_a_model_are_tubes_of_the_stored_half_width(page):
    data = synthetic_results.swing(duration=0.2)
    meta, inflated, _ = page(Run(data.assign(half_width=("point", np.full(10, 0.007)))))
    assert meta["lines"][0] | {"outline": "round", "known": True} == meta["lines"][0]
    halves, _ = viewer_pages.array(meta, inflated, "halves")
    assert halves == pytest.approx(np.full(halves.shape, 0.007))
    assert any("does not describe the model" in note for note in meta["notes"])


def test_loads_have_their_size_at_every_time(page):
    table = {"kind": "table", "times": [0.0, 1.0, 2.0], "values": [0.0, 1.0, 0.0]}
    loads = [
        {"kind": "force", "at": "beam.end", "value": [0.0, 0.035, 0.0], "until": 0.0},
        {"kind": "moment", "at": "beam.end", "value": [0.0, 0.0, 2.0], "time": table},
        {"kind": "gravity"},
        {"kind": "distributed_force", "rod": "beam", "value": [0.0, 0.0, 1.0], "following": True},
        {"kind": "moving_force", "rod": "beam", "value": [0.0, 1.0, 0.0], "speed": 0.1},
    ]
    meta, data, _ = page(Run(viewer_pages.described(synthetic_results.swing(duration=4.0), loads=loads)))
    time, sizes = (viewer_pages.array(meta, data, name)[0] for name in ("instants", "load_sizes"))
    assert sizes[0, 0] == pytest.approx(0.035)  # what held the rod before it was let go
    assert not sizes[1:, 0].any()
    assert sizes[:, 1] == pytest.approx(2.0 * np.interp(time, [0.0, 1.0, 2.0], [0.0, 1.0, 0.0]), abs=1e-6)
    assert sizes[:, 2] == pytest.approx(9.81)
    inside = np.abs(time - 3.0) > 1e-3  # at 3 s it leaves the rod, give or take round-off
    assert sizes[inside, 4] == pytest.approx(np.where(time < 3.0, 1.0, 0.0)[inside])
    marks, half = viewer_pages.array(meta, data, "marks")
    by_label = {load["label"]: load for load in meta["scene"]["loads"]}
    # d3 of the section is along x: the following load, given along it, points there
    arrow = marks[:, by_label["load along beam"]["arrows"][4]]
    assert np.abs(arrow - [1.0, 0.0, 0.0]).max() <= 1.01 * half.max()
    foot = marks[:, by_label["force travelling on beam"]["feet"][0], 0]
    assert np.abs(foot - np.minimum(0.1 * time, synthetic_results.LENGTH)).max() <= 1.01 * half[0] + 1e-6
    tip = marks[:, by_label["force at beam.end"]["feet"][0]]
    positions, _ = viewer_pages.array(meta, data, "positions")
    assert np.abs(tip - positions[:, -1]).max() <= 2.01 * half.max()


def test_loads_of_an_equilibrium_grow_with_the_load_factor(page):
    loads = [{"kind": "moment", "at": "beam.end", "value": [0.0, 0.0, 2.0], "until": 0.0}]
    meta, data, _ = page(Equilibrium(viewer_pages.described(synthetic_results.rolled_up(), loads=loads)))
    sizes, _ = viewer_pages.array(meta, data, "load_sizes")
    assert sizes[:, 0] == pytest.approx([0.5, 1.0, 1.5, 2.0])
    assert meta["scene"]["supports"][0]["label"] == "clamp at beam.start"


# --- budget


def test_ten_thousand_frames_of_two_hundred_stations_stay_light(page):
    run = Run(viewer_pages.beating())
    with counted_calls() as effort:
        meta, data, text = page(run)
    assert effort.calls < 2_000_000  # 380 000 in 2 s where it was measured
    assert len(text) == pytest.approx(6.5e6, rel=0.02)  # docs/howto/view.md
    assert meta["notes"][:2] == [
        "1500 frames shown of 10000 stored times",
        f"charts: {len(viewer_pages.array(meta, data, 'samples')[0])} of 10000 stored times, extremes kept",
    ]
    # the charts keep the largest of every beat, though they leave most states out
    numbers, _ = viewer_pages.array(meta, data, "sample_numbers")
    assert numbers.size < 4200
    for curve in (run.field("displacement")[:, -1, 1], run.data["kinetic"].values):
        for bucket in np.array_split(np.arange(10_000), 50):
            best = numbers[(numbers >= bucket[0]) & (numbers <= bucket[-1])]
            assert curve[best].max() == pytest.approx(curve[bucket].max(), rel=1e-3)


def test_a_smaller_budget_takes_frames_and_says_so(page):
    run = Run(viewer_pages.beating(frames=2000))
    meta, _, text = page(run, megabytes=3.0)
    assert len(text) <= 3e6
    shown = int(meta["notes"][0].split()[0])
    assert 2 <= shown < 1500
    assert meta["arrays"]["positions"]["shape"][0] == shown


def test_many_stations_are_taken_at_even_arc_lengths(page):
    data = viewer_pages.beating(frames=20, elements=300)
    run = Run(data)
    meta, inflated, _ = page(run)
    s, _ = viewer_pages.array(meta, inflated, "node_s")
    assert np.diff(s) == pytest.approx(1.0 / (len(s) - 1), rel=1e-4)
    assert len(s) == 400
    assert "400 stations shown of 1201" in meta["notes"]
    positions, half = viewer_pages.array(meta, inflated, "positions")
    numbers, _ = viewer_pages.array(meta, inflated, "numbers")
    k = int(numbers[8])
    expected = np.interp(s, data["station_s"].values, data["position"].values[k, :, 1])
    frame = int(np.flatnonzero(numbers == k)[0])
    # straight lines between 1201 stations differ from the polynomials by the square of their distance
    assert np.abs(positions[frame, :, 1] - expected).max() <= half[1] + 2e-5
    assert meta["arrays"]["field_strain3"]["shape"][1] <= 400


# --- text from files


class Reader(HTMLParser):
    """Elements of a page, and where they point."""

    def __init__(self):
        super().__init__()
        self.tags, self.targets = [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        given = dict(attrs)
        self.targets += [given[name] for name in ("src", "href", "srcset", "action", "data") if name in given]
        assert not [name for name in given if name.startswith("on")]


def test_text_from_a_file_never_becomes_markup(page):
    data = synthetic_results.swing(duration=0.4).assign_attrs(title=EVIL, warnings=json.dumps([EVIL]))
    data = data.assign_coords(support=[EVIL], station_rod=("station", [EVIL] * synthetic_results.STATIONS))
    meta, _, text = page(Run(data))
    plain, _, innocent = page(Run(synthetic_results.swing(duration=0.4)))
    assert meta["title"] == EVIL
    assert meta["warnings"][0] == EVIL
    assert meta["lines"][0]["rod"] == EVIL
    found, known = Reader(), Reader()
    found.feed(text)
    known.feed(innocent)
    assert found.tags == known.tags
    assert "img" not in found.tags
    assert plain["title"] == "A swing in closed form"


def test_page_asks_for_nothing(page):
    _, _, text = page(Run(synthetic_results.swing(duration=0.4)))
    reader = Reader()
    reader.feed(text)
    assert reader.targets == ["data:,"]  # an icon, so that none is asked for
    code = re.sub(r'<script type="text/plain" id="data".*?</script>', "", text, flags=re.S)
    addresses = set(re.findall(r"https?://[^\s\"'`)]+", code))
    # names of XML vocabularies, and a comment that says where uPlot is from
    assert addresses <= {
        "http://www.w3.org/1999/xhtml",
        "http://www.w3.org/2000/svg",
        "https://github.com/leeoniya/uPlot",
    }


def test_only_the_pages_own_scripts_may_run(page):
    _, _, text = page(Run(synthetic_results.swing(duration=0.4)))
    policy = re.search(r'Content-Security-Policy" content="(.*?)"', text)[1]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    scripts = re.findall(r"<script>(.*?)</script>", text, re.S)
    assert len(scripts) == 8
    for script in scripts:
        digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy


def test_vendored_scripts_are_those_that_are_documented():
    folder = files("viscorod.pictures.viewer") / "static" / "vendor"
    told = (folder / "README.md").read_text(encoding="utf-8")
    for name in ("three.min.js", "uplot.min.js", "uplot.min.css"):
        assert hashlib.sha256((folder / name).read_bytes()).hexdigest() in told
    for name in ("three.LICENSE", "uplot.LICENSE"):
        assert "Permission is hereby granted, free of charge" in (folder / name).read_text(encoding="utf-8")


# --- wrong use


def test_wrong_use_is_refused(tmp_path):
    run = Run(synthetic_results.swing(duration=0.4))
    for options in ({"frames": 1}, {"frames": 2.5}, {"frames": True}, {"megabytes": 0.5}):
        with pytest.raises(InputError, match=next(iter(options))):
            view(run, tmp_path / "no.html", **options)
    with pytest.raises(
        InputError, match=r"^result: \[.*\]: this has no page; give one motion, and the others as beside"
    ):
        view([run, run], tmp_path / "no.html")
    with pytest.raises(InputError, match=r"^result: .*: this has no page; give one of its members"):
        view(Sweep([]), tmp_path / "no.html")
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        view(run, tmp_path / "folder.html")
    with pytest.raises(InputError, match=r"the suffix '.txt' is not that of a page; use .html or .htm"):
        view(run, tmp_path / "no.txt")
    assert not (tmp_path / "no.html").exists()


def test_one_state_is_a_page_too(page):
    run = Run(synthetic_results.swing(duration=0.0))
    meta, data, _ = page(run)
    assert meta["notes"][0] == "one state"
    assert viewer_pages.array(meta, data, "positions")[0].shape[0] == 1


def test_frames_of_one_state():
    frames = Frames.of(Run(synthetic_results.swing(duration=0.0)), 100)
    assert (frames.count, frames.stored) == (1, 1)
    assert frames.instants.tolist() == [0.0]


def test_command_writes_beside_the_result(tmp_path):
    path = Run(synthetic_results.swing(duration=1.0)).save(tmp_path / "run.nc")
    done = CliRunner().invoke(app, ["view", str(path), "--frames", "20"])
    assert done.exit_code == 0, done.output
    meta, _ = viewer_pages.parts((tmp_path / "run.html").read_text(encoding="utf-8"))
    assert meta["notes"][0] == "20 frames shown of 51 stored times"
    missing = CliRunner().invoke(app, ["view", str(tmp_path / "no.nc")])
    assert missing.exit_code == 2
    assert "is not a file" in missing.output


def test_public_name_writes_a_page(tmp_path):
    path = viscorod.view(Run(synthetic_results.swing(duration=0.4)), tmp_path / "new" / "page.html")
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


def test_others_beside_a_motion_have_their_values_at_its_times(tmp_path):
    """Another motion and a measured record: values of both at the times of the charts, nothing where they have none."""
    run, other = (Run(synthetic_results.swing(zeta, duration=2.0)) for zeta in (0.05, 0.2))
    times = np.linspace(0.5, 1.5, 201)
    record = viscorod.Record(
        times, np.sin(times), place="beam.end", quantity="displacement", direction="y", name="laser"
    )
    text = viscorod.view(run, tmp_path / "page.html", beside=[other, record]).read_text(encoding="utf-8")
    meta, data = viewer_pages.parts(text)
    group = meta["histories"][0]
    assert group["label"] == "displacement of beam.end"
    names = [told["name"] for told in group["others"]]
    assert names == [*(f"{axis}, A swing in closed form (2)" for axis in "xyz"), "y, laser"]
    curves, _ = viewer_pages.array(meta, data, group["array"])
    time, _ = viewer_pages.array(meta, data, "samples")
    assert curves[4] == pytest.approx(other.history("beam.end", "displacement").values[:, 1], abs=1e-7)
    inside = (time > 0.501) & (time < 1.499)
    assert curves[6][inside] == pytest.approx(np.sin(time[inside]), abs=1e-4)
    assert np.isnan(curves[6][time < 0.499]).all()
    ghost, half = viewer_pages.array(meta, data, "ghost0")
    instants, _ = viewer_pages.array(meta, data, "instants")
    for k in (0, len(instants) // 2):
        assert np.abs(ghost[k] - other.positions_at(float(instants[k]))).max() < half.max() + 1e-7
    with pytest.raises(viscorod.InputError, match="only motions over time"):
        viscorod.view(Equilibrium(synthetic_results.rolled_up()), tmp_path / "page.html", beside=[other])


def test_others_beside_a_motion_may_be_named(tmp_path):
    """By a table: two results of one case have one title."""
    run = Run(synthetic_results.swing(duration=1.0))
    named = {"before": run, "after": run}
    text = viscorod.view(run, tmp_path / "page.html", beside=named).read_text(encoding="utf-8")
    meta, _ = viewer_pages.parts(text)
    assert [one["name"] for one in meta["ghosts"]] == ["before", "after"]
    assert [one["name"] for one in meta["histories"][0]["others"]] == [
        f"{axis}, {name}" for name in named for axis in "xyz"
    ]


def test_round_off_is_not_shown_as_data(page):
    data = synthetic_results.swing(duration=1.0)
    data["position"][..., 2] += 1e-17 * np.sin(np.arange(data.sizes["station"]))
    data["strain"][..., 5] += 1e-16
    meta, inflated, _ = page(Run(data))
    curves, _ = viewer_pages.array(meta, inflated, meta["histories"][0]["array"])
    assert not curves[2].any()
    twist, _ = viewer_pages.array(meta, inflated, "field_strain5")
    assert not twist.any()
