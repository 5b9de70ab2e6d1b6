"""How motions step: the integrator, the control of its steps, and what computes some of them again."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.modal_reduction import reduced_makers
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
from viscorod.solve.transient.motion_scale import PartOfMotion, Tolerance
from viscorod.solve.transient.step_control import ErrorControl, FixedSteps, StepControl
from viscorod.solve.transient.time_step import choose_time_step

__all__ = ["halved_steps", "integrates_strains", "integrator_makers", "stepping"]

LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
SEEN = 16
"""Slowest vibrations that equal steps are chosen by."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""


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


def halved_steps(
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
