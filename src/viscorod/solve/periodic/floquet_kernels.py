"""The matrices of the steps by which small motions about a periodic one are integrated."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.typing import Floats

__all__ = ["fill_steps"]


@kernel
def fill_steps(d: Floats, twice: Floats, C: Floats, heavy: Floats, M: Floats, J: Floats) -> None:
    """Write ``d_ij (C_i + M ad_j) + (d d)_ij M`` of all stages ``i``, ``j`` of all steps.

    Args:
        d, twice: derivatives by the stages, and their square ``(s, s)``.
        C: damping ``(steps, s, u, f)``; heavy: ``M ad`` likewise; M: mass ``(u, f)``.
        J: output ``(steps, s, u, s, f or more)``.
    """
    steps, stages, rows, columns = C.shape
    for a in range(steps):
        for i in range(stages):
            for k in range(rows):
                for j in range(stages):
                    for c in range(columns):
                        J[a, i, k, j, c] = (
                            d[i, j] * (C[a, i, k, c] + heavy[a, j, k, c]) + twice[i, j] * M[k, c]
                        )
