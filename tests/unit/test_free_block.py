"""What supports leave of a matrix, as a sparse matrix: against rows and columns of the whole."""

import numpy as np
import pytest

from viscorod.solve.constraints.free_block import FreeBlock
from viscorod.solve.linear.pattern import Pattern

RNG = np.random.default_rng(3)


@pytest.mark.parametrize("held", [range(6), [0, 4, 9, 14, 15, 29], range(0)], ids=["node", "some", "none"])
def test_rows_and_columns_of_the_whole_matrix(held):
    elements = np.array([[0, 2, 1], [1, 4, 3]])
    pattern = Pattern.of(5, [elements])
    blocks = RNG.normal(size=(len(pattern.rows), 6, 6))
    blocks[RNG.random(blocks.shape) < 0.4] = 0.0
    chosen = np.setdiff1d(np.arange(30), list(held))
    unit = RNG.uniform(0.5, 2.0, len(chosen))
    found = FreeBlock.of(pattern, chosen, unit).matrix(blocks)
    whole = pattern.sparse(blocks).toarray()[np.ix_(chosen, chosen)]
    np.testing.assert_array_equal(found.toarray(), whole * unit[:, None] * unit)
    assert found.nnz == np.count_nonzero(whole)
    assert found.has_sorted_indices
    assert found.indices.dtype == found.indptr.dtype == np.int32


def test_a_model_that_is_held_everywhere_leaves_nothing():
    pattern = Pattern.of(2, [np.array([[0, 1]])])
    found = FreeBlock.of(pattern, np.zeros(0, dtype=np.int64), np.zeros(0))
    assert found.matrix(np.ones((len(pattern.rows), 6, 6))).shape == (0, 0)
