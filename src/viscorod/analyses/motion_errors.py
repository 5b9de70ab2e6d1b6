"""What a finished motion errs by: by its steps, by its mesh, and by what the motion makes of both."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.finer_run import mesh_matters, told_by_finer_run
from viscorod.analyses.motion_attributes import tell
from viscorod.analyses.motion_start import MotionStart
from viscorod.analyses.second_run import UNTOLD, is_needed, second_run, told_by_second_run
from viscorod.results.late_attributes import LateAttributes
from viscorod.results.run import Run
from viscorod.solve.history import Snapshot
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.step_errors import StepErrors, damped_by_steps

__all__ = ["tell_errors"]


def tell_errors(
    attrs: LateAttributes,
    discrete: DiscreteModel,
    settings: SimulateSettings,
    start: MotionStart,
    twin: Callable[..., Integrator],
    halved: HalvedSteps,
    last: tuple[float, Snapshot],
    recorded: Callable[[], Run],
) -> LateAttributes:
    """Return the attributes of a motion with what it errs by, and tell what is not known of that.

    Where errors of steps do not add up as in small motions about the start, the motion is computed again with smaller
    steps, and once more on a finer mesh.

    Args:
        attrs: of the motion so far; start: of it; twin: makes its integrator with a system of its own.
        halved: what computed some of its steps again; last: time [s] and state at its end.
        recorded: returns the motion, to be compared with another.
    """
    summed = told = StepErrors.of(halved, discrete.problem, start.begin, last[0])
    second, unknown = None, ""
    if summed is not None and is_needed(discrete, settings, halved, summed):
        logging.getLogger("viscorod").info(
            "viscorod: the motion is computed again with smaller steps, for the errors of the first ones"
        )
        first = recorded()
        second = second_run(discrete, settings, start, twin, float(first.time[-1]))
        if second is None:
            unknown = UNTOLD
        else:
            told = told_by_second_run(discrete, summed, first, second)
    attrs |= _attributes(discrete, settings, halved, last, (summed, told))
    tell(attrs, unknown)
    if second is not None and mesh_matters(discrete):
        of_mesh, unknown = told_by_finer_run(discrete, settings, second)
        attrs |= of_mesh
        tell(attrs, unknown)
    return attrs


def _attributes(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    halved: HalvedSteps,
    last: tuple[float, Snapshot],
    errors: tuple[StepErrors | None, StepErrors | None],
) -> dict[str, Any]:
    """Return the errors of steps and mesh as attributes.

    Args:
        last: time [s] and state at the end.
        errors: of its steps, as they add up in small motions about its start, and as the motion makes them grow.
    """
    watch = discrete.watch
    summed, told = errors
    see = watch.see_motion if settings.dynamics == "nonlinear" else watch.see_linear_motion
    scale = float(settings.initial == "equilibrium")
    if settings.modes is None:  # what modes leave out is not in balance on any mesh
        see(last, discrete.static, scale, damped_by_steps(halved))
    if told is None or summed is None:
        return watch.attributes
    watch.grow(told.growth(summed))
    return told.attributes | watch.attributes
