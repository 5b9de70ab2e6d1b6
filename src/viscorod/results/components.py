"""Components of strains and section forces: their words, units, and which of them matters most in a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.results.array_pieces import extremes
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result

STRAINS = {
    "shear_1": ("shear strain 1", "1"),
    "shear_2": ("shear strain 2", "1"),
    "stretch": ("stretch strain", "1"),
    "bend_1": ("curvature about d1", "1/m"),
    "bend_2": ("curvature about d2", "1/m"),
    "twist": ("twist", "1/m"),
}
FORCES = {
    "shear_1": ("shear force 1", "N"),
    "shear_2": ("shear force 2", "N"),
    "stretch": ("normal force", "N"),
    "bend_1": ("bending moment about d1", "N m"),
    "bend_2": ("bending moment about d2", "N m"),
    "twist": ("torque", "N m"),
}
"""Component of the data set -> name and unit of the strain or the section force."""


@dataclass(frozen=True)
class Component:
    """A scalar along the rods.

    Attributes:
        quantity: "strain", "section_force" or "dissipation"; index: its component, None of a dissipation.
        name, unit: in words.
    """

    quantity: str
    index: int | None
    name: str
    unit: str

    @property
    def short(self) -> str:
        """The last word of its name, its kind: "moment", "force", "curvature"."""
        return next(
            word
            for word in ("moment", "force", "curvature", "strain", "torque", "twist", "dissipation")
            if word in self.name
        )

    def of(self, field: Floats) -> Floats:
        """Return it from the whole quantity, components last."""
        return field if self.index is None else field[..., self.index]


def chosen_component(result: Result, quantity: str, component: str | None) -> Component:
    """Return a component; by default the one of the strain or section force that changes most.

    Forces are compared with moments by a tenth of the length of the longest rod, strains with curvatures by the half
    width (or a hundredth of that length).

    Raises:
        InputError: no such quantity or component in this result.
    """
    known = [name for name in ("strain", "section_force", "dissipation") if name in result.data]
    if quantity not in known:
        raise InputError(f"quantity = {quantity!r} is not stored; it can be {', '.join(known) or 'none'}")
    if not result.data.sizes["point"]:
        raise InputError(f"quantity = {quantity!r}: rods have it, and this model has rigid bodies alone")
    if quantity == "dissipation":
        if component is not None:
            raise InputError(f"component = {component!r}: dissipation has no components; leave it out")
        return Component(quantity, None, "dissipation per length", "W/m")
    table = STRAINS if quantity == "strain" else FORCES
    words = list(table)
    if component is None:
        arc = np.asarray(result.data["point_s"].values, dtype=float)
        length = float(np.max(arc))
        width = np.asarray(result.data["half_width"].values) if "half_width" in result.data else np.zeros(1)
        lever = 0.1 * length if quantity == "section_force" else float(np.max(width)) or 0.01 * length
        low, high = extremes(result, quantity)
        size = np.max(high - low if np.any(high > low) else np.abs(high), axis=0)
        weight = np.array([lever] * 3 + [1.0] * 3) if quantity == "section_force" else _lengths(lever)
        component = words[int(np.argmax(weight * size))]
    if component not in table:
        raise InputError(f"component = {component!r} is none; it can be {', '.join(words)}")
    return Component(quantity, words.index(component), *table[component])


def _lengths(lever: float) -> Floats:
    return np.array([1.0] * 3 + [lever] * 3)
