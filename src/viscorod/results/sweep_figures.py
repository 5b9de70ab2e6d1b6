"""Figures of the members of a sweep: a few numbers of each result, by which they are compared."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.results.buckling import Buckling
from viscorod.results.campbell import Campbell
from viscorod.results.followed_modes import FollowedModes
from viscorod.results.frequency_response import FrequencyResponse
from viscorod.results.mesh_error import mesh_errors
from viscorod.results.modes_result import Modes
from viscorod.results.periodic import Periodic
from viscorod.results.recorded_states import RecordedStates
from viscorod.results.result import Result
from viscorod.results.run import Run

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["FIGURES", "figures_of", "shown"]

REAL = 1e-9
"""Imaginary part of a root, as a part of it, below which it does not oscillate."""


class Figure(NamedTuple):
    """One number of a result.

    Attributes:
        unit, words: what it is; heading, show: of its column in a table, and how it is written there.
    """

    unit: str
    words: str
    heading: str
    show: Callable[[float], str]


FIGURES = {
    "first_frequency": Figure(
        "Hz", "of the slowest vibration that oscillates", "first frequency [Hz]", "{:.6g}".format
    ),
    "first_damping_ratio": Figure("1", "of the same", "damping ratio", "{:.5g}".format),
    "peak_frequency": Figure("Hz", "at which the first response is largest", "peak at [Hz]", "{:.6g}".format),
    "peak": Figure("", "its size there", "peak", "{:.5g}".format),
    "first_critical_speed": Figure(
        "rad/s", "at which a frequency is a multiple of the speed", "critical speed [rad/s]", "{:.6g}".format
    ),
    "first_critical_load": Figure(
        "1", "load factor at which the model gives way", "critical load factor", "{:.6g}".format
    ),
    "first_limit": Figure(
        "", "speed [rad/s] or load factor at which a mode begins to grow", "grows from", "{:.6g}".format
    ),
    "steps": Figure("1", "steps taken", "steps", "{:.0f}".format),
    "wall_time_s": Figure("s", "wall time", "wall time [s]", "{:.3g}".format),
    "time_reached": Figure("s", "end of the motion", "until [s]", "{:.6g}".format),
    "mesh_error": Figure(
        "1", "estimated error of positions by the mesh, over the length", "mesh error", "{:.1g}".format
    ),
    "frequency_error": Figure(
        "1", "estimated error of the frequencies by the mesh, in parts of them", "mesh error", "{:.1g}".format
    ),
    "critical_load_error": Figure(
        "1",
        "estimated error of the critical loads by the mesh, in parts of them",
        "mesh error",
        "{:.1g}".format,
    ),
    "step_error": Figure("m", "estimated error of positions by the steps", "step error [m]", "{:.1g}".format),
    "numerical_fraction": Figure(
        "1",
        "largest numerical remainder of the energy account over the energy that moved",
        "numerical [%]",
        lambda part: f"{100.0 * part:.2g}",
    ),
}
"""All of them, in the order of the columns of a table; they are variables of a sweep's data set too."""
OF_STATES = ("steps", "numerical_fraction", "time_reached", "mesh_error", "step_error")
"""Figures that say little beside others."""


def figures_of(result: AnyResult | None) -> dict[str, float]:
    """Return the figures of a result by name; none of no result."""
    if result is None:
        return {}
    attrs = (result.stored if isinstance(result, RecordedStates) else result.data).attrs
    found = {name: float(attrs[name]) for name in ("steps", "wall_time_s") if name in attrs}
    if isinstance(result, Result) and (mesh := mesh_errors(result)):
        found["mesh_error"] = max(mesh.values())
    if isinstance(result, Run):
        steps = result.step_errors
        found |= {"step_error": steps["position"]} if "position" in steps else {}
        found["time_reached"] = float(result.time[-1])
        found["numerical_fraction"] = result.energy.numerical_fraction
    found |= _errors_by_mesh(result)
    if isinstance(result, Modes | FrequencyResponse):
        found |= _slowest(result.eigenvalues if isinstance(result, Modes) else result.poles)
    if isinstance(result, Periodic | FrequencyResponse):
        _, found["peak_frequency"], found["peak"] = result.summit()
    return found | _first(result)


def _errors_by_mesh(result: AnyResult) -> dict[str, float]:
    """Return the largest estimated error by the mesh of a result without states; none where it was not estimated."""
    known = {
        "frequency_error": result.frequency_errors if isinstance(result, Modes) else np.zeros(0),
        "critical_load_error": result.errors if isinstance(result, Buckling) else np.zeros(0),
    }
    found = {name: float(errors.max()) for name, errors in known.items() if len(errors)}
    if isinstance(result, Periodic | FrequencyResponse) and (
        error := result.data.attrs.get("frequency_error")
    ):
        found["frequency_error"] = float(error)
    return found


def _first(result: AnyResult) -> dict[str, float]:
    """Return the first critical speed, critical load and limit of stability that a result has."""
    known = {
        "first_critical_speed": [one.speed for one in result.critical_speeds]
        if isinstance(result, Campbell)
        else [],
        "first_limit": [one.at for one in result.limits if one.unstable]
        if isinstance(result, FollowedModes)
        else [],
        "first_critical_load": result.load_factors.tolist() if isinstance(result, Buckling) else [],
    }
    return {name: float(values[0]) for name, values in known.items() if values}


def _slowest(s: np.ndarray) -> dict[str, float]:
    """Return frequency [Hz] and damping ratio of the slowest root that oscillates."""
    s = s[s.imag > REAL * np.abs(s)]
    if not len(s):
        return {}
    first = s[np.argmin(np.abs(s))]
    return {
        "first_frequency": float(np.abs(first) / (2.0 * np.pi)),
        "first_damping_ratio": 0.0 - float(first.real / np.abs(first)),  # no -0 of what is not damped
    }


def shown(rows: list[dict[str, float]]) -> list[str]:
    """Return the names of the figures that a table of members has: those of any member, without what says little."""
    known = [name for name in FIGURES if any(name in row for row in rows)]
    telling = [name for name in known if name not in (*OF_STATES, "wall_time_s")]
    return [name for name in known if not telling or name not in OF_STATES if name != "time_reached"]
