"""Static equilibrium: mixed Newton with load steps that adapt to how hard the problem is."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from scipy import sparse

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.once import once
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.newton import (
    ROUGH,
    Convergence,
    NewtonReport,
    Outcome,
    SingularMatrixError,
    imbalance_within,
    interruption,
    worst_node,
)
from viscorod.solve.statics.node_turns import NodeTurns
from viscorod.solve.statics.second_variation import SecondVariation
from viscorod.solve.statics.tangent import SMALL, Tangent, surely_positive
from viscorod.typing import Floats

ROUND_OFF = 16.0
"""Imbalance in units of the last digit of positions times the stiffness between two nodes that passes for rounding."""
LARGEST_TURN = 2.0
"""Largest change [rad] of a prescribed rotation in one load step: about a third of a turn, but no part of a turn, as a
rod that is rolled up by whole turns is next to nothing's stiffness away from other shapes."""
PART = 1.0 / 64.0
"""Load step, as a part of all, below which the last state is passed by: its tangent may be singular."""


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
        self.turns = NodeTurns(system.problem)

    def beside(self, problem: Problem) -> StaticSolver:
        """Return the solver of a problem that has other sections, masses or loads on the same nodes.

        See :meth:`~viscorod.solve.formulations.element_assembly.ElementAssembly.beside`: it works with what this one
        works with.
        """
        assert isinstance(self.system, GeometricSystem)
        found = copy.copy(self)
        found.system, found.loads = self.system.beside(problem), ExternalLoads(problem)
        return found

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
        stops: Sequence[float] = (),
        on_step: Callable[[float, State, int], None] | None = None,
    ) -> StaticPath:
        """Move ``state`` from its present equilibrium (load factor 0) to the one at ``factor``.

        A load step changes no prescribed rotation by more than a third of a turn: so they are followed, whatever
        their size, instead of closed the shorter way round.

        Args:
            state: start, overwritten by the last converged equilibrium; twists are ignored.
            t, before: time at which loads and motions are taken, and whether from the left.
            factor: final multiple of the loads and prescribed motions.
            first_step: first load step as a fraction of ``factor``; steps halve on failure and double on easy success.
            stops: factors at which load steps end, in this order, before the last one at ``factor``.
            on_step: called with (load factor, state, iterations) after every converged step.
        """
        path = StaticPath()
        try:
            self._advance(path, state, t, before, [*stops, factor], first_step, smallest_step, on_step)
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
        stops: Sequence[float],
        first_step: float,
        smallest_step: float,
        on_step: Callable[[float, State, int], None] | None,
    ) -> None:
        size = max(abs(stop) for stop in stops) or 1.0
        largest = self.largest_step(t, before=before)
        at, step = 0.0, min(size * first_step, largest)
        pending = list(stops)
        earlier: tuple[float, State] | None = None
        failed = False
        while pending:
            stop = pending[0]
            reached = at + np.copysign(min(step, abs(stop - at)), stop - at)
            if abs(stop - reached) < 1e-12 * size:
                reached = stop
            trial = state.copy()
            passed_by = earlier is not None and failed and step < PART * size
            if passed_by and earlier is not None:
                before_it, trial = earlier
                trial, earlier = trial.copy(), None
                by = 0.5 * abs(at - before_it)
                if by < smallest_step * size:
                    continue
                step = min(step, by)
                reached = at + np.copysign(min(by, abs(stop - at)), stop - at)
            path.load_level = reached
            path.report = report = self.newton(trial, t, before=before, scale=reached)
            if report.converged and self.turns.jumped(state, trial):
                path.report = report = replace(report, outcome=Outcome.WRAPPED, node=self.turns.worst(trial))
            if report.converged:
                earlier, failed = (at, state.copy()), False
                at = reached
                state.set(trial)
                path.factors.append(at)
                path.iterations.append(report.iterations)
                if on_step is not None:
                    on_step(at, state, report.iterations)
                if report.iterations <= 8:
                    step = min(2.0 * step, largest)
                if at == stop:
                    pending.pop(0)
                continue
            failed = True
            path.rejected += 1
            path.wasted += report.iterations
            self.restore(state, t, before=before, scale=at)
            if passed_by:
                continue
            step = 0.5 * abs(reached - at)
            if step < smallest_step * size:
                path.outcome = report.outcome
                return

    def largest_step(self, t: float, *, before: bool) -> float:
        """Return the change of the load factor that turns prescribed rotations by a third of a turn."""
        self.supports.update(t, before)
        self.system.constraints.update(t, before)
        turn = max(self.supports.largest_turn, self.system.constraints.largest_turn)
        return LARGEST_TURN / turn if turn > 0.0 else np.inf

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
            verdict, size = convergence.judge(
                increment[: problem.size], count, partial(self.is_round_off, state, residual)
            )
            if verdict is Outcome.NOT_FINITE:
                return report(Outcome.SINGULAR)
            if verdict is not Outcome.CONVERGED or size < ROUGH:
                retract(state.r, state.q, increment, state.r, state.q)
                system.carry_stress(increment)
                state.multiplier += system.multiplier_change(increment)
            if verdict is None:
                continue
            if verdict is Outcome.CONVERGED:
                self.restore(state, t, before=before, scale=scale)
                crushed = self.crushed()
                if crushed is not None:
                    return replace(report(Outcome.INSIDE_OUT), node=crushed)
            return report(verdict)

    def is_round_off(self, state: State, residual: Floats) -> bool:
        """Return whether an imposed ``residual`` is what rounding the positions of ``state`` makes of the forces.

        Prescribed motions and joints must be where they are to be.
        """
        problem, supports, constraints = self.system.problem, self.supports, self.system.constraints
        noise = position_noise(problem, state.r)
        if not imbalance_within(noise, supports.unbalanced(residual)[: problem.size], problem.length):
            return False  # as in most iterations
        nodes = supports.set.nodes
        gaps = np.abs(residual[nodes] / supports.weights[nodes]) * supports.set.fixed
        gap = max(gaps[:, :3].max(initial=0.0) / problem.length, gaps[:, 3:].max(initial=0.0))
        return bool(max(gap, np.abs(constraints.gap / constraints.unit).max(initial=0.0)) <= self.tolerance)

    def crushed(self) -> int | None:
        """Return a node where sections of the last assembly are pressed through each other, None if none are.

        There the third component of r' in the section's axes, 1 in a straight reference shape, is not positive.
        """
        strain = self.system.gauss_points().strain[:, 2]
        if strain.min(initial=0.0) > -1.0:
            return None
        worst = int(np.argmin(strain))
        places = self.system.gauss_positions()
        stations = self.system.problem.stations
        mine = np.flatnonzero(stations.rod == places.rod[worst])
        return int(stations.nodes[mine[np.argmin(np.abs(stations.s[mine] - places.s[worst]))]])

    def restore(self, state: State, t: float, *, before: bool, scale: float) -> None:
        """Evaluate forces and reactions at ``state`` and take its section forces as stress iterate."""
        self.supports.update(t, before, scale)
        self.system.constraints.update(t, before, scale)
        self.system.assemble(state, self.loads.at(t, before, scale), None, tangent=False, moving=False)
        self.system.reset_stress()
        self.system.constraints.track_angles()
        residual = self.system.residual()
        self.supports.impose(state, residual, self.system.matrix, tangent=False)

    def tangent(
        self,
        state: State,
        t: float = 0.0,
        *,
        before: bool = True,
        scale: float = 1.0,
        rate_matrix: Matrix | None = None,
    ) -> Tangent:
        """Return the tangent stiffness at an equilibrium, and the conditions of joints and held strains beside it.

        ``rate_matrix`` takes the damping, in a basis of all nodes.
        """
        self.restore(state, t, before=before, scale=scale)
        return self.tangent_here(state, t, before=before, scale=scale, rate_matrix=rate_matrix)

    def surely_stable(self, state: State, t: float, *, before: bool, scale: float) -> bool:
        """Return whether the stiffness at an equilibrium is certainly positive, of a small model without conditions.

        The stress iterate is to be that of the state, as it is where :meth:`solve` ended; False says nothing. It takes
        a fifth of what :meth:`tangent` and a count of its negative eigenvalues take, to the same verdict.
        """
        system, supports = self.system, self.supports
        if system.constraints.rows or 6 * system.problem.size > SMALL:
            return False
        supports.update(t, before, scale)
        system.constraints.update(t, before, scale)
        system.assemble(state, self.loads.at(t, before, scale), None, tangent=True, moving=False)
        stiffness = supports.reduced_tangent(state, system.residual(), system.matrix)
        return surely_positive(0.5 * (stiffness + stiffness.T))

    def tangent_here(
        self, state: State, t: float, *, before: bool, scale: float, rate_matrix: Matrix | None = None
    ) -> Tangent:
        """Return the same with the present stress iterate, which may have been carried to a state near by."""
        system, supports = self.system, self.supports
        supports.update(t, before, scale)
        system.constraints.update(t, before, scale)
        loads = self.loads.at(t, before, scale)
        system.assemble(state, loads, None, tangent=True, moving=False, rate_matrix=rate_matrix)
        balance = system.residual()
        stiffness, basis = supports.reduce_tangent(state, balance.copy(), system.matrix)
        gradients = None
        if system.constraints.rows:
            gradients = unit_rows(sparse.csr_array(system.constraint_gradients(state) @ basis))
        forms = SecondVariation(system, supports, state, loads, balance, basis)
        return Tangent(stiffness, basis, gradients, forms.work, forms.loss)


def position_noise(problem: Problem, positions: Floats) -> float:
    """Return what rounding the positions ``(n, 3)`` makes of the forces of nodes [N]."""
    size = max(problem.length, float(np.abs(positions).max()))
    return float(ROUND_OFF * np.finfo(float).eps * _stiffest(problem) * size)


@once
def _stiffest(problem: Problem) -> float:
    """Return the largest stiffness between two neighbouring nodes [N/m]."""
    stiffest = 0.0
    for part in (one for one in problem.sets if len(one.stiffness)):
        stiff = float(np.abs(part.stiffness[:, :3, :3]).max())
        spacing = 2.0 * float(part.half_lengths.min()) / part.order
        stiffest = max(stiffest, stiff / spacing)
    return stiffest
