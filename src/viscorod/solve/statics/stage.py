"""Stages of statics: which parts of loads and prescribed motions act at the end of each, and what each begins from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["Stage", "begin_at", "begin_stage", "end_stages"]


@dataclass(frozen=True)
class Stage:
    """Parts of everything at the end of a stage.

    Attributes:
        loads: of the model's loads, and last of the rest strains ``(loads + 1,)``.
        supports: of motions of supports ``(m, 6)``; motors: of joints ``(c,)``.
    """

    loads: Floats
    supports: Floats
    motors: Floats

    @classmethod
    def whole(cls, static: StaticSolver, loads: int, factor: float = 1.0) -> Stage:
        """Return the stage at whose end everything acts, ``factor`` times; ``loads`` are those of the model."""
        problem = static.system.problem
        return cls(
            np.full(loads + 1, factor),
            np.full((len(problem.supports.nodes), 6), factor),
            np.full(problem.joints.count, factor),
        )


def begin_stage(static: StaticSolver, stage: Stage, last: Stage | None, t: float, before: bool) -> None:
    """Let ``scale`` lead from the end of the ``last`` stage, None for the reference shape, to the end of a stage."""
    none = np.zeros_like(stage.loads)
    supports, constraints = static.supports, static.system.constraints
    if last is not None:
        supports.update(t, before, 1.0)
        constraints.update(t, before, 1.0)
        supports.stage = supports.target.copy(), stage.supports
        constraints.stage = constraints.driven.copy(), stage.motors
    else:
        supports.stage = np.zeros_like(stage.supports), stage.supports
        constraints.stage = constraints.stage[0], stage.motors
    static.loads.stage = (none if last is None else last.loads), stage.loads


def begin_at(static: StaticSolver, stage: Stage, state: State, t: float, before: bool) -> None:
    """Let loads act in full, while ``scale`` leads motions from what they are in ``state`` to the end of a stage."""
    supports, constraints = static.supports, static.system.constraints
    supports.stage = np.zeros_like(stage.supports), stage.supports
    supports.update(t, before, 1.0)
    supports.stage = supports.measured(state), stage.supports
    value, _, _ = constraints.measure(state)
    constraints.stage = (
        np.where(constraints.is_held, constraints.ball_motors.values(value), 0.0),
        stage.motors,
    )
    static.loads.stage = stage.loads, stage.loads


def end_stages(static: StaticSolver) -> None:
    """Let ``scale`` be the part of all loads and motions again."""
    constraints = static.system.constraints
    static.supports.stage = static.loads.stage = None
    constraints.stage = constraints.reference_gaps, np.ones(len(constraints.target))
