"""Steps downhill as in a thick fluid: implicit Euler for ``A x' = external - internal``, with a drag ``A``.

A step solves ``(mu A + K) dx = external - internal - mu A d``, where ``d`` is the way since its start and ``1/mu`` its
length in the time of the flow. ``A`` is like the inertia.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.mechanics.rotations.rotation import increment_size, retract
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.statics.second_variation import SecondVariation
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["LARGEST", "LOOSE", "DragFlow", "FlowStep", "drag"]

LARGEST = 0.5
"""Largest step: displacement over the length of the model, or rotation in rad."""
ITERATIONS = 12
LOOSE = 1e-5
"""Size of the last Newton increment of a step."""
INVERSE = 15
"""Inverse iterations for the fastest way off an unstable equilibrium."""


class FlowStep(NamedTuple):
    """The state at the end of a step, None if it failed; its size and the iterations that it took."""

    end: State | None
    size: float
    iterations: int


class DragFlow:
    """The flow of one static problem under loads and motions of one time.

    Args:
        static: solves it. t, before: time at which loads and motions are taken; factor: their multiple.

    Attributes:
        span: size of the model [m], by which displacements are measured; drag: of the nodes ``(n, 6, 6)``.
        turn: prescribed rotation in all [rad], see :meth:`motions_from`.
    """

    def __init__(self, static: StaticSolver, t: float, *, before: bool, factor: float) -> None:
        self.static, self.system, self.supports = static, static.system, static.supports
        self.problem = static.system.problem
        self.t, self.before, self.factor = t, before, factor
        self.span = max(self.problem.length, float(np.ptp(self.problem.positions, axis=0).max()))
        self.drag = drag(static)
        self._swapped = np.ascontiguousarray(np.swapaxes(self.drag, 1, 2))
        self.turn = 0.0

    def motions_from(self, motion: float) -> bool:
        """Return whether motions are prescribed or joints are open beyond a part of them; set how much they turn."""
        self.place(1.0)
        supports, joints = self.supports.target.copy(), self.system.constraints.driven.copy()
        self.place(motion)
        supports -= self.supports.target
        joints -= self.system.constraints.driven
        self.turn = max(
            float(np.abs(supports[:, 3:]).max(initial=0.0)), float(np.abs(joints).max(initial=0.0))
        )
        return bool(supports.any() or joints.any())

    def place(self, motion: float) -> None:
        """Impose a part of the prescribed motions and gaps."""
        self.supports.update(self.t, self.before, motion * self.factor)
        self.system.constraints.update(self.t, self.before, motion * self.factor)

    def loads(self) -> LoadState:
        """Return the loads."""
        return self.static.loads.at(self.t, self.before, self.factor)

    def begin(self, x: State) -> None:
        """Take the section forces at ``x`` as stress iterate."""
        self.system.assemble(x, self.loads(), None, tangent=False, moving=False)
        self.system.reset_stress()
        self.system.constraints.track_angles()

    def first_drag(self, x: State, motion: float) -> float:
        """Return the first ``mu``: the whole imbalance may move the model by a tenth of the largest step."""
        self.place(motion)
        self.begin(x)
        residual = self.supports.unbalanced(self.system.residual()[: self.problem.size])
        force = np.abs(residual[:, :3]).max(axis=1) + np.abs(residual[:, 3:]).max(axis=1) / self.span
        mass = np.einsum("nii->ni", self.drag)[:, :3].max(axis=1)
        pace = float((force / mass).max()) / (0.1 * LARGEST * self.span)
        self.system.assemble(x, self.loads(), None, tangent=True, moving=False)
        diagonal = self.problem.pattern.diagonal[: self.problem.size]
        stiff = float(np.abs(np.einsum("nii->ni", self.system.matrix.blocks[diagonal])[:, :3]).sum())
        return max(pace, 1e-9 * stiff / float(mass.sum())) or 1.0

    def step(self, start: State, mu: float, motions: tuple[float, float], accuracy: float) -> FlowStep:
        """Take a step.

        Args:
            start: where it begins; mu: of the step [1/s].
            motions: parts of the prescribed motions at its start and end.
            accuracy: size of the last Newton increment.
        """
        system, supports, n = self.system, self.supports, self.problem.size
        x, way = start.copy(), np.zeros((n, 6))
        self.place(motions[0])
        self.begin(x)
        self.place(motions[1])
        last = np.inf
        for count in range(1, ITERATIONS + 1):
            residual = self._assemble(x, mu)
            residual[:n] += mu * np.einsum("nij,nj->ni", self.drag, way)
            if not np.isfinite(residual).all():
                return FlowStep(None, 0.0, count)
            supports.impose(x, residual, system.matrix, tangent=True)
            try:
                system.matrix.factorise()
            except SingularMatrixError:
                return FlowStep(None, 0.0, count)
            increment = system.matrix.solve(-residual)
            size = increment_size(increment[:n], self.span)
            if not size < 4.0 * LARGEST or (count > 4 and size > last):
                return FlowStep(None, 0.0, count)
            retract(x.r, x.q, increment, x.r, x.q)
            system.carry_stress(increment)
            x.multiplier += system.multiplier_change(increment)
            way += increment[:n]
            last = size
            if size <= accuracy:
                break
        else:
            return FlowStep(None, 0.0, ITERATIONS)
        moved = increment_size(way, self.span)
        if moved > LARGEST or self.jumped(start, x):
            return FlowStep(None, moved, count)
        self.begin(x)
        return FlowStep(x, moved, count)

    def jumped(self, start: State, x: State) -> bool:
        """Return whether a prescribed rotation was closed the shorter way round between two nodes."""
        return self.turn > 0.0 and self.static.turns.jumped(start, x)

    def _assemble(self, x: State, mu: float) -> Floats:
        """Assemble with the drag in the matrix; return the unbalanced forces without it."""
        self.system.constraints.pace = float(np.sqrt(mu))
        self.system.assemble(x, self.loads(), None, tangent=True, moving=False)
        self.system.constraints.pace = 0.0
        self.system.matrix.blocks[self.problem.pattern.diagonal[: self.problem.size]] += mu * self._swapped
        return self.system.residual()

    def unstable(self, x: State, mu: float) -> int:
        """Return the number of negative eigenvalues of the tangent with the drag."""
        return negative_eigenvalues(self._tangent(x, mu))

    def _tangent(self, x: State, mu: float) -> Tangent:
        """Return the tangent with the drag in the motions that the supports allow."""
        balance = self._assemble(x, mu)
        stiffness, basis = self.supports.reduce_tangent(x, balance.copy(), self.system.matrix)
        gradients = None
        if self.system.constraints.rows:
            gradients = unit_rows(sparse.csr_array(self.system.constraint_gradients(x) @ basis))
        work = SecondVariation(self.system, self.supports, x, self.loads(), balance, basis).work
        dragged = sparse.csr_array(basis.T @ block_diagonal(self.drag) @ basis)
        return Tangent(stiffness, basis, gradients, work.plus(dragged, mu))

    def fastest(self, x: State, mu: float, axis: int) -> tuple[float, Floats]:
        """Return the lowest eigenvalue over drag and its motion ``(n, 6)``, by inverse iteration shifted by ``-mu``.

        It starts from displacements along global z, y or x (``axis`` 0 to 2), or from all motions (3).
        """
        n, rng = self.problem.size, np.random.default_rng(1)
        way = rng.standard_normal((n, 6))
        if axis < 3:
            way[:, :3] = matrices(x.q)[:, 2 - axis] * rng.uniform(0.5, 1.0, (n, 1))
            way[:, 3:] = 0.0
        rate = 0.0
        for _ in range(INVERSE):
            residual = self._assemble(x, mu)
            right = np.zeros_like(residual)
            right[:n] = np.einsum("nij,nj->ni", self.drag, way)
            before = float(np.sum(way * right[:n]))
            self.supports.impose(x, residual, self.system.matrix, tangent=True)
            right[self.supports.set.nodes] *= 1.0 - self.supports.set.fixed
            self.system.matrix.factorise()
            new = self.system.matrix.solve(right)[:n]
            gain = float(np.sum(way * np.einsum("nij,nj->ni", self.drag, new)))
            rate = before / gain - mu if gain else np.inf
            way = new / increment_size(new, self.span)
        return rate, way


def drag(static: StaticSolver) -> Floats:
    """Return the drag of every node ``(n, 6, 6)``: its inertia, against rotation at least that of a ball of its size.

    The rotational inertia of a slender rod is so small that its drag would let sections spin.
    """
    problem = static.system.problem
    out = problem.mass.copy()
    size = np.zeros(problem.size)
    for e in problem.sets:
        np.add.at(size, e.nodes, np.broadcast_to(e.half_lengths[:, None] * 2.0 / e.order, e.nodes.shape))
    mass = np.einsum("nii->ni", out)[:, :3].max(axis=1)
    light = mass < 1e-6 * mass.max(initial=1e-300)
    for k in np.flatnonzero(light):
        out[k, :3, :3] += np.eye(3) * (1e-3 * mass.mean() or 1.0)
    mass = np.einsum("nii->ni", out)[:, :3].max(axis=1)
    own = np.einsum("nii->ni", out)[:, 3:].min(axis=1)
    least = mass * np.where(size > 0.0, size, 0.01 * problem.length) ** 2 / 12.0
    for k in np.flatnonzero(own < least):
        out[k, 3:, 3:] += np.eye(3) * (least[k] - own[k])
    return out
