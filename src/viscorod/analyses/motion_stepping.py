"""How motions step: the integrator, the control of its steps, and what computes some of them again."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion_start import held_part
from viscorod.results.text_numbers import quantity
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import Linearisation
from viscorod.solve.modes.vibrations import natural_frequencies
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.transient.motion_scale import PartOfMotion, Tolerance
from viscorod.solve.transient.participation import Participation, participation, periods_set_off
from viscorod.solve.transient.step_control import ErrorControl, FixedSteps, KnownSteps, StepControl
from viscorod.solve.transient.time_step import choose_time_step

__all__ = ["halved_steps", "integrates_strains", "integrator_makers", "many_steps", "set_off", "stepping"]

LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
SEEN = 16
"""Slowest vibrations that equal steps are chosen by."""
MANY = 50_000
"""Steps of a run from which on it is said beforehand that there are so many."""
MANY_BESIDE_CREEP = MANY // 10
"""The same of vibrations that a start sets off in what relaxes, where creep may be all that is meant."""
STEPS_PER_RINGING = 10
"""Steps per period that a vibration which is not damped takes, about, by default; 7 to 30 were seen."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""


def integrator_makers(
    discrete: DiscreteModel, settings: SimulateSettings, state: State
) -> tuple[Callable[..., Integrator], Callable[..., Integrator]]:
    """Return what makes the integrator of a motion from a state, and a twin of it with a system of its own."""
    if settings.modes is not None:
        from viscorod.analyses.modal_reduction import reduced_makers

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
    start: State | None = None,
    modes: Callable[[], StartModes] | None = None,
) -> tuple[Integrator, StepControl, dict[str, Any]]:
    """Return integrator, step control and what was chosen, by name.

    Args:
        linear: returns small motions about the start, as stiff as vibrations see them; it is called where they are
            needed. So is ``modes``, which returns the slowest of them.
        start: where the motion begins; None: loads are not known beforehand.
    """
    method = INTEGRATORS[settings.integrator]
    duration = settings.duration
    tolerance: float | Tolerance | None = settings.tolerance
    if follows_vibrations(settings):
        tolerance = PartOfMotion(discrete.supports, linear(), duration)
    given: dict[str, Any] = dict(method.parameters)
    given |= {name: getattr(settings, name) for name in given if getattr(settings, name) is not None}
    known = discrete.options.step_ends
    if known:
        with_tolerance = {} if tolerance is None else {"tolerance": tolerance}
        return _unjudged(make(**given, **with_tolerance)), KnownSteps(known, duration), given
    if tolerance is not None:
        largest = settings.time_step or duration / LEAST_STEPS
        for period in discrete.problem.periods:
            largest = min(largest, period / STEPS_PER_PERIOD)
        integrator = make(**given, tolerance=tolerance)
        control: StepControl = ErrorControl(integrator.estimate_order, largest, duration)
        return integrator, control, given | {"largest_step": largest}
    step = settings.time_step
    if step is None:
        if start is not None and modes is not None and moved_by_loads(discrete, settings):
            seen = participation(discrete.problem, modes(), start, duration, held_part(settings))
        else:
            seen = Participation(natural_frequencies(linear(), SEEN), 0.0)
        step = choose_time_step(discrete.problem, seen.vibrations[:SEEN], duration, seen.rigid)
    return make(**given), FixedSteps(step), given | {"time_step": step}


def follows_vibrations(settings: SimulateSettings) -> bool:
    """Return whether small motions about the start say what steps may err by."""
    return settings.tolerance is None and INTEGRATORS[settings.integrator].tolerance is not None


def _unjudged(integrator: Integrator) -> Integrator:
    """Let the steps of an integrator err by anything; its iteration ends where its tolerance says."""
    if isinstance(integrator, GeneralizedAlpha):
        integrator.step_tolerance = None if integrator.step_tolerance is None else math.inf
    method: Any = integrator
    if hasattr(method, "step_factor"):
        method.step_factor = math.inf
    return integrator


def moved_by_loads(discrete: DiscreteModel, settings: SimulateSettings) -> bool:
    """Return whether loads that are known, and velocities at the start, are all that sets a motion off."""
    problem = discrete.problem
    driven = (
        problem.supports.motions or problem.joints.motions or any(s.changes for _, s in problem.rest_strains)
    )
    known = settings.start is None and not problem.initial_strain and not problem.functions
    return known and not driven and not problem.periods and settings.dynamics == "nonlinear"


def many_steps(
    control: StepControl,
    duration: float,
    settings: SimulateSettings,
    periods: Sequence[float] = (),
    ringing: tuple[float, float] = (0.0, 0.0),
    relaxes: bool = False,
) -> str:
    """Return a warning if steps that the program has chosen, or vibrations ask for, are very many, else nothing.

    Args:
        control: of the steps; duration: of the motion [s]; settings: of it.
        periods: of harmonic loads and motions [s].
        ringing: frequency [Hz] and number of periods of what the start sets off, see ``periods_set_off``.
        relaxes: whether rods have Maxwell branches, so that they creep.
    """
    method = INTEGRATORS[settings.integrator]
    if isinstance(control, ErrorControl):
        shortest = min(periods, default=math.inf)
        count = math.ceil(STEPS_PER_PERIOD * duration / shortest)
        if count < MANY:
            return _rings(*ringing, MANY_BESIDE_CREEP if relaxes else MANY)
        return (
            f"a load or motion of {quantity(1.0 / shortest, 'Hz', 3)} asks for at least {count} steps, "
            f"{STEPS_PER_PERIOD} of each period; if it is what is meant, frequency_response and periodic have the "
            "motion that lasts without the steps up to there"
        )
    if settings.time_step is not None or not isinstance(control, FixedSteps):
        return ""
    count = math.ceil(duration / control.time_step)
    if count < MANY:
        return ""
    return (
        f"{method.title} takes {count} equal steps of {quantity(control.time_step, 's', 2)}, which follow the "
        "vibrations about the start; integrator = 'radau' follows the motion that there is in far fewer, and time_step "
        "gives others"
    )


def set_off(
    discrete: DiscreteModel, settings: SimulateSettings, modes: Callable[[], StartModes], start: State
) -> tuple[float, float]:
    """Return frequency [Hz] and number of periods of what loads set off at the start; none if they are not known."""
    if not discrete.watch.affordable or not moved_by_loads(discrete, settings):
        return 0.0, 0.0
    return periods_set_off(discrete.problem, modes(), start, settings.duration, held_part(settings))


def _rings(frequency: float, periods: float, many: int) -> str:
    """Return a warning if the start sets off a vibration that asks for ``many`` steps or more, else nothing."""
    count = STEPS_PER_RINGING * periods
    if count < many:
        return ""
    return (
        f"what begins at once at the start lets the model ring at {quantity(frequency, 'Hz', 3)}, {periods:.2g} "
        f"periods long, as the material hardly damps it: that asks for some {count:.1g} steps; if a slow motion is "
        f"meant, such as creep, let the load grow over some periods (time = Ramp(0, {10.0 / frequency:.2g}))"
    )


def halved_steps(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    modes: Callable[[], StartModes],
    chosen: Mapping[str, Any],
    make: Callable[..., Integrator],
) -> HalvedSteps | None:
    """Return what computes some steps of a motion again, with solvers of its own; None for large models."""
    if not discrete.watch.affordable:
        return None
    method = INTEGRATORS[settings.integrator]
    given = {name: chosen[name] for name in method.parameters}
    tolerance = None if method.tolerance is None else settings.tolerance or method.tolerance
    if tolerance is not None:
        given["tolerance"] = tolerance
    return HalvedSteps(
        partial(make, **given),
        modes(),
        discrete.problem,
        method.order_with(given),
        tolerance=tolerance,
        strains=integrates_strains(settings),
        turning=settings.dynamics == "nonlinear",
    )


def integrates_strains(settings: SimulateSettings) -> bool:
    """Return whether strains are integrated in time beside the poses, so that both can be compared."""
    return settings.formulation == "intrinsic" and settings.dynamics == "nonlinear" and settings.modes is None
