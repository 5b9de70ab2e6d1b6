"""What the result of a motion says of how it was computed, and what is doubtful about it."""

from __future__ import annotations

import json
from collections.abc import MutableMapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion_stepping import integrates_strains
from viscorod.errors import warn
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_table import TimeTable
from viscorod.solve.problem.discretise import MANY_ROWS
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.amplitude import PART_OF_MOTION
from viscorod.solve.transient.motion_scale import PartOfMotion
from viscorod.solve.transient.pose_check import pose_gap
from viscorod.solve.transient.transient_solver import Transient

if TYPE_CHECKING:
    from viscorod.solve.reduced.reduced_motion import ReducedMotion

__all__ = ["begun_at_once", "blows", "described", "failure", "keep", "tell"]

LOOKS = 101
"""Times at which prescribed motions are looked at."""
ROUNDED = 1e-6
"""Part of the largest speed of a prescribed motion below which it begins at rest."""


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
    if settings.modes is not None:
        from viscorod.analyses.modal_reduction import told_of_modes

        found |= told_of_modes(settings, cast("ReducedMotion", transient.integrator))
    elif settings.dynamics == "nonlinear":
        systems = getattr(transient.integrator, "systems", None)  # of collocation methods, without held nodes
        plan = discrete.problem.plan if systems is None else systems.real.plan
        found["linear_solver"] = plan.description
    if integrates_strains(settings):
        found["pose_gap"], found["rotation_gap"] = pose_gap(discrete.system, transient.result.history)
    return found


def failure(discrete: DiscreteModel, transient: Transient) -> str:
    """Say why a motion ended before its time, and what to try; empty if it did not."""
    result = transient.result
    if result.outcome is Outcome.INTERRUPTED:
        return f"Stopped at t = {transient.integrator.t:.6g} s: {result.reason}"
    if result.outcome is not Outcome.COMPLETED:
        assert result.report is not None
        broken = result.outcome is Outcome.BROKEN
        place = _torn(discrete, transient) if broken else discrete.where(result.report)
        failed = "" if broken else f" (a step to {result.failed_at:.6g} s failed)"
        return (
            f"The motion could not be followed beyond t = {transient.integrator.t:.6g} s{failed}: "
            f"{result.outcome.value}.{place} What to try: {result.outcome.advice(static=False)}."
        )
    return ""


def _torn(discrete: DiscreteModel, transient: Transient) -> str:
    """Say in a sentence where shear and stretch of a rod are largest: no imbalance ended such a motion."""
    points = discrete.system.gauss_positions()
    strain = np.abs(transient.integrator.snapshot().strain[:, :3]).max(axis=1)
    k = int(np.nanargmax(strain)) if np.isfinite(strain).any() else 0
    return (
        f" The largest shear or stretch is that of {discrete.problem.rods[points.rod[k]]}@{points.s[k]:.6g}."
    )


def tell(attrs: MutableMapping[str, Any], doubt: str) -> None:
    """Keep a doubt among the warnings of a result, and show it."""
    if doubt:
        keep(attrs, doubt)
        warn(doubt)


def keep(attrs: MutableMapping[str, Any], doubt: str) -> None:
    """Keep a doubt, which has been shown, among the warnings of a result."""
    if doubt:
        attrs["warnings"] = json.dumps([*json.loads(attrs["warnings"]), doubt])


def blows(problem: Problem) -> str:
    """Return a warning if a support or motor moves along straight lines between many rows, else nothing."""
    for motion, place in _motions(problem):
        if isinstance(motion, TimeTable) and motion.straight and len(motion.knots) >= MANY_ROWS:
            return (
                f"the motion of {place} is a table of {len(motion.knots)} rows joined by "
                "straight lines: its velocity jumps at every row, each a blow; give interpolation = 'cubic'"
            )
    return ""


def begun_at_once(problem: Problem, duration: float) -> str:
    """Return a warning if a support or motor begins with a velocity, in a motion of ``duration`` [s], else nothing.

    It says why steps lose vibrations, where they do.
    """
    for motion, place in _motions(problem):
        rates = [abs(motion.rate(t)) for t in np.linspace(0.0, duration, LOOKS).tolist()]
        if rates[0] > ROUNDED * max(rates):
            return (
                f"the motion of {place} begins with a velocity at t = 0, a blow to what is at rest, which sends waves "
                "along the rods; let it begin smoothly, as SmoothRamp and SpinUp do, or a sine from where it turns "
                "back (phase = -pi/2 with offset = amplitude)"
            )
    return ""


def _motions(problem: Problem) -> list[tuple[TimeFunction, str]]:
    """Return all prescribed motions, of supports and of motors, and what they move."""
    held = [(motion, problem.supports.names[k]) for k, _, motion in problem.supports.motions]
    return held + [(motion, "a joint") for _, motion in problem.joints.motions]
