"""Section matrices: their symmetric part, and entries in parts of the sizes on the diagonal."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["by_sizes", "symmetric_part"]


def symmetric_part(matrix: Floats) -> Floats:
    """Return half the sum of a matrix and its transpose."""
    return np.asarray((matrix + matrix.T) / 2.0)


def by_sizes(matrix: Floats, squares: Floats) -> Floats:
    """Return entries over sqrt(squares_i squares_j); for a stiffness and its diagonal, the correlations."""
    size = np.sqrt(squares)
    return np.asarray(matrix / size[:, None] / size[None, :])
