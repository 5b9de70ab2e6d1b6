"""Orders in time of the collocation methods and their dense output by regression; error against the tolerance."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators import GeneralizedAlpha, Midpoint, Radau
from viscorod.solve.transient.step_control import FixedSteps
from viscorod.solve.transient.transient_solver import Transient

TIGHT = 2.5e-8
"""Tolerance of radau with fixed steps, for which only the error left by Newton's method matters: 1e-12."""


def curved(damping, elements=3, order=4):
    """A curved and twisted cantilever with a full section."""
    stiffness = np.diag([800.0, 700.0, 2e3, 1.0, 1.4, 0.8])
    stiffness[2, 3] = stiffness[3, 2] = 10.0
    stiffness[3, 5] = stiffness[5, 3] = 0.2
    section = vr.StiffnessSection(stiffness, [1, 1, 1, 1e-2, 1e-2, 2e-2], damping * stiffness)
    model = vr.Model()
    given = {"section": section, "elements": elements, "order": order, "twist": 0.8}
    model.add("rod", vr.Rod.arc((0, 0, 0), (1, 0, 0), (0, 1, 0), 1.0, 1.2, **given))
    return model


def swung(damping=0.01):
    """Smooth dead and following loads."""
    model = curved(damping)
    model.clamp("rod.start")
    model.force("rod.end", (0.4, 0.8, 1.5), time=vr.Sine(1.0))
    model.moment("rod.end", (0.3, 0.0, -0.4), following=True, time=vr.Sine(0.7))
    return model


def whirled():
    """Prescribed motion of a clamp and a partly supported, moving far end."""
    model = curved(0.01)
    model.clamp("rod.start", motion={"uy": vr.Sine(1.0, amplitude=0.1), "rz": vr.Sine(0.5, amplitude=0.8)})
    model.support("rod.end", ("ux",), motion={"uz": vr.Sine(0.8, amplitude=0.15)})
    return model


def steered():
    """Likewise, from rest: no velocity jumps at the start."""
    model = curved(0.01)
    model.clamp("rod.start", motion={"uy": vr.SpinUp(0.2, 1.0), "rz": vr.SpinUp(0.8, 1.0)})
    model.support("rod.end", ("ux",), motion={"uz": vr.SpinUp(0.3, 1.0)})
    return model


def released():
    """Loads that jump at t = 0 and at t = 0.25."""
    model = curved(0.02)
    model.clamp("rod.start")
    model.force("rod.end", (0, 0, 1.0), until=0.0)
    model.force("rod.end", (0.5, 0, 0), time=vr.TimeTable([0.0, 0.25, 0.25], [0.0, 0.0, 1.0]))
    return model


class March:
    """A run with equal steps: positions and velocities ``(instants, stations, 3)``, and what the integrator did."""

    def __init__(self, model, duration, step, method=Radau, interval=None, settle=False, **given):
        problem = discretise(model)
        system, supports = GeometricSystem(problem), SupportState(problem)
        n = problem.size
        state = State(problem.positions.copy(), problem.quaternions.copy(), np.zeros((n, 6)))
        if settle:
            StaticSolver(system, supports).solve(state)
        if method is Radau:
            given = {"tolerance": TIGHT} | given
        self.integrator = method(system, supports, **given)
        self.integrator.iterations = 50  # partly held nodes that turn converge slowly to round-off
        control = FixedSteps(step)
        self.result = Transient(problem, self.integrator, control, system.describe_node).run(
            state, duration, output_interval=interval
        )
        assert self.result.outcome is Outcome.COMPLETED
        assert self.result.effort.rejected == 0
        snapshots = self.result.history.snapshots
        self.t = np.array(self.result.history.instant)
        r, q, twist = (np.array([getattr(s.state, name) for s in snapshots]) for name in ("r", "q", "twist"))
        self.r, self.q, self.v, self.spin = StationReader(problem).read(r, q, twist)


def slope(sizes, errors):
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def orders(make, duration, steps, fine, method=Radau, settle=False, at=slice(None), **given):
    """Orders of positions and velocities at the end."""
    exact = March(make(), duration, fine, method, settle=settle, **given)
    errors = []
    for h in steps:
        run = March(make(), duration, h, method, settle=settle, **given)
        errors.append([np.abs(getattr(run, n)[-1, at] - getattr(exact, n)[-1, at]).max() for n in "rv"])
    return [slope(steps, e) for e in np.transpose(errors)], np.array(errors)


def test_order_of_radau():
    """Order five of positions and velocities under smooth loads (theory; against a fine run on the same mesh)."""
    (positions, velocities), errors = orders(swung, 0.8, (0.08, 0.04, 0.02), 0.005)
    assert positions == pytest.approx(5.0, abs=0.35)
    assert velocities == pytest.approx(5.0, abs=0.5)
    assert errors[-1, 0] < 5e-8


@pytest.mark.parametrize("method", [Midpoint, GeneralizedAlpha])
def test_order_of_the_methods_of_second_order(method):
    """Order two of positions and velocities under smooth loads (theory)."""
    found, _ = orders(swung, 0.8, (0.02, 0.01, 0.005), 0.0005, method)
    assert found == pytest.approx([2.0, 2.0], abs=0.1)


def test_order_of_radau_with_prescribed_motion_and_partial_support():
    """Theory of index-3 constraints: order five of positions and three of velocities."""
    (positions, velocities), _ = orders(steered, 0.8, (0.08, 0.04, 0.02), 0.005)
    assert positions == pytest.approx(5.0, abs=0.5)
    assert velocities > 3.0


def test_order_of_radau_after_supports_start_with_a_jolt():
    """Order by regression: velocities that jump at the start excite modes far beyond what the steps resolve."""
    found, errors = orders(whirled, 0.8, (0.01, 0.005, 0.0025), 0.000625)
    assert min(found) > 1.8
    assert errors[-1, 0] < 5e-7


def test_order_of_radau_with_jumps():
    """Order by regression, steps far too long for what the jumps start in the highest modes: no step lags behind."""
    (positions, velocities), errors = orders(released, 0.7, (0.05, 0.025, 0.0125), 0.003125, settle=True)
    assert positions > 2.5
    assert velocities > 2.5
    assert errors[-1, 0] < 1e-7


@pytest.mark.parametrize("tau", [0.1, 1.0, 10.0])
def test_order_of_radau_with_heavily_damped_modes(tau):
    """Order by regression where tau omega of the highest modes is 1e2 to 1e5: at least the stage order, three."""
    omega = np.abs(swung(1e-6).modes(200).eigenvalues).max()
    assert 1e2 < tau * omega < 1e5
    steps = (0.16, 0.08, 0.04, 0.02)
    found, errors = orders(lambda: swung(tau), 0.8, steps, 0.0025)
    assert min(found) > 3.0
    clear = errors[:, 0] > 1e-8  # above what Newton's method leaves
    local = np.diff(np.log(errors[:, 0])) / np.diff(np.log(steps))
    assert local[clear[1:]].min() > 3.0


def between_steps(method, steps, **given):
    """Orders of positions, velocities, orientations and strains at 77 equal times, most of them between steps."""
    exact = March(swung(), 0.8, 0.0025, interval=0.8 / 77)
    errors = []
    for h in steps:
        run = March(swung(), 0.8, h, method, interval=0.8 / 77, **given)
        assert run.t == pytest.approx(exact.t, abs=1e-12)
        strain = [
            np.abs(a.strain - b.strain).max()
            for a, b in zip(run.result.history.snapshots, exact.result.history.snapshots, strict=True)
        ]
        errors.append([*(np.abs(getattr(run, n) - getattr(exact, n)).max() for n in "rvq"), max(strain)])
    return [slope(steps, e) for e in np.transpose(errors)]


def test_order_between_the_steps_of_radau():
    """Order by regression of the dense output against a fine run."""
    positions, velocities, rotations, strains = between_steps(Radau, (0.08, 0.04, 0.02))
    assert positions > 4.0
    assert rotations > 3.0
    assert velocities > 2.0
    assert strains > 2.0


@pytest.mark.parametrize("method", [Midpoint, GeneralizedAlpha])
def test_order_between_the_steps_of_second_order(method):
    """Order by regression of the dense output against a fine run: that of the methods."""
    positions, velocities, rotations, strains = between_steps(method, (0.02, 0.01, 0.005))
    assert [positions, velocities, rotations] == pytest.approx([2.0] * 3, abs=0.15)
    assert strains > 0.7


def error(model, reference, **given):
    run = model.simulate(1.5, output_interval=0.01, initial="reference", **given)
    distance = np.linalg.norm(run.data["position"].values - reference, axis=2)
    return float(distance.max() / run.data.attrs["scale_length"])


@pytest.mark.parametrize(
    ("integrator", "tolerances", "least", "most"),
    [
        ("radau", (1e-3, 1e-5, 1e-7), 0.003, 10.0),  # jolts are followed more exactly than asked
        ("generalized_alpha", (1e-2, 1e-3, 1e-4), 0.01, 30.0),
    ],
)
@pytest.mark.parametrize("make", [swung, whirled])
def test_error_follows_the_tolerance(make, integrator, tolerances, least, most):
    """Largest displacement error at 150 equal times over the tolerance, against a run at 1e-9."""
    fine = make().simulate(1.5, tolerance=1e-9, output_interval=0.01, initial="reference")
    reference = fine.data["position"].values
    found = np.array([error(make(), reference, integrator=integrator, tolerance=t) for t in tolerances])
    assert np.all(found < most * np.array(tolerances))
    assert np.all(found > least * np.array(tolerances))
    assert np.all(np.diff(found) < 0)
