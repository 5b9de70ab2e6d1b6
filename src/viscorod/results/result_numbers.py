"""The numbers of a result as plain data, for ``--json`` and for other programs."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.results.equilibrium_result import Equilibrium
from viscorod.results.modes_result import Modes
from viscorod.results.result import Result
from viscorod.results.run import Run
from viscorod.results.steady_result import Steady
from viscorod.results.sweep_result import Sweep

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["numbers_of", "plain"]

_HIDDEN = ("case", "case_text", "checksums", "message")
_LONGEST = 200
"""Letters of the texts that are kept."""


def numbers_of(result: AnyResult | Sweep) -> dict[str, Any]:
    """Return what the report of a result tells, as dictionaries, lists, numbers and texts; SI units.

    Complex numbers are pairs, what is not finite is None. Of results without states all variables are there, each with
    its dimensions and its unit.
    """
    if isinstance(result, Sweep):
        table = result.table().reset_index()
        members = [dict(zip(table.columns, row, strict=True)) for row in table.itertuples(index=False)]
        notes = list(result.notes)
        return _dictionary({"kind": "sweep", "title": result.title, "members": members, "notes": notes})
    attrs = result.data.attrs
    found: dict[str, Any] = {"kind": result.kind, "title": result.title, "outcome": result.outcome}
    found["warnings"] = list(result.warnings)
    found |= {
        name: json.loads(value) if isinstance(value, str) and value[:1] in ("{", "[") else value
        for name, value in attrs.items()
        if name not in found and name not in _HIDDEN and _short(value)
    }
    if not isinstance(result, Result):
        found["variables"] = {
            str(name): {
                "dimensions": list(variable.dims),
                "unit": variable.attrs.get("units", ""),
                "values": variable.values,
            }
            for name, variable in result.data.variables.items()
        }
        return _dictionary(found)
    if isinstance(result, Run | Equilibrium | Steady):
        found["places"] = _places(result)
        found["mesh_errors"] = result.mesh_errors
    if isinstance(result, Run):
        found |= _of_run(result)
    elif isinstance(result, Equilibrium):
        found |= {
            "load_factors": result.load_factor,
            "elastic_energy": result.elastic_energy,
            "stable": result.stable,
        }
    elif isinstance(result, Steady):
        found |= {"eigenvalues": result.eigenvalues, "frequencies": result.frequencies}
        found |= {"damping_ratios": result.damping_ratios, "stable": result.stable}
    elif isinstance(result, Modes):
        found |= {"names": list(result.names), "eigenvalues": result.eigenvalues}
        found |= {"frequencies": result.frequencies, "damping_ratios": result.damping_ratios}
        found |= {"frequency_errors": result.frequency_errors, "certified": result.certified}
    else:
        found |= {"load_factors": result.load_factors}
    if "reaction" in result.data and result.data.sizes.get("support", 0):
        last = result.data["reaction"].isel({result.dimension: -1}).values
        names = map(str, result.data["support"].values)
        found["reactions"] = dict(zip(names, last, strict=True))
    return _dictionary(found)


def _dictionary(found: dict[str, Any]) -> dict[str, Any]:
    made: dict[str, Any] = plain(found)
    return made


def _short(value: object) -> bool:
    return not isinstance(value, str) or len(value) <= _LONGEST


def _places(result: Result) -> dict[str, dict[str, Any]]:
    """Return where the ends of rods and the bodies are in the last state [m]."""
    sites = result.sites
    known = [end for rod in sites.rods for end in sites.ends(rod)] + [sites.at(body) for body in sites.bodies]
    position, moved = (result.field(name, states=-1) for name in ("position", "displacement"))
    return {site.label: {"position": site.of(position), "displacement": site.of(moved)} for site in known}


def _of_run(run: Run) -> dict[str, Any]:
    site, axis = run.main_motion
    decay, energy = run.free_decay(site.label, axis), run.energy
    parts = ("kinetic", "elastic", "viscous", "external", "outside", "actuator", "numerical")
    found: dict[str, Any] = {"time": [run.time[0], run.time[-1]], "step_errors": run.step_errors}
    found["main_motion"] = {"place": site.label, "axis": axis}
    found["decay"] = decay and {
        "place": decay.place,
        "axis": decay.axis,
        "time": decay.time,
        "amplitude": decay.amplitude,
        "period": decay.period,
        "log_decrement": decay.log_decrement,
        "damping_ratio": decay.damping_ratio,
        "limit": dict(zip(("of", "damping_ratio"), decay.limit, strict=True)),
    }
    found["energy"] = {
        "start": energy.total[0],
        "end": {name: getattr(energy, name)[-1] for name in parts},
        "moved": energy.moved,
        "numerical_fraction": energy.numerical_fraction,
    }
    return found


def plain(value: Any) -> Any:
    """Return a value of dictionaries, lists, texts and numbers that JSON knows."""
    if isinstance(value, dict):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, str | int | bool):
        return value
    return json.loads(json.dumps(value, default=str))
