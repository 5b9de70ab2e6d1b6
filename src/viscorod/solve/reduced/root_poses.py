"""The poses of the nodes from which rods begin, which turn and travel where nothing clamps them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.mechanics.elements.poses_from_strains import rotated
from viscorod.solve.reduced.shape_from_strains import Root
from viscorod.typing import Floats

__all__ = ["stage_poses", "unit"]


def stage_poses(roots: Sequence[Root], start: Floats, twists: Floats, A: Floats) -> Floats:
    """Return the poses of roots at all stages of a step ``(s, roots, 7)``, by the collocation method.

    ``q' = q (0, w)/2`` is linear in the quaternion; ``r' = R v`` follows.

    Args:
        roots: of the rods; start: their poses at the start of the step ``(roots, 7)``.
        twists: at the stages ``(s, roots, 6)``; A: step times the matrix of the method ``(s, s)``.
    """
    s = len(twists)
    out = np.tile(start, (s, 1, 1))
    for k, root in enumerate(roots):
        if root.held:
            continue
        turning = np.array([_turning(w) for w in twists[:, k, 3:]])
        matrix = np.eye(4 * s) - np.einsum("ij,jab->iajb", A, turning).reshape(4 * s, 4 * s)
        out[:, k, 3:] = np.linalg.solve(matrix, np.tile(start[k, 3:], s)).reshape(s, 4)
        if not root.pinned:
            out[:, k, :3] += A @ rotated(unit(out[:, k])[:, 3:], twists[:, k, :3])
    return out


def unit(poses: Floats) -> Floats:
    """Return poses ``(..., 7)`` with unit quaternions."""
    found = poses.copy()
    found[..., 3:] /= np.linalg.norm(found[..., 3:], axis=-1, keepdims=True)
    return found


def _turning(w: Floats) -> Floats:
    """Return the matrix of ``q -> q (0, w)/2 (4, 4)``."""
    x, y, z = 0.5 * w
    return np.array([[0, -x, -y, -z], [x, 0, z, -y], [y, -z, 0, x], [z, y, -x, 0]])
