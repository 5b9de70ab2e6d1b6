"""States between the stages of a step, whose joints and held strains compiled code closes, one after the other.

The same as ``projection.close_gaps``, for many states: nodes are moved until the gaps are gone, then their velocities
are. At the ends of steps, where positions are closed, only velocities are. Only models with joints or held strains
compile it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.by_address import address_of, far
from viscorod.mechanics.compilation.compiled import kernel, part
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared
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


class Solver(NamedTuple):
    """Factors of a matrix with the rows of the constraints, with scales; nodes that do not move; kernels' addresses."""

    factors: Factors
    rows: Floats
    scales: Floats
    still: Integers
    measure: int
    substitute: int
    forces: int


class Closing(NamedTuple):
    """What states are closed with. It stands in memory (see ``mechanics.compilation.shared``).

    Attributes:
        joints, held: all coordinates and held strains, with their units and scales ``(places,)``.
        elements, points, work, force: of the strains, with their scratch.
        length: of the model [m].
        gap, right, change, gradients: scratch ``(places,)``, ``(6 N,)``, ``(n, 6)``, ``(c, 12)``.
        solver: of the changes by which gaps go.
    """

    joints: Joints
    held: HeldStrains
    unit: Floats
    scale: Floats
    elements: Elements
    points: GaussStates
    work: ElementWork
    force: Floats
    length: float
    gap: Floats
    right: Floats
    change: Floats
    gradients: Floats
    solver: Solver


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
def look(given: Closing, wanted: Wanted, states: Closed, k: int, rates: bool, strains: bool) -> float:
    """Measure the joints of state ``k``; write the gaps of positions, or of rates; return the largest in its unit."""
    joints, held, points, gap = given.joints, given.held, given.points, given.gap
    value, rate = states.value[k], states.rate[k]
    at = (states.r[k], states.q[k], states.twist[k], wanted.near[k], value, rate, given.gradients)
    _measure(given.solver.measure, (joints, *at))
    for i in range(gap.shape[0]):
        gap[i] = 0.0
    for c in range(joints.place.shape[0]):
        if joints.place[c] >= 0:
            gap[joints.place[c]] = rate[c] - wanted.rate[k, c] if rates else value[c] - wanted.target[k, c]
    if strains:
        one = (states.r[k : k + 1], states.q[k : k + 1], states.twist[k : k + 1])
        _forces(given.solver.forces, (given.elements, *one, points, given.work, given.force))
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
def find_change(given: Closing) -> None:
    """Solve for the change of all nodes by which the gaps go."""
    right, change, solver = given.right, given.change, given.solver
    f, size = solver.factors, change.shape[0]
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


@part
def close_poses(given: Closing, wanted: Wanted, states: Closed, k: int, strains: bool) -> float:
    """Move the nodes of state ``k`` until gaps are closed or do not fall any more; return the largest."""
    size, last = 0.0, np.inf
    for _ in range(MOST):
        size = look(given, wanted, states, k, False, strains)
        if size <= TOLERANCE or size > 0.9 * last:
            break
        last = size
        find_change(given)
        retract(states.r[k], states.q[k], given.change, states.r[k], states.q[k])
    return size


@part
def allow_velocities(given: Closing, wanted: Wanted, states: Closed, k: int, strains: bool) -> float:
    """Give state ``k`` velocities that the constraints allow; return what is left over that of the fastest node."""
    size, last = 0.0, np.inf
    for _ in range(MOST):
        speed = speed_of(given, wanted, states, k)
        size = look(given, wanted, states, k, True, strains) / speed
        if size <= TOLERANCE or size > 0.9 * last:
            break
        last = size
        find_change(given)
        for n in range(given.change.shape[0]):
            for a in range(6):
                states.twist[k, n, a] += given.change[n, a]
    return size


@kernel
def close_states(
    given: Closing, wanted: Wanted, states: Closed, first: int, count: int, poses: bool, strains: bool
) -> float:
    """Close some states, and give them velocities that the constraints allow.

    Args:
        given: a reference; wanted, states: of which ``count`` are closed, from the ``first`` on.
        poses: they are open, too; False: at the ends of steps only velocities are.
        strains: that are held are to be looked at.

    Returns:
        the largest gap that is left of positions, or where these are not open of velocities, over the fastest one.
    """
    left = 0.0
    for k in range(first, first + count):
        open_by = close_poses(given, wanted, states, k, strains) if poses else 0.0
        rate = allow_velocities(given, wanted, states, k, strains)
        size = open_by if poses else rate
        if not size <= left:
            left = size
    return left


class ClosedStates:
    """Closes states of one model.

    Args:
        constraints: of the system, with conditions that multipliers enforce.

    Attributes:
        closing: the kernel.
    """

    def __init__(self, constraints: Constraints) -> None:
        self.constraints = constraints
        self.closing = KnownTypes(close_states)
        self._measure, self._substitute = KnownTypes(measure), KnownTypes(substitute)
        self._forces = KnownTypes(internal_forces)
        self._shared: Shared[Closing] | None = None

    def close(self, systems: StageSystems, wanted: Wanted, states: Closed, *, poses: bool = True) -> float:
        """Close states with the real matrix of the last step; see :func:`close_states`."""
        systems.provide()
        strains, count = self.constraints.measures_strains, len(states.r)
        given = self.share(systems).argument
        left = float(self.closing.call(given, wanted, states, 0, count, poses, strains))
        systems.check()
        return left

    def share(self, systems: StageSystems) -> Shared[Closing]:
        """Return what states are closed with, in memory; the same as long as factors and elements are."""
        constraints, factors, known = self.constraints, systems.factors, self._shared
        elements = constraints.elements
        if known is not None:
            of = known.bundle
            if of.elements is elements and of.solver.factors is factors.real:
                return known
        problem, (points, work, force) = constraints.problem, constraints.evaluation
        n, c = problem.size, constraints.joints.count
        right, gradients = np.empty(6 * problem.pattern.size), np.empty((c, 12))
        still = np.array(systems.real.plan.without, dtype=np.int64)
        coordinates = (*np.empty((3, c)), gradients)
        where = np.empty((n, 3)), np.empty((n, 4)), np.empty((n, 6))
        several = tuple(field[None] for field in where)
        addresses = (
            address_of(self._measure, NOTHING, lambda: (constraints.arrays, *where, *coordinates)),
            address_of(self._substitute, NOTHING, lambda: (*factors.real, right)),
            address_of(self._forces, NOTHING, lambda: (elements, *several, points, work, force)),
        )
        solver = Solver(factors.real, factors.real_rows, factors.scales, still, *addresses)
        bundle = Closing(
            constraints.arrays,
            constraints.held,
            constraints.unit,
            constraints.scale,
            elements,
            points,
            work,
            force,
            problem.length,
            np.empty(len(constraints.gap)),
            right,
            np.empty((n, 6)),
            gradients,
            solver,
        )
        self._shared = Shared(bundle)
        return self._shared
