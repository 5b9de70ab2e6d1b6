"""The approximate theories by name, and what each of them leaves out (Artola, Wynn and Palacios, section IV)."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["EXACT", "THEORIES", "PlanarTheory"]

EXACT = "exact"
"""The word of the geometrically exact rod, with which the others are compared."""


class PlanarTheory(NamedTuple):
    """What a theory keeps of the planar rod; the axes of forces never turn.

    Attributes:
        shear: sections shear and have rotary inertia, (38)-(39); without it they stay normal to the centre line.
        stretching: deflections stretch the centre line, eps = u' + w'^2/2, (37); without it everything is linear.
        title: its name in reports.
    """

    shear: bool
    stretching: bool
    title: str


THEORIES: dict[str, PlanarTheory] = {
    "euler_bernoulli": PlanarTheory(shear=False, stretching=False, title="Euler-Bernoulli"),
    "timoshenko": PlanarTheory(shear=True, stretching=False, title="Timoshenko"),
    "von_karman": PlanarTheory(shear=False, stretching=True, title="von Karman"),
}
"""By their words, from the simplest on."""
