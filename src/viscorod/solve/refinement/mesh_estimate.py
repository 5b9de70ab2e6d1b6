"""The error that a mesh leaves in an equilibrium: its difference from the one on a mesh twice as fine.

One idea for all analyses: what is solved on elements half as long, from what the coarse ones have found, differs from
that by nearly its whole error, since errors fall with a power of the length (Richardson 1911; Zienkiewicz and Zhu,
Int. J. Numer. Meth. Eng. 24 (1987), call the difference from a better solution an error estimator).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape, halves
from viscorod.typing import Floats

__all__ = ["MeshEstimate", "difference"]

LEAST_MOTION = 1e-8
"""Part of the model's length below which a motion is taken as this: round-off and the tolerance of Newton's method."""
MINOR = 1e-2
"""Part of the forces, times the length, that counts as moments where there are none, and the other way round."""


@dataclass(frozen=True)
class MeshEstimate:
    """Estimated errors of a mesh.

    Attributes:
        rods: rod -> error of the positions of element ends over its length.
        motion: the largest error of positions over the largest displacement of the model.
        force: the largest error of section forces (moments) over the largest of the model, anywhere in elements.
        elements: rod -> what each element adds to ``motion``, and its error of section forces ``(elements, 2)``.
    """

    rods: dict[str, float]
    motion: float
    force: float
    elements: dict[str, Floats]

    @property
    def largest(self) -> float:
        """The larger of both."""
        return max(self.motion, self.force)

    def joined(self, other: MeshEstimate | None) -> MeshEstimate:
        """Return the larger errors of two estimates of the same mesh."""
        if other is None:
            return self
        return MeshEstimate(
            {name: max(error, other.rods[name]) for name, error in self.rods.items()},
            max(self.motion, other.motion),
            max(self.force, other.force),
            {name: np.maximum(errors, other.elements[name]) for name, errors in self.elements.items()},
        )


def difference(finer: FinerMesh, shape: Shape, found: Shape) -> MeshEstimate:
    """Return the errors of a solution of the coarse mesh, from the one that was ``found`` on the finer mesh."""
    coarse = finer.coarse
    r, q = finer.coarse_stations(shape.state)
    fine_r, fine_q = finer.stations(found.state)
    moved = float(np.linalg.norm(r - finer.coarse_reference, axis=1).max(initial=0.0))
    scale = min(max(moved, LEAST_MOTION * coarse.length), coarse.length)
    sizes = _force_scales(found.section_force, coarse.length)
    rods, elements = {}, {}
    worst_motion = worst_force = 0.0
    first = first_point = 0
    for number, (name, division) in enumerate(finer.divisions.items()):
        p, n, length = division.order, division.count, coarse.rod_lengths[number]
        ends, fine_ends = first + p * np.arange(n + 1), 2 * first - number + 2 * p * np.arange(n + 1)
        gap = float(np.linalg.norm(r[ends] - fine_r[fine_ends], axis=1).max())
        if n == 1:
            middle = halves(p).nodes[p] @ r[first : first + p + 1]
            gap = max(gap, float(np.linalg.norm(middle - fine_r[fine_ends[0] + p])))
        own = _relative(r[ends], q[ends], fine_r[fine_ends], fine_q[fine_ends], coarse.length) / scale
        mine = shape.section_force[first_point : first_point + p * n].reshape(n, p, 6)
        theirs = found.section_force[2 * first_point : 2 * (first_point + p * n)].reshape(n, 2 * p, 6)
        read = halves(p)
        apart = np.einsum("kg,egc->ekc", read.whole, mine) - np.einsum("kg,egc->ekc", read.divided, theirs)
        force = (np.linalg.norm(apart.reshape(n, -1, 2, 3), axis=3) / sizes).max(axis=(1, 2))
        rods[name] = gap / float(length)
        elements[name] = np.column_stack([own, force])
        worst_motion, worst_force = max(worst_motion, gap / scale), max(worst_force, float(force.max()))
        first, first_point = first + p * n + 1, first_point + p * n
    return MeshEstimate(rods, worst_motion, worst_force, elements)


def _force_scales(force: Floats, length: float) -> Floats:
    """Return the largest force [N] and moment [N m] of ``(m, 6)``; a small one is a part of the other."""
    n, m = np.linalg.norm(force.reshape(-1, 2, 3), axis=2).max(axis=0)
    return np.maximum([n, m], np.maximum(MINOR * np.array([m / length, n * length]), np.finfo(float).tiny))


def _relative(r: Floats, q: Floats, fine_r: Floats, fine_q: Floats, length: float) -> Floats:
    """Return by how much the pose of the end of every element, seen from its start, differs ``(elements,)`` [m].

    Rotations count with the length of the model: they carry what comes after them.
    """

    def seen(r: Floats, q: Floats) -> tuple[Floats, Floats]:
        frames = matrices(q[:-1])
        return np.einsum("eji,ej->ei", frames, np.diff(r, axis=0)), product(conjugate(q[:-1]), q[1:])

    (d, turn), (fine_d, fine_turn) = seen(r, q), seen(fine_r, fine_q)
    angle = 2.0 * np.linalg.norm(product(conjugate(turn), fine_turn)[:, 1:], axis=1)
    return np.asarray(np.linalg.norm(d - fine_d, axis=1) + length * angle)
