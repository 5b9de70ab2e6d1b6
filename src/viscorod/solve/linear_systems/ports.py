"""Inputs and outputs of small motions as columns and rows of their matrices."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.solve.constraints.moved_by_inputs import check_ground, moved_by, refused_input
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


def _base(solver: StaticSolver, small: SmallMotions, signal: MotionInput, k: int) -> Floats:
    """Return the motions of all supports that follow a rigid motion of the ground."""
    problem, state, supports = small.problem, small.state, solver.supports
    if not len(small.held_motions):
        raise refused_input(
            k, signal, "the model has no supports that could move", "give a force, or add a support"
        )
    check_ground(problem, supports, signal, k)
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
    held, targets = into
    constraints = solver.system.constraints
    moved = moved_by(small.problem, solver.supports, constraints, signal, k)
    if moved.support is not None:
        mine = (small.held_motions == (moved.support, signal.component)).all(axis=1)
        held[np.flatnonzero(mine)[0]] = 1.0
    else:
        row = int(np.searchsorted(constraints.used, constraints.arrays.place[moved.coordinate]))
        targets[row] = 1.0 / small.condition_scale[row]
