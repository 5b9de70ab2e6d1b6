"""The scripts of ``bench`` run: each with its own functions, the smallest model and one repetition.

What is measured is not judged here, but that every script still finds what it names in the package, and prints a table
of numbers. Parts that need other programs are left out.
"""

from __future__ import annotations

import importlib.util
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

import viscorod as vr

BENCH = Path(__file__).parents[2] / "bench"
SCRIPTS = sorted(path.stem for path in BENCH.glob("*.py"))

SMALL = {
    "assemblies": ([], {"ROUNDS": 1, "STEPS": 2}),
    "formulations": (None, {"ROUNDS": 1, "REPEATS": 1, "MESHES": ((1, 2),), "RUNS": ((1, 3, 1e-2),)}),
    "linear_solvers": ([], {"SECONDS": 0.0}),
    "many_members": (["--members", "2", "--kept", "3"], {"FIRST": 2}),
    "mesh_accuracy": ([], {"DURATION": 0.04, "MESHES": ((1, 2),)}),
    "model_sizes": ([], {"STEPS": 2, "SIZES": ((1, 100), (2, 4))}),
    "newton_iteration": (["--elements", "40"], {}),
    "periodic_motions": ([], {"BAND": (85.0, 86.0), "COMPARED": 1}),
    "published_times": (["--rounds", "1", "--only", "static"], {}),
    "sobol_intervals": (["--ensembles", "2", "--points", "64", "--dimensions", "1"], {}),
    "stability": (["--rounds", "1"], {"ELEMENTS": (1,)}),
    "statics": (["--rounds", "1"], {}),
    "sweep": (["--members", "2", "--workers", "1", "--tolerance", "1e-2"], {}),
    "whole_results": (["--members", "2", "--duration", "0.1"], {}),
    "tolerance": (["string", "--tolerances", "1e-2"], {"REFERENCE": 1e-3, "OUTPUTS": 10}),
}
"""Arguments of the scripts, and their constants, that make them small."""


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch):
    """Return a function that loads a script as a module."""

    def load(name: str):
        monkeypatch.syspath_prepend(str(BENCH))
        spec = importlib.util.spec_from_file_location(f"bench_{name}", BENCH / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        monkeypatch.setitem(sys.modules, spec.name, module)
        spec.loader.exec_module(module)
        return module

    return load


def test_every_script_is_tried() -> None:
    others = {
        "decays",
        "derivatives",
        "identification",
        "large_models",
        "measured",
        "startup",
        "work_precision",
    }
    assert set(SCRIPTS) == set(SMALL) | others


@pytest.mark.filterwarnings("ignore:the numerical remainder")  # steps are long
@pytest.mark.parametrize("name", SMALL)
def test_a_script_prints_its_table(name, script, monkeypatch, capsys) -> None:
    arguments, constants = SMALL[name]
    module = script(name)
    for constant, value in constants.items():
        assert hasattr(module, constant)
        monkeypatch.setattr(module, constant, value)
    if hasattr(module, "MODELS"):
        small = module.lattice(2) if name == "assemblies" else module.chain(2, 2)
        monkeypatch.setattr(module, "MODELS", {"small": lambda: small})
    if arguments is None:
        make, length, _, settings = module.MOTIONS["cantilever"]
        monkeypatch.setattr(module, "MOTIONS", {"cantilever": (make, length, 0.02, settings)})
        module.newton_table()
        module.run_table()
    else:
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        module.main()
    printed = capsys.readouterr().out
    assert any(character.isdigit() for character in printed)
    assert "nan" not in printed


def test_derivatives_of_a_random_model_are_those_of_differences(script, capsys) -> None:
    module = script("derivatives")
    module.accuracy(0, 1)
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0] for line in lines[-5:-1]] == list(module.FLOOR)
    assert all(": 1 of 1 within" in line for line in lines[-5:-1])


def test_all_kinds_of_decays_are_tried_without_a_word(script, capsys, monkeypatch) -> None:
    decays = script("decays")
    monkeypatch.setattr(decays, "LENGTHS", {"short": (160, 0.025)})
    monkeypatch.setattr(decays, "COLOURS", (0.0,))
    monkeypatch.setattr(sys, "argv", ["decays", "--sets", "1"])
    decays.main()
    assert [line.split(" mode")[0] for line in capsys.readouterr().out.splitlines() if "AR(" in line] == [
        "short, 1",
        "short, 2",
    ]


def test_intervals_of_a_few_decays_are_as_wide_as_the_bound(script, capsys) -> None:
    """Cramer and Rao's bound is what least squares reaches in white noise."""
    script("decays").run("short", 1, 0.0, 3)
    printed = capsys.readouterr().out
    widths = printed.split("width over bound")[1].split(",")
    assert [float(width) for width in widths] == pytest.approx([1.0, 1.0], abs=0.3)


def test_intervals_of_a_few_data_sets_are_as_wide_as_the_bound(script, capsys) -> None:
    """Cramer and Rao's bound is what the estimator reaches where predictions are linear."""
    script("identification").run("blade", 3, 0, False)
    printed = capsys.readouterr().out
    assert "blade: 3 sets" in printed
    widths = [float(line.split("width over bound")[1].split()[0]) for line in printed.splitlines()[1:]]
    assert widths == pytest.approx([1.0, 1.0], abs=0.5)


def test_models_and_analyses_of_many_elements_work_with_few(script, tmp_path) -> None:
    module = script("large_models")
    for make, _ in module.FAMILIES.values():
        assert make(3).equilibrium(load_steps=1).load_factor[-1] == 1.0
    for name in set(module.ANALYSES) - {"draw", "plot", "view"}:
        module.ANALYSES[name](module.beam(2), tmp_path)()
    assert (tmp_path / "run.nc").exists()
    assert (tmp_path / "run.csv").exists()


def test_models_of_measurements_are_cases(script) -> None:
    module = script("measured")
    assert module.bar().kind == "simulate"
    fixed, hanging = (module.bar(0.05, on_a_joint).description for on_a_joint in (False, True))
    assert set(fixed.bodies) == set(hanging.bodies) == {"weight", "edge"}
    assert [len(one.joints) for one in (fixed, hanging)] == [0, 1]


def test_runs_whose_start_is_timed_are_there(script) -> None:
    module = script("startup")
    assert module.seconds([sys.executable, "-c", "pass"]) >= 0.0
    runs = module.runs()
    assert len(runs) == 4
    assert len(next(run for name, run in runs.items() if "member" in name)().table()) == module.MEMBERS


def test_times_of_equal_error_are_read_between_two_runs(script) -> None:
    """On a straight line in logarithms: ten times the error in a quarter of the time."""
    module = script("work_precision")
    points = [module.Point("a", "fine", 4.0, 1e-4), module.Point("a", "coarse", 1.0, 1e-3)]
    assert module.seconds_at(points, 1e-4) == 4.0
    assert module.seconds_at(points, 10**-3.5) == pytest.approx(2.0)
    assert module.faster(points, [module.Point("a", "fine", 3.0, 1e-4), points[1]])[0].seconds == 3.0
    assert set(module.LADDERS) == set(module.CASES)
    assert {entry.case for entry in module.SUITE} <= set(module.CASES)
    for entry in module.SUITE:
        assert (BENCH / "peers" / f"{entry.module}.py").exists()
    case = module.CASES["string"]
    run = case.model(2, 6).simulate(0.002, tolerance=1e-4, initial=case.initial)
    fallen = 0.5 * 9.81 * 0.002**2  # what the clamp does has not come to the tip yet
    assert run.history(case.tip).values[-1, 1] == pytest.approx(-fallen, rel=1e-3)


def test_a_link_on_a_hinge_under_a_force_balances(script) -> None:
    """``k a = F L cos a`` of a rigid link along x under a force across it."""
    script("work_precision")
    from peers.chain import held_angles

    angles, links = held_angles(np.array([2.0]), np.array([3.0]), (0.0, 1.5, 0.0))
    assert 3.0 * angles[0] == pytest.approx(1.5 * 2.0 * np.cos(angles[0]), abs=1e-9)
    assert np.linalg.norm(links[0]) == pytest.approx(2.0)


def test_a_loss_is_printed_as_what_the_package_gives(script) -> None:
    """Half the sum of squares of the tip's positions, and its derivatives."""
    module = script("derivatives")
    run = module.swing(1).simulate(duration=0.02, output_interval=0.01)
    tip = run.history("beam.end").values
    value, weights = module.misfit(run)
    assert value == pytest.approx(0.5 * (tip**2).sum())
    assert weights["position"][:, -1] == pytest.approx(tip)
    assert isinstance(run, vr.Run)


def test_the_picture_of_the_house_has_words_for_every_wing() -> None:
    """The script draws what the import contract names, and would end at a wing that it does not know."""
    house = runpy.run_path(str(BENCH.parent / "docs" / "figures" / "architecture.py"))
    assert {wing for rung in house["contract"]() for wing in rung} == set(house["WORDS"])
