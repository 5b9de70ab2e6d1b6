"""The gradient of one scalar of a motion by any many numbers of the case, by the adjoint of its steps.

The motion is gone through again with its steps, and then backward once, whatever the number of numbers. What comes out
is how the scalar changes with the arrays of the discretised problem; with the derivatives of these by a number, for
which nothing is solved, follows that by the number. Loads, and what else no array tells, are evaluated for two
neighbours of the model on the way back.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from viscorod.analyses.derivatives.changed_arrays import Kind, array_changes, kind_of
from viscorod.analyses.derivatives.differentiate import on_mesh_of
from viscorod.analyses.derivatives.motions import MotionStart, change_of, exact_integrator, require_known
from viscorod.analyses.derivatives.neighbours import Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import Fault, InputError, SolveError
from viscorod.mechanics.rotations.nodal_motion import pose_differences
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.sensitivity import motion_sensitivity
from viscorod.solve.sensitivity.equilibrium_sensitivity import EquilibriumSensitivity, actions_of
from viscorod.solve.sensitivity.motion_sensitivity import KeptSteps, MotionGradient
from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.sensitivity.stage_residuals import stage_residual
from viscorod.solve.sensitivity.stored_states import READ, StoredWeights
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.given_steps import Retraced, side_by_side
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["UnknownAdjointError", "motion_gradient", "weights_of"]


CONVERGED = 1e-11
"""What iterations leave (displacement over model length, rotation in rad): about the error of the gradient."""


class UnknownAdjointError(InputError):
    """The adjoint of a motion is not known; neighbours of the model may tell its derivatives."""


class _Number(NamedTuple):
    """A number: its neighbours in the model, and what it changes."""

    neighbours: Neighbours
    kind: Kind


def weights_of(run: Run, given: Mapping[str, object]) -> dict[str, Floats]:
    """Return the derivatives of a scalar by what is stored of a run.

    Raises:
        InputError: they are not those of stored motion, or have another shape.
    """
    found = {}
    for name, values in given.items():
        if name not in READ:
            raise InputError(
                Fault(
                    "function", repr(name), "its adjoint is not known", f"differentiate by {', '.join(READ)}"
                )
            )
        array, shape = np.asarray(values, dtype=float), run.data[name].shape
        if array.shape != shape or not np.isfinite(array).all():
            why = f"run.data[{name!r}] is an array {shape}, of finite numbers"
            raise InputError(
                Fault("function", f"a derivative {array.shape}", why, "give one number for each")
            )
        found[name] = array
    return found


def motion_gradient(
    model: ModelDescription,
    settings: SimulateSettings,
    run: Run,
    ends: Sequence[float],
    keys: Sequence[str],
    weights: Mapping[str, Floats],
) -> Floats:
    """Return the derivatives ``(keys,)`` of a scalar by numbers of the case.

    Args:
        model: as its user made it; settings: of the motion; run: that it led to; ends: of its steps [s].
        keys: of the numbers.
        weights: derivatives of the scalar by what is stored, see :func:`weights_of`.

    Raises:
        InputError: there is no such number, or the motion has no derivatives.
        UnknownAdjointError: it has, but not here.
    """
    discrete = on_mesh_of(DiscreteModel.of(model, settings), run)
    require_known(settings, run, keys)
    steps = KeptSteps(_integrator(discrete, settings))
    start = MotionStart(discrete, settings, run)
    state = start.own()
    began = state.copy()
    motion = Retraced(discrete.problem, steps, ends, np.zeros(1))
    try:
        motion_sensitivity.require_known(steps)
        stuck = side_by_side([motion], [state], settings.duration)
        motion_sensitivity.require_known(steps)
    except InputError as error:
        raise UnknownAdjointError(error.problems) from None
    if stuck is not None:
        raise SolveError(
            f"The motion has no gradient: the step to {motion.integrator.t:.6g} s ended as: "
            f"{motion.result.outcome.value}"
        )
    few = change_of(len(ends))
    every = [Neighbours.of(model, key, discrete, few) for key in keys]
    numbers = [_Number(one, kind_of(discrete.problem, one)) for one in every]
    if discrete.problem.relaxing and (more := [one for one in numbers if one.kind is Kind.MORE]):
        key, why = (
            more[0].neighbours.number.key,
            "with Maxwell branches only numbers of materials, sections, inertia, ",
        )
        raise UnknownAdjointError(
            Fault("keys", key, f"{why}rest strains and loads have an adjoint", "take differences")
        )
    back = _WayBack(discrete, settings, [one for one in numbers if one.kind is not Kind.ARRAYS])
    stored = StoredWeights(
        StationReader(discrete.problem),
        np.asarray(run.time),
        weights,
        run.data["rotation"].values,
        steps.integrator.body.split,
        steps.integrator.tableau,
        discrete.problem.length,
    )
    adding = back.add if back.numbers else None
    found = motion_sensitivity.gradient(steps, stored.seen, adding, loads=False)
    resting = start.change is not None and not began.twist.any()
    if resting:
        at = EquilibriumSensitivity(discrete.static, began)
        found.arrays.add(at.adjoint(found.pose))
    totals = iter(back.totals)
    gradient = []
    for one in numbers:
        arrays = one.kind is Kind.ARRAYS
        total = found.arrays.product(array_changes(one.neighbours)) if arrays else next(totals)
        if not start.given and not (resting and arrays):
            total += _by_start(one.neighbours, found, start, began)
        if one.kind is Kind.MORE:
            each = one.neighbours.each
            total += sum(near.weight * stored.value(StationReader(near.problem)) for near in each)
        gradient.append(total)
    return np.array(gradient)


def _by_start(neighbours: Neighbours, found: MotionGradient, start: MotionStart, began: State) -> float:
    """Return the derivative by a number through the state that the motion starts from."""
    total = 0.0
    for one, state in zip(neighbours.each, start.states(neighbours), strict=True):
        change = np.empty_like(began.twist)
        pose_differences(began.r, began.q, state.r, state.q, change)
        by = np.vdot(found.pose, change) + np.vdot(found.twist, state.twist - began.twist)
        total += one.weight * float(by)
    return total


def _integrator(discrete: DiscreteModel, settings: SimulateSettings) -> Collocation:
    """Return the integrator of a motion.

    Raises:
        UnknownAdjointError: its steps are not linearised here.
    """
    integrator: Any = None
    if settings.dynamics != "linear":
        integrator = exact_integrator(discrete, settings)
    if isinstance(integrator, Collocation):
        integrator.newton_tolerance = CONVERGED
    if not isinstance(integrator, Collocation) or len(integrator.tableau.exact_inside):
        why = "only steps of radau with three stages have an adjoint here"
        raise UnknownAdjointError(Fault("integrator", settings.integrator, why, "take radau"))
    problem = discrete.problem
    if problem.multipliers or (integrator.supports.moving and len(integrator.supports.partial)):
        why = "states within steps are corrected where joints or held strains, or supports that move and leave a "
        raise UnknownAdjointError(Fault("derivatives", "", f"{why}place free, hold them", "take differences"))
    found: Collocation = integrator
    return found


class _WayBack:
    """Adds up, step by step, what the scalar changes by through loads and through what no array tells.

    Attributes:
        totals: of all numbers that are neither.
    """

    def __init__(
        self, discrete: DiscreteModel, settings: SimulateSettings, numbers: Sequence[_Number]
    ) -> None:
        self.numbers, self.totals = numbers, [0.0] * len(numbers)
        self._scale = discrete.system.constraints.scale
        self._loads: list[list[StepActions]] = []
        self._integrators: list[list[Integrator]] = []
        for number in numbers:
            each, loads = number.neighbours.each, number.kind is Kind.LOADS
            self._loads.append([actions_of(one.system) for one in each] if loads else [])
            self._integrators.append([] if loads else [exact_integrator(one, settings) for one in each])

    def add(self, step: StageRecord, forces: Floats, lifted: Floats) -> None:
        """Take one step, with the derivatives by its balances ``(s, N, 6)``, projected and as they are."""
        for k, number in enumerate(self.numbers):
            each = number.neighbours.each
            for one, actions in zip(each, self._loads[k], strict=False):
                self.totals[k] -= one.weight * _work(actions, step, lifted)
            for one, integrator in zip(each, self._integrators[k], strict=False):
                assert isinstance(integrator, Collocation)
                residual = stage_residual(integrator, step, self._scale)
                self.totals[k] += one.weight * float(np.vdot(forces, residual))


def _work(actions: StepActions, step: StageRecord, weights: Floats) -> float:
    """Return the sum of the loads at all stages of a step times ``weights (s, N, 6)``."""
    total = 0.0
    for i, t in enumerate(step.times):
        state, external = State(step.r[i], step.q[i], step.twist[i]), np.zeros_like(step.twist[i])
        last = i == len(step.times) - 1
        actions.add_loads(float(t), state, external, before=step.before and last)
        total += float(np.vdot(weights[i, : len(external)], external))
    return total
