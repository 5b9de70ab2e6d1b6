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
from viscorod.analyses.derivatives.moved_steps import moves_corners
from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import Fault, InputError, SolveError
from viscorod.mechanics.rotations.nodal_motion import pose_differences
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.run import Run
from viscorod.solve.constraints.projection import start_consistently
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.sensitivity import motion_sensitivity
from viscorod.solve.sensitivity.closed_states import ClosedStates
from viscorod.solve.sensitivity.equilibrium_sensitivity import EquilibriumSensitivity, actions_of
from viscorod.solve.sensitivity.motion_sensitivity import KeptSteps, MotionGradient
from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.sensitivity.stage_residuals import stage_residual
from viscorod.solve.sensitivity.step_linearisation import StepLinearisation
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

    @classmethod
    def of(cls, model: ModelDescription, key: str, discrete: DiscreteModel, change: float) -> _Number:
        """Return a number that changes by a part of it.

        Places are told by more neighbours: at one motion what they strain, and start from, is large and nearly cancels.
        """
        few = Neighbours.of(model, key, discrete, change)
        kind = kind_of(discrete.problem, few)
        return cls(Neighbours.of(model, key, discrete, many=change) if kind is Kind.MORE else few, kind)


class _Start(NamedTuple):
    """What a number changes of the state that a motion starts from.

    What an equilibrium changes to first order is known without solving for a neighbour. Where a rod hangs still the
    change of the start and that of the loads nearly cancel, and what two neighbours have of third order would remain.

    Attributes:
        pose: body increments of all nodes ``(n, 6)`` per unit of the number, of a start at rest.
        states: in which neighbours start, of any other.
    """

    pose: Floats | None = None
    states: Sequence[State] = ()

    @classmethod
    def of(cls, start: MotionStart, number: _Number, *, resting: bool) -> _Start:
        """Return that of one number; nothing where it is known by arrays, or does not change."""
        if start.given or (resting and number.kind is Kind.ARRAYS):
            return cls()
        if resting and start.change is not None:
            return cls(start.change.increment(number.neighbours)[: start.discrete.problem.size])
        return cls(states=start.states(number.neighbours))

    def product(self, found: MotionGradient, neighbours: Neighbours, began: State) -> float:
        """Return the derivative by the number through the start."""
        total = 0.0 if self.pose is None else float(np.vdot(found.pose, self.pose))
        for one, given in zip(neighbours.each, self.states, strict=False):
            change, state = np.empty_like(began.twist), _consistent(one, given)
            pose_differences(began.r, began.q, state.r, state.q, change)
            by = np.vdot(found.pose, change) + np.vdot(found.twist, state.twist - began.twist)
            total += one.weight * float(by)
        return total


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
    state = _consistent(discrete, start.own())
    began = state.copy()
    motion = Retraced(discrete.problem, steps, ends, np.zeros(1))
    _ask(steps)
    numbers = [_Number.of(model, key, discrete, change_of(len(ends))) for key in keys]
    for number in numbers:
        if any(
            moves_corners(discrete.problem.breakpoints, one.problem.breakpoints)
            for one in number.neighbours.each
        ):
            why = "it moves jumps or corners of loads or motions within the steps, which its adjoint does not see"
            raise UnknownAdjointError(Fault("keys", number.neighbours.number.key, why, "take differences"))
    if discrete.problem.relaxing and (more := [one for one in numbers if one.kind is Kind.MORE]):
        key, why = (
            more[0].neighbours.number.key,
            "with Maxwell branches only numbers of materials, sections, inertia, ",
        )
        raise UnknownAdjointError(
            Fault("keys", key, f"{why}rest strains and loads have an adjoint", "take differences")
        )
    resting = start.change is not None and not began.twist.any()
    # before the steps, which take the scales of multipliers over
    starts = [_Start.of(start, one, resting=resting) for one in numbers]
    stuck = side_by_side([motion], [state], settings.duration)
    _ask(steps)
    if stuck is not None:
        raise SolveError(
            f"The motion has no gradient: the step to {motion.integrator.t:.6g} s ended as: "
            f"{motion.result.outcome.value}"
        )
    linear = StepLinearisation(steps.integrator)
    closing = ClosedStates(linear) if discrete.problem.multipliers else None
    back = _WayBack(settings, linear, [one for one in numbers if one.kind is not Kind.ARRAYS])
    stored = StoredWeights(
        StationReader(discrete.problem),
        np.asarray(run.time),
        weights,
        run.data["rotation"].values,
        steps.integrator.body.split,
        steps.integrator.tableau,
        discrete.problem.length,
        closing,
    )
    adding = back.add if back.numbers else None
    first = None if closing is None else linear
    found = motion_sensitivity.gradient(steps, stored.seen, adding, loads=False, linear=first)
    if closing is not None:
        np.add(found.arrays.reference, closing.reference, out=found.arrays.reference)
    if resting:
        at = EquilibriumSensitivity(discrete.static, began)
        found.arrays.add(at.adjoint(found.pose))
    totals = iter(back.totals)
    gradient = []
    for one, other in zip(numbers, starts, strict=True):
        arrays = one.kind is Kind.ARRAYS
        total = found.arrays.product(array_changes(one.neighbours)) if arrays else next(totals)
        total += other.product(found, one.neighbours, began)
        if one.kind is Kind.MORE:
            each = one.neighbours.each
            total += sum(near.weight * stored.value(StationReader(near.problem)) for near in each)
            if closing is not None:
                total += sum(near.weight * closing.value(near.system.constraints) for near in each)
        gradient.append(total)
    return np.array(gradient)


def _ask(steps: KeptSteps) -> None:
    """Refuse steps that have no adjoint.

    Raises:
        UnknownAdjointError: of the model, of the method, or since velocities were corrected after a jump.
    """
    try:
        motion_sensitivity.require_known(steps)
    except InputError as error:
        raise UnknownAdjointError(error.problems) from None


def _consistent(one: Neighbour | DiscreteModel, state: State) -> State:
    """Return a state to start from with velocities that joints, held strains and supports allow, as a motion does."""
    if one.system.constraints.rows or len(one.supports.partial):
        actions = actions_of(one.system)  # the model's own matrix is kept
        actions.supports.update(0.0, False)
        actions.supports.prescribe(state)
        actions.supports.project_twists(state)
        actions.system.constraints.update(0.0)
        actions.system.impose_rest(Imposed(t=0.0))
        start_consistently(actions.system, actions.supports, state)
    return state


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
    if integrator.supports.moving and len(integrator.supports.partial):
        why = "states within steps are corrected where supports that move and leave a place free hold them"
        raise UnknownAdjointError(Fault("derivatives", "", why, "take differences"))
    if len(discrete.system.constraints.ball_motors.coordinates):
        why = "motors of ball joints measure from axes that turn"
        raise UnknownAdjointError(Fault("derivatives", "", why, "take differences"))
    found: Collocation = integrator
    return found


class _WayBack:
    """Adds up, step by step, what the scalar changes by through loads and through what no array tells.

    Attributes:
        totals: of all numbers that are neither.
    """

    def __init__(
        self, settings: SimulateSettings, linear: StepLinearisation, numbers: Sequence[_Number]
    ) -> None:
        self.numbers, self.totals = numbers, [0.0] * len(numbers)
        self._linear = linear
        self._loads: list[list[StepActions]] = []
        self._integrators: list[list[Integrator]] = []
        for number in numbers:
            each, loads = number.neighbours.each, number.kind is Kind.LOADS
            self._loads.append([actions_of(one.system) for one in each] if loads else [])
            self._integrators.append([] if loads else [exact_integrator(one, settings) for one in each])

    def add(self, step: StageRecord, forces: Floats, lifted: Floats, ended: Floats) -> None:
        """Take one step, with the derivatives by its balances ``(s, N, 6)``, projected and as they are.

        Those by the twists at its end, which supports correct, are ``ended (n, 6)``.
        """
        for k, number in enumerate(self.numbers):
            each = number.neighbours.each
            for one, actions in zip(each, self._loads[k], strict=False):
                self.totals[k] -= one.weight * _work(actions, step, lifted)
            for one, integrator in zip(each, self._integrators[k], strict=False):
                assert isinstance(integrator, Collocation)
                residual = stage_residual(integrator, step, self._linear.arrays.scale)
                self.totals[k] += one.weight * float(np.vdot(forces, residual))
                if len(one.supports.partial):
                    end = State(step.r[-1], step.q[-1], step.twist[-1].copy())
                    one.supports.update(float(step.times[-1]), True)
                    one.supports.project_twists(end)
                    self.totals[k] += one.weight * float(np.vdot(ended, end.twist))


def _work(actions: StepActions, step: StageRecord, weights: Floats) -> float:
    """Return the sum of the loads at all stages of a step times ``weights (s, N, 6)``."""
    total = 0.0
    for i, t in enumerate(step.times):
        state, external = State(step.r[i], step.q[i], step.twist[i]), np.zeros_like(step.twist[i])
        last = i == len(step.times) - 1
        actions.add_loads(float(t), state, external, before=step.before and last)
        total += float(np.vdot(weights[i, : len(external)], external))
    return total
