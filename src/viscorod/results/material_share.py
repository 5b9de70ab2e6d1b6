"""How much of a measured damping can be the material's at most.

All that damps a structure adds up: its supports, the air and its joints take what the material does not. A mode
therefore bounds the damping of the material from above, and so do several modes, by a law: a flat loss factor eta gives
all modes of a uniform structure the ratio eta/2, the time tau of Kelvin and Voigt gives omega tau/2. The mode with the
least room is the bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.typing import Floats

__all__ = ["AtMost", "material_at_most", "material_text"]


@known_arguments
@dataclass(frozen=True)
class AtMost:
    """The most that a law of the material can have.

    Attributes:
        law: "flat_loss" or "kelvin_voigt".
        value: its loss factor, or its extensional time, s, at most.
        mode: number from 1 of the mode that says so.
    """

    law: str
    value: float
    mode: int


def material_at_most(frequencies: Floats, ratios: Floats, widths: Floats) -> list[AtMost]:
    """Return the most that a flat loss factor and a Kelvin-Voigt time can be, by the upper ends of ratios' intervals.

    Args:
        frequencies: Hz (k,); ratios: damping ratios (k,); widths: halves of their 95 % intervals (k,).
    """
    most = np.maximum(np.asarray(ratios) + np.asarray(widths), 0.0)
    bounds = {"flat_loss": 2.0 * most, "kelvin_voigt": most / (np.pi * np.asarray(frequencies))}
    return [AtMost(law, float(b.min()), int(np.argmin(b)) + 1) for law, b in bounds.items()]


def material_text(found: list[AtMost]) -> str:
    """Return this in words."""
    flat, time = found
    return (
        "At most this can be the material's, if nothing else damps (by the upper ends of the intervals): a flat loss "
        f"factor of {flat.value:.3g} (mode {flat.mode}), or a Kelvin-Voigt time of {time.value:.3g} s "
        f"(mode {time.mode})."
    )
