"""Where joints and held strains are and where they are to be: coordinates, targets in time, gaps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.elements.internal_force import Elements, ElementWork, GaussStates, internal_forces
from viscorod.mechanics.joints.joint_coordinates import ANGLE, DISTANCE, ROTATION, TRANSLATION
from viscorod.solve.constraints.ball_motors import LARGEST, BallMotors
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.solve.formulations.system import State

CLOSED = 1e-9
"""Gap of a joint over the length (or in rad) that passes for round-off of the reference shape."""


class HeldCoordinates:
    """Coordinates of joints and held strains, what motors and multipliers want them to be, and what they lack.

    Args:
        problem: of which they are part; elements: returns all of its elements, called for held strains only.

    Attributes:
        driven: where held coordinates are to be ``(c,)`` at the time of the last :meth:`update`.
        target, target_rate: the same as they are measured, see ``BallMotors``.
        near: values ``(c,)`` that angles are to be near.
        reference_gaps: values of held coordinates in the reference shape ``(c,)``.
        stage: values of held coordinates at the start of a stage of statics, and parts of motors at its end ``(c,)``.
        gap: gaps that multipliers must close ``(places,)``; unit: of each.
        idle, used: multipliers without a condition, and with one.
        strains_as_states: returns strains and their rates ``(1, e, points, 6)`` where a formulation keeps them as
            states, which are held exactly; None where they follow from poses. Between the steps of a motion
            (``between_steps``) such strains count as held.
    """

    def __init__(self, problem: Problem, elements: Callable[[], Elements]) -> None:
        self.problem = problem
        geometry = problem.joints.arrays.geometry.copy()
        self.joints = problem.joints
        if self.joints.count:
            self.joints = replace(problem.joints, arrays=problem.joints.arrays._replace(geometry=geometry))
        self.held, self.arrays = problem.held, self.joints.arrays
        self.ball_motors = BallMotors(self.joints, geometry)
        c, places = self.joints.count, 6 * problem.multipliers
        self.strains_as_states: Callable[[State], tuple[Floats, Floats]] | None = None
        self.between_steps = False
        self._elements = elements
        self.near, self.target, self.target_rate = np.zeros(c), np.zeros(c), np.zeros(c)
        self.driven = np.zeros(c)
        self.gap = np.zeros(places)
        driven = {number for number, _ in self.joints.motions}
        self._rotations: Integers = np.array(
            [k for k in range(c) if k in driven and self.arrays.kind[k] == ROTATION], dtype=np.int64
        )
        followed = set(self.joints.joint[self.ball_motors.coordinates].ravel().tolist())
        self._balls = sorted({int(self.joints.joint[k]) for k in self._rotations} - followed)
        self.is_held = self.arrays.place >= 0
        self.reference_gaps = self._gaps_of_reference()
        taken = np.zeros(places, dtype=bool)
        taken[self.arrays.place[self.is_held]] = True
        taken[self.held.place] = True
        self.idle: Integers = np.flatnonzero(~taken)
        self.used: Integers = np.flatnonzero(taken)
        self.stage: tuple[Floats, Floats] = self.reference_gaps, np.ones(c)
        self.target[:] = self.reference_gaps
        self.unit = np.ones(places)
        self.unit[self.arrays.place[self.is_held]] = self.joints.unit[self.is_held]

    def _gaps_of_reference(self) -> Floats:
        """Return the values of held coordinates in the reference shape, their initial gaps ``(c,)``."""
        problem = self.problem
        if not self.joints.count:
            return np.zeros(0)
        still = np.zeros((problem.size, 6))
        value, _, _ = self.joints.measure(problem.positions, problem.quaternions, still)
        value[~self.is_held] = 0.0
        value[np.abs(value) < 1e-14 * self.joints.unit] = 0.0
        return value

    @property
    def elements(self) -> Elements:
        """All elements."""
        return self._elements()

    def measure(self, state: State) -> tuple[Floats, Floats, Floats]:
        """Return values and rates ``(c,)`` and gradients ``(c, 12)`` of all coordinates in a state."""
        return self.joints.measure(state.r, state.q, state.twist, self.near)

    @property
    def rows(self) -> int:
        """Number of conditions that multipliers enforce."""
        return len(self.used)

    def rate_gaps(self, state: State) -> Floats:
        """Return the rates of all gaps ``(places,)`` [1/s and units of the gaps], 0 where velocities are allowed."""
        _, rate, _ = self.measure(state)
        strains = self._strains(state)[1] if self.measures_strains else None
        return self._by_place(rate - self.target_rate, strains)

    def gaps(self, state: State) -> Floats:
        """Return all gaps ``(places,)``, 0 where positions are as the last :meth:`update` wants them."""
        value, _, _ = self.measure(state)
        strains = self._strains(state)[0] if self.measures_strains else None
        return self._by_place(value - self.target, strains)

    def _by_place(self, coordinates: Floats, strains: Floats | None) -> Floats:
        """Arrange values of all coordinates ``(c,)`` and Gauss points ``(1, e, points, 6)`` by multiplier."""
        out, held = np.zeros_like(self.gap), self.held
        out[self.arrays.place[self.is_held]] = coordinates[self.is_held]
        if strains is not None:
            out[held.place] = strains[0, held.element, held.point, held.component]
        return out

    @property
    def measures_strains(self) -> bool:
        """Whether held strains may be anything but zero."""
        return len(self.held.place) > 0 and not (self.between_steps and self.strains_as_states)

    def _strains(self, state: State) -> tuple[Floats, Floats]:
        """Return strains and their rates ``(1, e, points, 6)`` in a state."""
        if self.strains_as_states is not None:
            return self.strains_as_states(state)
        points, work, force = self.evaluation
        internal_forces(self.elements, state.r[None], state.q[None], state.twist[None], points, work, force)
        return points.strain, points.strain_rate

    @cached_property
    def evaluation(self) -> tuple[GaussStates, ElementWork, Floats]:
        """Work arrays of :meth:`_strains`."""
        width = self.elements.nodes.shape[1]
        return (
            GaussStates.of(self.elements, 1),
            ElementWork.of(width - 1),
            np.zeros((1, self.problem.size, 6)),
        )

    def speed(self, state: State) -> float:
        """Return the largest velocity [m/s], or angular velocity times the length, of a state or of motors."""
        length = self.problem.length
        fastest = max(
            float(np.abs(state.twist[:, :3]).max()), length * float(np.abs(state.twist[:, 3:]).max())
        )
        driven = float(np.abs(self.target_rate).max(initial=0.0)) * length
        return max(fastest, driven, 1e-300) / length

    def open_joints(self, part: float = 1.0, driven: Floats | None = None) -> list[str]:
        """Name the joints that are open in the reference shape, and by how much.

        Args:
            part: of the gaps that is left; driven: where motors are to be instead of 0 ``(c,)``.
        """
        gaps = part * self.reference_gaps - (0.0 if driven is None else driven)
        lengths = np.isin(self.arrays.kind, (TRANSLATION, DISTANCE))
        return [
            f"{self.joints.label(int(c))} by {abs(gaps[c]):.6g} {'m' if lengths[c] else 'rad'}"
            for c in np.flatnonzero(np.abs(gaps) > CLOSED * self.joints.unit)
        ]

    def update(self, t: float, before: bool = False, scale: float = 1.0) -> None:
        """Evaluate motors at time ``t`` [s]; ``scale`` below 1 leaves gaps of the reference shape open in part.

        Raises:
            InputError: the motors of a ball joint are to turn it by half a turn.
        """
        if self.joints.count == 0:
            return
        first, part = self.stage
        self.target[:] = (1.0 - scale) * first
        for c, motion in self.joints.motions:
            self.target[c] += scale * part[c] * motion.value(t, before)
            self.target_rate[c] = scale * motion.rate(t, before)
        self.driven[:] = self.target
        self.ball_motors.follow(self.target, self.target_rate)
        self.near[self.is_held] = self.target[self.is_held]
        for joint in self._balls:
            mine = self.joints.joint[self._rotations] == joint
            turn = float(np.linalg.norm(self.target[self._rotations[mine]]))
            if turn > LARGEST:
                raise InputError(
                    f"joints: the motors of {self.joints.names[joint]} are to turn it by {turn:.3g} rad at "
                    f"t = {t:.6g} s: the rotation vector of a joint that is free to turn all ways cannot pass half a "
                    "turn unless rx, ry and rz are all driven; drive all three, or use a joint with one or two axes "
                    "(revolute, cylindrical, universal), which turn any number of times"
                )

    def stand_as(self, other: HeldCoordinates) -> None:
        """Take over where coordinates of the same joints are and are to be."""
        for mine, its in (
            (self.near, other.near),
            (self.driven, other.driven),
            (self.target, other.target),
            (self.target_rate, other.target_rate),
            (self.arrays.geometry, other.arrays.geometry),
        ):
            mine[:] = its

    @property
    def drives_rotations(self) -> bool:
        """Whether motors drive components of rotation vectors."""
        return len(self._rotations) > 0

    @property
    def largest_turn(self) -> float:
        """Largest rotation [rad] of motors at the time of the last update."""
        turns = [
            abs(float(self.driven[c]))
            for c, _ in self.joints.motions
            if self.arrays.kind[c] in (ANGLE, ROTATION)
        ]
        turns += [float(np.linalg.norm(self.driven[mine])) for mine in self.ball_motors.coordinates]
        return max(turns, default=0.0)
