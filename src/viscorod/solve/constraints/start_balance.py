"""Accelerations with which a motion starts, and the forces of joints and held strains that belong to them.

Poses and velocities tell what springs and sections do, but not what a multiplier does: that follows from the
accelerations, which have to keep the conditions (index reduction, Hairer and Wanner 1996, VII.1)

    M a + G^T lambda = f,    G a = -d(G)/dt x1 + d(target rate)/dt

with the twists x1 and their rates a. The second line is the rate of the rates of all gaps along the motion. Quotients
of fourth order tell it, for all kinds of joints and both formulations alike.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.model.actions.time_function import TimeFunction
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.typing import Floats

__all__ = ["StartBalance"]

WAY = 3e-4
"""Way between the places of a quotient, over the length (or in rad): 1e-15 is left out, 1e-12 is round-off."""
PLACES = (-2.0, -1.0, 1.0, 2.0)
WEIGHTS = (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0)
SETTLED = 1e-10
"""Change of accelerations and multipliers, as a part of them, that passes for none."""
MOST = 8
"""Solutions with the same factors: the first is right where strains follow from poses, others where they are states."""


class StartBalance:
    """The accelerations of one state, whose poses and velocities are those that the conditions allow.

    Args:
        system, supports: the model, with motors and supports at the time of the state; their poses are prescribed.
        t: that time [s]; state: whose multipliers are found.
        strain: of a formulation that keeps strains as states ``(e, points, 6)``, None where they follow from poses.

    Attributes:
        acceleration: rates of the twists ``(n, 6)``, of what supports prescribe until :meth:`solve` finds the others.
    """

    def __init__(
        self, system: System, supports: SupportState, t: float, state: State, strain: Floats | None = None
    ) -> None:
        self.system, self.supports, self.t, self.state, self.strain = system, supports, t, state, strain
        self._motors = [(c, *_course(motion, t)) for c, motion in system.constraints.joints.motions]
        self._motions = [(k, i, *_course(motion, t)) for k, i, motion in supports.set.motions]
        quickest = max((abs(course[-1]) for course in (*self._motors, *self._motions)), default=0.0)
        unit = min(system.problem.length, 1.0)
        self._step = WAY / max(system.constraints.speed(state), np.sqrt(quickest / unit), WAY)
        self.acceleration = np.zeros_like(state.twist)
        if supports.moving:
            self.acceleration[supports.set.nodes[supports.complete]] = supports.twist_rate
        if len(supports.partial):
            nodes = supports.set.nodes[supports.partial]
            self.acceleration[nodes] = self._rate(self._allowed_twists)[nodes]

    def solve(self, unbalanced: Callable[[Floats], Floats]) -> None:
        """Find the accelerations and the multipliers; conditions that contradict each other are left to the steps.

        Args:
            unbalanced: returns what accelerates the nodes with the present multipliers ``(n, 6)``, gyroscopic forces
                among them. It is told the accelerations that are known so far, at last all of them.
        """
        system, state, acceleration = self.system, self.state, self.acceleration
        mass = system.problem.mass
        force = unbalanced(acceleration)
        if not system.problem.constrained and not len(self.supports.partial):
            return
        try:
            self._factorise()
        except SingularMatrixError:
            return
        for _ in range(MOST):
            residual = np.empty((system.problem.pattern.size, 6))
            residual[: len(mass)] = np.einsum("nij,nj->ni", mass, acceleration) - force
            gaps = system.constraints.scale * self._rate(self._gap_rates)
            residual[len(mass) :] = gaps.reshape(-1, 6)
            self.supports.impose(state, residual, system.matrix, tangent=False)
            increment = system.matrix.solve(-self.supports.unbalanced(residual))
            change, more = increment[: len(mass)], system.multiplier_change(increment)
            if _is_small(change, acceleration) and _is_small(more, state.multiplier):
                return
            acceleration += change
            state.multiplier += more
            force = unbalanced(acceleration)

    def _factorise(self) -> None:
        """Factorise the mass with the rows and columns of multipliers, where supports leave nodes free."""
        system = self.system
        system.assemble_mass(self.state)
        none = np.zeros((system.problem.pattern.size, 6))
        self.supports.impose(self.state, none, system.matrix, tangent=True)
        system.matrix.factorise()

    def _rate(self, measured: Callable[[State, float], Floats]) -> Floats:
        """Return how fast changes what is measured in a state, at a time after the present one [s]."""
        total: Floats | float = 0.0
        for place, weight in zip(PLACES, WEIGHTS, strict=True):
            after, state = place * self._step, self.state.copy()
            retract(state.r, state.q, after * state.twist, state.r, state.q)
            state.twist += after * self.acceleration
            total = total + weight / self._step * measured(state, after)
        return np.asarray(total)

    def _allowed_twists(self, state: State, after: float) -> Floats:
        """Return the twists ``(n, 6)`` that supports which hold nodes in part make of those of a state."""
        supports = self.supports
        for k, component, *course in self._motions:
            supports.target[k, component], supports.rate[k, component] = _after(after, *course)
        supports.project_twists(state)
        supports.update(self.t)
        return state.twist

    def _gap_rates(self, state: State, after: float) -> Floats:
        """Return the rates of the gaps ``(places,)`` in a state."""
        constraints, strain = self.system.constraints, self.strain
        for c, *course in self._motors:
            constraints.target[c], constraints.target_rate[c] = _after(after, *course)
        constraints.ball_motors.follow(constraints.target, constraints.target_rate)
        constraints.near[constraints.is_held] = constraints.target[constraints.is_held]
        kept = None
        if strain is not None and constraints.strains_as_states is not None:
            kept = strain.copy()
            strain += after * constraints.strains_as_states(self.state)[1][0]
        found = constraints.rate_gaps(state)
        if strain is not None and kept is not None:
            strain[:] = kept
        constraints.update(self.t)
        return found


def _course(motion: TimeFunction, t: float) -> tuple[float, float, float]:
    """Return value, rate and acceleration of a motor or a support just after ``t`` [s]."""
    return motion.value(t), motion.rate(t), motion.acceleration(t)


def _after(after: float, value: float, rate: float, acceleration: float) -> tuple[float, float]:
    """Return value and rate at a time [s] at which the acceleration is still the same."""
    return value + after * (rate + 0.5 * after * acceleration), rate + after * acceleration


def _is_small(change: Floats, whole: Floats) -> bool:
    """Return whether a change passes for round-off."""
    return bool(np.abs(change).max(initial=0.0) <= SETTLED * np.abs(whole).max(initial=0.0))
