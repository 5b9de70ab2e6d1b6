"""Coefficients of collocation methods, computed from their nodes.

A method with nodes ``c`` has the matrix ``A`` with ``sum_j a_ij p(c_j) = int_0^{c_i} p`` for polynomials of degree
below the number of stages. Stage values follow the stage derivatives by ``A``; its inverse ``D`` gives derivatives from
values, and its eigenvalues decouple the stages in the simplified Newton iteration (Hairer and Wanner 1996, IV.8).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np

from viscorod.typing import Floats


class Tableau(NamedTuple):
    """A collocation method with an odd number of stages: one real eigenvalue, and complex pairs.

    Attributes:
        nodes: ``c (s,)``; weights: ``b (s,)`` of its quadrature.
        matrix: ``A (s, s)``; derivative: ``D = A^-1``.
        to_stages, to_modes: ``T`` and ``T^-1`` with ``D T = T Lambda``, Lambda in real blocks
            ``real`` and ``[[a, -b], [b, a]]``, one for every pair.
        real, pairs: the eigenvalues of ``D``, of pairs those above the real axis ``((s - 1)/2,)``.
        error: weights ``e (s,)`` of the error estimate ``f(u_0) + sum e_i (u_i - u_0)/h``, filtered by
            ``(real/h - J)^-1``: the difference to the embedded method of order s with the extra node 0
            (Hairer and Wanner 1996, IV.8.17).
        start_derivative: ``(s,)``, h times the derivative at the start is ``sum start_derivative_i (u_i - u_0)``.
        values, integrals: coefficients ``(s, s)`` of the powers 1 to s of the place in the step, of the polynomials of
            the stage values and of the integrals of the stage derivatives.
    """

    nodes: Floats
    weights: Floats
    matrix: Floats
    derivative: Floats
    to_stages: Floats
    to_modes: Floats
    real: float
    pairs: np.ndarray
    error: Floats
    start_derivative: Floats
    values: Floats
    integrals: Floats

    @classmethod
    def of(cls, nodes: Floats) -> Tableau:
        """Compute the coefficients of the collocation method with the given nodes."""
        s = len(nodes)
        powers = np.vander(nodes, s, increasing=True)
        k = np.arange(1, s + 1)
        matrix = (nodes[:, None] ** k / k) @ np.linalg.inv(powers)
        weights = np.asarray(np.linalg.solve(powers.T, 1.0 / k), dtype=np.float64)
        derivative = np.linalg.inv(matrix)
        values, vectors = np.linalg.eig(derivative)
        first = int(np.argmin(np.abs(values.imag)))
        real = float(values[first].real)
        above = np.flatnonzero(values.imag > 0.0)
        columns = [vectors[:, first].real]
        for at in above:
            columns += [vectors[:, at].real, -vectors[:, at].imag]
        to_stages = np.ascontiguousarray(np.column_stack(columns))
        # embedded weights integrate polynomials up to degree s - 1 with the extra weight 1/real at node 0
        moments = 1.0 / k
        moments[0] -= 1.0 / real
        embedded = np.linalg.solve(powers.T, moments)
        return cls(
            nodes,
            weights,
            matrix,
            derivative,
            to_stages,
            np.linalg.inv(to_stages),
            real,
            np.ascontiguousarray(values[above], dtype=np.complex128),
            real * (embedded - weights) @ derivative,
            np.asarray(np.linalg.solve(powers.T * nodes, np.eye(s)[0]), dtype=np.float64),
            np.asarray(np.linalg.inv(powers.T * nodes), dtype=np.float64),
            np.asarray(np.linalg.inv(powers.T) / k, dtype=np.float64),
        )

    def polynomials(self, places: Floats) -> Floats:
        """Return the values ``(k, s)`` at ``places (k,)`` of the polynomials that are one at one node, else zero."""
        return self._powers(places) @ self.values.T

    def partial_weights(self, parts: Floats) -> Floats:
        """Return the weights ``(k, s)`` of the integrals of stage values from 0 to ``parts (k,)`` of the step."""
        return self._powers(parts) @ self.integrals.T

    @property
    def exact_inside(self) -> Floats:
        """Nodes inside of a step whose stages, of order s + 1, are as exact as Hermite's polynomial of degree 5."""
        return self.nodes[:-1] if len(self.nodes) >= 5 else self.nodes[:0]

    def _powers(self, places: Floats) -> Floats:
        powers = np.empty((len(places), len(self.nodes)))
        powers[:, 0] = places
        for k in range(1, len(self.nodes)):
            powers[:, k] = powers[:, k - 1] * places
        return powers


def radau_nodes(stages: int) -> Floats:
    """Return the nodes of Radau IIA, zeros of ``P_(s-1) - P_s`` in Legendre's polynomials (IV.5 there)."""
    basis = np.polynomial.Legendre.basis
    zeros = basis(stages - 1) - basis(stages)
    nodes = np.sort(zeros.roots().real)
    nodes -= zeros(nodes) / zeros.deriv()(nodes)  # what rounding in the roots has left
    nodes[-1] = 1.0
    return np.asarray(0.5 * (1.0 + nodes), dtype=np.float64)


@cache
def radau(stages: int) -> Tableau:
    """Return Radau IIA with an odd number of stages s: order 2 s - 1, L-stable, stiffly accurate."""
    return Tableau.of(radau_nodes(stages))


MIDPOINT = Tableau.of(np.array([0.5]))
"""The implicit midpoint rule: order 2, symmetric."""
