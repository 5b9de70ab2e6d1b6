"""Inputs and outputs of small motions as columns and rows of their matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.fields.definition import some_of
from viscorod.solve.linear_systems.small_motions import SmallMotions, global_axes
from viscorod.solve.problem.external_loads import ExternalLoads, load_count
from viscorod.solve.settings.signals import BASE, LoadInput, MotionInput, SignalInput
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["Inputs", "inputs_of"]


@dataclass(frozen=True)
class Inputs:
    """What unit inputs do to small motions.

    Attributes:
        signals: the inputs.
        force: on all nodes, body axes ``(6 n, inputs)``.
        held: motions of supports ``(held, inputs)``, or their derivatives by time.
        targets: of the conditions, in their unit rows ``(rows, inputs)``, or derivatives.
        derivative: how often the prescribed motion of each input is differentiated ``(inputs,)``; 0 of loads.
    """

    signals: tuple[SignalInput, ...]
    force: Floats
    held: Floats
    targets: Floats
    derivative: np.ndarray

    def motions_at(self, s: complex) -> np.ndarray:
        """Return by what the columns of prescribed motions are multiplied ``(inputs,)`` at ``s`` [1/s]."""
        return np.asarray([s ** -float(k) if k else 1.0 for k in self.derivative], dtype=complex)


def inputs_of(
    solver: StaticSolver, small: SmallMotions, signals: Sequence[SignalInput], first_load: int
) -> Inputs:
    """Return the inputs of small motions.

    Args:
        solver: of the model; small: its motions; signals: the inputs.
        first_load: number of the load of the first input that is one; those of others follow.

    Raises:
        InputError: nothing can be moved there, by name.
    """
    count = len(signals)
    conditions = 0 if small.gradients is None else small.gradients.shape[0]
    force, held = np.zeros((small.free.shape[0], count)), np.zeros((small.held.shape[1], count))
    targets = np.zeros((conditions, count))
    number = first_load
    for k, signal in enumerate(signals):
        if isinstance(signal, LoadInput):
            force[:, k] = _unit_load(small, number)
            number += 1
        elif signal.place == BASE:
            held[:, k] = _base(solver, small, signal, k)
        else:
            _prescribe(solver, small, signal, (held[:, k], targets[:, k]), k)
    derivative = np.array([s.derivative if isinstance(s, MotionInput) else 0 for s in signals])
    return Inputs(tuple(signals), force, held, targets, derivative)


def _unit_load(small: SmallMotions, number: int) -> Floats:
    """Return the generalised forces of a load with the factor 1 in the state of the small motions."""
    problem, state = small.problem, small.state
    given = {load: float(load == number) for load in range(load_count(problem))}
    external = np.zeros((problem.size, 6))
    ExternalLoads(problem).at(0.0, given=given).add(problem, (state.r, state.q), None, external)
    return external.ravel()


def _refused(k: int, signal: MotionInput, why: str, instead: str) -> InputError:
    return InputError(Fault(f"inputs[{k}]", repr(signal.label), why, instead))


def _base(solver: StaticSolver, small: SmallMotions, signal: MotionInput, k: int) -> Floats:
    """Return the motions of all supports that follow a rigid motion of the ground."""
    problem, state, supports = small.problem, small.state, solver.supports
    if not len(small.held_motions):
        raise _refused(
            k, signal, "the model has no supports that could move", "give a force, or add a support"
        )
    if supports.set.in_body.any():
        raise _refused(
            k, signal, "a support holds velocities along axes of the section", "use another support"
        )
    if problem.joints.count and (problem.joints.arrays.nodes < 0).any():
        raise _refused(
            k,
            signal,
            "a joint or spring connects the model to the ground, which does not move with the supports",
            "attach it to a body, and support that",
        )
    axis = np.eye(3)[signal.component % 3]
    turns, R = signal.component >= 3, global_axes(state)
    found = np.zeros(len(small.held_motions))
    for place, (support, motion) in enumerate(small.held_motions):
        node = supports.set.nodes[support]
        shift = np.cross(axis, state.r[node]) if turns else axis
        increment = np.concatenate([R[node].T @ shift, R[node].T @ (axis if turns else np.zeros(3))])
        Z = supports.free_directions(int(support), state)
        found[place] = np.linalg.solve(Z, increment)[motion]
    return found


def _prescribe(
    solver: StaticSolver,
    small: SmallMotions,
    signal: MotionInput,
    into: tuple[Floats, Floats],
    k: int,
) -> None:
    """Write a motion of one support, or of a held coordinate of a joint."""
    problem, supports = small.problem, solver.supports
    held, targets = into
    word = MOTIONS[signal.component]
    named = [i for i, name in enumerate(supports.set.names) if signal.place in name.split(" + ")]
    if named:
        mine = np.flatnonzero((small.held_motions == (named[0], signal.component)).all(axis=1))
        if not len(mine):
            raise _refused(
                k, signal, f"this support does not hold {word}", "give a motion that it holds, or a force"
            )
        held[mine[0]] = 1.0
        return
    constraints = solver.system.constraints
    joints = problem.joints
    if signal.place in joints.names:
        number = joints.names.index(signal.place)
        mine = np.flatnonzero(
            (joints.joint == number) & constraints.is_held & (np.array(joints.words) == word)
        )
        balls = np.isin(mine, constraints.ball_motors.coordinates)
        if not len(mine) or balls.any():
            raise _refused(
                k,
                signal,
                f"{word} of this joint is {'a motor about several axes' if len(mine) else 'not held'}",
                "give a motion that the joint holds or drives, or a moment",
            )
        row = int(np.searchsorted(constraints.used, constraints.arrays.place[mine[0]]))
        targets[row] = 1.0 / small.condition_scale[row]
        return
    places = [place for name in supports.set.names for place in name.split(" + ")]
    raise _refused(
        k,
        signal,
        "only supports and joints can be moved, and none has this name",
        f"give one of {some_of([BASE, *places, *joints.names])}, or a force",
    )
