"""The order of the six strains in programs whose beam axis is x.

They count (axial, shear y, shear z | torsion, bend y, bend z). Their x is viscorod's d3, y its d1 and z its d2,
which is a right-handed relabelling: components change places but not signs.
"""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats, Integers

__all__ = ["AXIAL_FIRST", "STRAINS", "VISCOSITIES", "from_axial_first", "to_axial_first"]

AXIAL_FIRST = np.array([2, 0, 1, 5, 3, 4])
"""Places in viscorod's order (shear_1, shear_2, stretch, bend_1, bend_2, twist), in the order of the other."""

STRAINS = ("axial", "shear y", "shear z", "torsion", "bending y", "bending z")
"""In that order."""
VISCOSITIES = ("N s", "N s", "N s", "N m^2 s", "N m^2 s", "N m^2 s")
"""Units of their viscosities."""

_BACK = np.argsort(AXIAL_FIRST)


def to_axial_first(values: Floats) -> Floats:
    """Return six numbers (6,) or a section matrix (6, 6) in the order of a program whose beam axis is x."""
    return _placed(values, AXIAL_FIRST)


def from_axial_first(values: Floats) -> Floats:
    """Return six numbers (6,) or a section matrix (6, 6) of such a program in viscorod's order."""
    return _placed(values, _BACK)


def _placed(values: Floats, places: Integers) -> Floats:
    return np.asarray(values[places] if values.ndim == 1 else values[np.ix_(places, places)])
