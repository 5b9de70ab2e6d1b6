"""Motions in time."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.folded_rods import FOLDED, folded
from viscorod.analyses.motion_attributes import begun_at_once, blows, described, failure, keep, tell
from viscorod.analyses.motion_errors import tell_errors
from viscorod.analyses.motion_events import monitors
from viscorod.analyses.motion_start import MotionStart, held_part, initial_state
from viscorod.analyses.motion_stepping import (
    follows_vibrations,
    halved_steps,
    integrates_strains,
    integrator_makers,
    many_steps,
    set_off,
    stepping,
)
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
from viscorod.solve.refinement.noted_states import NotedStates
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.events import EventWatch
from viscorod.solve.transient.saved_state import SavedTree, restore, saved
from viscorod.solve.transient.transient_result import TransientResult
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
    computed = _Computation(discrete, settings, stream)
    outcome = computed.run().outcome
    attrs = labels | computed.attributes(outcome)
    if computed.halved is not None and outcome is Outcome.COMPLETED:
        attrs = tell_errors(
            attrs,
            discrete,
            settings,
            computed.start,
            computed.twin,
            computed.halved,
            computed.last,
            lambda: _recorded(discrete, stream, labels),
        )
    keep(attrs, computed.effort)
    attrs["message"] = message = failure(discrete, computed.transient)
    _tell_doubts(attrs, discrete, settings, stream)
    run = _result(discrete, stream, attrs, interrupted=outcome is Outcome.INTERRUPTED)
    run.ends_of_steps = np.array(computed.ends)
    if message:
        raise SolveError(message, run)
    return run


class _Computation:
    """The steps of a motion from where it starts, or from the checkpoint where an earlier run was stopped.

    Args:
        discrete: model; settings: of the motion; stream: where its states go to.

    Attributes:
        start: of the motion; twin: makes another integrator like its own, with a system of its own.
        chosen: what the program chose, by name; effort: a warning of very many steps, or nothing.
        halved: what computes some steps again, None if nothing does; ends: of all steps [s], if they are noted.
    """

    def __init__(self, discrete: DiscreteModel, settings: SimulateSettings, stream: Stream) -> None:
        discrete.require_independent()
        self.discrete, self.settings, self.stream = discrete, settings, stream
        self.journal = stream if isinstance(stream, JournalStream) else None
        self.start, self.began_from = self._start()
        start = self.start
        make, self.twin = integrator_makers(discrete, settings, start.state)
        integrator, control, self.chosen = stepping(
            discrete, settings, start.vibrations, make, start.begin, start.modes
        )
        ringing = set_off(discrete, settings, start.modes, start.begin)
        relaxes = any(part.branches.size for part in discrete.problem.sets)
        self.effort = many_steps(
            control, settings.duration, settings, discrete.problem.periods, ringing, relaxes
        )
        if self.effort:
            warn(self.effort, at_once=True)
        self.halved = halved_steps(discrete, settings, start.modes, self.chosen, self.twin)
        self.transient = Transient(discrete.problem, integrator, control, self.halved)
        self.ends: list[float] = []
        self.loop_time = 0.0

    def _start(self) -> tuple[MotionStart, str]:
        """Return where the motion starts, and what that is in words; the stresses are those of it then."""
        discrete, settings = self.discrete, self.settings
        state, text = initial_state(discrete, settings)
        start = MotionStart(discrete, settings, state)
        judged = discrete.watch.affordable or settings.events or settings.modes
        if judged or settings.dynamics == "linear" or follows_vibrations(settings):
            start.small_motions()
        else:
            discrete.static.restore(state, 0.0, before=True, scale=held_part(settings))
        return start, text

    def run(self) -> TransientResult:
        """Take the steps.

        Raises:
            InputError: the disk takes no more states.
            SolveError: elements fold, and the model is to be begun anew on shorter ones.
        """
        discrete, settings, options = self.discrete, self.settings, self.discrete.options
        noted = discrete.watch.noted if discrete.watch.feasible else None
        began, checkpoint = time.perf_counter(), self._checkpoint()
        result = self.transient.run(
            self.start.state,
            settings.duration,
            output_interval=settings.output_interval,
            progress=self._progress if options.derivatives or options.note_steps else options.progress,
            history=self.stream,
            checkpoint=checkpoint,
            after_step=self._after_step,
            patient=options.stop is None or getattr(options.stop, "patient", False),
            notes=None if noted is None else _Noted(noted, self.stream),
            watch=EventWatch(monitors(discrete, settings.events, self.start.small_motions)),
        )
        if result.reason == FOLDED:
            raise SolveError(failure(discrete, self.transient), coarse=True)
        self.loop_time = time.perf_counter() - began
        if self.journal is not None and self.journal.broken:
            raise InputError(result.reason)
        if self.journal is not None and result.between_steps:
            self.journal.save(self._resumable)
        return result

    @property
    def last(self) -> tuple[float, Snapshot]:
        """Time [s] and state that have been reached."""
        return self.transient.integrator.t, self.transient.integrator.snapshot()

    def attributes(self, outcome: Outcome) -> dict[str, Any]:
        """Return the attributes of the result about how it was computed."""
        about = described(self.discrete, self.transient, self.settings, outcome)
        return self.chosen | {"began_from": self.began_from} | about | {"loop_time_s": self.loop_time}

    def _checkpoint(self) -> SavedTree:
        """Take over the states that an earlier run noted; return what its integrator goes on from, None without one."""
        begun = None if self.journal is None else self.journal.checkpoint
        if begun is None:
            return None
        if noted := restore({}, begun["watch"]):
            self.discrete.watch.noted.take_over(noted)
        motion: SavedTree = begun["motion"]
        return motion

    def _resumable(self) -> dict[str, Any]:
        """Return what another run can go on from."""
        watch = self.discrete.watch
        return {
            "motion": self.transient.saved(),
            "watch": saved(watch.noted.saved() if watch.feasible else {}),
        }

    def _progress(self, end: float, h: float) -> None:
        """Note the end of a step [s], and pass it on with its length [s]."""
        self.ends.append(end)
        if self.discrete.options.progress is not None:
            self.discrete.options.progress(end, h)

    def _after_step(self) -> str:
        """Write what is due; return why the motion is to stop, or nothing."""
        options = self.discrete.options
        if self.journal is not None:
            self.journal.after_step(self._resumable)
        if options.stop_folded and folded(self.transient.integrator):
            return FOLDED
        return "" if options.stop is None else options.stop()


def _tell_doubts(
    attrs: LateAttributes, discrete: DiscreteModel, settings: SimulateSettings, stream: Stream
) -> None:
    """Tell what is doubtful about a motion whose errors are among its attributes."""
    tell(attrs, blows(discrete.problem))
    if stream.whole:  # what was written to disk is not read again for this
        for text in touching_in(discrete.model.rods, discrete.problem, stream, "at {:.4g} s"):
            tell(attrs, text)
    tell(attrs, motion_doubt(attrs))
    tell(attrs, force_doubt(attrs))
    if settings.start is None and force_doubt(attrs):
        keep(attrs, begun_at_once(discrete.problem, settings.duration))


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
