"""Joints, springs and held strains of a problem in action: their forces, tangents and losses."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.mechanics.elements.held_strains import add_held_strains
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.joints.joint_forces import JointLaws, JointStates, SpringOperators, joint_forces
from viscorod.mechanics.joints.joint_tangent import JointSlopes, add_joint_tangent
from viscorod.solve.constraints.held_coordinates import HeldCoordinates
from viscorod.solve.linear.matrix import unit_of
from viscorod.solve.problem.law_callbacks import NUMBERS, LawCallbacks
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.formulations.system import State


class JointState(NamedTuple):
    """Values [m, rad], rates and forces [N, N m] of all coordinates of joints ``(c,)``.

    A force is what the joint exerts on its first place along (about) the coordinate.
    """

    value: Floats
    rate: Floats
    force: Floats


class Constraints(HeldCoordinates):
    """Couplings of nodes beside elements, with their forces: joints, springs and held strains.

    Args:
        problem: of which they are part; elements: returns all of its elements, called for held strains only.

    Attributes:
        pace: rate [1/s] with the square of which inertia counts in the present matrix.
        scale: of multipliers and their rows ``(places,)``.
        value, rate, force: of all coordinates, as they were measured last ``(c,)``; energy: of springs [J].
    """

    def __init__(self, problem: Problem, elements: Callable[[], Elements]) -> None:
        super().__init__(problem, elements)
        c = self.joints.count
        self.pace = 0.0
        self.laws = LawCallbacks(self.joints.laws)
        self.functions = JointLaws(self.laws.callback.address, np.zeros(NUMBERS))
        self.scale = np.ones(6 * problem.multipliers)
        self.operators = SpringOperators.of(c)
        self.force, self.rate, self.value = np.zeros(c), np.zeros(c), np.zeros(c)
        self.energy = 0.0
        self._stiffness, self._damping = self.arrays.stiffness.copy(), self.arrays.damping.copy()
        self._earlier = np.zeros(c)

    def is_strained(self, reference: State, t: float, *, before: bool = True) -> bool:
        """Return whether open joints, motors away from 0 or springs keep the ``reference`` shape from being at rest."""
        self.update(t, before)
        if np.abs(self.driven).max(initial=0.0) > 0.0 or self.open_joints():
            return True
        return self.springs_push(reference)

    def springs_push(self, state: State) -> bool:
        """Return whether springs exert forces in a ``state``."""
        self.add_forces(state, np.zeros_like(state.twist))
        return bool(np.any(self.force[~self.is_held] != 0.0))

    def add_forces(self, state: State, internal: Floats) -> None:
        """Add the forces of joints and springs in a state to ``internal (n, 6)``; measure all coordinates."""
        if self.joints.count == 0:
            return
        rate, force = np.zeros((1, self.joints.count)), np.zeros((1, self.joints.count))
        energy, power = np.zeros(1), np.zeros(1)
        states = JointStates(
            near=self.near,
            target=self.target[None],
            multiplier=state.multiplier[None],
            carried=force,
            value=self.value,
            rate=rate,
            force=force,
            energy=energy,
            power=power,
            gap=self.gap[None],
            gradient=np.empty(12),
        )
        joint_forces(
            self.arrays,
            self.functions,
            states,
            state.r[None],
            state.q[None],
            state.twist[None],
            internal[None],
        )
        self.laws.callback.check()
        self.force, self.rate = force[0], rate[0]
        self.energy = float(energy[0]) + self.function_energy()

    def function_energy(self) -> float:
        """Return the energy [J] of springs that are Python functions, at the values measured last."""
        law = self.arrays.law
        return sum(self.laws.energy(int(law[c]), float(self.value[c])) for c in np.flatnonzero(law >= 0))

    def track_angles(self) -> None:
        """Take the present values of angles as those that the next ones are nearest to, beyond a full turn too."""
        free = ~self.is_held
        self.near[free] = self.value[free]

    def add_tangent(
        self,
        state: State,
        rate_map: Floats,
        K: Floats,
        C: Floats,
        *,
        moving: bool,
        held: tuple[Integers, Floats] | None,
    ) -> None:
        """Add to the blocks ``K`` (and ``C``, see ``add_joint_tangent``) after :meth:`add_forces` in the same state.

        Args:
            held: orders of all elements and the change of their strains, see ``add_held_strains``.
        """
        a = self.arrays
        for c in np.flatnonzero(a.law >= 0):
            law = int(a.law[c])
            self._stiffness[c], self._damping[c] = self.laws.slopes(
                law, float(self.value[c]), float(self.rate[c])
            )
        slopes = JointSlopes(self.near, self.force, self._stiffness, self._damping)
        self._add(state, slopes, rate_map if moving else rate_map[:0], self._stiffest(K), K, C, held)

    @property
    def slopes(self) -> tuple[Floats, Floats]:
        """Derivatives of the forces of springs by coordinates and rates ``(c,)``, at the last tangent."""
        return self._stiffness.copy(), self._damping.copy()

    def add_rows(self, state: State, K: Floats, held: tuple[Integers, Floats] | None) -> None:
        """Add the rows and columns of multipliers, and nothing else, to the blocks ``K``."""
        none, no_blocks = np.zeros(self.joints.count), np.zeros((0, 6, 6))
        slopes = JointSlopes(self.near, none, none, none)
        self._add(state, slopes, no_blocks, self._largest(K), K, no_blocks, held)

    def _add(
        self,
        state: State,
        slopes: JointSlopes,
        rate_map: Floats,
        stiff: float,
        K: Floats,
        C: Floats,
        held: tuple[Integers, Floats] | None,
    ) -> None:
        """Add joints with the given forces and slopes, held strains, and ones for idle multipliers."""
        diagonal, n = self.problem.pattern.diagonal, self.problem.size
        length = unit_of(self.problem.length)
        if self.joints.count:
            add_joint_tangent(
                self.arrays,
                state.r,
                state.q,
                state.twist,
                slopes,
                rate_map,
                stiff,
                length,
                self.scale,
                K,
                C,
                self.operators,
            )
        if held is not None:
            orders, B = held
            add_held_strains(self.held, orders, stiff, length, B, self.scale, K)
        for place in self.idle:
            K[diagonal[n + place // 6], place % 6, place % 6] = 1.0

    def _stiffest(self, K: Floats) -> float:
        """Return the largest diagonal entry of all nodes with their inertia, or of springs, or 1."""
        return (
            self._largest(K, self.pace * self.pace) or float(np.abs(self._stiffness).max(initial=0.0)) or 1.0
        )

    def _largest(self, K: Floats, inertia: float = 0.0) -> float:
        """Return the largest diagonal entry of all nodes, displacements measured in the unit of the matrix."""
        problem = self.problem
        found = np.abs(np.einsum("kii->ki", K[problem.pattern.diagonal[: problem.size]]))
        found = found + inertia * np.einsum("kii->ki", problem.mass)
        return float((found * ([unit_of(problem.length) ** 2] * 3 + [1.0] * 3)).max())

    def state(self) -> JointState:
        """Return what was measured last."""
        return self.state_of(self.value, self.rate, self.force)

    def state_of(self, value: Floats, rate: Floats, force: Floats) -> JointState:
        """Return coordinates, rates and the forces that they exert ``(c,)`` as motors and users count them."""
        motors = self.ball_motors
        return JointState(motors.values(value), motors.rates(value, rate), -motors.forces(value, force))

    def loss(self, duration: float) -> float:
        """Return the energy [J] lost to dampers since the last call, ``duration`` [s] ago; 0 starts counting anew.

        The rate is the mean one of the step, as for sections.
        """
        if self.joints.count == 0:
            return 0.0
        total = 0.0
        if duration > 0.0:
            rate = (self.value - self._earlier) / duration
            total = (
                float(np.sum(np.where(self.arrays.law < 0, self.arrays.damping, 0.0) * rate**2)) * duration
            )
            for c in np.flatnonzero(self.arrays.law >= 0):
                total += self.laws.power(int(self.arrays.law[c]), float(rate[c])) * duration
        self._earlier[:] = self.value
        return total

    def motor_power(self) -> float:
        """Return the power [W] that motors put in, in the state of the last measurement."""
        if not self.joints.motions:
            return 0.0
        return -float(np.sum(self.force[self.is_held] * self.target_rate[self.is_held]))
