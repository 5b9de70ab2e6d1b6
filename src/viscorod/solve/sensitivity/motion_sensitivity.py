"""How a motion changes with the arrays of the problem: forward with the time, and by the adjoint backward.

Both go through recorded steps again and linearise each exactly. They are derivatives of the computed motion, with its
steps as they are: what a parameter would change of the sizes of steps is an error of the integration, which is small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from viscorod.errors import InputError
from viscorod.solve.formulations.system import State
from viscorod.solve.sensitivity.array_changes import ArrayChanges
from viscorod.solve.sensitivity.equilibrium_sensitivity import actions_of
from viscorod.solve.sensitivity.step_linearisation import StepLinearisation, require_linearisable
from viscorod.solve.transient.recorded_steps import RecordedSteps
from viscorod.typing import Floats

__all__ = ["MotionChange", "MotionGradient", "Weights", "forward", "gradient"]

Weights = Callable[[int, State], "tuple[Floats, Floats] | None"]
"""Derivatives ``(n, 6)`` of a scalar by body increments of the poses, and by the twists, at the end of step ``k - 1``
(``k = 0`` is the start); None where the scalar does not look."""


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


def forward(
    steps: RecordedSteps,
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
    _require_known(steps)
    actions = actions_of(integrator.system)
    nodes = integrator.system.problem.size
    pose, twist = np.zeros((2, 6 * nodes, count))
    if start is not None:
        pose, twist = (part.reshape(count, -1).T.copy() for part in start)

    def here(time: float) -> MotionChange:
        shaped = (np.ascontiguousarray(part.T).reshape(count, nodes, 6) for part in (pose, twist))
        return MotionChange(time, integrator.state.copy(), *shaped)

    for stretch in range(steps.stretches):
        for step in steps.again(stretch):
            yield here(integrator.t)
            linear = StepLinearisation(integrator, actions, step.end, before=step.before)
            pose, twist = linear.forward(pose, twist, changes)
    yield here(integrator.t)


def gradient(steps: RecordedSteps, weights: Weights) -> MotionGradient:
    """Return the derivatives of a scalar that looks at the states at the ends of steps, by the adjoint.

    Every stretch between checkpoints is computed twice, and its linearisations are kept meanwhile; no more is.

    Args:
        steps: that were computed.
        weights: of the scalar; called once for every end of a step, and for the start.

    Raises:
        InputError: the model or the method has parts whose derivatives are not known here.
    """
    integrator = steps.integrator
    _require_known(steps)
    actions = actions_of(integrator.system)
    size = 6 * integrator.system.problem.size
    pose, twist = np.zeros((2, size, 1))
    total = ArrayChanges.none(integrator.system.problem, integrator.system.elements())

    def look(number: int, state: State) -> None:
        seen = weights(number, state)
        if seen is not None:
            pose[:, 0] += seen[0].ravel()
            twist[:, 0] += seen[1].ravel()

    for stretch in reversed(range(steps.stretches)):
        passed: list[tuple[int, State, StepLinearisation]] = []
        for step in steps.again(stretch):
            linear = StepLinearisation(integrator, actions, step.end, before=step.before)
            passed.append((step.number, integrator.state.copy(), linear))
        ends = [state for _, state, _ in passed[1:]] + [integrator.state.copy()]
        for (number, _, linear), end in zip(reversed(passed), reversed(ends), strict=False):
            look(number + 1, end)
            pose, twist, by_arrays = linear.backward(pose, twist)
            total.add(by_arrays)
        if stretch == 0 and passed:
            look(0, passed[0][1])
    return MotionGradient(total, pose.reshape(-1, 6), twist.reshape(-1, 6))


def _require_known(steps: RecordedSteps) -> None:
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
