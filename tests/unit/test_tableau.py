"""Coefficients of the collocation methods against Hairer and Wanner (1996), IV.5 and IV.8, and their program RADAU."""

from __future__ import annotations

from math import factorial

import numpy as np
import pytest

from viscorod.solve.transient.integrators.tableau import MIDPOINT, radau

RADAU = radau(3)
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


EIGENVALUES = {
    3: (3.6378342527444957, [2.6810828736277521 + 3.0504301992474105j]),
    5: (
        6.286704751729276645,
        [3.655694325463572258 + 6.543736899360077294j, 5.700953298671789419 + 3.210265600308549888j],
    ),
    7: (
        8.936832788405216337,
        [
            4.378693561506806002 + 10.16969328379501162j,
            7.141055219187640105 + 6.623045922639275970j,
            8.511834825102945723 + 3.281013624325058830j,
        ],
    ),
}
"""Of the inverse matrices, as in the program of Hairer and Wanner (1999)."""

ROUNDING = {1: 1e-13, 3: 1e-13, 5: 2e-12, 7: 2e-10}
"""By the number of stages: powers of the nodes are the more alike."""

ERROR = {
    3: [(-13 - 7 * R6) / 3, (-13 + 7 * R6) / 3, -1 / 3],
    5: [-27.78093394406463730, 3.641478498049213152, -1.252547721169118720, 0.5920031671845428725, -0.2],
    7: [
        -54.37443689412861451,
        7.000024004259186512,
        -2.355661091987557192,
        1.132289066106134386,
        -0.6468913267673587118,
        0.3875333853753523774,
        -1 / 7,
    ],
}
"""Weights of error estimates: (e1, e2, e3) of Hairer and Wanner (IV.8.17), the others as in their program."""


@pytest.mark.parametrize("stages", EIGENVALUES)
def test_radau_eigenvalues(stages):
    """Published numbers: eigenvalues of the inverse matrix; the transformation makes them blocks."""
    method, (real, pairs) = radau(stages), EIGENVALUES[stages]
    assert method.real == pytest.approx(real, rel=ROUNDING[stages])
    assert np.sort(method.pairs) == pytest.approx(np.sort(pairs), rel=ROUNDING[stages])
    blocks = np.zeros((stages, stages))
    blocks[0, 0] = real
    for m, pair in enumerate(method.pairs):
        a, b = pair.real, pair.imag
        blocks[2 * m + 1 : 2 * m + 3, 2 * m + 1 : 2 * m + 3] = [[a, -b], [b, a]]
    assert method.to_modes @ method.derivative @ method.to_stages == pytest.approx(
        blocks, abs=10 * ROUNDING[stages]
    )
    assert method.to_modes @ method.to_stages == pytest.approx(np.eye(stages), abs=ROUNDING[stages])


@pytest.mark.parametrize("stages", ERROR)
def test_radau_error_weights(stages):
    """Published numbers."""
    assert radau(stages).error == pytest.approx(ERROR[stages], abs=1e-11)


def pade(z, j, k):
    """Pade approximation of exp with a numerator of degree k and a denominator of degree j (IV.3.30 there)."""

    def part(m, n, x):
        return sum(
            factorial(n) * factorial(m + n - i) / (factorial(n - i) * factorial(m + n)) * x**i / factorial(i)
            for i in range(n + 1)
        )

    return part(j, k, z) / part(k, j, -z)


@pytest.mark.parametrize("stages", [3, 5, 7])
def test_radau_order_conditions_and_stability(stages):
    """Order 2 s - 1 of the quadrature, not 2 s (closed form); R(z) is the (s - 1, s) Pade approximation."""
    method = radau(stages)
    for k in range(1, 2 * stages):
        assert method.weights @ method.nodes ** (k - 1) == pytest.approx(1 / k, abs=1e-14)
    # the square of Jacobi's polynomial of degree s - 1, made monic, with the weight 1 - x
    excess = (factorial(stages) * factorial(stages - 1) / factorial(2 * stages - 1)) ** 2 / (2 * stages)
    assert method.weights @ method.nodes ** (2 * stages - 1) - 1 / (2 * stages) == pytest.approx(
        excess, rel=1e-6
    )
    for z in (-0.3, -2.0 + 1.5j, -1e3, 1e4j):
        # the last stage is the end: 1 + z b.(1 - z A)^-1 1 would lose three digits where z is large
        found = np.linalg.solve(np.eye(stages) - z * method.matrix, np.ones(stages))[-1]
        assert found == pytest.approx(pade(z, stages, stages - 1), abs=1e-12)
        assert abs(found) <= 1.0


@pytest.mark.parametrize("method", [RADAU, radau(5), radau(7), MIDPOINT])
def test_polynomials(method):
    """Polynomials up to the number of stages are reproduced, their integrals and first derivatives exact."""
    s = len(method.nodes)
    rounding = ROUNDING[s]
    for k in range(1, s + 1):
        x = np.array([0.0, 0.3, 1.0, 1.7])
        assert method.polynomials(x) @ method.nodes**k == pytest.approx(x**k, abs=rounding)
        integral = method.partial_weights(x) @ method.nodes ** (k - 1)
        assert integral == pytest.approx(x**k / k, abs=rounding)
        first = 1.0 if k == 1 else 0.0
        assert method.start_derivative @ method.nodes**k == pytest.approx(first, abs=10 * rounding)
    assert method.polynomials(method.nodes) == pytest.approx(np.eye(s), abs=rounding)
    assert method.partial_weights(np.ones(1))[0] == pytest.approx(method.weights, abs=rounding / 10)


def test_midpoint():
    """The implicit midpoint rule: node 1/2, weight 1, eigenvalue 2."""
    assert (MIDPOINT.nodes[0], MIDPOINT.weights[0], MIDPOINT.real) == pytest.approx((0.5, 1.0, 2.0))
