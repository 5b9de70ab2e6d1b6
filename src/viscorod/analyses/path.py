"""Paths of static equilibria, through limit points and past bifurcations."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near
from viscorod.analyses.growing_loads import unloaded
from viscorod.errors import InputError, SolveError
from viscorod.results.data_schema import AXES
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot, StationReader
from viscorod.solve.settings.statics import PathSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.path_follower import Path, PathFollower
from viscorod.solve.statics.special_points import PathPoint
from viscorod.solve.statics.stability import Stability, stability_attributes

__all__ = ["equilibrium_path"]


def equilibrium_path(discrete: DiscreteModel, settings: PathSettings) -> Equilibrium:
    """Follow a path of equilibria; see ``Model.path``."""
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    state, first = _start(discrete, settings)
    points = _Points(discrete, settings)
    path = PathFollower(discrete.static).follow(
        state,
        first=first,
        load_factor=settings.target,
        endings=[] if points.displacement is None else [points.beyond],
        wanted=settings.load_factors,
        largest=settings.arc_length,
        points=settings.points,
        limit_point=settings.limit_point,
        branch=settings.branch,
        on_point=points.record,
    )
    history = points.history
    discrete.watch.see_path(history, abs(settings.target or 1.0))
    attrs = _course(path) | discrete.watch.attributes
    if path.outcome is not Outcome.COMPLETED:
        attrs["message"] = _failure(discrete, path, history)
    found = None
    if path.count:
        assert points.stability is not None
        attrs |= stability_attributes(points.stability, lambda: discrete.inertia_known)
        found = Equilibrium.later(discrete.arrays("equilibrium", history, attrs))
    if found is None or path.outcome not in (Outcome.COMPLETED, Outcome.POINTS):
        raise SolveError(attrs["message"], found, coarse=path.outcome is Outcome.WRAPPED)
    return found


def _start(discrete: DiscreteModel, settings: PathSettings) -> tuple[State, float]:
    """Return the equilibrium that a path starts from, and its load factor.

    Raises:
        InputError: nothing acts that a path could follow.
    """
    loads = discrete.static.loads.at(0.0, True, 1.0)
    discrete.supports.update(0.0, True)
    reference = State.reference(discrete.problem)
    strained = discrete.problem.rest_strains or discrete.system.constraints.is_strained(reference, 0.0)
    if loads.none and not discrete.supports.target.any() and not strained:
        raise InputError(
            "no path to follow: no load, prescribed motion or rest strain acts at t = 0; add a load without until"
        )
    if settings.start is not None:
        state, first, _ = equilibrium_near(discrete, settings.start, own_factor=True)
        return state, first
    discrete.require_held(lambda: loads)
    return unloaded(discrete), 0.0


class _Points:
    """The points of a path, recorded as they are reached, with progress by what the path is to end at.

    Attributes:
        history: of the points; stability: of the last one.
        displacement: returns that of the place at which the path ends [m]; None if it ends elsewhere.
    """

    def __init__(self, discrete: DiscreteModel, settings: PathSettings) -> None:
        self.history = History()
        self.stability: Stability | None = None
        self.displacement = None if settings.place is None else _displacement(discrete, settings)
        self._discrete, self._settings, self._told = discrete, settings, 0.0

    def record(self, point: PathPoint) -> None:
        """Record a point, in whose state the system is."""
        discrete, history = self._discrete, self.history
        account = EnergyAccount(elastic=discrete.system.elastic_energy())
        snapshot = Snapshot.of(point.state, discrete.system, discrete.supports)
        step = point.factor - (history.instant[-1] if history.instant else 0.0)
        history.record(point.factor, snapshot, account, step, point.iterations)
        assert point.stability is not None
        history.unstable.append(point.stability.unstable)
        self.stability = point.stability
        if discrete.options.progress is not None:
            reached = point.factor if self.displacement is None else self.displacement(point)
            discrete.options.progress(reached, reached - self._told)
            self._told = reached

    def beyond(self, point: PathPoint) -> float:
        """Return how far a point is beyond the displacement that ends the path, in the length of the model."""
        assert self.displacement is not None
        assert self._settings.displacement is not None
        return (self.displacement(point) - self._settings.displacement) / self._discrete.problem.length


def _course(path: Path) -> dict[str, Any]:
    """Return the attributes of a path."""
    return {
        "outcome": path.outcome.name.lower(),
        "steps": path.count,
        "iterations": path.iterations,
        "rejected": path.rejected,
        "limit_points": json.dumps(path.limit_points),
        "bifurcations": json.dumps(path.bifurcations),
        "multiplicity": json.dumps(path.multiplicity),
        "flutter_points": json.dumps(path.flutter),
        "parting": json.dumps(path.parting),
    }


def _displacement(discrete: DiscreteModel, settings: PathSettings) -> Callable[[PathPoint], float]:
    """Return what tells the displacement that ends a path, from the reference shape [m]."""
    assert settings.place is not None
    assert settings.axis is not None
    problem, reader = discrete.problem, StationReader(discrete.problem)
    start = reader.read(problem.positions, problem.quaternions, np.zeros((problem.size, 6)))[0]
    place, component = discrete.place(settings.place), AXES.index(settings.axis)

    def displacement(point: PathPoint) -> float:
        position = reader.read(point.state.r, point.state.q, point.state.twist)[0]
        return float(place.of(position - start)[component])

    return displacement


def _failure(discrete: DiscreteModel, path: Path, history: History) -> str:
    reached = history.instant[-1] if history.instant else 0.0
    if path.outcome is Outcome.INTERRUPTED:
        return f"Stopped at {reached:.6g} of the loads, {path.count} points: {path.reason}"
    text = f"The path was followed to {reached:.6g} of the loads, {path.count} points: {path.outcome.value}."
    if path.outcome is Outcome.POINTS:
        return f"{text} What to try: {path.outcome.advice(static=True)}."
    where = discrete.where(path.report) if path.report is not None else ""
    advice = "give a smaller arc_length, or a small load that prefers one way where the path branches"
    if path.count < 2:
        advice = "look for what moves freely, or is held twice, in the reference shape"
    return f"{text}{where} What to try: {advice}."
