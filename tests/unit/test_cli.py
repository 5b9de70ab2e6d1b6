"""The command line: exit codes, messages, files. Solutions are stood in for by results in closed form."""

import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import viscorod as vr
import viscorod.analyses.case_run
import viscorod.analyses.check
import viscorod.analyses.discrete
import viscorod.casefile.case
from helpers.synthetic_results import rolled_up, swing
from viscorod.analyses.progress import reporting
from viscorod.casefile.shipped import shipped_case
from viscorod.cli.app import app
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.reports.check_report import CheckReport
from viscorod.results.result_numbers import numbers_of, plain
from viscorod.results.run import Run
from viscorod.results.validity import Condition, Validity
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.units import Conversion

REPORT = CheckReport(
    validity=Validity((Condition("|J0 - 1|: half width x curvature", "LLT 2.2", 0.2, 0.1, "beam"),)),
    rods=[{"rod": "beam", "length [m]": 0.3, "mass [kg]": 0.03, "elements": 2, "order": 5}],
    sections=[
        {"section": "beam", "area [m2]": 1e-4, **{f"stiffness {k}": 10.0**k for k in range(12)}},
    ],
    frequencies=np.array([0.573, 3.59]),
    damping_ratios=np.array([0.036, 0.2256]),
    mode_names=("bend_1 1", "bend_1 2"),
    rigid_motions=("rotation about z",),
    warnings=["the rod is thick"],
    nodes=11,
    unknowns=66,
    materials=[{"material of rod": "beam", "shear time [s]": 0.02}],
    assumptions=["rod beam: the bulk modulus does not relax"],
    bodies=[{"body": "plate", "mass [kg]": 2.0}],
    joints=[{"joint": "elbow", "kind": "revolute", "gap [m]": 0.001}],
    springs=[],
    media=[{"load": "air", "kind": "drag", "linear across [Pa s]": 0.02}],
    rest_strains=[],
    conditions=5,
    linear_solver="band of half width 35",
)


@pytest.fixture
def invoke(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text('title = "A case"\n')
    return lambda *arguments: CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def solving(monkeypatch):
    """Let ``viscorod run`` come to a given result, or fail with a given error."""

    def draw(path, title):
        path.parent.mkdir(parents=True)
        path.write_text(title)
        return path

    def prepare(outcome, settings):
        def run_case(case, discrete, *, progress, folder, **_):
            for reached in np.linspace(0.0, 1.0, 51)[1:]:
                progress(reached * getattr(case.settings, "duration", 1.0), 0.02)
            result = getattr(outcome, "run", outcome)
            if isinstance(result, Run):  # a motion is written as it comes
                result.save(folder / "run.nc")
            if isinstance(outcome, Exception):
                raise outcome
            return outcome

        given = [Conversion("rods.beam.twist", "30 deg", 0.5235987755982989, "rad")]
        case = SimpleNamespace(description=None, settings=settings, title="A case", conversions=given)
        monkeypatch.setattr(viscorod.casefile.case, "load_case", lambda path: case)
        monkeypatch.setattr(viscorod.analyses.check, "check", lambda discrete, settings: REPORT)
        monkeypatch.setattr(viscorod.analyses.case_run, "discretised_case", lambda case: SimpleNamespace())
        monkeypatch.setattr(
            viscorod.analyses.discrete.DiscreteModel, "of", lambda model, validated: SimpleNamespace()
        )
        monkeypatch.setattr(viscorod.analyses.check, "doubts", lambda discrete: ["the rod is thick"])
        monkeypatch.setattr(viscorod.analyses.case_run, "run_case", run_case)
        monkeypatch.setattr(
            viscorod.analyses.case_run, "as_model", lambda description: SimpleNamespace(draw=draw)
        )

    return prepare


def test_version_and_help(invoke):
    assert re.fullmatch(r"viscorod \d+\.\d+\.\d+\S*\n", invoke("--version").output)
    for command in ("run", "check", "example"):
        assert command in invoke("--help").output


def test_run_writes_files_and_prints_the_report(invoke, solving, tmp_path):
    solving(Run(swing()), SimulateSettings(duration=10.0))
    result = invoke("run", "case.toml", "-o", "results")
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in (tmp_path / "results").iterdir()) == [
        "energy.png",
        "motion.png",
        "run.nc",
    ]
    assert "Decay of beam.end along y" in result.stdout
    assert "warning: the rod is thick" in result.stderr
    assert result.stderr.count(" of 10 s, step ") == 1  # a short run has one line in a log
    assert isinstance(vr.load(tmp_path / "results" / "run.nc"), Run)


def test_quiet_and_json_and_the_report_again(invoke, solving, tmp_path):
    """Numbers as JSON are those of the result; a result that is there is named before it is replaced."""
    run = Run(swing(zeta=0.05))
    solving(run, SimulateSettings(duration=10.0))
    silent = invoke("run", "case.toml", "-o", "results", "-q")
    assert (silent.exit_code, silent.output) == (0, "")
    told = invoke("run", "case.toml", "-o", "results", "--json")
    assert told.exit_code == 0, told.output
    found = json.loads(told.stdout)
    assert told.stderr == ""
    assert found["kind"] == "simulate"
    assert found["decay"]["damping_ratio"] == pytest.approx(run.decrement("beam.end", "y").damping_ratio)
    assert found["energy"]["end"]["kinetic"] == float(run.energy.kinetic[-1])
    assert found["places"]["beam.end"]["position"] == pytest.approx(
        run.history("beam.end").values[-1].tolist()
    )
    assert [path.rpartition("/")[2] for path in found["written"]] == ["run.nc", "motion.png", "energy.png"]
    loud = invoke("run", "case.toml", "-o", "results")
    assert re.search(r"note: results/run\.nc of \d{4}-\d\d-\d\d \d\d:\d\d is replaced", loud.stderr)
    again = invoke("report", "results/run.nc")
    assert again.stdout == vr.load(tmp_path / "results" / "run.nc").report() + "\n"
    assert json.loads(invoke("report", "results/run.nc", "--json").stdout)["decay"] == found["decay"]
    assert max(map(len, loud.stdout.splitlines())) <= 80


def test_numbers_of_every_kind_are_plain():
    """No NaN and nothing but what JSON knows."""
    for result in (Run(swing(duration=1.0)), Equilibrium(rolled_up())):
        text = json.dumps(numbers_of(result), allow_nan=False)
        assert json.loads(text)["outcome"] == "completed"
    assert plain({"a": np.array([1.0, np.nan]), "b": 1j, "c": np.int64(3)}) == {
        "a": [1.0, None],
        "b": [0.0, 1.0],
        "c": 3,
    }


def test_help_is_short_too_and_lists_whole_sentences(invoke):
    assert invoke("-h").output == invoke("--help").output
    text = " ".join(invoke("-h").output.split())
    assert (
        "Continue a stopped run from its last checkpoint; the result is that of an uninterrupted run." in text
    )
    assert "..." not in text.partition("Commands:")[2]
    assert invoke("run", "-h").exit_code == 0
    assert "--install-completion" in text


def test_help_names_what_options_take_in_words():
    """Of every option with a value; Typer names types of Python, "<int range>"."""

    def options(command, name):
        for parameter in command.params:
            if parameter.param_type_name == "option" and not parameter.is_flag:
                yield name, parameter.opts[0], parameter.metavar
        for word, inner in getattr(command, "commands", {}).items():
            yield from options(inner, f"{name} {word}")

    found = list(options(typer.main.get_command(app), "viscorod"))
    assert len(found) > 100
    assert [one for one in found if one[2] is None and "completion" not in one[1]] == []


def test_run_of_an_equilibrium_and_default_folder(invoke, solving, tmp_path):
    solving(Equilibrium(rolled_up()), EquilibriumSettings())
    result = invoke("run", "case.toml")
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in (tmp_path / "out" / "case").iterdir()) == ["run.nc", "shape.png"]
    assert "load = 1 of 1" in result.stderr
    assert "Stable" in result.stdout


def test_failed_solution_keeps_what_there_is(invoke, solving, tmp_path):
    error = vr.SolveError("no solution at t = 0.8 s; try a smaller time_step")
    error.run = Run(swing().isel(time=slice(0, 40)).assign_attrs(outcome="diverged"))
    solving(error, SimulateSettings(duration=10.0))
    result = invoke("run", "case.toml", "-o", "results")
    assert result.exit_code == 1
    assert "error: no solution at t = 0.8 s; try a smaller time_step" in result.stderr
    assert "Traceback" not in result.output
    partial = vr.load(tmp_path / "results" / "run.nc")
    assert partial.time.size == 40
    assert partial.outcome == "diverged"


def test_failed_solution_without_anything_to_keep(invoke, solving, tmp_path):
    error = vr.SolveError("no equilibrium")
    error.run = None
    solving(error, SimulateSettings(duration=10.0))
    assert invoke("run", "case.toml", "-o", "results").exit_code == 1
    assert not (tmp_path / "results").exists()


def test_files_of_the_other_kind_are_told_in_one_message(invoke, tmp_path):
    """A fit file is no case file, a case file no fit file; a page has the suffix of pages; a sweep needs values."""
    (tmp_path / "case.toml").write_text(shipped_case("cantilever_swing").read_text(encoding="utf-8"))
    (tmp_path / "fit.toml").write_text('case = "case.toml"\n[[records]]\nkind = "modes"\n')
    for arguments, told in (
        (("run", "fit.toml"), "is no case file; compute it with: viscorod identify fit.toml"),
        (
            ("identify", "case.toml"),
            "case.toml is a case file; what is identified stands in a file of its own",
        ),
        (
            ("sweep", "case.toml"),
            "nothing varies; give --set KEY=VALUES, --grid KEY=VALUES or --table FILE.csv",
        ),
    ):
        result = invoke(*arguments)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert told in result.stderr


@pytest.mark.parametrize("command", ["run", "check"])
def test_wrong_input_is_one_message(invoke, command, tmp_path):
    missing = invoke(command, "none.toml")
    assert (missing.exit_code, missing.stderr.count("\n")) == (2, 1)
    assert missing.stderr.startswith("error: none.toml is not a file; name a case file")
    (tmp_path / "run.nc").write_bytes(b"")
    assert (
        "run.nc is a result, no case file; read it with: viscorod report" in invoke(command, "run.nc").stderr
    )
    assert invoke(command, "csae.toml").stderr == "error: csae.toml is not a file; did you mean case.toml?\n"
    assert invoke(command, "four_bar").stderr.endswith("copy one with: viscorod example four_bar\n")
    asked = invoke("report", "case.toml")
    assert (asked.exit_code, asked.stderr) == (
        2,
        "error: case.toml is no result; compute it first, with: viscorod run case.toml\n",
    )
    (tmp_path / "broken.toml").write_text("rods = [\n")
    broken = invoke(command, "broken.toml")
    assert broken.exit_code == 2
    assert broken.stderr.startswith("error: ")
    assert "Traceback" not in broken.output


def test_check_prints_tables(invoke, solving, monkeypatch):
    solving(None, None)
    monkeypatch.setenv("COLUMNS", "100")
    result = invoke("check", "case.toml")
    assert result.exit_code == 0, result.output
    lines = [" ".join(line.split()) for line in result.stdout.splitlines()]
    assert "rod length [m] mass [kg] elements order" in lines
    assert "beam 0.3 0.03 2 5" in lines
    assert "stiffness 3 1000" in lines  # too wide for the terminal, so turned on its side
    assert "1 bend_1 1 0.573 0.036" in lines
    assert lines[lines.index("Rigid motions: 1") + 1] == "- rotation about z"
    assert "11 nodes, 66 unknowns, 5 conditions of joints and held strains" in lines
    assert "Linear systems: band of half width 35" in lines
    assert "body mass [kg]" in lines
    assert "plate 2" in lines
    assert "elbow revolute 1" in lines  # gap [mm]
    assert "Springs" not in lines
    assert lines[lines.index("key as given in SI") + 1] == "rods.beam.twist 30 deg 0.5235987755982989 rad"
    assert lines[-1] == "Written: out/case/assembly.png"
    assert "- the rod is thick" in lines
    assert "material of rod shear time [s]" in lines
    assert (
        lines[lines.index("Assumptions about damping") + 1] == "- rod beam: the bulk modulus does not relax"
    )
    assert "|J0 - 1|: half width x curvature 0.2 0.1 NO LLT 2.2 beam" in lines
    assert max(map(len, result.stdout.splitlines())) <= 100


def test_check_draws_the_model_where_it_is_told(invoke, tmp_path):
    invoke("example", "cantilever_swing")
    result = invoke("check", "cantilever_swing.toml", "-o", "pictures")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "pictures" / "assembly.png").stat().st_size > 10_000
    assert "Written: pictures/assembly.png" in result.stdout
    told = json.loads(invoke("check", "cantilever_swing.toml", "-o", "pictures", "--json").stdout)
    assert told["rods"][0]["d1 at its start"] == pytest.approx([0.0, 1.0, 0.0])  # numbers, not their text
    assert told["rods"][0]["length [m]"] == pytest.approx(0.3)
    assert len(told["frequencies"]) == len(told["damping_ratios"]) == len(told["mode_names"])
    (tmp_path / "taken").write_text("")
    refused = invoke("check", "cantilever_swing.toml", "-o", "taken")
    assert refused.exit_code == 2
    assert "taken cannot be written" in refused.stderr
    refused = invoke("check", "cantilever_swing.toml", "-o", "drawing.png")
    assert refused.exit_code == 2
    assert "drawing.png: this is the name of a file" in refused.stderr
    assert not (tmp_path / "drawing.png").exists()


def test_example_lists_and_copies(invoke, tmp_path):
    listed = invoke("example").stdout
    assert "cantilever_swing" in listed
    assert "needs 'viscorod[sections]'" in next(
        line for line in listed.splitlines() if "damped_strip" in line
    )
    assert listed.count("needs") == 1
    copied = invoke("example", "cantilever_swing", "-o", "mine")
    assert copied.exit_code == 0
    target = tmp_path / "mine" / "cantilever_swing.toml"
    assert target.read_bytes() == shipped_case("cantilever_swing").read_bytes()
    again = invoke("example", "cantilever_swing", "-o", "mine")
    assert again.exit_code == 2
    assert "exists already" in again.stderr
    unknown = invoke("example", "cantilever_swim")
    assert unknown.exit_code == 2
    assert "cantilever_swing" in unknown.stderr


def test_progress_on_a_terminal_is_a_bar(monkeypatch, capsys):
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    monkeypatch.setenv("FORCE_COLOR", "1")
    with reporting(Course("t", " s", 0.0, 2.0)) as progress:
        for step in range(1, 21):
            progress(0.1 * step, 0.1)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "of 2 s" in shown.err
    assert "left" in shown.err


def test_a_former_key_of_a_case_file_is_named(tmp_path):
    case = tmp_path / "spin.toml"
    text = shipped_case("swept_blade").read_text(encoding="utf-8")
    case.write_text(text.replace("[steady]", "[steady]\nabout = [0.0, 0.0, 0.0]"), encoding="utf-8")
    command = [sys.executable, "-m", "viscorod", "check", str(case), "-o", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "warning: about is now centre" in done.stderr.splitlines()


def documented(row):
    """Keys that the reference names in a row of its table of what ``--json`` prints."""
    text = (Path(__file__).parents[2] / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith(row))
    return set(re.findall(r"`(\w+)`", re.sub(r"\(.*?\)", "", line.split("|")[2])))


@pytest.mark.parametrize(
    ("row", "result"),
    [
        ("| all but", lambda: Run(swing())),
        ("| `run`", lambda: Run(swing())),
        ("| of equilibria", lambda: Equilibrium(rolled_up())),
    ],
    ids=["all", "run", "equilibria"],
)
def test_keys_of_json_are_those_of_the_reference(row, result):
    assert documented(row) - set(numbers_of(result())) == set()


def test_tables_of_a_check_are_those_of_the_reference():
    assert documented("| `check`") <= {field.name for field in dataclasses.fields(CheckReport)}
