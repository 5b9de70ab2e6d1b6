"""Frequencies, critical loads and responses on meshes that the program chooses, with what a finer one makes of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.refinement import GAIN, MOST_MESHES, on_fine_enough
from viscorod.errors import SolveError
from viscorod.results.buckling import Buckling
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.results.modes_result import Modes
from viscorod.results.periodic import Periodic
from viscorod.results.result import Result
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import linearise, natural_frequencies
from viscorod.solve.problem.division import divisions_of
from viscorod.solve.refinement.finer_divisions import MOST_CHOSEN_NODES
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.typing import Floats

__all__ = ["frequency_errors", "refined_buckling", "refined_modes", "refined_periodic", "refined_response"]

RIGID = 1e-6
"""Part of the highest listed frequency below which one is a rigid motion."""
MOST_COUNTED = 1000
"""Modes for which the program chooses a mesh at most."""
MOST_COMPARED = 200
"""Frequencies that are compared on two meshes at most."""

S = TypeVar("S", bound=Meshed)
Q = TypeVar("Q", bound=Result)


def refined_modes(
    analysis: Callable[[DiscreteModel, ModesSettings], Modes],
    discrete: DiscreteModel,
    settings: ModesSettings,
) -> Modes:
    """Find modes on a mesh that the program chooses, with the estimated errors of their frequencies.

    More than a mesh has are not sought: the highest modes of any mesh are its own, not those of the model.
    """

    def compared(found: Modes, other: Modes) -> tuple[Modes, Floats]:
        errors = frequency_errors(found, other)
        return found.with_errors(errors), errors

    asked = settings.count
    discrete, count = _countable(discrete, asked)
    found = beside_finer(analysis, discrete, settings.replaced(count=count), compared)
    there = len(found.eigenvalues)
    if there < asked and (count < asked or not settings.oscillating):
        begun = count < asked and discrete.watch.free
        note = (
            f"{asked} modes were asked for, and {there} are listed, "
            + (
                "as many as the mesh with which the program begins can have"
                if begun
                else "all that the mesh has"
            )
            + "; the highest modes of any mesh are its own: for more, give the rods more elements"
        )
        told = json.loads(found.data.attrs.get("warnings", "[]"))
        found.data.attrs["warnings"] = json.dumps([*told, note])
    return found


def _countable(discrete: DiscreteModel, count: int) -> tuple[DiscreteModel, int]:
    """Return the model on a mesh with as many degrees of freedom as modes are sought, and how many are sought there.

    If the program would have to choose a mesh for more than ``MOST_COUNTED`` modes, those of the present mesh are.
    """
    if count <= 6 * discrete.problem.size:
        return discrete, count
    if count > MOST_COUNTED and discrete.watch.free:
        return discrete, 6 * discrete.problem.size
    while count > 6 * discrete.problem.size:
        divisions = discrete.watch.halved()
        if divisions is None:
            return discrete, 6 * discrete.problem.size
        discrete = discrete.on_mesh(divisions)
    return discrete, count


def refined_buckling(
    analysis: Callable[[DiscreteModel, BucklingSettings], Buckling],
    discrete: DiscreteModel,
    settings: BucklingSettings,
) -> Buckling:
    """Find critical loads on a mesh that the program chooses, with the estimated errors of their factors."""

    def compared(found: Buckling, other: Buckling) -> tuple[Buckling, Floats]:
        paired = min(len(found.load_factors), len(other.load_factors))
        mine, theirs = found.load_factors[:paired], other.load_factors[:paired]
        errors = np.ones(len(found.load_factors))
        errors[:paired] = np.abs(mine - theirs) / np.maximum(np.abs(theirs), np.finfo(float).tiny)
        found = found.with_errors(errors)
        unlike = _unlike(found, other)
        if unlike:
            told = json.loads(found.data.attrs.get("warnings", "[]"))
            found.data.attrs["warnings"] = json.dumps([*told, unlike])
        return found, np.append(errors, [1.0] if unlike else [])

    return beside_finer(analysis, discrete, settings, compared)


def _unlike(found: Buckling, other: Buckling) -> str:
    """Return a warning where a finer mesh has critical loads of other kinds, or more at once, else nothing."""
    if not found.exact:
        return ""
    for k, (mine, better) in enumerate(zip(found.limit, other.limit, strict=False), 1):
        if mine != better:
            kinds = ("a limit point", "a bifurcation") if mine else ("a bifurcation", "a limit point")
            return f"critical load {k} is {kinds[0]} on this mesh and {kinds[1]} on a finer one; use more elements"
    if len(found.load_factors) < len(other.load_factors):
        return (
            f"a finer mesh has {len(other.load_factors)} critical loads where this one has "
            f"{len(found.load_factors)}; use more elements"
        )
    return ""


def beside_finer(
    analysis: Callable[[DiscreteModel, S], Q],
    discrete: DiscreteModel,
    settings: S,
    compared: Callable[[Q, Q], tuple[Q, Floats]],
) -> Q:
    """Run an analysis on a mesh and on the one with all elements halved; their differences are the estimated errors.

    While one is more than ``accuracy``, and the program may choose the mesh of a rod, the finer mesh becomes the
    coarser one; so it does if Newton's method fails on a first mesh that the program chose.

    Args:
        analysis: what is run; discrete, settings: its arguments.
        compared: returns a result with its errors, and these, from it and that of the finer mesh.
    """
    found, discrete = on_fine_enough(analysis, discrete, settings, failing=True)
    stuck, before = 0, np.inf
    if not discrete.watch.feasible:
        return found
    free = {name for name, rod in discrete.model.rods.items() if rod.elements is None}
    for _ in range(MOST_MESHES):
        coarse = divisions_of(discrete.problem)
        finer = discrete.on_mesh({name: division.halved() for name, division in coarse.items()})
        try:
            other = analysis(finer, settings)
        except SolveError as error:
            known = json.loads(found.data.attrs.get("warnings", "[]"))
            note = f"errors of the mesh were not estimated, the finer one beside it has no result: {error}"
            found.data.attrs["warnings"] = json.dumps([*known, note])
            return found
        found, errors = compared(found, other)
        worst = float(errors.max(initial=0.0))
        # high modes of a rod that tapers to a point change little at first, before its mesh reaches them
        stuck, before = (stuck + 1 if worst > GAIN * before else 0), worst
        if worst <= settings.accuracy or not free or stuck > 1 or finer.problem.size > MOST_CHOSEN_NODES:
            return found
        if len(free) == len(coarse):
            discrete, found = finer, other
        else:
            halved = {name: d.halved() if name in free else d for name, d in coarse.items()}
            discrete = discrete.on_mesh(halved)
            found = analysis(discrete, settings)
    return found


def refined_response(
    analysis: Callable[[DiscreteModel, ResponseSettings], FrequencyResponse],
    discrete: DiscreteModel,
    settings: ResponseSettings,
) -> FrequencyResponse:
    """Compute responses on a mesh that resolves the resonances up to the highest frequency.

    While an undamped frequency in the band differs by more than ``accuracy`` from that of the mesh with all elements
    halved, and the program may choose the mesh of a rod, the finer mesh is taken. The result keeps the difference.
    """
    discrete, errors = _resolving(discrete, settings.highest, settings.accuracy)
    try:
        found, _ = on_fine_enough(analysis, discrete, settings)
    except SolveError as error:
        if isinstance(error.run, FrequencyResponse):
            error.run.data.attrs["frequency_error"] = errors
        raise
    found.data.attrs["frequency_error"] = errors
    return found


def refined_periodic(
    analysis: Callable[[DiscreteModel, PeriodicSettings], Periodic],
    discrete: DiscreteModel,
    settings: PeriodicSettings,
) -> Periodic:
    """Compute periodic motions on a mesh that resolves vibrations as high as they are; see :func:`refined_response`."""
    highest = max(
        settings.frequencies or (settings.frequency or 0.0,)
    )  # of free vibrations the first is compared
    discrete, errors = _resolving(discrete, highest, settings.accuracy)
    found, _ = on_fine_enough(analysis, discrete, settings)
    found.data.attrs["frequency_error"] = errors
    return found


def _resolving(discrete: DiscreteModel, highest: float, accuracy: float) -> tuple[DiscreteModel, float]:
    """Return the model on a mesh that resolves vibrations up to a frequency [Hz], and the largest difference."""
    free = {name for name, rod in discrete.model.rods.items() if rod.elements is None}
    errors = 0.0
    for _ in range(MOST_MESHES if discrete.watch.feasible else 0):
        coarse = divisions_of(discrete.problem)
        finer = discrete.on_mesh({name: division.halved() for name, division in coarse.items()})
        errors = _differences(discrete, finer, highest)
        if errors <= accuracy or not free or finer.problem.size > MOST_CHOSEN_NODES:
            break
        discrete = discrete.on_mesh({n: d.halved() if n in free else d for n, d in coarse.items()})
    return discrete, errors


def _differences(discrete: DiscreteModel, finer: DiscreteModel, highest: float) -> float:
    """Return the largest relative difference of the frequencies up to ``highest`` [Hz], undamped and unloaded."""
    found: list[Floats] = []
    for one in (discrete, finer):
        linear = linearise(one.static, State.reference(one.problem), scale=0.0)
        count = 8
        while True:
            omega = natural_frequencies(linear, min(count, linear.motions))
            if omega[-1] > 2.0 * np.pi * highest or count >= min(linear.motions, MOST_COMPARED):
                break
            count *= 2
        found.append(omega)
    pairs = min(map(len, found))
    mine, better = found[0][:pairs], found[1][:pairs]
    kept = np.flatnonzero((mine > RIGID * mine[-1]) & (better <= 2.0 * np.pi * highest))
    if not len(kept):
        kept = np.flatnonzero(mine > RIGID * mine[-1])[:1]  # the next one shapes the response below it
    return float((np.abs(mine[kept] - better[kept]) / better[kept]).max(initial=0.0))


def frequency_errors(found: Modes, other: Modes) -> Floats:
    """Return how far each frequency is from that of the ``other`` modes, in parts of it.

    Oscillating modes are compared in their order, so that a missing or an invented one shows. Overdamped ones crowd,
    the more the finer the mesh is: each is compared with the nearest.
    """
    s, better = found.eigenvalues, other.eigenvalues
    highest = max(np.abs(s).max(initial=0.0), np.abs(better).max(initial=0.0))
    floor = max(RIGID * highest, np.finfo(float).tiny)
    oscillating, theirs = (np.flatnonzero(np.abs(x.imag) > RIGID * np.abs(x)) for x in (s, better))
    nearest = np.abs(s[:, None] - better[None, :]).min(axis=1, initial=np.inf)
    errors = nearest / np.maximum(np.abs(s), floor)
    paired = min(len(oscillating), len(theirs))
    mine, theirs = oscillating[:paired], theirs[:paired]
    size = np.maximum(np.abs(better[theirs]), floor)
    errors[mine] = np.abs(np.abs(s[mine]) - np.abs(better[theirs])) / size
    return np.asarray(errors)
