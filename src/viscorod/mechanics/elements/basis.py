"""Lagrange basis on Gauss-Lobatto nodes, and the two quadratures of an element, on [-1, 1]."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.polynomial import legendre

from viscorod.typing import Floats


@lru_cache
def lobatto(order: int) -> tuple[Floats, Floats]:
    """Return the ``order + 1`` Gauss-Lobatto nodes and weights (exact for polynomials of degree ``2 order - 1``)."""
    series = np.zeros(order + 1)
    series[order] = 1.0
    slope = legendre.legder(series)
    inner = np.sort(np.real(legendre.legroots(slope))) if order > 1 else np.empty(0)
    curvature = legendre.legder(slope)
    for _ in range(3 if order > 1 else 0):  # polish the companion-matrix roots to round-off
        inner -= legendre.legval(inner, slope) / legendre.legval(inner, curvature)
    nodes = np.concatenate([[-1.0], 0.5 * (inner - inner[::-1]), [1.0]])
    weights = 2.0 / (order * (order + 1) * legendre.legval(nodes, series) ** 2)
    return nodes, weights


@lru_cache
def gauss(count: int) -> tuple[Floats, Floats]:
    """Return the ``count`` Gauss-Legendre points and weights."""
    points, weights = legendre.leggauss(count)
    return points, weights


@lru_cache
def gauss_table(order: int) -> tuple[Floats, Floats]:
    """Return the Lagrange basis and its derivative at the ``order`` Gauss points; see :func:`lagrange`."""
    return lagrange(order, gauss(order)[0])


def lagrange(order: int, xi: Floats) -> tuple[Floats, Floats]:
    """Evaluate the Lagrange basis on the Gauss-Lobatto nodes and its derivative.

    Args:
        order: polynomial order p.
        xi: points ``(m,)`` in [-1, 1].

    Returns:
        values and derivatives with respect to ``xi``, each ``(m, order + 1)``.
    """
    nodes, _ = lobatto(order)
    xi = np.atleast_1d(np.asarray(xi, dtype=float))
    values = np.ones((len(xi), order + 1))
    slopes = np.zeros((len(xi), order + 1))
    for k in range(order + 1):
        for j in range(order + 1):
            if j == k:
                continue
            gap = nodes[k] - nodes[j]
            slopes[:, k] = slopes[:, k] * (xi - nodes[j]) / gap + values[:, k] / gap
            values[:, k] *= (xi - nodes[j]) / gap
    return values, slopes
