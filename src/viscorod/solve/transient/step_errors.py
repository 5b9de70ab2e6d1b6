"""The error that the steps of a motion leave in it: what single steps err by, added up by the modes of small motions.

An error of a step is a small motion, which goes on by itself: a vibration lasts until it has faded, a velocity of a
rigid motion becomes a displacement in time. Errors of steps in the same vibration are taken to add up, as those of
frequency and amplitude do: after n steps of a free vibration that is ``n |R(a h) - exp(a h)|`` of its amplitude.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from viscorod.mechanics.elements.linearised import Operators
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.transient.halved_steps import HalvedSteps, Trials
from viscorod.typing import Floats

__all__ = ["StepErrors", "damped_by_steps"]

MIXED = 0.5
"""Power of their number with which errors add up that faster motions make: their signs are random."""
RESOLVED = 4.0
"""Eigenvalue times step up to which a vibration is followed and errs by itself; faster ones only follow others."""
FADED = 0.5
"""What is left after a step of vibrations that fade in it."""
SAFETY = 1.5
"""Factor on what was found: too large is less bad than too small."""
FORCE_SAFETY = 2.0
"""The same for section forces, in which vibrations that are hard to follow have a larger part."""
LEAST_MOTION = 1e-9
"""Motion, over the length or in rad, below which it is round-off."""
LEAST_FORCE = 1e-8
"""Part of the force that holds the model at its speed on a circle of its length, below which one is round-off: sections
of a body that falls freely carry nothing."""
LOOKS = 6
"""Numbers of steps, from one to all that one stands for, after which what a jump set off is looked at."""
FINER = 3.0
"""Times that steps are shorter with which a motion is nearly free of their errors: a few thousandths are left."""


@dataclass(frozen=True)
class StepErrors:
    """Estimated errors of a motion by its steps, and how large it is.

    Attributes:
        gap: largest error of a displacement [m] and of a rotation [rad] of a node ``(2,)``; forces: of the force [N]
            and the moment [N m] of a section ``(2,)``.
        moved, loaded: largest displacement [m] and rotation [rad] from the start, force [N] and moment [N m] of
            sections, no less than round-off ``(2,)``.
        length: of the model [m].
    """

    gap: Floats
    forces: Floats
    moved: Floats
    loaded: Floats
    length: float

    @classmethod
    def of(cls, halved: HalvedSteps, problem: Problem, start: State, end: float) -> StepErrors | None:
        """Add up the errors of steps that were tried again, each of which stands for those around it.

        Args:
            halved: what was found; problem: that was solved; start: the state at t = 0; end: of the
                run [s].

        Returns:
            None if no step was tried again.
        """
        modes, trials, size = halved.modes, halved.trials, problem.size
        if not trials.lengths:
            return None
        stands_for = _weights(trials, halved.power)
        every = np.outer(trials.lengths, modes.eigenvalues)
        steps = halved.run.stability(every.ravel()).reshape(every.shape)
        lost = _lost(trials, every, steps, stands_for)
        errors, faded = _vibrations(halved, every, steps, stands_for)
        vibrating = np.maximum(errors, lost / SAFETY) * modes.shapes
        rigid = _rigid_motions(trials, stands_for, end) * modes.rigid
        apart = stands_for.max() if not len(modes.omega) else np.sqrt(stands_for.max())
        rest = (apart * trials.rest).reshape(-1, 1)
        passing = np.abs(faded).max(axis=1, keepdims=True)
        fields = np.hstack([vibrating, rigid, rest, passing, trials.within.reshape(-1, 1)]).reshape(
            size, 2, 3, -1
        )
        gap = SAFETY * np.sqrt(np.square(fields).sum(axis=(2, 3))).max(axis=0)
        followed = min(trials.lengths) * np.abs(modes.eigenvalues) < RESOLVED
        squares = _squared_forces(_system_of(halved, problem), start, np.hstack([vibrating, faded]))
        squares, passing_by = squares[: len(followed)], squares[len(followed) :]
        forces = _largest_forces(squares[followed])
        # stiff sections turn a motion that went far from the start into forces that are none
        stiff = trials.apart
        if not halved.strains:
            most = np.max([_largest_forces(one[None]) for one in passing_by], axis=0)
            stiff = np.minimum(stiff, np.hypot(_largest_forces(squares[~followed]), most))
        released = _largest_forces(_squared_forces(_system_of(halved, problem), start, lost * modes.shapes))
        forces = np.maximum(FORCE_SAFETY * (forces + stiff), released)
        round_off = LEAST_FORCE * np.max(trials.energies) * np.array([1.0 / problem.length, 1.0])
        loaded = np.maximum(trials.forces, round_off)
        return cls(gap, forces, trials.moved, loaded, problem.length)

    @property
    def motion(self) -> float:
        """The larger of the errors of displacements and rotations, over the largest of each.

        Rotations count at least as displacements over the length, and the other way round.
        """
        scale = np.array([self.length, 1.0])
        amplitude = max(float((self.moved / scale).max()), LEAST_MOTION)
        return float((self.gap / scale).max() / amplitude)

    @property
    def force(self) -> float:
        """The larger of the errors of section forces and moments, over the largest of each."""
        n, m = self.loaded
        size = np.maximum(self.loaded, [1e-2 * m / self.length, 1e-2 * n * self.length])
        return float((self.forces / np.maximum(size, np.finfo(float).tiny)).max())

    def growth(self, summed: StepErrors) -> float:
        """Return how many times as large displacements err as the sum of errors in small motions says, at least 1."""
        least = LEAST_MOTION * self.length
        return float(max(1.0, self.gap[0] / max(summed.gap[0], least)))

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its steps."""
        return {
            "step_position_error": float(self.gap[0]),
            "step_rotation_error": float(self.gap[1]),
            "step_section_force_error": float(self.forces[0]),
            "step_section_moment_error": float(self.forces[1]),
            "step_motion_error": self.motion,
            "step_force_error": self.force,
        }


def damped_by_steps(halved: HalvedSteps) -> StartModes:
    """Return small motions that fade as they do by themselves, and with steps that are ``FINER`` than those of a run.

    What these damp away is an error of steps, not of the mesh.
    """
    modes, lengths = halved.modes, halved.trials.lengths
    if not lengths:
        return modes
    h = float(np.median(lengths)) / FINER
    left = np.clip(np.abs(halved.run.stability(1j * modes.omega * h)), np.finfo(float).tiny, 1.0)
    return replace(modes, decay=modes.decay - np.log(left) / h)


def _weights(trials: Trials, power: int) -> Floats:
    """Return for how many steps of its length each of those that were tried again stands ``(j,)``.

    No more than there are: steps that are longer than their neighbours are so because less is wrong in them.
    """
    count = len(trials.lengths)
    around = np.array([*trials.around[: count - 1], np.sum(trials.around[count - 1 :], axis=0)])
    alike = around[:, 1] / np.array(trials.lengths) ** power
    return np.asarray(np.clip(alike, 1.0, np.maximum(around[:, 0], 1.0)))


def _vibrations(
    halved: HalvedSteps, every: np.ndarray, steps: np.ndarray, stands_for: Floats
) -> tuple[Floats, Floats]:
    """Return the largest error of each vibration at any time ``(k,)``, and of those that fade, fields ``(6 n, j)``.

    Vibrations that fade within a step hardly move by themselves: their errors stay together as a step leaves them.

    What a vibration errs by itself, ``|R - exp|`` of its amplitude, adds up from step to step; what others push it by
    does so in part, within half a period. Later steps damp errors as they damp the vibration, stiff ones at once, and
    wrong velocities of those move nothing. There is no larger error than twice the vibration that there is.

    Args:
        halved: steps that were tried again; every, steps: their lengths times the eigenvalues of the vibrations, and
            what the steps make of these ``(j, k)``; stands_for: how many steps each is of ``(j,)``.
    """
    trials = halved.trials
    single = np.array(list(halved.errors(stands_for)))
    left = np.minimum(np.abs(steps), 1.0 - 1e-12)
    fades = np.exp(every.real) < FADED
    faded = halved.modes.shapes @ np.where(fades, single[:, 0] / (1.0 - left), 0.0).T
    kept, size = (
        left ** stands_for[:, None],
        np.hypot(np.where(fades, 0.0, single[:, 0]), left * single[:, 1]),
    )
    amplitude = np.maximum.accumulate(trials.amplitudes)
    own = np.where(np.abs(every) < RESOLVED, np.minimum(size, np.abs(steps - np.exp(every)) * amplitude), 0.0)
    summed = (1.0 - kept) / (1.0 - left)
    mixed = np.minimum(summed**MIXED, 2.0 / np.maximum(np.abs(1.0 - steps), 1e-12))
    added, most = own * summed + (size - own) * mixed, np.maximum(size, 2.0 * amplitude)
    error = largest = np.zeros(every.shape[1])
    for j in range(len(every)):
        error = error * kept[j] + added[j]
        largest = np.maximum(largest, np.minimum(error, most[j]))
    return largest, faded


def _lost(trials: Trials, every: np.ndarray, steps: np.ndarray, stands_for: Floats) -> Floats:
    """Return what steps make wrong of vibrations that jumps set off ``(k,)``: at most all that is left of them.

    Steps that are longer than a vibration damp it, or keep it out of phase, before any is tried again. Vibrations about
    the start add up: what one jump sets off goes on after the next. Arguments as of :func:`_vibrations`.
    """
    exact, counts = np.exp(every), np.maximum(stands_for, 1.0)[:, None, None]
    after = (counts ** np.linspace(0.0, 1.0, LOOKS)[:, None]).round()
    there_then, here_then = exact[:, None] ** after, steps[:, None] ** after
    there_last, here_last = exact ** stands_for[:, None], steps ** stands_for[:, None]
    largest = np.zeros(every.shape[1])
    there, here = np.zeros((2, every.shape[1]), dtype=complex)
    begun = deque(zip(trials.starts, trials.released, strict=True))
    for j, end in enumerate(trials.times):
        while begun and begun[0][0] < end:
            moved, moving = begun.popleft()[1]
            there, here = there + (moved - 1j * moving), here + (moved - 1j * moving)
        largest = np.maximum(largest, np.abs(there * there_then[j] - here * here_then[j]).max(axis=0))
        there, here = there * there_last[j], here * here_last[j]
    return largest


def _rigid_motions(trials: Trials, stands_for: Floats, end: float) -> Floats:
    """Return the error of each rigid motion at the end ``(m,)``.

    A velocity drifts for the rest of the run. Errors around one step that was tried again are alike, those around
    others of any sign. Where the energy of rigid motions comes and goes at a rate, as that of a
    pendulum does, something holds them: an amplitude that is wrong then drifts in phase, by the root of that time.
    """
    first, last = np.array(trials.energies).T
    both = float(np.square(first + last).sum())
    changes = (last - first) / np.array(trials.lengths)
    rate = np.sqrt(float(np.square(changes).sum()) / both) if both > 0.0 else 0.0
    error = np.zeros(trials.rigid[0].shape[1])
    for t, (moved, velocity), count in zip(trials.times, trials.rigid, stands_for, strict=True):
        drifting = (end - t) / np.sqrt(max(1.0, rate * (end - t)))
        error = np.hypot(error, count * (np.abs(moved) + np.abs(velocity) * drifting))
    return error


def _system_of(halved: HalvedSteps, problem: Problem) -> GeometricSystem:
    """Return a system whose sections respond at once: that of the run, which is over, if it is one."""
    known: object = getattr(halved.run, "system", None)
    if (
        type(known) is GeometricSystem
        and known.problem is problem
        and known.relaxation is None
        and not known.imposed.changes
    ):
        return known
    system = GeometricSystem(problem)
    system.relaxation = None
    return system


def _squared_forces(system: GeometricSystem, start: State, fields: Floats) -> Floats:
    """Return the squared section forces of small motions from the start, at all Gauss points ``(j, m, 6)``.

    Args:
        system: in which forces follow; fields: body increments of the nodes ``(6 n, j)``.
    """
    problem = system.problem
    elements, still = system.elements(), np.zeros((problem.size, 6, 6))
    operators, stress = Operators.of(elements), np.zeros(elements.reference.shape)
    system.linearise(start, still, stress, operators, *np.zeros((2, len(problem.pattern.rows), 6, 6)))
    moved = fields.T.reshape(-1, problem.size, 6)[:, elements.nodes]  # (j, elements, nodes of each, 6)
    j, count, nodes, _ = moved.shape  # a rod all of whose strains are held has no such motion
    forces = np.einsum("erc,kec->ker", operators.force, moved.reshape(j, count, 6 * nodes))
    return np.asarray(
        np.square(forces.reshape(j, forces.shape[1] * forces.shape[2] // 6, 6)[:, system.gauss_indices()])
    )


def _largest_forces(squares: Floats) -> Floats:
    """Return the largest force and moment of sections that motions make together, by their squares ``(2,)``."""
    return np.asarray(np.sqrt(squares.sum(axis=0).reshape(-1, 2, 3).sum(axis=2).max(axis=0, initial=0.0)))
