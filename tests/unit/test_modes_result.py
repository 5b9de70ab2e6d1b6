"""Modes and frequency responses as results: case files, commands, files, pictures, reports."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers.pictures import written
from helpers.plain_text import flat
from helpers.viewer_pages import array, parts
from viscorod.casefile.case import parse_case
from viscorod.cli.app import app

CASE = """
title = "A strip"

[materials.steel]
youngs_modulus = 2.1e11
poissons_ratio = 0.3
density = 7850.0
damping = { shear_time = 1e-5, bulk_time = 1e-5 }

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.5, 0.0, 0.0]
section = { shape = "rectangle", width = 0.02, height = 0.005 }
material = "steel"
elements = 2
order = 4

[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [400.0, 0.0, 0.0]
"""
MODES = CASE + "\n[modes]\ncount = 3\n"
RESPONSE = (
    CASE
    + """
[response]
inputs = ["base uz", { kind = "distributed_force", rod = "beam", value = [0.0, 0.0, 1.0] }]
outputs = ["beam.end uz"]
band = ["10 Hz", "0.05 kHz"]
"""
)


def run(tmp_path, text, *command):
    path = tmp_path / "strip.toml"
    path.write_text(text)
    return CliRunner().invoke(app, [command[0], str(path), "-o", str(tmp_path / "out"), *command[1:]])


def test_modes_are_a_result_like_others(tmp_path):
    """Loads included: a rod in tension swings faster. The file gives back all that was found."""
    model = parse_case(MODES).model(vr.Model)
    found = model.modes(3)
    assert found.frequencies[0] > 1.02 * model.modes(3, about="reference").frequencies[0]
    again = vr.load(found.save(tmp_path / "modes.nc"))
    assert isinstance(again, vr.Modes)
    for name in (
        "eigenvalues",
        "shapes",
        "rotations",
        "positions",
        "residuals",
        "shares",
        "frequency_errors",
    ):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert (again.names, again.rigid, again.certified) == (found.names, found.rigid, found.certified)
    assert again.report() == found.report()
    assert "1: bend_1 1" in flat(found.report())
    assert written(found.plot, tmp_path / "modes.png", 2).stat().st_size > 10_000
    meta, data = parts(vr.view(found, tmp_path / "modes.html").read_text(encoding="utf-8"))
    told = [(one["name"], *one["cells"]) for one in meta["modes"]]
    assert told == list(zip(found.names, found.frequencies, found.damping_ratios, strict=True))
    positions, half = array(meta, data, "positions")
    second = meta["modes"][1]
    swing = positions[second["first"] : second["last"] + 1] - found.positions
    # it begins with the real part of the shape, and ends as it began; half a swing later it is on the other side
    shape = found.shapes[1].real
    np.testing.assert_allclose(swing[0] / np.abs(swing[0]).max(), shape / np.abs(shape).max(), atol=1e-3)
    np.testing.assert_allclose(swing[-1], swing[0], atol=4 * half.max())
    np.testing.assert_allclose(swing[12], -swing[0], atol=4 * half.max())
    start = model.equilibrium(start=found)  # the state that they are about
    np.testing.assert_allclose(start.field("position", states=-1), found.positions, atol=1e-9)


def test_modes_of_any_case(tmp_path):
    """The command takes the table of the case, or any other case, and options before it."""
    shown = run(tmp_path, MODES, "modes")
    assert shown.exit_code == 0, shown.output
    assert "3: bend_1 2" in shown.output
    assert vr.load(tmp_path / "out" / "modes.nc").title == "A strip"
    other = run(tmp_path, CASE + "\n[equilibrium]\n", "modes", "--count", "1", "--about", "reference")
    assert other.exit_code == 0, other.output
    assert "2: " not in other.output
    assert "as if free of load" in other.output
    whole = run(tmp_path, MODES, "run")
    assert whole.exit_code == 0, whole.output
    assert "3: bend_1 2" in whole.output


def test_response_of_a_case(tmp_path):
    shown = run(tmp_path, RESPONSE, "response")
    assert shown.exit_code == 0, shown.output
    assert "beam.end uz over base uz, 1: peaks" in shown.output
    found = vr.load(tmp_path / "out" / "response.nc")
    assert found.inputs == ("base uz", "distributed_force beam")
    assert found.frequencies[-1] == 50.0
    assert found.title == "A strip"
    refused = run(tmp_path, MODES, "response")
    assert refused.exit_code == 2
    assert "give a table [response]" in refused.output
    case = parse_case(RESPONSE)
    assert parse_case_again(case).settings == case.settings


def parse_case_again(case):
    from viscorod.casefile.case import case_from_dict

    return case_from_dict(case.to_dict())


def test_what_was_assumed_of_the_damping_stands_beside_its_ratios():
    """Moduli that no Kelvin-Voigt material follows are told where the damping ratio is read, once for equal rods."""
    omega = 2.0 * np.pi * np.logspace(-1.0, 3.0, 9)
    moduli = 2e6 + 3e6 * 1j * omega * 0.002 / (1.0 + 1j * omega * 0.002)
    table = vr.ComplexModuli(frequency=omega / (2.0 * np.pi), storage=moduli.real, loss=moduli.imag)
    rubber = vr.Material(poissons_ratio=0.49, density=1100.0, damping=table)
    model = vr.Model()
    for name in ("left", "right"):
        section = vr.Rectangle(0.02, 0.005)
        model.add(name, vr.Rod.straight((0, 0, 0), (0.2, 0, 0), section=section, material=rubber, elements=1))
        model.clamp(f"{name}.start")
    found = model.modes(2)
    text = flat(found.report())
    for sentence in rubber.assumptions:
        assert text.count(f"rods left, right: {sentence}") == 1
    assert re.search(r"loss modulus by \S+ %", text)
    assert 'law = "maxwell" follows the table' in text  # what would help


@pytest.mark.parametrize("modulus", [2e11, 7e10, 1.1e11, 3e9])
def test_the_sign_of_a_shape_with_two_equal_maxima_is_not_round_off(modulus):
    """The second bending mode of a beam on two supports has peaks of opposite signs: the first one is positive."""
    model = vr.Model()
    material = vr.Material(modulus, 0.3, 2000.0)
    section = vr.Rectangle(0.02, 0.01)
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, material=material, elements=4))
    model.support("beam.start", ("ux", "uy", "uz", "rx"))
    model.support("beam.end", ("uy", "uz"))
    found = model.modes(4)
    for shape in found.shapes:
        across = shape[:, np.abs(shape).max(axis=0).argmax()].real
        peaks = np.flatnonzero(np.abs(across) > 1.0 - 1e-6)
        assert across[peaks[0]] == pytest.approx(1.0)
    assert sum(np.sum(np.abs(shape) > 1.0 - 1e-6) > 1 for shape in found.shapes) == 2
