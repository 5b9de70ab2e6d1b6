"""How a motion changes with the arrays of the problem: forward with the time, and by the adjoint backward.

Both go through recorded steps and linearise each exactly. They are derivatives of the computed motion, with its steps
as they are: what a parameter would change of the sizes of steps is an error of the integration, which is small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.elements.linearised import Operators
from viscorod.solve.formulations.system import State
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.equilibrium_sensitivity import actions_of
from viscorod.solve.sensitivity.known_models import require_linearisable
from viscorod.solve.sensitivity.stage_records import StageRecord, Weights
from viscorod.solve.sensitivity.step_linearisation import StepLinearisation
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.recorded_steps import RecordedSteps
from viscorod.typing import Floats

__all__ = ["KeptSteps", "Look", "MotionChange", "MotionGradient", "Seen", "forward", "gradient"]

MEMORY = 2**28
"""Bytes of stages that are kept."""


class Look(NamedTuple):
    """Derivatives of a scalar by what it looks at in a step, and at its end.

    Attributes:
        pose, twist: by body increments of the poses and by the twists at the end ``(n, 6)``.
        stages: by the twists of the stages ``(s, n, 6)``; start_pose, start_twist: by the start ``(n, 6)``; None: zero.
    """

    pose: Floats
    twist: Floats
    stages: Floats | None = None
    start_pose: Floats | None = None
    start_twist: Floats | None = None


Seen = Callable[[int, State, "StageRecord | None"], "Look | None"]
"""What a scalar sees at the end of step ``k - 1``, in this state, and within the step; ``k = 0`` is the start, without
a step. None where it does not look."""


class MotionChange(NamedTuple):
    """Changes of the state at one time [s], of poses (body increments) and twists ``(k, n, 6)`` per parameter."""

    time: float
    state: State
    pose: Floats
    twist: Floats


class MotionGradient(NamedTuple):
    """Derivatives of a scalar by the arrays, and by poses (body increments) and twists ``(n, 6)`` of the start."""

    arrays: ArrayChanges
    pose: Floats
    twist: Floats


class KeptSteps(RecordedSteps):
    """Recorded steps whose stages are kept as well, of as many of the last steps as memory allows.

    Args:
        integrator: that computes; every: accepted steps between two checkpoints; memory: bytes of stages.
    """

    def __init__(self, integrator: Collocation, every: int = 32, memory: int = MEMORY) -> None:
        super().__init__(integrator, every)
        self._kept: dict[int, StageRecord] = {}
        self._left = memory

    def accept(self) -> None:
        """Take a step; see ``Integrator``."""
        _, end, before = self._calls[-1]
        record = StageRecord.of(self.integrator, end, before=before)
        self._kept[len(self.times) - 1] = record
        self._left -= record.size
        while self._left < 0 and len(self._kept) > 1:
            self._left += self._kept.pop(next(iter(self._kept))).size
        super().accept()

    def stages(self, stretch: int) -> list[tuple[int, StageRecord]]:
        """Return the stages of all steps of a stretch, with their numbers; computed again where they are not kept."""
        last = self._checkpoints[stretch + 1][1] if stretch + 1 < self.stretches else len(self.times) - 1
        numbers = range(self._checkpoints[stretch][1], last)
        if all(number in self._kept for number in numbers):
            return [(number, self._kept[number]) for number in numbers]
        return [
            (step.number, StageRecord.of(self.integrator, step.end, before=step.before))
            for step in self.again(stretch)
        ]


def forward(
    steps: KeptSteps,
    changes: Sequence[ArrayChanges],
    start: tuple[Floats, Floats] | None = None,
) -> Iterator[MotionChange]:
    """Yield how the states at the ends of all steps change with parameters, the start first.

    Args:
        steps: that were computed.
        changes: of the arrays of the problem with each of the ``k`` parameters.
        start: changes of poses and twists at the start ``(k, n, 6)``; none by default.

    Raises:
        InputError: the model or the method has parts whose derivatives are not known here.
    """
    integrator, count = steps.integrator, len(changes)
    require_known(steps)
    if integrator.dashpots is not None:
        raise InputError(
            "forward derivatives are not known with Maxwell branches; take the adjoint, or differences"
        )
    final, linear = integrator.state.copy(), StepLinearisation(integrator)
    nodes = integrator.system.problem.size
    pose, twist = np.zeros((2, 6 * nodes, count))
    if start is not None:
        pose, twist = (part.reshape(count, -1).T.copy() for part in start)

    def here(time: float, state: State) -> MotionChange:
        shaped = (np.ascontiguousarray(part.T).reshape(count, nodes, 6) for part in (pose, twist))
        return MotionChange(time, state.copy(), *shaped)

    for stretch in range(steps.stretches):
        for _, step in steps.stages(stretch):
            yield here(step.t, step.state)
            linear.linearise(step)
            pose, twist = linear.forward(pose, twist, changes)
    yield here(steps.times[-1], final)


def gradient(
    steps: KeptSteps,
    seen: Seen,
    forces: Callable[[StageRecord, Floats, Floats, Floats], None] | None = None,
    *,
    loads: bool = True,
    linear: StepLinearisation | None = None,
) -> MotionGradient:
    """Return the derivatives of a scalar that looks at the motion, by the adjoint.

    Args:
        steps: that were computed.
        seen: of the scalar; called once for every end of a step, the last one first, and for the start.
        forces: called with every step, with the derivatives of the scalar by changes of its balances ``(s, N, 6)``,
            with the rows of supports projected, and as they are, and with those by its corrected end twists ``(n, 6)``.
        loads: whether derivatives by the factors of the loads are wanted; they are zero if not.
        linear: that every step is to be linearised by before the scalar looks at it; by default one is made.

    Raises:
        InputError: the model or the method has parts whose derivatives are not known here.
    """
    integrator = steps.integrator
    require_known(steps)
    first, problem = linear is not None, integrator.system.problem
    linear = linear or StepLinearisation(integrator)
    total = ArrayChanges.none(problem, integrator.system.elements())
    none = np.zeros((problem.size, 6))
    pose, twist, end, looked = none, none, integrator.state.copy(), False
    dashpot: Floats | None = None
    shape = (len(linear.tableau.nodes), problem.size, 6)
    for stretch in reversed(range(steps.stretches)):
        for number, step in reversed(steps.stages(stretch)):
            if first:
                linear.linearise(step)
            look = seen(number + 1, end, step)
            end = step.state
            if look is None and not looked:
                continue
            looked, look = True, look or Look(none, none)
            twists = np.zeros(shape) if look.stages is None else look.stages.copy()
            if not first:
                linear.linearise(step)
            ended = twist + look.twist
            by_pose, by_twist = linear.look_at_end(pose + look.pose, ended)
            twists[-1] += by_twist
            back = linear.look_back(Weights(by_pose, twists, dashpot))
            lifted = linear.lifted(back.forces)
            linear.arrays.add_gradient(lifted, total, loads=loads)
            if back.branches is not None:
                dashpot = back.branches.start
                for mine, its in (
                    (total.branches, back.branches.branches),
                    (total.times, back.branches.times),
                    (total.reference, back.branches.reference),
                ):
                    np.add(mine, its, out=mine)
            if forces is not None:
                forces(step, back.forces, lifted, ended)
            pose, twist = back.pose, back.twist
            pose = pose if look.start_pose is None else pose + look.start_pose
            twist = twist if look.start_twist is None else twist + look.start_twist
    look = seen(0, end, None) or Look(none, none)
    pose, twist = pose + look.pose, twist + look.twist
    if dashpot is not None:  # dashpots begin with the strains of the start
        pose = pose + _by_strains(integrator, end, dashpot.sum(axis=0))
        np.subtract(total.reference, dashpot.sum(axis=0), out=total.reference)
    return MotionGradient(total, pose, twist)


def _by_strains(integrator: Collocation, state: State, weights: Floats) -> Floats:
    """Return the derivatives by body increments ``(n, 6)`` of the strains in a state times ``(e, points, 6)``."""
    system, problem = actions_of(integrator.system).system, integrator.system.problem
    elements = system.elements()
    operators, blocks = Operators.of(elements), np.zeros((2, len(problem.pattern.rows), 6, 6))
    still, none = np.zeros((problem.size, 6, 6)), np.zeros_like(weights)
    system.linearise(state, still, none, operators, *blocks)
    pushed = np.einsum("er,erk->ek", weights.reshape(len(weights), -1), operators.strain)
    found = np.zeros((problem.size, 6))
    np.add.at(found, elements.nodes, pushed.reshape(*elements.nodes.shape, 6))
    return found


def require_known(steps: RecordedSteps) -> None:
    """Refuse steps whose derivatives are not known here.

    Raises:
        InputError: of the model, of the method, or since velocities were corrected after a jump.
    """
    integrator = steps.integrator
    require_linearisable(integrator)
    corrected = integrator.system.constraints.rows > 0 or len(integrator.supports.partial) > 0
    if corrected and steps.restarts:
        raise InputError(
            f"loads or motions jump at t = {steps.restarts[0]:.6g} s: derivatives of motions are not known there where "
            "joints, held strains or supports that leave a place free in part correct velocities; take differences of "
            "two runs, or end the motion there"
        )
