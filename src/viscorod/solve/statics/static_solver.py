"""Static equilibrium: mixed Newton with load steps that adapt to how hard the problem is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import sparse

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.statics.newton import (
    Convergence,
    NewtonReport,
    Outcome,
    SingularMatrixError,
    interruption,
    worst_node,
)
from viscorod.solve.statics.tangent import Tangent


@dataclass
class StaticPath:
    """The solution of a static analysis and the steps to it.

    Attributes:
        outcome: COMPLETED, or why the last load step failed.
        factors: load factors of the converged steps; iterations: Newton iterations of each.
        rejected: load steps that failed and were halved; their iterations are in ``wasted``.
        report: the last Newton report; load_level: the factor that was tried last.
        reason: why an INTERRUPTED solution stopped.
    """

    outcome: Outcome = Outcome.COMPLETED
    factors: list[float] = field(default_factory=list)
    iterations: list[int] = field(default_factory=list)
    rejected: int = 0
    wasted: int = 0
    report: NewtonReport | None = None
    load_level: float = 0.0
    reason: str = ""


class StaticSolver:
    """Solves for equilibrium under the loads and prescribed motions at one time, scaled by a load factor.

    Args:
        system: the formulation; supports: its supports.
        tolerance: size of the last Newton increment (displacement over model length, rotation in rad).
        iterations: allowed Newton iterations per load step.
        stop: called in every iteration; returns why the solution is to stop, or nothing.
    """

    def __init__(
        self,
        system: System,
        supports: SupportState,
        *,
        tolerance: float = 1e-9,
        iterations: int = 25,
        stop: Callable[[], str] | None = None,
    ) -> None:
        self.system = system
        self.supports = supports
        self.loads = ExternalLoads(system.problem)
        self.tolerance = tolerance
        self.iterations = iterations
        self.stop = stop

    def check_interrupt(self) -> None:
        """Raise where the solution is to stop; called in every iteration.

        Raises:
            KeyboardInterrupt: it is; as if asked from the keyboard, with the reason.
        """
        reason = "" if self.stop is None else self.stop()
        if reason:
            raise KeyboardInterrupt(reason)

    def solve(
        self,
        state: State,
        t: float = 0.0,
        *,
        before: bool = True,
        factor: float = 1.0,
        first_step: float = 1.0,
        smallest_step: float = 1.0 / 4096,
        on_step: Callable[[float, State, int], None] | None = None,
    ) -> StaticPath:
        """Move ``state`` from its present equilibrium (load factor 0) to the one at ``factor``.

        Args:
            state: start, overwritten by the last converged equilibrium; twists are ignored.
            t, before: time at which loads and motions are taken, and whether from the left.
            factor: final multiple of the loads and prescribed motions.
            first_step: first load step as a fraction of ``factor``; steps halve on failure and double on easy success.
            on_step: called with (load factor, state, iterations) after every converged step.
        """
        path = StaticPath()
        try:
            self._advance(path, state, t, before, factor, first_step, smallest_step, on_step)
        except KeyboardInterrupt as asked:
            path.outcome, path.reason = Outcome.INTERRUPTED, interruption(asked)
            self.restore(state, t, before=before, scale=path.factors[-1] if path.factors else 0.0)
        return path

    def _advance(
        self,
        path: StaticPath,
        state: State,
        t: float,
        before: bool,
        factor: float,
        first_step: float,
        smallest_step: float,
        on_step: Callable[[float, State, int], None] | None,
    ) -> None:
        done, step = 0.0, first_step
        while done < 1.0:
            step = min(step, 1.0 - done)
            trial = state.copy()
            path.load_level = factor * (done + step)
            path.report = report = self.newton(trial, t, before=before, scale=path.load_level)
            if report.converged:
                done = 1.0 if done + step > 1.0 - 1e-12 else done + step
                state.set(trial)
                path.factors.append(factor * done)
                path.iterations.append(report.iterations)
                if on_step is not None:
                    on_step(factor * done, state, report.iterations)
                if report.iterations <= 8:
                    step *= 2.0
                continue
            path.rejected += 1
            path.wasted += report.iterations
            self.restore(state, t, before=before, scale=factor * done)
            step *= 0.5
            if step < smallest_step:
                path.outcome = report.outcome
                return

    def newton(self, state: State, t: float, *, before: bool, scale: float) -> NewtonReport:
        """Solve at one load level from ``state``; on success the assembly at the solution is left in the system."""
        system, supports = self.system, self.supports
        problem = system.problem
        supports.update(t, before, scale)
        system.constraints.update(t, before, scale)
        loads = self.loads.at(t, before, scale)
        convergence = Convergence(problem.length, self.tolerance, self.iterations)
        count, size = 0, 0.0

        def report(outcome: Outcome) -> NewtonReport:
            imbalance, node = worst_node(supports.unbalanced(residual)[: problem.size], problem.length)
            return NewtonReport(outcome, count, size, imbalance, node)

        while True:
            self.check_interrupt()
            system.assemble(state, loads, None, tangent=True, moving=False)
            residual = system.residual()
            if not np.isfinite(residual).all():
                bad = min(int(np.flatnonzero(~np.isfinite(residual).all(axis=1))[0]), problem.size - 1)
                return NewtonReport(Outcome.NOT_FINITE, count, size, np.inf, bad)
            supports.impose(state, residual, system.matrix, tangent=True)
            try:
                system.matrix.factorise()
            except SingularMatrixError as error:
                return replace(report(Outcome.SINGULAR), node=error.row // 6)
            increment = system.matrix.solve(-residual)
            count += 1
            verdict, size = convergence.judge(increment[: problem.size], count)
            if verdict is Outcome.NOT_FINITE:
                return report(Outcome.SINGULAR)
            retract(state.r, state.q, increment, state.r, state.q)
            system.carry_stress(increment)
            state.multiplier += system.multiplier_change(increment)
            if verdict is None:
                continue
            if verdict is Outcome.CONVERGED:
                self.restore(state, t, before=before, scale=scale)
            return report(verdict)

    def restore(self, state: State, t: float, *, before: bool, scale: float) -> None:
        """Evaluate forces and reactions at ``state`` and take its section forces as stress iterate."""
        self.supports.update(t, before, scale)
        self.system.constraints.update(t, before, scale)
        self.system.assemble(state, self.loads.at(t, before, scale), None, tangent=False, moving=False)
        self.system.reset_stress()
        self.system.constraints.track_angles()
        residual = self.system.residual()
        self.supports.impose(state, residual, self.system.matrix, tangent=False)

    def tangent(self, state: State, t: float = 0.0, *, before: bool = True, scale: float = 1.0) -> Tangent:
        """Return the tangent stiffness at an equilibrium, and the conditions of joints and held strains beside it."""
        system, supports = self.system, self.supports
        self.restore(state, t, before=before, scale=scale)
        system.assemble(state, self.loads.at(t, before, scale), None, tangent=True, moving=False)
        stiffness, basis = supports.reduce_tangent(state, system.residual(), system.matrix)
        gradients = None
        if system.constraints.rows:
            gradients = unit_rows(sparse.csr_array(system.constraint_gradients(state) @ basis))
        return Tangent(stiffness, basis, gradients)
