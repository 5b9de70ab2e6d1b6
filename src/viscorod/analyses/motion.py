"""Motions in time: where they start, how they step, what comes out."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import find_initial_equilibrium
from viscorod.analyses.modal_reduction import reduced_makers, told_of_modes
from viscorod.analyses.motion_events import monitors
from viscorod.analyses.start_state import StartState
from viscorod.analyses.start_velocities import blow_at_start
from viscorod.errors import InputError, SolveError, warn
from viscorod.mechanics.compilation.compiled import announce_formulation
from viscorod.mechanics.elements import intrinsic_element as intrinsic
from viscorod.mechanics.elements.maxwell_branches import remember
from viscorod.model.actions.time_table import TimeTable
from viscorod.results.data_schema import annotated
from viscorod.results.dataset import dataset
from viscorod.results.files.gathered import Gathered
from viscorod.results.files.storage import read
from viscorod.results.files.stream import JournalStream, Stream
from viscorod.results.result_warnings import energy_doubt
from viscorod.results.run import Run
from viscorod.results.step_error import force_doubt, motion_doubt
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.modes.relaxing import Relaxing, vibrating
from viscorod.solve.modes.vibrations import natural_frequencies
from viscorod.solve.problem.discretise import MANY_ROWS
from viscorod.solve.problem.initial_shape import strain_rods
from viscorod.solve.problem.problem import Problem
from viscorod.solve.reduced.reduced_motion import ReducedMotion
from viscorod.solve.refinement.mesh_watch import MeshWatch
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.amplitude import PART_OF_MOTION
from viscorod.solve.transient.events import EventWatch
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.motion_scale import PartOfMotion, Tolerance
from viscorod.solve.transient.pose_check import pose_gap
from viscorod.solve.transient.saved_state import restore, saved
from viscorod.solve.transient.step_control import ErrorControl, FixedSteps, StepControl
from viscorod.solve.transient.step_errors import StepErrors, damped_by_steps
from viscorod.solve.transient.time_step import choose_time_step
from viscorod.solve.transient.transient_solver import Transient

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "described",
    "failure",
    "initial_state",
    "integrator_makers",
    "motion",
    "small_motions",
    "small_vibrations",
    "stepping",
]

REACHED = 1e-6
"""Distance over the size of the model, or angle, by which a start may miss what supports and joints prescribe."""
LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
SEEN = 16
"""Slowest vibrations that equal steps are chosen by."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""


def motion(discrete: DiscreteModel, settings: SimulateSettings) -> Run:
    """Compute a motion from t = 0 on; see ``Model.simulate``."""
    options = discrete.options
    labels = discrete.attributes | {"settings": json.dumps(settings.to_dict())}

    def build(history: History) -> xr.Dataset:
        data = dataset("simulate", discrete.problem, discrete.system.gauss_positions(), history, labels)
        return annotated(data, "simulate", own=True)

    integrated = _integrates_strains(settings)
    if options.folder is None:
        return _motion(discrete, settings, labels, Stream(Gathered(), build, sampled=integrated))
    stream = JournalStream(options.folder, build, labels, resume=options.resume, sampled=integrated)
    try:
        if stream.doubt:
            warn(stream.doubt, at_once=True)
        return _motion(discrete, settings, labels, stream)
    finally:
        stream.journal.close()


def _motion(
    discrete: DiscreteModel, settings: SimulateSettings, labels: dict[str, str], stream: Stream
) -> Run:
    """Compute a motion, whose states go to a stream as they come.

    Args:
        labels: attributes that are known before it begins.
    """
    discrete.require_independent()
    options = discrete.options
    state, began_from = initial_state(discrete, settings)
    linear = cache(partial(small_motions, discrete, settings, state))
    if discrete.watch.feasible or settings.events or settings.modes or settings.dynamics == "linear":
        linear()
    else:  # where the stresses are those of the start in any case
        discrete.static.restore(state, 0.0, before=True, scale=_held_part(settings))
    relaxing = cache(lambda: Relaxing.of(discrete.static.system, start, linear()))
    start = state.copy()
    makers = integrator_makers(discrete, settings, state)
    integrator, control, chosen = stepping(
        discrete, settings, lambda: vibrating(linear(), relaxing()), makers[0]
    )
    halved = _halved_steps(discrete, settings, lambda: StartModes.of(linear(), relaxing()), chosen, makers[1])
    transient = Transient(discrete.problem, integrator, control, discrete.system.describe_node, halved)
    began = time.perf_counter()

    written = stream if isinstance(stream, JournalStream) else None
    begun = None if written is None else written.checkpoint

    def resumable() -> dict[str, Any]:
        return {"motion": transient.saved(), "watch": saved(discrete.watch.notes())}

    ends: list[float] = []

    def progress(end: float, h: float) -> None:
        if options.derivatives:
            ends.append(end)
        if options.progress is not None:
            options.progress(end, h)

    def after_step() -> str:
        if written is not None:
            written.after_step(resumable)
        return "" if options.stop is None else options.stop()

    if begun is not None:
        discrete.watch.take_over(restore({}, begun["watch"]))
    result = transient.run(
        state,
        settings.duration,
        output_interval=settings.output_interval,
        progress=progress if options.derivatives else options.progress,
        history=stream,
        checkpoint=None if begun is None else begun["motion"],
        after_step=after_step,
        patient=options.stop is None or getattr(options.stop, "patient", False),
        notes=_Noted(discrete.watch, stream),
        watch=EventWatch(monitors(discrete, settings.events, linear)),
    )
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
    attrs["loop_time_s"] = time.perf_counter() - began
    if halved is not None and result.outcome is Outcome.COMPLETED:
        errors = StepErrors.of(halved, discrete.problem, start, integrator.t)
        attrs |= {} if errors is None else errors.attributes
        watch = discrete.watch
        see = watch.see_motion if settings.dynamics == "nonlinear" else watch.see_linear_motion
        scale = float(settings.initial == "equilibrium")
        if settings.modes is None:  # what modes leave out is not in balance on any mesh
            see((integrator.t, integrator.snapshot()), discrete.static, scale, damped_by_steps(halved))
        attrs |= watch.attributes
    attrs["message"] = message = failure(discrete, transient)
    _tell(attrs, _blows(discrete.problem))
    _tell(attrs, motion_doubt(attrs))
    _tell(attrs, force_doubt(attrs))
    if interrupted:  # it goes on from the disk
        stream.flush()
    data = stream.in_memory()
    if data is not None:
        data.attrs.update(discrete.complete(attrs))
        run = Run.owning(data)
        if not interrupted:
            _tell(run.data.attrs, energy_doubt(run.data))
        if written is not None:
            written.write(run.data)
    else:
        assert written is not None
        # a motion that was streamed is a file then, with a journal beside it where it can still go on
        _keep(attrs, written.doubt)
        if not interrupted:
            _tell(attrs, energy_doubt(written.contents().assign_attrs(attrs)))
        run = Run(read(written.finish(discrete.complete(attrs), keep=interrupted)))
    run.ends_of_steps = np.array(ends)
    if message:
        raise SolveError(message, run)
    return run


class _Noted:
    """Lets the mesh watch note states of a motion."""

    def __init__(self, watch: MeshWatch, stream: Stream) -> None:
        self.watch, self.stream = watch, stream

    def coming(self, steps: int) -> list[int]:
        """See ``transient_solver.Notes``."""
        return self.watch.coming(steps)

    def passed(self, steps: int, t: float, state: Callable[[], Snapshot]) -> None:
        """See ``transient_solver.Notes``."""
        self.watch.note(self.stream.start, t, state, steps)


def _tell(attrs: dict[str, Any], doubt: str) -> None:
    """Keep a doubt among the warnings of a result, and show it."""
    if doubt:
        _keep(attrs, doubt)
        warn(doubt)


def _keep(attrs: dict[str, Any], doubt: str) -> None:
    """Keep a doubt, which has been shown, among the warnings of a result."""
    if doubt:
        attrs["warnings"] = json.dumps([*json.loads(attrs["warnings"]), doubt])


def _blows(problem: Problem) -> str:
    """Return a warning if a support or motor moves along straight lines between many rows, else nothing."""
    places = {id(motion): problem.supports.names[k] for k, _, motion in problem.supports.motions}
    motions = [motion for _, _, motion in problem.supports.motions] + [m for _, m in problem.joints.motions]
    for motion in motions:
        if isinstance(motion, TimeTable) and motion.straight and len(motion.knots) >= MANY_ROWS:
            return (
                f"the motion of {places.get(id(motion), 'a joint')} is a table of {len(motion.knots)} rows joined by "
                "straight lines: its velocity jumps at every row, each a blow; give interpolation = 'cubic'"
            )
    return ""


def initial_state(discrete: DiscreteModel, settings: SimulateSettings) -> tuple[State, str]:
    """Return the state that a motion starts from, and what it is in words."""
    state, text = State.reference(discrete.problem), "the reference shape"
    if settings.start is not None:
        found = StartState(discrete, settings.start)
        state, text = found.state, found.label
        _note(discrete, found.notes)
        _require_reached(discrete, state)
    elif discrete.problem.initial_strain:
        discrete.system.given_strain = strain_rods(discrete.system, state)
        text = "the initial strains"
    elif settings.initial == "equilibrium":
        search = find_initial_equilibrium(discrete, state)
        text = "the equilibrium" if search is None else f"the equilibrium, found by {search.found_by}"
    else:
        _require_closed(discrete)
    given = discrete.problem.initial_twist(state.r, state.q)
    if settings.start is None:
        state.twist[:] = given
        if given.any():
            _note(discrete, blow_at_start(discrete.system, discrete.supports, state), show=True)
    elif given.any():
        raise InputError(
            "velocities: the motion starts with the velocities of an earlier result; leave the initial velocities out, "
            "or start"
        )
    if settings.formulation == "intrinsic":
        announce_formulation(intrinsic.forces_at)
    if discrete.problem.relaxing and settings.dynamics == "nonlinear":
        announce_formulation(remember)
    return state, text


def _note(discrete: DiscreteModel, doubts: Sequence[str], *, show: bool = False) -> None:
    """Keep doubts about a start for the result, and ``show`` them: once, also if a finer mesh begins anew."""
    told = json.loads(discrete.attributes.get("doubts", "[]"))
    new = [doubt for doubt in doubts if doubt not in told]
    for doubt in new if show else ():
        warn(doubt)
    discrete.attributes["doubts"] = json.dumps([*told, *new])


def _require_reached(discrete: DiscreteModel, state: State) -> None:
    """Refuse a start in which supports or motors are not where their motions begin."""
    supports, constraints, length = discrete.supports, discrete.system.constraints, discrete.problem.length
    supports.update(0.0)
    constraints.update(0.0)
    gaps = np.abs(supports.set.fixed * (supports.measured(state) - supports.target))
    gaps[supports.set.in_body] = 0.0
    apart = {
        name: float(max(gap[:3].max() / length, gap[3:].max()))
        for name, gap in zip(supports.set.names, gaps, strict=True)
    }
    value, _, _ = constraints.measure(state)
    for c in np.flatnonzero(constraints.is_held):
        apart[constraints.joints.label(int(c))] = float(
            abs(value[c] - constraints.target[c]) / constraints.joints.unit[c]
        )
    wrong = [name for name, gap in apart.items() if gap > REACHED]
    if wrong:
        raise InputError(
            f"start: {', '.join(wrong[:6])} {'is' if len(wrong) == 1 else 'are'} elsewhere in the earlier result than "
            "this model prescribes at t = 0; let its motions begin at what they are there, or find the equilibrium "
            "from there first (equilibrium with start)"
        )


def _require_closed(discrete: DiscreteModel) -> None:
    """Refuse to start from a reference shape in which joints are open."""
    constraints = discrete.system.constraints
    constraints.update(0.0)
    gaps = constraints.open_joints(driven=constraints.driven)
    if gaps:
        raise InputError(
            f"initial = 'reference': joints are open in the reference shape: {', '.join(gaps)}. "
            "Start from the equilibrium (initial = 'equilibrium'), which closes them, move the parts so that they "
            "meet, or let motors begin at 0"
        )


def described(
    discrete: DiscreteModel,
    transient: Transient,
    settings: SimulateSettings,
    outcome: Outcome,
) -> dict[str, Any]:
    """Return the attributes of a result about how its motion was computed."""
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
        "warnings": json.dumps([*json.loads(discrete.attributes.get("doubts", "[]")), *effort.notes]),
    }
    tolerance = getattr(transient.integrator, "tolerance", None)
    if tolerance is not None:
        found["tolerance"] = tolerance if isinstance(tolerance, float) else tolerance.value
        if isinstance(tolerance, PartOfMotion):
            found["part_of_motion"] = PART_OF_MOTION
    if settings.events:
        watch = transient.watch
        events = [{"time": t, "event": label} for t, label in zip(watch.times, watch.labels, strict=True)]
        found |= {"events": json.dumps(events), "ended_by": watch.ended_by}
    if discrete.system.constraints.rows:
        found["drift_position"], found["drift_velocity"] = transient.integrator.drift
    if isinstance(transient.integrator, ReducedMotion):
        found |= told_of_modes(settings, transient.integrator)
    elif settings.dynamics == "nonlinear":
        systems = getattr(transient.integrator, "systems", None)  # of collocation methods, without held nodes
        plan = discrete.problem.plan if systems is None else systems.real.plan
        found["linear_solver"] = plan.description
    if _integrates_strains(settings):
        found["pose_gap"], found["rotation_gap"] = pose_gap(discrete.system, transient.result.history)
    return found


def _integrates_strains(settings: SimulateSettings) -> bool:
    """Return whether strains are integrated in time beside the poses, so that both can be compared."""
    return settings.formulation == "intrinsic" and settings.dynamics == "nonlinear" and settings.modes is None


def failure(discrete: DiscreteModel, transient: Transient) -> str:
    """Say why a motion ended before its time, and what to try; empty if it did not."""
    result = transient.result
    if result.outcome is Outcome.INTERRUPTED:
        return f"Stopped at t = {transient.integrator.t:.6g} s: {result.reason}"
    if result.outcome is not Outcome.COMPLETED:
        assert result.report is not None
        return (
            f"The motion could not be followed beyond t = {transient.integrator.t:.6g} s "
            f"(a step to {result.failed_at:.6g} s failed): {result.outcome.value}.{discrete.where(result.report)} "
            f"What to try: {result.outcome.advice(static=False)}."
        )
    return ""


def integrator_makers(
    discrete: DiscreteModel, settings: SimulateSettings, state: State
) -> tuple[Callable[..., Integrator], Callable[..., Integrator]]:
    """Return what makes the integrator of a motion from a state, and a twin of it with a system of its own."""
    if settings.modes is not None:
        return reduced_makers(discrete, settings, state)
    method = INTEGRATORS[settings.integrator]
    make: Any = method.make_linear if settings.dynamics == "linear" else method.make

    def twin(**given: Any) -> Integrator:
        system = FORMULATIONS[discrete.formulation].make(discrete.problem)
        system.given_strain = discrete.system.given_strain
        found: Integrator = make(system, SupportState(discrete.problem), **given)
        return found

    return partial(make, discrete.system, discrete.supports), twin


def stepping(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    linear: Callable[[], Linearisation],
    make: Callable[..., Integrator],
) -> tuple[Integrator, StepControl, dict[str, Any]]:
    """Return integrator, step control and what was chosen, by name.

    Args:
        linear: returns small motions about the start, as stiff as vibrations see them; it is called where they are
            needed.
    """
    method = INTEGRATORS[settings.integrator]
    duration = settings.duration
    tolerance: float | Tolerance | None = settings.tolerance
    if tolerance is None and method.tolerance is not None:
        tolerance = PartOfMotion(discrete.supports, linear(), duration)
    given: dict[str, Any] = dict(method.parameters)
    given |= {name: getattr(settings, name) for name in given if getattr(settings, name) is not None}
    if tolerance is not None:
        largest = settings.time_step or duration / LEAST_STEPS
        for period in discrete.problem.periods:
            largest = min(largest, period / STEPS_PER_PERIOD)
        integrator = make(**given, tolerance=tolerance)
        control: StepControl = ErrorControl(integrator.estimate_order, largest, duration)
        return integrator, control, given | {"largest_step": largest}
    step = settings.time_step
    if step is None:
        step = choose_time_step(discrete.problem, natural_frequencies(linear(), SEEN), duration)
    return make(**given), FixedSteps(step), given | {"time_step": step}


def _halved_steps(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    modes: Callable[[], StartModes],
    chosen: Mapping[str, Any],
    make: Callable[..., Integrator],
) -> HalvedSteps | None:
    """Return what computes some steps of a motion again, with solvers of its own; None for large models."""
    if not discrete.watch.feasible:
        return None
    method = INTEGRATORS[settings.integrator]
    given = {name: chosen[name] for name in method.parameters}
    if method.tolerance is not None:
        given["tolerance"] = settings.tolerance or method.tolerance
    twin = make(**given)
    strains = _integrates_strains(settings)
    order, turning = method.order_with(given), settings.dynamics == "nonlinear"
    return HalvedSteps(twin, modes(), discrete.problem, order, strains=strains, turning=turning)


def small_motions(discrete: DiscreteModel, settings: SimulateSettings, state: State) -> Linearisation:
    """Return small motions about the state that a motion starts from."""
    return linearise(discrete.static, state, scale=_held_part(settings))


def small_vibrations(discrete: DiscreteModel, settings: SimulateSettings, state: State) -> Linearisation:
    """Return the same, as stiff as the slowest vibration sees them."""
    linear = small_motions(discrete, settings, state)
    return vibrating(linear, Relaxing.of(discrete.static.system, state, linear))


def _held_part(settings: SimulateSettings) -> float:
    """Return which part of the loads just before t = 0 the start is in balance with."""
    return 1.0 if settings.initial == "equilibrium" or settings.start is not None else 0.0
