"""A model as generalised-alpha sees it: the balance of momenta at one instant, and its solution for the poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.nodes import inertia
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.problem.external_loads import ExternalLoads
from viscorod.solve.statics.newton import Outcome, SingularMatrixError, worst_node
from viscorod.solve.transient.integrators.balance_iteration import BalanceIteration
from viscorod.solve.transient.integrators.contract import OUTCOME, StepReport
from viscorod.typing import Floats

STEP_FACTOR = 1.0
"""Error that a step may have over ``tolerance^1.5``: that of a step is of order 3, that of the motion of order 2."""


@dataclass(frozen=True)
class Coefficients:
    """The three numbers of the method for a spectral radius ``rho`` at infinite frequency in [0, 1]."""

    mass: float
    force: float
    gamma: float

    @classmethod
    def of(cls, rho: float) -> Coefficients:
        """Return those of order 2 with optimal dissipation (Jansen et al. 2000, convention of Bruels and Cardona)."""
        return cls(
            mass=(3.0 * rho - 1.0) / (2.0 * (1.0 + rho)), force=rho / (1.0 + rho), gamma=1.0 / (1.0 + rho)
        )


@dataclass(frozen=True)
class Relation:
    """A step's linear relations: ``twist = slope increment + constant`` and ``wrench = slope momentum + history``."""

    slope: float
    constant: Floats
    history: Floats


@dataclass(frozen=True)
class Solution:
    """A solved balance: report, state, the increment that led there and the momentum before it."""

    report: StepReport
    state: State
    increment: Floats
    momentum_before: Floats


class MomentumModel:
    """What :class:`~.generalized_alpha.GeneralizedAlpha`, which has the same arguments, takes steps with."""

    def __init__(
        self,
        system: GeometricSystem,
        supports: SupportState,
        *,
        spectral_radius: float,
        tolerance: float | None = None,
        newton_tolerance: float = 1e-9,
        iterations: int = 12,
    ) -> None:
        self.system = system
        self.supports = supports
        self.loads = ExternalLoads(system.problem)
        self.coefficients = Coefficients.of(spectral_radius)
        self.tolerance = tolerance
        self.newton_tolerance = newton_tolerance
        self.iterations = iterations
        self.step_tolerance = None if tolerance is None else STEP_FACTOR * tolerance**1.5
        n = system.problem.size
        self.t = 0.0
        self.state = State.reference(system.problem)
        self.kinetic = self.elastic = self.work = self.loss = self.outside = self.actuator = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        self.drift = 0.0, 0.0
        self.branch_loss: Floats = np.zeros(len(system.problem.relaxation_times))
        self._power = self._lost_power = self._end = self._step = 0.0
        self._trial: tuple[Relation, Solution]
        self._start: tuple[State, Snapshot]
        self._snapshot: Snapshot
        self._twist_mean: Floats = np.zeros((n, 6))  # xi
        self._momentum: Floats = np.zeros((n, 6))
        self._wrench: Floats = np.zeros((n, 6))
        self._wrench_mean: Floats = np.zeros((n, 6))  # b
        self._rate: Floats = np.zeros((n, 6))  # of the twists, for predicting
        self._map = np.zeros((n, 6, 6))
        self._held = supports.set.nodes[supports.complete]
        self._retract, self._add_rate = KnownTypes(retract), KnownTypes(inertia.add_momentum_rate)
        self.newton = BalanceIteration(system, supports, self._map)

    def _solve(self, t: float, before: bool, relation: Relation, increment: Floats) -> Solution:
        """Solve the balance at time ``t`` for the poses reached by ``increment`` (predicted) from the last state."""
        system, supports, old = self.system, self.supports, self.state
        supports.update(t, before)
        system.constraints.update(t, before)
        if system.relaxation is not None:
            system.relaxation.set_step(t - self.t)
        loads = self.loads.at(t, before)
        increment[self._held] = 0.0
        new = old.copy()
        system.constraints.pace = relation.slope
        newton = self.newton
        newton.begin(old, new, increment, (relation.slope, relation.constant, relation.history), loads)
        imbalance, node, size = 0.0, 0, 0.0
        try:
            code, size = newton.run(self.newton_tolerance, self.iterations)
            verdict = OUTCOME[code]
        except SingularMatrixError as error:
            verdict, node = Outcome.SINGULAR, error.row // 6
        count = newton.count
        if verdict not in (Outcome.CONVERGED, Outcome.SINGULAR):
            unbalanced = supports.unbalanced(newton.residual)[: system.problem.size]
            imbalance, node = worst_node(unbalanced, system.problem.length)
        self.evaluations += count
        self.factorisations += count
        self.jacobians += count
        report = StepReport(verdict, count, size, imbalance, node)
        if report.converged:
            self._update_state(new, increment, relation)
        else:
            self._restore_state()
        return Solution(report, new, increment, self._momentum)

    def _update_state(self, new: State, increment: Floats, relation: Relation) -> None:
        """Write the poses and twists that belong to an increment."""
        self._retract.call(self.state.r, self.state.q, increment, new.r, new.q)
        np.multiply(increment, relation.slope, out=new.twist)
        new.twist += relation.constant
        self.supports.prescribe(new)

    def _residual(self, new: State, relation: Relation, *, tangent: bool) -> Floats:
        system = self.system
        residual = system.residual()
        self._add_rate.call(
            system.problem.mass,
            new.r,
            new.q,
            new.twist,
            relation.slope,
            relation.history,
            self._map,
            tangent,
            residual,
            system.matrix.blocks,
            system.matrix.pattern.diagonal,
        )
        return residual

    def _take_solution(self, solution: Solution, relation: Relation, end: float) -> None:
        """Take a solution as the new state; leaves forces and reactions there in system and supports."""
        system, supports, new = self.system, self.supports, solution.state
        system.assemble(new, self.loads.last, None, tangent=False, moving=True)
        system.reset_stress()
        system.constraints.track_angles()
        supports.impose(new, self._residual(new, relation, tangent=False), system.matrix, tangent=False)
        momentum = np.empty_like(self._momentum)
        self.kinetic = inertia.momenta(system.problem.mass, new.r, new.q, new.twist, momentum)
        self._momentum = momentum
        self._wrench = relation.slope * momentum + relation.history
        self._rate = (new.twist - self.state.twist) / (end - self.t)
        self.state = new
        self.t = end

    def _project_velocities(self) -> None:
        """Make the velocities of partly supported nodes exactly those that are allowed."""
        if len(self.supports.partial):
            state = self.state
            self.supports.project_twists(state)
            mass = self.system.problem.mass
            self.kinetic = inertia.momenta(mass, state.r, state.q, state.twist, self._momentum)

    def _restore_state(self) -> None:
        """Put system and supports back to the last accepted state."""
        if self.system.relaxation is not None:
            self.system.relaxation.set_step(0.0)
        self.supports.update(self.t, False)
        self.system.constraints.update(self.t)
        self.system.assemble(self.state, self.loads.at(self.t), None, tangent=False, moving=True)
        self.system.reset_stress()

    def _work_rate(self) -> float:
        """Return the present power of loads and moving supports [W]."""
        loads = float(np.sum(self.system.external * self.state.twist)) + self.system.dissipated
        return loads + self.supports.power(self.state) + self.system.constraints.motor_power()

    def _actuator_work(self, began: float) -> float:
        """Return the work [J] of what changed the rest strains since ``began`` [s]: their change times mean forces."""
        imposed = self.system.imposed
        if not imposed.changes:
            return 0.0
        positions, places = self.system.gauss_positions(), self.system.gauss_indices()
        change = imposed.driven(self._end, True) - imposed.driven(began)
        mean = 0.5 * (self._snapshot.section_force + self.system.gauss_points().section_force)
        return -float(np.einsum("g,gi,gi", positions.length, mean, change.reshape(-1, 6)[places]))
