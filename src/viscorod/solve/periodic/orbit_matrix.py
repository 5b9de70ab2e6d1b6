"""The linear system of a whole orbit: its Jacobian over motions and phases, factorised with a border.

With the changes ``V p`` of the twists by body increments ``p`` at all phases (``p' + ad(x) p`` of the continuous
motion), and the derivative ``w D`` over the phases,

    J = K + (C + M w D) V  [+ B^T C_b w tau D (1 + w tau D)^-1 B of Maxwell branches].

Motions that do not couple, such as those across the plane in which a rod swings, make systems of their own
(:func:`coupled_motions`): only those that are driven are solved.
"""

from __future__ import annotations

import numpy as np
from scipy import linalg, sparse
from scipy.sparse.csgraph import connected_components

from viscorod.solve.linear.matrix import unit_of
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.periodic.orbit import Linearised
from viscorod.solve.periodic.orbit_balance import OrbitBalance
from viscorod.solve.periodic.orbit_kernels import add_orbit_blocks
from viscorod.typing import Floats, Integers

__all__ = ["OrbitMatrix", "coupled_motions", "free_motions", "strains_of_nodes", "whole_matrix"]

DENSE = 2500
"""Unknowns up to which a dense factorisation is faster than a sparse one."""
COUPLED = 1e-11
"""Size of an entry, over the geometric mean of the largest of its row and its column, that is more than round-off."""


class OrbitMatrix:
    """The Jacobian of an orbit and its factors.

    Args:
        balance: of the model; omega: angular frequency [rad/s]; linear: derivatives at the orbit.
        motions: that are solved for, of all motions of nodes and multipliers, six for each ``(d,)``.

    Attributes:
        weights: of the squares of all unknowns in the size of a change ``(d N,)``: displacements over the length,
            rotations [rad]; their mean over the phases is that of one motion.
    """

    def __init__(
        self,
        balance: OrbitBalance,
        omega: float,
        linear: Linearised,
        motions: Integers,
    ) -> None:
        self.balance, self.motions = balance, motions
        problem = balance.problem
        self._count, self._rows = balance.fourier.count, problem.pattern.size
        self.unit = np.ones((self._rows, 6))
        self.unit[: problem.size, :3] = unit_of(problem.length)
        own = self.unit.ravel()[motions]
        size = np.zeros((self._rows, 6))
        size[: problem.size] = [unit_of(problem.length) / problem.length] * 3 + [1.0] * 3
        self.weights: Floats = np.repeat(size.ravel()[motions] ** 2, self._count) / self._count
        self._Z = linear.Z
        self._scales = np.repeat(own, self._count)
        self.dense = len(self._scales) <= DENSE
        self.matrix = self._dense(linear, omega) if self.dense else self._sparse(linear, omega)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self._scales)

    def factorise(self, columns: Floats, rows: Floats, corner: Floats) -> None:
        """Factorise ``[[J, columns], [rows, corner]]`` with columns ``(size, k)`` and rows ``(k, size)``."""
        k, n = len(corner), self.size
        if self.dense:
            whole = np.empty((n + k, n + k), order="F")
            whole[:n, :n] = self.matrix
            whole[:n, n:], whole[n:, :n], whole[n:, n:] = columns, rows, corner
            self._factors = linalg.lu_factor(whole, overwrite_a=True, check_finite=False)
        else:
            parts = [
                [self.matrix, sparse.csc_array(columns)],
                [sparse.csr_array(rows), sparse.csr_array(corner)],
            ]
            self._lu = SparseLU(sparse.csc_array(sparse.block_array(parts)))

    def solve(self, right: Floats) -> Floats:
        """Return the solution ``(size + k,)`` of the bordered system."""
        if self.dense:
            return np.asarray(linalg.lu_solve(self._factors, right, check_finite=False))
        return self._lu.solve(right)

    def right(self, residual: Floats) -> Floats:
        """Return a residual ``(N, N_b, 6)`` as a right side ``(size,)``."""
        flat = residual.reshape(self._count, -1)[:, self.motions].T.ravel()
        return np.asarray(flat * self._scales)

    def others(self, residual: Floats) -> Floats:
        """Return the largest entries of a residual in motions that are not solved for, and that are ``(2,)`` [N m]."""
        size = np.abs(residual).max(axis=0)
        size[:, :3] *= self.balance.problem.length
        mine = np.zeros(size.size, dtype=bool)
        mine[self.motions] = True
        flat = np.where(free_motions(self.balance), size.ravel(), 0.0)
        return np.array([flat[~mine].max(initial=0.0), flat[mine].max(initial=0.0)])

    def whole(self, solution: Floats) -> Floats:
        """Return a solution ``(size,)`` as changes of all motions ``(N, N_b, 6)``, along the axes of supports."""
        found = np.zeros((self._count, 6 * self._rows))
        found[:, self.motions] = (solution * self._scales).reshape(len(self.motions), -1).T
        return found.reshape(self._count, self._rows, 6)

    def reduced(self, changes: Floats) -> Floats:
        """Return changes as :meth:`whole` gives them as a solution ``(size,)``."""
        flat = changes.reshape(self._count, -1)[:, self.motions].T.ravel()
        return np.asarray(flat / self._scales)

    def increments(self, changes: Floats, residual: Floats | None = None) -> Floats:
        """Return changes of all motions ``(N, N_b, 6)`` as body increments, in which supports close their gaps."""
        found = changes.copy()
        supports = self.balance.supports
        for number, k in enumerate(supports.partial):
            node = int(supports.set.nodes[k])
            if residual is not None:
                fixed = supports.set.fixed[k] != 0.0
                found[:, node, fixed] = -residual[:, node, fixed]
            found[:, node] = np.einsum("pij,pj->pi", self._Z[:, number], found[:, node])
        return np.ascontiguousarray(found)

    def _dense(self, linear: Linearised, omega: float) -> Floats:
        """Return the matrix of few unknowns."""
        balance, rows, count = self.balance, self.motions, self._count
        D, here = omega * balance.D, np.arange(count)
        columns = np.union1d(rows, _of_partial_nodes(balance)) if balance.body.partly else rows
        pattern, nodes = balance.problem.pattern, np.arange(balance.problem.size)
        found = np.zeros((len(rows), count, len(columns), count))
        of_rows, of_columns = np.full((2, 6 * pattern.size), -1, dtype=np.int64)
        of_rows[rows], of_columns[columns] = np.arange(len(rows)), np.arange(len(columns))
        n = len(nodes)
        pushed = (D @ linear.V.reshape(n, count, -1)).reshape(linear.V.shape)
        C = np.ascontiguousarray(linear.C)
        add_orbit_blocks(C, pattern.rows, pattern.columns, linear.V, of_rows, of_columns, found)
        add_orbit_blocks(linear.M, nodes, nodes, pushed, of_rows, of_columns, found)
        K = whole_matrix(balance, linear.K, pattern.rows, pattern.columns)
        found[:, here, :, here] += K[:, rows[:, None], columns]
        if balance.problem.relaxing:
            found += self._branches(linear.strain, omega, rows, columns)
        for number, k in enumerate(balance.supports.partial):
            first = 6 * int(balance.supports.set.nodes[k])
            mine = np.searchsorted(columns, np.arange(first, first + 6))
            found[:, :, mine] = np.einsum("ipjq,qjl->iplq", found[:, :, mine], linear.Z[:, number])
        found = found[:, :, np.searchsorted(columns, rows)]
        return np.asarray(found.reshape(self.size, self.size) * self._scales * self._scales[:, None])

    def _branches(self, B: Floats, omega: float, rows: Integers, columns: Integers) -> Floats:
        """Return what the strains at all phases make of the forces of Maxwell branches at each."""
        balance = self.balance
        memory, elements, size = balance.system.relaxation, balance.elements, 6 * balance.problem.size
        assert memory is not None
        inside = [np.flatnonzero(part < size) for part in (rows, columns)]
        found = np.zeros((len(rows), self._count, len(columns), self._count))
        responses = balance.sections.responses(omega)
        whole = strains_of_nodes(balance, B)
        left = project_rows(balance, self._Z, whole)[:, :, rows[inside[0]]]
        right = whole[:, :, columns[inside[1]]]
        first = 0
        part = np.zeros((len(inside[0]), self._count, len(inside[1]), self._count))
        for e, order in enumerate(elements.order.tolist()):
            for g in range(order):
                mine = slice(first, first + 6)
                first += 6
                weight = elements.weights[order, g] * elements.half_lengths[e]
                for b, modulus in enumerate(memory.branches[elements.section[e, g]] * weight):
                    if modulus.any():
                        pushed = np.einsum("pai,ab->pib", left[:, mine], modulus)
                        part += np.einsum(
                            "pib,pq,qbj->ipjq", pushed, responses[b], right[:, mine], optimize=True
                        )
        found[np.ix_(inside[0], np.arange(self._count), inside[1], np.arange(self._count))] = part
        return found

    def _sparse(self, linear: Linearised, omega: float) -> sparse.csc_array:
        """Return the matrix of many unknowns."""
        balance, count = self.balance, self._count
        pattern, n, here = balance.problem.pattern, balance.problem.size, np.arange(count)
        D = omega * balance.D
        V = np.zeros((pattern.size, count, count, 6, 6))
        V[:n] = linear.V
        blocks = np.einsum("psij,spqjl->spiql", linear.C, V[pattern.columns], optimize=True)
        blocks[:, here, :, here] += linear.K
        pushed = np.einsum("pr,krqjl->kpqjl", D, linear.V, optimize=True)
        blocks[pattern.diagonal[:n]] += np.einsum("pkij,kpqjl->kpiql", linear.M, pushed, optimize=True)
        if balance.problem.relaxing:
            self._add_branches(linear.strain, omega, blocks)
        supports = balance.supports
        for number, k in enumerate(supports.partial):
            mine = pattern.columns == supports.set.nodes[k]
            blocks[mine] = np.einsum("spiqj,qjl->spiql", blocks[mine], linear.Z[:, number])
        wide = 6 * count
        order = np.lexsort((pattern.columns, pattern.rows))
        starts = np.searchsorted(pattern.rows[order], np.arange(self._rows + 1))
        size = wide * self._rows
        stored = sparse.bsr_array(
            (blocks.reshape(-1, wide, wide)[order], pattern.columns[order], starts), shape=(size, size)
        ).tocsr()
        stored.eliminate_zeros()
        node, component = np.divmod(self.motions, 6)
        own = (node[:, None] * wide + here * 6 + component[:, None]).ravel()
        scale = sparse.diags_array(self._scales)
        return sparse.csc_array(scale @ stored[own].tocsc()[:, own] @ scale)

    def _add_branches(self, B: Floats, omega: float, blocks: Floats) -> None:
        """Add the forces of Maxwell branches, by the strains at all phases, to blocks ``(b, N, 6, N, 6)``."""
        balance, pattern, count = self.balance, self.balance.problem.pattern, self._count
        elements, memory, supports = balance.elements, balance.system.relaxation, balance.supports
        assert memory is not None
        responses = balance.sections.responses(omega)
        slots = {pair: k for k, pair in enumerate(zip(pattern.rows, pattern.columns, strict=True))}
        partial = {int(supports.set.nodes[k]): number for number, k in enumerate(supports.partial)}
        for e, order in enumerate(elements.order.tolist()):
            nodes = elements.nodes[e, : order + 1].tolist()
            right = B[:, e, : 6 * order, : 6 * (order + 1)]
            left = right.copy()
            for a, node in enumerate(nodes):
                if node in partial:
                    left[..., 6 * a : 6 * a + 6] = right[..., 6 * a : 6 * a + 6] @ self._Z[:, partial[node]]
            size = right.shape[-1]
            part = np.zeros((size, count, size, count))
            for g in range(order):
                mine = slice(6 * g, 6 * g + 6)
                weight = elements.weights[order, g] * elements.half_lengths[e]
                for b, modulus in enumerate(memory.branches[elements.section[e, g]] * weight):
                    if modulus.any():
                        pushed = np.einsum("pai,ab->pib", left[:, mine], modulus)
                        part += np.einsum(
                            "pib,pq,qbj->ipjq", pushed, responses[b], right[:, mine], optimize=True
                        )
            whole = part.reshape(order + 1, 6, count, order + 1, 6, count)
            for a, row in enumerate(nodes):
                for c, column in enumerate(nodes):
                    blocks[slots[row, column]] += whole[a, :, :, c].transpose(1, 0, 3, 2)


def whole_matrix(balance: OrbitBalance, blocks: Floats, rows: Integers, columns: Integers) -> Floats:
    """Return blocks at all phases ``(N, b, 6, 6)`` as matrices over the motions of all block rows ``(N, R, R)``."""
    count, size = len(blocks), balance.problem.pattern.size
    found = np.zeros((count, size, 6, size, 6))
    found[:, rows, :, columns] = np.swapaxes(blocks, 0, 1)
    return found.reshape(count, 6 * size, 6 * size)


def strains_of_nodes(balance: OrbitBalance, B: Floats) -> Floats:
    """Return the strains of all Gauss points by increments of all nodes ``(N, 6 points, 6 n)``, element by element."""
    elements, size = balance.elements, 6 * balance.problem.size
    found = []
    for e, order in enumerate(elements.order.tolist()):
        rows = np.zeros((len(B), 6 * order, size))
        for k in range(order + 1):
            first = 6 * int(elements.nodes[e, k])
            rows[:, :, first : first + 6] += B[:, e, : 6 * order, 6 * k : 6 * k + 6]
        found.append(rows)
    return np.concatenate(found, axis=1)


def project_rows(balance: OrbitBalance, Z: Floats, columns: Floats) -> Floats:
    """Return arrays over increments of all nodes ``(N, k, 6 n)`` over motions along the axes of partial supports."""
    supports, found = balance.supports, columns.copy()
    for number, k in enumerate(supports.partial):
        first = 6 * int(supports.set.nodes[k])
        mine = slice(first, first + 6)
        found[:, :, mine] = columns[:, :, mine] @ Z[:, number]
    return found


def free_motions(balance: OrbitBalance) -> np.ndarray:
    """Return which motions of nodes and multipliers are unknowns ``(6 N_b,)``."""
    problem, supports = balance.problem, balance.supports.set
    free = np.ones((problem.pattern.size, 6), dtype=bool)
    free[supports.nodes] = supports.fixed == 0.0
    found = free.ravel()
    if problem.constrained:
        found[6 * problem.size + balance.system.constraints.idle] = False
    return found


def coupled_motions(balance: OrbitBalance, omega: float, linear: Linearised) -> list[Integers]:
    """Return the motions that are unknowns in groups that do not couple at any phase."""
    pattern, n = balance.problem.pattern, balance.problem.size
    ad = np.zeros((len(linear.ad), pattern.size, 6, 6))
    ad[:, :n] = linear.ad
    parts = linear.K, omega * linear.C, linear.C @ ad[:, pattern.columns]
    size = sum(np.abs(part).max(axis=0) for part in parts)
    heavy = omega**2 * linear.M, omega * (linear.M @ linear.ad)
    size[pattern.diagonal[:n]] += sum(np.abs(part).max(axis=0) for part in heavy)
    whole = 6 * pattern.size
    rows = 6 * pattern.rows[:, None, None] + np.arange(6)[:, None] + np.zeros(6, dtype=np.int64)
    columns = 6 * pattern.columns[:, None, None] + np.arange(6) + np.zeros((6, 1), dtype=np.int64)
    of_rows, of_columns = np.zeros((2, whole))
    np.maximum.at(of_rows, rows.ravel(), size.ravel())
    np.maximum.at(of_columns, columns.ravel(), size.ravel())
    linked = size > COUPLED * np.sqrt(of_rows[rows] * of_columns[columns])
    for k in balance.supports.partial:  # their axes mix the motions of a node
        node = int(balance.supports.set.nodes[k])
        axes = np.abs(linear.Z).max(axis=0)[int(np.flatnonzero(balance.supports.partial == k)[0])]
        linked[pattern.diagonal[node]] |= axes > COUPLED
    pairs = sparse.coo_array(
        (np.ones(int(linked.sum())), (rows[linked], columns[linked])), shape=(whole, whole)
    ).tocsr()
    free = np.flatnonzero(free_motions(balance))
    count, label = connected_components(pairs[free].tocsc()[:, free], directed=False)
    return [free[label == k] for k in range(count)]


def _of_partial_nodes(balance: OrbitBalance) -> Integers:
    nodes = balance.supports.set.nodes[balance.supports.partial]
    return np.asarray((6 * nodes[:, None] + np.arange(6)).ravel())
