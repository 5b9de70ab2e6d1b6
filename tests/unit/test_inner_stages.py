"""States within a step of many stages, corrected so that they go through the stages."""

from __future__ import annotations

import numpy as np
import pytest

from viscorod.solve.transient.integrators.inner_stages import go_through_stages
from viscorod.solve.transient.integrators.tableau import radau

PARTS = np.array([0.15, 0.5, 0.93])
AXIS = np.array([0.48, -0.6, 0.64])


def lacking(stages, places):
    """What was interpolated lacks: a polynomial of as many powers as stages, which vanishes at both ends ``(k,)``."""
    powers = np.array([0.3, -0.7, 0.2, 0.5, -0.1, 0.4])[: stages - 1]
    return places * (1.0 - places) * np.polynomial.polynomial.polyval(places, powers)


def turned(tangents):
    """Rotations about one axis, by the tangents of half their angles ``(k, 1, 4)``."""
    q = np.concatenate([np.ones((len(tangents), 1)), tangents[:, None] * AXIS], axis=1)
    return (q / np.linalg.norm(q, axis=1, keepdims=True))[:, None]


@pytest.mark.parametrize("stages", [5, 7])
def test_what_is_a_polynomial_of_that_degree_is_corrected_exactly(stages):
    """Closed form: Lagrange's polynomials through start and stages; of rotations the tangents of half angles are so."""
    method = radau(stages)
    inner = method.nodes[:-1]
    ends = np.array([1.0, 2.0, -1.0])
    places = np.concatenate([PARTS, inner])
    before = np.outer(places, ends)[:, None]  # interpolated at the places, then at the inner stages
    gap = 0.2 * lacking(stages, method.nodes)
    at_stages = np.outer(method.nodes, ends)[:, None] + gap[:, None, None]
    twist, twist_at_stages = (np.concatenate([one, -one], axis=2) for one in (before, at_stages))
    r, q = before.copy(), np.tile([1.0, 0.0, 0.0, 0.0], (len(places), 1, 1))
    go_through_stages(PARTS, method, (at_stages, turned(gap), twist_at_stages), 0, len(PARTS), (r, q, twist))
    expected = before[:3] + 0.2 * lacking(stages, PARTS)[:, None, None]
    np.testing.assert_allclose(r[:3], expected, atol=1e-14)
    np.testing.assert_allclose(twist[:3], np.concatenate([expected, -expected], axis=2), atol=1e-14)
    np.testing.assert_allclose(q[:3], turned(0.2 * lacking(stages, PARTS)), atol=1e-14)
    np.testing.assert_array_equal(r[3:], before[3:])


def test_states_at_the_stages_become_the_stages():
    """By definition, whatever was interpolated."""
    method, random = radau(5), np.random.default_rng(7)

    def unit(q):
        return q / np.linalg.norm(q, axis=2, keepdims=True)

    about = random.normal(size=(1, 3, 4))
    r, q, twist = (
        random.normal(size=(8, 3, 3)),
        unit(about + 0.2 * random.normal(size=(8, 3, 4))),
        random.normal(size=(8, 3, 6)),
    )
    for field in (r, q, twist):
        field[4:] = field[:4]
    stages = (
        random.normal(size=(5, 3, 3)),
        unit(about + 0.2 * random.normal(size=(5, 3, 4))),
        random.normal(size=(5, 3, 6)),
    )
    go_through_stages(method.nodes[:-1].copy(), method, stages, 0, 4, (r, q, twist))
    for found, stage in zip((r, twist), (stages[0], stages[2]), strict=True):
        np.testing.assert_allclose(found[:4], stage[:4], atol=1e-12)
    np.testing.assert_allclose(np.abs(np.sum(q[:4] * stages[1][:4], axis=2)), 1.0, atol=1e-12)
