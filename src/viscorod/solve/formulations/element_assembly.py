"""All elements of a problem, and what analyses and compiled code assemble their forces and their tangent with."""

from __future__ import annotations

import copy
import itertools
from collections.abc import Callable
from typing import Self

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.gauss_batch import PointFields
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import LANES
from viscorod.mechanics.elements.linearised import Operators, collect
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.problem.element_arrays import all_branches, element_arrays
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.imposed_strains import Imposed, ImposedStrains
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

SCRATCH = frozenset(
    (
        "_all_columns",
        "_columns",
        "_no_blocks",
        "_no_columns",
        "_no_map",
        "_places",
        "_strain_columns",
        "_unstressed",
        "batches",
        "external",
        "internal",
    )
)
"""What is computed anew or never changes: motions that go on need none of it."""


class ElementAssembly:
    """Assembles the geometric element of model.md section 4 for a whole problem.

    Strains are measured from those of the interpolated reference shape, so a curved rod is free of stress as built, and
    from the rest strains of the problem. :class:`~viscorod.solve.formulations.geometric_system.GeometricSystem` says
    what comes of it.

    Attributes:
        batches: the numbers of each :class:`~viscorod.mechanics.elements.gauss_batch.ElementGroup`, and its first batch
            of Gauss points and that of the next one ``(groups, 8)``.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.internal: Floats = np.zeros((problem.size, 6))
        self.external: Floats = np.zeros((problem.size, 6))
        self.dissipated = 0.0
        self.matrix = Matrix(problem.pattern, problem.length, lambda: problem.plan)
        self.given_strain: Floats | None = None
        self.groups, elements, self._positions, self._places = element_arrays(problem)
        self._unstressed, self.imposed = elements.reference, ImposedStrains(problem)
        whole = self._unstressed + self.imposed.constant
        self._elements = present = elements._replace(reference=whole)
        self._reference = whole.copy() if problem.rest_strains else whole
        self.rest: tuple[Floats, Floats] = (np.zeros((1, *whole.shape)), np.zeros((1, *whole.shape)))
        self.prestress: Floats = np.zeros((0, 1, 6))
        self._beside: Floats = np.zeros_like(whole)
        self.stress, self.strain, self.strain_rate, self.section_force, self._earlier = (
            np.zeros_like(whole) for _ in range(5)
        )
        batches = np.cumsum([0, *(-(-group.size * group.order // LANES) for group in self.groups)])
        most = max((group.order for group in self.groups), default=0) + 1
        self._all_columns: Floats = np.zeros((int(batches[-1]), most, 6, 6, LANES))
        self._columns = [self._all_columns[a:b] for a, b in itertools.pairwise(batches)]
        self.batches: Integers = np.array(
            [(*group, batches[k], batches[k + 1]) for k, group in enumerate(self.groups)], dtype=np.int64
        ).reshape(-1, 8)
        self._stiffness = self._elements.stiffness.copy()
        self._no_map = np.zeros((problem.size, 6, 6))
        self._no_blocks = np.zeros((0, 6, 6))
        self._no_columns = np.zeros((0, 1, 6, 6, LANES))
        self._strain_columns = self._no_columns
        self._operators: Operators | None = None
        self._assemble, self._collect = KnownTypes(geometric.assemble), KnownTypes(collect)
        self._update_stress = KnownTypes(geometric.update_stress)
        self.constraints = Constraints(problem, lambda: present)
        self.relaxation = self._relaxed()

    def _relaxed(self) -> DashpotMemory | None:
        """Return the memory of Maxwell branches before a motion; None where there are none."""
        problem = self.problem
        if not problem.relaxing:
            return None
        return DashpotMemory(self.elements(), problem.relaxation_times, all_branches(problem))

    def beside(self, problem: Problem) -> Self:
        """Return the system of a problem that has other sections, masses or loads on the same nodes.

        It works with the arrays that this one works with, but for the matrix and for joints: while one of them is
        looked at, the other must not be assembled.
        """
        found = copy.copy(self)
        found.problem = problem
        found.matrix = Matrix(problem.pattern, problem.length, lambda: problem.plan)
        if problem.constrained:  # a tangent scales what multipliers are measured in
            found.constraints = Constraints(problem, lambda: found._elements)
        if problem.sets is self.problem.sets:
            return found
        found.groups, elements, found._positions, found._places = element_arrays(problem)
        found._elements = elements._replace(reference=self._elements.reference)
        found._stiffness = elements.stiffness.copy()
        ends = self.batches[:, 6:].tolist()
        found.batches = np.array(
            [(*group, *last) for group, last in zip(found.groups, ends, strict=True)], dtype=np.int64
        ).reshape(-1, 8)
        found._operators = None
        found.relaxation = found._relaxed()
        return found

    @property
    def unsaved(self) -> frozenset[str]:
        """What ``saved_state`` leaves out."""
        return SCRATCH if self.problem.constrained else SCRATCH | {"constraints"}

    def elements(self) -> Elements:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return self._elements

    def assemble(
        self,
        state: State,
        loads: LoadState,
        rate_map: Floats | None,
        *,
        tangent: bool,
        moving: bool,
        rate_matrix: Matrix | None = None,
    ) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        problem = self.problem
        blocks = self.matrix.blocks
        self.internal.fill(0.0)
        self.external.fill(0.0)
        if tangent:
            self.matrix.clear()
        if rate_matrix is not None:
            rate_matrix.clear()
        rates = self._no_map if rate_map is None else rate_map
        rate_blocks = self._no_blocks if rate_matrix is None else rate_matrix.blocks
        elements = self._prepare(loads, moving=moving)
        held = problem.held
        self.hold_stress(state)
        self._add_elements(
            elements,
            self.stress,
            state,
            (moving, rates, tangent),
            geometric.Assembled(self.internal, blocks, rate_blocks),
            self._shared_operators() if tangent and len(held.place) else None,
        )
        self._add_rest(state, loads, rate_map, rate_blocks, tangent=tangent, moving=moving)

    def _prepare(self, loads: LoadState, *, moving: bool) -> Elements:
        """Return all elements with the stiffness, the prestress and the rest strains of an assembly under ``loads``."""
        self._update_sections()
        if loads.rest is not None:
            self.impose_rest(loads.rest)
        self._take_rates(moving)
        return self._present()

    def hold_stress(self, state: State) -> None:
        """Take the stresses of held strains from their multipliers."""
        held = self.problem.held
        if len(held.place):
            self.stress[held.element, held.point, held.component] = state.multiplier[held.place] / held.weight

    def _add_rest(
        self,
        state: State,
        loads: LoadState,
        rate_map: Floats | None,
        rate_blocks: Floats,
        *,
        tangent: bool,
        moving: bool,
    ) -> None:
        """Add joints, springs, held strains and loads to what the elements amount to."""
        problem, blocks = self.problem, self.matrix.blocks
        if moving and self.imposed.changes:
            self.strain_rate -= self.rest[1][0]
        if problem.constrained:
            rates = self._no_map if rate_map is None else rate_map
            self._add_constraints(state, rates, blocks, rate_blocks, tangent=tangent, moving=moving)
        maps = rate_map if moving and rate_map is not None else self._no_blocks
        into = MotionTangent(maps, blocks, rate_blocks, problem.pattern.diagonal) if tangent else None
        twist = state.twist if moving else None
        self.dissipated = loads.add(problem, (state.r, state.q), twist, self.external, into)

    # --- the same for compiled code, which adds the elements itself

    def lend(self, loads: LoadState) -> tuple[Elements, PointFields]:
        """Return elements and Gauss points for assemblies of what moves under ``loads``, in all batches."""
        held = len(self.problem.held.place) > 0
        strain_columns = self._no_columns
        if held and not len(self._strain_columns):
            self._strain_columns = np.zeros_like(self._all_columns)
        if held:
            strain_columns = self._strain_columns
        elements = self._prepare(loads, moving=True)
        beside = self._beside if self.imposed.changes else self.prestress
        fields = self.strain, self.strain_rate, self.section_force
        return elements, PointFields(self.stress, beside, *fields, self._all_columns, strain_columns)

    def lend_tangent(
        self, stress: Floats, K: Floats, C: Floats
    ) -> tuple[Elements, Integers, PointFields, geometric.Assembled]:
        """Return what :meth:`linearise` assembles the elements with: all, their ``batches``, their Gauss points."""
        beside = self._beside if self.imposed.changes else self.prestress
        columns = self._all_columns, np.zeros_like(self._all_columns)
        fields = PointFields(stress, beside, self.strain, self.strain_rate, self.section_force, *columns)
        return self._moving(), self.batches, fields, geometric.Assembled(self.internal, K, C)

    @property
    def tangent_kernels(self) -> tuple[KnownTypes, KnownTypes]:
        """What assembles a group of elements, and what writes its operators."""
        return self._assemble, self._collect

    @property
    def has_more(self) -> bool:
        """Whether there is more than elements and loads on nodes."""
        problem = self.problem
        more = problem.constrained or problem.station_loads or problem.motion_loads
        return bool(more or self.imposed.changes)

    def add_rest(self, state: State, loads: LoadState, rate_map: Floats) -> None:
        """Add all but the elements, which compiled code has assembled with their tangent."""
        if len(self._strain_columns):
            for number, group in enumerate(self.groups):
                first, last = self.batches[number, 6:]
                fields = self._point_fields(number, self.stress, self._strain_columns[first:last])
                collect(self._elements, group, fields, self._shared_operators())
        self._add_rest(state, loads, rate_map, self._no_blocks, tangent=True, moving=True)

    def impose_rest(self, rest: Imposed) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.problem.rest_strains:
            self._reference[:] = self._unstressed + self.imposed.whole(rest)
        if self.imposed.changes:
            self.rest = (
                rest.part * self.imposed.driven(rest.t, rest.before)[None],
                rest.part * self.imposed.rate(rest.t, rest.before)[None],
            )

    def _take_rates(self, moving: bool) -> None:
        """Let dashpots see the rates of strains less those of the rest strains, which change with time."""
        if not self.imposed.changes:
            return
        beside = self.prestress if len(self.prestress) else np.zeros_like(self.strain)
        damping = self._elements.damping[self._elements.section]
        self._beside = beside - np.einsum("egij,egj->egi", damping, self.rest[1][0]) if moving else beside

    def _update_sections(self) -> None:
        """Set the stiffness and the prestress of the sections with Maxwell branches."""
        if self.relaxation is not None:
            self._stiffness = self._elements.stiffness + self.relaxation.stiffness
            self.prestress = self.relaxation.prestress

    def _present(self) -> Elements:
        """Return all elements with the present stiffness and the rest strains imposed so far."""
        if self.relaxation is None and not self.problem.rest_strains:
            return self._elements
        return self._elements._replace(stiffness=self._stiffness, reference=self._reference)

    def _moving(self) -> Elements:
        """Return all elements of a motion, which has the whole rest strains."""
        elements = self._elements
        if self.relaxation is not None:
            elements = elements._replace(stiffness=self._stiffness)
        if self.imposed.changes:
            elements = elements._replace(reference=self._reference)
        return elements

    def _point_fields(self, group: int, stress: Floats, strain_columns: Floats) -> PointFields:
        """Return what an assembly of a group with a stress iterate reads and writes at the Gauss points."""
        return PointFields(
            stress,
            self._beside if self.imposed.changes else self.prestress,
            self.strain,
            self.strain_rate,
            self.section_force,
            self._columns[group],
            strain_columns,
        )

    def _shared_operators(self) -> Operators:
        if self._operators is None:
            self._operators = Operators.of(self._elements)
        return self._operators

    def _add_constraints(
        self, state: State, rate_map: Floats, K: Floats, C: Floats, *, tangent: bool, moving: bool
    ) -> None:
        """Add joints, springs and held strains, whose elements are assembled."""
        constraints = self.constraints
        held = self.problem.held
        constraints.gap[held.place] = self.strain[held.element, held.point, held.component]
        at = state if moving else State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)
        constraints.add_forces(at, self.internal)
        if tangent:
            separate = len(C) > 0  # dampers at rest have a derivative by twists all the same
            maps = rate_map if moving else self._no_map
            constraints.add_tangent(at, maps, K, C, moving=moving or separate, held=self._held_rows())

    def _held_rows(self) -> tuple[Integers, Floats] | None:
        if not len(self.problem.held.place):
            return None
        return self._elements.order, self._shared_operators().strain

    def _add_elements(
        self,
        elements: Elements,
        stress: Floats,
        state: State,
        kind: tuple[bool, Floats, bool],
        out: geometric.Assembled,
        operators: Operators | None,
        kernels: tuple[Callable[..., object], Callable[..., object]] | None = None,
    ) -> None:
        """Add the forces of all elements and their tangent to ``out``; write the operators if they are wanted.

        ``kind``: the state is moving, its rate maps, the tangent is wanted; ``kernels``: call these two.
        """
        known = self._assemble.suited(state.r, state.q, state.twist, kind[1], out.blocks, out.rate_blocks)
        assemble, collected = kernels if kernels is not None else (known, collect)
        for number, group in enumerate(self.groups):
            columns = self._columns[number]
            strain_columns = self._no_columns if operators is None else np.empty_like(columns)
            fields = self._point_fields(number, stress, strain_columns)
            assemble(elements, group, fields, state.r, state.q, state.twist, *kind, out)
            if operators is not None:
                collected(elements, group, fields, operators)

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        self.internal.fill(0.0)
        out = geometric.Assembled(self.internal, K, C)
        kernels = self._assemble.call, self._collect.call
        self._add_elements(self._moving(), stress, state, (True, ad, True), out, operators, kernels)

    def carry_stress(self, increment: Floats) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        for number, group in enumerate(self.groups):
            fields = self._point_fields(number, self.stress, self._no_columns)
            update = self._update_stress.suited(increment)
            update(self._elements, group, fields, increment, self.stress)

    def carry_strains(self, state: State) -> None:
        """Let :meth:`carry_stress` give the strains of increments about ``state``, until the next assembly."""
        unit = np.broadcast_to(np.eye(6), self._stiffness.shape).copy()
        elements = self._elements._replace(stiffness=unit)
        out = geometric.Assembled(self.internal, self.matrix.blocks, self._no_blocks)
        for number, group in enumerate(self.groups):
            plain = group._replace(coupled=False, damped=False)
            fields = self._point_fields(number, self.stress, self._no_columns)
            geometric.assemble(
                elements, plain, fields, state.r, state.q, state.twist, False, self._no_map, True, out
            )
        self.section_force.fill(0.0)
