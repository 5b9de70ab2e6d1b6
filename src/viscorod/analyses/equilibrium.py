"""Static equilibria: that of the loads at t = 0-, and the one from which motions and small vibrations start."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable
from functools import partial
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium_search import Search
from viscorod.analyses.start_state import StartState
from viscorod.analyses.static_stages import stages_of
from viscorod.errors import Fault, InputError, SolveError
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.start import Start
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.stability import Stability, circulatory, stability_attributes, stability_of
from viscorod.solve.statics.stage import Stage, begin_at, begin_stage, end_stages

__all__ = ["equilibrium", "equilibrium_near", "find_initial_equilibrium", "require_no_initial_strain"]

PATIENCE = 10.0
"""Seconds between two lines about an initial equilibrium: a motion shows no progress before it has begun."""


def equilibrium(discrete: DiscreteModel, settings: EquilibriumSettings) -> Equilibrium:
    """Find the equilibrium at ``load_factor`` times the loads just before t = 0; see ``Model.equilibrium``."""
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    return _Equilibrium(discrete, settings).found()


class _Equilibrium:
    """Finds an equilibrium, stage by stage, and keeps the record."""

    def __init__(self, discrete: DiscreteModel, settings: EquilibriumSettings) -> None:
        self.discrete, self.settings = discrete, settings
        self.history = History()
        self.searches: list[Search] = []
        self.ends: list[int] = []  # states at the ends of stages
        self.stages = stages_of(discrete, settings)
        self.notes: list[str] = []
        self._last = self._shown = 0.0
        self._staged = bool(settings.stages) or settings.start is not None
        self._passed: tuple[float, int] | None = None  # load step since the last one that was kept
        self._unstable: list[float] = []  # load factors of states that were asked for on the way

    def found(self) -> Equilibrium:
        """Return the equilibrium.

        Raises:
            InputError: nothing holds the model. SolveError: none was found.
        """
        state, staged = self._begin(), self._staged
        steps = self.settings.load_steps or 1
        stops = tuple(k / steps for k in range(1, steps + 1)) if staged else self.settings.stops
        self._kept = stops if self.settings.load_steps or self.settings.load_factors else None
        factor = stops[-1]
        for number, stage in enumerate(self.stages):
            if staged and number > 0:
                begin_stage(self.discrete.static, stage, self.stages[number - 1], 0.0, True)
            search = self._search(factor, number)
            kept = self.history.count
            done = search.run(state, stops=stops[:-1], on_step=self._on_step)
            if not done:
                self._keep_last(state)
                raise SolveError(search.failure(), self._part(search), coarse=search.coarse)
            if search.settled:
                self._forget(kept, stops)
                self._record(factor, state, search.iterations)
            self.ends.append(self.history.count - 1)
        mesh = self.discrete.watch.once_asked(
            partial(self._compare_meshes, self.history.records[-1].states.at(-1), factor)
        )
        found = {"found_by": self._found_by()} | stability_attributes(
            search.stability, lambda: self.discrete.inertia_known
        )
        return self._result(Outcome.COMPLETED, found, mesh)

    def _compare_meshes(self, found: Snapshot, factor: float) -> None:
        watch = self.discrete.watch
        if self._staged and watch.feasible:
            begin_stage(watch.finer.static, self.stages[-1], None, 0.0, True)
        watch.see(found, factor)

    def _forget(self, kept: int, stops: tuple[float, ...]) -> None:
        """Forget the load steps to an equilibrium that is not the result; those that were asked for stay."""
        if self._kept is not None:
            wanted = len(stops) - 1
            there = self.history.count - kept
            if there < wanted:
                passed = ", ".join(f"{stop:g}" for stop in stops[there:-1])
                self.notes.append(
                    f"no load steps led to the load factors {passed}: they are not among the states"
                )
            kept += min(there, wanted)
        self.history.truncate(kept)
        self._last = self.history.instant[-1] if kept else 0.0

    def _begin(self) -> State:
        """Return the state to begin from."""
        discrete, settings = self.discrete, self.settings
        if settings.start is not None:
            start = StartState(discrete, settings.start)
            self.notes, self.origin = start.notes, start.label
            begin_at(discrete.static, self.stages[0], start.state, 0.0, True)
            return start.state
        self.origin = "the reference shape"
        state = State.reference(discrete.problem)
        if settings.stages:
            begin_stage(discrete.static, self.stages[0], None, 0.0, True)
        return state

    def _search(self, factor: float, number: int) -> Search:
        """Return the search of a stage; what nothing holds is refused."""
        discrete, allowed = self.discrete, self.settings.search
        search = Search(discrete, factor, allowed=allowed, forced="search" in self.settings.model_fields_set)
        search.origin = self.origin if number == 0 else f"the end of stage {number}"
        if discrete.coarser is not None and not self._staged:
            search.near = StartState(discrete, Start(result=discrete.coarser)).state
        from_reference = number == 0 and self.settings.start is None
        if from_reference or allowed:
            loads = partial(discrete.static.loads.at, 0.0, True, factor)
            loose = discrete.require_held(loads, searching=allowed)
            search.loose = loose if from_reference else []
        self.searches.append(search)
        return search

    def _on_step(self, reached: float, state: State, iterations: int) -> None:
        """Keep a load step, or only those that were asked for."""
        self._passed = reached, iterations
        if self._kept is None or reached in self._kept:
            self._record(reached, state, iterations)
            if self._kept is not None and reached != self._kept[-1]:
                self._judge(reached, state)
        if self.discrete.options.progress is not None:
            self.discrete.options.progress(self._of_all(reached), self._of_all(reached) - self._shown)
        self._shown = self._of_all(reached)

    def _judge(self, reached: float, state: State) -> None:
        """Note if a state on the way is unstable: load steps go on along a straight strut, whatever it would do."""
        static = self.discrete.static
        if circulatory(static.loads.at(0.0, True, reached)):
            return
        if stability_of(static, state, before=True, scale=reached, solved=True).unstable:
            self._unstable.append(self._of_all(reached))
        static.restore(state, 0.0, before=True, scale=reached)

    def _passed_unstable(self) -> list[str]:
        """Return a warning of states on the way that are unstable."""
        if not self._unstable:
            return []
        which = ", ".join(f"{factor:.4g}" for factor in self._unstable)
        states = (
            f"state at the load factor {which} is" if len(self._unstable) == 1 else f"states at {which} are"
        )
        return [
            f"the {states} unstable: a smaller load led to where the model buckles or snaps, and load steps went on "
            "beside that; model.buckling says where, model.path what follows, and an equilibrium at that load_factor "
            "alone is sought until it is stable"
        ]

    def _keep_last(self, state: State) -> None:
        """Keep the last load step of a search that failed, though it was not asked for."""
        if self._passed is not None:
            reached, iterations = self._passed
            self.discrete.static.restore(state, 0.0, before=True, scale=reached)
            self._record(reached, state, iterations)

    def _record(self, reached: float, state: State, iterations: int) -> None:
        discrete, reached = self.discrete, self._of_all(reached)
        account = EnergyAccount(elastic=discrete.system.elastic_energy())
        snapshot = Snapshot.of(state, discrete.system, discrete.supports)
        self.history.record(reached, snapshot, account, reached - self._last, iterations)
        self._last, self._passed = reached, None

    def _of_all(self, reached: float) -> float:
        """Return the load factor of all stages at that of the present one."""
        if not self._staged:
            return reached
        return self.settings.load_factor * (len(self.searches) - 1 + reached) / len(self.stages)

    def _found_by(self) -> str:
        if len(self.searches) == 1:
            return self.searches[0].found_by
        return "; ".join(f"stage {k}: {search.found_by}" for k, search in enumerate(self.searches, 1))

    def _part(self, search: Search) -> Equilibrium | None:
        """Return what was found up to a failure."""
        if self.history.count == 0:
            return None
        return self._result(search.steps.outcome, {"message": search.failure()})

    def _result(
        self,
        outcome: Outcome,
        more: dict[str, Any],
        late: Callable[[], dict[str, Any]] | None = None,
    ) -> Equilibrium:
        searches, discrete = self.searches, self.discrete
        effort = sum(search.iterations for search in searches)
        warnings = (
            json.loads(discrete.attributes.get("warnings", "[]")) + self.notes + self._passed_unstable()
        )
        attrs: dict[str, Any] = {
            "outcome": outcome.name.lower(),
            "steps": sum(search.count for search in searches),
            "iterations": effort,
            "factorisations": effort,
            "rejected": sum(0 if search.settled else search.steps.rejected for search in searches),
            "linear_solver": discrete.problem.plan.description,
            "warnings": json.dumps(warnings + [doubt for search in searches for doubt in search.doubts]),
        } | more
        if len(self.stages) > 1:
            attrs["stage_ends"] = json.dumps(self.ends)
        return Equilibrium.later(discrete.arrays("equilibrium", self.history, attrs, late))


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


def equilibrium_near(
    discrete: DiscreteModel, start: Start, *, own_factor: bool = False
) -> tuple[State, float, Stability]:
    """Return the equilibrium just before t = 0 that is found from an earlier result, its load factor and stability.

    Args:
        discrete: the model; start: the earlier result.
        own_factor: loads and motions have the load factor of the earlier result (1 for a motion), else 1.

    Raises:
        InputError: it is no result of this model, or nothing holds the model.
        SolveError: there is no such equilibrium.
    """
    require_no_initial_strain(discrete)
    found = StartState(discrete, start)
    factor = found.load_factor if own_factor else None
    factor = 1.0 if factor is None else factor
    whole = Stage.whole(discrete.static, len(discrete.model.loads), factor)
    begin_at(discrete.static, whole, found.state, 0.0, True)
    discrete.require_held(partial(discrete.static.loads.at, 0.0, True), searching=True)
    # one that is unstable was meant: it is kept, where settling would leave it
    stable = not found.result.stored.attrs.get("negative_eigenvalues", 0)
    search = Search(discrete, origin=found.label, allowed=stable)
    done = search.run(found.state)
    end_stages(discrete.static)
    if not done:
        raise SolveError(
            f"No equilibrium was found from {found.label}. {search.failure()}", coarse=search.coarse
        )
    discrete.static.restore(found.state, 0.0, before=True, scale=factor)
    return found.state, factor, search.stability


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
    jointed = discrete.problem.joints.count > 0
    strained = jointed and discrete.system.constraints.is_strained(state, 0.0, before=before)
    resting = not discrete.problem.rest_strains
    if resting and loads.none and not discrete.supports.target.any() and not strained:
        return None
    search = Search(discrete, before=before)
    search.loose = discrete.require_held(lambda: loads, searching=True)
    last = time.perf_counter()

    def on_step(reached: float, *_: Any) -> None:
        nonlocal last
        if reached < 1.0 and time.perf_counter() - last > PATIENCE:
            last = time.perf_counter()
            logging.getLogger("viscorod").warning(
                "viscorod: looking for the initial equilibrium, %.3g of the loads reached", reached
            )

    if not search.run(state, on_step=on_step):
        raise SolveError(f"The initial equilibrium was not found. {search.failure()}", coarse=search.coarse)
    told = json.loads(discrete.attributes.get("doubts", "[]"))
    new = [one for one in search.fallen if one not in told]
    if new:
        discrete.attributes["doubts"] = json.dumps([*told, *new])
    return search
