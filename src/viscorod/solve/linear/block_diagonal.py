"""Matrices of square blocks on the diagonal."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.typing import Floats


def block_diagonal(blocks: Floats) -> sparse.csr_array:
    """Return the matrix with ``blocks (n, k, k)`` on its diagonal, without entries that are zero."""
    count = len(blocks)
    found = sparse.csr_array(sparse.bsr_array((blocks, np.arange(count), np.arange(count + 1))))
    found.eliminate_zeros()
    return found
