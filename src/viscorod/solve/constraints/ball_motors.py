"""Motors that drive all three rotations of a joint: their turns are followed, whatever their size.

A rotation vector tells no more than half a turn, and is singular at a whole one. So coordinates are measured from
turned axes: the axes of b are compared with ``R_a Q_a B exp(theta)`` where the motors want ``B exp(theta) = exp(psi)``.
In statics ``B`` is where the motors are to be, beyond ``LARGEST``; in motions it is where they were at the beginning of
a step, since all stages of a step need the same coordinates.
"""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.joints.joint_coordinates import AT_Q_A, ROTATION
from viscorod.mechanics.rotations.adjoint_maps import skew
from viscorod.mechanics.rotations.quaternion import conjugate, product, rotation_vector
from viscorod.solve.problem.joint_set import JointSet
from viscorod.typing import Floats, Integers

__all__ = ["BallMotors"]

LARGEST = 3.0
"""Largest rotation vector [rad] that is measured as it is: beyond half a turn the shorter way is the other one."""
FAR = 1.0
"""Rotation from the turned axes [rad] from which on they are turned again."""


class BallMotors:
    """The joints of which motors drive all three rotations.

    Args:
        joints: all of them; geometry: that of their coordinates, of which the axes of a are turned here.

    Attributes:
        coordinates: of each joint ``(balls, 3)``.
        moving: whether a motion is under way, in which axes are turned by :meth:`turn_axes` alone.
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
        self._turned = np.tile([1.0, 0.0, 0.0, 0.0], (len(found), 1))
        self._psi, self._theta = np.zeros((2, len(found), 3))
        self._none: Integers = np.zeros(0, dtype=np.int64)

    def follow(self, target: Floats, rate: Floats) -> None:
        """Replace the targets and rates ``(c,)`` of these coordinates by those relative to the turned axes."""
        for k, mine in enumerate(self.coordinates):
            psi = target[mine].copy()
            if not self.moving:
                self._turn(k, psi if np.linalg.norm(psi) > LARGEST else np.zeros(3))
            theta = psi.copy()
            if self._turned[k, 0] < 1.0 or np.linalg.norm(psi) > LARGEST:
                theta = rotation_vector(product(conjugate(self._turned[k]), _quaternion(psi)))
                rate[mine] = np.linalg.solve(_tangent(theta), _tangent(psi) @ rate[mine])
            self._psi[k], self._theta[k], target[mine] = psi, theta, theta

    def turn_axes(self) -> list[tuple[Integers, Floats]]:
        """Turn the axes of joints that are far from them to where the last :meth:`follow` wants them.

        Returns:
            Coordinates of each ``(3,)``, and what makes of forces conjugate to them those to the new ones ``(3, 3)``.
        """
        turned: list[tuple[Integers, Floats]] = []
        for k, mine in enumerate(self.coordinates):
            if np.linalg.norm(self._theta[k]) > FAR:
                turned.append((mine, np.asarray(np.linalg.inv(_tangent(self._theta[k]).T))))
                self._turn(k, self._psi[k])
        return turned

    def _turn(self, k: int, psi: Floats) -> None:
        self._turned[k] = _quaternion(psi)
        self._geometry[self.coordinates[k], AT_Q_A : AT_Q_A + 4] = product(self._axes[k], self._turned[k])

    def values(self, value: Floats) -> Floats:
        """Return the rotation vectors in place of those relative to the turned axes, near the targets ``(c,)``."""
        out = value.copy()
        for k in self._far():
            mine, psi, theta = self.coordinates[k], self._psi[k], self._theta[k]
            out[mine] = psi + _by_rotation(psi, _tangent(theta) @ (value[mine] - theta))
        return out

    def rates(self, value: Floats, rate: Floats) -> Floats:
        """Return the rates of the rotation vectors in place of those of the relative ones ``(c,)``."""
        out = rate.copy()
        for k in self._far():
            mine = self.coordinates[k]
            out[mine] = _by_rotation(self._psi[k], _tangent(value[mine]) @ rate[mine])
        return out

    def forces(self, value: Floats, force: Floats) -> Floats:
        """Return the forces conjugate to the rotation vectors in place of those to the relative ones ``(c,)``."""
        out = force.copy()
        for k in self._far():
            mine = self.coordinates[k]
            out[mine] = _tangent(self._psi[k]).T @ np.linalg.solve(_tangent(value[mine]).T, force[mine])
        return out

    def _far(self) -> Integers:
        """Return the joints whose coordinates are not the rotation vectors themselves."""
        if not len(self.coordinates):
            return self._none
        return np.flatnonzero(np.any(self._psi != self._theta, axis=1))


def _by_rotation(psi: Floats, rotation: Floats) -> Floats:
    """Return the change of a rotation vector by a small rotation in turned axes; at whole turns the least one."""
    return np.asarray(np.linalg.lstsq(_tangent(psi), rotation, rcond=1e-9)[0])


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
