"""Steady rotations: what is refused and how, the element's matrices, derivatives, what results hold."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from helpers.pictures import written
from helpers.small_frame import Moved, frame
from viscorod.analyses.case_run import run_case
from viscorod.casefile.case import case_from_dict, parse_case
from viscorod.mechanics.elements.intrinsic_element import StrainMotion, forces_at
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.steady.geometric_steady import GeometricSteady
from viscorod.solve.steady.intrinsic_steady import IntrinsicSteady
from viscorod.solve.steady.rigid_rotation import (
    RotationAxis,
    inertia_about,
    mass_centre,
    mean_spin,
    rigid_twists,
)
from viscorod.solve.steady.steady_poses import integrate_poses
from viscorod.solve.steady.strain_rates import StrainRates

MEASURES = ("spin", "energy", "momentum", "elastic")
AXIS = np.array([0.6, 0.48, 0.64])


def rod(held="pin"):
    model = vr.Model()
    section = vr.StiffnessSection([50.0, 50.0, 90.0, 1.0, 2.0, 1.0], [1.0, 1.0, 1.0, 0.01, 0.01, 0.02])
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=2, order=3))
    if held:
        getattr(model, held)("beam.start")
    return model


def changed(model, change):
    change(model)
    return model


REFUSED = {
    "no measure": (rod, {}, "exactly one of spin, energy and momentum"),
    "two measures": (rod, {"spin": 1.0, "energy": 1.0}, "exactly one of spin, energy and momentum"),
    "spin twice": (rod, {"spin": (0, 0, 1.0), "axis": (0, 0, 1)}, "has an axis already"),
    "no spin": (rod, {"spin": (0, 0, 0)}, "nothing turns"),
    "hardly any spin": (rod, {"spin": (0, 0, 1e-300)}, "smaller than any quantity"),
    "backwards": (rod, {"spin": -1.0}, "give a number > 0"),
    "centre": (rod, {"spin": 1.0, "centre": (0, 0, 1)}, "turns about its ball joint"),
    "damping": (rod, {"spin": 1.0, "damping": "linearised"}, "full damping only"),
    "clamped": (lambda: rod("clamp"), {"energy": 1.0}, "there is a clamp at beam.start"),
    "moving support": (
        lambda: changed(rod(None), lambda m: m.clamp("beam.start", motion={"rz": vr.Ramp(0.0, 1.0)})),
        {"spin": (0, 0, 1.0)},
        "clamp at beam.start: its prescribed motion rz",
    ),
    "slanting gravity": (
        lambda: changed(rod("clamp"), lambda m: m.gravity((0, 1, -9.81))),
        {"spin": (0, 0, 1.0)},
        r"loads\[0\]: gravity: it is not parallel to the axis",
    ),
    "loaded free rod": (
        lambda: changed(rod(), lambda m: m.gravity()),
        {"spin": 1.0},
        r"loads\[0\]: gravity: a rod that turns freely is free of load",
    ),
    "changing load": (
        lambda: changed(rod("clamp"), lambda m: m.force("beam.end", (0, 0, 1), time=vr.Sine(1.0, 1.0))),
        {"spin": (0, 0, 1.0)},
        r"loads\[0\]: force: it changes with time",
    ),
    "travelling load": (
        lambda: changed(rod("clamp"), lambda m: m.moving_force("beam", (0, 0, 1), speed=1.0)),
        {"spin": (0, 0, 1.0)},
        r"loads\[0\]: moving_force: it travels",
    ),
    "load between nodes": (
        lambda: changed(rod("clamp"), lambda m: m.force("beam@0.123", (1, 0, 0), following=True)),
        {"spin": (0, 0, 1.0)},
        r"loads\[0\]: force: it acts between nodes",
    ),
    "dead load of the intrinsic formulation": (
        lambda: changed(rod("clamp"), lambda m: m.gravity()),
        {"spin": (0, 0, 1.0), "formulation": "intrinsic"},
        "which the intrinsic formulation does not know",
    ),
    "roller of the intrinsic formulation": (
        lambda: changed(rod(None), lambda m: m.roller("beam.end", (0, 1, 0))),
        {"spin": (1.0, 0, 0), "formulation": "intrinsic"},
        "roller at beam.end: the intrinsic formulation knows clamps and ball joints",
    ),
    "two supports of the intrinsic formulation": (
        lambda: changed(rod("clamp"), lambda m: m.pin("beam.end")),
        {"spin": (1.0, 0, 0), "formulation": "intrinsic"},
        "pin at beam.end: without positions nothing keeps a second support",
    ),
    "rods apart": (
        lambda: changed(rod(), lambda m: m.add("other", rod().rods["beam"])),
        {"spin": 1.0},
        "the rods are not connected",
    ),
    "eccentric joint of the intrinsic formulation": (
        rod,
        {"spin": (0, 0, 1.0), "centre": (0, 1, 0), "formulation": "intrinsic"},
        "pin at beam.start: off the axis",
    ),
    "start at rest": (
        rod,
        {"spin": 1.0, "start": vr.Model.equilibrium(changed(rod("clamp"), lambda m: m.clamp("beam@0.3")))},
        "start: its last state does not turn",
    ),
    "resting start": (rod, {"spin": 1.0, "start": vr.Model.equilibrium(rod("clamp"))}, "does not turn"),
    "no result": (rod, {"spin": 1.0, "start": 3}, "give a result"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(name):
    """Contract: what cannot turn steadily is refused by name, with what to give instead."""
    model, given, message = REFUSED[name]
    with pytest.raises(vr.InputError, match=message):
        model().steady(**given)


def test_a_spin_out_of_reach_is_told_with_the_range():
    """Contract: bent shapes exist from the first bending frequency on; the message says from where to where."""
    with pytest.raises(vr.SolveError, match="bent shapes were followed from spin = "):
        rod().steady(spin=1.0)


def test_settings_are_those_of_the_case_file():
    """Contract: settings round-trip through plain values."""
    settings = SteadySettings(spin=(0, 0, 4), centre=(1, 0, 0), modes=3)
    assert SteadySettings(**settings.to_dict()) == settings
    assert settings.driven
    assert settings.measure == "spin"


def intrinsic(at, *, linearised=False, still=True, joint=2):
    rng = np.random.default_rng(2)
    strain = 0.1 * rng.normal(size=at.elements.reference.shape)
    return IntrinsicSteady(
        at.problem,
        at.elements,
        linearised=linearised,
        free=np.ones((at.n, 6), dtype=bool),
        following=rng.normal(size=(at.n, 6)),
        joint=joint,
        still=still,
        line=RotationAxis(AXIS, np.zeros(3)),
        state=at.state,
        strain=strain,
    )


def test_strain_rates_are_those_of_the_element():
    """Equivalence: matrices give the strain rates and forces of the compiled element, attachments included."""
    at = Moved(frame())
    equations = intrinsic(at, linearised=True)
    strain, _ = equations.fields()
    motion = StrainMotion.of(at.elements, 1, linearised=True)
    rate, S, force = np.zeros((1, *strain.shape)), np.zeros((1, *strain.shape)), np.zeros((1, at.n, 6))
    forces_at(at.elements, motion, at.state.twist[None], strain[None], rate, np.zeros_like(strain), S, force)
    used = equations.rates.used
    _, own, _ = equations._rates_and_forces()
    assert own == pytest.approx(force[0], abs=1e-12 * np.abs(force).max())
    assert equations.fields()[1][used] == pytest.approx(S[0][used], abs=1e-12 * np.abs(S).max())
    viscous = equations.rates.unstrained @ at.state.twist.ravel()
    assert viscous == pytest.approx(rate[0][used], abs=1e-12 * np.abs(rate).max())


@pytest.mark.parametrize("linearised", [False, True])
def test_derivatives_of_the_intrinsic_equations(linearised):
    """Finite differences: residual and measures, in a random direction at a random state; both are polynomials."""
    equations = intrinsic(Moved(frame()), linearised=linearised)
    balance, kept = equations.balance(), equations.save()
    direction = np.random.default_rng(1).normal(size=balance.matrix.shape[1]) * equations.scales()

    def slope_of(value, h=1e-4):
        ends = []
        for sign in (1.0, -1.0):
            equations.restore(kept)
            equations.update(sign * h * direction)
            ends.append(value())
        equations.restore(kept)
        return (ends[0] - ends[1]) / (2.0 * h)

    expected = slope_of(lambda: equations.balance().residual)
    assert balance.matrix @ direction == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    for measure in MEASURES:
        expected = slope_of(lambda measure=measure: equations.measure(measure)[0])
        assert equations.measure(measure)[1] @ direction == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_derivatives_of_the_geometric_equations():
    """Finite differences: residual and measures, in a random direction at a random state without supports."""
    at = Moved(frame())
    loads = ExternalLoads(at.problem).at(0.0)
    equations = GeometricSteady(at.system, at.supports, loads, RotationAxis(AXIS, np.ones(3)), at.state, 0.7)
    balance, kept = equations.balance(), equations.save()
    direction = np.random.default_rng(1).normal(size=balance.matrix.shape[1])

    def slope_of(value, h=1e-5):
        ends = []
        for sign in (1.0, -1.0):
            equations.restore(kept)
            equations.update(sign * h * direction)
            ends.append(value())
        equations.restore(kept)
        return (ends[0] - ends[1]) / (2.0 * h)

    def nodal():
        return equations.residual()[0].ravel()

    expected = slope_of(nodal)
    assert balance.matrix @ direction == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    for measure in MEASURES:
        expected = slope_of(lambda measure=measure: equations.measure(measure)[0])
        assert equations.measure(measure)[1] @ direction == pytest.approx(expected, rel=1e-6)


def test_laying_out_undoes_taking_strains():
    """Round trip: a shape of constant curvature and twist is a helix, which elements of order 8 lay out to 1e-9."""
    model = vr.Model()
    section = vr.StiffnessSection([1.0] * 6, [1.0] * 6)
    helix = vr.Rod.helix(0.3, 0.2, 1.0, section=section, elements=8, order=8)
    model.add("helix", helix)
    problem = discretise(model)
    at = Moved(model, size=0.0)
    strain = np.zeros_like(at.elements.reference)
    for root in (0, problem.size - 1):
        r, q = integrate_poses(
            problem, at.elements, strain, root, problem.positions[root], problem.quaternions[root]
        )
        assert r == pytest.approx(problem.positions, abs=1e-9)
        assert np.abs(np.einsum("ni,ni->n", q, problem.quaternions)) == pytest.approx(1.0, abs=1e-12)


def test_rigid_bodies():
    """Closed forms: mass centre and inertia of a bar; the mean spin of a rigid rotation is its spin."""
    problem = discretise(rod(None))
    mass, r, q = problem.mass, problem.positions, problem.quaternions
    assert mass_centre(mass, r, q) == pytest.approx([0.5, 0.0, 0.0], abs=1e-14)
    expected = np.diag([0.02, 1.0 / 3.0 + 0.01, 1.0 / 3.0 + 0.01])
    assert inertia_about(mass, r, q, np.zeros(3)) == pytest.approx(expected, abs=1e-14)
    spin = np.array([1.0, -2.0, 0.5])
    state = State(r, q, rigid_twists(r, q, [0.0] * 3, spin, np.zeros(3)))
    assert mean_spin(mass, state, np.zeros(3)) == pytest.approx(spin, abs=1e-13)


def test_rates_of_rigid_motions():
    """Invariance: a rigid motion of the unstrained shape has no strain rates, up to the curvature's interpolation."""
    problem = discretise(frame((4, 5)))
    at = Moved(frame((4, 5)), offset=0.0, size=0.0)
    twist = rigid_twists(problem.positions, problem.quaternions, [1.0, 2.0, 3.0], AXIS, np.zeros(3))
    rates = StrainRates(at.elements, problem.size).unstrained @ twist.ravel()
    assert np.abs(rates).max() < 1e-12


def test_a_result_is_saved_drawn_and_told(tmp_path):
    """Contract: a loaded steady rotation says what the fresh one does."""
    found = rod().steady(spin=5.0, axis=(0, 0, 1), title="A turning bar", modes=4)
    again = vr.load(found.save(tmp_path / "steady.nc"))
    assert isinstance(again, vr.Steady)
    assert again.report() == found.report()
    assert again.eigenvalues == pytest.approx(found.eigenvalues, abs=0.0)
    text = str(found)
    for words in ("A turning bar", "steady rotation at 5 rad/s", "Axis (0, 0, 1)", "Slowest small motions"):
        assert words in text
    assert written(found.plot, tmp_path / "steady.png").is_file()
    assert (found.formulation, found.damping, len(found.frequencies)) == ("geometric", "full", 4)
    size = np.abs(found.eigenvalues)
    assert found.damping_ratios * size == pytest.approx(-found.eigenvalues.real)
    assert found.damping_ratios[0] == size[0] == 0.0  # spinning a bit faster
    assert np.linalg.norm(found.joint_spin) == pytest.approx(5.0)
    # and it is a first guess itself
    faster = rod().steady(spin=5.5, start=found)
    assert np.linalg.norm(faster.spin) == pytest.approx(5.5)


CASE = """
[sections.flat]
shape = "stiffness"
stiffness = [50.0, 50.0, 90.0, 1.0, 2.0, 1.0]
inertia = [1.0, 1.0, 1.0, 0.01, 0.01, 0.02]
[rods.blade]
shape = "straight"
start = [0.2, 0.0, 0.0]
end = [1.2, 0.0, 0.0]
section = "flat"
elements = 1
order = 4
[[supports]]
kind = "clamp"
at = "blade.start"
[steady]
spin = [0.0, 0.0, 2.0]
modes = 3
"""


def test_a_case_file_asks_for_it():
    """Contract: the table [steady] does what ``Model.steady`` does, and round-trips."""
    case = parse_case(CASE)
    assert case.kind == "steady"
    found = run_case(case)
    assert isinstance(found, vr.Steady)
    model = case.model(vr.Model)
    assert found.eigenvalues == pytest.approx(model.steady(spin=(0, 0, 2.0), modes=3).eigenvalues, abs=0.0)
    assert case_from_dict(case.to_dict()).settings == case.settings


def test_members_of_a_sweep(tmp_path):
    """Contract: a sweep over the angular velocity keeps one steady rotation per member, in its file too."""
    table = {"steady.spin": [[0, 0, 1.0], [0, 0, 2.0]]}
    sweep = vr.sweep(parse_case(CASE), table, workers=1)
    again = vr.load(sweep.save(tmp_path / "sweep.nc"))
    rates = [float(np.linalg.norm(member.result.spin)) for member in again.members]
    assert rates == [1.0, 2.0]
