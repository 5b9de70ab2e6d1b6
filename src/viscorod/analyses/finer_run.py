"""A motion computed once more on elements half as long: what its mesh errs by where states alone do not say.

The mesh is judged by some states of a motion: by what does not balance there on a finer mesh, with the inertial forces
of the coarse one (``solve.refinement``). Of parts that turn far and hang slack that says little: a rope that is let go
is pressed here and there, its stiffness is negative or next to nothing, and one state tells 40 times as much as the
next one, while errors that the motion makes grow are in none of them. The difference between two runs has both.
"""

from __future__ import annotations

import logging
from typing import Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion_start import MotionStart, initial_state
from viscorod.analyses.motion_stepping import integrator_makers
from viscorod.analyses.second_run import SecondRun, second_run
from viscorod.errors import InputError, SolveError
from viscorod.solve.problem.division import divisions_of
from viscorod.solve.settings.motion import SimulateSettings

__all__ = ["mesh_matters", "told_by_finer_run"]

NEGLIGIBLE = 1e-4
"""Error of positions by the mesh, as a part of the motion, up to which no finer mesh is tried."""
FASTER = 10.0 * np.pi
"""Angular frequency, times the duration, from which on motions about a start that was read begin in balance."""
UNTOLD = (
    "the run on a finer mesh, which tells what the mesh makes wrong of such a motion, did not come to its end: "
    "positions may be off by far more than is told; use more elements and compare"
)
"""What is told with a motion where states alone tell little of its mesh, and nothing else does."""


def mesh_matters(discrete: DiscreteModel) -> bool:
    """Return whether a mesh may make more than nothing wrong of a motion that needed a second run."""
    watch = discrete.watch
    return watch.feasible and (watch.lost > 0 or watch.estimate is None or watch.estimate.motion > NEGLIGIBLE)


def told_by_finer_run(
    discrete: DiscreteModel, settings: SimulateSettings, second: SecondRun
) -> tuple[dict[str, Any], str]:
    """Return what a motion errs by because of its mesh, as attributes, from its difference from a finer one.

    Both runs have the smaller steps, so that those of the first one have no part in it.

    Args:
        second: the motion with smaller steps.

    Returns:
        And what is not known, in words.
    """
    logging.getLogger("viscorod").info(
        "viscorod: the motion is computed again on elements half as long, for the errors of the mesh"
    )
    watch = discrete.watch
    try:
        other = _on_finer_mesh(discrete, settings, second)
    except (InputError, SolveError):  # it has no such start
        other = None
    if other is None:
        return watch.attributes, UNTOLD
    (here, states), (there, fine) = second.states(), other.states()
    finer = watch.finer
    r, _ = finer.interpolated(states.r[here], states.q[here])
    fine_r, _ = finer.stations(fine.r[there], fine.q[there])
    watch.see_runs(r, fine_r)
    return watch.attributes, ""


def _on_finer_mesh(
    discrete: DiscreteModel, settings: SimulateSettings, second: SecondRun
) -> SecondRun | None:
    """Compute the motion with the steps of the second run on elements half as long."""
    finer = discrete.on_mesh({name: one.halved() for name, one in divisions_of(discrete.problem).items()})
    start, _ = initial_state(finer, settings)
    if settings.start is not None:
        known = discrete.watch.noted.start
        found = None if known is None else discrete.watch.finer_start(known, (FASTER / second.times[-1]) ** 2)
        if found is None:
            return None
        start.r[:], start.q[:], start.multiplier[:] = found.r, found.q, found.multiplier
    begun = MotionStart(finer, settings, start)
    begun.small_motions()
    make = integrator_makers(finer, settings, start)[1]
    return second_run(finer, settings, begun, make, float(second.times[-1]), second.time_step)
