"""Loads that grow with a factor from an equilibrium on, beside what acts in full throughout."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium_search import Search
from viscorod.analyses.static_stages import constant_stage
from viscorod.errors import InputError, SolveError
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.stage import Stage, begin_stage

__all__ = ["begin_growing", "move", "unloaded"]


def begin_growing(discrete: DiscreteModel, constant: Sequence[str], nothing: str) -> State:
    """Return the equilibrium under what is ``constant`` by its names, with the stage of all else begun.

    Raises:
        InputError: the model has none of such a name, nothing holds it, or, in the words ``nothing``, nothing grows.
        SolveError: there is no such equilibrium.
    """
    static = discrete.static
    whole = Stage.whole(static, len(discrete.model.loads))
    last = None
    state = State.reference(discrete.problem)
    if constant:
        last = constant_stage(discrete, constant)
        begin_stage(static, last, None, 0.0, True)
        discrete.require_held(lambda: static.loads.at(0.0, True, 1.0), searching=True)
        move(discrete, state, 1.0, "the prestress")
        whole = Stage(
            np.where(last.loads > 0.0, last.loads, whole.loads),
            np.where(last.supports > 0.0, last.supports, whole.supports),
            np.where(last.motors > 0.0, last.motors, whole.motors),
        )
    begin_stage(static, whole, last, 0.0, True)
    growing = static.loads.at(0.0, True, 1.0)
    if last is None:
        discrete.require_held(lambda: growing)
    if not _grows(whole, last, discrete):
        raise InputError(
            f"{nothing}: no load or prescribed motion grows at t = 0; add one, or leave it out of constant"
        )
    return unloaded(discrete) if last is None else state


def unloaded(discrete: DiscreteModel) -> State:
    """Return the equilibrium without loads: the reference shape, unless springs push it from there.

    Raises:
        SolveError: there is none.
    """
    state = State.reference(discrete.problem)
    constraints = discrete.system.constraints
    constraints.update(0.0, True, 0.0)
    if constraints.springs_push(state):
        move(discrete, state, 0.0, "its springs alone")
    return state


def move(discrete: DiscreteModel, state: State, factor: float, where: str) -> None:
    """Move ``state`` to an equilibrium.

    Raises:
        SolveError: there is none.
    """
    search = Search(discrete, factor, allowed=factor == 1.0)
    if not search.run(state):
        raise SolveError(f"No equilibrium was found under {where}. {search.failure()}")


def _grows(whole: Stage, last: Stage | None, discrete: DiscreteModel) -> bool:
    """Return whether anything acts that is not there from the beginning."""
    static, supports = discrete.static, discrete.supports
    before = static.loads.at(0.0, True, 0.0)
    after = static.loads.at(0.0, True, 1.0)
    same = (
        np.array_equal(before.dead, after.dead)
        and np.array_equal(before.following, after.following)
        and np.array_equal(before.gravity, after.gravity)
        and len(before.stations) == len(after.stations)
        and before.pushes == after.pushes
        and (before.rest == after.rest or not discrete.problem.rest_strains)
    )
    supports.update(0.0, True, 1.0)
    moving = supports.target.any() and (last is None or not np.array_equal(whole.supports, last.supports))
    return bool(not same or moving or discrete.problem.joints.motions)
