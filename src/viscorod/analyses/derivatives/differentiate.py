"""Derivatives of a finished result by numbers of its case, on its mesh and with its steps."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from viscorod.analyses.call_arguments import Differentiated
from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.derivatives.resting_neighbours import neighbours_at_rest, snapshots
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange
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
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.start import Start

__all__ = ["equilibrium_derivatives", "on_mesh_of", "with_derivatives"]


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
    every = [neighbours_at_rest(model, key, discrete) for key in keys]
    histories = [[History() for _ in one.each] for one in every]
    for factor in map(float, result.load_factor):
        state = StartState(discrete, Start(result=result, load_factor=factor)).state
        change = StaticChange(discrete, state, Instant(scale=factor))
        for neighbours, kept in zip(every, histories, strict=True):
            found = snapshots(change, neighbours, change.increment(neighbours), discrete)
            for snapshot, history in zip(found, kept, strict=True):
                history.record(factor, snapshot, EnergyAccount(elastic=snapshot.elastic), 0.0, 0)
    return {
        neighbours.number.key: derivative(neighbours, result, kept, Equilibrium)
        for neighbours, kept in zip(every, histories, strict=True)
    }


def record_static(
    one: Neighbour, state: State, at: Instant, history: History, level: float, discrete: DiscreteModel
) -> None:
    """Append a resting state of a neighbour to its history."""
    one.system.constraints.near[:] = discrete.system.constraints.near
    one.static.restore(state, at.t, before=at.before, scale=at.scale)
    snapshot = Snapshot.of(state, one.system, one.supports)
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
    gauss, attributes = one.system.gauss_positions(), LateAttributes({}, partial(one.attributes, result))
    return arrays_beside(result.kind, lambda: result.data, one.problem, gauss, history, attributes)
