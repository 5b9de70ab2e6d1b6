"""The error that a mesh leaves in an equilibrium: its difference from the one on a mesh twice as fine.

One idea for all analyses: what is solved on elements half as long, from what the coarse ones have found, differs from
that by nearly its whole error, since errors fall with a power of the length (Richardson 1911; Zienkiewicz and Zhu,
Int. J. Numer. Meth. Eng. 24 (1987), call the difference from a better solution an error estimator).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, matrices, product
from viscorod.solve.refinement.finer_mesh import Carried, FinerMesh, Shape
from viscorod.solve.refinement.half_elements import read
from viscorod.typing import Floats, Integers

__all__ = ["MeshEstimate", "difference"]

SAFETY = 1.5
"""Factor on differences of two motions: the finer one has errors of its own, and times between are not compared."""

LEAST_MOTION = 1e-8
"""Part of the model's length below which a motion is taken as this: round-off and the tolerance of Newton's method."""
FAINT = 1e5
"""Section forces below this many times their round-off are taken as this."""
MINOR = 1e-2
"""Part of the forces, times the length, that counts as moments where there are none, and the other way round; and of
the rotations, times the length, that counts as displacement where rods turn about themselves and nothing else moves."""


@dataclass(frozen=True)
class MeshEstimate:
    """Estimated errors of a mesh in some states, and what they are measured by.

    Attributes:
        rods: rod -> error of displacements over its length, anywhere on it.
        gap: the largest error of positions [m]; moved: the largest displacement, at most the model's length, and no
            less than ``MINOR`` of the largest rotation times that [m].
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

    def grown(self, factor: float) -> MeshEstimate:
        """Return the estimate with errors of positions that many times as large, at most twice what moves [m]."""
        most = max(1.0, min(factor, 2.0 * self.sizes[0] / max(self.gap, np.finfo(float).tiny)))
        rods = {name: most * error for name, error in self.rods.items()}
        return replace(self, gap=most * self.gap, hidden=most * self.hidden, rods=rods)

    def of_runs(self, gaps: dict[str, float], lengths: dict[str, float], moved: float) -> MeshEstimate:
        """Return the estimate with errors of positions that two whole motions show; what steps hide is beside them.

        Args:
            gaps: differences of every rod [m]; lengths: of the rods [m]; moved: the largest displacement [m].
        """
        rods = {name: (SAFETY * gap + self.hidden) / lengths[name] for name, gap in gaps.items()}
        most = SAFETY * max(gaps.values()) + self.hidden
        return replace(self, gap=most, rods=rods, moved=max(self.moved, min(moved, self.length)))

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


def difference(
    finer: FinerMesh, carried: Carried, found: Sequence[Shape], jumping: Sequence[Integers] = ()
) -> MeshEstimate:
    """Return the largest errors of some solutions of the coarse mesh, from those ``found`` on the finer mesh.

    Args:
        finer, carried, found: both meshes, and the solutions on them.
        jumping: of each solution, the elements within which forces jump; these count no errors of forces there.
    """
    coarse, halves = finer.coarse, finer.halves
    r, q, mine = carried.r, carried.q, np.array([shape.section_force for shape in carried.shapes])
    theirs = np.array([shape.section_force for shape in found])
    fine_r, fine_q = finer.stations(*(np.array([getattr(s.state, name) for s in found]) for name in "rq"))
    moved = float(np.linalg.norm(fine_r - finer.reference, axis=-1).max(initial=0.0))
    turns = product(conjugate(np.broadcast_to(finer.reference_turns, fine_q.shape)), fine_q)
    sine = np.linalg.norm(turns[..., 1:], axis=-1).max(initial=0.0)
    moved = max(moved, MINOR * min(2.0 * float(sine), 1.0) * coarse.length)
    forces = np.linalg.norm(theirs.reshape(-1, 2, 3), axis=2).max(axis=0)
    forces = np.maximum(forces, FAINT * _round_off(finer, r))
    gaps = (r - finer.coarse_reference) - (fine_r - finer.reference)
    of_rods = _largest(np.linalg.norm(gaps, axis=-1), halves.finer_stations)
    inside = _largest(np.linalg.norm(read(halves.inside, gaps), axis=-1), halves.inner)
    turned = _relative((r, q), (fine_r, fine_q), halves.ends, coarse.length).max(axis=0)
    apart = (read(halves.whole, mine) - read(halves.divided, theirs)).reshape(len(found), -1, 2, 3)
    apart = np.linalg.norm(apart, axis=-1)
    for k, under in enumerate(jumping):
        first = np.append(halves.places, apart.shape[1])
        for element in under:
            apart[k, first[element] : first[element + 1], 0] = 0.0
    apart = _largest(apart, halves.places)
    rods, elements = {}, {}
    for k, (name, length) in enumerate(zip(coarse.rods, coarse.rod_lengths, strict=True)):
        own = slice(halves.elements[k], halves.elements[k + 1])
        rods[name] = float(of_rods[k]) / float(length)
        errors = np.maximum((own.stop - own.start) * turned[own], inside[own])
        elements[name] = np.column_stack([errors, apart[own]])
    return MeshEstimate(
        rods, float(of_rods.max()), min(moved, coarse.length), forces, elements, coarse.length
    )


def _largest(values: Floats, first: Integers) -> Floats:
    """Return the largest of ``values (k, places, ...)`` in all of ``k`` states, of places from each ``first`` on."""
    return np.asarray(np.maximum.reduceat(values.max(axis=0), first, axis=0))


def _round_off(finer: FinerMesh, r: Floats) -> Floats:
    """Return what rounding the positions ``r`` of stations makes of section forces [N] and moments [N m] ``(2,)``."""
    size, noise = max(finer.coarse.length, float(np.abs(r).max())), np.zeros(2)
    for part in finer.problem.sets:
        spacing = 2.0 * float(part.half_lengths.min()) / part.order
        axial, bending = (float(np.abs(part.stiffness[:, k, k]).max()) for k in (slice(0, 3), slice(3, 6)))
        noise = np.maximum(noise, [axial * size / spacing, bending / spacing])
    return np.asarray(np.finfo(float).eps * noise)


def _relative(
    mine: tuple[Floats, Floats], theirs: tuple[Floats, Floats], ends: Integers, length: float
) -> Floats:
    """Return by how much the pose of the end of every element, seen from its start, differs ``(k, elements)`` [m].

    Rotations count with the length of the model: they carry what comes after them.

    Args:
        mine, theirs: positions [m] and unit quaternions of stations ``(k, stations, ...)``; ends: of all elements
            ``(elements, 2)``.
    """

    def seen(r: Floats, q: Floats) -> tuple[Floats, Floats]:
        start, end = ends.T
        frames = matrices(q[:, start].reshape(-1, 4)).reshape(len(q), -1, 3, 3)
        way = r[:, end] - r[:, start]
        return np.einsum("keji,kej->kei", frames, way), product(conjugate(q[:, start]), q[:, end])

    (d, turn), (fine_d, fine_turn) = seen(*mine), seen(*theirs)
    angle = 2.0 * np.linalg.norm(product(conjugate(turn), fine_turn)[..., 1:], axis=-1)
    return np.asarray(np.linalg.norm(d - fine_d, axis=-1) + length * angle)
