"""The command ``viscorod damping``: tables, texts to paste, files, and what wrong input is told."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from helpers.blade_files import PRIMARY, assembly, blade_text
from viscorod import programs as vd
from viscorod.casefile.case import load_case
from viscorod.casefile.shipped import shipped_case
from viscorod.cli.app import app

MATERIAL = ("--youngs-modulus", "1e6", "--poissons-ratio", "0.3")


@pytest.fixture
def invoke(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    (tmp_path / "swing.toml").write_bytes(shipped_case("cantilever_swing").read_bytes())
    (tmp_path / "turns_back.toml").write_bytes(shipped_case("helix_spring").read_bytes())
    (tmp_path / "four_bar.toml").write_bytes(shipped_case("four_bar").read_bytes())
    (tmp_path / "blade.dat").write_text(blade_text())
    (tmp_path / "primary.dat").write_text(PRIMARY)
    return lambda *arguments: CliRunner().invoke(app, ["damping", *map(str, arguments)])


def values(text, label):
    """The numbers behind a label of a table."""
    (line,) = (line for line in text.splitlines() if line.strip().startswith(label))
    return [float(word) for word in line.strip().removeprefix(label).split()]


def test_a_material_in_all_numbers(invoke):
    result = invoke("convert", *MATERIAL, "--shear-time", 0.02, "--bulk-time", 0.03, "--frequency", 0.57)
    assert result.exit_code == 0, result.output
    assert values(result.output, "time [s]") == [0.02, 0.0213333, 0.03]
    assert values(result.output, "viscosity [Pa s]") == [7692.31, 21333.3, 25000.0]
    ratios = values(result.output, "damping ratio")
    assert ratios == pytest.approx([np.pi * 0.57 * t for t in (0.02, 0.0213333, 0.03)], rel=1e-5)
    assert values(result.output, "Q") == pytest.approx([1 / (2 * r) for r in ratios], rel=1e-5)


@pytest.mark.parametrize(
    "given",
    [
        ("--shear-viscosity", 7692.307692307692, "--bulk-viscosity", 25000.0),
        ("--shear-time", 0.02, "--extensional-time", 0.064 / 3.0),
    ],
)
def test_other_words_for_the_same_material(invoke, given):
    result = invoke("convert", *MATERIAL, *given)
    assert result.exit_code == 0, result.output
    assert values(result.output, "time [s]") == pytest.approx([0.02, 0.0213333, 0.03], rel=1e-5)


@pytest.mark.parametrize(
    "given",
    [
        ("--time", 0.02),
        ("--loss-factor", 2 * np.pi * 0.57 * 0.02),
        ("--damping-ratio", np.pi * 0.57 * 0.02),
        ("--log-decrement", vd.log_decrement(np.pi * 0.57 * 0.02)),
        ("--quality-factor", 1 / (2 * np.pi * 0.57 * 0.02)),
    ],
)
def test_one_law_in_all_numbers(invoke, given):
    result = invoke("convert", *given, "--frequency", 0.57, "--band", "0.1,10")
    assert result.exit_code == 0, result.output
    assert values(result.output, "time [s]") == [0.02]
    assert values(result.output, "this law") == [0.0, 0.02, 0.0]
    found = vd.rayleigh_for_constant_ratio(np.pi * 0.57 * 0.02, 0.1, 10.0)
    assert values(result.output, "the ratio 0.0358142 everywhere")[:2] == pytest.approx(
        [found.alpha, found.beta], rel=1e-5
    )


def test_rayleigh_constants_become_a_law(invoke):
    result = invoke("convert", "--rayleigh", "0.4,0.002", "--band", "0.5,5")
    time, error = vd.time_from_rayleigh(0.4, 0.002, 0.5, 5.0)
    assert values(result.output, "time [s]") == pytest.approx([time], rel=1e-5)
    assert f"differs by up to {error:.3g}" in result.output


def test_an_overdamped_mode_is_called_so(invoke):
    assert re.search(
        r"log decrement +overdamped", invoke("convert", "--time", 1.0, "--frequency", 1.0).output
    )
    assert re.search(r"critical from \[Hz\] +never", invoke("convert", "--time", 0.0).output)


def test_all_programs(invoke):
    result = invoke("programs", "swing.toml", "--segment-length", 0.025, "--frequency", 0.57)
    assert result.exit_code == 0, result.output
    for kind in vd.PROGRAMS.values():
        assert f"\n{kind.title} ({kind.program}): {kind.meaning}\n" in result.output
        for source in kind.sources:
            assert f"Read in: {source}" in result.output
    assert "Lost: the six mu hold for the whole blade" in result.output
    two = invoke(
        "programs", "swing.toml", "--program", "mujoco", "--program", "mbdyn", "--segment-length", 0.025
    )
    assert two.exit_code == 0, two.output  # an option goes to the programs that take it
    without = invoke("programs", "swing.toml")
    assert without.exit_code == 0
    assert "MuJoCo cable: needs --segment-length; give it to see its inputs" in without.output
    assert "PyElastica: needs --frequency; give it to see its inputs" in without.output


def test_one_program(invoke):
    result = invoke("programs", "swing.toml", "--program", "mbdyn", "--at", 0.1)
    assert "section at 0.1 m" in result.output
    assert "    linear viscoelastic generic," in result.output
    assert "BeamDyn" not in result.output


def test_from_a_program(invoke):
    result = invoke("from", "chrono-tapered", "--numbers", "0.2,0.2,0.2,0.2", "--case", "swing.toml")
    assert result.exit_code == 0, result.output
    assert re.search(r"twist +0\.04 ", result.output)
    assert "shear_time = 0.04, bulk_time = 0.04 }" in result.output
    other = invoke("from", "beamdyn", "--numbers", ",".join(["0.02"] * 6), "--case", "swing.toml",
                   "--poissons-ratio", 0.5)  # fmt: skip
    assert "shear_time = 0.02, bulk_time = 0.02 }" in other.output


def test_blade_is_read_and_written(invoke, tmp_path):
    result = invoke("blade", "blade.dat", "--centreline", "primary.dat", "-o", "again.dat", "--stations", 5)
    assert result.exit_code == 0, result.output
    assert "mu [s]: 0.001, 0.0012, 0.0014, 0.0018, 0.0022, 0.0026" in result.output
    assert (
        "The rod's D is T C T with the same six times; it differs from BeamDyn's mu S by up to"
        in result.output
    )
    assert (
        "Note: the product of these times with a stiffness can create energy, but not with this one"
        in " ".join(result.output.split())
    )
    assert "Written: again.dat" in result.output
    blade = vd.read_beamdyn_blade(tmp_path / "again.dat")
    assert blade.stations == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
    table = [[float(word) for word in line.split()] for line in result.output.splitlines()[-5:]]
    assert table[0] == pytest.approx([0.0, 0.0, 0.0, 13.0], abs=1e-6)
    assert table[-1] == pytest.approx([0.5, 0.3, 7.0, 0.0], abs=1e-6)
    case = invoke("blade", "blade.dat", "--centreline", "primary.dat", "-o", "case.toml", "--elements", 3)
    assert "Written: case.toml, with 3 sections" in case.output
    assert load_case(tmp_path / "case.toml").description.rods["blade"].length == pytest.approx(7.1, abs=0.1)
    power = invoke("blade", "blade.dat", "--length", 10, "--same-power")
    assert "The rod's D is the symmetric part of mu S" in power.output


def test_beams_of_the_other_program_and_of_cases(invoke, tmp_path):
    import json

    (tmp_path / "beam.json").write_text(json.dumps(assembly()))
    lines = (f"{key} = {json.dumps(value)}" for key, value in assembly().items())
    (tmp_path / "beam.toml").write_text("\n".join(lines))
    for name in ("beam.json", "beam.toml"):
        result = invoke("blade", name, "-o", "out.json", "--elements", 2)
        assert result.exit_code == 0, result.output
        assert "Written: out.json" in result.output
    again = vd.rod_from_gxbeam(tmp_path / "out.json")
    assert again.length == pytest.approx(2.0)
    case = invoke("blade", "swing.toml")
    assert "mu [s]: 0.02, 0.02, 0.02, 0.02, 0.02, 0.02" in case.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("convert",),
            "damping convert: given: nothing: one law or one material is needed; give exactly one of --time",
        ),
        (("convert", "--time", 1, "--quality-factor", 3), "given: --time, --quality-factor"),
        (("convert", "--time", 1, "--shear-time", 3), "given: --time, shear_time"),
        (
            ("convert", "--loss-factor", 0.1),
            "--frequency: it is needed here; give --frequency (of the mode, Hz)",
        ),
        (("convert", "--time", -1), "time: -1: outside what is allowed; give a number >= 0"),
        (("convert", "--rayleigh", "1,2"), "--band: it is needed here; give --band (LOW,HIGH, Hz)"),
        (("convert", "--rayleigh", "1", "--band", "1,2"), "--rayleigh: 1: two numbers are needed here"),
        (
            ("convert", "--time", 1, "--band", "1,x"),
            "--band: 1,x: numbers are needed here; separate them by commas",
        ),
        (("convert", "--time", 1, "--band", "1,2"), "--frequency: it is needed here"),
        (("convert", "--shear-time", 1), "--youngs-modulus: a material needs it"),
        (("convert", *MATERIAL, "--shear-time", 1), "the viscosity needs one complete pair"),
        (
            ("convert", *MATERIAL, "--extensional-time", 1),
            "--extensional-time: it is given instead of the bulk time",
        ),
        (
            ("convert", *MATERIAL, "--shear-time", 1, "--extensional-time", 0.1),
            "the bulk viscosity would be negative",
        ),
        (("programs", "no.toml"), "no.toml is not a file"),
        (
            ("programs", "swing.toml", "--rod", "bean"),
            "--rod: bean: the case has no such rod; did you mean beam?",
        ),
        (("programs", "four_bar.toml"), "--rod: the case has"),
        (
            ("programs", "swing.toml", "--at", 1),
            "--at: 1: outside the rod; give an arc length from 0 to 0.3 m",
        ),
        (("programs", "swing.toml", "--program", "mujoco"), "segment_length: this program needs it"),
        (
            ("programs", "swing.toml", "--program", "mbdyn", "--segment-length", 0.1),
            "--segment-length: 0.1: not used by MBDyn; leave it out",
        ),
        (
            ("from", "beamdyn", "--numbers", "1,1,1,1,1,1", "--case", "swing.toml", "--frequency", 2),
            "frequency: 2: BeamDyn has no use for it; leave it out",
        ),
        (("programs", "swing.toml", "--program", "abaqus"), "program: abaqus: no such program"),
        (
            ("from", "beamdyn", "--numbers", "1", "--case", "swing.toml"),
            "beamdyn: 1 numbers: BeamDyn has 6 here",
        ),
        (
            ("from", "beamdyn", "--numbers", "a", "--case", "swing.toml"),
            "--numbers: a: numbers are needed here",
        ),
        (
            ("from", "pyelastica", "--numbers", "1", "--case", "swing.toml", "--frequency", "1"),
            "a mass-proportional constant does not damp strains",
        ),
        (("blade", "blade.dat"), "exactly one of --centreline and --length is needed"),
        (("blade", "blade.dat", "--length", 1, "--centreline", "primary.dat"), "exactly one of --centreline"),
        (("blade", "no.dat", "--length", 1), "the file cannot be read"),
        (("blade", "swing.toml", "-o", "swing.toml/x.json"), "cannot be written"),
        (("blade", "turns_back.toml", "-o", "x.dat"), "BeamDyn's blades run along +Z from root to tip"),
    ],
)
def test_wrong_input_is_one_message_and_exit_code_2(invoke, arguments, message):
    result = invoke(*arguments)
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert "Traceback" not in result.output
