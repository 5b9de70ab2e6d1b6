"""What single steps err by: some of them are computed again in halves.

A method of order p errs by ``C h^(p+1)`` in a step and by ``2^-p`` of that in two halves, so that both differ by
``1 - 2^-p`` of the error of the step (Richardson 1911; Hairer, Norsett and Wanner 1993, II.4). Of a vibration with
eigenvalue ``a`` that is ``R(a h) - R(a h/2)^2`` of its amplitude, ``R`` being the stability function of the method.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.rotations.nodal_motion import pose_differences
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.carried_modes import CarriedModes
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.reach_of_velocities import ReachOfVelocities
from viscorod.solve.transient.saved_state import hand_over
from viscorod.solve.transient.trial_choice import FARTHEST, FIRST, LONGER, PART, SETTLED
from viscorod.solve.transient.tried_steps import Reached, Several, TriedStep
from viscorod.typing import Floats

__all__ = ["HalvedSteps", "Trials"]

LITTLE = 0.3
"""Part of the errors that are sure which those of the remaining steps may be."""


@dataclass
class Trials:
    """What steps that were tried again err by, and how large the motion is there.

    Attributes:
        next: number of the step that is tried next; border: of that from which on the next one stands for the others.
        times, lengths: of the steps that were tried again, their ends and how long they are [s].
        states: at their ends, by their halves; faster: errors of body twists there ``(n, 6)``.
        around: number of the steps around each, and the sum of those powers of their lengths that errors go
            with ``(2,)``.
        errors: their errors in each vibration, of displacement and of velocity over the frequency ``(2, k)``.
        amplitudes: of each vibration by its velocity ``(k,)``.
        rigid: the same in rigid motions, velocities as they are ``(2, m)``; energies: of these motions at the start and
            at the end of the step ``(2,)``.
        rest: the largest error that no mode explains, body axes ``(n, 6)``; within: largest ones of the polynomials
            between the ends of steps, in their middle, at every node.
        moved: largest displacement [m] and rotation [rad] of a node from the start ``(2,)``.
        starts: when the run began, and began anew after jumps [s]; released: what each vibration is set off by then,
            displacement from where all is in balance and velocity over the frequency ``(2, k)``.
        forces: largest force [N] and moment [N m] of sections ``(2,)``; apart: largest error of these in a step, also
            within it where strains are unknowns of their own.
    """

    rest: Floats
    within: Floats
    next: int = FIRST
    border: int | None = None
    around: list[Floats] = field(default_factory=lambda: [np.zeros(2)])
    lengths: list[float] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    faster: list[Floats] = field(default_factory=list)
    errors: list[Floats] = field(default_factory=list)
    amplitudes: list[Floats] = field(default_factory=list)
    rigid: list[Floats] = field(default_factory=list)
    energies: list[Floats] = field(default_factory=list)
    starts: list[float] = field(default_factory=list)
    released: list[Floats] = field(default_factory=list)
    moved: Floats = field(default_factory=lambda: np.zeros(2))
    forces: Floats = field(default_factory=lambda: np.zeros(2))
    apart: Floats = field(default_factory=lambda: np.zeros(2))


class HalvedSteps:
    """Computes some steps of a run again, with an integrator of its own that does not disturb the run.

    What they err by is worked out when it is asked for: after the run, as a rule.

    Args:
        make: makes an integrator like that of the run, which is needed where the compiled loop does not serve.
        tolerance: of that, if steps follow one.
        modes: small motions in which errors are taken apart; problem: that is solved; order: of the method.
        strains: they are unknowns of their own, from which those of the poses drift apart.
        turning: parts may turn against each other, and their motions with them.
    """

    def __init__(
        self,
        make: Callable[[], Integrator],
        modes: StartModes,
        problem: Problem,
        order: int,
        *,
        tolerance: float | None = None,
        strains: bool = False,
        turning: bool = True,
    ) -> None:
        self._make, self.tolerance = make, tolerance
        self.modes, self.mass, self.strains = modes, problem.mass, strains
        self.problem, self.turning = problem, turning
        self.unit = np.repeat([problem.length, 1.0], 3)
        self._trials = Trials(*np.zeros((2, problem.size, 6)))
        self._unseen: list[TriedStep] = []
        self.power, self.seen = order + 1, 1.0
        self._differences = KnownTypes(pose_differences)
        self._start: State | None = None
        self._carried: CarriedModes | None = None
        self._run: Integrator | None = None
        self._kept = self._started = False
        self._duration = np.inf

    @cached_property
    def _reach(self) -> ReachOfVelocities:
        return ReachOfVelocities(self.problem, self.modes)

    @cached_property
    def twin(self) -> Integrator:
        """An integrator like that of the run."""
        return self._make()

    @property
    def run(self) -> Integrator:
        """The integrator of the run."""
        assert self._run is not None
        return self._run

    @property
    def start(self) -> State:
        """The state at t = 0."""
        assert self._start is not None
        return self._start

    def begin(self, integrator: Integrator, duration: float) -> None:
        """Note where a run of ``duration`` [s] has begun, at t = 0."""
        self._run, self.seen = integrator, integrator.seen_by_halving
        self._start, self._duration, self._started = integrator.state.copy(), duration, False
        self._measure(integrator.state.r, integrator.state.q, integrator.section_force)
        self.release(integrator, 0.0, 0.0)

    def release(self, integrator: Integrator, unbalanced: Floats | float, twist: Floats | float) -> None:
        """Note which vibrations are set off where the run has begun, or begun anew after a jump.

        They are what the jump changes: what turns or swings is out of balance all the time. Velocities of what supports
        or motors carry along are no vibrations.

        Args:
            unbalanced, twist: what accelerated the nodes, and their body twists, just before ``(n, 6)``; 0 at the
                start.
        """
        trials, modes, state = self._trials, self.modes, integrator.state
        shapes, _ = self._shapes_at(state)
        moved = -shapes.T @ (integrator.unbalanced() - unbalanced).ravel() / modes.omega**2
        moving = np.zeros_like(moved)
        if not self.problem.supports.motions and not self.problem.joints.motions:
            moving = shapes.T @ np.einsum("nij,nj->ni", self.mass, state.twist - twist).ravel() / modes.omega
        trials.starts.append(integrator.t)
        trials.released.append(np.array([moved, moving]))

    def _shapes_at(self, state: State) -> tuple[Floats, Floats]:
        """Return the shapes of vibrations and of rigid motions in a state."""
        if not self.turning:
            return self.modes.shapes, self.modes.rigid
        if self._carried is None:
            assert self._start is not None
            self._carried = CarriedModes(self.modes, self.problem, self._start)
        return self._carried.at(state)

    @property
    def trials(self) -> Trials:
        """What was found."""
        unseen, self._unseen = self._unseen, []
        if unseen:
            self._look_at(unseen)
        return self._trials

    def errors(self, stands_for: Floats) -> list[Floats]:
        """Return what steps err by in each vibration, as ``Trials.errors``, but velocities as far as they go.

        They go as far as vibrations of the present shape do. It is looked at where they tell more than displacements,
        which a vibration has by turns: in those steps first that have the largest part, and in no more than matter.

        Args:
            stands_for: for how many steps each of those that were tried again stands ``(j,)``.
        """
        trials, found = self.trials, list(self.trials.errors)
        if not self.turning or not len(self.modes.omega):
            return found
        moved, moving = stands_for[:, None] * np.abs(np.array(found)).transpose(1, 0, 2)
        beyond = np.maximum(moving - moved, 0.0).max(axis=1)
        known, doubtful = np.minimum(moving, moved).max(axis=1).sum(), beyond.sum()
        for j in np.argsort(-beyond):
            if doubtful <= LITTLE * known:
                break
            state = trials.states[j]
            shapes, _ = self._shapes_at(state)
            found[j] = found[j].copy()
            found[j][1] = self._reach.along(shapes, state, trials.times[j], trials.faster[j])
            known, doubtful = known + stands_for[j] * np.abs(found[j][1]).max(), doubtful - beyond[j]
        return found

    @property
    def coming(self) -> tuple[int, float]:
        """Number of the step that is tried next, and the length [s] beyond which others are."""
        return self._trials.next, LONGER * max(self._trials.lengths, default=np.inf)

    def prepare(self, number: int, integrator: Integrator, h: float) -> None:
        """Keep the state before an attempt of a step of ``h`` [s], by its number, if it is one to be tried again."""
        if not self._kept and self.tries(number, h):
            self._kept = True
            if not self._started:
                assert self._start is not None
                self._started = True
                self.twin.start(0.0, self._start.copy())
                self.twin.watch(self._duration)
            hand_over(integrator, self.twin)

    def tries(self, number: int, h: float) -> bool:
        """Return whether a step of ``h`` [s] is one to be tried again, by its number."""
        upcoming, longest = self.coming
        return number == upcoming or (number > SETTLED and h > longest)

    @property
    def waiting(self) -> bool:
        """Whether the step that is taken next is one to be tried again."""
        return self._kept

    def passed(self, number: int, h: float) -> None:
        """Count a step of ``h`` [s] that was accepted, by its number."""
        trials = self._trials
        if trials.border is not None and number >= trials.border:
            trials.border = None
            trials.around.append(np.zeros(2))
        around = trials.around[-1]
        around[0] += 1.0
        around[1] += h**self.power
        if number == trials.next:
            trials.next += min(2 * number + 1, max(FARTHEST, number // PART))

    def compare(self, number: int, integrator: Integrator, before: State, h: float, *, left: bool) -> None:
        """Compute a step that was accepted again in halves, if the state before it was kept.

        Args:
            number: of the step; integrator: of the run, at its end.
            before: the state at its start; h: its length [s]; left: whether loads at its end are limits from the left.
        """
        twin, end = self.twin, integrator.t
        self.passed(number, h)
        if not self._kept:
            return
        self._kept = False
        twin.resume()
        middle = integrator.between(np.array([0.5])).states.at(0)
        halves = []
        for place, at, limit in ((0.0, end - 0.5 * h, False), (0.5, end, left)):
            twin.begin_half(integrator, place)
            if not twin.attempt(at, before=limit).converged:
                return
            twin.accept()
            halves.append(Reached.at(twin))
        inside = Reached(middle.state, middle.section_force)
        self.take(number, TriedStep(end, h, before.twist.copy(), inside, Reached.at(integrator), *halves))

    def take(self, number: int, step: TriedStep) -> None:
        """Take the difference of a step, by its number, from its halves as its error; it has been counted."""
        trials = self._trials
        if trials.border is not None:  # two in a row
            trials.around.append(np.zeros(2))
        trials.border = (number + 1 + trials.next) // 2
        trials.lengths.append(step.h)
        trials.times.append(step.end)
        self._unseen.append(step)

    def _look_at(self, steps: list[TriedStep]) -> None:
        """Work out what steps err by."""
        trials = self._trials
        _, _, _, *columns = zip(*steps, strict=True)
        middle, whole, better_middle, better = map(Several.of, columns)
        trials.states += [step.better.state for step in steps]
        within = np.abs(self._away(middle, better_middle)).max(axis=0)
        if self.strains:
            inside = _largest(middle.section_force - better_middle.section_force)
            trials.apart = np.maximum(trials.apart, inside)
        trials.within = np.maximum(trials.within, within)
        self._measure(better.r, better.q, better.section_force)
        self._compare(steps, whole, better)
        lacking = _largest(whole.section_force - better.section_force)
        trials.apart = np.maximum(trials.apart, lacking / self.seen)

    def _compare(self, steps: list[TriedStep], whole: Several, better: Several) -> None:
        """Take the errors of steps apart, mode by mode."""
        before = np.array([step.before for step in steps])
        pose = self._away(whole, better)
        moving = np.stack([pose, whole.twist - better.twist, before, whole.twist], axis=1)
        momenta = np.einsum("nij,lknj->lkni", self.mass, moving).reshape(len(steps), 4, -1)
        momenta[:, :2] /= self.seen
        self._trials.faster += list(moving[:, 1] / self.seen)
        for step, moved, away in zip(steps, momenta, pose / self.seen, strict=True):
            self._take_apart(step.better.state, moved, away)

    def _take_apart(self, better: State, momenta: Floats, away: Floats) -> None:
        """Take the error of one step apart.

        Args:
            better: by the halves, at its end.
            momenta: errors of pose and twist, and twists at the start and at the end, by the mass ``(4, 6 n)``.
            away: error of the pose ``(n, 6)``.
        """
        trials, modes = self._trials, self.modes
        shapes, still = self._shapes_at(better)
        errors, rigid = momenta[:2] @ shapes, momenta @ still
        explained = (shapes @ errors[0] + still @ rigid[0]).reshape(away.shape)
        errors[1] /= modes.omega
        trials.errors.append(errors)
        trials.amplitudes.append(np.abs(momenta[2:] @ shapes).max(axis=0) / modes.omega)
        trials.rigid.append(rigid[:2])
        trials.energies.append(np.square(rigid[2:]).sum(axis=1))
        rest = away - explained
        if np.abs(rest / self.unit).max() > np.abs(trials.rest / self.unit).max():
            trials.rest = rest

    def _measure(self, r: Floats, q: Floats, section_force: Floats) -> None:
        """Measure how large the motion is, in one state or in several."""
        assert self._start is not None
        start, trials = self._start, self._trials
        far = np.square(r - start.r).sum(axis=-1).max()
        chord = np.minimum(np.square(q - start.q).sum(axis=-1), np.square(q + start.q).sum(axis=-1))
        trials.moved = np.maximum(trials.moved, [math.sqrt(far), 2.0 * math.sqrt(chord.max())])
        trials.forces = np.maximum(trials.forces, _largest(section_force))

    def _away(self, states: Several, better: Several) -> Floats:
        """Return by how much the poses of states differ from better ones, body increments ``(k, n, 6)``."""
        pose = np.empty((*states.r.shape[:2], 6))
        rows = [field.reshape(-1, field.shape[2]) for field in (better.r, better.q, states.r, states.q, pose)]
        self._differences.call(*rows)
        return pose


def _largest(section_force: Floats) -> Floats:
    """Return the largest force and moment ``(2,)``."""
    squares = np.square(section_force).reshape(-1, 2, 3).sum(axis=2)
    return np.asarray(np.sqrt(squares.max(axis=0, initial=0.0)))
