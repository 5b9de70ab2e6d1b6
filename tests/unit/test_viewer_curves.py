"""Pages of curves and of critical loads, read back without a browser and in one."""

import numpy as np
import pytest

import viscorod as vr
from helpers import chromium, viewer_pages
from helpers.viewer_pages import EVIL
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case
from viscorod.pictures.viewer import view


def shipped(name):
    return load_case(shipped_case(name)).model(vr.Model)


@pytest.fixture(scope="module")
def motions():
    """A few motions of the clamped strip, in the linear range, so that the curve is even."""
    return shipped("clamped_strip").periodic(
        inputs="beam@0.2 fz", amplitudes=[0.01], outputs=["beam@0.2 uz", "beam@0.2 vz"], frequencies=[60.0, 70.0],
        harmonics=2, title=EVIL,
    )  # fmt: skip


@pytest.fixture(scope="module")
def diagram():
    return shipped("whirling_shaft").campbell(
        (1, 0, 0), speeds=[90.0, 110.0, 130.0], modes=2, frame="space", title=EVIL
    )


@pytest.fixture
def page(tmp_path):
    def make(result, **options):
        text = view(result, tmp_path / "page.html", **options).read_text(encoding="utf-8")
        meta, data = viewer_pages.parts(text)
        return meta, lambda row: viewer_pages.array(meta, data, row[0])[0][row[1]], text

    return make


def of_title(meta, start):
    return next(chart for chart in meta["charts"] if chart["title"].startswith(start))


def test_campbell_page_has_the_numbers_of_the_diagram(page, diagram):
    meta, row, text = page(diagram)
    assert meta["title"] == EVIL
    assert "<img" not in text
    assert row([meta["slider"]["places"], 0]) == pytest.approx(diagram.speeds)
    above, below = of_title(meta, "Frequencies"), of_title(meta, "Damping")
    for k, (curve, ratio) in enumerate(zip(above["curves"], below["curves"], strict=True)):
        assert curve["name"] == diagram.modes[k]
        assert row(curve["x"]) == pytest.approx(diagram.speeds)
        assert row(curve["y"]) == pytest.approx(diagram.frequencies[:, k], rel=1e-6)
        assert row(ratio["y"]) == pytest.approx(100.0 * diagram.damping_ratios[:, k], rel=1e-6, abs=1e-9)
    assert [mark["x"] for mark in above["marks"]] == [one.speed for one in diagram.critical_speeds]
    assert above["guides"][0]["y"][1] == pytest.approx(130.0 / (2.0 * np.pi))
    critical = next(table for table in meta["tables"] if table["title"] == "Critical speeds")
    assert [cells[2] for cells in critical["rows"]] == [one.speed for one in diagram.critical_speeds]


PREFIXES = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "": 1.0}


def in_si(label, unit):
    """Factor to SI of an axis, "amplitude [µm]", whose values have a prefix."""
    shown = label.partition("[")[2].removesuffix("]")
    assert shown.endswith(unit)
    return PREFIXES[shown.removesuffix(unit)]


def test_periodic_page_has_cycles_loops_and_multipliers(page, motions):
    """The area of a loop is the work of a cycle; a polygon of 96 sides lacks (2 pi/96)^2/6 of an ellipse."""
    meta, row, _ = page(motions)
    amplitude, course = of_title(meta, "Amplitude of beam@0.2 uz"), of_title(meta, "A cycle of beam@0.2 uz")
    size = in_si(amplitude["y"], "m")
    assert size < 1e-3  # the motion is small: its axis has a prefix
    assert size * row(amplitude["curves"][0]["y"]) == pytest.approx(motions.amplitude(0), rel=1e-6)
    loop, circle = of_title(meta, "Loop"), of_title(meta, "Floquet")
    joule = in_si(loop["x"], "m") * in_si(loop["y"], "N")
    loss = of_title(meta, "Energy lost")
    assert in_si(loss["y"], "J") * row(loss["curves"][0]["y"]) == pytest.approx(motions.loss, rel=1e-6)
    for k in range(len(motions.frequencies)):
        moved, force = (row([loop["curves"][0][side][0], k]) for side in "xy")
        area = abs(0.5 * np.sum(moved[:-1] * force[1:] - moved[1:] * force[:-1]))
        assert joule * area == pytest.approx(motions.work[k], rel=2.0 * (2.0 * np.pi / 96) ** 2 / 6.0)
        cycle = row([course["curves"][0]["y"][0], k])
        swing = 0.5 * in_si(course["y"], "m") * np.ptp(cycle)
        assert swing == pytest.approx(motions.amplitude(0)[k], rel=3e-3)
        real, imaginary = (row([circle["curves"][0][side][0], k]) for side in "xy")
        assert real + 1j * imaginary == pytest.approx(motions.multipliers[k], rel=1e-5, abs=1e-7)
    assert [choice["names"] for choice in meta["choices"]] == [
        ["beam@0.2 uz", "beam@0.2 vz"],
        ["beam@0.2 fz"],
    ]


def test_fewer_places_are_told(page, motions):
    meta, row, _ = page(motions, frames=2)
    assert len(row([meta["slider"]["places"], 0])) == 2
    assert meta["notes"] == [f"2 of {len(motions.frequencies)} places along the curves are shown"]


def test_stability_and_response_have_pages(page):
    column = shipped("becks_column").stability([9.0, 10.0, 12.0], modes=1)
    meta, row, _ = page(column)
    assert of_title(meta, "Frequencies")["marks"][0]["x"] == pytest.approx(column.limits[0].at)
    dashed = of_title(meta, "Damping")["curves"][0]["dashed"]
    assert row(dashed).tolist() == [0.0, 0.0, 1.0]
    response = shipped("shaken_strip").frequency_response(
        "base uz", ["beam.end uz"], frequencies=[5.0, 10.0, 20.0]
    )
    meta, row, _ = page(response)
    size = of_title(meta, "beam.end uz over base uz")
    assert size["log"] == ["y"]
    assert row(size["curves"][0]["y"]) == pytest.approx(response.amplification(), rel=1e-6)


def test_shapes_of_critical_loads_swing_about_the_critical_state(page):
    model = shipped("tall_rod")
    found = model.buckling(2)
    meta, _, text = page(found)
    assert [one["cells"][0] for one in meta["modes"]] == ["buckles"] * len(found.load_factors)
    assert f"load factor {found.load_factors[0]:.6g}" == meta["modes"][0]["name"]
    positions, half = viewer_pages.array(*viewer_pages.parts(text), "positions")
    swing = positions[meta["modes"][0]["first"] : meta["modes"][0]["last"] + 1]
    middle = 0.5 * (swing[0] + swing[len(swing) // 2])  # half a swing apart
    assert middle == pytest.approx(found.positions[0], abs=float(2.0 * half.max()))
    assert np.abs(swing[0] - middle).max() == pytest.approx(0.1 * 5.0, rel=1e-3)  # a tenth of the length


@pytest.mark.skipif(chromium.find() is None, reason="no browser")
def test_a_place_is_chosen_in_a_browser(tmp_path, motions, diagram):
    pytest.importorskip("websocket", reason="the package websocket-client drives the browser")
    with chromium.opened(tmp_path / "profile") as shown:
        for result, number in ((motions, 2), (diagram, 1)):
            shown.open(view(result, tmp_path / "page.html").as_uri())
            shown.run(f"document.getElementById('scrub').value = {number}")
            shown.run("document.getElementById('scrub').dispatchEvent(new Event('input'))")
            shown.drawn()
            cells = shown.run(
                "[...document.querySelectorAll('#live tbody tr')].map(r => [...r.cells].map(c => c.textContent))"
            )
            told = [float(row[1].replace("\u2212", "-")) for row in cells]
            wanted = [motions.frequencies[2], 1.0] if result is motions else diagram.frequencies[1]
            assert told[:2] == pytest.approx(list(wanted), rel=1e-5)
            assert shown.run("document.querySelectorAll('.chosen').length") > 0
            shown.key("Home", "Home")
            assert shown.run("document.getElementById('scrub').value") == "0"
        # a click near the end of the curve chooses its last place
        corner = "document.querySelector('#curves svg').getBoundingClientRect()"
        shown.click(shown.run(f"{corner}.right") - 20, shown.run(f"{corner}.top") + 40)
        assert shown.run("document.getElementById('scrub').value") == "2"
        assert shown.run("window.hit") is None
        assert shown.errors == []
        assert [url for url in shown.requests if not url.startswith(("file:", "data:"))] == []
