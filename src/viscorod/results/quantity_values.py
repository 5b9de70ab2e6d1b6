"""Numbers of a result that words stand for: fields at places, reduced over time, decays, frequencies, energies."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import InputError
from viscorod.results.components import STRAINS
from viscorod.results.data_schema import AXES, LABELS

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult
    from viscorod.results.between_records import Instants
    from viscorod.results.followed_modes import FollowedModes
    from viscorod.results.result import Result
    from viscorod.typing import Floats

__all__ = [
    "FIELDS",
    "HISTORY",
    "HISTORY_TIMES",
    "OTHERS",
    "REDUCTIONS",
    "SIZE",
    "Number",
    "Word",
    "field_value",
    "unit_of",
]

Number: TypeAlias = float | list[float]
"""Value of a quantity: a number, or those of a history."""
Word: TypeAlias = str | float
"""One word of a quantity."""

HISTORY = "history"
HISTORY_TIMES = 201
"""Instants of a history, equally spaced from 0 to the end of the motion."""

_DIRECTORS = ("d1", "d2", "d3")
SIZE = "size"
FIELDS: dict[str, tuple[str, ...]] = {
    "position": AXES,
    "displacement": AXES,
    "velocity": AXES,
    "angular_velocity": _DIRECTORS,
    "strain": tuple(STRAINS),
    "section_force": tuple(STRAINS),
    "dissipation": (),
    "reaction": tuple(LABELS["motion"]),
}
"""What can be read at a place -> its components; vectors of three have a size too."""
_UNITS = {
    "position": "m",
    "displacement": "m",
    "velocity": "m/s",
    "angular_velocity": "rad/s",
    "dissipation": "W/m",
    "energy": "J",
    "frequency": "Hz",
    "peak_frequency": "Hz",
}
"""SI units by first word, of what has one whatever the other words are."""
_OF_COMPONENTS = {"strain": ("1", "1/m"), "section_force": ("N", "N m"), "reaction": ("N", "N m")}
"""SI units of the first three and of the last three components."""


def unit_of(words: tuple[Word, ...]) -> str:
    """Return the SI unit of what words read; empty where it has none or the words do not say it."""
    head = str(words[0]) if words else ""
    if head not in _OF_COMPONENTS:
        return _UNITS.get(head, "")
    unit = _OF_COMPONENTS[head][FIELDS[head].index(str(words[2])) // 3]
    return "" if unit == "1" else unit


def _mean(t: Floats, x: Floats) -> float:
    return float(np.trapezoid(x, t) / (t[-1] - t[0])) if t[-1] > t[0] else float(x[0])


REDUCTIONS: dict[str, Callable[[Floats, Floats], float]] = {
    "first": lambda _, x: float(x[0]),
    "last": lambda _, x: float(x[-1]),
    "min": lambda _, x: float(x.min()),
    "max": lambda _, x: float(x.max()),
    "max_abs": lambda _, x: float(np.abs(x).max()),
    "range": lambda _, x: float(x.max() - x.min()),
    "mean": _mean,
    "rms": lambda t, x: math.sqrt(_mean(t, x * x)),
}
"""What makes a number of a history: of stored states, means by the trapezoidal rule over time."""


def field_value(result: AnyResult, words: tuple[Word, ...]) -> Number:
    """Return what is read at a place, reduced."""
    from viscorod.results.probe import instants_of
    from viscorod.results.run import Run

    head, place, how = str(words[0]), str(words[1]), words[-1]
    component = str(words[2]) if FIELDS[head] else ""
    found: Any = result
    along: Floats = np.asarray(found.stored[found.dimension].values, dtype=float)
    instants = None
    if head == "reaction":
        values = _reaction(found, place)
    else:
        if isinstance(result, Run) and isinstance(how, float):
            instants = instants_of(result, how)
        elif isinstance(result, Run) and how == HISTORY:
            instants = instants_of(result, np.linspace(0.0, result.time[-1], HISTORY_TIMES))
        values = _at(found, place, head, instants)
    if component == SIZE:
        values = np.linalg.norm(values, axis=-1)
    elif component:
        values = values[:, FIELDS[head].index(component)]
    if not np.isfinite(values).all():
        raise InputError(f"{head} of {place} is not finite")
    if how == HISTORY:
        return [float(value) for value in values]
    return float(values[0]) if isinstance(how, float) else REDUCTIONS[how](along, values)


def _at(result: Result, place: str, head: str, instants: Instants | None) -> Floats:
    """Return a field at a place, in stored states or at instants."""
    from viscorod.results.probe import fields_at

    site = result.sites.at(place)
    if instants is None and head in ("position", "displacement"):  # no other field is read
        return result.vector(site, "position" if head == "position" else "displacement")
    fields = fields_at(result, [site], instants)
    if head not in fields:
        raise InputError(f"{head} is not known at {place}")
    return fields[head][:, 0]


def _reaction(result: Result, place: str) -> Floats:
    stored = result.stored
    known = [str(name) for name in stored["support"].values] if "reaction" in stored else []
    if place not in known:
        raise InputError(f"{place} has no support; there are {', '.join(known) or 'none'}")
    values: Floats = stored["reaction"].values[:, known.index(place)]
    return values


def _decay(result: Any, words: Sequence[Word]) -> float:
    place, axis, what = map(str, words[:3])
    found = result.decay(place, axis)
    if len(words) == 3 and not found.regular:
        raise InputError(
            f"{place} along {axis} does not decay regularly over three maxima or more; simulate longer, or name a cycle"
        )
    if len(words) == 3:
        if what == "damping_ratio":
            return float(found.limit[1])
        return float(np.mean(getattr(found, what))) if what != "amplitude" else float(found.amplitude[0])
    values, cycle = getattr(found, what), int(words[3])
    if cycle > len(values):
        raise InputError(f"{place} along {axis} has {len(values)} cycles; there is no cycle {cycle}")
    return float(values[cycle - 1])


_LISTED: dict[str, Callable[[Any], Any]] = {
    "load_factor": lambda result: result.load_factors,
    "critical_speed": lambda result: [one.speed for one in result.critical_speeds],
    "limit": lambda result: [one.at for one in result.limits if one.unstable],
}
"""What has numbers, and no names."""
_FOLLOWED = {"frequency": "frequencies", "damping_ratio": "damping_ratios"}
"""What modes have at every value of the parameter that they are followed along."""


def _row_of(result: FollowedModes, at: float) -> int:
    """Return which of the values of the parameter is meant."""
    known = result.values
    near = int(np.argmin(np.abs(known - at)))
    if not math.isclose(known[near], at, rel_tol=1e-9, abs_tol=1e-9 * float(np.abs(known).max())):
        told = f"{', '.join(f'{value:g}' for value in known[:8])}{', ...' if len(known) > 8 else ''}"
        raise InputError(f"nothing is computed at {at:g}; modes are followed at {told}")
    return near


def _numbered(what: str) -> Callable[[Any, Sequence[Word]], float]:
    """Return what reads a number of a mode, a pole or a critical load, by its number or name."""

    def read(result: Any, words: Sequence[Word]) -> float:
        word = words[0]
        if what in _LISTED:
            values = _LISTED[what](result)
        elif len(words) > 1:
            values = getattr(result, _FOLLOWED[what])[_row_of(result, float(words[1]))]
        elif hasattr(result, "poles"):
            s = result.poles
            values = np.abs(s) / (2.0 * np.pi) if what == "frequency" else -s.real / np.abs(s)
        else:
            values = result.frequencies if what == "frequency" else result.damping_ratios
        if isinstance(word, str):
            names = _names(result)
            if word not in names:
                raise InputError(f"there is no {word!r}; there are {', '.join(names) or 'numbers only'}")
            return float(values[names.index(word)])
        if word > len(values):
            from viscorod.results.modes_result import Modes

            sought = isinstance(result, Modes)
            more = f"; modes.count = {word:g} seeks more of them" if sought else ""
            there = f"there are {len(values)}; there is no number {word:g}{more}"
            raise InputError(there if len(values) else "there is none")
        return float(values[int(word) - 1])

    return read


def _names(result: Any) -> list[str]:
    """Return the names of modes or poles, which follow from shapes: a sixth of a small search for modes."""
    if hasattr(result, "poles"):
        return [str(name) for name in result.data["pole_name"].values]
    if hasattr(result, "names"):
        return list(result.names)
    modes = result.modes  # of a steady rotation, or names of those that are followed
    return list(getattr(modes, "names", modes))


def _peak(what: str) -> Callable[[Any, Sequence[Word]], float]:
    """Return what reads the largest size of a response, or where it is."""

    def read(result: Any, words: Sequence[Word]) -> float:
        given = [int(word) if isinstance(word, float) else word for word in words]
        top = result.summit(*given)
        return float(top.amplitude if what == "peak" else top.frequency)

    return read


def _energy(result: Any, words: Sequence[Word]) -> float:
    account = result.energy
    values = np.broadcast_to(getattr(account, str(words[0])), account.time.shape)
    return REDUCTIONS[str(words[1])](account.time, values)


OTHERS: dict[str, Callable[[Any, Sequence[Word]], float]] = {
    "decrement": _decay,
    "energy": _energy,
    "frequency": _numbered("frequency"),
    "damping_ratio": _numbered("damping_ratio"),
    "load_factor": _numbered("load_factor"),
    "critical_speed": _numbered("critical_speed"),
    "limit": _numbered("limit"),
    "peak": _peak("peak"),
    "peak_frequency": _peak("peak_frequency"),
}
"""First word of what is no field at a place -> what reads it from the other words."""
