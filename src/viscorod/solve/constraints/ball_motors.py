"""Motors that drive all three rotations of a joint: in statics their turns are followed, whatever their size.

A rotation vector tells no more than half a turn, and is singular at a whole one. So beyond ``LARGEST`` coordinates
are measured from where the motors are to be: the axes of b are compared with ``R_a Q_a exp(psi)``, so that targets are
zero. Motions turn less than that.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.joints.joint_coordinates import AT_Q_A, ROTATION
from viscorod.mechanics.rotations.quaternion import product
from viscorod.solve.constraints.rigid_motions import skew
from viscorod.solve.problem.joint_set import JointSet
from viscorod.typing import Floats, Integers

__all__ = ["BallMotors"]

LARGEST = 3.0
"""Largest rotation vector [rad] that is measured as it is: beyond half a turn the shorter way is the other one."""


class BallMotors:
    """The joints of which motors drive all three rotations.

    Args:
        joints: all of them; geometry: that of their coordinates, of which the axes of a are turned here.

    Attributes:
        coordinates: of each joint ``(balls, 3)``.
        moving: whether a motion is under way, in which axes stay as they are.
    """

    def __init__(self, joints: JointSet, geometry: Floats) -> None:
        driven = {number for number, _ in joints.motions}
        found = []
        for joint in sorted({int(joints.joint[c]) for c in driven}):
            mine = [c for c in driven if joints.joint[c] == joint and joints.arrays.kind[c] == ROTATION]
            if len(mine) == 3:
                found.append(sorted(mine))
        self.coordinates: Integers = np.array(found, dtype=np.int64).reshape(-1, 3)
        self.moving = False
        self._geometry = geometry
        self._axes = geometry[self.coordinates[:, 0], AT_Q_A : AT_Q_A + 4].copy()
        self._psi: list[Floats | None] = [None] * len(found)

    def follow(self, target: Floats, rate: Floats) -> None:
        """Replace the targets and rates ``(c,)`` of these coordinates by those relative to the turned axes."""
        for k, mine in enumerate(self.coordinates):
            psi = target[mine].copy()
            far = bool(np.linalg.norm(psi) > LARGEST) and not self.moving
            self._psi[k] = psi if far else None
            axes = product(self._axes[k], _quaternion(psi)) if far else self._axes[k]
            self._geometry[mine, AT_Q_A : AT_Q_A + 4] = axes
            if far:
                target[mine], rate[mine] = 0.0, _tangent(psi) @ rate[mine]

    def values(self, value: Floats) -> Floats:
        """Return the rotation vectors in place of those relative to the turned axes, near the targets ``(c,)``."""
        out = value.copy()
        for mine, psi in zip(self.coordinates, self._psi, strict=True):
            if psi is not None:
                out[mine] = psi + np.linalg.lstsq(_tangent(psi), value[mine], rcond=1e-9)[0]
        return out

    def forces(self, value: Floats, force: Floats) -> Floats:
        """Return the forces conjugate to the rotation vectors in place of those to the relative ones ``(c,)``."""
        out = force.copy()
        for mine, psi in zip(self.coordinates, self._psi, strict=True):
            if psi is not None:
                out[mine] = _tangent(psi).T @ np.linalg.solve(_tangent(value[mine]).T, force[mine])
        return out


def _quaternion(psi: Floats) -> Floats:
    """Return the quaternion of a rotation vector of any length [rad]."""
    angle = float(np.linalg.norm(psi))
    return np.concatenate([[np.cos(0.5 * angle)], 0.5 * np.sinc(0.5 * angle / np.pi) * psi])


def _tangent(psi: Floats) -> Floats:
    """Return the right tangent of the exponential ``(3, 3)``: angular velocity in turned axes by the rate of psi."""
    angle, S = float(np.linalg.norm(psi)), skew(psi[None])[0]
    if angle < 1e-4:
        return np.asarray(np.eye(3) - 0.5 * S + S @ S / 6.0)
    return np.asarray(
        np.eye(3) - (1.0 - np.cos(angle)) / angle**2 * S + (angle - np.sin(angle)) / angle**3 * (S @ S)
    )
