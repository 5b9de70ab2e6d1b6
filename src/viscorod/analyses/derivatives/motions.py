"""How a motion changes with numbers of the case, with the steps that it was computed with.

The model with the number a little larger and smaller goes through the same steps, from the same kind of start, with an
iteration that goes on to round-off: what is left of the sizes of steps and of the iteration, which would hide a
derivative in the difference of two runs, is not in these (internal numerical differentiation, Bock 1981). What they
differ by is the derivative of the discrete equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from viscorod.analyses.derivatives.differentiate import attributes
from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.start_state import StartState
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.dataset import dataset
from viscorod.results.derivative import Derivative
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History
from viscorod.solve.problem.initial_shape import strain_rods
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.start import Start
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.given_steps import GivenSteps, Retraced
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.typing import Floats

__all__ = ["motion_derivatives"]

TOLERANCE = 1e-8
"""Of a method whose iteration goes on to a part of it: to round-off."""
ITERATIONS = 60
FEW_STEPS = 200
"""Steps from which on numbers change less: phases grow with the time, and with them what the scheme leaves."""

LITTLE, MORE = 2e-5, 20.0
"""Change of positions over the size of the model that is little, and how many times more a number changes then."""


def motion_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: SimulateSettings,
    run: Run,
    keys: Sequence[str],
) -> dict[str, Derivative[Run]]:
    """Return the derivatives of a motion at all its stored times."""
    _require_known(settings, keys)
    part = min(1.0, FEW_STEPS / max(len(run.ends_of_steps), 1))
    every = [Neighbours.of(model, key, discrete, part) for key in keys]
    start = _Start(discrete, settings, run)
    found: dict[str, Derivative[Run]] = {}
    for near in every:
        neighbours, runs = near, _runs(near, settings, start, run)
        if _hardly_moved(runs, discrete.problem.length):
            neighbours = Neighbours.of(model, near.number.key, discrete, part * MORE)
            runs = _runs(neighbours, settings, start, run)
        number, weights = neighbours.number, [one.weight for one in neighbours.each]
        parts = list(zip(weights, runs, strict=True))
        found[number.key] = Derivative(number.key, number.value, number.unit, run, parts)
    return found


def _runs(neighbours: Neighbours, settings: SimulateSettings, start: _Start, run: Run) -> list[Run]:
    """Return the motions of all neighbours."""
    found = []
    for one, state in zip(neighbours.each, start.states(neighbours), strict=True):
        history = _gone_through(one, settings, state, run, neighbours.number.key)
        found.append(
            Run(dataset("simulate", one.problem, one.system.gauss_positions(), history, attributes(run)))
        )
    return found


def _hardly_moved(runs: Sequence[Run], length: float) -> bool:
    """Return whether the motions of neighbours differ so little that round-off would show in their differences."""
    first, *others = (run.data["position"].values for run in runs)
    return max(float(np.abs(other - first).max()) for other in others) < LITTLE * length


def _require_known(settings: SimulateSettings, keys: Sequence[str]) -> None:
    """Refuse motions that have no derivatives here.

    Raises:
        InputError: of settings.
    """
    parts = {
        "modes": (settings.modes is not None, "the modes that a motion is sought in change too"),
        "events": (bool(settings.events), "the time of an event changes too"),
    }
    for name, (there, why) in parts.items():
        if there:
            raise InputError(Fault("derivatives", ", ".join(keys), why, f"leave {name} out"))


class _Start:
    """Where a motion and its neighbours begin."""

    def __init__(self, discrete: DiscreteModel, settings: SimulateSettings, run: Run) -> None:
        self.discrete, self.settings = discrete, settings
        self.state = StartState(discrete, Start(result=run, time=0.0)).state
        self.given = settings.start is not None
        self.strained = not self.given and bool(discrete.problem.initial_strain)
        resting = not self.given and not self.strained and settings.initial == "equilibrium"
        self.change: StaticChange | None = None
        if resting:
            still = self.state.copy()
            still.twist[:] = 0.0
            try:
                self.change = StaticChange(discrete, still, Instant())
            except SolveError:
                if not _free_of_load(discrete, still):
                    raise

    def states(self, neighbours: Neighbours) -> list[State]:
        """Return the states from which neighbours start."""
        increment = None if self.change is None else self.change.increment(neighbours)
        return [self._state(one, increment) for one in neighbours.each]

    def _state(self, one: Neighbour, increment: Floats | None) -> State:
        if self.given:
            return self.state.copy()
        state = State.reference(one.problem)
        if self.strained:
            one.system.given_strain = strain_rods(one.system, state)
        elif self.change is not None and increment is not None:
            one.system.constraints.near[:] = self.discrete.system.constraints.near
            state = self.change.moved(increment, one.change)
            report = one.static.newton(state, 0.0, before=True, scale=1.0)
            if not report.converged:
                raise SolveError(
                    "The equilibrium that the motion starts from has no derivatives: it was not found for a slightly "
                    f"different number.{self.discrete.where(report)}"
                )
        state.twist[:] = one.problem.initial_twist(state.r, state.q)
        return state


def _free_of_load(discrete: DiscreteModel, state: State) -> bool:
    """Return whether nothing acts on a model, whose reference shape is the equilibrium then."""
    discrete.static.restore(state, 0.0, before=True, scale=1.0)
    return discrete.static.loads.at(0.0, True).none and not discrete.supports.target.any()


def _gone_through(one: Neighbour, settings: SimulateSettings, state: State, run: Run, key: str) -> History:
    """Return the history of a neighbour with the steps and the stored times of a run."""
    integrator = _integrator(one, settings)
    transient = Retraced(one.problem, integrator, GivenSteps(run.ends_of_steps), run.time)
    result = transient.run(state, settings.duration, output_interval=settings.output_interval)
    if result.outcome is not Outcome.COMPLETED or result.history.count != len(run.time):
        raise SolveError(
            f"The motion has no derivative by {key}: with a slightly different number the step to "
            f"{integrator.t:.6g} s ended as: {result.outcome.value}"
        )
    return result.history


def _integrator(one: Neighbour, settings: SimulateSettings) -> Integrator:
    """Return the integrator of a run for a neighbour, with an iteration that goes on to round-off."""
    method = INTEGRATORS[settings.integrator]
    make: Any = method.make_linear if settings.dynamics == "linear" else method.make
    given: dict[str, Any] = dict(method.parameters)
    given |= {name: getattr(settings, name) for name in given if getattr(settings, name) is not None}
    if method.tolerance is not None:
        given["tolerance"] = TOLERANCE
    integrator: Any = make(one.system, one.supports, **given)
    if hasattr(integrator, "iterations"):
        integrator.iterations = ITERATIONS
    found: Integrator = integrator
    return found
