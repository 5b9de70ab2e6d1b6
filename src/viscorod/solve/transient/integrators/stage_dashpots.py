"""Maxwell branches of a collocation method, from step to step (see ``mechanics.elements.maxwell_branches``)."""

from __future__ import annotations

from typing import Any

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.branch_memory import (
    BranchMemory,
    BranchRows,
    begin_branches,
    keep_branches,
    read_branches,
    read_within,
)
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays
from viscorod.solve.formulations.dashpot_memory import DashpotMemory
from viscorod.solve.transient.integrators.branch_systems import Stiffened, stiffen
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers

__all__ = ["StageDashpots"]


class StageDashpots:
    """The state of the branches in the steps of a run.

    Args:
        memory: of the system; body: the model; tableau: the method; places: of the points of results, see ``Reading``.

    Attributes:
        step: for the compiled step; own: what branches remember, whose strains are those of the system.
        real, pair: the stiffness with branches at real and at complex eigenvalues.
        begin, keep, read, within, stiffen_real, stiffen_pair: kernels, see ``branch_memory`` and ``branch_systems``.
    """

    unsaved = frozenset({"own", "pair", "real", "step"})

    def __init__(
        self, memory: DashpotMemory, body: Discretisation, tableau: Tableau, places: Integers
    ) -> None:
        self.memory, self.body, self.tableau, self.places = memory, body, tableau, places
        stages, blocks, sections = len(tableau.nodes), len(body.pattern.rows), len(memory.branches)
        self.step = MaxwellArrays.of(body.elements, memory.times, memory.branches, stages)
        self.own = BranchMemory.of(memory.dashpot, memory.strain, stages)
        self.real = Stiffened.of(blocks, sections, float)
        self.pair = Stiffened.of(blocks, sections, complex)
        self.begin, self.keep = KnownTypes(begin_branches), KnownTypes(keep_branches)
        self.read, self.within = KnownTypes(read_branches), KnownTypes(read_within)
        self.stiffen_real, self.stiffen_pair = KnownTypes(stiffen), KnownTypes(stiffen)

    def prepare(self, h: float) -> None:
        """Write what the compiled step needs for a step of ``h`` [s] from the last accepted instant."""
        self.begin.call(*self.begin_arguments(h))

    def begin_arguments(self, h: float) -> tuple[Any, ...]:
        """Return what :attr:`begin` takes."""
        elements = self.body.elements
        return h, self.tableau.matrix, elements.order, elements.section, self.step, self.own

    def add_stiffness(self, matrices: Matrices, mu: complex) -> np.ndarray:
        """Return the stiffness ``K`` of the Jacobian with the branches at ``s = mu``, until it is asked for again."""
        is_real = not isinstance(mu, complex)
        call, out = (self.stiffen_real, self.real) if is_real else (self.stiffen_pair, self.pair)
        call.call(mu, *self.stiffen_arguments(matrices), out)
        return out.blocks

    def stiffen_arguments(self, matrices: Matrices) -> tuple[Any, ...]:
        """Return what :func:`.stiffen` takes between the eigenvalue and its output."""
        body = self.body
        where = body.elements, self.step, body.supports, matrices.directions, body.pattern
        return matrices.K, matrices.operators.strain, *where

    def end_step(self, strain: Floats) -> None:
        """Take the end of the step, where the last stage has led; ``strain (s, e, points, 6)``."""
        self.keep.call(self.tableau.weights, strain, self.step, self.own)

    @property
    def loss(self) -> Floats:
        """Energy that the branches dissipated in the last step ``(n,)`` [J]."""
        return self.own.loss.copy()

    def present(self) -> BranchRows:
        """Return the branches at the last accepted instant, as one row."""
        rows = self._rows(1)
        self.read.call(0, *self.reading, rows)
        return rows

    def between(self, parts: Floats) -> BranchRows:
        """Return the branches at ``parts (k,)`` of the last step."""
        rows = self._rows(len(parts))
        self.within.call(parts, 0, self.tableau.values, self.tableau.integrals, *self.reading, rows)
        return rows

    @property
    def reading(self) -> tuple[Any, ...]:
        """What is read, and where."""
        return self.step, self.own, self.body.elements.section, self.places

    def _rows(self, count: int) -> BranchRows:
        return BranchRows.of(count, len(self.places), len(self.step.times))
