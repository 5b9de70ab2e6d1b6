"""A motion computed once more with smaller steps: what its steps err by where small motions about its start do not say.

Errors of steps are added up as those of small motions about the start are (``solve.transient.step_errors``). Of parts
that nothing holds and that turn far that is not true: a body that tumbles about its middle axis, or a double
pendulum, makes a thousand times as much of an error as a linear motion would. The difference from a second run has it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.folded_rods import FOLDED, folded
from viscorod.analyses.motion_start import MotionStart
from viscorod.analyses.motion_stepping import stepping
from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.results.between_records import Instants
from viscorod.results.probe import PartsRead
from viscorod.results.run import Run
from viscorod.results.step_error import MOTION
from viscorod.solve.history import History, Snapshots, station_reader
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.tangent import negative_eigenvalues
from viscorod.solve.transient.halved_steps import HalvedSteps
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.step_control import FixedSteps, StepControl
from viscorod.solve.transient.step_errors import FORCE_SAFETY, SAFETY, StepErrors
from viscorod.solve.transient.transient_solver import Transient
from viscorod.typing import Floats, Integers

__all__ = ["UNTOLD", "SecondRun", "is_needed", "second_run", "told_by_second_run"]

TURNED = 0.5
"""Rotation [rad] from which on parts that nothing holds have turned far."""
BENT = 1.0
"""Rotation [rad] from which on an estimate that would be warned of is looked at again, whatever holds the parts."""
SHALLOW = 0.01
"""Rotation [rad] up to which nothing is looked for through which a motion could snap."""
LEVELS = (0.3, 0.5)
"""Parts of the way to the farthest state at which it is looked whether a state would leave by itself."""
PART = 0.3
"""What steps of the second run may err by, over that of the first one."""
SHORTER = 0.5
"""Equal steps of the second run, over those of the first one."""
UNTOLD = (
    "the second run, which tells how much a motion makes errors of steps grow, did not come to its end: positions and "
    "rotations may be off by far more than is told; use a smaller tolerance and compare"
)
"""What is told with a motion where errors may have grown and it is not known by how much."""
INSTANTS = 200
"""Times at which both runs are compared, about."""


def is_needed(
    discrete: DiscreteModel, settings: SimulateSettings, halved: HalvedSteps, errors: StepErrors
) -> bool:
    """Return whether a linear sum of errors says too little of a motion, or doubts it where it means little."""
    if settings.dynamics == "linear" or settings.modes is not None:
        return False
    if settings.start is not None and halved.problem.relaxing:
        return False  # what branches hold there is known to the first run alone
    turned = float(errors.moved[1])
    free = halved.modes.rigid.shape[1] > 0
    if (free and turned > TURNED) or (turned > BENT and errors.motion > MOTION):
        return True
    if (halved.modes.decay < 0.0).any() and errors.motion > MOTION:
        return True  # what grows about the start need not go on growing, as on the way to a limit cycle
    return turned > SHALLOW and _passes_unstable_states(discrete, halved)


def _passes_unstable_states(discrete: DiscreteModel, halved: HalvedSteps) -> bool:
    """Return whether a motion goes through states from which it would leave by itself, as an arch that snaps does.

    Some are looked at on the way to where it is farthest from its start.
    """
    trials, begin = halved.trials, halved.start.r
    far = np.array([np.linalg.norm(state.r - begin) for state in trials.states])
    if not far.any():
        return False
    way = far[: int(np.argmax(far)) + 1] / far.max()
    for k in sorted({int(np.argmin(np.abs(way - level))) for level in LEVELS}):
        t, state = trials.times[k], trials.states[k]
        static = discrete.static
        static.restore(state, t, before=True, scale=1.0)
        if static.surely_stable(state, t, before=True, scale=1.0):
            continue
        if negative_eigenvalues(static.tangent_here(state, t, before=True, scale=1.0)):
            return True
    return False


class SecondRun(NamedTuple):
    """A motion that was computed again with smaller steps.

    Attributes:
        history: of it, with states at the ``times`` [s] ``(k,)``; time_step: of equal steps [s], None of others.
    """

    history: History
    times: Floats
    time_step: float | None

    def states(self) -> tuple[Integers, Snapshots]:
        """Return where among all states those at the times are ``(k,)``, and all of them."""
        there = np.searchsorted(self.history.instant, self.times * (1.0 - 1e-9))
        return there, self.history.states()


def second_run(
    discrete: DiscreteModel,
    settings: SimulateSettings,
    start: MotionStart,
    make: Callable[..., Integrator],
    end: float,
    time_step: float | None = None,
) -> SecondRun | None:
    """Compute a motion again with smaller steps.

    Args:
        start: of the motion; make: makes an integrator with a system of its own.
        end: of the motion [s], which an event may have ended.
        time_step: of equal steps [s]; None for smaller ones than those of the first run.

    Returns:
        None if it ends before its time.
    """
    integrator, control, _ = stepping(discrete, settings, start.vibrations, make, start.begin, start.modes)
    _sharpen(integrator, control)
    if isinstance(control, FixedSteps):
        control.time_step = time_step or control.time_step
    times = _times(settings, end)
    transient = Transient(discrete.problem, integrator, control)
    stop, progress = discrete.options.stop, discrete.options.progress

    def after_step() -> str:
        if discrete.options.stop_folded and folded(integrator):  # the first run did not
            return FOLDED
        return "" if stop is None else stop()

    result = transient.run(
        start.begin.copy(),
        end,
        output_interval=float(times[0]),
        progress=progress if getattr(progress, "again", False) else None,  # others count steps of the result
        after_step=after_step,
        patient=stop is None or getattr(stop, "patient", False),
    )
    if result.outcome is not Outcome.COMPLETED:
        return None
    return SecondRun(result.history, times, control.time_step if isinstance(control, FixedSteps) else None)


def told_by_second_run(
    discrete: DiscreteModel, errors: StepErrors, run: Run, second: SecondRun
) -> StepErrors:
    """Return the errors of the steps of a motion, from its difference from the same with smaller steps.

    Args:
        errors: that were added up; run: the motion; second: the same with smaller steps.
    """
    gap, forces = _apart(discrete, run, second)
    gap = np.minimum(SAFETY * gap, [np.inf, np.pi])
    return replace(errors, gap=gap, forces=np.maximum(errors.forces, FORCE_SAFETY * forces))


def _sharpen(integrator: Integrator, control: StepControl) -> None:
    """Let steps err by a part of what they may, or make them shorter."""
    if isinstance(control, FixedSteps):
        control.time_step *= SHORTER
    elif isinstance(integrator, Radau):
        integrator.step_factor *= PART
        integrator.newton_factor *= PART**integrator.newton_power
        integrator.newton_tolerance *= PART**integrator.newton_power
    elif isinstance(integrator, GeneralizedAlpha) and integrator.step_tolerance is not None:
        integrator.step_tolerance *= PART**1.5


def _times(settings: SimulateSettings, end: float) -> Floats:
    """Return times at which both runs are compared ``(k,)`` [s]: equal ones, stored where not all is, and the end."""
    interval = settings.output_interval
    if interval is None:
        return np.arange(1.0, INSTANTS + 1.0) * (end / INSTANTS)
    count = int(end / interval * (1.0 + 1e-12) + 1e-9)
    every = max(1, -(-count // INSTANTS))
    times = np.arange(1.0, count // every + 1.0) * (every * interval)
    # errors that grow are largest there
    return times if count and times[-1] > end * (1.0 - 1e-9) else np.append(times, end)


def _apart(discrete: DiscreteModel, run: Run, second: SecondRun) -> tuple[Floats, Floats]:
    """Return the largest differences of positions [m] and rotations [rad], and of section forces [N] and moments [N m].

    Args:
        run, second: the first one and the second one.
    """
    there, states = second.states()
    r, q, _, _ = station_reader(discrete.problem).read(states.r, states.q, states.twist)
    instants = Instants.of(run.time, second.times, run.step_ends)
    read = PartsRead(run, instants)
    moving = read.moving(np.arange(r.shape[1]))
    assert moving is not None
    poses = moving[0]
    far = float(np.linalg.norm(poses.position - r[there], axis=-1).max())
    turn = product(conjugate(q[there].reshape(-1, 4)), poses.rotation.reshape(-1, 4))
    sine = float(np.linalg.norm(turn[:, 1:], axis=1).max())
    forces = instants.fields(read.at("section_force", "point", np.arange(states.section_force.shape[1])))
    away = (forces - states.section_force[there]).reshape(-1, 2, 3)
    largest = np.linalg.norm(away, axis=2).max(axis=0, initial=0.0)
    return np.array([far, 2.0 * np.arcsin(min(sine, 1.0))]), np.asarray(largest)
