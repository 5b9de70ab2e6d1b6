"""The work of small motions against stiffness and damping, summed up from strains and not from entries of matrices.

An entry of the tangent is rounded by one part in 1e16 of the stiffness of an element against stretching. A fine mesh of
a slender rod resists slow motions by less than that: they neither stretch nor shear it, so that large entries cancel.
Strains are differences of neighbouring nodes, and their rounding counts squared: ``v.K v = int de.C de + v.G v`` with
the geometric stiffness ``G`` of section forces and loads has no such cancellation.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.section_laws import SectionLaws
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.once import once
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.work import Work, matrix_form
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.constraints.support_state import SupportState
    from viscorod.solve.formulations.system import State, System
    from viscorod.solve.problem.external_loads import LoadState

__all__ = ["SecondVariation", "without_elements"]


class SecondVariation:
    """The forms of the tangent at a state, in motions that are columns of a basis.

    They are made when they are first asked for, with supports and joints where they stand then.

    Args:
        system: just assembled, with the stress iterate of the tangent; supports: its supports.
        state, loads: of the assembly; balance: unbalanced forces ``(N, 6)``; basis: ``(6 n, free)``.
    """

    def __init__(
        self,
        system: System,
        supports: SupportState,
        state: State,
        loads: LoadState,
        balance: Floats,
        basis: sparse.csc_array,
    ) -> None:
        assert isinstance(system, GeometricSystem)  # whose statics all formulations have
        self._system, self._supports, self._loads, self._basis = system, supports, loads, basis
        self._state, self._balance = state.copy(), balance.copy()
        self._stress = system.stress.copy()
        self._sections = system.section_tangents()

    @property
    def work(self) -> Work:
        """That of the stiffness."""
        return Work(lambda motions: self._form(motions, self._sections[0], self._beside_elements[1]))

    @property
    def loss(self) -> Work:
        """That of the damping."""
        return Work(lambda motions: self._form(motions, self._sections[1], self._beside_elements[2]))

    @cached_property
    def _beside_elements(
        self,
    ) -> tuple[GeometricSystem, sparse.csr_array, sparse.csr_array, sparse.csr_array]:
        """What is left of stiffness and damping without elements ``(free, free)``, behind the system that has none.

        The operators of its elements are those of strains. The last matrix ``(6 n, 6 n)`` has the sizes of what the
        entries of the stiffness are summed up from: forces turn a section about each of its axes by the same products,
        which cancel about the axis along the force.
        """
        bare = without_elements(self._system)
        bare.stress[:] = self._stress
        state, dampers, basis = self._state, Matrix(bare.problem.pattern), self._basis
        bare.assemble(state, self._loads, None, tangent=True, moving=False, rate_matrix=dampers)
        sizes = Matrix(bare.problem.pattern)
        parts = np.abs(bare.matrix.blocks).reshape(-1, 2, 3, 2, 3)
        parts[:] = parts.max(axis=(2, 4), keepdims=True)
        sizes.blocks[:] = parts.reshape(-1, 6, 6)
        stiffness, _ = self._supports.reduce_tangent(state, self._balance.copy(), bare.matrix)
        size = basis.shape[0]
        damping = sparse.csr_array(basis.T @ dampers.sparse()[:size, :size] @ basis)
        bare.carry_strains(state)
        return bare, stiffness, damping, sparse.csr_array(sizes.sparse()[:size, :size])

    def _form(self, motions: Floats, sections: Floats, beside: sparse.csr_array) -> tuple[Floats, Floats]:
        """Return ``int de.C de`` of section matrices, and the form of the matrix ``beside`` it."""
        bare = self._beside_elements[0]
        work, size = matrix_form(beside, motions)
        moved = np.abs(np.asarray(self._basis @ motions))
        size = np.maximum(size, np.einsum("ik,ik->k", moved, self._beside_elements[3] @ moved))
        strains = []
        for column in np.ascontiguousarray(np.asarray(self._basis @ motions).T):
            bare.carry_stress(column.reshape(-1, 6))
            strains.append(bare.stress.copy())
        e = bare.elements()
        weight = (e.half_lengths[:, None] * e.weights[e.order])[:, :, None]
        for k, strain in enumerate(strains):
            force = weight * np.einsum("epij,epj->epi", sections, strain)
            row = np.array([float(np.sum(other * force)) for other in strains])
            work[k] += row
            size[k] += abs(row[k])
        return 0.5 * (work + work.T), size


def without_elements(system: System) -> GeometricSystem:
    """Return a system without stiffness and damping of its elements, whose joints stand as in another."""
    bare = GeometricSystem(_without_elements(system.problem))
    bare.constraints.stand_as(system.constraints)
    return bare


@once
def _without_elements(problem: Problem) -> Problem:
    """Return the same problem without stiffness and damping of its elements."""
    sets = tuple(
        replace(
            e,
            stiffness=np.zeros_like(e.stiffness),
            damping=np.zeros_like(e.damping),
            branches=np.zeros_like(e.branches),
            laws=SectionLaws.none(len(e.stiffness)),
        )
        for e in problem.sets
    )
    return replace(problem, sets=sets)
