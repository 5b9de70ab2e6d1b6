"""Rigid motions of the parts of a model that supports and joints leave free."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.free_motion import FreeMotion, described
from viscorod.solve.constraints.parts import Parts, count_of_parts, held_motions, many_parts, null_space
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.once import once_of_layout
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["RigidParts", "free_motions", "motions_of_parts", "rigid_share"]


@once_of_layout
def free_motions(problem: Problem) -> list[FreeMotion]:
    """Return the rigid motions of all parts that supports, joints and springs allow in the reference shape.

    A part is what shares nodes: rods with their attachments and bodies. Parts move together where joints join them.
    """
    r, q = problem.positions, problem.quaternions
    joints, parts = problem.joints, Parts.of(problem, r, q)
    held = held_motions(problem, parts.R)
    gradients = joints.measure(r, q, np.zeros((problem.size, 6)))[2]
    counted = (joints.arrays.place >= 0) | joints.has_spring
    return [described(parts, group, motion) for group, motion in parts.free(held, gradients, counted)]


@once_of_layout
def surely_held(problem: Problem) -> bool:
    """Return whether all is one part that a support holds completely: no rigid motion is left then."""
    return len(problem.supports.complete) > 0 and count_of_parts(problem) == 1


def motions_of_parts(
    problem: Problem, r: Floats, q: Floats, held: list[Floats], gradients: Floats
) -> RigidParts:
    """Return the rigid motions of all parts that supports and joints allow in a state; springs resist them.

    Elements do not, however they are strained, so that loads and springs alone decide which of them are free. Of very
    many joined parts only motions of single ones are found, such as the spin of a rod between ball joints.

    Args:
        problem: whose parts they are; r, q: poses of its nodes.
        held: derivatives ``(6, 6)`` of the motions of every support by the body increment of its node.
        gradients: of all coordinates of joints ``(c, 12)``.
    """
    parts = Parts.of(problem, r, q)
    search = parts.free_alone if many_parts(problem) else parts.free
    return RigidParts(parts, search(held, gradients, problem.joints.arrays.place >= 0))


@dataclass(frozen=True)
class RigidParts:
    """Rigid motions of parts; ``increments (6 n, k)`` are their nodal body increments, in lengths of the model."""

    parts: Parts
    found: list[tuple[list[int], Floats]]

    @cached_property
    def increments(self) -> Floats:
        """Nodal body increments ``(6 n, k)``."""
        moves = np.zeros((len(self.found), self.parts.count, 6))
        for k, (group, motion) in enumerate(self.found):
            moves[k, group] = motion.reshape(-1, 6)
        return self.parts.increments(moves).reshape(len(moves), -1).T.copy()

    def combined(self, weights: Floats) -> list[FreeMotion]:
        """Return as many motions as ``weights (k, m)`` combine, single ones of single parts where possible."""
        if weights.shape[1] == len(self.found):
            return [described(self.parts, group, motion) for group, motion in self.found]
        every = list(range(self.parts.count))
        columns = np.zeros((6 * self.parts.count, len(self.found)))
        for k, (group, motion) in enumerate(self.found):
            columns.reshape(-1, 6, len(self.found))[group, :, k] = motion.reshape(-1, 6)
        allowed, _ = np.linalg.qr(columns @ weights)
        across = np.eye(len(allowed)) - allowed @ allowed.T
        return [described(self.parts, every, motion) for motion in null_space(across, 1e-6)]


def rigid_share(problem: Problem, r: Floats, q: Floats, increments: np.ndarray) -> Floats:
    """Return the part ``(m,)`` of the kinetic energy of nodal velocities ``(6 n, m)`` in rigid motions of parts."""
    parts = Parts.of(problem, r, q)
    T, M = parts.moves(), block_diagonal(problem.mass)
    momenta = T.T @ (M @ increments)
    inertia = sparse.bsr_array(T.T @ M @ T, blocksize=(6, 6))
    inertia.sort_indices()
    blocks = np.zeros((parts.count, 6, 6))
    blocks[inertia.indices] = inertia.data
    own = momenta.reshape(parts.count, 6, -1)
    moving = np.linalg.pinv(blocks, rcond=1e-12, hermitian=True) @ own
    energy = np.einsum("im,im->m", increments.conj(), M @ increments).real
    return np.asarray(np.einsum("pim,pim->m", own.conj(), moving).real / energy)
