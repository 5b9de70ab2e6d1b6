"""Maxwell branches of a collocation method, from step to step (see ``mechanics.elements.maxwell_branches``)."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays, add_section_stiffness, remember
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.transient.integrators.jacobian import project_blocks
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats


class StageDashpots:
    """The state of the branches in the steps of a run.

    Args:
        memory: of the system; body: the model; tableau: the method.

    Attributes:
        step: for the compiled step.
    """

    def __init__(self, memory: DashpotMemory, body: Discretisation, tableau: Tableau) -> None:
        self.memory, self.body, self.tableau = memory, body, tableau
        self.step = MaxwellArrays.of(body.elements, memory.times, memory.branches, len(tableau.nodes))
        self._length = 0.0
        self._start_spring: Floats

    def prepare(self, h: float) -> None:
        """Write what the compiled step needs for a step of ``h`` [s] from the last accepted instant."""
        step, memory, elements = self.step, self.memory, self.body.elements
        if h != self._length:
            A, unit = self.tableau.matrix, np.eye(len(self.tableau.nodes))
            step.factor[:] = np.linalg.inv(unit + (h / memory.times)[:, None, None] * A)
            step.coupling[:] = np.einsum("jik,mjab->mikab", step.factor, memory.branches)
            self._length = h
        step.start[:], step.start_strain[:] = memory.dashpot, memory.strain
        remember(elements.order, elements.section, step.branches, step.factor, step.start, step.past)

    def add_stiffness(self, matrices: Matrices, mu: complex) -> Floats:
        """Return the stiffness ``K`` of the Jacobian with the branches at ``s = mu``, supported rows projected."""
        body, memory = self.body, self.memory
        response = mu * memory.times / (1.0 + mu * memory.times)
        modulus = np.einsum("j,sjab->sab", response, memory.branches)
        blocks = np.zeros(matrices.K.shape, dtype=modulus.dtype)
        add_section_stiffness(body.elements, modulus, matrices.operators.strain, blocks)
        old = np.zeros(6, dtype=modulus.dtype)
        pattern = body.pattern
        project_blocks(body.supports, matrices.directions, pattern.starts, pattern.across, blocks, old)
        return np.asarray(matrices.K + blocks)

    def end_step(self, strain: Floats) -> None:
        """Take the end of the step, where the last stage has led; ``strain (s, e, points, 6)``."""
        step, memory = self.step, self.memory
        self._start_spring = memory.strain - memory.dashpot
        found = strain[-1] - step.spring[-1]
        if len(self.tableau.nodes) > 1:
            memory.dashpot[:], memory.strain[:] = found, strain[-1]
        else:  # extrapolated from the middle; strains at the end are known later
            memory.dashpot[:] = 2.0 * found - step.start

    @property
    def loss(self) -> Floats:
        """Energy that the branches dissipated in the last step ``(n,)`` [J]."""
        return np.asarray(self._length * self.tableau.weights @ self.step.power)

    def loss_until(self, parts: Floats) -> Floats:
        """Return the energy that the branches dissipated up to ``parts (k,)`` of the last step ``(k, n)`` [J]."""
        return np.asarray(self._length * self.tableau.partial_weights(parts) @ self.step.power)

    def springs_between(self, parts: Floats) -> Floats:
        """Return the strains of the springs ``(k, n, e, points, 6)`` at ``parts (k,)`` of the last step."""
        start = self._start_spring
        weights = self.tableau.polynomials(parts)
        return np.asarray(start + np.einsum("ks,snegc->knegc", weights, self.step.spring - start))
