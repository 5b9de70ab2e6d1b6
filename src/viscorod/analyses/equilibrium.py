"""Static equilibria: that of the loads at t = 0-, and the one from which motions and small vibrations start."""

from __future__ import annotations

import logging
import time
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import SolveError
from viscorod.results.run import Equilibrium
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.formulations.system import State
from viscorod.solve.history import EnergyAccount, History, Snapshot
from viscorod.solve.settings import EquilibriumSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.stability import stability_attributes, stability_of
from viscorod.solve.statics.static_solver import StaticPath

__all__ = ["equilibrium", "find_initial_equilibrium"]

PATIENCE = 10.0
"""Seconds between two lines about an initial equilibrium: a motion shows no progress before it has begun."""


def equilibrium(discrete: DiscreteModel, settings: EquilibriumSettings) -> Equilibrium:
    """Find the equilibrium at ``load_factor`` times the loads just before t = 0; see ``Model.equilibrium``."""
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    stops, options = settings.stops, discrete.options
    factor, chosen = stops[-1], bool(settings.load_factors or settings.load_steps)
    discrete.require_held(discrete.static.loads.at(0.0, True, factor))
    state = State.reference(discrete.problem)
    history = History()
    last = 0.0

    def record(reached: float, iterations: int) -> None:
        account = EnergyAccount(elastic=discrete.system.elastic_energy())
        snapshot = Snapshot.of(state, discrete.system, discrete.supports)
        step = reached - (history.instant[-1] if history.instant else 0.0)
        history.record(reached, snapshot, account, step, iterations)

    def on_step(reached: float, state: State, iterations: int) -> None:
        del state
        nonlocal last
        if not chosen or reached in stops:
            record(reached, iterations)
        if options.progress is not None:
            options.progress(reached, reached - last)
        last = reached

    path = discrete.static.solve(state, factor=factor, stops=stops[:-1], on_step=on_step)
    if path.factors and (not history.instant or history.instant[-1] != path.factors[-1]):
        record(path.factors[-1], path.iterations[-1])
    attrs: dict[str, Any] = {
        "outcome": path.outcome.name.lower(),
        "steps": len(path.factors),
        "iterations": sum(path.iterations) + path.wasted,
        "factorisations": sum(path.iterations) + path.wasted,
        "rejected": path.rejected,
        "linear_solver": discrete.problem.plan.description,
    }
    if path.outcome is not Outcome.COMPLETED:
        attrs["message"] = _failure(discrete, path)
        found = Equilibrium.later(discrete.data_set("equilibrium", history, attrs)) if path.factors else None
        raise SolveError(attrs["message"], found)
    attrs |= stability_attributes(stability_of(discrete.static, state, scale=factor))
    return Equilibrium.later(discrete.data_set("equilibrium", history, attrs))


def find_initial_equilibrium(discrete: DiscreteModel, state: State, *, before: bool = True) -> None:
    """Move ``state`` to the equilibrium just before or after t = 0; the reference shape itself if nothing acts.

    Raises:
        InputError: nothing holds the model. SolveError: there is no such equilibrium.
    """
    discrete.supports.update(0.0, before)
    loads = discrete.static.loads.at(0.0, before)
    strained = discrete.system.constraints.is_strained(state, 0.0, before=before)
    if loads.none and not discrete.supports.target.any() and not strained:
        return
    discrete.require_held(loads)
    last = time.perf_counter()

    def on_step(reached: float, *_: Any) -> None:
        nonlocal last
        if reached < 1.0 and time.perf_counter() - last > PATIENCE:
            last = time.perf_counter()
            logging.getLogger("viscorod").warning(
                "viscorod: looking for the initial equilibrium, %.3g of the loads reached", reached
            )

    path = discrete.static.solve(state, before=before, on_step=on_step)
    if path.outcome is not Outcome.COMPLETED:
        raise SolveError(f"The initial equilibrium was not found. {_failure(discrete, path)}")


def _failure(discrete: DiscreteModel, path: StaticPath) -> str:
    reached = path.factors[-1] if path.factors else 0.0
    if path.outcome is Outcome.INTERRUPTED:
        return f"Stopped at {reached:.6g} of the loads (trying {path.load_level:.6g}): {path.reason}"
    assert path.report is not None
    text = (
        f"No equilibrium beyond {reached:.6g} of the loads (tried {path.load_level:.6g}): {path.outcome.value}."
        f"{discrete.where(path.report)} What to try: {path.outcome.advice(static=True)}."
    )
    gaps = discrete.system.constraints.open_joints(1.0 - reached)
    if gaps:
        text += f" Joints that are open in the reference shape could not be closed; still open: {', '.join(gaps)}."
    free = free_motions(discrete.problem)
    if free:
        text += f" Free rigid motions: {', '.join(motion.text for motion in free)}."
    return text
