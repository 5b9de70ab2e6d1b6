"""Analyses on meshes that the program chooses: repeated on finer ones until the estimated error is as wanted."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.folded_rods import on_unfolded
from viscorod.errors import InputError, SolveError, last_warnings
from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.files.folder_lock import claimed
from viscorod.results.files.journal_folder import FOLDER
from viscorod.results.files.stored_journal import about
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.problem.division import Division, Divisions
from viscorod.solve.refinement.finer_divisions import MOST_CHOSEN_NODES
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.steady import SteadySettings

__all__ = ["GAIN", "MOST_MESHES", "on_fine_enough", "refined", "refined_motion"]

MOST_MESHES = 12
"""Meshes that are tried at most."""
MOST_REPEATS, REPEATED = 2, 10.0
"""Times that a motion is computed again, and by how many times its estimated error is too large then."""
MOST_INTRINSIC_NODES = 100
"""Nodes that steady rotations of the intrinsic formulation are refined to at most: it has full matrices."""
GAIN = 0.7
"""Part of the error before that refinement leaves at most, where it is the mesh that makes the error."""


S = TypeVar("S", bound=Meshed)
R = TypeVar("R")


def refined(analysis: Callable[[DiscreteModel, S], R], discrete: DiscreteModel, settings: S) -> R:
    """Run an analysis, again and again on finer meshes while its estimated error is larger than ``accuracy``.

    Rods whose elements are given keep them.
    """
    full = isinstance(settings, SteadySettings) and settings.formulation == "intrinsic"
    most = MOST_INTRINSIC_NODES if full else MOST_CHOSEN_NODES
    result, discrete = on_fine_enough(analysis, discrete, settings)
    stuck, before = 0, np.inf
    for _ in range(MOST_MESHES - 1):
        divisions, estimate = discrete.watch.refined(settings.accuracy, most=most), discrete.watch.estimate
        if estimate is not None:  # what does not fall is not the mesh's
            stuck, before = (stuck + 1 if estimate.largest > GAIN * before else 0), estimate.largest
        if divisions is None or stuck > 1:
            break
        discrete = discrete.on_mesh(divisions, result if isinstance(result, Equilibrium) else None)
        result, discrete = on_fine_enough(analysis, discrete, settings)
    return result


def on_fine_enough(
    analysis: Callable[[DiscreteModel, S], R],
    discrete: DiscreteModel,
    settings: S,
    *,
    failing: bool = False,
) -> tuple[R, DiscreteModel]:
    """Run an analysis, on elements half as long where these are too long to tell which way their nodes turn.

    Args:
        analysis: what is run; discrete, settings: its arguments.
        failing: whether it is run on elements half as long once more, too, where it fails for another reason.

    Returns:
        the result, and the model on the mesh that it has.

    Raises:
        SolveError: of the analysis, on the first mesh if another does not help; the program may not choose the mesh.
    """
    first: SolveError | None = None
    while True:
        try:
            return analysis(discrete, settings), discrete
        except SolveError as error:
            outcome = None if error.run is None else error.run.outcome
            if first is not None and outcome != "interrupted":
                raise first from None
            again = error.coarse or (failing and first is None and outcome == "failed")
            divisions = discrete.watch.halved() if again else None
            if divisions is None:
                raise
            first = None if error.coarse else error
        discrete = discrete.on_mesh(divisions)


def refined_motion(
    analysis: Callable[[DiscreteModel, SimulateSettings], Run],
    discrete: DiscreteModel,
    settings: SimulateSettings,
) -> Run:
    """Compute a motion on a mesh that resolves the state it starts from and the slowest vibrations about it.

    If its estimated error is still more than ``REPEATED`` times what is wanted, it is computed again on a finer mesh.
    """
    options = discrete.options
    if options.folder is None:
        if options.resume or options.anew:
            raise InputError(
                f"{'resume' if options.resume else 'anew'}: give the folder of the run that was stopped"
            )
        return _refined_motion(analysis, _prepared(discrete, settings), settings)
    if options.resume and options.anew:
        raise InputError("resume and anew: a run goes on or begins anew; give one of them")
    with claimed(options.folder, resume=options.resume, anew=options.anew):
        discrete = _resumed(discrete, options.folder) if options.resume else _prepared(discrete, settings)
        return _refined_motion(analysis, discrete, settings)


def _refined_motion(
    analysis: Callable[[DiscreteModel, SimulateSettings], Run],
    discrete: DiscreteModel,
    settings: SimulateSettings,
) -> Run:
    with last_warnings() as told:
        run, discrete = on_unfolded(analysis, discrete, settings)
        for _ in range(MOST_REPEATS):
            motion, forces = REPEATED * settings.mesh_accuracy, np.inf
            divisions = None if discrete.watch.unknown else discrete.watch.refined(motion, forces)
            if divisions is None:
                break
            logging.getLogger("viscorod").info(
                "viscorod: the mesh is too coarse for this motion; again on a finer one"
            )
            discrete = discrete.on_mesh(divisions)
            if discrete.options.resume:  # what was stopped is complete
                discrete = discrete.renewed(replace(discrete.options, resume=False), {})
            told.clear()
            run, discrete = on_unfolded(analysis, discrete, settings)
    return run


def _resumed(discrete: DiscreteModel, folder: Path) -> DiscreteModel:
    """Return the model on the mesh with which the motion in a folder began."""
    stored = json.loads(str(about(folder / FOLDER).get("divisions", "{}")))
    if not stored:
        return discrete
    return discrete.on_mesh({name: Division(order, np.array(ends)) for name, (order, ends) in stored.items()})


def _prepared(discrete: DiscreteModel, settings: SimulateSettings) -> DiscreteModel:
    """Return the model on a mesh that is fine enough for where its motion begins, as far as it may be chosen."""
    for _ in range(MOST_MESHES):
        if not discrete.watch.free or not discrete.watch.feasible or discrete.problem.initial_strain:
            break
        before = discrete.renewed(
            discrete.options, {}
        )  # its solvers keep stresses, those of the motion shall not
        try:
            divisions = _finer_start(before, settings)
        except (InputError, SolveError) as error:
            divisions = before.watch.halved() if isinstance(error, SolveError) and error.coarse else None
            if divisions is None:
                break  # the motion will say so
        if divisions is None:
            discrete.watch.share(before.watch)
            break
        discrete = discrete.on_mesh(divisions)
    return discrete


def _finer_start(discrete: DiscreteModel, settings: SimulateSettings) -> Divisions | None:
    """Return finer divisions if the state from which a motion starts, or the slowest vibrations about it, need them."""
    watch, resting = discrete.watch, settings.initial == "equilibrium"
    state = State.reference(discrete.problem)
    if resting:
        find_initial_equilibrium(discrete, state)
    discrete.static.restore(state, 0.0, before=True, scale=float(resting))
    snapshot = Snapshot.of(state, discrete.system, discrete.supports)
    if resting:
        watch.see(snapshot)
    divisions = watch.refined(settings.mesh_accuracy)
    if (
        divisions is None
        and watch.phases(discrete.static, snapshot, float(resting)).leading > settings.mesh_accuracy
    ):
        divisions = watch.halved()
    return divisions
