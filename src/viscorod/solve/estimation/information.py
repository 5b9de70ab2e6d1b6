"""Criteria by which laws are compared on the same data."""

from __future__ import annotations

import numpy as np

__all__ = ["criteria"]


def criteria(square: float, count: float, fitted: int) -> tuple[float, float]:
    """Return Akaike's corrected and the Bayesian information criterion of a fit, up to a common constant.

    K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, 2002, sections 2.4 and 6.4.

    Args:
        square: weighted sum of squares of the residuals.
        count: effective number of values.
        fitted: unknowns, the noise level included.
    """
    likelihood = count * float(np.log(max(square, 1e-300) / count))
    room = max(count - fitted - 1.0, 1.0)
    return likelihood + 2.0 * fitted * (1.0 + (fitted + 1.0) / room), likelihood + fitted * float(
        np.log(count)
    )
