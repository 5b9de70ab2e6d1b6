"""Cables: rods that bend and twist at no cost, whose sections need a direction all the same."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["GYRATION", "SLACK", "with_direction"]

SLACK = 1e-14
"""Bending stiffness of a cable over axial stiffness times the square of its length: its sections need a direction.
Its influence on the shape is of this order over the strain of the cable, and grows with the square of the waves of a
vibration."""
GYRATION = 1e-5
"""Radius of gyration of a cable over its length, against rotation and twist: twist waves are as fast as those of
stretch, or each cable had slow vibrations of twist that mean nothing."""


def with_direction(stiffness: Floats, inertia: Floats, length: float) -> tuple[Floats, Floats]:
    """Return stiffness and inertia of a section of a rod; those of a cable with what gives its sections a direction."""
    if stiffness[3:].any():
        return stiffness, inertia
    bending, turning = SLACK * length**2, (GYRATION * length) ** 2
    inertia = inertia.copy()
    inertia[3:], inertia[:, 3:] = 0.0, 0.0
    return (
        stiffness + stiffness[2, 2] * np.diag([0, 0, 0, bending, bending, turning]),
        inertia + inertia[2, 2] * np.diag([0, 0, 0, turning, turning, turning]),
    )
