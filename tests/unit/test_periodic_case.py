"""Periodic motions from case files and by command."""

import pytest
from typer.testing import CliRunner

import viscorod as vr
from viscorod.casefile.case import parse_case
from viscorod.casefile.shipped import shipped_case
from viscorod.cli.app import app


@pytest.fixture(scope="module")
def short():
    text = shipped_case("clamped_strip").read_text(encoding="utf-8")
    return text + "points = 6\nharmonics = 3\n"


def test_command_writes_curve_table_and_pictures(short, tmp_path):
    case = tmp_path / "strip.toml"
    case.write_text(short)
    shown = CliRunner().invoke(app, ["periodic", str(case), "-o", str(tmp_path / "out")])
    assert shown.exit_code == 0, shown.output
    assert "6 on a curve from 90 Hz to" in shown.output
    assert "does not reach its end with 6 points" in " ".join(shown.output.split())
    for name in ("amplitude.png", "multipliers.png", "loops.png", "periodic.csv"):
        assert (tmp_path / "out" / name).exists()
    found = vr.load(tmp_path / "out" / "periodic.nc")
    assert found.outcome == "points"
    assert found.title == "Clamped strip that hardens"
    viewed = CliRunner().invoke(app, ["view", str(tmp_path / "out" / "periodic.nc")])
    assert viewed.exit_code == 0, viewed.output
    assert CliRunner().invoke(app, ["response", str(case)]).exit_code == 2


def test_case_comes_back(short):
    assert parse_case(short).settings == parse_case(short).settings
