"""What is recorded of models with joints or held strains: states that are closed after a step, and the transpose.

Velocities at the end of a step, and poses and velocities within it, are corrected before they are recorded, by what is
in the range of ``A``: the solutions of the matrix of the step for gaps. With the gradient ``G`` of the gaps, a closed
state changes by ``dx' = dx - A dl``, so that ``G dx'`` and what the gap changes by with the poses, or with a number of
the model, add up to zero. A scalar with the weights ``w`` then has the weights ``w - G' m`` in the state that was
corrected, where ``A' (w - G' m) = 0``, and ``-m`` in the gaps. ``A`` itself is taken as constant: corrections are as
small as the error of a step, and what they change by with ``A`` is smaller still.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.linearised import Operators
from viscorod.mechanics.joints.joint_tangent import JointSlopes, add_joint_tangent
from viscorod.mechanics.rotations.adjoint_maps import adjoint_map
from viscorod.mechanics.rotations.nodal_motion import pose_differences
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.constraints.projection import close_gaps, project_velocities
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.sensitivity import stage_maps
from viscorod.solve.sensitivity.step_linearisation import StepLinearisation
from viscorod.typing import Floats, Integers

__all__ = ["ClosedState", "ClosedStates"]

ROUNDS = 40
"""Of the iteration for the weights of gaps."""
LEFT = 1e-12
"""Of the first weights, where it ends."""


class ClosedState(NamedTuple):
    """A recorded state that has been corrected.

    Attributes:
        t: its time [s]; before: whether joints are driven there as by the limit from the left.
        state: as it is recorded; moved: by which body increments ``(n, 6)``, None at the end of a step.
    """

    t: float
    before: bool
    state: State
    moved: Floats | None


class _Gradients(NamedTuple):
    """Derivatives of gaps by body increments.

    Attributes:
        place, nodes, rows: of joints: multipliers ``(h,)``, nodes ``(h, 2)`` and gradients ``(h, 2, 6)``.
        tangent: of the elements without section forces ``(b, 6, 6)``, None where no strains are held.
        held, members, strains: the same of held strains ``(k,)``, ``(k, nodes)`` and ``(k, nodes, 6)``.
    """

    place: Integers
    nodes: Integers
    rows: Floats
    tangent: Floats | None
    held: Integers | None = None
    members: Integers | None = None
    strains: Floats | None = None

    def forces(self, weights: Floats, nodes: int) -> Floats:
        """Return what multipliers ``(places,)`` do at all nodes ``(n, 6)``."""
        found = np.zeros((nodes, 6))
        np.add.at(found, self.nodes, weights[self.place][:, None, None] * self.rows)
        if self.held is not None and self.members is not None and self.strains is not None:
            np.add.at(found, self.members, weights[self.held][:, None, None] * self.strains)
        return found


class _Gaps(NamedTuple):
    """Weights of gaps and of their rates ``(places,)`` in a recorded state."""

    closed: ClosedState
    gap: Floats
    rate: Floats


class ClosedStates:
    """Closes recorded states as a motion does, and takes the weights of a scalar back through that.

    Args:
        linear: that has linearised the step of each state.

    Attributes:
        nodes: that joints and held strains act on, ascending.
    """

    def __init__(self, linear: StepLinearisation) -> None:
        system = linear.actions.system
        assert isinstance(system, GeometricSystem)
        self._system, self._linear = system, linear
        self._constraints: Constraints = system.constraints
        joints, held, elements = self._constraints.arrays, system.problem.held, system.elements()
        mine = joints.nodes[self._constraints.is_held]
        self.nodes: Integers = np.unique(
            np.concatenate([mine[mine >= 0].ravel(), elements.nodes[held.element].ravel()])
        )
        self._reference: Floats = np.zeros_like(elements.reference)
        self._weights: list[_Gaps] = []

    @property
    def reference(self) -> Floats:
        """Derivatives, so far, by the strains of the unstressed shape ``(e, points, 6)`` through the gaps."""
        return self._reference

    def at_end(self, state: State, t: float) -> ClosedState:
        """Return the recorded state at the end ``t`` [s] of a step."""
        found = state.copy()
        self._constraints.update(t, True)
        project_velocities(self._constraints, found, self._linear.solver.solve_real)
        return ClosedState(t, True, found, None)

    def within(self, state: State, t: float) -> ClosedState:
        """Return the recorded state at the time ``t`` [s] within a step, of the interpolated one."""
        found, moved = state.copy(), np.empty_like(state.twist)
        self._constraints.update(t)
        close_gaps(self._constraints, found, self._linear.solver.solve_real)
        pose_differences(state.r, state.q, found.r, found.q, moved)
        return ClosedState(t, False, found, moved)

    def back(self, closed: ClosedState, pose: Floats, twist: Floats) -> tuple[Floats, Floats]:
        """Return weights ``(n, 6)`` in a closed state as ones in the state that was corrected."""
        self._constraints.update(closed.t, closed.before)
        gradient = self._gradients(closed.state)
        places = 6 * self._system.problem.multipliers
        rate, gap = self._gap_weights(twist, gradient), np.zeros(places)
        twist = twist - gradient.forces(rate, len(twist))
        if rate.any():
            pose = pose - self._turning(closed.state, rate, gradient)
        if closed.moved is not None:
            gap = self._gap_weights(pose, gradient)
            pose = pose - gradient.forces(gap, len(pose))
            pose = pose - np.einsum("nji,nj->ni", adjoint_map(closed.moved), pose)
        held = self._system.problem.held
        np.add.at(self._reference, (held.element, held.point, held.component), gap[held.place])
        self._weights.append(_Gaps(closed, gap, rate))
        return pose, twist

    def value(self, other: Constraints) -> float:
        """Return what the gaps of another model in the same states come to, with their weights."""
        total = 0.0
        for closed, gap, rate in self._weights:
            other.near[:] = self._constraints.near
            other.update(closed.t, closed.before)
            total -= float(gap @ other.gaps(closed.state) + rate @ other.rate_gaps(closed.state))
        return total

    def _gap_weights(self, weights: Floats, gradient: _Gradients) -> Floats:
        """Return the weights ``m (places,)`` of gaps with ``A' (w - G' m) = 0``."""
        n, places = len(weights), 6 * self._system.problem.multipliers
        found, first = np.zeros(places), 0.0
        scale, right = self._constraints.scale, np.zeros((self._system.problem.pattern.size, 6))
        for _ in range(ROUNDS):
            right[:n] = weights - gradient.forces(found, n)
            change = scale * self._linear.solver.solve_real_transposed(right)[n:].ravel()
            change[self._constraints.idle] = 0.0
            found += change
            size = float(np.abs(change * self._constraints.unit).max(initial=0.0))
            first = first or size
            if size <= LEFT * first:
                break
        return found

    def _gradients(self, state: State) -> _Gradients:
        """Return the derivatives of all gaps by body increments, and the tangent of unstressed elements."""
        constraints, held = self._constraints, self._system.problem.held
        mine = np.flatnonzero(constraints.is_held)
        rows = constraints.measure(state)[2][mine].reshape(-1, 2, 6)
        nodes = constraints.arrays.nodes[mine]
        rows[nodes < 0] = 0.0
        if not len(held.place):
            return _Gradients(constraints.arrays.place[mine], nodes, rows, None)
        operators, K = self._linearised(state, np.zeros_like(self._reference))
        members = self._system.elements().nodes[held.element]
        strains = operators.strain[held.element, 6 * held.point + held.component].reshape(*members.shape, 6)
        whole = _Gradients(constraints.arrays.place[mine], nodes, rows, K)
        return whole._replace(held=held.place, members=members, strains=strains)

    def _linearised(self, state: State, stress: Floats) -> tuple[Operators, Floats]:
        """Return the operators of strains and the tangent ``(b, 6, 6)`` of elements with given section forces."""
        problem = self._system.problem
        operators = Operators.of(self._system.elements())
        K, C = np.zeros((2, len(problem.pattern.rows), 6, 6))
        self._system.linearise(state, np.zeros((problem.size, 6, 6)), stress, operators, K, C)
        return operators, K

    def _turning(self, state: State, rate: Floats, gradient: _Gradients) -> Floats:
        """Return how the rates of gaps times their weights change with body increments ``(n, 6)``, at these twists.

        With the weights as multipliers it is the work that the change of their forces does on the twists.
        """
        constraints, problem, held = self._constraints, self._system.problem, self._system.problem.held
        pattern, no_blocks = problem.pattern, np.zeros((0, 6, 6))
        K, C = np.zeros((2, 1, len(pattern.rows), 6, 6))
        if gradient.tangent is not None:
            stress = np.zeros_like(self._reference)
            stress[held.element, held.point, held.component] = rate[held.place] / held.weight
            K[0] = self._linearised(state, stress)[1] - gradient.tangent
        if constraints.joints.count:
            forces, none = np.zeros((2, constraints.joints.count))
            forces[constraints.is_held] = rate[constraints.arrays.place[constraints.is_held]]
            add_joint_tangent(
                constraints.arrays,
                state.r,
                state.q,
                state.twist,
                JointSlopes(constraints.near, forces, none, none),
                no_blocks,
                1.0,
                problem.length,
                np.ones_like(constraints.scale),
                K[0],
                no_blocks,
                constraints.operators,
            )
        twists, found = np.zeros((2, 1, pattern.size, 6))
        twists[0, : problem.size] = state.twist
        unused = np.zeros((2, 1, problem.size, 6))
        mass = np.zeros((1, problem.size, 6, 6))
        stage_maps.add_balances_transposed(pattern.rows, pattern.columns, K, C, mass, twists, found, *unused)
        return np.asarray(found[0, : problem.size])
