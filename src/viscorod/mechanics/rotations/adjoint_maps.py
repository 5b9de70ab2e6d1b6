"""Adjoint maps of rotations and twists, and exponential maps as their power series, for any number of nodes at once."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["adjoint_map", "series_of_exponential", "skew"]

TERMS = 30
"""Of the series: the next one is below round-off for rotations of 3 rad."""


def skew(a: Floats) -> Floats:
    """Return ``[a]x`` of vectors ``(..., 3)`` as matrices ``(..., 3, 3)``."""
    out = np.zeros((*a.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -a[..., 2], a[..., 1], -a[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = a[..., 2], -a[..., 1], a[..., 0]
    return out


def adjoint_map(x: Floats) -> Floats:
    """Return ``ad(x) = [[w~, v~], [0, w~]]`` of twists or coordinates ``(..., 6)``."""
    found: Floats = np.zeros((*x.shape, 6), dtype=x.dtype)
    found[..., _ROWS, _COLUMNS] = x[..., _FROM] * _SIGNS
    return found


def _entries() -> tuple[np.ndarray, ...]:
    """Return rows, columns, components and signs of the entries of ``ad(x)``."""
    found = []
    for first, second, start in ((0, 3, 0), (3, 3, 3), (0, 0, 3)):
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            found.append((first + i, second + j, start + k, -1.0))
            found.append((first + j, second + i, start + k, 1.0))
    rows, columns, components, signs = map(np.array, zip(*found, strict=True))
    return rows, columns, components, signs


_ROWS, _COLUMNS, _FROM, _SIGNS = _entries()


def series_of_exponential(X: Floats, split: Floats, terms: int = TERMS) -> tuple[Floats, Floats]:
    """Return ``exp(-ad X)`` and ``T(X)``, the series of ``(-ad X)^k`` over ``k!`` and ``(k + 1)!`` ``(n, 6, 6)``.

    Those of nodes that are ``split`` have displacement and rotation apart (see ``nodal_motion``).
    """
    apart = split != 0.0
    turning = X.copy()
    turning[apart, :3] = 0.0
    ad = -adjoint_map(turning)
    term = np.broadcast_to(np.eye(6, dtype=X.dtype), ad.shape)
    carry, tangent = term.copy(), term.copy()
    for k in range(1, terms + 1):
        term = term @ ad / k
        carry += term
        tangent += term / (k + 1)
    tangent[apart, :3, :3] = carry[apart, :3, :3]
    carry[apart, :3, 3:] = -carry[apart, :3, :3] @ adjoint_map(X[apart])[:, :3, 3:]
    return carry, tangent
