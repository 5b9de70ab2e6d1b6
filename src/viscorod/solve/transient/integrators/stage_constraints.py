"""Joints, springs and held strains of a collocation method, from step to step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.constraints.constraints import Constraints, JointState
from viscorod.solve.constraints.projection import with_allowed_velocities
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.transient.integrators.closed_states import Closed, ClosedStates, Wanted
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays
from viscorod.solve.transient.integrators.stage_data import Matrices
from viscorod.solve.transient.integrators.stage_systems import StageSystems
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


class StageConstraints:
    """Targets, predictions and records of joints, springs and held strains in a run.

    Args:
        constraints: of the system that is integrated; tableau: the method.

    Attributes:
        arrays: for the compiled step.
        drift: largest gap of positions over the length (or in rad, or strain), and of recorded velocities over the
            fastest one, so far.
    """

    unsaved = frozenset({"_closed", "_still"})

    def __init__(self, constraints: Constraints, tableau: Tableau) -> None:
        self.constraints, self.tableau = constraints, tableau
        constraints.ball_motors.moving = True
        self.arrays = ConstraintArrays.of(constraints, len(tableau.nodes))
        self._closed = ClosedStates(constraints)
        self._still = not (constraints.joints.motions or len(constraints.ball_motors.coordinates))
        self.drift = 0.0, 0.0
        c = constraints.joints.count
        self._multiplier = np.zeros(len(constraints.gap))  # at t
        self._force = np.zeros(c)  # of all coordinates, at t
        self._earlier = np.zeros(c)  # at the start of the last step
        self._past: tuple[Floats, float] | None = None  # multipliers and forces of the last step, its length
        self._whole: tuple[tuple[Floats, float], float] | None = None
        self._start = JointState(np.zeros(c), np.zeros(c), np.zeros(c))

    def turn_axes(self, t: float, state: State) -> bool:
        """Measure ball joints from where their motors are at the start of a step, if that is far; tell if any is."""
        constraints = self.constraints
        if not len(constraints.ball_motors.coordinates):
            return False
        constraints.update(t)
        turned = constraints.ball_motors.turn_axes()
        for mine, change in turned:
            place = constraints.arrays.place[mine]
            for forces, at in ((state.multiplier, place), (self._multiplier, place), (self._force, mine)):
                forces[at] = change @ forces[at]
        if turned:
            constraints.update(t)
            self.reset()
        return bool(turned)

    def prepare(self, i: int, t: float, *, before: bool) -> None:
        """Evaluate motors at stage ``i``, at time ``t`` [s]."""
        constraints, arrays = self.constraints, self.arrays
        if not self._still:
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
        self._past = self._whole = None

    def follow(self, whole: StageConstraints, place: float) -> None:
        """Let the next step be predicted by ``whole``, see ``predictor.Predictor.follow``."""
        self._whole = None if whole._past is None else (whole._past, place)

    def predict(self, h: float) -> None:
        """Write multipliers and spring forces of a step of ``h`` [s]: the last step's polynomials go on."""
        states = self.arrays.states
        now = np.concatenate([self._multiplier, self._force])
        past, place = (self._past, 1.0) if self._whole is None else self._whole
        if past is None:
            stages = np.broadcast_to(now, (len(states.multiplier), len(now)))
        else:
            known, length = past
            weights = self.tableau.polynomials(place + self.tableau.nodes * (h / length))
            stages = known[0] + weights @ (known[1:] - known[0])
        places = states.multiplier.shape[1]
        states.multiplier[:], states.carried[:] = stages[:, :places], stages[:, places:]

    def begin(self, state: State) -> None:
        """Take over a state for which joint coordinates have just been evaluated."""
        constraints = self.constraints
        constraints.track_angles()
        self._multiplier, self._force = state.multiplier.copy(), constraints.force.copy()
        self._start = constraints.state()

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
        constraints, states = self.constraints, self.arrays.states
        self._earlier, self._whole = self._force.copy(), None
        now = np.concatenate([self._multiplier, self._force])
        if len(self.tableau.nodes) > 1:
            stages = np.concatenate([states.multiplier, states.force], axis=1)
            self._past = np.concatenate([now[None], stages]), h
        state.multiplier = states.multiplier[-1].copy()
        position = float((np.abs(states.gap[-1]) / constraints.unit).max(initial=0.0))
        self.drift = max(self.drift[0], position), self.drift[1]
        if stage:
            constraints.value, constraints.rate = states.value.copy(), states.rate[-1].copy()
            constraints.force = states.force[-1].copy()
            self.begin(state)
        return constraints.function_energy()

    def with_allowed_velocities(self, snapshot: Snapshot, solve: Callable[[Floats], Floats]) -> Snapshot:
        """Return the ``snapshot`` at the end of a step with allowed velocities; ``solve`` is that of the step."""
        found, velocity = with_allowed_velocities(self.constraints, snapshot, solve)
        self.drift = self.drift[0], max(self.drift[1], velocity)
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
        constraints, exerted = self.constraints, self.arrays.states.force
        weights = self.tableau.polynomials(parts)
        forces = self._earlier + weights @ (exerted - self._earlier)
        wanted = Wanted(*np.empty((3, *forces.shape)))
        if self._still:
            wanted.target[:], wanted.rate[:] = constraints.target, constraints.target_rate
            wanted.near[:] = constraints.near
        else:
            for k, t in enumerate(times):
                constraints.update(t)
                wanted.target[k], wanted.rate[k] = constraints.target, constraints.target_rate
                wanted.near[k] = constraints.near
        closed = Closed(*states, *np.empty((2, *forces.shape)))
        constraints.between_steps = True
        left = self._closed.close(systems, wanted, closed)
        constraints.between_steps = False
        self.drift = max(self.drift[0], left), self.drift[1]
        if self._still:
            return JointState(closed.value, closed.rate, -forces)
        found = []
        for t, *fields in zip(times, closed.value, closed.rate, forces, strict=True):
            if len(constraints.ball_motors.coordinates):
                constraints.update(t)
            found.append(constraints.state_of(*fields))
        return JointState(*map(np.array, zip(*found, strict=True)))
