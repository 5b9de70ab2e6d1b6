"""Patterns of block matrices, their bands and their scaling, against dense algebra."""

from __future__ import annotations

import numpy as np
import pytest

from helpers.small_frame import dense
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.singular import SingularMatrixError


def chain(size, seed=None):
    """Elements of order 1 one after the other, nodes numbered at random if there is a seed."""
    number = np.arange(size) if seed is None else np.random.default_rng(seed).permutation(size)
    return Pattern.of(size, [np.stack([number[:-1], number[1:]], axis=1)])


PATTERNS = {
    "in order": (chain(9), 11),
    "shuffled": (chain(9, seed=1), 11),
    "one block": (Pattern.of(1, ()), 5),
    "ring": (Pattern.of(6, [np.array([[k, (k + 1) % 6] for k in range(6)])]), 17),
    "apart": (Pattern.of(4, [np.array([[0, 2]]), np.array([[1, 3]])]), 11),
}


def random_blocks(pattern, kind=float, seed=2):
    rng = np.random.default_rng(seed)
    blocks = rng.normal(size=(len(pattern.rows), 6, 6)).astype(kind)
    if kind is complex:
        blocks += 1j * rng.normal(size=blocks.shape)
    return blocks


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("name", PATTERNS)
def test_bands_are_narrow_and_solve(name, kind):
    """Independent code: numpy.linalg.solve; twice, for the storage is used again."""
    pattern, width = PATTERNS[name]
    solver = DirectSolver(Plan.of(pattern), kind)
    assert solver.description == f"band of half width {width}"
    for seed in (2, 3):
        blocks = random_blocks(pattern, kind, seed)
        kept = blocks.copy()
        solver.factorise(blocks)
        assert np.array_equal(blocks, kept)
        b = random_blocks(pattern, kind)[: pattern.size, 0].copy()
        expected = np.linalg.solve(dense(pattern, blocks), b.ravel())
        flat = b.ravel().copy()
        solver.solve(b)
        solver.solve(flat)
        assert flat == pytest.approx(expected, rel=1e-9, abs=1e-9 * np.abs(expected).max())
        assert np.array_equal(b.ravel(), flat)


def test_blocks_between_members():
    pattern = chain(7, seed=4)
    for s, (row, column) in enumerate(zip(pattern.rows, pattern.columns, strict=True)):
        assert pattern.slots(np.array([[row, column]]))[0, 0, 1] == s
        t = pattern.across[s]
        assert (pattern.rows[t], pattern.columns[t]) == (column, row)
        assert pattern.starts[column] <= s < pattern.starts[column + 1]
    assert np.array_equal(pattern.rows[pattern.diagonal], np.arange(7))
    assert np.array_equal(pattern.columns[pattern.diagonal], np.arange(7))


def test_sparse_arrays_hold_what_is_not_zero():
    pattern = chain(5, seed=3)
    blocks = random_blocks(pattern)
    blocks[::2] = 0.0
    found = pattern.sparse(blocks)
    assert np.array_equal(found.toarray(), dense(pattern, blocks))
    assert found.nnz == np.count_nonzero(blocks)


@pytest.mark.parametrize("length", [1e-3, 1.0, 300.0])
def test_scaling_changes_no_solutions(length):
    pattern = chain(5)
    matrix = Matrix(pattern, length)
    matrix.blocks[:] = random_blocks(pattern)
    whole = matrix.sparse().toarray()
    b = np.random.default_rng(1).normal(size=(5, 6))
    matrix.factorise()
    x = matrix.solve(b.copy())
    assert whole @ x.ravel() == pytest.approx(b.ravel(), abs=1e-8)
    assert (matrix.scales.min() < 1.0) == (length < 0.1)
    assert (matrix.scales.max() > 1.0) == (length > 10.0)


@pytest.mark.parametrize("kind", [float, complex])
@pytest.mark.parametrize("seed", [None, 5])
def test_singular_matrices_are_told(seed, kind):
    """Closed form: a zero column of a diagonal matrix gives a zero pivot in its row, as the nodes are numbered."""
    pattern = chain(6, seed)
    blocks = np.zeros((len(pattern.rows), 6, 6), dtype=kind)
    blocks[pattern.diagonal] = np.eye(6)
    blocks[pattern.diagonal[4], 2, 2] = 0.0
    with pytest.raises(SingularMatrixError) as told:
        DirectSolver(Plan.of(pattern), kind).factorise(blocks)
    assert told.value.row == 26
