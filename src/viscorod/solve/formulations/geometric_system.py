"""The geometric formulation (positions and rotations) as a :class:`~viscorod.solve.formulations.system.System`."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.internal_force import Elements, energies
from viscorod.mechanics.elements.section_laws import BY_RATE, BY_STRAIN, ENERGY
from viscorod.solve.constraints.constraint_rows import gradients_of_gaps
from viscorod.solve.formulations.dashpot_memory import at_points
from viscorod.solve.formulations.element_assembly import ElementAssembly
from viscorod.solve.formulations.element_forces import ElementForces, GeometricForces
from viscorod.solve.formulations.system import GaussPoints, GaussPositions, State
from viscorod.solve.problem.external_loads import NO_LOADS
from viscorod.solve.problem.law_responses import law_responses
from viscorod.typing import Floats, Integers

__all__ = ["GeometricSystem"]


class GeometricSystem(ElementAssembly):
    """The elements of a problem as a system: its balance with joints, its mass, what its Gauss points tell."""

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
        if not self.problem.multipliers:
            return increment[:0].ravel()
        change = increment[self.problem.size :].ravel() * self.constraints.scale
        change[self.constraints.idle] = 0.0
        return change

    def section_tangents(self) -> tuple[Floats, Floats]:
        """Return the derivatives ``(e, points, 6, 6)`` of section forces by strains and by rates, at rest."""
        elements = self._present()
        C, D = elements.stiffness[elements.section], elements.damping[elements.section]
        if elements.laws.present:
            values = law_responses(elements.laws, elements.section, self.strain, np.zeros_like(self.strain))
            C += values[..., BY_STRAIN:BY_RATE].reshape(C.shape)
            D += values[..., BY_RATE:ENERGY].reshape(D.shape)
        return C, D

    def reset_stress(self) -> None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        self.stress[:] = self.section_force

    def elastic_energy(self) -> float:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        elastic, dissipated = np.empty((2, 1))
        energies(self._elements, self.strain[None], self.strain_rate[None], elastic, dissipated)
        total = float(elastic[0])
        if self.relaxation is not None and self.relaxation.known:
            total += self.relaxation.energy(self.strain)
        return total + self.constraints.energy

    def advance_branches(self) -> Floats:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.relaxation is None:
            return np.zeros(0)
        self.relaxation.begin(self.strain)
        return self.relaxation.advance(self.strain)

    def branch_power(self) -> Floats | None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.relaxation is None or not self.relaxation.known:
            return None
        return self.relaxation.power(self.strain).ravel()[self.gauss_indices()]

    def branch_strain(self) -> Floats | None:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        if self.relaxation is None or not self.relaxation.known:
            return None
        return at_points(self.strain - self.relaxation.dashpot, self.gauss_indices())

    def viscous_loss(self, duration: float) -> float:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        total = 0.0
        if duration > 0.0 and self._elements.damped:
            total = geometric.viscous_loss(self._elements, self.strain, self._earlier, duration)
        self._earlier[:] = self.strain
        return total + self.constraints.loss(duration)

    def gauss_points(self) -> GaussPoints:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        places = self._places
        strain, rate, force = (
            x.reshape(-1, 6)[places] for x in (self.strain, self.strain_rate, self.section_force)
        )
        return GaussPoints(strain=strain, strain_rate=rate, section_force=force)

    def gauss_indices(self) -> Integers:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return self._places

    def gauss_positions(self) -> GaussPositions:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return self._positions

    def element_forces(self, elements: Elements, stages: int) -> ElementForces:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        del stages
        return GeometricForces(self, elements)
