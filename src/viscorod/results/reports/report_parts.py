"""What the reports of motions, equilibria and steady rotations have in common."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from viscorod.errors import InputError
from viscorod.results.damping_validity import damping_validity
from viscorod.results.largest_stress import largest_stress
from viscorod.results.reports.effort import MOST_NAMES
from viscorod.results.result_warnings import warnings_of
from viscorod.results.text_numbers import number, quantity, scaled
from viscorod.results.text_table import listed, numbers, tabulated, words
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.result import Result
    from viscorod.results.result_places import ResultPlace
    from viscorod.results.run import Run
    from viscorod.results.steady_result import Steady
    from viscorod.results.validity import Validity

__all__ = [
    "drift",
    "ends",
    "heading",
    "load_level",
    "named_sites",
    "places",
    "reactions",
    "stress",
    "validity",
    "vector",
    "warnings",
]


def heading(result: Result, summary: str) -> str:
    """Return the title of the case, what was computed, and what stopped it."""
    lines = [result.title] if result.title else []
    lines.append(summary)
    if result.outcome != "completed":
        lines.append(
            f"stopped early ({result.outcome}): {result.stored.attrs.get('message', '')}".rstrip(": ")
        )
    return "\n".join(lines)


def ends(result: Result, title: str, state: int) -> str:
    """Return where the ends of the rods and the bodies are in a state."""
    position = result.field("position", states=state)
    displacement = result.field("displacement", states=state)
    size = float(np.max(np.abs(position)))
    sites = named_sites(result)
    where, moved = (
        np.array([site.of(field) for site in sites]).reshape(-1, 3) for field in (position, displacement)
    )
    return tabulated(
        f"{title}: position, and displacement from the reference shape",
        words("place", [site.label for site in sites]),
        numbers(("x", "y", "z"), "m", where, size=size),
        numbers(("moved x", "y", "z"), "m", moved, size=size),
    )


def named_sites(result: Result, *, points: bool = True) -> list[ResultPlace]:
    """Return the ends of the rods and the places on bodies; ``points`` False leaves named points out."""
    sites = result.sites
    bodies = [sites.at(place) for place in sites.bodies if points or "." not in place]
    return [end for rod in sites.rods for end in sites.ends(rod)] + bodies


def places(result: Result) -> str:
    """Return what has a line in the tables of places."""
    return "Rod ends and bodies" if result.sites.bodies else "Rod ends"


def reactions(equilibrium: Equilibrium | Steady) -> str:
    """Return forces and moments of the supports."""
    if "reaction" not in equilibrium.stored or equilibrium.stored.sizes.get("support", 0) == 0:
        return ""
    names = equilibrium.stored["support"].values
    values = equilibrium.stored["reaction"].isel({equilibrium.dimension: -1}).values
    size = float(np.max(np.abs(equilibrium.field("position", states=-1))))
    force, moment = (float(np.max(np.abs(part))) for part in (values[:, :3], values[:, 3:]))
    force = max(force, moment / size) if size > 0.0 else force  # round-off of either spoils both
    moment = max(moment, force * size)
    return tabulated(
        "Reactions of the supports",
        words("support", map(str, names)),
        numbers(("fx", "fy", "fz"), "N", values[:, :3], size=force),
        numbers(("mx", "my", "mz"), "N m", values[:, 3:], size=moment),
    )


def validity(result: Result, judged: Validity) -> str:
    """Tell the conditions of a rod model, each with its number, and whether the motion kept to the bands of losses."""
    lines = [str(judged)] if judged.conditions else []
    return "\n".join([*lines, *_band_notes(result)])


def _band_notes(result: Result) -> list[str]:
    """Say which rods moved beyond the band over which their loss factor is followed."""
    if result.kind != "simulate" or "damping_laws" not in result.stored.attrs:
        return []
    try:
        notes = damping_validity(cast("Run", result)).notes
    except InputError:  # too short for a spectrum
        return []
    return [note for note in notes if "loss factor" in note]


def stress(result: Result) -> str:
    """Report the largest von Mises stress, and where it is."""
    found = largest_stress(result)
    if found is None or not found.value:
        return ""
    place = result.sites.along(found.rod, found.s).label
    factor, unit = scaled("m", found.point)
    x, y = vector(factor * np.array(found.point), factor * (max(map(abs, found.point)) or 1.0))
    when = {
        "time": f" at {quantity(found.level, 's')}",
        "load_factor": f" under {load_level(found.level)}",
    }
    text = (
        f"Largest von Mises stress {quantity(found.value, 'Pa')}, {place}, at ({x}, {y}) {unit} of the section along "
        f"d1, d2{when.get(result.dimension, '')}"
    )
    if found.missing:
        more = f" and {len(found.missing) - MOST_NAMES} more" if len(found.missing) > MOST_NAMES else ""
        names = ", ".join(found.missing[:MOST_NAMES])
        text += f"\n  (not of {names}{more}: sections without a known shape, or with a law)"
    return text


def drift(result: Result) -> str:
    """Tell how far joints and held strains are from what they hold."""
    attrs = result.stored.attrs
    if "drift_position" not in attrs:
        return ""
    return (
        f"Joints and held strains: largest violation {attrs['drift_position']:.2g} (positions, over the size), "
        f"{attrs['drift_velocity']:.2g} (velocities)"
    )


def load_level(factor: float, digits: int = 6) -> str:
    """Return a load factor in words: a part of the loads, or a multiple of small reference loads."""
    if factor == 1.0:
        return "all of the loads"
    if abs(factor) <= 10.0:
        return f"{100.0 * factor:.{digits}g} % of the loads"
    return f"{factor:.{digits}g} times the loads"


def warnings(result: Result, judged: Validity) -> str:
    """Return what the result says against itself, beside the conditions of a rod model that it does not keep."""
    found = warnings_of(result)
    none = "No warnings" if judged.valid else "No warnings beside what the rod model does not keep (NO above)"
    return listed("Warnings", found) if found else none


def vector(values: Floats, scale: float) -> list[str]:
    """Format numbers with six digits; round-off against ``scale`` becomes 0."""
    return [number(float(value), size=scale) for value in values]
