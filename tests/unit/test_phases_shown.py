"""Phases of responses: the same on pages and in pictures, against the closed form of a delay."""

import numpy as np
import pytest
import xarray as xr

import viscorod as vr
from helpers import chromium, viewer_pages
from viscorod.pictures.viewer import view

DELAY = 0.03  # s: three turns up to 100 Hz
HERTZ = np.linspace(1.0, 100.0, 23)
"""So far apart that nobody could count the turns between them: 49 degrees each, and every third response is missing."""


@pytest.fixture(scope="module")
def delayed():
    """The output follows the input a while later: H = exp(-i omega T), whose phase falls by 360 f T degrees."""
    values = np.exp(-2j * np.pi * HERTZ * DELAY)
    parts = np.stack([values.real, values.imag], axis=-1)
    data = xr.Dataset(
        {
            "response": (("frequency", "output", "input", "part"), parts[:, None, None, :]),
            "pole": (("mode", "part"), np.zeros((0, 2))),
            "residue": (("mode", "output", "input", "part"), np.zeros((0, 1, 1, 2))),
            "pole_name": (("mode",), np.array([], dtype="U1")),
            "input_unit": (("input",), ["m"]),
            "output_unit": (("output",), ["m"]),
        },
        coords={
            "frequency": HERTZ,
            "input": ["base uz"],
            "output": ["tip uz"],
            "part": ["real", "imaginary"],
        },
        attrs={"kind": "response"},
    )
    return vr.FrequencyResponse(data)


def wrapped(hertz):
    """Between -180 and 180 degrees, by whole turns."""
    return (-360.0 * DELAY * hertz + 180.0) % 360.0 - 180.0


def test_page_and_picture_have_the_phases_of_the_closed_form(delayed, tmp_path):
    text = view(delayed, tmp_path / "page.html").read_text(encoding="utf-8")
    meta, data = viewer_pages.parts(text)
    chart = next(one for one in meta["charts"] if one["title"] == "Phase")
    rows = [viewer_pages.array(meta, data, chart["curves"][0][side][0])[0][0] for side in "xy"]
    assert rows[0] == pytest.approx(HERTZ, rel=1e-6)
    assert rows[1] == pytest.approx(wrapped(HERTZ), abs=1e-4)
    panel = delayed.plot().axes[1]
    x, y = panel.lines[-1].get_data()
    drawn = np.isfinite(y)
    assert x[drawn] == pytest.approx(HERTZ)
    assert y[drawn] == pytest.approx(wrapped(HERTZ), abs=1e-9)
    jumps = np.abs(np.diff(wrapped(HERTZ))) > 180.0
    assert np.count_nonzero(~drawn) == np.count_nonzero(jumps) == 3
    assert panel.get_ylabel() == chart["y"] == "phase [degrees]"
    assert panel.get_ylim() == tuple(chart["range"])


@pytest.mark.skipif(chromium.find() is None, reason="no browser")
def test_the_page_draws_no_line_over_a_jump(delayed, tmp_path):
    pytest.importorskip("websocket", reason="the package websocket-client drives the browser")
    with chromium.opened(tmp_path / "profile") as shown:
        shown.open(view(delayed, tmp_path / "page.html").as_uri())
        shown.drawn()
        lines = shown.run(
            "[...[...document.querySelectorAll('.curve-chart')].find((c) => c.textContent.startsWith('Phase'))"
            ".querySelectorAll('polyline')].map((p) => p.getAttribute('points').split(' '))"
        )
        places = [np.array([pair.split(",") for pair in line], dtype=float) for line in lines]
        assert sum(len(line) for line in places) == len(HERTZ)
        assert len(places) == 4
        for line in places:
            assert np.all(np.diff(line[:, 1]) > 0.0)  # it falls, which is down the screen, and never jumps up
        assert shown.errors == []
