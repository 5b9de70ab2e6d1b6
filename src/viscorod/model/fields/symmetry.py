"""Matrices that must be symmetric: how far round-off and printed digits excuse that they are not."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["skew_entry"]

_SLACK = 1e-6
"""Largest skew part that is taken for round-off, in parts of sqrt(A_ii A_jj) or of the entries themselves.

Energies, and so frequencies, change by less than this part if half the sum of both entries is taken. Section codes
leave 1e-14 to 1e-9, six printed digits 1e-6; a matrix given by one triangle has couplings far above.
"""


def skew_entry(matrix: Floats) -> tuple[int, int] | None:
    """Return row and column (from 0) of the worst entry of a matrix (n, n) that is not symmetric, or None.

    Entries are compared with the sizes of both strains, sqrt(A_ii A_jj): a coupling of no size beside them may differ
    from itself in every digit.
    """
    diagonal = np.sqrt(np.abs(np.diag(matrix)))
    size = np.maximum(np.outer(diagonal, diagonal), np.abs(matrix) + np.abs(matrix.T))
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.nan_to_num(np.abs(matrix - matrix.T) / size, nan=0.0)
    i, j = divmod(int(np.argmax(part)), len(matrix))
    return (min(i, j), max(i, j)) if part[i, j] > _SLACK else None
