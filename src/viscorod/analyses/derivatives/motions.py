"""How a motion changes with numbers of the case, with the steps that it was computed with.

The model with the number a little larger and smaller goes through the same steps, from the same kind of start, all of
them side by side: what is left of the sizes of steps and of the iteration, which would hide a derivative in the
difference of two runs, is not in these (internal numerical differentiation, Bock 1981). What they differ by is the
derivative of the discrete equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from viscorod.analyses.derivatives.differentiate import derivative
from viscorod.analyses.derivatives.felt_forces import FeltForces
from viscorod.analyses.derivatives.moved_steps import moved_ends
from viscorod.analyses.derivatives.neighbours import CLOSE, Neighbour, Neighbours
from viscorod.analyses.derivatives.static_changes import Instant, StaticChange, settle
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.start_state import StartState
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.derivative import Derivative
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History
from viscorod.solve.problem.initial_shape import strain_rods
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.start import Start
from viscorod.solve.transient.corners import corners_of
from viscorod.solve.transient.given_steps import Retraced, side_by_side
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.company import Member
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.typing import Floats

__all__ = ["MotionStart", "change_of", "exact_integrator", "motion_derivatives", "require_known"]

TOLERANCE = 1e-8
"""Of a method that has one; it does not choose steps here."""
ROUNDING = 1e-13
"""What iterations leave (displacement over model length, rotation in rad)."""
ITERATIONS = 60
FEW_STEPS = 50
"""Steps from which on numbers change less: phases grow with the time, and with them what the scheme leaves."""

UNEVEN = ("midpoint",)
"""Methods whose section forces are quotients of small differences: few neighbours would show their rounding."""
LEAST, WANTED, MOST = 1e-6, 3e-6, 3e-4
"""Change of positions over the size of the model, which round-off would hide, which is good, and which is too large."""
LARGEST = 7e-4
"""Change of a number, as a part of it, that two neighbours differ by at most: what they leave of third order is about
the square of it, and half of the 1e-6 that is wanted is left for rounding."""
HIDDEN, FARTHEST = 3e-7, 1e-2
"""Change of positions over the size of the model, a millionth of which round-off (1e-13) nearly hides: a number that
changes them less has four neighbours, which may differ by so much of it."""
ROUNDED = 10.0
"""Times what round-off leaves in positions over a step it leaves in velocities: rates of polynomials through stages."""
STILL, HEARD, CLEAR = 1e-13, 6e-10, 2e-9
"""Change of velocities times a step, over the size of the model and :data:`ROUNDED`: below which there is none, below
which round-off (6e-16) is more than 1e-6 of it, and which is good."""
WEAK = ("damping", "inertia")
"""Words of keys of numbers that hardly matter in most motions: neighbours are as far apart as two may be at first."""
UNMOVED = 1e-11
"""Change of positions at rest over the size of the model, below which a number is felt in motion only."""
OPEN = 1e-9
"""Gap of a joint over the length of the model (in rad) from which on it is open."""
ALIKE = 0.5
"""Part by which another distance differs, at least, to be worth another motion."""


def motion_derivatives(
    model: ModelDescription,
    discrete: DiscreteModel,
    settings: SimulateSettings,
    run: Run,
    keys: Sequence[str],
) -> dict[str, Derivative[Run]]:
    """Return the derivatives of a motion at all its stored times."""
    require_known(settings, run, keys)
    close = None if settings.integrator in UNEVEN else change_of(len(run.ends_of_steps))
    start = MotionStart(discrete, settings, run)
    tried = [_Tried.of(model, key, discrete, close, start) for key in keys]
    histories = _histories([one.neighbours for one in tried], settings, start, run)
    again: dict[int, _Tried] = {}
    step = float(np.median(np.diff(run.ends_of_steps, prepend=0.0)))
    for k, (one, kept) in enumerate(zip(tried, histories, strict=True)):
        better = one.better(model, discrete, _apart(kept, discrete.problem.length, step))
        if better is not None:
            again[k] = better
    farther = [one.neighbours for one in again.values()]
    for k, kept in zip(again, _histories(farther, settings, start, run), strict=True):
        tried[k], histories[k] = again[k], kept
    every = [one.neighbours for one in tried]
    return {
        neighbours.number.key: derivative(neighbours, run, kept, Run)
        for neighbours, kept in zip(every, histories, strict=True)
    }


def change_of(steps: int) -> float:
    """Return by which part of it a number changes in a motion of so many steps."""
    return CLOSE * min(1.0, FEW_STEPS / max(steps, 1))


class _Apart(NamedTuple):
    """How far neighbours are apart: at places and in velocities, as for :data:`HEARD`; infinite if unknown."""

    places: float
    speeds: float = np.inf


class _Tried(NamedTuple):
    """Neighbours by one number, and the part of it that they differ by; None of those that suit any number."""

    neighbours: Neighbours
    part: float | None

    @classmethod
    def of(
        cls,
        model: ModelDescription,
        key: str,
        discrete: DiscreteModel,
        close: float | None,
        start: MotionStart,
    ) -> _Tried:
        """Return those to begin with: as far as what they change of the equilibrium at the start asks for."""
        if close is None:
            return cls(Neighbours.of(model, key, discrete), None)
        part = close * (LARGEST / CLOSE if any(word in key for word in WEAK) else 1.0)
        found = cls(Neighbours.of(model, key, discrete, part), part)
        moved = start.moved(found.neighbours)
        return found.better(model, discrete, _Apart(moved)) or found if moved > 0.0 else found

    def better(self, model: ModelDescription, discrete: DiscreteModel, apart: _Apart) -> _Tried | None:
        """Return others, if these are too close or too far ``apart``."""
        if self.part is None:
            return None
        places, speeds = max(apart.places, 1e-30), apart.speeds
        other, hidden = self.part * WANTED / places, places * LARGEST < HIDDEN * self.part
        if LEAST <= places <= MOST:
            if not STILL < speeds < HEARD:
                return None
            other = self.part * min(CLEAR / speeds, MOST / places)
            hidden = speeds * LARGEST < HEARD * self.part
        key, nearer = self.neighbours.number.key, min(other, LARGEST)
        if hidden:
            return _Tried(Neighbours.of(model, key, discrete, many=min(other, FARTHEST)), None)
        if abs(nearer - self.part) > ALIKE * self.part:
            return _Tried(Neighbours.of(model, key, discrete, nearer), nearer)
        return None


def _histories(
    every: Sequence[Neighbours], settings: SimulateSettings, start: MotionStart, run: Run
) -> list[list[History]]:
    """Return the motions of all neighbours, which go through the steps and the stored times of a run."""
    if not every:
        return []
    motions, states, members = [], [], []
    for number, neighbours in enumerate(every):
        for one, state in zip(neighbours.each, start.states(neighbours), strict=True):
            integrator = exact_integrator(one, settings)
            here, there = (
                corners_of(problem, 0.0, settings.duration, within=integrator.looks_within)[0]
                for problem in (start.discrete.problem, one.problem)
            )
            ends = moved_ends(neighbours.number.key, run.ends_of_steps, run.time, here, there)
            motions.append(Retraced(one.problem, integrator, ends, run.time))
            states.append(state)
            members.append(Member(number, one.change))
    stuck = side_by_side(motions, states, settings.duration, members)
    if stuck is not None:
        number = motions.index(stuck)
        keys = [neighbours.number.key for neighbours in every for _ in neighbours.each]
        raise SolveError(
            f"The motion has no derivative by {keys[number]}: with a slightly different number the step to "
            f"{stuck.integrator.t:.6g} s ended as: {stuck.result.outcome.value}"
        )
    left = iter(motions)
    return [[next(left).result.history for _ in neighbours.each] for neighbours in every]


def _apart(histories: Sequence[History], length: float, step: float) -> _Apart:
    """Return how far motions of neighbours are apart at most, over the size of the model; ``step``: a usual one [s]."""
    found = []
    for field in ("r", "twist"):
        each = (
            np.concatenate([getattr(one.states, field) for one in history.records]) for history in histories
        )
        first, *others = each
        changes = [np.abs(other - first).reshape(-1, first.shape[-1] // 3, 3) for other in others]
        found.append(np.max([change.max(axis=(0, 2)) for change in changes], axis=0))
    places, speeds = float(found[0][0]) / length, found[1] * step / ROUNDED
    speeds[0] /= length
    return _Apart(places, float(min((one for one in speeds if one > STILL), default=0.0)))


def require_known(settings: SimulateSettings, run: Run, keys: Sequence[str]) -> None:
    """Refuse motions that have no derivatives here.

    Raises:
        InputError: of settings.
    """
    parts = {
        "resume": (getattr(settings, "resume", False), "the steps before a motion was stopped are not known"),
        "modes": (settings.modes is not None, "the modes that a motion is sought in change too"),
        "events": (
            bool(run.stored.attrs.get("ended_by")),
            "an event ended the motion, at a time that changes too",
        ),
    }
    for name, (there, why) in parts.items():
        if there:
            raise InputError(Fault("derivatives", ", ".join(keys), why, f"leave {name} out"))


class MotionStart:
    """Where a motion and its neighbours begin."""

    def __init__(self, discrete: DiscreteModel, settings: SimulateSettings, run: Run) -> None:
        self.discrete, self.settings = discrete, settings
        self.state = StartState(discrete, Start(result=run, time=0.0)).state
        self.given = settings.start is not None
        self.strained = not self.given and bool(discrete.problem.initial_strain)
        resting = not self.given and not self.strained and settings.initial == "equilibrium"
        self.change: StaticChange | None = None
        self._known: dict[str, tuple[Neighbours, Floats]] = {}  # increments of the equilibrium
        still = self.state.copy()
        still.twist[:] = 0.0
        if resting and not _as_built(discrete, still):
            try:
                self.change = StaticChange(discrete, still, Instant())
            except SolveError:
                if not _free_of_load(discrete, still):
                    raise
        self._felt = None if self.change is None else FeltForces(discrete, run, self.change)

    def own(self) -> State:
        """Return the state that the motion itself starts from; an equilibrium is found to round-off."""
        discrete, state = self.discrete, self.state.copy()
        if self.strained:
            state = State.reference(discrete.problem)
            discrete.system.given_strain = strain_rods(discrete.system, state)
        elif self.change is not None:
            state = self.change.state.copy()
        if not self.given:
            state.twist[:] = discrete.problem.initial_twist(state.r, state.q)
        return state

    def states(self, neighbours: Neighbours) -> list[State]:
        """Return the states from which neighbours start."""
        increment = None if self.change is None else self._increment(neighbours)
        found = [self._state(one, increment) for one in neighbours.each]
        if not self.given and self.change is None:
            own = self._open(self.discrete, State.reference(self.discrete.problem))
            for one, state in zip(neighbours.each, found, strict=True):
                self._require_closed(neighbours.number.key, one, state, own)
        return found

    def moved(self, neighbours: Neighbours) -> float:
        """Return how far neighbours are apart, over the size of the model; 0 where nothing is known.

        That is at rest at the start, and in the motion if a number changes nothing there.
        """
        if self.change is None:
            return 0.0
        first, *others = neighbours.each
        apart = max(abs(one.change - first.change) for one in others)
        increment = self._increment(neighbours)[: self.discrete.problem.size, :3]
        found = apart * float(np.abs(increment).max()) / self.discrete.problem.length
        if found < UNMOVED and self._felt is not None:
            found = self._felt.moved(neighbours)
        return found

    def _increment(self, neighbours: Neighbours) -> Floats:
        """Return the increment of the equilibrium at the start per unit of a number."""
        assert self.change is not None
        kept, found = self._known.get(neighbours.number.key, (None, None))
        if kept is not neighbours or found is None:
            found = self.change.increment(neighbours)
            self._known[neighbours.number.key] = neighbours, found
        return found

    @staticmethod
    def _open(one: Neighbour | DiscreteModel, state: State) -> Floats:
        """Return the gaps of joints ``(joints,)`` in a state, over their units."""
        constraints = one.system.constraints
        constraints.update(0.0)
        places = constraints.arrays.place[constraints.is_held]
        found: Floats = np.abs(constraints.gaps(state) / constraints.unit)[places]
        return found

    def _require_closed(self, key: str, one: Neighbour, state: State, own: Floats) -> None:
        """Refuse a number that takes the places of a joint apart, of a motion that starts as the model is built.

        Raises:
            InputError: it does: the first steps would throw them together.
        """
        opened = self._open(one, state) - own
        if opened.max(initial=0.0) > OPEN:
            joint = np.flatnonzero(self.discrete.system.constraints.is_held)[int(np.argmax(opened))]
            joints = self.discrete.problem.joints
            name = joints.names[joints.joint[joint]]
            raise InputError(
                Fault(
                    "derivatives",
                    repr(key),
                    f"it takes the places of {name} apart, and the motion starts in the reference shape, in which they "
                    "would be thrown together",
                    "start from the equilibrium (leave initial out), or name a number that keeps the joint closed",
                )
            )

    def _state(self, one: Neighbour, increment: Floats | None) -> State:
        if self.given:
            return self.state.copy()
        state = State.reference(one.problem)
        if self.strained:
            one.system.given_strain = strain_rods(one.system, state)
        elif self.change is not None and increment is not None:
            one.system.constraints.near[:] = self.discrete.system.constraints.near
            state = self.change.moved(increment, one.change)
            report = settle(one.static, state, Instant())
            if not report.converged:
                raise SolveError(
                    "The equilibrium that the motion starts from has no derivatives: it was not found for a slightly "
                    f"different number.{self.discrete.where(report)}"
                )
        state.twist[:] = one.problem.initial_twist(state.r, state.q)
        return state


def _as_built(discrete: DiscreteModel, still: State) -> bool:
    """Return whether a model starts in its reference shape whatever its numbers, even where it could rest elsewhere."""
    problem = discrete.problem
    return not problem.rest_strains and not problem.joints.count and _free_of_load(discrete, still)


def _free_of_load(discrete: DiscreteModel, state: State) -> bool:
    """Return whether nothing acts on a model, whose reference shape is the equilibrium then."""
    discrete.static.restore(state, 0.0, before=True, scale=1.0)
    return discrete.static.loads.at(0.0, True).none and not discrete.supports.target.any()


def exact_integrator(one: Neighbour | DiscreteModel, settings: SimulateSettings) -> Integrator:
    """Return the integrator of a run for a model, with an iteration that goes on nearly to round-off."""
    method = INTEGRATORS[settings.integrator]
    make: Any = method.make_linear if settings.dynamics == "linear" else method.make
    given: dict[str, Any] = dict(method.parameters)
    given |= {name: getattr(settings, name) for name in given if getattr(settings, name) is not None}
    if method.tolerance is not None:
        given["tolerance"] = TOLERANCE
    integrator: Any = make(one.system, one.supports, **given)
    if hasattr(integrator, "iterations") and settings.integrator not in UNEVEN:
        integrator.iterations, integrator.newton_tolerance = ITERATIONS, ROUNDING
    found: Integrator = integrator
    return found
