"""What parts two points of a path beside a bifurcation: a load that leads to one side, or rounding."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.statics.softness import softest_motions
from viscorod.solve.statics.special_points import PathPoint
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Inverse
from viscorod.typing import Floats

__all__ = ["parted_by_rounding"]

ROUNDED = 0.1
"""Imbalance across a path, as a part of that of rounding, which no load makes: on paths of rings and arches it is up to
0.02, and 1.6 at least, mostly hundreds, where next to no load parts them."""


class Line(Protocol):
    """What is needed of a path to compare two of its points."""

    static: StaticSolver
    t: float
    before: bool
    weights: Floats

    def imbalance(self, point: PathPoint) -> Floats:
        """Return the forces and moments that are left at the nodes of a point."""


def parted_by_rounding(path: Line, first: PathPoint, last: PathPoint) -> bool:
    """Return whether an imbalance of the size of rounding moves two equilibria beside a bifurcation apart.

    Along a motion of stiffness k an imbalance e moves an equilibrium by e/k, to one side before a bifurcation and to
    the other one behind it (Koiter; see Thompson and Hunt, A General Theory of Elastic Stability, 1973). So the larger
    stiffness of the two, times half of what they are apart, is at least as large as e: how far they are apart alone
    says nothing, as rounding of stiff sections moves soft ones far. What rounding makes is what it has left at each of
    the nodes, with random signs.
    """
    static = path.static
    tangents = [
        static.tangent(point.state, path.t, before=path.before, scale=point.factor) for point in (first, last)
    ]
    try:
        stiffness, motions = softest_motions(Inverse(tangents[0]))
    except SingularMatrixError:
        return False
    then = np.einsum("ik,ik->k", motions, tangents[1].stiffness @ motions)
    root = np.sqrt(path.weights)
    gap = root * (last.change.increment - first.change.increment)
    nodal = np.asarray(tangents[0].basis @ motions).T.reshape(-1, *gap.shape)
    directions = np.concatenate([root * nodal, (root * first.forward.increment)[None]])
    parts = np.linalg.lstsq(directions.reshape(len(directions), -1).T, gap.ravel(), rcond=None)[0]
    across = 0.5 * np.maximum(np.abs(stiffness), np.abs(then)) * np.abs(parts[:-1])
    left = [tangents[k].basis.T @ path.imbalance(point).ravel() for k, point in enumerate((first, last))]
    noise = np.max([np.linalg.norm(motions * forces[:, None], axis=0) for forces in left], axis=0)
    return bool((across < ROUNDED * noise).all())
