"""Reports and the warnings in them."""

import json
import re
from contextlib import nullcontext

import numpy as np
import pytest

import viscorod as vr
from helpers.plain_text import flat
from helpers.synthetic_results import rolled_up, swing
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.reports.report_parts import load_level
from viscorod.results.result_warnings import warnings_of
from viscorod.results.run import Run


def test_run_report_says_what_the_user_asks():
    report = Run(swing(leak=1e-3)).report()
    assert report.startswith(
        "A swing in closed form\n10 s simulated in 500 steps of 0.02 s, generalized-alpha\n"
    )
    lines = [" ".join(line.split()) for line in report.splitlines()]
    assert "beam.end 0.3 0.2 0 0 0.2 0" in lines
    assert "1 0.00000 0.2 1.74751 0.31455 0.05" in lines
    assert "(beam.end along y has the largest range of displacement, 0.37085 m)" in lines
    assert any(
        line.startswith("lost to viscosity 7.5") and " mJ " in line and line.endswith("% of what moved")
        for line in lines
    )
    assert (
        "Effort: 500 steps, 0 rejected steps, 1500 iterations, 1500 factorisations, 0.5 s wall time"
        in " ".join(lines)
    )
    assert lines[-1] == "No warnings"
    assert "nan" not in report.lower()


def test_columns_of_the_energy_account_never_run_together():
    """Not with a negative part of four digits below zero either: -1e-6 of what moved, beside positive ones."""
    account = Run(swing(leak=-1.44123e-6)).energy
    rows = [line for line in str(account).splitlines() if line.endswith("of what moved")]
    assert any("e-0" in line or "-0.00014" in line for line in rows)
    for line in rows:
        assert re.search(r"\d [µm]?J +\S+ % of what moved$", line) or line.startswith("  largest"), line


def test_report_of_steps_that_follow_the_error():
    """Tolerance in the heading, and where the smallest step was and why; rejected steps are no warning there."""
    data = swing()
    del data.attrs["time_step"]
    report = Run(
        data.assign_attrs(
            integrator="radau", tolerance=1e-4, steps=50, rejected=2, evaluations=603, jacobians=1,
            smallest_step=0.003, smallest_step_at=1.25, smallest_step_why="the error of rotation along d3 at rod 'a'",
        )
    ).report()  # fmt: skip
    assert "10 s simulated in 50 steps that follow the error, tolerance 0.0001, radau " in flat(report)
    report = " ".join(report.split())
    assert "50 steps, 2 rejected steps, 1500 iterations, 603 evaluations of the forces, 1 Jacobian," in flat(
        report
    )
    why = "limited by the error of rotation along d3 at rod 'a'"
    assert f"Smallest step: 3 ms at t = 1.25 s, {why}" in flat(report)
    assert report.endswith("No warnings")


def test_report_without_cycles_says_why():
    assert (
        "No regular decay: beam.end along y has the largest range of displacement"
        in Run(swing(duration=1.0)).report()
    )


def test_report_of_a_rod_that_rests_takes_no_rounding_for_a_motion():
    """A clamped strip that hangs in its equilibrium: 84 am had been called its largest range of displacement."""
    model = vr.Model()
    rubber = vr.Material(5e6, 0.49, 1100.0)
    strip = vr.Rod.straight((0, 0, 0), (0.15, 0, 0), section=vr.Rectangle(0.02, 0.003), material=rubber)
    model.add("strip", strip)
    model.clamp("strip.start")
    model.gravity()
    report = model.simulate(0.1).report()
    assert "Nothing moves: what displacements change by is rounding" in report
    assert "largest range" not in report


def test_report_of_a_single_state():
    report = Run(swing(duration=1.0).isel(time=slice(0, 1))).report()
    assert report.count("beam.end") >= 1


def test_report_of_driven_cycles_does_not_blame_the_material():
    data = swing()
    data["external"] = data["external"] + 1e-3 * data["time"]
    assert "loads or supports do work meanwhile" in flat(Run(data).report())


def test_stopped_run_says_so():
    data = swing().assign_attrs(outcome="diverged", message="Newton's method failed at 3 s")
    assert "stopped early (diverged): Newton's method failed at 3 s" in flat(Run(data).report())


def test_equilibrium_report():
    report = Equilibrium(rolled_up(0.5 * np.pi)).report()
    lines = [" ".join(line.split()) for line in report.splitlines()]
    assert "beam.end 0.190986 0.190986 0 -0.109014 0.190986 0" in lines
    assert "beam.end 0 0 1.5708" in lines
    assert "Stable: the tangent stiffness has no negative eigenvalue" in lines
    assert any(line.startswith("beam.start 0 0 0 0 0 -4.3") for line in lines)
    unstable = Equilibrium(rolled_up().assign_attrs(negative_eigenvalues=2)).report()
    assert "Unstable: the tangent stiffness has 2 negative eigenvalues" in unstable


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (swing(leak=0.05), "numerical remainder of the energy account reaches 4.9 %"),
        (swing().assign_attrs(warnings=json.dumps(["the rod is thick"])), "the rod is thick"),
        (
            rolled_up().assign_attrs(mesh_errors='{"beam": 0.001}', mesh_motion_error=0.02),
            "positions may be off by 2 % of the largest displacement, most in rod 'beam'",
        ),
        (rolled_up().assign_attrs(mesh_force_error=0.07), "section forces may be off by 7 %"),
        (rolled_up().assign_attrs(mesh_lost=1), "the error of the mesh is unknown"),
    ],
)
def test_warnings(data, text):
    kind = Run if data.attrs["kind"] == "simulate" else Equilibrium
    (warning,) = warnings_of(kind(data))
    assert text in warning


def test_large_strain_is_located():
    data = swing(duration=1.0)
    data["strain"][3, 4, 2] = -0.3
    (warning,) = warnings_of(Run(data))
    assert warning.startswith("the strain stretch reaches 0.3 at beam@0.135")


def test_small_numbers_beside_large_ones_read_zero():
    data = rolled_up()
    data["position"][..., 2] = 1e-18
    row = next(line for line in Equilibrium(data).report().splitlines() if "beam.end" in line)
    assert "e-18" not in row


def test_large_bending_strain_is_located():
    data = swing(duration=1.0)
    data["half_width"] = ("point", np.full(data.sizes["point"], 0.005))
    assert warnings_of(Run(data)) == []
    data["strain"][3, 4, 4] = -30.0
    (warning,) = warnings_of(Run(data))
    assert warning.startswith("bend 2 times the half width of the section reaches 0.15 at beam@0.135")


def test_what_the_steps_lost_is_told_everywhere(tmp_path):
    """A bar that swings undamped, in ten steps: the remainder of its energy account is in all that is read."""
    model = vr.Model()
    steel = vr.Material(2e11, 0.3, 7850.0)
    model.add(
        "bar",
        vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Rectangle(0.02, 0.02), material=steel, elements=1),
    )
    model.clamp("bar.start")
    model.force("bar.end", (0, 8.0, 0))
    text = "numerical remainder of the energy account reaches"
    for folder in (None, tmp_path):
        with pytest.warns(vr.AccuracyWarning, match=text) as caught:
            run = model.simulate(0.2, initial="reference", tolerance=1e-2, folder=folder)
        assert {record.filename for record in caught} == {__file__}
        assert [text in warning for warning in run.warnings].count(True) == 1
        assert text in flat(run.report())
        assert any(text in told for told in json.loads(run.data.attrs["warnings"]))
    assert any(text in told for told in vr.load(tmp_path / "run.nc").warnings)


@pytest.mark.parametrize(("retardation", "told"), [(1e-8, True), (1e-4, False)])
def test_steps_that_take_more_than_the_material_are_told(retardation, told):
    """A strip that swings without damping, with steps of the same tolerance, shows what the steps alone take."""

    def swing(damping):
        steel = vr.Material(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7850.0, damping=damping)
        model, section = vr.Model(), vr.Rectangle(0.02, 0.001)
        rod = vr.Rod.straight((0, 0, 0), (0.3, 0, 0), section=section, material=steel, elements=1, order=5)
        model.add("strip", rod)
        model.clamp("strip.start")
        model.force("strip.end", (0, 0, 0.5), until=0.0)
        run = model.simulate(0.1, tolerance=1e-5, errors=False)
        return run, float(run.energy.total[0] - run.energy.total[-1])

    undamped, by_steps = swing(None)
    assert undamped.warnings == []
    with pytest.warns(vr.AccuracyWarning, match="is not the material's") if told else nullcontext():
        run, gone = swing(vr.KelvinVoigt(shear_time=retardation, bulk_time=retardation))
    assert (by_steps > 0.2 * (gone - by_steps)) == told
    warned = [text for text in run.warnings if "is not the material's" in text]
    assert len(warned) == told
    if told:
        steps = float(re.search(r"steps took ([\d.]+) µJ", warned[0])[1])
        assert 1e-6 * steps == pytest.approx(by_steps, rel=0.1)


def test_a_motion_computed_again_warns_of_its_last_mesh_only():
    """A step of the axial force on an undamped bar runs along it as a front, for which the first mesh is too coarse."""
    steel = vr.Material(youngs_modulus=2.1e11, poissons_ratio=0.3, density=7850.0)
    model = vr.Model()
    model.add("bar", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=vr.Circle(0.005), material=steel))
    model.clamp("bar.start")
    model.force("bar.end", (-50.0, 0, 0), until=0.0)
    with pytest.warns(vr.AccuracyWarning) as caught:
        run = model.simulate(1.5e-3, tolerance=1e-7)
    assert run.data.attrs["warnings"] == json.dumps([str(record.message) for record in caught])
    assert {record.filename for record in caught} == {__file__}


@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1.0, "all of the loads"),
        (0.25, "25 % of the loads"),
        (-1.5, "-150 % of the loads"),
        (439.6, "439.6 times the loads"),
    ],
)
def test_load_factors_in_words(factor, words):
    assert load_level(factor) == words
