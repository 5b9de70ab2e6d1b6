"""Motions in time: where they start, how they step, what is watched, what comes out."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel, Progress
from viscorod.analyses.watching import monitors
from viscorod.errors import InputError, SolveError
from viscorod.mechanics.compilation.compiled import announce_formulation
from viscorod.mechanics.elements import intrinsic_element as intrinsic
from viscorod.results.data_schema import annotated
from viscorod.results.dataset import dataset
from viscorod.results.files.storage import read
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History
from viscorod.solve.modes import vibrations as small_motion
from viscorod.solve.problem.initial_shape import strain_rods
from viscorod.solve.settings import LEAST_TOLERANCE, SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.events import EventWatch
from viscorod.solve.transient.integrators import INTEGRATORS, LINEAR_INTEGRATORS, Integrator
from viscorod.solve.transient.pose_check import pose_gap
from viscorod.solve.transient.step_control import ErrorControl, FixedSteps, StepControl
from viscorod.solve.transient.time_step import choose_time_step
from viscorod.solve.transient.transient_solver import Transient

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.files.stream import Stream

__all__ = ["described", "failure", "initial_state", "simulate", "stepping"]

TOLERANCE = 1e-4
PART_OF_MOTION = 1e-3
"""Largest tolerance as a part of the displacement from which a free vibration starts."""
ROUND_OFF = 1e-9
"""Displacement over the size of the model that is none."""
SPECTRAL_RADIUS = 0.6
LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""


def simulate(
    work: DiscreteModel,
    settings: SimulateSettings,
    progress: Progress | None,
    attrs: dict[str, Any],
    stream: Stream | None = None,
    stop: Callable[[], str] | None = None,
) -> Run:
    """Compute the motion; see ``Model.simulate``.

    Args:
        settings, progress: as there; attrs: of the data set.
        stream: where states go as they come; without one they stay in memory.
        stop: called after every step; returns why the run is to stop, or nothing.
    """
    state = initial_state(work, settings)
    integrator, control, chosen = stepping(work, settings, state)
    transient = Transient(work.problem, integrator, control, work.system.describe_node)
    began = time.perf_counter()

    def build(history: History) -> xr.Dataset:
        data = dataset("simulate", work.problem, work.system.gauss_positions(), history, attrs)
        return annotated(data, "simulate")

    def after_step() -> str:
        if stream is not None:
            stream.after_step(build, transient.saved)
        return "" if stop is None else stop()

    result = transient.run(
        state,
        settings.duration,
        output_interval=settings.output_interval,
        progress=progress,
        history=stream,
        checkpoint=None if stream is None else stream.checkpoint,
        after_step=after_step,
        watch=EventWatch(monitors(work, settings, state)),
    )
    work.history = result.history
    if stream is not None and result.outcome is Outcome.INTERRUPTED:
        if stream.broken:
            raise InputError(result.reason)
        stream.save(build, transient.saved)
    attrs |= chosen | described(work, transient, settings, result.outcome, attrs)
    attrs["loop_time_s"] = time.perf_counter() - began
    message = failure(work, transient)
    run = _run(work, attrs | {"message": message}, stream, build, result.outcome is Outcome.INTERRUPTED)
    if message:
        raise SolveError(message, run)
    return run


def initial_state(work: DiscreteModel, settings: SimulateSettings) -> State:
    """The state that a motion starts from."""
    state = State.reference(work.problem)
    if work.problem.initial_strain:
        work.system.given_strain = strain_rods(work.system, state)
    elif settings.initial == "equilibrium":
        work.settle(state)
    else:
        work.require_closed()
    state.twist[:] = work.problem.initial_twist(state.r, state.q)
    if settings.formulation == "intrinsic":
        announce_formulation(intrinsic.forces_at)
    return state


def described(
    work: DiscreteModel,
    transient: Transient,
    settings: SimulateSettings,
    outcome: Outcome,
    attrs: dict[str, Any],
) -> dict[str, Any]:
    """What a result tells of how its motion was computed."""
    effort = transient.effort
    found: dict[str, Any] = {
        "outcome": outcome.name.lower(),
        "integrator": settings.integrator,
        "formulation": settings.formulation,
        "damping": settings.damping,
        "dynamics": settings.dynamics,
        "steps": effort.steps,
        "iterations": effort.iterations,
        "evaluations": effort.evaluations,
        "factorisations": effort.factorisations,
        "jacobians": effort.jacobians,
        "rejected": effort.rejected,
        "smallest_step": effort.smallest_step,
        "smallest_step_at": effort.smallest_at,
        "smallest_step_why": effort.smallest_why,
        "warnings": json.dumps([*json.loads(attrs.get("doubts", "[]")), *transient.notes]),
    }
    if settings.events:
        watch = transient.watch
        events = [{"time": t, "event": label} for t, label in zip(watch.times, watch.labels, strict=True)]
        found |= {"events": json.dumps(events), "ended_by": watch.ended_by}
    if work.system.constraints.rows:
        found["drift_position"], found["drift_velocity"] = transient.integrator.drift
    if settings.dynamics == "nonlinear":
        found["linear_solver"] = work.problem.plan.description
    if settings.formulation == "intrinsic" and settings.dynamics == "nonlinear":
        found["pose_gap"], found["rotation_gap"] = pose_gap(work.system, work.history)
    return found


def failure(work: DiscreteModel, transient: Transient) -> str:
    """Why a motion ended before its time, and what to try; empty if it did not."""
    result = transient.result
    if result.outcome is Outcome.INTERRUPTED:
        return f"Stopped at t = {transient.integrator.t:.6g} s: {result.reason}"
    if result.outcome is not Outcome.COMPLETED:
        assert result.report is not None
        return (
            f"The motion could not be followed beyond t = {transient.integrator.t:.6g} s "
            f"(a step to {result.failed_at:.6g} s failed): {result.outcome.value}.{work.where(result.report)} "
            f"What to try: {result.outcome.advice(static=False)}."
        )
    return ""


def _run(
    work: DiscreteModel,
    attrs: dict[str, Any],
    stream: Stream | None,
    build: Callable[[History], xr.Dataset],
    interrupted: bool,
) -> Run:
    """Return the result of a motion; one that was streamed is a file then, unless it can still go on."""
    if stream is None:
        return Run(work.dataset("simulate", attrs))
    stream.flush(build)
    return Run(read(stream.finish(work.complete(attrs), keep=interrupted)))


def stepping(
    work: DiscreteModel, settings: SimulateSettings, state: State
) -> tuple[Integrator, StepControl, dict[str, Any]]:
    """Return integrator, step control and what was chosen, by name."""
    tolerance, duration = settings.tolerance, settings.duration
    if settings.integrator == "radau" and tolerance is None:
        tolerance = _chosen_tolerance(work, state, duration)
    make = (LINEAR_INTEGRATORS if settings.dynamics == "linear" else INTEGRATORS)[settings.integrator]
    given: dict[str, Any] = {}
    if settings.integrator == "generalized_alpha":
        radius = settings.spectral_radius
        given["spectral_radius"] = SPECTRAL_RADIUS if radius is None else radius
    if tolerance is not None:
        largest = settings.time_step or duration / LEAST_STEPS
        for period in work.problem.periods:
            largest = min(largest, period / STEPS_PER_PERIOD)
        integrator = make(work.system, work.supports, **given, tolerance=tolerance)
        control: StepControl = ErrorControl(integrator.order, largest, duration)
        return integrator, control, given | {"tolerance": tolerance, "largest_step": largest}
    step = settings.time_step
    if step is None:
        linear = small_motion.linearise(
            work.static, state, scale=1.0 if settings.initial == "equilibrium" else 0.0
        )
        frequencies = small_motion.natural_frequencies(linear, 16)
        step = choose_time_step(work.problem, frequencies, duration)
    return make(work.system, work.supports, **given), FixedSteps(step), given | {"time_step": step}


def _chosen_tolerance(work: DiscreteModel, state: State, duration: float) -> float:
    """The usual tolerance, or less where a free vibration starts so near to rest that this would swallow it."""
    problem = work.problem
    loads = work.static.loads.at(0.0)
    later = any(0.0 < t < duration for t in problem.breakpoints) or problem.periods
    if not loads.none or later or work.supports.moving or problem.joints.motions or state.twist.any():
        return TOLERANCE
    moved = float(np.linalg.norm(state.r - problem.positions, axis=1).max()) / problem.length
    if moved < ROUND_OFF:
        return TOLERANCE
    return min(TOLERANCE, max(PART_OF_MOTION * moved, LEAST_TOLERANCE))
