"""Units of the columns of measured tables."""

from __future__ import annotations

import math

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.materials.column_names import MEASURE, Heading, unit_of

__all__ = ["FREQUENCY_UNITS", "MODULUS_UNITS", "NOUNS", "factor", "refuse_unit"]

FREQUENCY_UNITS = {
    "Hz": 2.0 * math.pi,
    "kHz": 2e3 * math.pi,
    "rad/s": 1.0,
    "mHz": 2e-3 * math.pi,
    "MHz": 2e6 * math.pi,
}
"""Angular frequency [rad/s] of the unit."""
MODULUS_UNITS = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "N/mm2": 1e6,
    "N/m2": 1.0,
    "psi": 6894.757293168361,
    "ksi": 6894757.293168361,
    "bar": 1e5,
    "dyn/cm2": 0.1,
}
"""Pa of the unit."""

_FACTORS = {
    "frequency": FREQUENCY_UNITS,
    "modulus": MODULUS_UNITS,
    "ratio": {"1": 1.0, "%": 0.01},
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0},
    "compliance": {"1/Pa": 1.0, "1/kPa": 1e-3, "1/MPa": 1e-6, "1/GPa": 1e-9},
    "viscosity": {"Pa s": 1.0, "mPa s": 1e-3, "kPa s": 1e3, "MPa s": 1e6, "P": 0.1},
    "temperature": {"C": 1.0, "K": 1.0, "F": 1.0},
}
NOUNS = {
    "frequency": "frequency",
    "angular": "angular frequency",
    "storage": "storage modulus",
    "loss": "loss modulus",
    "complex": "complex modulus",
    "tan_delta": "tan delta",
    "phase": "phase angle",
    "storage_compliance": "storage compliance",
    "loss_compliance": "loss compliance",
    "complex_compliance": "complex compliance",
    "viscosity": "dynamic viscosity",
    "out_of_phase_viscosity": "out-of-phase viscosity",
    "complex_viscosity": "complex viscosity",
}


def refuse_unit(known: Heading, unit: str) -> None:
    """Refuse a unit that is not known for a column.

    Raises:
        RefusedError: always.
    """
    allowed = _FACTORS[MEASURE[known.kind]]
    raise RefusedError(
        f"the unit {show(unit.strip('[]()'))} of the column of {NOUNS.get(known.kind, known.kind)} is not known",
        f"use one of {', '.join(allowed)}",
    )


def factor(known: Heading, given: dict[str, str | None]) -> float:
    """Return the SI value of the unit of a column, from the file or a key, and refuse neither or both."""
    measure = MEASURE[known.kind]
    noun = NOUNS.get(known.kind, known.kind)
    unit = None
    if known.unit is not None:
        unit = unit_of(known.unit, measure)
        if unit == "1/s" and known.kind == "angular":
            unit = "rad/s"
        if unit is None or unit == "1/s":
            refuse_unit(known, known.unit)
    if measure == "ratio":
        return _FACTORS[measure][unit or "1"]
    if measure in given:
        key, wanted = f"{measure}_unit", given[measure]
        if unit is None and known.kind == "angular" and wanted is None:
            unit = "rad/s"
        if wanted is not None and unit not in (None, wanted) and known.kind != "angular":
            raise RefusedError(
                f"the file gives the {noun} in {unit}, and {key} says {wanted}", f"leave {key} out"
            )
        unit = unit or wanted
        if unit is None:
            raise RefusedError(
                f"the file does not give the unit of the column of {noun}",
                f"write it beside the name, or give {key}",
            )
        if known.kind == "angular" and unit != "rad/s":
            raise RefusedError(
                f"{known.text} is called an angular frequency and has the unit {unit}",
                "name it frequency, or give it in rad/s",
            )
    elif unit is None:
        raise RefusedError(
            f"the file does not give the unit of the column of {noun}", "write it beside the name"
        )
    assert unit is not None
    return _FACTORS[measure][unit]
