"""Moduli from what tables have in their place: complex compliances and complex viscosities.

M* = 1/(J' - i J''), and M* = i omega (eta' - i eta''), with M* = M' + i M'' (J. D. Ferry, Viscoelastic Properties of
Polymers, chapter 1).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from viscorod.model.materials.column_names import Heading
from viscorod.typing import Floats

__all__ = ["IN_THEIR_PLACE", "enough", "moduli_of", "spared"]

_COMPLIANCES = {"storage_compliance", "loss_compliance", "complex_compliance"}
_OF_VISCOSITY = {
    "viscosity": "loss",
    "out_of_phase_viscosity": "storage",
    "complex_viscosity": "complex",
}
"""Columns that are a modulus over the angular frequency."""
IN_THEIR_PLACE = frozenset({*_COMPLIANCES, *_OF_VISCOSITY})
_ANGLES = {"tan_delta", "phase"}


def _of_moduli(kinds: set[str]) -> bool:
    return bool((kinds & {"storage", "loss", "complex"} and kinds & _ANGLES) or {"storage", "loss"} <= kinds)


def enough(kinds: set[str]) -> bool:
    """Return whether kinds of columns give a complex modulus."""
    viscous = {_OF_VISCOSITY[kind] for kind in kinds & set(_OF_VISCOSITY)}
    compliant = kinds & _COMPLIANCES
    return (
        _of_moduli(kinds)
        or _of_moduli(viscous | kinds & _ANGLES)
        or bool(compliant and kinds & _ANGLES)
        or {"storage_compliance", "loss_compliance"} <= kinds
    )


def spared(columns: dict[int, Heading]) -> dict[int, Heading]:
    """Return the columns without compliances and viscosities where there are moduli."""
    if not _of_moduli({known.kind for known in columns.values()}):
        return columns
    return {at: known for at, known in columns.items() if known.kind not in IN_THEIR_PLACE}


def moduli_of(values: Mapping[str, Floats], omega: Floats, tangent: Floats) -> dict[str, Floats]:
    """Return what the columns in the place of moduli say: storage, loss or complex modulus, Pa (n,) each.

    Args:
        values: by kind, SI (n,); omega: rad/s (n,); tangent: loss over storage, nan where it is not known.
    """
    found = {_OF_VISCOSITY[kind]: omega * values[kind] for kind in _OF_VISCOSITY if kind in values}
    real, imaginary = values.get("storage_compliance"), values.get("loss_compliance")
    if real is not None and imaginary is not None:
        square = real**2 + imaginary**2
        found |= {"storage": real / square, "loss": imaginary / square}
    elif "complex_compliance" in values:
        found["complex"] = 1.0 / values["complex_compliance"]
    elif real is not None:
        found["complex"] = 1.0 / (real * np.hypot(1.0, tangent))
    elif imaginary is not None:
        found["complex"] = tangent / (imaginary * np.hypot(1.0, tangent))
    return found
