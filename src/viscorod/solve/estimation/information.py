"""Criteria by which laws are compared on the same data."""

from __future__ import annotations

import numpy as np

__all__ = ["criteria"]


def criteria(square: float, count: float, fitted: int, values: float) -> tuple[float, float]:
    """Return Akaike's corrected and the Bayesian information criterion of a fit, up to a common constant.

    K. P. Burnham and D. R. Anderson, Model Selection and Multimodel Inference, 2002, sections 2.4 and 6.4.

    Args:
        square: weighted sum of squares of the residuals.
        count: effective number of values.
        fitted: unknowns, the noise level included.
        values: their number. Where it is far above the effective one, as with a best model that misses the motion, the
            correction for small samples, which is derived for independent values, does not decide by itself.
    """
    likelihood = count * float(np.log(max(square, 1e-300) / count))
    room = max(count - fitted - 1.0, min(float(fitted), values - fitted - 1.0), 1.0)
    return likelihood + 2.0 * fitted * (1.0 + (fitted + 1.0) / room), likelihood + fitted * float(
        np.log(count)
    )
