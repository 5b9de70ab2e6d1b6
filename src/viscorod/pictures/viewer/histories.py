"""Contents of the charts of a page: histories of places, reactions and joints, the energy account, the decay."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.results.data_schema import AXES
from viscorod.results.energy import Energy
from viscorod.results.run import Run
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.pictures.viewer.beside import Beside
    from viscorod.pictures.viewer.packing import Pack
    from viscorod.results.result import Result
    from viscorod.results.result_places import ResultPlace

__all__ = ["MOST_SAMPLES", "decay_of", "energy_of", "histories_of", "places_of", "samples_of"]

MOST_SAMPLES = 4000
"""Stored states in the charts at most; of more, see :func:`samples_of`."""
MOST_PLACES = 12
MOST_GROUPS = 24
_ROUND_OFF = 1e-9  # what is below this part of the largest of its kind is not shown
_STILL = 1e-9  # a place that moves by less than this part of the largest displacement is held
_PER_BUCKET = 5  # first, extremes of the main motion, extremes of the kinetic (or elastic) energy


def samples_of(result: Result) -> Integers:
    """Return the numbers of the stored states in the charts.

    Where there are too many, buckets of neighbouring states keep their first state and those in which the main
    motion and the energy are largest and smallest.
    """
    count = int(result.data.sizes[result.dimension])
    if count <= MOST_SAMPLES:
        return np.arange(count)
    site, axis = result.main_motion
    main = result.vector(site, "displacement")[:, AXES.index(axis)]
    energy = np.asarray(result.data["kinetic" if "kinetic" in result.data else "elastic"].values, dtype=float)
    edges = np.linspace(0, count, MOST_SAMPLES // _PER_BUCKET + 1).astype(np.int64)
    chosen = {0, count - 1}
    for start, stop in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        chosen.add(start)
        for curve in (main[start:stop], energy[start:stop]):
            chosen |= {start + int(np.argmin(curve)), start + int(np.argmax(curve))}
    return np.array(sorted(chosen), dtype=np.int64)


def places_of(result: Result) -> list[ResultPlace]:
    """Return places whose histories can be chosen: that of the main motion, then ends of rods, points of bodies."""
    sites = result.sites
    main, _ = result.main_motion
    found = {main.label: main}
    for place in (*sites.bodies, *(f"{rod}.{end}" for rod in sites.rods for end in ("end", "start"))):
        site = sites.at(place)
        found.setdefault(site.label, site)
    moved = np.max(np.abs(result.displacement_range), axis=(0, 2))
    least = _STILL * float(np.max(moved))
    moving = [site for site in found.values() if site is main or float(moved[site.stations].max()) > least]
    return moving[:MOST_PLACES]


def without_round_off(values: Floats, size: float) -> Floats:
    """Return columns ``(n, k)`` of which those that stay below what round-off of ``size`` makes are zero."""
    nothing = np.nan_to_num(np.abs(values)).max(axis=0, initial=0.0) < _ROUND_OFF * size
    shown: Floats = np.where(nothing & ~np.isnan(values), 0.0, values)
    return shown


def histories_of(result: Result, samples: Integers, pack: Pack, beside: Beside) -> list[dict[str, Any]]:
    """Return the groups of curves that can be chosen, and put their numbers into the page.

    Each group has a label, a unit, names of its curves, those of other results beside them, and the name of its array
    ``(curves, samples)``.
    """
    groups: list[dict[str, Any]] = []

    def add(
        label: str, unit: str, curves: list[str], values: Floats, place: str = "", size: float = 0.0
    ) -> None:
        if len(groups) >= MOST_GROUPS:
            return
        values = without_round_off(values, size)
        others = beside.curves(label, place, curves) if place else []
        if others:
            curves_of_others = np.stack([curve for _, curve in others], axis=1)
            values = np.concatenate([values, without_round_off(curves_of_others, size)], axis=1)
        factor, word = scaled(unit, values[:, : len(curves)])
        name = f"history{len(groups)}"
        pack.plain(name, factor * values.T)
        groups.append({"label": label, "unit": word, "curves": curves, "array": name, "place": place})
        groups[-1]["others"] = [told for told, _ in others]

    quantities: list[Any] = ["displacement"]
    quantities += ["velocity"] if "velocity" in result.data and result.dimension == "time" else []
    for quantity in quantities:
        unit = "m/s" if quantity == "velocity" else "m"
        known = [(site, result.vector(site, quantity)[samples]) for site in places_of(result)]
        size = max(float(np.abs(values).max()) for _, values in known)
        for site, values in known:
            add(f"{quantity} of {site.label}", unit, list(AXES), values, site.label, size)
    data = result.data
    if "reaction" in data:
        reactions = np.asarray(data["reaction"].values, dtype=float)[samples]
        forces, moments = (
            float(np.abs(part).max(initial=0.0)) for part in (reactions[..., :3], reactions[..., 3:])
        )
        length = float(np.abs(result.field("position", states=-1)).max()) or 1.0
        forces, moments = max(forces, moments / length), max(moments, forces * length)
        for k, name in enumerate(np.asarray(data["support"].values, dtype=str).tolist()):
            add(f"force of support {name}", "N", list(AXES), reactions[:, k, :3], size=forces)
            add(f"moment of support {name}", "N m", list(AXES), reactions[:, k, 3:], size=moments)
    if "joint" in data.coords:
        held = np.asarray(data["joint_held"].values, dtype=bool)
        words = np.asarray(data["joint_motion"].values, dtype=str)
        for k, name in enumerate(np.asarray(data["joint"].values, dtype=str).tolist()):
            turning = words[k].startswith("r")
            value = np.asarray(data["joint_value"].values, dtype=float)[samples, k : k + 1]
            force = np.asarray(data["joint_force"].values, dtype=float)[samples, k : k + 1]
            if not held[k] or np.ptp(value) > 1e-9:
                add(f"{words[k]} of {name}", "rad" if turning else "m", [words[k]], value)
            if force.any():
                what = "moment" if turning else "force"
                add(f"{what} along {words[k]} of {name}", "N m" if turning else "N", [words[k]], force)
    return groups


def energy_of(result: Result, samples: Integers, pack: Pack) -> dict[str, Any]:
    """Return the energy account for its chart: names of what is stacked, unit, and how well it closes."""
    if isinstance(result, Run):
        account: Energy = result.energy
        stacked = [("lost to viscosity", account.viscous), ("elastic", account.elastic)]
        if account.outside.any():
            stacked.insert(0, ("lost to drag", account.outside))
        stacked.append(("kinetic", account.kinetic))
        supplied = account.supplied
        factor, unit = scaled("J", np.maximum(np.sum([v for _, v in stacked], axis=0), supplied))
        rows = np.stack([*(values for _, values in stacked), supplied, account.numerical])
        pack.plain("energy", factor * rows[:, samples])
        return {
            "stacked": [name for name, _ in stacked],
            "unit": unit,
            "line": "initial energy + work done",
            "fraction": account.numerical_fraction,
            "moved": factor * account.moved,
        }
    elastic = np.asarray(result.data["elastic"].values, dtype=float)
    factor, unit = scaled("J", elastic)
    pack.plain("energy", factor * elastic[None, samples])
    return {"stacked": ["elastic"], "unit": unit}


def decay_of(result: Result) -> dict[str, Any] | None:
    """Return the cycles of the main motion, None where it does not decay regularly."""
    if not isinstance(result, Run):
        return None
    site, axis = result.main_motion
    found = result.free_decay(site.label, axis)
    if found is None:
        return None
    name, limit = found.limit
    factor, unit = scaled("m", found.amplitude)
    return {
        "place": site.label,
        "axis": axis,
        "time": found.time.tolist(),
        "ratio": found.damping_ratio.tolist(),
        "period": found.period.tolist(),
        "amplitude": (factor * found.amplitude).tolist(),
        "unit": unit,
        "limit": limit,
        "limit_name": name,
        "scattered": found.scattered,
    }
