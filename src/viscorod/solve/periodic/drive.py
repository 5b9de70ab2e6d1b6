"""What drives a periodic motion: loads and motions of supports and joints that are harmonic in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.constraints.moved_by_inputs import check_ground, moved_by, refused_input
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.signals import BASE, LoadInput, MotionInput, SignalInput
from viscorod.typing import Floats, Integers

__all__ = ["Drive"]


@dataclass(frozen=True)
class Drive:
    """Inputs ``a cos(phase + lead)``, all times a level.

    Attributes:
        signals: the inputs, with their amplitudes ``(k,)`` and leads ``(k,)`` [rad].
        loads: number of the load of each, -1 of motions ``(k,)``.
        targets: by how much a unit input moves supports ``(k, m, 6)``; joints: and held coordinates of joints
            ``(k, c)``.
    """

    signals: tuple[SignalInput, ...]
    amplitudes: Floats
    leads: Floats
    loads: Integers
    targets: Floats
    joints: Floats

    @classmethod
    def of(
        cls,
        problem: Problem,
        supports: SupportState,
        constraints: Constraints,
        signals: Sequence[SignalInput],
        amplitudes: Floats,
        leads: Floats,
        first_load: int,
    ) -> Drive:
        """Return what inputs do.

        Args:
            first_load: number of the load of the first input that is one; those of others follow.

        Raises:
            InputError: nothing can be moved there, by name.
        """
        count = len(signals)
        loads = np.full(count, -1, dtype=np.int64)
        targets = np.zeros((count, len(supports.set.nodes), 6))
        joints = np.zeros((count, problem.joints.count))
        for k, signal in enumerate(signals):
            if isinstance(signal, LoadInput):
                loads[k] = first_load
                first_load += 1
            elif signal.place == BASE:
                targets[k] = _base(problem, supports, signal, k)
            else:
                moved = moved_by(problem, supports, constraints, signal, k)
                if moved.support is not None:
                    targets[k, moved.support, signal.component] = 1.0
                else:
                    joints[k, moved.coordinate] = 1.0
        return cls(tuple(signals), np.asarray(amplitudes), np.asarray(leads), loads, targets, joints)

    @property
    def moving(self) -> bool:
        """Whether supports or joints are moved."""
        return bool((self.loads < 0).any())

    def phasors(self, omega: float, level: float) -> np.ndarray:
        """Return forces, and displacements of what is moved, ``(k,)`` as ``Re(phasor exp(i phase))``."""
        order = np.array([s.derivative if isinstance(s, MotionInput) else 0 for s in self.signals])
        return np.asarray(level * self.amplitudes * np.exp(1j * self.leads) / (1j * omega) ** order)

    def factors(self, phases: Floats, omega: float, level: float) -> Floats:
        """Return forces and displacements at some phases ``(phases, k)``."""
        return np.asarray((self.phasors(omega, level) * np.exp(1j * phases)[:, None]).real)

    def motion(
        self, phases: Floats, omega: float, level: float
    ) -> tuple[tuple[Floats, Floats, Floats], tuple[Floats, Floats]]:
        """Return what is added to targets of supports, their rates and accelerations ``(phases, m, 6)``; of joints.

        Those of joints are targets and rates ``(phases, c)``.
        """
        waves = self.phasors(omega, level) * np.exp(1j * phases)[:, None]
        waves = np.where(self.loads < 0, waves, 0.0)
        parts = [((1j * omega) ** order * waves).real for order in range(3)]
        of_supports = tuple(np.einsum("pk,kma->pma", part, self.targets) for part in parts)
        of_joints = tuple(part @ self.joints for part in parts[:2])
        return (of_supports[0], of_supports[1], of_supports[2]), (of_joints[0], of_joints[1])


def _base(problem: Problem, supports: SupportState, signal: MotionInput, k: int) -> Floats:
    """Return how supports are moved by a translation of the ground ``(m, 6)``."""
    found, s = np.zeros((len(supports.set.nodes), 6)), supports.set
    if signal.component >= 3:
        raise refused_input(
            k, signal, "the ground of a periodic motion is moved, not turned", "turn one support"
        )
    check_ground(problem, supports, signal, k)
    found[:, :3] = s.fixed[:, :3] * s.axes[:, signal.component, :]
    if not found.any():
        raise refused_input(k, signal, "no support holds anything along this axis", "give a force")
    return found
