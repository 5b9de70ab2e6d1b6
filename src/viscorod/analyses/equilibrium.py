"""Static equilibria: that of the loads at t = 0-, and the one from which motions and small vibrations start."""

from __future__ import annotations

import json
import logging
import time
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium_search import Search
from viscorod.errors import Fault, InputError, SolveError
from viscorod.results.run import Equilibrium
from viscorod.solve.formulations.system import State
from viscorod.solve.history import EnergyAccount, History, Snapshot
from viscorod.solve.settings import EquilibriumSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.settling import SettlingReport

__all__ = ["equilibrium", "find_initial_equilibrium", "require_no_initial_strain"]

PATIENCE = 10.0
"""Seconds between two lines about an initial equilibrium: a motion shows no progress before it has begun."""


def equilibrium(discrete: DiscreteModel, settings: EquilibriumSettings) -> Equilibrium:
    """Find the equilibrium at ``load_factor`` times the loads just before t = 0; see ``Model.equilibrium``."""
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    factor, options = settings.load_factor, discrete.options
    loads = discrete.static.loads.at(0.0, True, factor)
    search = Search(discrete, factor, allowed=settings.search)
    search.loose = discrete.require_held(loads, searching=settings.search)
    state = State.reference(discrete.problem)
    history = History()
    last = 0.0

    def on_step(reached: float, state: State, iterations: int) -> None:
        nonlocal last
        account = EnergyAccount(elastic=discrete.system.elastic_energy())
        snapshot = Snapshot.of(state, discrete.system, discrete.supports)
        history.record(reached, snapshot, account, reached - last, iterations)
        if options.progress is not None:
            options.progress(reached, reached - last)
        last = reached

    found = search.run(state, first_step=1.0 / (settings.load_steps or 1), on_step=on_step)
    path, settling = search.steps, search.settling or SettlingReport()
    effort = sum(path.iterations) + path.wasted + settling.iterations
    attrs: dict[str, Any] = {
        "outcome": path.outcome.name.lower(),
        "steps": len(path.factors) + settling.steps,
        "iterations": effort,
        "factorisations": effort,
        "rejected": 0 if search.settled else path.rejected,
        "linear_solver": discrete.problem.plan.description,
    }
    if not found:
        attrs["message"] = search.failure()
        part = Equilibrium.later(discrete.data_set("equilibrium", history, attrs)) if path.factors else None
        raise SolveError(attrs["message"], part)
    if search.settled:
        history, last = History(), 0.0
        attrs["outcome"] = Outcome.COMPLETED.name.lower()
        on_step(factor, state, settling.iterations)
    discrete.watch.see(history.snapshots[-1], factor)
    attrs |= discrete.watch.attributes
    attrs["found_by"] = search.found_by
    attrs["negative_eigenvalues"] = search.unstable
    doubts = json.loads(discrete.attributes.get("warnings", "[]")) + search.doubts
    attrs["warnings"] = json.dumps(doubts)
    return Equilibrium.later(discrete.data_set("equilibrium", history, attrs))


def require_no_initial_strain(discrete: DiscreteModel) -> None:
    """Refuse initial strains where no motion begins with them.

    Raises:
        InputError: the model has initial strains.
    """
    if discrete.problem.initial_strain:
        raise InputError(
            Fault(
                "strains",
                str(len(discrete.problem.initial_strain)),
                "initial strains are those of a motion at t = 0, and no equilibrium",
                "give a rest strain (rest_strain, [[rest_strains]]) if rods are free of stress at it, leave them out, "
                "or take the reference shape (about = 'reference' of modes)",
            )
        )


def find_initial_equilibrium(discrete: DiscreteModel, state: State, *, before: bool = True) -> Search | None:
    """Move ``state`` to the equilibrium just before or after t = 0.

    Returns:
        how it was found; None where nothing acts and the reference shape is the equilibrium.

    Raises:
        InputError: nothing holds the model. SolveError: there is no such equilibrium.
    """
    require_no_initial_strain(discrete)
    discrete.supports.update(0.0, before)
    loads = discrete.static.loads.at(0.0, before)
    strained = discrete.system.constraints.is_strained(state, 0.0, before=before)
    resting = not discrete.problem.rest_strain
    if resting and loads.none and not discrete.supports.target.any() and not strained:
        return None
    search = Search(discrete, before=before)
    search.loose = discrete.require_held(loads, searching=True)
    last = time.perf_counter()

    def on_step(reached: float, *_: Any) -> None:
        nonlocal last
        if reached < 1.0 and time.perf_counter() - last > PATIENCE:
            last = time.perf_counter()
            logging.getLogger("viscorod").warning(
                "viscorod: looking for the initial equilibrium, %.3g of the loads reached", reached
            )

    if not search.run(state, on_step=on_step):
        raise SolveError(f"The initial equilibrium was not found. {search.failure()}")
    return search
