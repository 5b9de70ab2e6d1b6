"""Motions in time."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.finer_run import mesh_matters, told_by_finer_run
from viscorod.analyses.folded_rods import FOLDED, folded
from viscorod.analyses.motion_attributes import begun_at_once, blows, described, failure, keep, tell
from viscorod.analyses.motion_events import monitors
from viscorod.analyses.motion_start import held_part, initial_state, small_motions
from viscorod.analyses.motion_stepping import (
    halved_steps,
    integrates_strains,
    integrator_makers,
    many_steps,
    set_off,
    stepping,
)
from viscorod.analyses.second_run import UNTOLD, SecondRun, is_needed, second_run, told_by_second_run
from viscorod.analyses.touching_coils import touching_in
from viscorod.errors import InputError, SolveError, warn
from viscorod.results.data_schema import annotated
from viscorod.results.dataset import state_arrays
from viscorod.results.files.gathered import Gathered
from viscorod.results.files.storage import read
from viscorod.results.files.stream import JournalStream, Stream
from viscorod.results.late_attributes import LateAttributes
from viscorod.results.result_warnings import energy_doubt
from viscorod.results.run import Run
from viscorod.results.state_arrays import StateArrays
from viscorod.results.step_error import force_doubt, motion_doubt
from viscorod.solve.history import History, Snapshot
from viscorod.solve.modes.linearisation import Linearisation
from viscorod.solve.modes.relaxing import Relaxing, vibrating
from viscorod.solve.refinement.noted_states import NotedStates
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.events import EventWatch
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.saved_state import restore, saved
from viscorod.solve.transient.step_errors import StepErrors, damped_by_steps
from viscorod.solve.transient.transient_solver import Transient

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["motion"]


def motion(discrete: DiscreteModel, settings: SimulateSettings) -> Run:
    """Compute a motion from t = 0 on; see ``Model.simulate``."""
    options = discrete.options
    labels = discrete.attributes | {"settings": json.dumps(settings.to_dict())}

    def build(history: History) -> xr.Dataset:
        return annotated(_arrays(discrete, history, labels).data_set(), "simulate", own=True)

    integrated = integrates_strains(settings)
    if options.folder is None:
        return _motion(discrete, settings, labels, Stream(Gathered(), build, sampled=integrated))
    stream = JournalStream(options.folder, build, dict(labels), resume=options.resume, sampled=integrated)
    try:
        if stream.doubt:
            warn(stream.doubt, at_once=True)
        return _motion(discrete, settings, labels, stream)
    finally:
        stream.journal.close()


def _motion(
    discrete: DiscreteModel, settings: SimulateSettings, labels: LateAttributes, stream: Stream
) -> Run:
    """Compute a motion, whose states go to a stream as they come.

    Args:
        labels: attributes that are known before it begins.
    """
    discrete.require_independent()
    options = discrete.options
    state, began_from = initial_state(discrete, settings)
    linear = cache(partial(small_motions, discrete, settings, state))
    if discrete.watch.affordable or settings.events or settings.modes or settings.dynamics == "linear":
        linear()
    else:  # where the stresses are those of the start in any case
        discrete.static.restore(state, 0.0, before=True, scale=held_part(settings))
    relaxing = cache(lambda: Relaxing.of(discrete.static.system, start, linear()))
    start = state.copy()
    makers = integrator_makers(discrete, settings, state)
    modes = cache(lambda: StartModes.of(linear(), relaxing()))

    def stiff() -> Linearisation:
        return vibrating(linear(), relaxing())

    integrator, control, chosen = stepping(discrete, settings, stiff, makers[0], start, modes)
    ringing = set_off(discrete, settings, modes, start)
    effort = many_steps(control, settings.duration, settings, discrete.problem.periods, ringing)
    if effort:
        warn(effort, at_once=True)
    halved = halved_steps(discrete, settings, modes, chosen, makers[1])
    transient = Transient(discrete.problem, integrator, control, halved)
    began = time.perf_counter()

    written = stream if isinstance(stream, JournalStream) else None
    begun = None if written is None else written.checkpoint

    def resumable() -> dict[str, Any]:
        return {
            "motion": transient.saved(),
            "watch": saved(discrete.watch.noted.saved() if discrete.watch.feasible else {}),
        }

    ends: list[float] = []
    noting = bool(options.derivatives) or options.note_steps

    def progress(end: float, h: float) -> None:
        ends.append(end)
        if options.progress is not None:
            options.progress(end, h)

    def after_step() -> str:
        if written is not None:
            written.after_step(resumable)
        if options.stop_folded and folded(integrator):
            return FOLDED
        return "" if options.stop is None else options.stop()

    if begun is not None and (noted := restore({}, begun["watch"])):
        discrete.watch.noted.take_over(noted)
    result = transient.run(
        state,
        settings.duration,
        output_interval=settings.output_interval,
        progress=progress if noting else options.progress,
        history=stream,
        checkpoint=None if begun is None else begun["motion"],
        after_step=after_step,
        patient=options.stop is None or getattr(options.stop, "patient", False),
        notes=_Noted(discrete.watch.noted, stream) if discrete.watch.feasible else None,
        watch=EventWatch(monitors(discrete, settings.events, linear)),
    )
    if result.reason == FOLDED:
        raise SolveError(failure(discrete, transient), coarse=True)
    loop_time = time.perf_counter() - began
    interrupted = result.outcome is Outcome.INTERRUPTED
    if written is not None and written.broken:
        raise InputError(result.reason)
    if written is not None and result.between_steps:
        written.save(resumable)
    attrs = (
        labels
        | chosen
        | {"began_from": began_from}
        | described(discrete, transient, settings, result.outcome)
    )
    attrs["loop_time_s"] = loop_time
    if halved is not None and result.outcome is Outcome.COMPLETED:
        errors = StepErrors.of(halved, discrete.problem, start, integrator.t)
        told, last, unknown = errors, (integrator.t, integrator.snapshot()), ""
        second: SecondRun | None = None
        if errors is not None and is_needed(discrete, settings, halved, errors):
            logging.getLogger("viscorod").info(
                "viscorod: the motion is computed again with smaller steps, for the errors of the first ones"
            )
            first = _recorded(discrete, stream, labels)
            second = second_run(discrete, settings, start, makers[1], stiff, modes, float(first.time[-1]))
            if second is None:
                unknown = UNTOLD
            else:
                told = told_by_second_run(discrete, errors, first, second)
        attrs |= _estimated_errors(discrete, settings, halved, last, (errors, told))
        tell(attrs, unknown)
        if second is not None and mesh_matters(discrete):
            of_mesh, unknown = told_by_finer_run(discrete, settings, second)
            attrs |= of_mesh
            tell(attrs, unknown)
    keep(attrs, effort)
    attrs["message"] = message = failure(discrete, transient)
    tell(attrs, blows(discrete.problem))
    if stream.whole:  # what was written to disk is not read again for this
        for text in touching_in(discrete.model.rods, discrete.problem, stream, "at {:.4g} s"):
            tell(attrs, text)
    tell(attrs, motion_doubt(attrs))
    tell(attrs, force_doubt(attrs))
    if settings.start is None and force_doubt(attrs):
        keep(attrs, begun_at_once(discrete.problem, settings.duration))
    run = _result(discrete, stream, attrs, interrupted=interrupted)
    run.ends_of_steps = np.array(ends)
    if message:
        raise SolveError(message, run)
    return run


def _estimated_errors(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    halved: HalvedSteps,
    last: tuple[float, Snapshot],
    errors: tuple[StepErrors | None, StepErrors | None],
) -> dict[str, Any]:
    """Return what a finished motion errs by, by its steps and by its mesh, as attributes.

    Args:
        last: time [s] and state at its end.
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


def _recorded(discrete: DiscreteModel, stream: Stream, labels: LateAttributes) -> Run:
    """Return all states of a run that is over, to be read, before its result is made."""
    if stream.whole:
        arrays = _arrays(discrete, stream, discrete.attributes | labels)
        return Run.later(lambda: arrays)
    stream.flush()
    return Run.owning(stream.contents())


def _result(discrete: DiscreteModel, stream: Stream, attrs: LateAttributes, *, interrupted: bool) -> Run:
    """Return the run of all states in a stream, in memory or on disk, with these attributes."""
    if interrupted:  # it goes on from the disk
        stream.flush()
    written = stream if isinstance(stream, JournalStream) else None
    if stream.whole:
        stream.truncate(len(stream.instant))  # an interrupt may have left a part of another one
        about = discrete.attributes | {"settings": attrs["settings"]} | discrete.complete(attrs)
        arrays = _arrays(discrete, stream, about)
        run = Run.later(lambda: arrays)
        tell(arrays.attrs, energy_doubt(arrays))
        if written is not None:
            written.write(run.stored)
        return run
    if written is None:
        stream.flush()
        data = stream.contents()
        data.attrs.update(discrete.complete(attrs))
        run = Run.owning(data)
        if not interrupted:
            tell(run.data.attrs, energy_doubt(run.data))
        return run
    written.flush()
    # a motion that was streamed is a file then, with a journal beside it where it can still go on
    keep(attrs, written.doubt)
    if not interrupted:
        tell(attrs, energy_doubt(written.contents().assign_attrs(attrs)))
    return Run(read(written.finish(dict(discrete.complete(attrs)), keep=interrupted)))


def _arrays(discrete: DiscreteModel, history: History, attrs: LateAttributes) -> StateArrays:
    """Return the arrays of a motion, which are copies of what a history recorded."""
    return state_arrays("simulate", discrete.problem, discrete.system.gauss_positions(), history, attrs)


class _Noted:
    """Notes states of a motion for the mesh watch."""

    def __init__(self, noted: NotedStates, stream: Stream) -> None:
        self.noted, self.stream = noted, stream

    def coming(self, steps: int) -> list[int]:
        """See ``transient_solver.Notes``."""
        return self.noted.coming(steps)

    def passed(self, steps: int, t: float, state: Callable[[], Snapshot]) -> None:
        """See ``transient_solver.Notes``."""
        self.noted.note(self.stream.start, t, state, steps)
