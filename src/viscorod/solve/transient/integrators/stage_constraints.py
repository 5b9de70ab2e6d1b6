"""Joints, springs and held strains of a collocation method, from step to step."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.constraints.constraints import Constraints, JointState
from viscorod.solve.constraints.projection import with_allowed_velocities
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.transient.integrators.closed_states import Closed, ClosedStates, Wanted
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays
from viscorod.solve.transient.integrators.link_memory import LinkMemory, through_stages
from viscorod.solve.transient.integrators.stage_data import Matrices
from viscorod.solve.transient.integrators.stage_systems import StageSystems
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


class StageConstraints:
    """Targets, predictions and records of joints, springs and held strains in a run.

    Args:
        constraints: of the system that is integrated; tableau: the method.

    Attributes:
        arrays: for the compiled step; memory: from step to step, in arrays that stay.
        closed_states: closes what is recorded.
        still: nothing drives the joints.
    """

    unsaved = frozenset({"closed_states", "still"})

    def __init__(self, constraints: Constraints, tableau: Tableau) -> None:
        self.constraints, self.tableau = constraints, tableau
        constraints.ball_motors.moving = True
        self.arrays = ConstraintArrays.of(constraints, len(tableau.nodes))
        self.closed_states = ClosedStates(constraints)
        self.still = not (constraints.joints.motions or len(constraints.ball_motors.coordinates))
        c = constraints.joints.count
        self.memory = LinkMemory.of(len(tableau.nodes), len(constraints.gap), c)
        self._length = 0.0  # of the last step [s], 0 if it predicts nothing
        self._whole: tuple[LinkMemory, float, float] | None = None  # of what step, its length, place in it
        self._middle = np.zeros(
            len(constraints.gap)
        )  # multipliers there, of the last step of the midpoint rule
        self._since = 0.0  # time since then [s], 0 if there was none
        self._start = JointState(np.zeros(c), np.zeros(c), np.zeros(c))

    @property
    def drift(self) -> tuple[float, float]:
        """Largest gap of positions, and of recorded velocities, see ``LinkMemory``."""
        position, velocity = self.memory.drift.tolist()
        return position, velocity

    def turn_axes(self, t: float, state: State) -> bool:
        """Measure ball joints from where their motors are at the start of a step, if that is far; tell if any is."""
        constraints = self.constraints
        if not len(constraints.ball_motors.coordinates):
            return False
        constraints.update(t)
        turned = constraints.ball_motors.turn_axes()
        for mine, change in turned:
            place = constraints.arrays.place[mine]
            for forces, at in (
                (state.multiplier, place),
                (self.memory.multiplier, place),
                (self.memory.force, mine),
            ):
                forces[at] = change @ forces[at]
        if turned:
            constraints.update(t)
            self.reset()
        return bool(turned)

    def prepare(self, i: int, t: float, *, before: bool) -> None:
        """Evaluate motors at stage ``i``, at time ``t`` [s]."""
        constraints, arrays = self.constraints, self.arrays
        if not self.still:
            constraints.update(t, before)
        arrays.states.target[i], arrays.target_rate[i] = constraints.target, constraints.target_rate

    def prepare_end(self, t: float, end: float, *, before: bool) -> None:
        """Evaluate motors at the end of a step of the midpoint rule, and their mean rates."""
        constraints, arrays = self.constraints, self.arrays
        constraints.update(t)
        first = constraints.target.copy()
        constraints.update(end, before)
        arrays.end_target[:] = constraints.target
        arrays.target_rate[0] = (constraints.target - first) / (end - t)

    def reset(self) -> None:
        """Forget the last step: it does not predict the next one."""
        self._length, self._whole, self._since = 0.0, None, 0.0

    def follow(self, whole: StageConstraints, place: float) -> None:
        """Let the next step be predicted by ``whole``, see ``predictor.Predictor.follow``."""
        self._whole = None if whole._length == 0.0 else (whole.memory, whole._length, place)

    def predict(self, h: float) -> None:
        """Write multipliers and spring forces of a step of ``h`` [s]: the last step's polynomials go on."""
        states = self.arrays.states
        known, length, place = (self.memory, self._length, 1.0) if self._whole is None else self._whole
        if length == 0.0:
            states.multiplier[:], states.carried[:] = known.multiplier, known.force
            return
        places = place + self.tableau.nodes * (h / length)
        states.multiplier[:] = through_stages(self.tableau, places, known.multipliers)
        states.carried[:] = through_stages(self.tableau, places, known.forces)

    def begin(self, state: State) -> None:
        """Take over a state for which joint coordinates have just been evaluated."""
        constraints, memory = self.constraints, self.memory
        constraints.track_angles()
        memory.multiplier[:], memory.force[:] = state.multiplier, constraints.force
        memory.value[:], memory.rate[:] = constraints.value, constraints.rate
        self._start = constraints.state()

    def take_back(self, state: State, length: float) -> None:
        """Go on from where the compiled loop has come to, after a step of ``length`` [s]."""
        constraints, memory = self.constraints, self.memory
        state.multiplier = memory.multiplier.copy()
        constraints.value, constraints.rate = memory.value.copy(), memory.rate.copy()
        constraints.force = memory.force.copy()
        self._length, self._start = length, constraints.state()

    def linearise(self, state: State, ad: Floats, elements: Elements, matrices: Matrices) -> None:
        """Add the constraints to the matrices of the Jacobian, whose operators are known (see ``Collocation``)."""
        constraints = self.constraints
        constraints.add_forces(state, np.zeros_like(state.twist))
        constraints.add_tangent(
            state,
            ad,
            matrices.K,
            matrices.C,
            moving=True,
            held=(elements.order, matrices.operators.strain) if len(constraints.held.place) else None,
        )

    def end_step(self, state: State, h: float, *, stage: bool) -> float:
        """Take the end of a step of ``h`` [s]; return the energy [J] of springs that are Python functions.

        Args:
            state: at the end, whose multipliers are completed.
            stage: the end is the last stage, whose multipliers are known; else they are those of the middle.
        """
        constraints, states, memory = self.constraints, self.arrays.states, self.memory
        self._whole = None
        memory.multipliers[0], memory.forces[0] = memory.multiplier, memory.force
        memory.multipliers[1:], memory.forces[1:] = states.multiplier, states.force
        if len(self.tableau.nodes) > 1:
            self._length = h
        state.multiplier = states.multiplier[-1].copy() if stage else self._extrapolated(h)
        position = float((np.abs(states.gap[-1]) / constraints.unit).max(initial=0.0))
        memory.drift[0] = max(memory.drift[0], position)
        if stage:
            constraints.value, constraints.rate = states.value.copy(), states.rate[-1].copy()
            constraints.force = states.force[-1].copy()
            self.begin(state)
        return constraints.function_energy()

    def _extrapolated(self, h: float) -> Floats:
        """Return multipliers at the end of a step of ``h`` [s]: on the line through two middles, or start and middle.

        Those of the middle alone are of first order there.
        """
        middle, earlier = self.arrays.states.multiplier[-1].copy(), self._middle
        if self._since == 0.0:
            earlier = self.memory.multiplier
        slope = (middle - earlier) / (self._since + 0.5 * h)
        self._middle, self._since = middle, 0.5 * h
        return np.asarray(middle + 0.5 * h * slope)

    def with_allowed_velocities(self, snapshot: Snapshot, systems: StageSystems) -> Snapshot:
        """Return the ``snapshot`` at the end of a step with allowed velocities; ``systems``: of the step."""
        constraints, drift = self.constraints, self.memory.drift
        if constraints.strains_as_states is not None:  # which poses do not tell
            found, left = with_allowed_velocities(constraints, snapshot, systems.solve_real)
        else:
            state = snapshot.state.copy()
            given = constraints.target, constraints.target_rate, constraints.near
            where = state.r, state.q, state.twist, *np.empty((2, constraints.joints.count))
            wanted, closed = (
                Wanted(*(field[None] for field in given)),
                Closed(*(field[None] for field in where)),
            )
            left = self.closed_states.close(systems, wanted, closed, poses=False)
            joints = None if snapshot.joints is None else snapshot.joints._replace(rate=closed.rate[0])
            found = snapshot._replace(state=state, joints=joints)
        drift[1] = max(drift[1], left)
        return found

    def state(self) -> JointState:
        """Return the joints at the present time."""
        return self._start

    def between(
        self,
        states: tuple[Floats, Floats, Floats],
        parts: Floats,
        times: Floats,
        systems: StageSystems,
    ) -> JointState:
        """Return the joints ``(k, c)`` in ``states``, which are closed: poses and twists ``(k, n, ...)``.

        Args:
            parts, times: of the last step, and the times [s] of the states.
            systems: of the step.
        """
        constraints, drift = self.constraints, self.memory.drift
        forces = through_stages(self.tableau, parts, self.memory.forces)
        wanted = Wanted(*np.empty((3, *forces.shape)))
        if self.still:
            wanted.target[:], wanted.rate[:] = constraints.target, constraints.target_rate
            wanted.near[:] = constraints.near
        else:
            for k, t in enumerate(times):
                constraints.update(t)
                wanted.target[k], wanted.rate[k] = constraints.target, constraints.target_rate
                wanted.near[k] = constraints.near
        closed = Closed(*states, *np.empty((2, *forces.shape)))
        constraints.between_steps = True
        left = self.closed_states.close(systems, wanted, closed)
        constraints.between_steps = False
        drift[0] = max(drift[0], left)
        if self.still:
            return JointState(closed.value, closed.rate, -forces)
        found = []
        for t, *fields in zip(times, closed.value, closed.rate, forces, strict=True):
            if len(constraints.ball_motors.coordinates):
                constraints.update(t)
            found.append(constraints.state_of(*fields))
        return JointState(*map(np.array, zip(*found, strict=True)))
