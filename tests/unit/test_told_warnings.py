"""What is doubtful of a model stands in the result of every analysis, once, and in its report.

Right is what was said when the model was made: a list of analyses is gone through that the package itself keeps.
"""

import warnings
from pathlib import Path

import pytest
from typer.testing import CliRunner

import viscorod as vr
from helpers import strip
from helpers.plain_text import flat
from viscorod.analyses.case_run import as_model, run_case
from viscorod.casefile.analysis_tables import ANALYSES
from viscorod.casefile.case import case_from_dict
from viscorod.casefile.toml_text import toml_text
from viscorod.cli.app import app

TABLE = {
    "kind": "table",
    "times": [0.0, 0.1, 0.2, 0.3, 5.0],
    "values": [0.0, 0.0, 1.0, 1.0, 1.0],
    "interpolation": "cubic",
}
HARMONIC = {"inputs": ["beam.end fz"], "outputs": ["beam.end uz"]}
SETTINGS = {
    "simulate": {"duration": 1e-3},
    "equilibrium": {},
    "path": {"load_factor": 1.0},
    "steady": {"spin": [1.0, 0.0, 0.0]},
    "modes": {"count": 1},
    "response": HARMONIC | {"frequencies": [0.1, 0.2]},
    "buckling": {"count": 1},
    "campbell": {"axis": [1.0, 0.0, 0.0], "band": [0.0, 1.0], "count": 2, "modes": 1},
    "stability": {"band": [0.0, 1.0], "count": 2, "modes": 1},
    "periodic": HARMONIC | {"amplitudes": [1e-4], "frequencies": [0.1, 0.2]},
}


DRIVEN = ("steady", "campbell")
"""Analyses that take no loads over time."""


def content(analysis):
    """A strip with the same load twice; and with one over a table that no spline goes through."""
    case = strip.content(analysis, **SETTINGS[analysis])
    pressed = {"kind": "distributed_force", "rod": "beam", "value": [-1e-3, 0.0, 0.0]}
    case["loads"] = [pressed, pressed]
    if analysis not in DRIVEN:
        case["loads"].append(pressed | {"time": TABLE})
    return case


def test_every_analysis_is_gone_through():
    assert set(SETTINGS) == set(ANALYSES)


@pytest.mark.parametrize("analysis", SETTINGS)
def test_doubts_stand_in_every_result_once(analysis, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error", vr.AccuracyWarning)  # nothing is told beside the result
        result = run_case(case_from_dict(content(analysis)))
    doubts = ["loads[0], loads[1] are the same distributed_force: "]
    doubts += [] if analysis in DRIVEN else ["loads[2].time: a cubic spline through the table would reach "]
    for one in (result, vr.load(result.save(tmp_path / "kept.nc"))):
        for doubt in doubts:
            assert sum(text.startswith(doubt) for text in one.warnings) == 1
            assert flat(one.report()).count(doubt) == 1
        assert f"{len(one.warnings)} warning" in repr(one)


def test_doubts_stand_in_linear_systems_and_fits():
    case = case_from_dict(content("equilibrium"))
    doubts = ("loads[0], loads[1] are the same ", "loads[2].time: a cubic spline ")
    system = as_model(case.description).linear(**HARMONIC)
    load = vr.StaticRecord([0.5, 1.0], [-3e-7, -6e-7], place="beam.end", direction="x")
    fit = vr.identify(case, load, {"materials.rubber.youngs_modulus": 1e6}, profile=False)
    for one in (system, fit):
        assert [text.startswith(doubt) for text, doubt in zip(one.warnings, doubts, strict=True)] == [
            True,
            True,
        ]
        assert "2 warnings" in repr(one)
    assert doubts[1] in flat(fit.report())


@pytest.mark.parametrize("analysis", ["equilibrium", "response"])
def test_the_command_line_tells_a_doubt_before_and_in_the_report_once(analysis, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("strip.toml").write_text(toml_text(content(analysis)))
    done = CliRunner().invoke(app, ["run", "strip.toml"])
    assert done.exit_code == 0, done.output
    told = "loads[2].time: a cubic spline through the table"
    assert flat(done.stdout).count(told) == 1
    assert flat(done.stderr).count(told) == 1
    assert flat(done.output).count("a cubic spline") == 2


def test_members_of_a_sweep_tell_a_doubt_once_for_all():
    case = case_from_dict(content("equilibrium"))
    found = vr.sweep(case, {"materials.rubber.youngs_modulus": [1e6, 2e6]}, workers=1)
    assert flat(found.report()).count("2 members (0, 1): warning: loads[2].time: a cubic spline") == 1


def test_a_report_without_warnings_points_at_conditions_that_do_not_hold():
    """A retardation time of a second in a strip that swings at some hertz: no Kelvin-Voigt material (LLT 2.6)."""
    case = strip.content("simulate", duration=1.0)
    case["materials"]["rubber"]["damping"] = {"shear_time": 1.0, "bulk_time": 1.0}
    case["rods"]["beam"] |= {"elements": 4, "order": 5}
    run = run_case(case_from_dict(case))
    assert not run.validity().valid
    assert run.warnings == []
    assert run.report().endswith("No warnings beside what the rod model does not keep (NO above)")
