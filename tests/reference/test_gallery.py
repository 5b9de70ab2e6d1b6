"""Every shipped case against the number that the gallery names, and the gallery against the shipped cases."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case, shipped_cases
from viscorod.cli.app import app

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "gallery.md").read_text(encoding="utf-8")


def height(run, time):
    """z of the middle of the bridge beam."""
    return np.interp(time, run.time, run.history("beam@15.0").sel(axis="z").values)


def lag(run):
    """Largest distance of the tip from the axis that turns with the root."""
    turned = np.array([vr.SpinUp(6.0, 15.0).value(t) for t in run.time])
    x, y, _ = run.history("arm.end").values.T
    return np.max(np.sin(turned) * x - np.cos(turned) * y)


def released(name):
    """The first mode once the force that holds it before t = 0 is gone: frequency and damping ratio."""
    modes = load_case(shipped_case(name)).model(vr.Model).modes(1, about="released")
    return modes.frequencies[0], modes.damping_ratios[0]


def sag(run):
    """How far the spring hangs down under its own weight."""
    model = load_case(shipped_case("helix_spring")).model(vr.Model)
    model.loads[:] = [load for load in model.loads if isinstance(load, vr.Gravity)]
    return -model.equilibrium().displacement("spring.end")[2]


def vibration(run):
    """Frequency of the undamped vibration and damping ratio, from the decay."""
    found = run.decrement("strip.end", "z")
    ratio = found.small_amplitude_ratio
    return 1.0 / found.period[1:].mean() / np.sqrt(1 - ratio**2), ratio


def amplification(response):
    """Size of the response at 0.95 of the first frequency, between the frequencies chosen, and at its peak."""
    hertz, values = response.frequencies, response.response()
    first = response.poles[0].imag / (2.0 * np.pi)
    below = complex(np.interp(0.95 * first, hertz, values.real), np.interp(0.95 * first, hertz, values.imag))
    return abs(below), response.resonances()[0].amplitude


def hardened(found):
    """Frequency at the peak over that of the backbone of one mode, w^2 = w1^2 + 3/4 alpha q^2."""
    height = found.amplitude("beam@0.2 uz")
    slow, stretched = 98.136, 109.670  # Hz, without amplitude and at 2.0376 mm
    backbone = np.sqrt(slow**2 + (stretched**2 - slow**2) * (height.max() / 2.0376e-3) ** 2)
    return found.frequencies[height.argmax()] / backbone


# name: what is taken from the result, what it should be, and the relative tolerance. It is the agreement that the
# gallery states; what a source leaves out is told there.
CHECKS = {
    "cantilever_swing": (lambda run: run.decrement("beam.end", "y").small_amplitude_ratio, 0.0357, 5e-3),
    "rubber_strip": (lambda run: released("rubber_strip"), (2.40078, 0.0504), 1e-3),
    "damped_strip": (vibration, (3.8814, 0.02758), 4e-3),
    "helix_spring": (sag, 0.05593, 3e-2),
    "soft_arm": (
        lambda run: run.decrement("end_plate.rim", "y").small_amplitude_ratio / released("soft_arm")[1],
        1.0,
        5e-3,
    ),
    "comb_resonator": (lambda run: 1.0 / run.decrement("shuttle", "x").period.mean(), 16479.0, 2e-3),
    "prestressed_bridge": (lambda run: (height(run, 1.25), height(run, 1.5)), (-3.0472, 1.7979), 1e-4),
    "hinged_beam": (lambda run: run.energy.total[-1], 0.44375, 2e-4),
    "flying_rod": (lambda run: run.energy.total[run.time > 5.0], 724.41, 1e-4),
    "right_angle_frame": (lambda run: run.energy.total[run.time > 2.0], 114.88, 4e-4),
    "spinning_up_arm": (lag, 0.573835, 1e-4),
    "four_bar": (
        lambda run: (
            *run.history("crank.end").values[-1],
            run.joint("motor")["force"].sel(motion="rz").values[-1],
        ),
        (0.109024, 0.050133, -0.000522, -5.53),
        1e-3,
    ),
    "bend_45": (lambda held: held.position("bend.end"), (15.68480, 47.15044, 53.47486), 1e-6),
    "princeton_beam": (lambda held: held.displacement("beam.end")[1:], (0.015621, 0.156775), 1e-4),
    "deep_arch": (lambda path: 10.0 * path.limit_points[0], 8.97, 5e-4),
    "elastica_column": (
        lambda path: (*path.position("column.end")[[0, 2]], path.rotation("column.end")[1]),
        (0.80317, 0.12316, np.radians(120.0)),
        2e-5,
    ),
    "shaken_strip": (amplification, (15.39, 156.6), 4e-3),
    "clamped_strip": (hardened, 1.0, 6e-3),
    "becks_column": (lambda found: found.limits[0].at, 10.96611166, 1e-7),
    "tall_rod": (lambda found: found.load_factors, [1.017725, 1.017725, 7.26894, 7.26894], 2e-5),
    "whirling_shaft": (lambda diagram: diagram.limits[0].at, 252.904, 2e-5),
    "swept_blade": (lambda turning: turning.frequencies[[0, 2, 3]], (14.7, 26.1, 44.8), 0.08),
}


@pytest.mark.parametrize("name", shipped_cases())
def test_case_has_the_number_of_its_source(name, tmp_path, monkeypatch):
    """The command of the gallery, in an empty folder; the number is taken from the file that it writes.

    The file has the report that was printed, finite numbers, and of the energy hardly anything was lost by the steps.
    """
    monkeypatch.chdir(tmp_path)
    for command in (["example", name], ["run", f"{name}.toml"]):
        result = CliRunner().invoke(app, command)
        assert result.exit_code == 0, result.output
    run = vr.load(f"out/{name}/run.nc")
    assert run.outcome == "completed"
    report = run.report()
    assert str(run) == report
    assert report in result.output
    for variable in run.data.variables.values():
        if variable.dtype.kind == "f":
            assert np.isfinite(variable.values).all()
    if isinstance(run, vr.Run):
        assert run.energy.numerical_fraction < 0.01
    take, expected, tolerance = CHECKS[name]
    found = np.asarray(take(run), dtype=float)
    assert found == pytest.approx(np.broadcast_to(expected, found.shape), rel=tolerance)


def test_decay_of_the_rubber_strip_has_the_ratio_of_its_mode():
    """Its position of rest moves by a sixth of what the amplitude loses per cycle; no late cycle is off by it."""
    run = load_case(shipped_case("rubber_strip")).model(vr.Model).simulate(4.0)
    found = run.free_decay("strip.end", "z")
    assert found.damping_ratio[-4:] == pytest.approx(0.0504044, rel=2e-3)
    assert found.limit == ("small amplitude", pytest.approx(0.0504044, rel=2e-3))


@pytest.mark.parametrize("name", shipped_cases())
def test_gallery_shows_the_case(name):
    """One section each, with a picture that is small, the command, the source and the number."""
    section = next(part for part in PAGE.split("\n## ") if f"viscorod example {name} &&" in part)
    assert f"$ viscorod example {name} && viscorod run {name}.toml\n" in section
    picture = DOCS / re.search(rf"\((images/gallery/{name}\.png)\)", section)[1]
    assert picture.stat().st_size <= 60_000
    assert "* Source: " in section
    assert "* Checked against: " in section


def test_gallery_shows_nothing_else():
    assert set(re.findall(r"viscorod run (\w+)\.toml", PAGE)) == set(shipped_cases())


@pytest.mark.parametrize("name", shipped_cases())
def test_header_names_the_source(name):
    header = shipped_case(name).read_text(encoding="utf-8").partition("\ntitle = ")[0]
    assert "\n# Source: " in header
