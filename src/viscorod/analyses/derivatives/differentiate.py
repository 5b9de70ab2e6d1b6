"""Derivatives of a finished result by numbers of its case, on its mesh and with its steps."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache, partial
from typing import Any

import numpy as np

from viscorod.analyses.call_arguments import Differentiated
from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.derivatives.resting_neighbours import RestingStates, neighbours_at_rest
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange, near
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.start_state import StartState
from viscorod.errors import Fault, InputError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.dataset import ArraysBeside, arrays_beside
from viscorod.results.derivative import Derivative, Part
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.late_attributes import LateAttributes
from viscorod.results.recorded_states import RecordedStates
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.problem.division import Division
from viscorod.solve.problem.element_arrays import gauss_positions
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.start import Start

__all__ = ["equilibrium_derivatives", "on_mesh_of", "with_derivatives"]

OF_POSES = {"reference_position", "reference_rotation", "position", "rotation", "half_width", "iterations"}
"""Variables of an equilibrium that need no forces."""


def on_mesh_of(discrete: DiscreteModel, result: Any) -> DiscreteModel:
    """Return a discretised model on the mesh of a result of it."""
    known = result.stored if isinstance(result, RecordedStates) else result.data
    stored = json.loads(str(known.attrs.get("divisions", "{}")))
    if not stored:
        return discrete.renewed(discrete.options, {})
    return discrete.on_mesh({name: Division(order, np.array(ends)) for name, (order, ends) in stored.items()})


def with_derivatives(
    compute: Callable[..., dict[str, Derivative[Any]]],
    model: ModelDescription,
    discrete: DiscreteModel,
    call: Differentiated,
    result: Any,
) -> None:
    """Give a result its derivatives.

    Args:
        compute: the derivatives of this kind of result, of ``(model, discrete, settings, result, keys)``.
        model: as its user made it; discrete: the same, on any mesh.
        call: of the analysis, with the keys of the numbers; result: that it found.
    """
    result.derivatives = compute(model, on_mesh_of(discrete, result), call, result, call.derivatives)


def equilibrium_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: EquilibriumSettings,
    result: Equilibrium,
    keys: Sequence[str],
) -> dict[str, Derivative[Equilibrium]]:
    """Return the derivatives of an equilibrium, in all states that are stored of it."""
    if settings.stages or settings.start is not None:
        raise InputError(
            Fault(
                "derivatives",
                ", ".join(keys),
                "equilibria that are found in stages or from an earlier state have no derivatives here",
                "leave stages and start out",
            )
        )
    every = [RestingStates(neighbours_at_rest(model, key, discrete), discrete) for key in keys]
    for factor in map(float, result.load_factor):
        state = StartState(discrete, Start(result=result, load_factor=factor)).state
        change = StaticChange(discrete, state, Instant(scale=factor))
        for resting in every:
            resting.take(change)
    found = {}
    for resting in every:
        number, each = resting.neighbours.number, resting.neighbours.each
        parts = [
            Part(one.weight, one.change, Equilibrium.later(partial(_at_rest, resting, k, result)))
            for k, one in enumerate(each)
        ]
        found[number.key] = Derivative(number.key, number.value, number.unit, result, parts)
    return found


def _at_rest(resting: RestingStates, number: int, result: Equilibrium) -> ArraysBeside:
    """Return the arrays of a neighbour by its number; what does not follow from poses is computed when it is read."""
    one = resting.neighbours.each[number]
    made = _arrays(one, resting.poses(number), result)
    whole = cache(lambda: _arrays(one, resting.histories[number], result).variables)

    def read(name: str) -> np.ndarray:
        return whole()[name].values

    for name, (dims, _) in made.arrays.items():
        if name not in OF_POSES:
            made.arrays[name] = dims, partial(read, name)
    return made


def record_static(
    one: Neighbour, state: State, at: Instant, history: History, level: float, discrete: DiscreteModel
) -> None:
    """Append a resting state of a neighbour to its history."""
    static = one.resting
    near(static, discrete.system.constraints.near)
    static.restore(state, at.t, before=at.before, scale=at.scale)
    snapshot = Snapshot.of(state, static.system, static.supports)
    history.record(level, snapshot, EnergyAccount(elastic=snapshot.elastic), 0.0, 0)


def derivative(
    neighbours: Neighbours, result: Any, histories: Sequence[History], kind: type[Any]
) -> Derivative[Any]:
    """Return a derivative from the histories of the neighbours."""
    number = neighbours.number
    parts = []
    for one, history in zip(neighbours.each, histories, strict=True):
        parts.append(Part(one.weight, one.change, kind.later(partial(_arrays, one, history, result))))
    return Derivative(number.key, number.value, number.unit, result, parts)


def _arrays(one: Neighbour, history: History, result: Any) -> ArraysBeside:
    gauss, attributes = gauss_positions(one.problem), LateAttributes({}, partial(one.attributes, result))
    return arrays_beside(result.kind, lambda: result.data, one.problem, gauss, history, attributes)
