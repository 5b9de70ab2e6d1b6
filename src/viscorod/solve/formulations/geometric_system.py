"""The geometric formulation (positions and rotations) as a :class:`~viscorod.solve.formulations.system.System`."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.gauss_batch import EqualElements, PointArrays
from viscorod.mechanics.elements.held_strains import HeldStrains
from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.lanes import LANES
from viscorod.mechanics.elements.linearised import Operators, collect
from viscorod.mechanics.nodes.motion_loads import MotionTangent
from viscorod.solve.constraints.constraint_rows import gradients_of_gaps
from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.formulations.element_forces import ElementForces, GeometricForces
from viscorod.solve.formulations.system import GaussPoints, GaussPositions, State
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.problem.element_arrays import (
    all_branches,
    all_elements,
    gauss_indices,
    gauss_positions,
    rest_strains,
)
from viscorod.solve.problem.external_loads import NO_LOADS, LoadState
from viscorod.solve.problem.problem import ElementSet, Problem
from viscorod.typing import Floats, Integers


class _Part:
    """One element set with its work arrays at the Gauss points."""

    def __init__(self, problem: Problem, elements: ElementSet) -> None:
        self.elements = elements
        self.problem = problem
        shape = (*elements.section.shape, 6)
        self.strain = np.zeros(shape)
        self.earlier = np.zeros(shape)
        self.strain_rate = np.zeros(shape)
        self.section_force = np.zeros(shape)
        self.stress = np.zeros(shape)
        batches = -(-elements.section.size // LANES)
        self.operator = np.zeros((batches, elements.nodes.shape[1], 6, 6, LANES))
        self.reference = np.zeros(shape)
        self.stiffness = elements.stiffness
        self.prestress = np.zeros((0, 1, 6))
        self.damped = elements.damped
        self.coupled = elements.coupled
        self.constrained = bool(elements.held.any())
        frames = np.zeros((*elements.section.shape, 4))
        geometric.strains(self.arrays, problem.positions, problem.quaternions, self.reference, frames)
        self.unstressed = self.reference.copy()
        self.rest = rest_strains(problem, elements)
        self.points = elements.section.shape[1]
        self.held_at = tuple(np.zeros(0, dtype=np.int64) for _ in range(3))  # elements, points, components
        self.place, self.weight = np.zeros(0, dtype=np.int64), np.zeros(0)

    @property
    def arrays(self) -> EqualElements:
        """The elements as kernels take them, with the present sections."""
        e, problem = self.elements, self.problem
        return EqualElements(
            e.nodes,
            e.links,
            e.slots,
            problem.link_positions,
            problem.link_quaternions,
            e.shapes,
            e.slopes,
            e.weights,
            e.half_lengths,
            e.section,
            self.stiffness,
            e.damping,
            e.held,
            self.coupled,
            self.damped,
            self.constrained,
            self.reference,
            self.prestress,
            e.laws,
        )

    def fields(self, stress: Floats, strain_operator: Floats) -> PointArrays:
        """Return what an assembly with a stress iterate reads and writes at the Gauss points."""
        return PointArrays(
            stress, self.strain, self.strain_rate, self.section_force, self.operator, strain_operator
        )

    def impose_rest(self, part: float) -> None:
        """Measure strains from the reference shape with a part of the rest strains."""
        if self.rest is not None:
            self.reference[:] = self.unstressed + part * self.rest

    @property
    def whole_reference(self) -> Floats:
        """Strains of the reference shape with the whole rest strains ``(elements, points, 6)``."""
        return self.unstressed if self.rest is None else self.unstressed + self.rest

    def set_held_strains(self, held: HeldStrains, first: int) -> None:
        """Set the held strains of this set, whose elements count from ``first`` on."""
        mine = (held.element >= first) & (held.element < first + len(self.elements.nodes))
        self.held_at = held.element[mine] - first, held.point[mine], held.component[mine]
        self.place, self.weight = held.place[mine], held.weight[mine]


class GeometricSystem:
    """Assembles the geometric element of model.md section 4 for a whole problem.

    Strains are measured from those of the interpolated reference shape, so a curved rod is free of stress as built, and
    from the rest strains of the problem.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.internal: Floats = np.zeros((problem.size, 6))
        self.external: Floats = np.zeros((problem.size, 6))
        self.dissipated = 0.0
        self.matrix = Matrix(problem.pattern, problem.length, lambda: problem.plan)
        self.parts = [_Part(problem, elements) for elements in problem.sets]
        self.given_strain: Floats | None = None
        self._no_map = np.zeros((problem.size, 6, 6))
        self._no_blocks = np.zeros((0, 6, 6))
        self._no_operator = np.zeros((0, 1, 6, 6, LANES))
        self._operators: Operators | None = None
        self.constraints = Constraints(problem, self.elements)
        first = 0
        for part in self.parts:
            part.set_held_strains(problem.held, first)
            first += len(part.elements.nodes)
        self._order, self._positions = gauss_positions(problem.sets)
        self.relaxation: DashpotMemory | None = None
        if problem.relaxing:
            self.relaxation = DashpotMemory(self.elements(), problem.relaxation_times, all_branches(problem))

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
        self._update_sections()
        first = 0
        for part in self.parts:
            part.impose_rest(loads.rest)
            part.stress[part.held_at] = state.multiplier[part.place] / part.weight
            strain_operator = (
                np.empty_like(part.operator) if tangent and part.constrained else self._no_operator
            )
            self._add_elements(
                part, part.stress, state, moving, rates, tangent, blocks, rate_blocks, strain_operator
            )
            if tangent and part.constrained:
                self._collect(part, first, strain_operator, self._shared_operators())
            first += len(part.elements.nodes)
        if problem.constrained:
            self._add_constraints(state, rates, blocks, rate_blocks, tangent=tangent, moving=moving)
        maps = rates if moving and rate_map is not None else self._no_blocks
        into = MotionTangent(maps, blocks, rate_blocks, problem.pattern.diagonal) if tangent else None
        twist = state.twist if moving else None
        self.dissipated = loads.add(problem, (state.r, state.q), twist, self.external, into)

    def _update_sections(self) -> None:
        """Set the stiffness and the prestress of the sections with Maxwell branches."""
        if self.relaxation is None:
            return
        first = sections = 0
        for part in self.parts:
            count = len(part.elements.nodes)
            own = slice(sections, sections + len(part.elements.stiffness))
            part.stiffness = part.elements.stiffness + self.relaxation.stiffness[own]
            part.prestress = self.relaxation.prestress[first : first + count, : part.points].copy()
            first, sections = first + count, own.stop

    def _strains(self) -> Floats:
        """Return the strains of the last assembly in the arrays of :meth:`elements`."""
        strain = np.zeros(self._all.reference.shape)
        first = 0
        for part in self.parts:
            strain[first : first + len(part.strain), : part.points] = part.strain
            first += len(part.strain)
        return strain

    def _shared_operators(self) -> Operators:
        if self._operators is None:
            self._operators = Operators.of(self._all)
        return self._operators

    def _add_constraints(
        self, state: State, rate_map: Floats, K: Floats, C: Floats, *, tangent: bool, moving: bool
    ) -> None:
        """Add joints, springs and held strains, whose elements are assembled."""
        constraints = self.constraints
        for part in self.parts:
            constraints.gap[part.place] = part.strain[part.held_at]
        at = state if moving else State(state.r, state.q, np.zeros_like(state.twist), state.multiplier)
        constraints.add_forces(at, self.internal)
        if tangent:
            separate = len(C) > 0  # dampers at rest have a derivative by twists all the same
            maps = rate_map if moving else self._no_map
            constraints.add_tangent(at, maps, K, C, moving=moving or separate, held=self._held_rows())

    def _held_rows(self) -> tuple[Integers, Floats] | None:
        if not any(part.constrained for part in self.parts):
            return None
        return self._all.order, self._shared_operators().strain

    def assemble_mass(self, state: State) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        problem, constraints, matrix = self.problem, self.constraints, self.matrix
        held = None
        if len(problem.held.place):
            self.assemble(state, NO_LOADS, None, tangent=True, moving=False)
            held = self._held_rows()
        matrix.clear()
        matrix.blocks[problem.pattern.diagonal[: problem.size]] = np.swapaxes(problem.mass, 1, 2)
        constraints.add_rows(state, matrix.blocks, held)

    def residual(self) -> Floats:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        unbalanced: Floats = self.internal - self.external
        if not self.problem.constrained:
            return unbalanced
        gaps = self.constraints.scale * self.constraints.gap
        return np.concatenate([unbalanced, gaps.reshape(-1, 6)])

    def constraint_gradients(self, state: State) -> sparse.csr_array:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if len(self.problem.held.place):
            self.assemble(state, NO_LOADS, None, tangent=True, moving=False)
        return gradients_of_gaps(self.constraints, state, self._held_rows())

    def multiplier_change(self, increment: Floats) -> Floats:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        change = increment[self.problem.size :].ravel() * self.constraints.scale
        change[self.constraints.idle] = 0.0
        return change

    def _add_elements(
        self,
        part: _Part,
        stress: Floats,
        state: State,
        moving: bool,
        rate_map: Floats,
        tangent: bool,
        blocks: Floats,
        rate_blocks: Floats,
        strain_operator: Floats,
    ) -> None:
        """Add the forces of one element set to ``internal`` and its tangent to the blocks."""
        geometric.assemble(
            part.arrays,
            part.fields(stress, strain_operator),
            state.r,
            state.q,
            state.twist,
            moving,
            rate_map,
            tangent,
            geometric.Assembled(self.internal, blocks, rate_blocks),
        )

    def linearise(
        self, state: State, ad: Floats, stress: Floats, operators: Operators, K: Floats, C: Floats
    ) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        self.internal.fill(0.0)
        first = 0
        for part in self.parts:
            e = part.elements
            count, points = e.section.shape
            strain_operator = np.empty_like(part.operator)
            self._add_elements(
                part,
                stress[first : first + count, :points].copy(),
                state,
                True,
                ad,
                True,
                K,
                C,
                strain_operator,
            )
            self._collect(part, first, strain_operator, operators)
            first += count

    def _collect(self, part: _Part, first: int, strain_operator: Floats, operators: Operators) -> None:
        """Write the operators of one element set, whose elements count from ``first`` on."""
        collect(part.arrays, part.fields(part.stress, strain_operator), first, operators)

    def carry_stress(self, increment: Floats) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        for part in self.parts:
            fields = part.fields(part.stress, self._no_operator)
            geometric.update_stress(part.arrays, fields, increment, part.stress)

    def reset_stress(self) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        for part in self.parts:
            part.stress[:] = part.section_force

    def elastic_energy(self) -> float:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        total = 0.0
        for part in self.parts:
            e = part.elements
            total += geometric.elastic_energy(
                e.weights, e.half_lengths, e.section, e.stiffness, e.laws, part.strain
            )
        if self.relaxation is not None and self.relaxation.known:
            total += self.relaxation.energy(self._strains())
        return total + self.constraints.energy

    def advance_branches(self) -> Floats:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.relaxation is None:
            return np.zeros(0)
        strain = self._strains()
        self.relaxation.begin(strain)
        return self.relaxation.advance(strain)

    def branch_power(self) -> Floats | None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.relaxation is None or not self.relaxation.known:
            return None
        return self.relaxation.power(self._strains()).ravel()[self.gauss_indices()]

    def viscous_loss(self, duration: float) -> float:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        total = 0.0
        for part in self.parts:
            e = part.elements
            if duration > 0.0 and part.damped:
                total += geometric.viscous_loss(
                    e.weights,
                    e.half_lengths,
                    e.section,
                    e.damping,
                    e.laws,
                    part.strain,
                    part.earlier,
                    duration,
                )
            part.earlier[:] = part.strain
        return total + self.constraints.loss(duration)

    def gauss_points(self) -> GaussPoints:
        """See :class:`~viscorod.solve.formulations.system.System`."""

        def gather(arrays: list[Floats]) -> Floats:
            return np.concatenate([array.reshape(-1, 6) for array in arrays])[self._order]

        return GaussPoints(
            strain=gather([part.strain for part in self.parts]),
            strain_rate=gather([part.strain_rate for part in self.parts]),
            section_force=gather([part.section_force for part in self.parts]),
        )

    def gauss_indices(self) -> Integers:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return gauss_indices(self.problem.sets)[self._order]

    def gauss_positions(self) -> GaussPositions:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return self._positions

    @cached_property
    def _all(self) -> Elements:
        return all_elements(self.problem, [part.whole_reference for part in self.parts])

    def elements(self) -> Elements:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return self._all

    def element_forces(self, elements: Elements, stages: int) -> ElementForces:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        del stages
        return GeometricForces(self, elements)

    def element_number(self, part: int, element: int) -> int:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return sum(len(e.nodes) for e in self.problem.sets[:part]) + element

    def describe_node(self, node: int) -> str:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        problem = self.problem
        if node >= problem.size:
            return self._constraint(node - problem.size)
        stations, bodies = problem.stations, problem.bodies
        if node in bodies.nodes:
            return f"body '{bodies.names[int(np.argmax(bodies.nodes == node))]}'"
        at = int(np.argmax(stations.nodes == node))
        rod, s = int(stations.rod[at]), float(stations.s[at])
        starts = np.sort(np.concatenate([p.elements.start[p.elements.rod == rod] for p in self.parts]))
        element = int(np.searchsorted(starts, s, side="right"))
        return f"rod '{problem.rods[rod]}', element {element}, s = {s:.6g} m"

    def _constraint(self, row: int) -> str:
        """Describe a block row of multipliers."""
        problem = self.problem
        joint = np.flatnonzero(problem.joints.row == row)
        if len(joint):
            return f"joint '{problem.joints.names[joint[0]]}'"
        element = int(problem.held.element[np.argmax(problem.held.place // 6 == row)])
        rods = np.concatenate([e.rod for e in problem.sets])
        starts = np.concatenate([e.start for e in problem.sets])
        rod = rods[element]
        number = 1 + np.count_nonzero(starts[rods == rod] < starts[element])
        return f"held strains of rod '{problem.rods[rod]}', element {number}"
