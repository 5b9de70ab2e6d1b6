"""The discretised model: frozen arrays that every analysis and formulation works on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from viscorod.mechanics.elements.held_strains import HeldStrains
from viscorod.mechanics.elements.section_laws import SectionLaws
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.load_effects import MotionLaw, TimeFactor
from viscorod.model.actions.rest_strain import RestStrain
from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.actions.time_table import TimeTable
from viscorod.solve.linear.known_plans import plan_of
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.solve.problem.joint_set import JointSet
from viscorod.typing import Floats, Integers


@dataclass(frozen=True)
class ElementSet:
    """All elements of one polynomial order, as arrays for ``mechanics.elements.geometric_element.assemble``.

    ``slots (elements, m, m)`` are the matrix blocks between the nodes of an element, of the problem's pattern.
    ``held (sections, 6)`` marks strains that multipliers hold; stiffness and damping have no rows and columns there.
    ``branches (sections, n, 6, 6)`` are the stiffnesses of the Maxwell branches with the problem's relaxation times.
    ``laws`` are those of the sections beside these matrices.
    ``half_widths (elements, points)`` [m] are the largest distances of the section from the centre line, 0 if unknown.
    """

    order: int
    nodes: Integers
    links: Integers
    slots: Integers
    rod: Integers
    start: Floats
    half_lengths: Floats
    shapes: Floats
    slopes: Floats
    weights: Floats
    section: Integers
    half_widths: Floats
    stiffness: Floats
    damping: Floats
    held: Floats
    branches: Floats
    laws: SectionLaws

    @property
    def damped(self) -> bool:
        """True if any section has viscosity."""
        return self.laws.present or bool(np.any(self.damping != 0.0))

    @property
    def coupled(self) -> bool:
        """True if any section couples different strains; kernels skip the off-diagonals otherwise."""
        if self.laws.present:
            return True
        matrices = (self.stiffness, self.damping, self.branches.reshape(-1, 6, 6))
        return any(map(_has_couplings, matrices))


def _has_couplings(matrices: Floats) -> bool:
    """Return whether any of some matrices ``(k, 6, 6)`` has an entry beside its diagonal."""
    return bool(np.count_nonzero(matrices) > np.count_nonzero(np.einsum("kii->ki", matrices)))


@dataclass(frozen=True)
class SupportSet:
    """Supported nodes: axes ``(m, 3, 3)``, fixed components ``(m, 6)`` as 0/1, prescribed motions, names.

    Axes that are zero are those of the moving section: velocities along them are held.
    """

    nodes: Integers
    axes: Floats
    fixed: Floats
    names: tuple[str, ...]
    motions: tuple[tuple[int, int, TimeFunction], ...]  # (support, component, time function)

    @property
    def complete(self) -> Integers:
        """Indices of supports that prescribe the whole pose."""
        return np.flatnonzero(self.fixed.all(axis=1) & ~self.in_body).astype(np.int64)

    @property
    def partial(self) -> Integers:
        """Indices of supports that leave some motion free."""
        return np.flatnonzero(~self.fixed.all(axis=1) | self.in_body).astype(np.int64)

    @property
    def in_body(self) -> np.ndarray:
        """Mask of the supports that hold velocities along the axes of the moving section ``(m,)``."""
        return np.asarray(~self.axes.any(axis=(1, 2)))


@dataclass(frozen=True)
class NodalLoad:
    """Dead (global) and following (body) wrenches on some nodes with one time factor; or gravity.

    Dead forces act at ``arms (k, 3)`` from the nodes, node axes [m]. ``load`` is the number of the model's load.
    """

    load: int
    nodes: Integers
    dead: Floats
    following: Floats
    gravity: Floats
    arms: Floats
    factor: TimeFactor


@dataclass(frozen=True)
class StationLoad:
    """A concentrated wrench at an arc length of a rod, which may move; outside the rod it does not act."""

    load: int
    rod: int
    position: TimeFactor
    dead: Floats
    following: Floats
    factor: TimeFactor


@dataclass(frozen=True)
class MotionLoad:
    """A law that sees the motion of its places, rigidly connected with nodes, with one time factor.

    Places are at ``arms (k, 3)`` [m] and ``turns (k, 4)`` in the nodes' axes, and stand for ``lengths (k,)`` [m].
    """

    load: int
    nodes: Integers
    arms: Floats
    turns: Floats
    lengths: Floats
    law: MotionLaw
    factor: TimeFactor


@dataclass(frozen=True)
class Stations:
    """Element nodes rod by rod, in order of arc length: where results are reported."""

    rod: Integers
    s: Floats
    nodes: Integers
    links: Integers


@dataclass(frozen=True)
class Bodies:
    """Mass centres and named points of rigid bodies: names, nodes ``(k,)``, arms in node axes ``(k, 3)`` [m].

    ``turns (k, 4)`` are quaternions from the body's axes to the node's; those of the first of the bodies that share a
    node are no turn.
    """

    names: tuple[str, ...]
    nodes: Integers
    arms: Floats
    turns: Floats


@dataclass(frozen=True)
class Problem:
    """Everything an analysis needs, in arrays; nodes are numbered rod by rod.

    Attributes:
        positions, quaternions: reference poses of the nodes ``(n, 3)`` [m], ``(n, 4)``.
        mass: nodal inertia in body axes ``(n, 6, 6)`` [kg, kg m, kg m^2].
        link_positions, link_quaternions: constant poses of rigidly attached rod ends in the frame of the shared node.
        pattern: blocks of all matrices; their first rows are those of the nodes.
        bodies: names of the rigid bodies and of their points, and where these are.
        joints: coordinates of joints and springs; held: strains that multipliers hold.
        multipliers: block rows of multipliers, after those of the nodes; first those of joints.
        interiors: nodes within elements, element by element, that couple with nothing outside.
        initial_strain: strains ``(6,)`` at t = 0 by arc length [m], of the rods (by index) that have any.
        rest_strains: at which rods (by index) are free of stress; several of one rod add up.
        initial_twist: body twists at t = 0 for given poses, ``(r, q) -> (n, 6)``.
        length: size of the model [m], the measure of "small" for displacements.
        breakpoints, jumps: times [s] at which loads or motions are not smooth / an integrator must start anew.
        rows: further breakpoints [s], of records, for integrators that do not look into their steps.
        records: loads whose factors are tables of many rows, by their number; record_ends: until when they act [s].
        functions: factors of loads that are Python functions, by the number of the load.
        periods: of harmonic loads and motions [s].
        of_layout: what was found of nodes, couplings and supports alone, by name; problems of one layout share it.
        layout: that it was made on; None of a problem that was made of another one by changing a field.
    """

    rods: tuple[str, ...]
    rod_lengths: Floats
    rod_orders: Integers
    positions: Floats
    quaternions: Floats
    mass: Floats
    sets: tuple[ElementSet, ...]
    link_positions: Floats
    link_quaternions: Floats
    pattern: Pattern
    bodies: Bodies
    joints: JointSet
    held: HeldStrains
    multipliers: int
    interiors: tuple[Integers, ...]
    supports: SupportSet
    nodal_loads: tuple[NodalLoad, ...]
    station_loads: tuple[StationLoad, ...]
    motion_loads: tuple[MotionLoad, ...]
    stations: Stations
    initial_strain: Mapping[int, Callable[[float], Floats]]
    rest_strains: tuple[tuple[int, RestStrain], ...]
    initial_twist: Callable[[Floats, Floats], Floats]
    relaxation_times: Floats
    length: float
    breakpoints: tuple[float, ...]
    jumps: tuple[float, ...]
    rows: tuple[float, ...]
    records: Mapping[int, TimeTable]
    record_ends: Mapping[int, float]
    functions: Mapping[int, FunctionOfTime]
    periods: tuple[float, ...]
    of_layout: dict[str, Any] = field(init=False, default_factory=dict, compare=False, repr=False)
    layout: Any = field(init=False, default=None, compare=False, repr=False)

    @property
    def size(self) -> int:
        """Number of nodes."""
        return len(self.positions)

    @property
    def constrained(self) -> bool:
        """True if there are joints, springs or held strains."""
        return self.joints.count > 0 or len(self.held.place) > 0

    @property
    def relaxing(self) -> bool:
        """True if any section has Maxwell branches."""
        return len(self.relaxation_times) > 0

    @cached_property
    def laws(self) -> SectionLaws:
        """The laws of all sections, set by set."""
        return SectionLaws.joined([e.laws for e in self.sets])

    def element(self, number: int) -> tuple[ElementSet, int]:
        """Return the set with an element that is numbered among all, and its number there."""
        for elements in self.sets:
            if number < len(elements.nodes):
                return elements, number
            number -= len(elements.nodes)
        raise IndexError(number)

    @cached_property
    def plan(self) -> Plan:
        """The plan by which all matrices are factorised."""
        return self.plan_without(())

    def plan_without(self, nodes: Iterable[int]) -> Plan:
        """Return the plan of matrices in which these nodes do not move."""
        without = tuple(map(int, nodes))
        name = f"plan without {without}"
        found: Plan | None = self.of_layout.get(name)
        if found is None:
            found = self.of_layout[name] = plan_of(self.pattern, self.interiors, without)
        return found
