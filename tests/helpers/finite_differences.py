"""Finite differences for the tests of tangents."""

from __future__ import annotations

import numpy as np


def slope_of(function, size, h=1e-3):
    """Fourth-order central differences of a vector function of ``size`` variables at 0."""
    columns = []
    for j in range(size):
        step = np.zeros(size)
        step[j] = h
        columns.append(
            (8 * (function(step) - function(-step)) - (function(2 * step) - function(-2 * step))) / (12 * h)
        )
    return np.array(columns).T
