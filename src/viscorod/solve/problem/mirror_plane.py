"""The plane that a motion stays in because everything is its own mirror image there, and the unknowns that are left.

Where shape, sections, inertia, supports, loads and the start are symmetric about a plane, what happens is so too: no
motion leaves the plane, and of the six unknowns of a node only the two displacements in it and the rotation about its
normal are other than zero. Their equations contain no others. Joints, held strains, laws given from outside and rest
strains that change are not looked into: models with these count as spatial.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.unknowns import Unknowns
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

__all__ = ["MirrorPlane", "find_mirror_plane", "free_unknowns"]

EXACT = 1e-14
"""What rounding may leave of a number that is zero by symmetry, over those that it is of."""
SETTLED = 1e-12
"""The same in a state, which a solution has left."""

_MOVES = np.array([[1, 2], [2, 0], [0, 1]])
"""Displacements in the plane whose normal is axis 0, 1, 2."""


class MirrorPlane(NamedTuple):
    """A plane of symmetry.

    Attributes:
        normal: unit vector ``(3,)``.
        axes: of every node, that of its own axes which is the normal, or its opposite ``(n,)``.
        support_axes: the same of the axes of every support ``(m,)``.
    """

    normal: Floats
    axes: Integers
    support_axes: Integers

    @property
    def direction(self) -> str:
        """The normal in words."""
        size = np.abs(self.normal)
        if size.max() == 1.0:
            return "xyz"[int(size.argmax())]
        return "(" + ", ".join(f"{x:.4g}" for x in self.normal) + ")"

    def equations(self, problem: Problem) -> Integers:
        """Return the equations of motions in the plane, by their numbers among all ``(n, 3)``.

        Those of partly supported nodes are along the axes of the support.
        """
        inside, partial = _inside(self.axes), problem.supports.partial
        inside[problem.supports.nodes[partial]] = _inside(self.support_axes[partial])
        return np.asarray(6 * np.arange(problem.size)[:, None] + inside)

    def unknowns(self, problem: Problem) -> Unknowns | None:
        """Return the unknowns of motions in the plane of nodes that are not held completely; None if all are."""
        rows = _free_nodes(problem)
        if not len(rows):
            return None
        equations = self.equations(problem)[rows] - 6 * rows[:, None]
        return Unknowns.some(problem.pattern, rows, equations, _inside(self.axes[rows]))


def free_unknowns(problem: Problem) -> Unknowns | None:
    """Return the unknowns of nodes that are not held completely; None if multipliers need others, or there are none."""
    rows = _free_nodes(problem)
    if problem.multipliers or not len(rows):
        return None
    every = np.tile(np.arange(6), (len(rows), 1))
    return Unknowns.some(problem.pattern, rows, every, every)


def find_mirror_plane(
    problem: Problem, elements: Elements, state: State, given_strain: Floats | None = None
) -> tuple[MirrorPlane | None, str]:
    """Return a plane in which a motion stays that begins in a state, or what is not symmetric.

    Args:
        problem: whose motion it is.
        elements: of the system, with its rest strains.
        state: that the motion begins with.
        given_strain: initial strains at the Gauss points, if there are any.
    """
    unseen = _unseen(problem)
    if unseen:
        return None, unseen
    reasons = []
    frames = _Frames.of(problem, elements, state)
    for normal in frames.nodes[0].T:
        near = np.round(normal)
        exact = near if np.abs(near - normal).max() <= EXACT else normal
        look = _Look(problem, elements, state, frames, exact)
        parts = (look.shape, look.frames_along, look.loads, look.supports, look.sections)
        reason = next((why for part in (*parts, look.inertia, look.start) if (why := part())), "")
        reason = reason or look.strains(given_strain)
        plane = MirrorPlane(exact, look.axes, look.support_axes)
        if not reason:
            return plane, ""
        reasons.append(f"normal to {plane.direction}, {reason}")
    return None, "; ".join(reasons)


class _Frames(NamedTuple):
    """Axes as columns of rotation matrices: of nodes, where they are at the start, and of sections at element nodes.

    Attributes:
        nodes, start: ``(n, 3, 3)``; sections: of the nodes of all elements one after the other ``(m, 3, 3)``.
        arms: of these from the shared nodes, global axes ``(m, 3)`` [m].
        element: number of the element of each ``(m,)``; first: place of the first one of each ``(e,)``.
    """

    nodes: Floats
    start: Floats
    sections: Floats
    arms: Floats
    element: Integers
    first: Integers

    @classmethod
    def of(cls, problem: Problem, elements: Elements, state: State) -> _Frames:
        """Collect them."""
        counts = elements.order + 1
        within = np.arange(elements.nodes.shape[1]) < counts[:, None]
        nodes, links = elements.nodes[within], elements.links[within]
        frames = matrices(problem.quaternions)
        sections, arms = frames[nodes], np.zeros((len(nodes), 3))
        linked = np.flatnonzero(links >= 0)
        if len(linked):
            own, link = sections[linked], links[linked]
            arms[linked] = np.einsum("nij,nj->ni", own, problem.link_positions[link])
            sections[linked] = own @ matrices(problem.link_quaternions[link])
        element = np.repeat(np.arange(len(counts)), counts)
        return cls(frames, matrices(state.q), sections, arms, element, np.cumsum(counts) - counts)


def _unseen(problem: Problem) -> str:
    """Return what is not looked into."""
    if problem.constrained:
        return "it has joints, springs or held strains"
    if problem.laws.present:
        return "sections have laws of their own"
    if problem.motion_loads:
        return "loads see the motion"
    if any(strain.changes for _, strain in problem.rest_strains):
        return "rest strains change with time"
    return ""


class _Look:
    """Looks at a problem and at the state that its motion begins with, from the side of one plane.

    Each method returns what is not symmetric in its part, or nothing; :meth:`frames_along` comes before the others.
    """

    def __init__(
        self, problem: Problem, elements: Elements, state: State, frames: _Frames, normal: Floats
    ) -> None:
        self.problem, self.elements, self.state, self.frames = problem, elements, state, frames
        self.normal, self.length = normal, problem.length
        self.axes, self._off = _axes(frames.nodes, normal)
        at_stations, self._sections_off = _axes(frames.sections, normal)
        self.section_axes = at_stations[frames.first]
        self._sections_turn = bool((at_stations != self.section_axes[frames.element]).any())
        self.support_axes = self.axes[problem.supports.nodes].copy()

    def shape(self) -> str:
        """Look at the positions of nodes."""
        for r, most in ((self.problem.positions, EXACT), (self.state.r, SETTLED)):
            if np.ptp(r @ self.normal) > most * self.length:
                return "the shape is not plane"
        return ""

    def frames_along(self) -> str:
        """Look at the axes of nodes, where they are and where they begin, and of sections."""
        at_start, off = _axes(self.frames.start, self.normal)
        if self._off > EXACT or off > SETTLED or (at_start != self.axes).any():
            return "sections or bodies are turned against each other"
        arms = np.abs(self.frames.arms @ self.normal).max(initial=0.0)
        if self._sections_turn or self._sections_off > EXACT or arms > EXACT * self.length:
            return "sections are turned against each other, or attached out of the plane"
        return ""

    def start(self) -> str:
        """Look at the velocities at the start."""
        leaves = _leaves(self.state.twist, _outside(self.axes), self.length, SETTLED)
        return "the motion begins out of the plane" if leaves else ""

    def inertia(self) -> str:
        """Look at the masses of nodes."""
        return "masses are not symmetric" if _couple(self.problem.mass, self.axes) else ""

    def sections(self) -> str:
        """Look at what sections couple: stiffness, damping and Maxwell branches."""
        elements, problem = self.elements, self.problem
        points = np.arange(elements.section.shape[1]) < elements.order[:, None]
        about = np.broadcast_to(self.section_axes[:, None], points.shape)
        used, axes = np.divmod(np.unique(3 * elements.section[points] + about[points]), 3)
        several = [elements.stiffness[used], elements.damping[used]]
        if problem.relaxing:
            several += list(np.swapaxes(np.concatenate([e.branches for e in problem.sets])[used], 0, 1))
        return "sections are not symmetric" if any(_couple(one, axes) for one in several) else ""

    def strains(self, given: Floats | None) -> str:
        """Look at the strains of the unstressed shape, and at those that are given at the start."""
        outside = _outside(self.section_axes)[:, None]
        for strains, most in ((self.elements.reference, EXACT), (given, SETTLED)):
            if strains is not None and _leaves(strains, outside, self.length, most, floor=1.0):
                return "rods are bent or twisted out of the plane"
        return ""

    def supports(self) -> str:
        """Look at the axes along which supports hold nodes in part, and along which they move them."""
        supports = self.problem.supports
        matters = {*supports.partial.tolist(), *(k for k, _, _ in supports.motions)}
        for k in sorted(matters - set(np.flatnonzero(supports.in_body).tolist())):
            along = np.abs(self.normal @ supports.axes[k])
            self.support_axes[k] = along.argmax()
            if np.delete(along, self.support_axes[k]).max() > EXACT:
                return "supports are not symmetric"
        outside = _outside(self.support_axes)
        if any(outside[k, component] for k, component, _ in supports.motions):
            return "supports move out of the plane"
        return ""

    def loads(self) -> str:
        """Look at forces, which are to lie in the plane, and at moments, which are to act about its normal."""
        reason, per_length = "loads act out of the plane", 1.0 / self.length
        frame = np.linalg.svd(self.normal[None])[2]  # the normal, and two directions in the plane
        globally = _outside(np.zeros(1, dtype=np.int64))
        rods = np.concatenate([e.rod for e in self.problem.sets])

        def dead_leaves(wrenches: Floats) -> bool:
            turned = (wrenches.reshape(-1, 2, 3) @ frame.T).reshape(-1, 6)
            return _leaves(turned, globally, per_length, EXACT)

        for load in self.problem.nodal_loads:
            outside = _outside(self.axes[load.nodes])
            if dead_leaves(load.dead) or _leaves(load.following, outside, per_length, EXACT):
                return reason
            if dead_leaves(np.concatenate([load.gravity, np.zeros(3)])):
                return reason
            arms = np.where(outside[:, :3], load.arms, 0.0)
            if load.dead.any() and np.abs(arms).max(initial=0.0) > EXACT * self.length:
                return reason
        for one in self.problem.station_loads:
            outside = _outside(np.unique(self.section_axes[rods == one.rod]))
            if dead_leaves(one.dead) or any(
                _leaves(one.following, mark, per_length, EXACT) for mark in outside
            ):
                return reason
        return ""


def _free_nodes(problem: Problem) -> Integers:
    supports = problem.supports
    return np.setdiff1d(np.arange(problem.size), supports.nodes[supports.complete])


def _inside(axes: Integers) -> Integers:
    """Return the components of motions in the plane ``(n, 3)``, ascending."""
    return np.column_stack([np.sort(_MOVES[axes], axis=1), 3 + axes])


def _outside(axes: Integers) -> np.ndarray:
    """Mark the components of motions out of the plane ``(n, 6)``."""
    marks = np.ones((len(axes), 6), dtype=bool)
    np.put_along_axis(marks, _inside(axes), False, axis=1)
    return marks


def _axes(frames: Floats, normal: Floats) -> tuple[Integers, float]:
    """Return the axes ``(n,)`` nearest to the normal, and how far others are from being at right angles to it."""
    along = np.abs(normal @ frames)
    axes = along.argmax(axis=1)
    np.put_along_axis(along, axes[:, None], 0.0, axis=1)
    return axes, float(along.max(initial=0.0))


def _leaves(values: Floats, outside: np.ndarray, unit: float, most: float, floor: float = 0.0) -> bool:
    """Return whether motions, wrenches or strains ``(..., 6)`` have components out of the plane.

    Args:
        outside: marks these; unit: of the last three components, in which they are like the first three.
        most: of the largest component, at least of ``floor``, is rounding.
    """
    sizes = np.abs(values) * np.repeat([1.0, unit], 3)
    out = np.where(outside, sizes, 0.0).max(initial=0.0)
    return bool(out > most * max(sizes.max(initial=0.0), floor))


def _couple(square: Floats, axes: Integers) -> bool:
    """Return whether matrices ``(n, 6, 6)`` couple what is in the plane with what is not."""
    outside = _outside(axes)
    across = outside[:, :, None] != outside[:, None, :]
    size = np.sqrt(np.abs(np.einsum("nii->ni", square)))
    return bool((across & (np.abs(square) > EXACT * size[:, :, None] * size[:, None, :])).any())
