"""The page in a real browser: it loads without a complaint, plays, scrubs, colours, and stays safe."""

import json

import matplotlib.image
import numpy as np
import pytest

import viscorod as vr
from helpers import chromium, synthetic_results, viewer_pages
from helpers.viewer_pages import EVIL
from viscorod.pictures.viewer import view
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.run import Run

pytestmark = pytest.mark.skipif(
    chromium.find() is None, reason=f"no browser: none of {', '.join(chromium.NAMES)} is on the PATH"
)
NOW = "document.getElementById('now').textContent"
SCRUB = "Number(document.getElementById('scrub').value)"


@pytest.fixture(scope="module")
def chrome(tmp_path_factory):
    pytest.importorskip("websocket", reason="the package websocket-client drives the browser")
    with chromium.opened(tmp_path_factory.mktemp("profile")) as page:
        yield page


@pytest.fixture
def shown(chrome, tmp_path):
    def show(result, beside=(), **options):
        path = view(result, tmp_path / "page.html", beside=beside)
        chrome.errors.clear()
        chrome.requests.clear()
        chrome.open(path.as_uri(), **options)
        return chrome

    return show


def moving():
    """A clamped beam, held by a force until t = 0, with dissipation."""
    data = synthetic_results.swing(zeta=0.05, duration=4.0)
    data["dissipation"] = 1e-3 * data["strain"][..., 3] ** 2
    loads = [
        {"kind": "force", "at": "beam.end", "value": [0.0, 0.035, 0.0], "until": 0.0},
        {"kind": "gravity"},
    ]
    return Run(viewer_pages.described(data, loads=loads))


def scrub(page, value):
    """Move the slider as a hand does."""
    page.run(
        f"(() => {{ const s = document.getElementById('scrub'); s.value = {value};"
        " s.dispatchEvent(new Event('input')); })()"
    )
    page.drawn()


def space(page, path):
    """Pixels of the view in space ``(rows, columns, 3)``."""
    box = page.run("(() => { const r = document.getElementById('stage').getBoundingClientRect();"
                   " return [r.x, r.y, r.width, r.height]; })()")  # fmt: skip
    x, y, width, height = (round(value) for value in box)
    picture = matplotlib.image.imread(page.picture(path))
    return picture[y : y + height, x : x + width, :3]


def changed(before, after):
    """Number of pixels that differ visibly."""
    return int(np.count_nonzero(np.abs(before - after).max(axis=-1) > 0.1))


def test_page_loads_without_errors_and_asks_for_nothing_but_itself(shown, tmp_path):
    page = shown(moving())
    page.drawn()
    assert page.errors == []
    assert [url for url in page.requests if not url.startswith(("data:", "blob:"))] == [
        (tmp_path / "page.html").as_uri()
    ]
    assert page.run("document.getElementById('title').textContent") == "A swing in closed form"
    assert page.run("document.getElementById('failure').hidden")
    assert (
        page.run("document.querySelectorAll('.uplot').length") == 4
    )  # history, along the rod, energy, damping
    names = page.run(
        "[...document.querySelectorAll('#labels span')].filter(s => !s.hidden).map(s => s.textContent)"
    )
    assert {"clamp at beam.start", "force at beam.end: 0.035 N", "gravity: 9.81 m/s²"} <= set(names)
    # something of many colours is drawn, and not only a white page
    colours = np.unique(np.round(space(page, tmp_path / "page.png").reshape(-1, 3), 1), axis=0)
    assert len(colours) > 20


def test_play_goes_on_in_time_and_pauses(shown):
    page = shown(moving())
    assert page.run(SCRUB) == 0.0
    page.run("document.getElementById('play').click()")
    page.wait(f"{SCRUB} > 0.2")
    assert page.run("document.getElementById('play').textContent") == "Pause"
    page.key(" ", "Space", " ")  # the button that was clicked by a script has no focus
    page.wait("document.getElementById('play').textContent === 'Play'")
    still = page.run(SCRUB)
    page.drawn()
    assert page.run(SCRUB) == still
    assert page.errors == []


def test_speed_is_that_of_the_clock(shown):
    page = shown(moving())
    page.choose("speed", "0.5")
    ran, after = page.run(
        "(() => { const own = window.requestAnimationFrame, asked = [];"
        " window.requestAnimationFrame = (f) => asked.push(f);"
        " const picture = (time) => asked.splice(0).forEach((f) => f(time));"
        " document.getElementById('play').click();"
        " for (let k = 0; k <= 30; k++) picture(1000 + 50 * k);"
        f" const ran = {SCRUB}; picture(3500); window.requestAnimationFrame = own; return [ran, {SCRUB}]; }})()"
    )
    assert ran == pytest.approx(0.5 * 1.5, abs=0.02)
    # a picture that takes more than a quarter of a second is not caught up with
    assert after == pytest.approx(ran + 0.5 * 0.25, abs=0.02)


def test_slider_sets_the_frame_in_view_and_charts(shown, tmp_path):
    page = shown(moving())
    first = space(page, tmp_path / "first.png")
    needle = "document.querySelector('.needle').getBoundingClientRect().x"
    left = page.run(needle)
    scrub(page, 1.74)  # half a period: the other side
    text = page.run(NOW)
    assert text.startswith("t = 1.74")
    time, frame = float(text.split()[2]), int(text.split()[-1].split("/")[0])
    count = int(text.rsplit("/", 1)[1])
    assert frame == round(time / 4.0 * (count - 1)) + 1
    assert page.run(needle) > left + 50
    assert changed(first, space(page, tmp_path / "second.png")) > 1000
    for key, expected in (("End", 4.0), ("Home", 0.0)):
        page.key(key, key)
        assert page.run(SCRUB) == pytest.approx(expected)
    page.key("ArrowRight", "ArrowRight")
    assert page.run(NOW).split("frame ")[1].startswith("2/")
    assert page.errors == []


def test_place_of_the_tip_in_the_scripts_is_that_of_the_run(shown):
    run = moving()
    page = shown(run)
    page.run(
        "(() => { const kind = viscorod.Surface.prototype, old = kind.move;"
        " kind.move = function (...a) { old.apply(this, a); window.surface = this; }; })()"
    )
    for time in (0.0, 0.613, 2.2, 4.0):
        scrub(page, time)
        page.wait("window.surface !== undefined")
        tip = np.array(page.run("[...window.surface.at.slice(-3)]"))
        expected = run.positions_at(time)[-1]
        # straight between frames that are 2.5 ms apart: h^2/8 of the largest acceleration, and half a step
        assert np.abs(tip - expected).max() < 0.0025**2 / 8.0 * 0.2 * 3.6**2 + 0.4 / 65535


PLATE = {
    "shape": "outline",
    "points": [[0, 0], [0.04, 0], [0.04, 0.02], [0, 0.02]],
    "holes": [[[0.02, 0.005], [0.03, 0.005], [0.03, 0.015], [0.02, 0.015]]],
}
CONE = {
    "start": {"shape": "annulus", "outer_radius": 0.01, "inner_radius": 0.009},
    "end": {"shape": "annulus", "outer_radius": 0.006, "inner_radius": 0.002},
}
POLYGON = 7.0 * np.sin(np.pi / 7.0)  # area of the drawn circle of 14 corners over its radius squared


@pytest.mark.parametrize(
    ("form", "area"),
    [
        ({"section": {"shape": "circle", "radius": 0.01}}, POLYGON * 1e-4),
        ({"section": {"shape": "annulus", "outer_radius": 0.01, "inner_radius": 0.008}}, POLYGON * 0.36e-4),
        ({"section": {"shape": "square_tube", "width": 0.03, "thickness": 0.003}}, 4.0 * 0.003 * 0.027),
        ({"section": PLATE}, 7e-4),
        # mean of r^2 of a cone is (r0^2 + r0 r1 + r1^2)/3
        ({"taper": CONE}, POLYGON * (1.96e-4 - 1.03e-4) / 3.0),
    ],
    ids=["circle", "annulus", "square tube", "outline", "tapered annulus"],
)
def test_surfaces_are_closed_and_look_outward(form, area, shown):
    """Triangles of a straight rod enclose its volume, holes left out, and are lit from outside."""
    if form.get("section") is PLATE:
        pytest.importorskip("sectionproperties")
    page = shown(Run(viewer_pages.described(synthetic_results.swing(duration=0.2, amplitude=0.0), **form)))
    page.run(
        "(() => { const kind = viscorod.Surface.prototype, old = kind.draw;"
        " kind.draw = function (...a) { old.apply(this, a); window.surface = this; }; })()"
    )
    page.choose("thickness", page.run("[...document.getElementById('thickness').options].at(-1).value"))
    page.wait("window.surface !== undefined")
    factor = page.run("window.surface.factor")
    read = "[...window.surface.geometry.{}.array]".format
    triangles = np.array(page.run(read("index"))).reshape(-1, 3)
    at, normal = (
        np.array(page.run(read(f"attributes.{name}"))).reshape(-1, 3) for name in ("position", "normal")
    )
    a, b, c = at[triangles].transpose(1, 0, 2)
    flat = np.cross(b - a, c - a)
    volume = np.sum(a * np.cross(b, c)) / 6.0
    assert volume == pytest.approx(factor**2 * area * synthetic_results.LENGTH, rel=2e-3)
    assert np.linalg.norm(flat.sum(axis=0)) < 1e-6 * np.abs(flat).sum()  # closed
    assert np.all(np.einsum("ti,tki->tk", flat, normal[triangles]) >= -1e-12)
    assert page.errors == []


def test_click_in_a_chart_goes_there(shown):
    page = shown(moving())
    x, y, width = page.run(
        "(() => { const chart = document.querySelector('#history-chart .u-over');"
        " const r = chart.getBoundingClientRect(); return [r.x, r.y + r.height / 2, r.width]; })()"
    )
    page.click(x + 0.75 * width, y)
    assert page.run(SCRUB) == pytest.approx(3.0, abs=0.03)


def test_field_changes_the_colours_and_their_scale(shown, tmp_path):
    page = shown(moving())
    pictures, scales = [], []
    for field in ("bending", "strain3", "force3", "dissipation", "speed", ""):
        page.choose("field", field)
        scrub(page, 0.5)
        pictures.append(space(page, tmp_path / f"{field or 'none'}.png"))
        scales.append(page.run("document.getElementById('scale-high').textContent"))
    for one, two in ((0, 1), (0, 3), (3, 4), (4, 5)):
        assert changed(pictures[one], pictures[two]) > 300, (one, two)
    # a bending of both signs and a size of one: 2 q / L^2 with q = 0.2 m at the start
    assert scales[0] == scales[1] == "4.44 1/m"
    assert scales[3].endswith("W/m") or scales[3].endswith("mW/m")
    page.choose("field", "bending")
    page.choose("range", "now")
    page.drawn()
    assert page.run("document.getElementById('scale-high').textContent") != "4.44 1/m"
    assert page.errors == []


def test_symbols_loads_and_trace_can_be_left_out(shown, tmp_path):
    page = shown(moving())
    before = space(page, tmp_path / "all.png")
    for word in ("symbols", "loads", "grid", "reference"):
        page.run(f"document.getElementById('show-{word}').click()")
        after = space(page, tmp_path / f"{word}.png")
        assert changed(before, after) > 30, word
        before = after
    page.choose("trace", "")
    assert changed(before, space(page, tmp_path / "trace.png")) > 30


def test_text_from_a_file_is_shown_as_text(shown):
    data = synthetic_results.swing(duration=0.4).assign_attrs(title=EVIL, warnings=json.dumps([EVIL]))
    data = data.assign_coords(support=[EVIL], station_rod=("station", [EVIL] * synthetic_results.STATIONS))
    page = shown(Run(data))
    page.drawn()
    assert page.run("document.getElementById('title').textContent") == EVIL
    assert page.run("document.title").startswith("</script><img src=x")
    assert page.run("document.querySelector('#warnings li').textContent") == EVIL
    assert page.run("document.querySelectorAll('img').length") == 0
    assert page.run("window.hit === undefined")
    assert page.errors == []


def test_equilibrium_is_played_along_the_load_factor(shown):
    page = shown(Equilibrium(synthetic_results.rolled_up()))
    assert page.run(NOW).startswith("load factor 0.250")
    page.key("End", "End")
    assert page.run(NOW).startswith("load factor 1.000")
    assert page.run("document.getElementById('decay').hidden")
    assert page.run("document.querySelector('#history option').textContent").startswith(
        "displacement of beam.end"
    )
    assert page.errors == []


def test_path_whose_loads_fall_again_is_played_state_by_state(shown):
    data = synthetic_results.rolled_up(factors=(0.2, 0.6, 0.9, 0.7, 0.4))
    page = shown(Equilibrium(data))
    scrub(page, 3)
    assert page.run(NOW).startswith("load factor 0.7")
    assert page.run(NOW).endswith("frame 4/5")
    assert page.errors == []


def test_one_state_is_shown_without_a_player(shown):
    page = shown(Run(synthetic_results.swing(duration=0.0)))
    assert page.run("document.getElementById('play').disabled")
    assert page.errors == []


def test_narrow_window_needs_no_sideways_scrolling(shown, tmp_path):
    page = shown(moving(), width=390, height=800)
    page.drawn()
    assert page.run("document.documentElement.scrollWidth") <= 390
    page.picture(tmp_path / "narrow.png")
    page.resize(1400, 900)


def test_the_list_of_rods_of_a_chart_stands_below_its_long_title_on_a_telephone(shown):
    model = vr.Model()
    rubber = vr.Material(1e6, 0.3, 1000.0)
    for name, y in (("left_finger", 0.0), ("right_finger", 0.1)):
        model.add(name, vr.Rod.straight((0, y, 0), (0.3, y, 0), section=vr.Circle(0.005), material=rubber))
        model.clamp(f"{name}.start")
        model.force(f"{name}.end", (0.0, 0.0, 0.001))
    page = shown(model.equilibrium(), width=420, height=800)
    page.drawn()
    assert page.run("document.getElementById('along-rod').hidden") is False
    assert page.run("document.documentElement.scrollWidth") <= 420
    page.resize(1400, 900)


@pytest.mark.slow
def test_long_run_is_drawn_fast_enough(shown):
    page = shown(Run(viewer_pages.beating()))
    least = page.run(
        "(async () => { const kind = viscorod.Space.prototype, old = kind.draw; let least = 1e9, count = 0;"
        " kind.draw = function () { const t = performance.now(); old.call(this);"
        " least = Math.min(least, performance.now() - t); count++; };"
        " document.getElementById('play').click();"
        " while (count < 20) await new Promise((done) => setTimeout(done, 20));"
        " document.getElementById('play').click(); kind.draw = old; return least; })()"
    )
    # what the scripts take of a thirtieth of a second where nothing interrupts them: 4 ms where it was measured, with
    # the same work in every picture; WebGL's own time is not theirs
    assert least < 33.0
    assert page.errors == []


def test_modes_swing_beside_their_table(shown, tmp_path):
    """A clamped strip, bent by nothing: names and numbers are in the table, and the row that is chosen moves."""
    steel = vr.Material(2.1e11, 0.3, 7850.0, damping=vr.KelvinVoigt(1e-5, 1e-5))
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.5, 0, 0), section=vr.Rectangle(0.02, 0.005), material=steel, elements=2, order=4
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    modes = model.modes(3, title=EVIL)
    page = shown(modes)
    page.drawn()
    rows = page.run(
        "[...document.querySelectorAll('#modes tbody tr')].map(r => [...r.cells].map(c => c.textContent))"
    )
    assert [row[1] for row in rows] == list(modes.names)
    numbers = np.array([[float(text.replace("\u2212", "-")) for text in row[2:]] for row in rows])
    np.testing.assert_allclose(numbers, np.transpose([modes.frequencies, modes.damping_ratios]), rtol=5e-3)
    assert page.run("document.getElementById('play').textContent") == "Pause"  # it swings at once
    page.run("document.querySelectorAll('#modes tbody tr')[1].click()")
    assert page.run("document.getElementById('mode').value") == "1"
    page.run("document.getElementById('play').click()")
    least = page.run("Number(document.getElementById('scrub').min)")
    scrub(page, least)
    assert page.run(NOW) == "phase 0\u00b0"
    before = space(page, tmp_path / "before.png")
    scrub(page, least + 0.5)
    assert page.run(NOW) == "phase 180\u00b0"
    assert changed(before, space(page, tmp_path / "after.png")) > 200
    assert page.run("window.hit") is None
    assert page.errors == []


def test_a_dark_page_has_a_dark_view_and_light_axes(shown, tmp_path):
    page = shown(moving())
    light = space(page, tmp_path / "light.png")
    page.key("d", "KeyD", "d")
    assert page.run("document.documentElement.hasAttribute('data-dark')")
    dark = space(page, tmp_path / "dark.png")
    assert np.median(light) > 0.9
    assert np.median(dark) < 0.2
    assert page.run("document.getElementById('dark').getAttribute('aria-pressed')") == "true"
    assert page.errors == []


def test_the_field_along_the_rod_is_that_of_the_present_time(shown):
    """Against the values of the result itself, at the nearest frame."""
    run = moving()
    page = shown(run)
    page.choose("field", "strain3")
    series = "document.querySelector('#along-chart .uplot') !== null"
    assert page.run(series)
    page.run("document.documentElement.dataset.test = ''")
    scrub(page, 1.74)
    title = page.run("document.getElementById('along-title').textContent")
    assert title == "Bend 1 along beam now"
    page.choose("field", "")
    assert page.run("document.getElementById('along').hidden")
    assert page.errors == []


def test_the_view_is_saved_as_a_picture(shown):
    """What the reader is given is a PNG as large as the view, and more than paper."""
    page = shown(moving())
    size, kind, link = page.run(
        "(async () => { const told = []; const own = URL.createObjectURL;"
        " URL.createObjectURL = (blob) => { told.push(blob.size, blob.type); return own(blob); };"
        " const click = HTMLAnchorElement.prototype.click;"
        " HTMLAnchorElement.prototype.click = function () { told.push(this.download); };"
        " document.getElementById('save').click();"
        " while (told.length < 3) await new Promise((done) => setTimeout(done, 20));"
        " URL.createObjectURL = own; HTMLAnchorElement.prototype.click = click; return told; })()"
    )
    assert (kind, link) == ("image/png", "viscorod.png")
    assert size > 5000
    assert page.errors == []


def test_values_below_rounding_are_told_as_zero(shown):
    """A coordinate that begins at 1e-27 m and moves far: its first value had been told as it is."""
    page = shown(moving())
    told = "(() => { const told = viscorod.toldOf([[1e-27, 3.0], [0.5]]); return [1e-27, -1e-12, 1e-9].map(told); })()"
    zero, rounding, small = page.run(told)
    assert zero == rounding == "0"
    assert small == "1e\u22129"
    assert page.run("viscorod.toldOf([[1e-27, 2e-27]])(1e-27)") != "0"


def test_another_motion_is_drawn_beside_it(shown, tmp_path):
    run, other = moving(), Run(synthetic_results.swing(zeta=0.2, duration=4.0))
    page = shown(run)
    alone = space(page, tmp_path / "alone.png")
    page = shown(run, beside=[other])
    both = space(page, tmp_path / "both.png")
    assert changed(alone, both) > 50
    legend = page.run("document.querySelector('#history-chart .u-legend').textContent")
    assert "y, A swing in closed form (2)" in legend
    assert page.errors == []


def test_names_do_not_run_under_the_buttons_and_controls_keep_to_two_rows(shown):
    """A result of a long name beside a motion of microseconds, whose speed is a long word."""
    run = moving()
    run.data["time"] = 1e-6 * run.data["time"]
    page = shown(Run(run.data), beside={"out/of/a/folder/that/has/a/long/name/run.nc": Run(run.data)})
    box = "((e) => { const b = e.getBoundingClientRect(); return [b.left, b.right, b.top, b.bottom]; })"
    names = page.run(f"[...document.querySelectorAll('#legend span')].map({box})")
    buttons = page.run(f"[...document.querySelectorAll('#look button')].map({box})")
    assert len(names) > 3
    for left, right, top, bottom in names:
        for other_left, other_right, other_top, other_bottom in buttons:
            apart = right <= other_left or other_right <= left or bottom <= other_top or other_bottom <= top
            assert apart
    (_, _, top, bottom), (_, _, play, _) = (
        page.run(f"{box}(document.getElementById('{name}'))") for name in ("player", "play")
    )
    assert bottom - top < 50.0
    assert play >= top
    assert page.errors == []


def test_labels_in_space_keep_off_legend_and_buttons_on_a_telephone(shown):
    """The force is above the middle, where at 420 px several rows of names stand."""
    page = shown(
        moving(), beside={"out/of/a/folder/that/has/a/long/name/run.nc": moving()}, width=420, height=500
    )
    page.run("document.querySelector('[data-look=z]').click()")
    page.drawn()
    box = "((e) => { const b = e.getBoundingClientRect(); return [b.left, b.right, b.top, b.bottom]; })"
    labels = page.run(f"[...document.querySelectorAll('#labels span')].filter(s => !s.hidden).map({box})")
    others = page.run(f"[...document.querySelectorAll('#legend span, #look button')].map({box})")
    assert len(labels) == 3
    for left, right, top, bottom in labels:
        for other_left, other_right, other_top, other_bottom in others:
            assert right <= other_left or other_right <= left or bottom <= other_top or other_bottom <= top
    assert page.errors == []
