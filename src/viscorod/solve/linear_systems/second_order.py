"""Linear systems of second order with Maxwell branches, inputs and outputs, and their equations of first order.

``A_2 y'' + A_1 y' + A_0 y + sum_j B_j w_j = F u - (the same of the prescribed motions p)``, ``w_j' = y' - w_j/tau_j``
the displacement less that of the dashpots of branch j; outputs ``sum_i R_i y^(i) + sum_j R_j w_j + ...``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.constraints.null_space import null_space
from viscorod.solve.linear_systems.ports import Inputs
from viscorod.solve.linear_systems.readings import Readings
from viscorod.solve.linear_systems.small_motions import Coefficient, SmallMotions
from viscorod.solve.modes.linearisation import factored
from viscorod.typing import Floats

__all__ = ["FirstOrderMatrices", "SecondOrder", "second_order"]

ROUNDS, CONVERGED = 30, 1e-11
NOISE, SILENT = 1e-10, 1e-4
"""Response over what would be possible, below which it is round-off, and by which its error is measured then."""
DENSE = 60
"""Coordinates up to which full matrices are faster."""


class FirstOrderMatrices(NamedTuple):
    """``z' = A z + B u``, ``y = C z + D u`` (dense)."""

    A: Floats
    B: Floats
    C: Floats
    D: Floats


@dataclass(frozen=True)
class SecondOrder:
    """A linear system of second order; see the module.

    Attributes:
        terms: stiffness, damping, mass and the stiffnesses of the branches ``(n, n)``.
        pushed: the same of the prescribed motion of every input ``(n, inputs)``, zero for loads.
        force: of the loads ``(n, inputs)``.
        rows: outputs of the same kinds ``(outputs, n)``; carried: of prescribed motions ``(outputs, inputs)``.
        direct: outputs of inputs ``(outputs, inputs)``.
        times: relaxation times of the branches [s].
        derivative: of the prescribed motions by time, which the inputs are ``(inputs,)``; -1 for loads.
        basis: nodal body increments of the coordinates ``(6 N, n)``; carrying: of the prescribed motions.
        measured: complex moduli over those at rest, functions of ``s``, of the terms after those of the branches.
    """

    terms: tuple[sparse.csr_array, ...]
    pushed: tuple[Floats, ...]
    force: Floats
    rows: tuple[sparse.csr_array, ...]
    carried: tuple[Floats, ...]
    direct: Floats
    times: Floats
    derivative: np.ndarray
    basis: sparse.csr_array
    carrying: Floats
    measured: tuple[Coefficient, ...] = ()

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return int(self.terms[0].shape[0])

    def coefficients(self, s: complex) -> list[complex]:
        """Return by what terms, rows and the rest are multiplied at ``s`` [1/s]."""
        return [
            1.0,
            s,
            s * s,
            *(s * tau / (1.0 + s * tau) for tau in self.times),
            *(c(s) for c in self.measured),
        ]

    def at(self, s: complex) -> sparse.csr_array:
        """Return the dynamic stiffness ``(n, n)`` at ``s`` [1/s]."""
        return sparse.csr_array(
            sum(c * term for c, term in zip(self.coefficients(s), self.terms, strict=True))
        )

    def response(self, hertz: float) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` at a frequency [Hz]."""
        c, times, x = self._solved(2j * np.pi * hertz)
        out = self.direct + times * sum(k * part for k, part in zip(c, self.carried, strict=True))
        return np.asarray(out + sum(k * (rows @ x) for k, rows in zip(c, self.rows, strict=True)))

    def sizes(self, responses: np.ndarray, hertz: Floats) -> Floats:
        """Return by what errors of responses ``(n, outputs, inputs)`` are measured ``(outputs, inputs)``.

        That is the largest size of each. One that symmetry forbids is round-off of what is possible, the largest
        factor in its row times the largest coordinate, and is measured by a part of that.

        Args:
            responses: at any frequencies; hertz: frequencies [Hz] at which coordinates are large, for what is possible.
        """
        possible = np.max([self._possible(float(f)) for f in hertz], axis=0)
        largest = np.abs(responses).max(axis=0)
        found: Floats = np.where(
            largest <= NOISE * possible, SILENT * possible, np.maximum(largest, np.finfo(float).tiny)
        )
        return found

    def _possible(self, hertz: float) -> Floats:
        c, times, x = self._solved(2j * np.pi * hertz)
        largest = np.abs(x).max(axis=0, initial=0.0)
        found: Floats = np.maximum(np.abs(self.direct), np.finfo(float).tiny)
        for k, rows, carried in zip(c, self.rows, self.carried, strict=True):
            factor = abs(rows).max(axis=1).toarray().ravel() if rows.nnz else np.zeros(len(found))
            found = found + abs(k) * (np.outer(factor, largest) + np.abs(times * carried))
        return found

    def _solved(self, s: complex) -> tuple[list[complex], np.ndarray, np.ndarray]:
        """Return the coefficients, the factors of prescribed motions ``(inputs,)`` and the coordinates at ``s``."""
        c = self.coefficients(s)
        times = np.where(self.derivative > 0, s ** -np.maximum(self.derivative, 0).astype(float), 1.0)
        right = self.force - times * sum(k * part for k, part in zip(c, self.pushed, strict=True))
        right = np.asarray(right, dtype=complex)
        if self.size <= DENSE:
            return c, times, np.linalg.solve(np.tensordot(c, self._dense, 1), right)
        return c, times, np.asarray(factored(self.at(s)).solve(right))

    @property
    def at_rest(self) -> sparse.csr_array:
        """Stiffness at rest, with what measured moduli have there."""
        return sparse.csr_array(sum(self.terms[self._first_measured :], self.terms[0]))

    @property
    def pushed_at_rest(self) -> Floats:
        """The same of prescribed motions."""
        found = self.pushed[0].copy()
        for part in self.pushed[self._first_measured :]:
            found += part
        return found

    @property
    def _first_measured(self) -> int:
        return 3 + len(self.times)

    @cached_property
    def _dense(self) -> Floats:
        """All terms as full matrices ``(terms, n, n)``."""
        return np.array([term.toarray() for term in self.terms])

    def pole_near(self, s: complex) -> complex:
        """Return the pole next to ``s`` [1/s], by inverse iteration (Newton's method)."""
        x = np.random.default_rng(1).standard_normal(self.size).astype(complex)
        for _ in range(ROUNDS):
            try:
                better = np.asarray(factored(self.at(s)).solve(self._slope(s, x)))
            except SolveError:  # exactly singular
                return s
            change = -np.vdot(better, x) / np.vdot(better, better)
            x, s = better / np.linalg.norm(better), s + change
            if abs(change) <= CONVERGED * abs(s):
                break
        return complex(s)

    def _slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        """Return the derivative of the dynamic stiffness by ``s``, applied to ``x``."""
        out = self.terms[1] @ x + 2.0 * s * (self.terms[2] @ x)
        for term, tau in zip(self.terms[3:], self.times, strict=False):
            out = out + tau / (1.0 + s * tau) ** 2 * (term @ x)
        return np.asarray(out)

    def within(self, V: Floats) -> SecondOrder:
        """Return the system in fewer coordinates ``y = V a`` (Galerkin: energies of motions in V stay as they are)."""

        def inner(matrix: sparse.csr_array) -> sparse.csr_array:
            return sparse.csr_array(V.T @ (matrix @ V))

        return replace(
            self,
            terms=tuple(inner(term) for term in self.terms),
            pushed=tuple(V.T @ part for part in self.pushed),
            force=V.T @ self.force,
            rows=tuple(sparse.csr_array(rows @ V) for rows in self.rows),
            basis=sparse.csr_array(self.basis @ V),
        )

    def first_order(self) -> FirstOrderMatrices:
        """Return the equations of first order, exact with all branches.

        States are coordinates, their rates, the branches' ``w_j``, and where accelerations are prescribed the motions,
        their rates and their branches. Inputs that prescribe displacements or velocities are not proper.
        """
        n, count, branches = self.size, self.force.shape[1], len(self.times)
        moving = np.flatnonzero(self.derivative >= 0)
        m = len(moving)
        K, C, M, *B = (term.toarray() for term in self.terms)
        inverse = scipy.linalg.inv(M)
        states = (2 + branches) * (n + m)
        y, v = slice(0, n), slice(n, 2 * n)
        w = [slice((2 + j) * n, (3 + j) * n) for j in range(branches)]
        first = (2 + branches) * n
        p, r = slice(first, first + m), slice(first + m, first + 2 * m)
        q = [slice(first + (2 + j) * m, first + (3 + j) * m) for j in range(branches)]
        pushed = [part[:, moving] for part in self.pushed]
        A, inputs = np.zeros((states, states)), np.zeros((states, count))
        A[y, v] = np.eye(n)
        A[v, y], A[v, v] = -inverse @ K, -inverse @ C
        A[v, p], A[v, r] = -inverse @ pushed[0], -inverse @ pushed[1]
        inputs[v] = inverse @ (self.force - self.pushed[2])
        A[p, r] = np.eye(m)
        inputs[np.arange(r.start, r.stop), moving] = 1.0
        for j, tau in enumerate(self.times):
            A[v, w[j]], A[v, q[j]] = -inverse @ B[j], -inverse @ pushed[3 + j]
            A[w[j], v], A[w[j], w[j]] = np.eye(n), -np.eye(n) / tau
            A[q[j], r], A[q[j], q[j]] = np.eye(m), -np.eye(m) / tau
        rows, carried = [part.toarray() for part in self.rows], [part[:, moving] for part in self.carried]
        out = rows[2] @ A[v]
        out[:, y] += rows[0]
        out[:, v] += rows[1]
        out[:, p] += carried[0]
        out[:, r] += carried[1]
        for j in range(branches):
            out[:, w[j]] += rows[3 + j]
            out[:, q[j]] += carried[3 + j]
        through = self.direct + rows[2] @ inputs[v] + self.carried[2]
        return FirstOrderMatrices(A, inputs, out, through)


def second_order(
    small: SmallMotions, inputs: Inputs, readings: Readings
) -> tuple[SecondOrder, Floats | None]:
    """Return the linear system of small motions without its conditions, and the basis in which they are fulfilled.

    Coordinates are the free motions, or where there are conditions combinations of them ``(free, n)`` that fulfil
    these, beside the shapes that prescribed motions have at rest.
    """
    free = small.free
    units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
    moved = np.asarray(small.held @ inputs.held)
    Z: Floats | None = None
    follow = np.zeros((free.shape[1], inputs.force.shape[1]))
    rows: Sequence[sparse.csr_array] = readings.rows
    direct = readings.direct
    if small.gradients is not None:
        G = (small.gradients @ free).toarray() * units
        inverse = np.linalg.pinv(G)
        Z = units[:, None] * null_space(sparse.csr_array(G))
        follow = units[:, None] * (inverse @ (inputs.targets - small.gradients @ moved))
        # multipliers balance what the free motions leave: G' lambda = F - sum_i c_i A_i d
        rest = readings.multipliers @ (inverse.T * units)
        rows = [
            sparse.csr_array(part - rest @ terms) for part, terms in zip(rows, small.balance, strict=True)
        ]
        direct = direct + rest @ (free.T @ inputs.force)
    basis = free if Z is None else sparse.csr_array(free @ Z)
    left = sparse.eye_array(free.shape[1], format="csr") if Z is None else sparse.csr_array(Z)
    carrying = moved + np.asarray(free @ follow)
    system = SecondOrder(
        terms=tuple(sparse.csr_array(left.T @ (part @ basis)) for part in small.balance),
        pushed=tuple(np.asarray(left.T @ (part @ carrying)) for part in small.balance),
        force=np.asarray(left.T @ (free.T @ inputs.force)),
        rows=tuple(sparse.csr_array(part @ basis) for part in rows),
        carried=tuple(np.asarray(part @ carrying) for part in rows),
        direct=direct,
        times=small.times,
        derivative=np.where(inputs.held.any(axis=0) | inputs.targets.any(axis=0), inputs.derivative, -1),
        basis=basis,
        carrying=carrying,
        measured=small.coefficients[3 + len(small.times) :],
    )
    return _about_shapes_at_rest(system), Z


def _about_shapes_at_rest(system: SecondOrder) -> SecondOrder:
    """Return the system in the motions beside the shapes that prescribed motions have at rest, if these are unique."""
    moving = system.derivative >= 0
    if not moving.any():
        return system
    try:
        shapes = -np.asarray(factored(system.at_rest).solve(system.pushed_at_rest))
    except SolveError:
        return system
    pushed = [part + term @ shapes for part, term in zip(system.pushed, system.terms, strict=True)]
    if not system.measured:
        pushed[0] = np.zeros_like(shapes)
    return replace(
        system,
        pushed=tuple(pushed),
        carried=tuple(part + rows @ shapes for part, rows in zip(system.carried, system.rows, strict=True)),
        carrying=system.carrying + system.basis @ shapes,
    )
