"""A planar chain of links under a force at its end: the held shape of programs without a static solver."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root

from .cases import Floats, Vector


def held_angles(
    lengths: Floats, hinges: Floats, force: Vector, axial: float = np.inf, shear: float = np.inf
) -> tuple[Floats, Floats]:
    """Angles to the x axis (n,) and link vectors (n, 2) of a chain that hangs on a wall at angle zero.

    Moments about the ends of each link balance; the dead force is the same in every link.

    Args:
        lengths: of the links, m.
        hinges: stiffness before each link, N m; the first one is at the wall.
        force: at the free end, N; its z part is ignored.
        axial: stiffness of the links along themselves, N.
        shear: stiffness of the links across themselves, N.
    """
    pull = np.array(force[:2])

    def links(angles: Floats) -> Floats:
        along = np.column_stack([np.cos(angles), np.sin(angles)])
        across = np.column_stack([-np.sin(angles), np.cos(angles)])
        stretch, slip = 1.0 + along @ pull / axial, across @ pull / shear
        return lengths[:, None] * (stretch[:, None] * along + slip[:, None] * across)

    def imbalance(angles: Floats) -> Floats:
        moments = hinges * np.diff(angles, prepend=0.0)
        vectors = links(angles)
        turning = vectors[:, 0] * pull[1] - vectors[:, 1] * pull[0]
        return moments - np.append(moments[1:], 0.0) - turning

    angles = np.zeros(len(lengths))
    for part in np.linspace(0.1, 1.0, 10):
        pull = part * np.array(force[:2])
        found = root(imbalance, angles, tol=1e-12)
        angles = found.x
    if np.abs(imbalance(angles)).max() > 1e-9 * hinges.max():
        raise RuntimeError("no equilibrium of the chain was found")
    return angles, links(angles)
