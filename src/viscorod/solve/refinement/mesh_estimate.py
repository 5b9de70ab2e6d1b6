"""The error that a mesh leaves in an equilibrium: its difference from the one on a mesh twice as fine.

One idea for all analyses: what is solved on elements half as long, from what the coarse ones have found, differs from
that by nearly its whole error, since errors fall with a power of the length (Richardson 1911; Zienkiewicz and Zhu,
Int. J. Numer. Meth. Eng. 24 (1987), call the difference from a better solution an error estimator).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.solve.refinement.finer_mesh import FinerMesh, Shape, halves
from viscorod.typing import Floats

__all__ = ["MeshEstimate", "difference"]

LEAST_MOTION = 1e-8
"""Part of the model's length below which a motion is taken as this: round-off and the tolerance of Newton's method."""
FAINT = 1e5
"""Section forces below this many times their round-off are taken as this."""
MINOR = 1e-2
"""Part of the forces, times the length, that counts as moments where there are none, and the other way round."""


@dataclass(frozen=True)
class MeshEstimate:
    """Estimated errors of a mesh in some states, and what they are measured by.

    Attributes:
        rods: rod -> error of displacements over its length, anywhere on it.
        gap: the largest error of positions [m]; moved: the largest displacement, at most the model's length [m].
        forces: the largest force [N] and moment [N m] of sections ``(2,)``.
        elements: rod -> what ``gap`` would be if all were like this element [m], and its errors of the force [N] and
            of the moment [N m] of sections, anywhere in it ``(elements, 3)``.
        length: of the model [m].
        hidden: part of ``gap`` that steps of the motion hide: no finer mesh mends it while they do [m].
    """

    rods: dict[str, float]
    gap: float
    moved: float
    forces: Floats
    elements: dict[str, Floats]
    length: float
    hidden: float = 0.0

    @property
    def sizes(self) -> Floats:
        """What errors of positions [m], section forces [N] and moments [N m] are measured by ``(3,)``.

        Forces or moments that are small beside the others, over the length, count as a part of them.
        """
        n, m = self.forces
        least = MINOR * np.array([m / self.length, n * self.length])
        moved = max(self.moved, LEAST_MOTION * self.length)
        return np.maximum([moved, *np.maximum([n, m], least)], np.finfo(float).tiny)

    @property
    def motion(self) -> float:
        """The largest error of positions over the largest displacement."""
        return float(self.gap / self.sizes[0])

    @property
    def mendable(self) -> float:
        """The part of ``motion`` that a finer mesh mends."""
        return float((self.gap - self.hidden) / self.sizes[0])

    @property
    def force(self) -> float:
        """The largest error of section forces, or moments, over the largest."""
        worst = np.max([errors[:, 1:].max(axis=0) for errors in self.elements.values()], axis=0)
        return float((worst / self.sizes[1:]).max())

    @property
    def largest(self) -> float:
        """The larger of both."""
        return max(self.motion, self.force)

    def of_elements(self, rod: str) -> Floats:
        """Return the errors of the elements of a rod, of motion and of section forces, in parts ``(elements, 2)``."""
        parts = self.elements[rod] / self.sizes
        return np.column_stack([parts[:, 0], parts[:, 1:].max(axis=1)])

    def drifted(
        self, gaps: dict[str, float], seen: dict[str, float], lengths: dict[str, float]
    ) -> MeshEstimate:
        """Return the estimate with gaps of rods in time [m], which are none of single elements, beside those in space.

        Args:
            gaps: of every rod [m]; seen: those that steps do not hide [m]; lengths: of the rods [m].
        """
        rods = {name: error + gaps[name] / lengths[name] for name, error in self.rods.items()}
        most = max(gaps.values())
        return replace(self, gap=self.gap + most, rods=rods, hidden=most - max(seen.values()))

    def joined(self, other: MeshEstimate | None) -> MeshEstimate:
        """Return the larger errors, and the larger sizes, of two estimates of the same mesh."""
        if other is None:
            return self
        return MeshEstimate(
            {name: max(error, other.rods[name]) for name, error in self.rods.items()},
            max(self.gap, other.gap),
            max(self.moved, other.moved),
            np.maximum(self.forces, other.forces),
            {name: np.maximum(errors, other.elements[name]) for name, errors in self.elements.items()},
            self.length,
        )


def difference(finer: FinerMesh, shape: Shape, found: Shape) -> MeshEstimate:
    """Return the errors of a solution of the coarse mesh, from the one that was ``found`` on the finer mesh."""
    coarse = finer.coarse
    r, q = finer.interpolated(shape.state)
    fine_r, fine_q = finer.stations(found.state)
    moved = float(np.linalg.norm(fine_r - finer.reference, axis=1).max(initial=0.0))
    forces = np.linalg.norm(found.section_force.reshape(-1, 2, 3), axis=2).max(axis=0)
    forces = np.maximum(forces, FAINT * _round_off(finer, r))
    rods, elements = {}, {}
    worst = 0.0
    first = point = 0
    for name, (p, n), length in zip(coarse.rods, finer.sizes, coarse.rod_lengths, strict=True):
        mine = slice(first, first + 2 * p * n + 1)
        gaps = (r - finer.coarse_reference)[mine] - (fine_r - finer.reference)[mine]
        gap = float(np.linalg.norm(gaps, axis=1).max())
        ends = first + 2 * p * np.arange(n + 1)
        turned = _relative(r[ends], q[ends], fine_r[ends], fine_q[ends], coarse.length)
        apart = _force_gaps(
            p,
            shape.section_force[point : point + p * n].reshape(n, p, 6),
            found.section_force[2 * point : 2 * (point + p * n)].reshape(n, 2 * p, 6),
        )
        rods[name] = gap / float(length)
        elements[name] = np.column_stack([np.maximum(n * turned, _inside(gaps, 2 * p)), apart])
        worst = max(worst, gap)
        first, point = mine.stop, point + p * n
    return MeshEstimate(rods, worst, min(moved, coarse.length), forces, elements, coarse.length)


def _round_off(finer: FinerMesh, r: Floats) -> Floats:
    """Return what rounding the positions ``r`` of stations makes of section forces [N] and moments [N m] ``(2,)``."""
    size, noise = max(finer.coarse.length, float(np.abs(r).max())), np.zeros(2)
    for part in finer.problem.sets:
        spacing = 2.0 * float(part.half_lengths.min()) / part.order
        axial, bending = (float(np.abs(part.stiffness[:, k, k]).max()) for k in (slice(0, 3), slice(3, 6)))
        noise = np.maximum(noise, [axial * size / spacing, bending / spacing])
    return np.asarray(np.finfo(float).eps * noise)


def _inside(gaps: Floats, step: int) -> Floats:
    """Return the largest difference within every element beside that of its ends ``(elements,)`` [m].

    Args:
        gaps: of the positions of a rod's stations ``(step n + 1, 3)`` [m]; step: stations to the end of an element.
    """
    ends = gaps[::step]
    part = np.arange(1, step) / step
    between = (1.0 - part)[:, None] * ends[:-1, None] + part[:, None] * ends[1:, None]
    inner = gaps[:-1].reshape(len(ends) - 1, step, 3)[:, 1:]
    return np.asarray(np.linalg.norm(inner - between, axis=2).max(axis=1))


def _force_gaps(order: int, mine: Floats, theirs: Floats) -> Floats:
    """Return the largest differences of section forces and moments, as the polynomials of elements give them.

    Args:
        order: of the elements; mine, theirs: section forces at their Gauss points ``(n, p, 6)`` and ``(n, 2 p, 6)``.

    Returns:
        ``(n, 2)`` [N, N m].
    """
    read = halves(order)
    apart = np.einsum("kg,egc->ekc", read.whole, mine) - np.einsum("kg,egc->ekc", read.divided, theirs)
    return np.asarray(np.linalg.norm(apart.reshape(len(mine), -1, 2, 3), axis=3).max(axis=1))


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
