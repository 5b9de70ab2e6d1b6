"""A model as a collocation method sees it: what works at its stages, its forces at one instant, its frozen Jacobian.

The arrays are those of the compiled step (see ``stage_data``); they are allocated once for a run.
"""

from __future__ import annotations

import operator
from typing import Any

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
from viscorod.mechanics.elements.internal_force import GaussStates, energies
from viscorod.mechanics.elements.intrinsic_element import StrainMotion
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays
from viscorod.mechanics.nodes import inertia
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.transient.integrators import jacobian, step_task
from viscorod.solve.transient.integrators.collocation_step import place_predicted, try_step
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays
from viscorod.solve.transient.integrators.loop_data import OF_MIDDLE, OF_START, OLD
from viscorod.solve.transient.integrators.predictor import Predictor
from viscorod.solve.transient.integrators.record_kernels import Kept
from viscorod.solve.transient.integrators.stage_constraints import StageConstraints
from viscorod.solve.transient.integrators.stage_dashpots import StageDashpots
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices, Stages, StepStart, Work
from viscorod.solve.transient.integrators.stage_systems import StageSystems
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.solve.transient.integrators.step_addresses import step_calls
from viscorod.solve.transient.integrators.step_recorder import StepRecorder
from viscorod.solve.transient.integrators.step_task import Ends, StepAccount, StepCalls, StepTask
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

SCRATCH = frozenset(
    {"_ad", "_numbers", "_points", "_reached", "_shared", "_start", "_step_points", "actions"}
)
"""What every step computes anew."""

_NO_STRAINS, _NO_LINKS, _NO_BRANCHES = StrainMotion.none(), ConstraintArrays.none(), MaxwellArrays.none()


class StageModel:
    """What a collocation method works on; :class:`~.collocation.Collocation` takes steps with it.

    Args:
        system, supports: the model.
        tableau: the method.
        newton_tolerance: error left by the iteration (displacement over model length, rotation in rad).
    """

    iterations = 12
    """Allowed iterations per step."""

    def __init__(
        self, system: System, supports: SupportState, tableau: Tableau, newton_tolerance: float
    ) -> None:
        self.system, self.supports, self.tableau = system, supports, tableau
        self.newton_tolerance = newton_tolerance
        problem = system.problem
        self.t = 0.0
        self.state = State.reference(problem)
        self.kinetic = self.elastic = self.work = self.loss = self.outside = self.actuator = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        stages = len(tableau.nodes)
        self._last = stages - 1
        self.body = body = Discretisation.of(problem, system.elements(), supports)
        self.actions = StepActions(system, supports, body, stages)
        driven = system.imposed.changes
        self.stages = Stages.of(stages, body, driven=driven)
        self.forces = system.element_forces(body.elements, stages)
        if driven:
            self.forces.take_rest(self.stages.rest, self.stages.rest_rate)
        self.predictor = Predictor(body, self.stages, tableau)
        self.stage_constraints = (
            StageConstraints(system.constraints, tableau) if problem.constrained else None
        )
        memory = system.relaxation
        self.dashpots = (
            None if memory is None else StageDashpots(memory, body, tableau, system.gauss_indices())
        )
        plan = problem.plan_without(supports.set.nodes[supports.complete])  # their poses are prescribed
        self.systems = StageSystems(body, system.matrix.scales, tableau, plan, self.dashpots)
        self.recorder = StepRecorder(
            body,
            self.actions.motion,
            self.stages,
            tableau,
            supports,
            system.gauss_indices(),
            self.stage_constraints,
            self.systems,
        )
        self.ends = Ends.none()
        self.matrices = Matrices.of(body)
        self.scratch = Work.of(body, stages)
        carried = len(problem.held.place) > 0 or problem.relaxing or driven
        self._points = GaussStates.of(body.elements, 1, carried=carried)  # at t
        self._stress = np.zeros(body.elements.reference.shape)  # at t
        self._force = np.zeros((problem.size, 6))  # what accelerates the nodes at t
        self._end_rate = np.zeros((problem.size, 6))  # of the twists at t
        self._ad = np.zeros((problem.size, 6, 6))
        self.account = StepAccount.of(problem.size, stages)
        self._reaction = np.zeros((len(body.complete), 6))  # of the supports at t, along their axes
        self._kept = Kept(
            self._force, self._reaction, self._stress, self.predictor.X, self.predictor.stresses
        )
        self._step_points = GaussStates(
            self.stages.strain, self.stages.strain_rate, self.stages.section_force, self.stages.stress
        )
        n = problem.size
        self._start = StepStart(np.zeros((n, 3)), np.zeros((n, 4)), np.zeros((n, 6)), self._force)
        self._numbers = np.zeros(step_task.NUMBERS)
        self._shared: Shared[StepTask] | None = None
        self._reached = State(self.stages.r[-1], self.stages.q[-1], self.stages.twist[-1])  # last stage
        self.trying, self.projection = KnownTypes(try_step), KnownTypes(jacobian.project)
        self.placing = KnownTypes(place_predicted)
        self.adjoints, self.inertia_terms = KnownTypes(jacobian.adjoint), KnownTypes(jacobian.add_inertia)
        self._have_jacobian, self._fresh_jacobian = False, OLD
        self._factor_step = self._end = self._step = 0.0
        self._rate = 1.0

    @property
    def unsaved(self) -> frozenset[str]:
        """What ``saved_state`` leaves out: where strains follow from poses, the system remembers nothing."""
        problem, remembers = self.system.problem, self.system.imposed.changes
        if problem.constrained or problem.relaxing or remembers or self.forces.motion is not None:
            return SCRATCH
        return SCRATCH | {"forces", "system"}

    def step_arguments(self, h: float) -> tuple[Any, ...]:
        """Return what the compiled step takes, for a step of ``h`` [s] from the present state."""
        numbers, start, state = self._numbers, self._start, self.state
        numbers[step_task.H], numbers[step_task.TOLERANCE] = h, self.newton_tolerance
        numbers[step_task.RATE], numbers[step_task.ITERATIONS] = self._rate, self.iterations
        start.r[:], start.q[:], start.twist[:] = state.r, state.q, state.twist
        return (self.share().argument,)

    @property
    def task(self) -> StepTask:
        """All that a step reads and writes."""
        return self.share().bundle

    def share(self) -> Shared[StepTask]:
        """Return what steps work on, which seldom changes, in memory."""
        links, dashpots, strains = self.stage_constraints, self.dashpots, self.forces.motion
        parts = (
            self.body,
            self.tableau,
            self._start,
            self._numbers,
            self.actions.motion,
            self.actions.stage_loads,
            self.systems.factors,
            self.matrices,
            self.stages,
            self._step_points,
            self.account,
            self.scratch,
            self.ends,
            _NO_STRAINS if strains is None else strains,
            _NO_LINKS if links is None else links.arrays,
            _NO_BRANCHES if dashpots is None else dashpots.step,
        )
        known = self._shared
        if known is None or not all(map(operator.is_, parts, known.bundle)):
            known = self._shared = Shared(StepTask(*parts, StepCalls()))
            known.put("calls", step_calls(known))
        return known

    def prepare_step(self, end: float, before: bool) -> None:
        """Evaluate loads and prescribed motions at all stages of the step to ``end``."""
        self.actions.look_within(self.t, end)
        for i, c in enumerate(self.tableau.nodes):
            last = i == self._last
            t = end if last else self.t + c * (end - self.t)
            self.actions.prepare(i, t, before=before and last)
            if self.stage_constraints is not None:
                self.stage_constraints.prepare(i, t, before=before and last)
        if self.system.imposed.changes:
            self._prepare_rest(end, before=before)

    def _prepare_rest(self, end: float, *, before: bool) -> None:
        """Evaluate rest strains at all stages of the step to ``end``, and the rates of the polynomial through them."""
        stages, imposed, h = self.stages, self.system.imposed, end - self.t
        for i, c in enumerate(self.tableau.nodes):
            last = i == self._last
            stages.rest[i] = imposed.driven(end if last else self.t + c * h, before and last)
        gained = stages.rest - imposed.driven(self.t)
        stages.rest_rate[:] = np.einsum("ij,jegk->iegk", self.tableau.derivative, gained) / h

    def _evaluate_state(self, t: float, state: State, *, before: bool, acceleration: Floats) -> None:
        """Make ``state`` the one at ``t``: forces, energies and reactions there.

        Args:
            acceleration: rates of the twists ``(n, 6)``, of which the reactions at supported nodes contain inertia.
        """
        supports, body, points = self.supports, self.body, self._points
        self.t, self.state = t, state
        internal, external = self.scratch.vector, self.scratch.change
        self.system.impose_rest(Imposed(1.0, t, before))
        self.forces.evaluate(state, points, internal)
        constraints = self.system.constraints
        if self.stage_constraints is not None:
            constraints.add_forces(state, internal)
            self.stage_constraints.begin(state)
        external.fill(0.0)
        self.actions.add_loads(t, state, external, before=before)
        self.evaluations += 1
        residual = internal - external
        inertia.add_coriolis(body.mass, state.twist, residual)
        np.negative(residual, out=self._force)
        residual += np.einsum("nij,nj->ni", body.mass, acceleration)
        supports.impose(state, residual, self.system.matrix, tangent=False)
        self.kinetic = inertia.kinetic_energy(body.mass, state.twist)
        elastic, dissipated = np.empty((2, 1))  # not the powers of the last step, which states between need
        energies(body.elements, points.strain, points.strain_rate, elastic, dissipated)
        self.elastic = float(elastic[0]) + constraints.energy
        if self.dashpots is not None:
            memory, strain = self.dashpots.memory, points.strain[0]
            memory.strain[:] = strain
            self.elastic += memory.energy(strain)
        self._reaction[:] = supports.reaction
        self._stress[:] = points.stress[0]
        self.recorder.record_state(
            state, points, supports.global_reactions(state), self.kinetic, self.elastic
        )

    def _whole_strain(self, stage: int) -> Floats:
        """Return the strains ``(e, points, 6)`` at a stage, with the rest strains that change."""
        stages = self.stages
        if not len(stages.rest):
            return np.asarray(stages.strain[stage])
        return np.asarray(stages.strain[stage] + stages.rest[stage])

    def _predicted(self, h: float) -> tuple[State, Floats]:
        """Return the middle stage of a step of ``h`` [s], and the stresses there, as they are predicted."""
        stages, middle = self.stages, self._last // 2
        self.placing.call(*self.step_arguments(h))
        state = State(stages.r[middle], stages.q[middle], stages.twist[middle], self.state.multiplier)
        return state, stages.stress[middle]

    def renew_jacobian(self, h: float, *, at_start: bool) -> None:
        """Linearise about the middle of a step of ``h`` [s], whose stages are predicted, or about its start.

        That is where too little is known of the middle: no step precedes, the method has one stage, or iterations about
        a middle have not converged, whose prediction is wild then.
        """
        state, stress = (self.state, self._stress) if at_start else self._predicted(h)
        matrices, body = self.matrices, self.body
        self.adjoints.call(state.twist, self._ad)
        matrices.K.fill(0.0)
        matrices.C.fill(0.0)
        self.forces.linearise(state, self._ad, stress, matrices.operators, matrices.K, matrices.C)
        if self.stage_constraints is not None:
            self.system.constraints.pace = self.tableau.real / h
            self.stage_constraints.linearise(state, self._ad, body.elements, matrices)
        self.actions.add_load_stiffness(self.t, state, self._ad, matrices.K, matrices.C)
        matrices.mass[:] = body.mass
        self.inertia_terms.call(
            body.mass,
            state.twist,
            self._ad,
            matrices.K,
            matrices.C,
            body.pattern.diagonal,
            matrices.adjoint,
            self.scratch.square,
        )
        self.actions.move_supports(self.t, before=False)
        self.projection.call(
            body.supports,
            self.supports.target,
            self._reaction,
            state.r,
            state.q,
            body.pattern,
            matrices.K,
            matrices.C,
            matrices.mass,
            matrices.directions,
            self.scratch.square[0],
        )
        self._have_jacobian, self._fresh_jacobian = True, OF_START if at_start else OF_MIDDLE
        self._factor_step = 0.0
        self.jacobians += 1

    def forget_jacobian(self) -> None:
        """Let the next step begin with a new Jacobian."""
        self._have_jacobian = False

    def factors_of(self, h: float) -> bool:
        """Return whether the factors are those of a step of ``h`` [s]."""
        return abs(h - self._factor_step) <= 1e-9 * h
