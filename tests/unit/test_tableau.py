"""Coefficients of the collocation methods against Hairer and Wanner (1996), IV.5 and IV.8."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.solve.transient.integrators.tableau import MIDPOINT, RADAU

R6 = np.sqrt(6.0)
MATRIX = np.array(
    [
        [(88 - 7 * R6) / 360, (296 - 169 * R6) / 1800, (-2 + 3 * R6) / 225],
        [(296 + 169 * R6) / 1800, (88 + 7 * R6) / 360, (-2 - 3 * R6) / 225],
        [(16 - R6) / 36, (16 + R6) / 36, 1 / 9],
    ]
)
"""Radau IIA of order 5, Hairer and Wanner, table IV.5.6."""


def test_radau_is_the_published_method():
    """Published numbers: nodes, matrix, weights; stiffly accurate, so the last row is the quadrature."""
    assert RADAU.nodes == pytest.approx([(4 - R6) / 10, (4 + R6) / 10, 1.0], abs=1e-15)
    assert RADAU.matrix == pytest.approx(MATRIX, abs=1e-14)
    assert RADAU.weights == pytest.approx(MATRIX[2], abs=1e-14)
    assert RADAU.derivative == pytest.approx(np.linalg.inv(MATRIX), abs=1e-12)


def test_radau_eigenvalues():
    """Published numbers: eigenvalues of the inverse matrix; the transformation makes them blocks."""
    assert RADAU.real == pytest.approx(3.6378342527444957, rel=1e-13)
    assert RADAU.pair == pytest.approx(2.6810828736277521 + 3.0504301992474105j, rel=1e-13)
    a, b = RADAU.pair.real, RADAU.pair.imag
    blocks = np.array([[RADAU.real, 0, 0], [0, a, -b], [0, b, a]])
    assert RADAU.to_modes @ RADAU.derivative @ RADAU.to_stages == pytest.approx(blocks, abs=1e-12)
    assert RADAU.to_modes @ RADAU.to_stages == pytest.approx(np.eye(3), abs=1e-13)


def test_radau_error_weights():
    """Published numbers: (e1, e2, e3) of Hairer and Wanner (IV.8.17)."""
    assert RADAU.error == pytest.approx([(-13 - 7 * R6) / 3, (-13 + 7 * R6) / 3, -1 / 3], abs=1e-12)


def test_radau_order_conditions_and_stability():
    """Order 5 of the quadrature and not 6 (closed form); R(z) is the (2, 3) Pade approximation, zero at infinity."""
    for k in range(1, 6):
        assert RADAU.weights @ RADAU.nodes ** (k - 1) == pytest.approx(1 / k, abs=1e-14)
    assert abs(RADAU.weights @ RADAU.nodes**5 - 1 / 6) > 1e-4
    for z in (-0.3, -2.0 + 1.5j, -1e3, 1e4j):
        found = 1 + z * RADAU.weights @ np.linalg.solve(np.eye(3) - z * RADAU.matrix, np.ones(3))
        pade = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
        assert found == pytest.approx(pade, abs=1e-12)
        assert abs(found) <= 1.0


@pytest.mark.parametrize("method", [RADAU, MIDPOINT])
def test_polynomials(method):
    """Polynomials up to the number of stages are reproduced, their integrals and first derivatives exact."""
    s = len(method.nodes)
    for k in range(1, s + 1):
        x = np.array([0.0, 0.3, 1.0, 1.7])
        assert method.polynomials(x) @ method.nodes**k == pytest.approx(x**k, abs=1e-13)
        integral = method.partial_weights(x) @ method.nodes ** (k - 1)
        assert integral == pytest.approx(x**k / k, abs=1e-13)
        first = 1.0 if k == 1 else 0.0
        assert method.start_derivative @ method.nodes**k == pytest.approx(first, abs=1e-12)
    assert method.polynomials(method.nodes) == pytest.approx(np.eye(s), abs=1e-13)
    assert method.partial_weights(np.ones(1))[0] == pytest.approx(method.weights, abs=1e-14)


def test_midpoint():
    """The implicit midpoint rule: node 1/2, weight 1, eigenvalue 2."""
    assert (MIDPOINT.nodes[0], MIDPOINT.weights[0], MIDPOINT.real) == pytest.approx((0.5, 1.0, 2.0))
