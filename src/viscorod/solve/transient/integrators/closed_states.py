"""States between the stages of a step, whose joints and held strains compiled code closes, one after the other.

The same as ``projection.close_gaps``, for many states: nodes are moved until the gaps are gone, then their velocities
are. Only models with joints or held strains compile it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.by_address import address_of, far
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.held_strains import HeldStrains
from viscorod.mechanics.elements.internal_force import Elements, ElementWork, GaussStates, internal_forces
from viscorod.mechanics.joints.joint_forces import Joints, measure
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.constraints.projection import MOST, TOLERANCE
from viscorod.solve.linear.factors import Factors
from viscorod.solve.linear.substitution import substitute
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.stage_systems import StageSystems
from viscorod.typing import Floats, Integers

__all__ = ["ClosedStates"]

_measure, _substitute, _forces = (
    far(measure, NOTHING),
    far(substitute, NOTHING),
    far(internal_forces, NOTHING),
)


class Closing(NamedTuple):
    """What states are closed with.

    Attributes:
        joints, held: all coordinates and held strains, with their units and scales ``(places,)``.
        elements, points, work, force: of the strains, with their scratch; ``measures``: they are to be looked at.
        length: of the model [m].
        gap, right, change, gradients: scratch ``(places,)``, ``(6 N,)``, ``(n, 6)``, ``(c, 12)``.
    """

    joints: Joints
    held: HeldStrains
    unit: Floats
    scale: Floats
    elements: Elements
    points: GaussStates
    work: ElementWork
    force: Floats
    measures: float
    length: float
    gap: Floats
    right: Floats
    change: Floats
    gradients: Floats


class Solver(NamedTuple):
    """Factors of a matrix with the rows of the constraints, with scales; nodes that do not move; kernels' addresses."""

    factors: Factors
    rows: Floats
    scales: Floats
    still: Integers
    measure: int
    substitute: int
    forces: int


class Wanted(NamedTuple):
    """Where coordinates of joints are to be in each state, their rates, and what angles are near to ``(k, c)``."""

    target: Floats
    rate: Floats
    near: Floats


class Closed(NamedTuple):
    """States ``(k, n, ...)``, which are closed; coordinates of joints there, and their rates ``(k, c)``."""

    r: Floats
    q: Floats
    twist: Floats
    value: Floats
    rate: Floats


@part
def look(given: Closing, solver: Solver, wanted: Wanted, states: Closed, k: int, rates: bool) -> float:
    """Measure the joints of state ``k``; write the gaps of positions, or of rates; return the largest in its unit."""
    joints, held, points, gap = given.joints, given.held, given.points, given.gap
    value, rate = states.value[k], states.rate[k]
    at = (states.r[k], states.q[k], states.twist[k], wanted.near[k], value, rate, given.gradients)
    _measure(solver.measure, (joints, *at))
    for i in range(gap.shape[0]):
        gap[i] = 0.0
    for c in range(joints.place.shape[0]):
        if joints.place[c] >= 0:
            gap[joints.place[c]] = rate[c] - wanted.rate[k, c] if rates else value[c] - wanted.target[k, c]
    if given.measures != 0.0:
        one = (states.r[k : k + 1], states.q[k : k + 1], states.twist[k : k + 1])
        _forces(solver.forces, (given.elements, *one, points, given.work, given.force))
        for i in range(held.place.shape[0]):
            e, g, a = held.element[i], held.point[i], held.component[i]
            gap[held.place[i]] = points.strain_rate[0, e, g, a] if rates else points.strain[0, e, g, a]
    largest = 0.0
    for i in range(gap.shape[0]):
        size = abs(gap[i]) / given.unit[i]
        if not size <= largest:
            largest = size
    return largest


@part
def find_change(given: Closing, solver: Solver) -> None:
    """Solve for the change of all nodes by which the gaps go."""
    right, change, f = given.right, given.change, solver.factors
    size = change.shape[0]
    for i in range(6 * size):
        right[i] = 0.0
    for i in range(given.gap.shape[0]):
        right[6 * size + i] = -given.scale[i] * given.gap[i] * solver.rows[6 * size + i]
    solving = (f.values, f.fronts, f.vector, f.integers, f.rows, f.groups, f.members, f.rest)
    _substitute(solver.substitute, (*solving, right))
    for k in range(size):
        for a in range(6):
            change[k, a] = right[6 * k + a] * solver.scales[6 * k + a]
    for m in range(solver.still.shape[0]):
        for a in range(6):
            change[solver.still[m], a] = 0.0


@part
def speed_of(given: Closing, wanted: Wanted, states: Closed, k: int) -> float:
    """Return the largest velocity, or angular velocity times the length, of a state or of motors, over the length."""
    linear = angular = 0.0
    for n in range(states.twist.shape[1]):
        for a in range(3):
            linear = max(linear, abs(states.twist[k, n, a]))
            angular = max(angular, abs(states.twist[k, n, 3 + a]))
    for c in range(wanted.rate.shape[1]):
        angular = max(angular, abs(wanted.rate[k, c]))
    return max(linear, angular * given.length, 1e-300) / given.length


@kernel
def close_states(given: Closing, solver: Solver, wanted: Wanted, states: Closed) -> float:
    """Close states, and give them velocities that the constraints allow; return the largest gap that is left."""
    left = 0.0
    for k in range(states.r.shape[0]):
        size, last = 0.0, np.inf
        for _ in range(MOST):
            size = look(given, solver, wanted, states, k, False)
            if size <= TOLERANCE or size > 0.9 * last:
                break
            last = size
            find_change(given, solver)
            retract(states.r[k], states.q[k], given.change, states.r[k], states.q[k])
        if not size <= left:
            left = size
        last = np.inf
        for _ in range(MOST):
            speed = speed_of(given, wanted, states, k)
            size = look(given, solver, wanted, states, k, True) / speed
            if size <= TOLERANCE or size > 0.9 * last:
                break
            last = size
            find_change(given, solver)
            for n in range(given.change.shape[0]):
                for a in range(6):
                    states.twist[k, n, a] += given.change[n, a]
    return left


class ClosedStates:
    """Closes states of one model.

    Args:
        constraints: of the system, with conditions that multipliers enforce.
    """

    def __init__(self, constraints: Constraints) -> None:
        self.constraints = constraints
        self._kernel = KnownTypes(close_states)
        self._measure, self._substitute = KnownTypes(measure), KnownTypes(substitute)
        self._forces = KnownTypes(internal_forces)
        self._known: Closing | None = None

    def close(self, systems: StageSystems, wanted: Wanted, states: Closed) -> float:
        """Close states with the real matrix of the last step; return the largest gap that is left, in its unit."""
        systems.provide()
        given = self._given()
        factors, plan = systems.factors, systems.real.plan
        still = np.array(plan.without, dtype=np.int64)
        one = states.r[0], states.q[0], states.twist[0], wanted.near[0], states.value[0], states.rate[0]
        several = states.r[:1], states.q[:1], states.twist[:1]
        found = (
            address_of(self._measure, NOTHING, lambda: (given.joints, *one, given.gradients)),
            address_of(self._substitute, NOTHING, lambda: (*factors.real, given.right)),
            address_of(
                self._forces,
                NOTHING,
                lambda: (given.elements, *several, given.points, given.work, given.force),
            ),
        )
        solver = Solver(factors.real, factors.real_rows, factors.scales, still, *found)
        left = float(self._kernel.call(given, solver, wanted, states))
        systems.check()
        return left

    def _given(self) -> Closing:
        """Return what states are closed with, in arrays that are made once."""
        constraints, known = self.constraints, self._known
        if known is not None and known.measures == float(constraints.measures_strains):
            return known._replace(elements=constraints.elements)
        problem, points, work, force = constraints.problem, *constraints.evaluation
        self._known = Closing(
            constraints.arrays,
            constraints.held,
            constraints.unit,
            constraints.scale,
            constraints.elements,
            points,
            work,
            force,
            float(constraints.measures_strains),
            problem.length,
            np.empty(len(constraints.gap)),
            np.empty(6 * problem.pattern.size),
            np.empty((problem.size, 6)),
            np.empty((constraints.joints.count, 12)),
        )
        return self._known
