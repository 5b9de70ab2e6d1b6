"""A model that another program moves step by step: forces in, motion out, and back to an earlier state on request."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from viscorod.analyses.call_options import CallOptions
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.motion_attributes import blows, described, failure, keep
from viscorod.analyses.motion_start import MotionStart, initial_state
from viscorod.analyses.motion_stepping import integrator_makers, stepping
from viscorod.analyses.provenance import provenance
from viscorod.analyses.touching_coils import touching_in
from viscorod.argument_names import known_arguments
from viscorod.checks import checked
from viscorod.errors import InputError, SolveError
from viscorod.limits import SMALLEST_NUMBER
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.result_places import ResultPlace
from viscorod.results.run import Run
from viscorod.solve.history import StationReader
from viscorod.solve.settings.co_simulation import CoSimulationSettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.saved_state import SavedTree
from viscorod.solve.transient.step_control import ErrorControl
from viscorod.solve.transient.transient_solver import Transient
from viscorod.typing import Floats

__all__ = ["CoSimulation"]

NOT_ESTIMATED = (
    "errors of steps and of the mesh are not estimated in a co-simulation; model.simulate with similar forces as loads "
    "tells them"
)


@known_arguments
class CoSimulation:
    """A model between two steps of a coupled simulation.

    At each step, forces and moments at the ports are constant; the model's own loads and prescribed motions go on as
    they are. Within a step the integrator takes steps of its own.

    Args:
        discrete: the discretised model, with a load at every port that takes the present wrench from ``wrenches``.
        settings: of the co-simulation.
        wrenches: force [N] and moment [N m] at every port ``(6,)``, global axes; changed by :meth:`apply`.

    Attributes:
        time: reached so far [s].
    """

    def __init__(
        self, discrete: DiscreteModel, settings: CoSimulationSettings, wrenches: dict[str, Floats]
    ) -> None:
        discrete.require_independent()
        self.settings = settings
        self._discrete, self._wrenches = discrete, wrenches
        state, _ = initial_state(discrete, settings)
        integrator, control, self._chosen = stepping(
            discrete,
            settings,
            MotionStart(discrete, settings, state).vibrations,
            integrator_makers(discrete, settings, state)[0],
        )
        self._transient = Transient(discrete.problem, integrator, control)
        self._reader = StationReader(discrete.problem)
        self._places: dict[str, ResultPlace] = {}
        self._changed = False
        self._transient.begin(state)
        self._state: tuple[Floats, ...] | None = None

    @classmethod
    def of(
        cls, model: ModelDescription, settings: CoSimulationSettings, options: CallOptions | None = None
    ) -> CoSimulation:
        """Discretise a model with loads at the ports, and let it begin.

        Raises:
            InputError: the model or a setting is wrong, or a port is not a place.
        """
        wrenches = {port: np.zeros(6) for port in settings.ports}
        coupled = type(model).of(**model.parts())
        for port, wrench in wrenches.items():
            for component in range(3):
                axis = tuple(float(k == component) for k in range(3))
                coupled.force(port, axis, time=_entry(wrench, component))
                coupled.moment(port, axis, time=_entry(wrench, 3 + component))
        usual = INTEGRATORS[settings.integrator].tolerance
        if settings.tolerance is None and usual is not None:
            # not less for a start near to rest, as in motions: what the ports will do is not known
            settings = settings.model_copy(update={"tolerance": usual})
        discrete = DiscreteModel.of(coupled, settings, options)
        # results describe the model as it was given, without the loads at the ports
        given = ModelDescription.of(**model.parts())  # the model may change before they are read
        own = provenance(given, discrete.model, discrete.options.title, discrete.options.attributes)
        return cls(replace(discrete, attributes=discrete.attributes | own), settings, wrenches)

    @property
    def time(self) -> float:
        """Time reached so far [s]."""
        return float(self._transient.integrator.t)

    # --- in

    @checked
    def apply(
        self,
        port: str,
        force: Sequence[float] | Floats = (0.0, 0.0, 0.0),
        moment: Sequence[float] | Floats = (0.0, 0.0, 0.0),
    ) -> None:
        """Let a force [N] and a moment [N m], global axes, act at a port from now on.

        Raises:
            InputError: no such port, or no three finite numbers.
        """
        if port not in self._wrenches:
            known = ", ".join(self._wrenches) or "none was named"
            raise InputError(f"{port!r} is not a port of this co-simulation; the ports are: {known}")
        try:
            wrench = np.concatenate([np.asarray(force, dtype=float), np.asarray(moment, dtype=float)])
        except (TypeError, ValueError, OverflowError):
            wrench = np.zeros(0)
        if wrench.shape != (6,) or not np.isfinite(wrench).all():
            raise InputError(
                f"force = {force!r}, moment = {moment!r} at {port}: give three finite numbers each, N and N m"
            )
        self._changed = self._changed or not np.array_equal(wrench, self._wrenches[port])
        self._wrenches[port][:] = wrench

    # --- on

    @checked
    def step(self, duration: float) -> None:
        """Go on by ``duration`` [s] > 0.

        Raises:
            InputError: no such duration. SolveError: the motion could not be followed; ``run`` holds it up to there.
        """
        if duration < SMALLEST_NUMBER or self.time + duration == self.time:
            raise InputError(f"duration = {duration!r}: give a time > 0, s, that changes t = {self.time:g} s")
        transient, control = self._transient, self._transient.control
        if isinstance(control, ErrorControl):
            control.duration = float(duration)  # of which the smallest step is a part
        corners, jumps = transient.corners(self.time, self.time + float(duration))
        for corner in corners:
            if self._changed or self.time in jumps:
                transient.restart(self.time)
                self._changed = False
            begun = transient.effort.steps > 0
            control.begin(
                self.time, corner, first=None if begun else transient.integrator.first_step(float(duration))
            )
            self._state = None
            if not transient.integrate_to(corner):
                self._fail()

    def _fail(self) -> None:
        result, message = self._transient.result, failure(self._discrete, self._transient)
        raise SolveError(message, self._run(result.outcome, message))

    # --- out

    @checked
    def position(self, place: str) -> Floats:
        """Return the position of a place (3,) [m], global axes."""
        return self._at(place, 0)

    @checked
    def velocity(self, place: str) -> Floats:
        """Return the velocity of a place (3,) [m/s], global axes."""
        return self._at(place, 2)

    @checked
    def frame(self, place: str) -> Floats:
        """Return the directions d1, d2, d3 of a place (columns) in global axes (3, 3)."""
        quaternions = self._fields()[1]
        return np.asarray(matrices(self._place_at(place).rotation(quaternions)[None])[0])

    @checked
    def angular_velocity(self, place: str) -> Floats:
        """Return the angular velocity of a place (3,) [rad/s], global axes."""
        return np.asarray(self.frame(place) @ self._at(place, 3))

    def _at(self, place: str, field: int) -> Floats:
        return self._place_at(place).of(self._fields()[field])

    def _place_at(self, place: str) -> ResultPlace:
        if place not in self._places:
            self._places[place] = self._discrete.place(place)
        return self._places[place]

    def _fields(self) -> tuple[Floats, ...]:
        if self._state is None:
            state = self._transient.integrator.state
            self._state = self._reader.read(state.r, state.q, state.twist)
        return self._state

    # --- back

    def saved(self) -> SavedTree:
        """Return the present state, to come back to it: a step of an implicit coupling is taken again and again."""
        values = {port: wrench.copy() for port, wrench in self._wrenches.items()}
        history = self._transient.result.history
        return self._transient.saved(), values, self._changed, history.count

    def restore(self, state: SavedTree) -> None:
        """Come back to a state that :meth:`saved` returned; what was recorded since then is forgotten.

        Raises:
            InputError: it is none of this co-simulation.
        """
        if not (isinstance(state, tuple) and len(state) == 4 and isinstance(state[1], dict)):
            raise InputError(f"state: {type(state).__name__}: give back what saved() returned")
        tree, values, self._changed, count = state
        self._transient.resume(tree)
        for port, wrench in values.items():
            self._wrenches[port][:] = wrench
        self._transient.result.history.truncate(count)
        self._state = None

    # --- the end

    def run(self) -> Run:
        """Return the motion so far; its warnings tell what is doubtful, and that errors are not estimated."""
        return self._run(Outcome.COMPLETED, "")

    def _run(self, outcome: Outcome, message: str) -> Run:
        self._transient.update_counts()
        attrs: dict[str, Any] = {**self._chosen, "message": message}
        attrs |= described(self._discrete, self._transient, self.settings, outcome)
        problem, history = self._discrete.problem, self._transient.result.history
        for doubt in (
            NOT_ESTIMATED,
            blows(problem),
            *touching_in(self._discrete.model.rods, problem, history, "at {:.4g} s"),
        ):
            keep(attrs, doubt)
        return Run(self._discrete.data_set("simulate", history, attrs)())


def _entry(wrench: Floats, component: int) -> FunctionOfTime:
    """Return a function of time that is the present value of a component, whatever the time."""
    return FunctionOfTime(lambda _: float(wrench[component]))
