"""Critical loads of a model, with what acts in full throughout as prestress."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import require_no_initial_strain
from viscorod.analyses.growing_loads import begin_growing, move
from viscorod.analyses.touching_coils import touching_coils
from viscorod.errors import SolveError
from viscorod.results.buckling import Buckling
from viscorod.results.validity import SMALL_STRAIN
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot, StationReader
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.modes.linearisation import nodal_motions
from viscorod.solve.modes.mode_names import StrainEnergies
from viscorod.solve.modes.vibrations import station_shapes
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.statics.critical_loads import CriticalPoint, CriticalSearch
from viscorod.solve.statics.newton import Outcome, interruption
from viscorod.solve.statics.path_follower import PathFollower
from viscorod.typing import Floats

__all__ = ["buckling"]


def buckling(discrete: DiscreteModel, settings: BucklingSettings) -> Buckling:
    """Find critical loads; see ``Model.buckling``."""
    try:
        return _critical(discrete, settings)
    except KeyboardInterrupt as asked:
        raise SolveError(f"Stopped: {interruption(asked)}") from None


def _critical(discrete: DiscreteModel, settings: BucklingSettings) -> Buckling:
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    require_no_initial_strain(discrete)
    state = _begin(discrete, settings)
    about = Snapshot.of(state, discrete.system, discrete.supports)
    search = CriticalSearch(PathFollower(discrete.static), state, settings.about)
    try:
        linear, increments = search.linear(settings.count)
    except SingularMatrixError:
        raise SolveError(
            f"The equilibrium at the load factor {settings.about:g} has no stiffness against some motion: it is "
            "critical itself, or something moves freely. What to try: add supports, or another `about`"
        ) from None
    if not settings.exact:
        points = [
            CriticalPoint(float(factor), state, increments[:, k : k + 1], False)
            for k, factor in enumerate(linear)
        ]
        return _found(discrete, settings, about, linear, points)
    points, course = search.exact(settings.count, linear, discrete.options.progress)
    if course.outcome in (Outcome.COMPLETED, Outcome.POINTS):
        told = [*_growing(search, points, settings.count), *_rounded(search)]
        return _found(discrete, settings, about, linear, points, reached=search.reached, told=told)
    reached = f"{points[-1].factor:.6g}" if points else "the beginning"
    why = course.reason or course.outcome.value
    stopped = course.outcome is Outcome.INTERRUPTED
    part = _found(discrete, settings, about, linear, points, "interrupted" if stopped else "failed")
    raise SolveError(
        f"The equilibria were not followed to {settings.count} critical loads: {why}, beyond {reached}"
        + ("" if stopped else ". What to try: a smaller count, or exact = false"),
        part,
        coarse=course.outcome is Outcome.WRAPPED,
    )


def _begin(discrete: DiscreteModel, settings: BucklingSettings) -> State:
    """Return the equilibrium about which the linear problem is solved, with the stage of the loads that grow begun."""
    state = begin_growing(discrete, settings.constant, "no critical loads")
    if settings.about:
        move(discrete, state, settings.about, f"the load factor {settings.about:g}")
    discrete.static.restore(state, 0.0, before=True, scale=settings.about)
    return state


def _found(
    discrete: DiscreteModel,
    settings: BucklingSettings,
    about: Snapshot,
    linear: Floats,
    points: list[CriticalPoint],
    outcome: str = "completed",
    reached: float | None = None,
    told: Sequence[str] = (),
) -> Buckling:
    """Return the result.

    Args:
        discrete, settings: of the analysis; about: state of the linear problem; linear: its factors; points: found.
        outcome: how it ended; reached: how far equilibria were followed; told: warnings.
    """
    problem = discrete.problem
    reader = StationReader(problem)
    shapes, rotations, positions, factors, limits = [], [], [], [], []
    for point in points:
        still = np.zeros((problem.size, 6))
        place = reader.read(point.state.r, point.state.q, still)[0]
        own, turned = station_shapes(problem, point.state, _principal(discrete, point))
        for k in range(len(own)):
            shapes.append(own[k].real)
            rotations.append(turned[k].real)
            positions.append(place)
            factors.append(point.factor)
            limits.append(point.limit)
    history = History()
    history.record(settings.about, about, EnergyAccount(elastic=about.elastic), 0.0, 0)
    attributes = {
        "outcome": outcome,
        "buckling_exact": int(settings.exact),
        "buckling_complete": int(len(factors) >= settings.count),
    }
    if settings.exact:
        states = ((f"at critical load {k}", point.state) for k, point in enumerate(points, 1))
        touching = touching_coils(discrete.model.rods, problem, states)
        attributes["warnings"] = json.dumps([*told, *_strained(discrete, points), *touching])
    if reached is not None:
        attributes["buckling_reached"] = reached
    data = discrete.data_set(Buckling.kind, history, attributes)()
    moving, stations = ("critical", "station", "axis"), len(reader.nodes)
    shaped = (len(factors), stations, 3)
    return Buckling(
        data.assign(
            critical_load=("critical", np.array(factors, dtype=float)),
            critical_limit=("critical", np.array(limits, dtype=bool)),
            critical_shape=(moving, np.array(shapes, dtype=float).reshape(shaped)),
            critical_rotation=(moving, np.array(rotations, dtype=float).reshape(shaped)),
            critical_position=(moving, np.array(positions, dtype=float).reshape(shaped)),
            linear_load=("linear", np.asarray(linear, dtype=float)),
        )
    )


def _growing(search: CriticalSearch, points: list[CriticalPoint], count: int) -> Iterator[str]:
    """Yield that loads without a potential make oscillations grow before stiffness is lost, or may do so."""
    if not search.by_motion:
        return
    first = min(search.flutter, key=lambda factor: abs(factor - search.about), default=None)
    if first is not None and all(abs(first - search.about) <= abs(p.factor - search.about) for p in points):
        yield (
            f"the loads have no potential, and oscillations grow from the load factor {first:.4g} on, before any "
            "stiffness is lost: `model.stability` finds where they begin, with the damping of the material"
        )
    elif sum(point.increments.shape[1] for point in points) < count:
        yield (
            "the loads have no potential (they follow the sections, or are moments about fixed axes): oscillations "
            "may grow, beyond what was looked at, without any loss of stiffness; `model.stability` finds where they "
            "begin"
        )


def _rounded(search: CriticalSearch) -> Iterator[str]:
    """Yield that the model gives way below its first critical load, as a column does that is not quite straight."""
    if search.rounded is not None:
        yield (
            f"near the load factor {search.rounded:.3g} the model gives way without losing its stiffness, as a column "
            "does that is not quite straight: the load at which the perfect one would buckle is near that, and `path` "
            "shows how displacements grow there"
        )


def _strained(discrete: DiscreteModel, points: list[CriticalPoint]) -> Iterator[str]:
    """Yield which critical loads are reached at strains for which a linear material law is not meant (LLT 2.2)."""
    for number, point in enumerate(points, 1):
        discrete.static.restore(point.state, 0.0, before=True, scale=point.factor)
        strain = np.abs(discrete.system.gauss_points().strain[:, :3]).max(axis=0)
        if strain.max() > SMALL_STRAIN:
            name = ("shear 1", "shear 2", "stretch")[int(np.argmax(strain))]
            yield (
                f"critical load {number} is reached where the strain {name} is {strain.max():.2g} already; the "
                "material law is meant for strains well below 1, and no real material need do the same"
            )


def _principal(discrete: DiscreteModel, point: CriticalPoint) -> Floats:
    """Return the directions of a point; of several, any combination is one, those that strain the rods in one way."""
    increments = point.increments
    if increments.shape[1] < 2:
        return increments
    energies = StrainEnergies(discrete.system, point.state, nodal_motions(discrete.problem))
    return np.asarray(energies.principal(increments, np.ones(increments.shape[1])))
