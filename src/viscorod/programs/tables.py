"""Rows of the tables that ``viscorod damping convert`` prints."""

from __future__ import annotations

from typing import TypeAlias

from viscorod.model.materials.material import Material
from viscorod.programs.conversions import (
    critical_frequency,
    damping_ratio,
    log_decrement,
    loss_factor,
    quality_factor,
)
from viscorod.programs.rayleigh import rayleigh_for_constant_ratio

__all__ = ["Row", "law_row", "material_rows", "rayleigh_rows"]

Row: TypeAlias = dict[str, object]


def law_row(word: str, time: float, frequency: float | None, viscosity: float | None = None) -> Row:
    """Return all numbers of a time: the viscosity where it is known, and the numbers at a frequency (Hz)."""
    ratio = damping_ratio(time, 1.0 if frequency is None else frequency)
    row: Row = {"law": word, "time [s]": time}
    if viscosity is not None:
        row["viscosity [Pa s]"] = viscosity
    if frequency is not None:
        row["loss factor"] = loss_factor(time, frequency)
        row["damping ratio"] = ratio
        row["log decrement"] = log_decrement(ratio) if ratio < 1.0 else "overdamped"
        row["Q"] = quality_factor(ratio)
    row["critical from [Hz]"] = critical_frequency(time) if time > 0.0 else "never"
    row["Rayleigh alpha [1/s]"] = 0.0
    row["Rayleigh beta [s]"] = time
    return row


def material_rows(material: Material, frequency: float | None) -> list[Row]:
    """Return rows for shear (and twist), extension (and bending), and volume change."""
    return [
        law_row("shear, twist", material.shear_time, frequency, material.shear_viscosity),
        law_row("stretch, bending", material.extensional_time, frequency, material.extensional_viscosity),
        law_row("volume change", material.bulk_time, frequency, material.bulk_viscosity),
    ]


def rayleigh_rows(time: float, frequency: float, band: tuple[float, float]) -> list[Row]:
    """Return Rayleigh constants over a band (Hz) for a Kelvin-Voigt law, and for its ratio kept constant."""
    ratio = damping_ratio(time, frequency)
    constant = rayleigh_for_constant_ratio(ratio, *band)
    return [
        {"wanted": "this law", "alpha [1/s]": 0.0, "beta [s]": time, "largest error of the ratio": 0.0},
        {
            "wanted": f"the ratio {ratio:.6g} everywhere",
            "alpha [1/s]": constant.alpha,
            "beta [s]": constant.beta,
            "largest error of the ratio": constant.largest_error,
        },
    ]
