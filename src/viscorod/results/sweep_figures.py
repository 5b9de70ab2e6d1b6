"""Figures that every member of a sweep has, by its kind: its cost, how well its energy account closes, a first mode."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.energy import Energy
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.results.modes_result import Modes
from viscorod.results.run import Run

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["COLUMNS", "FIGURES", "SMALL_COLUMNS", "figures_of"]

REAL = 1e-9
"""Imaginary part of a root, as a part of it, below which it does not oscillate."""
FIGURES = {
    "steps": ("1", "steps taken"),
    "wall_time_s": ("s", "wall time"),
    "time_reached": ("s", "end of the motion"),
    "numerical_fraction": (
        "1",
        "largest numerical remainder of the energy account over the energy that moved",
    ),
    "first_frequency": ("Hz", "of the slowest vibration that oscillates"),
    "first_damping_ratio": ("1", "of the same"),
    "peak_frequency": ("Hz", "at which the first response is largest"),
    "peak": ("", "its size there"),
}
"""Variables of every member that are not fields -> (unit, long name)."""

_WALL = ("wall_time_s", "wall time [s]", "{:.3g}".format)
Column = tuple[str, str, Callable[[float], str]]
COLUMNS: tuple[Column, ...] = (
    ("steps", "steps", "{:.0f}".format),
    _WALL,
    ("numerical_fraction", "numerical [%]", lambda part: f"{100.0 * part:.2g}"),
)
SMALL_COLUMNS: tuple[Column, ...] = (
    ("first_frequency", "first frequency [Hz]", "{:.6g}".format),
    ("first_damping_ratio", "damping ratio", "{:.5g}".format),
    ("peak_frequency", "peak at [Hz]", "{:.6g}".format),
    ("peak", "peak", "{:.5g}".format),
    _WALL,
)
"""Figures of members in the table of a report: name, heading, format."""


def figures_of(result: AnyResult | None) -> dict[str, float]:
    """Return steps, wall time [s], the numerical part of a run's energy account, the first mode, the first peak."""
    if result is None:
        return {}
    attrs = result.data.attrs
    found = {name: float(attrs[name]) for name in ("steps", "wall_time_s") if name in attrs}
    if isinstance(result, Run):
        found["time_reached"] = float(result.time[-1])
        found["numerical_fraction"] = Energy.of(result.data).numerical_fraction
    if isinstance(result, Modes | FrequencyResponse):
        s = result.eigenvalues if isinstance(result, Modes) else result.poles
        s = s[s.imag > REAL * np.abs(s)]
        if len(s):
            first = s[np.argmin(np.abs(s))]
            found["first_frequency"] = float(np.abs(first) / (2.0 * np.pi))
            found["first_damping_ratio"] = float(-first.real / np.abs(first))
    if isinstance(result, FrequencyResponse):
        size = result.amplification()
        found["peak_frequency"] = float(result.frequencies[np.argmax(size)])
        found["peak"] = float(size.max())
    return found
