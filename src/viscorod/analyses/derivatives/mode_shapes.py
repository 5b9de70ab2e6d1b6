"""How the shapes of modes change with numbers of the case, of modes that have a frequency of their own.

With ``P(s) x = 0``, ``P dx = -(dP x + ds P' x)`` has solutions that differ by multiples of ``x``; bordered by
``x* dx = 0`` and ``P' x``, which no motion balances, it has one (Nelson 1976). All shapes are scaled by the same
component then, the one that is 1 in the result.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import sparse

from viscorod.results.modes_result import Modes
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.modes.vibrations import station_motions

if TYPE_CHECKING:
    from viscorod.analyses.derivatives.eigenvalues import Pencil

__all__ = ["SHAPES", "MovingVectors", "ShapeRate", "ShapeRates"]

SHAPES = ("mode_shape", "mode_rotation")
"""Variables that hold them."""
ONE = 1e-9
"""Distance from 1 of the component that shapes are scaled by."""


class ShapeRate:
    """What the change of one vector follows from; computed when shapes are asked for.

    Args:
        pencil: the matrices; s: the eigenvalue; x: the vector.
    """

    def __init__(self, pencil: Pencil, s: complex, x: np.ndarray) -> None:
        self._pencil, self._s, self.x = pencil, s, x

    @cached_property
    def _slope(self) -> np.ndarray:
        return np.asarray(self._pencil.slope(self._s) @ self.x)

    @cached_property
    def _factors(self) -> SparseLU:
        column, row = self._slope[:, None], self.x.conj()[None]
        bordered = sparse.block_array([[self._pencil.at(self._s), column], [row, None]])
        return SparseLU(sparse.csc_array(bordered, dtype=complex))

    def change(self, changed: np.ndarray, rate: complex) -> np.ndarray:
        """Return the derivative of the vector, where ``dP x`` and the derivative of the eigenvalue are known."""
        right = -np.append(changed + rate * self._slope, 0.0)
        return np.asarray(self._factors.solve(right))[:-1]


class MovingVectors:
    """Derivatives of the vectors of modes by one number, computed when shapes are asked for.

    Args:
        of: modes that have a frequency of their own, by their places.
        changed: what ``dP x`` and the derivative of the eigenvalue are, by the places of these.
    """

    def __init__(
        self, of: Mapping[int, ShapeRate], changed: Mapping[int, tuple[np.ndarray, complex]]
    ) -> None:
        self._of, self._changed = of, changed

    @cached_property
    def rates(self) -> dict[int, np.ndarray]:
        """The derivatives, by the places of the modes."""
        return {k: self._of[k].change(*given) for k, given in self._changed.items()}


class _Scale(NamedTuple):
    """The component that is 1: of the rotations or of the displacements, and its place among them."""

    turning: bool
    place: int


class ShapeRates:
    """Shapes for other values of a number, to first order.

    Args:
        of: the modes that have a frequency of their own, by their places in the result; result: the modes.
    """

    def __init__(self, of: Mapping[int, ShapeRate], result: Modes) -> None:
        self.of, self._result = of, result
        self._scales = {k: _scale(result, k) for k in of}

    def near(self, pencil: Pencil, change: float, moving: MovingVectors) -> dict[str, np.ndarray]:
        """Return shapes and rotations as in the result, for a change of the number; not a number where not known.

        Args:
            pencil: for it; moving: derivatives of the vectors.
        """
        found = {name: np.full(self._result.data[name].shape, np.nan) for name in SHAPES}
        small = pencil.small
        for k, rate in moving.rates.items():
            vector = pencil.increments(self.of[k].x + change * rate)[:, None]
            motions = station_motions(small.problem, small.state, vector)
            turning, place = self._scales[k]
            peak = motions[turning][0].ravel()[place]
            for name, values in zip(SHAPES, motions, strict=True):
                found[name][k, 0], found[name][k, 1] = (values[0] / peak).real, (values[0] / peak).imag
        return found


def _scale(result: Modes, k: int) -> _Scale:
    """Return the component by which the shape of a mode is scaled."""
    for turning, values in ((False, result.shapes[k]), (True, result.rotations[k])):
        off = np.abs(values.ravel() - 1.0)
        if off.min() < ONE:
            return _Scale(turning, int(off.argmin()))
    return _Scale(False, int(np.abs(result.shapes[k]).argmax()))
