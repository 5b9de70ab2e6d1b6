"""Corrections of velocities at the end of a step, where supports hold a place in part: how they change, and back."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.rotations.adjoint_maps import adjoint_map
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

__all__ = ["EndCorrections"]

TURN = 3e-5
"""Rotation [rad], or displacement over the length of the model, of differences."""


class EndCorrections:
    """How corrections of twists at the end of a step change with the poses and the twists of its last stage.

    Supports that hold a place in part give it exactly the velocities that they prescribe. Where they hold
    displacements, twists are corrected by what a prescribed motion differs from its polynomial: vectors that are
    constant in space, and turn back as the node turns. Where they hold rotations, components of the twists are
    replaced, along directions that follow the pose: differences tell how, of what takes microseconds.

    Args:
        actions: of the model, on a system that nothing else works with.
    """

    def __init__(self, actions: StepActions) -> None:
        self._actions, supports, size = actions, actions.supports, actions.system.problem.size
        self._partial = len(supports.partial) > 0
        self._nodes = supports.set.nodes[supports.partial]
        self._turning = bool(supports.set.fixed[supports.partial][:, 3:].any())
        self._by_pose = np.zeros((size, 6, 6))
        self._by_twist = np.broadcast_to(np.eye(6), (size, 6, 6)).copy()

    def take(self, step: StageRecord) -> None:
        """Take a step."""
        if not self._partial:
            return
        self._actions.move_supports(float(step.times[-1]), before=True)
        poses, twist, nodes = (step.r[-1], step.q[-1]), step.twist[-1], self._nodes
        corrected = self._corrected(*poses, twist)
        if not self._turning:
            change = np.zeros_like(twist)
            change[:, 3:] = (corrected - twist)[:, :3]
            self._by_pose[:, :3, 3:] = adjoint_map(change)[:, 3:, 3:]
            return
        length = self._actions.system.problem.length
        for j in range(6):
            unit = np.zeros_like(twist)
            unit[nodes, j] = 1.0
            self._by_twist[nodes, :, j] = (self._corrected(*poses, twist + unit) - corrected)[nodes]
            size = TURN if j >= 3 else TURN * length
            both = []
            for sign in (1.0, -1.0):
                r, q = (part.copy() for part in poses)
                retract(r, q, sign * size * unit, r, q)
                both.append(self._corrected(r, q, twist)[nodes])
            self._by_pose[nodes, :, j] = (both[0] - both[1]) / (2.0 * size)

    def forward(self, pose: Floats, twist: Floats) -> Floats:
        """Return the change of the twists at the end ``(n, 6)`` with those of the last stage."""
        if not self._partial:
            return twist
        found = np.einsum("nij,nj->ni", self._by_twist, twist)
        return np.asarray(found + np.einsum("nij,nj->ni", self._by_pose, pose))

    def backward(self, pose: Floats, twist: Floats) -> tuple[Floats, Floats]:
        """Return derivatives by poses and twists at the end as ones by those of the last stage."""
        if not self._partial:
            return pose, twist
        by_pose = pose + np.einsum("nji,nj->ni", self._by_pose, twist)
        return by_pose, np.asarray(np.einsum("nji,nj->ni", self._by_twist, twist))

    def _corrected(self, r: Floats, q: Floats, twist: Floats) -> Floats:
        state = State(r, q, twist.copy())
        self._actions.supports.project_twists(state)
        return state.twist
