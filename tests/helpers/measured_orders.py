"""Orders of accuracy in time by regression of the error against the step, of any integrator that is registered."""

from __future__ import annotations

import numpy as np
import pytest

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators import INTEGRATORS
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


class March:
    """A run with equal steps: positions and velocities ``(instants, stations, 3)``, and what the integrator did."""

    def __init__(
        self,
        model,
        duration,
        step,
        integrator="radau",
        formulation="geometric",
        interval=None,
        settle=False,
        **given,
    ):
        problem, method = discretise(model), INTEGRATORS[integrator]
        system, supports = FORMULATIONS[formulation, "full"].make(problem), SupportState(problem)
        n = problem.size
        state = State(problem.positions.copy(), problem.quaternions.copy(), np.zeros((n, 6)))
        if settle:
            StaticSolver(system, supports).solve(state)
        given = {**method.parameters, **given}
        if method.tolerance is not None:
            given = {"tolerance": TIGHT} | given
        self.integrator = method.make(system, supports, **given)
        self.integrator.iterations = 50  # partly held nodes that turn converge slowly to round-off
        control = FixedSteps(step)
        self.result = Transient(problem, self.integrator, control).run(
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


def orders_against(exact, make, duration, steps, **given):
    """Orders of positions and velocities at the end, and the errors, against another run."""
    errors = []
    for h in steps:
        run = March(make(), duration, h, **given)
        errors.append([np.abs(getattr(run, n)[-1] - getattr(exact, n)[-1]).max() for n in "rv"])
    return [slope(steps, e) for e in np.transpose(errors)], np.array(errors)


def check_order_of_accuracy(integrator, formulation):
    """Measure the order of positions and velocities under smooth loads, against radau: what the method states."""
    order = INTEGRATORS[integrator].order
    longest = {1: 0.01, 2: 0.02}.get(order, 0.08)
    exact = March(swung(), 0.8, 0.005, formulation=formulation)
    (positions, velocities), _ = orders_against(
        exact,
        swung,
        0.8,
        (longest, 0.5 * longest, 0.25 * longest),
        integrator=integrator,
        formulation=formulation,
    )
    assert positions == pytest.approx(order, abs=0.1 if order < 3 else 0.07 * order)
    assert velocities == pytest.approx(order, abs=0.1 if order < 3 else 0.1 * order)
