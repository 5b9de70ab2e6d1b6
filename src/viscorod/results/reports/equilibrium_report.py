"""The report of an equilibrium, or of a path of equilibria, as plain text."""

from __future__ import annotations

import itertools
import json
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.reports.effort import counted, effort
from viscorod.results.reports.report_parts import (
    ends,
    heading,
    load_level,
    named_sites,
    places,
    reactions,
    stress,
    validity,
    warnings,
)
from viscorod.results.text_numbers import quantity
from viscorod.results.text_table import numbers, page, tabulated, words

if TYPE_CHECKING:
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.typing import Floats

__all__ = ["equilibrium_report"]


def equilibrium_report(equilibrium: Equilibrium) -> str:
    """Return the report of an equilibrium."""
    judged = equilibrium.validity()
    level = load_level(equilibrium.load_factor[-1])
    return page(
        [
            heading(equilibrium, f"static equilibrium under {level}"),
            ends(equilibrium, places(equilibrium), -1),
            _rotations(equilibrium),
            reactions(equilibrium),
            _path(equilibrium),
            _joints(equilibrium),
            _stability(equilibrium),
            stress(equilibrium),
            validity(equilibrium, judged),
            effort(equilibrium),
            warnings(equilibrium, judged),
        ]
    )


def _rotations(equilibrium: Equilibrium) -> str:
    sites = named_sites(equilibrium, points=False)
    found = np.array([equilibrium.rotation(site.label) for site in sites]).reshape(-1, 3)
    return tabulated(
        "Rotation from the reference orientation (rotation vector)",
        words("place", [site.label for site in sites]),
        numbers(("x", "y", "z"), "rad", found, size=max(1.0, _largest(found))),
    )


def _largest(values: Floats) -> float:
    return float(np.max(np.abs(values), initial=0.0))


def _joints(equilibrium: Equilibrium) -> str:
    """Report coordinates that joints leave free or drive, springs, and all forces."""
    data = equilibrium.data
    if "joint_value" not in data:
        return ""
    value, force = (np.asarray(data[name].values[-1], dtype=float) for name in ("joint_value", "joint_force"))
    motions = data["joint_motion"].values
    slides = np.array([str(word).startswith("u") for word in motions])
    size = float(data.attrs.get("scale_length", 1.0))
    largest = _largest(np.where(slides, force, force / size))
    names = data["joint"].values
    shown = ["" if k and name == names[k - 1] else str(name) for k, name in enumerate(names)]
    blocks = []
    for kind, mine, units, scale in (
        ("slide", slides, ("m", "N"), 1.0),
        ("turn", ~slides, ("rad", "N m"), size),
    ):
        if not mine.any():
            continue
        chosen = np.flatnonzero(mine)
        labels = [str(names[k]) if not shown[k] and k - 1 not in chosen else shown[k] for k in chosen]
        blocks.append(
            tabulated(
                f"Joints and springs that {kind}: coordinates, and what acts along them on the first place",
                words("joint", labels),
                words("motion", [str(motions[k]) for k in chosen]),
                numbers(("value",), units[0], value[mine], size=size if kind == "slide" else 1.0),
                numbers(
                    ("force" if kind == "slide" else "moment",), units[1], force[mine], size=largest * scale
                ),
                words("", ["held" if data["joint_held"].values[k] else "" for k in chosen]),
            )
        )
    return "\n\n".join(blocks)


def _path(equilibrium: Equilibrium) -> str:
    if not equilibrium.is_path:
        return ""
    factors = equilibrium.load_factor
    unstable = np.asarray(equilibrium.data["negative_eigenvalues"].values)
    lines = [f"Path of {factors.size} points; load factors from {factors.min():.6g} to {factors.max():.6g}"]
    motions = equilibrium.stability != "tangent stiffness"
    what = "growing motions" if motions else "negative eigenvalues"
    times = [f"{k}-fold bifurcation" if k > 1 else "bifurcation" for k in equilibrium.multiplicity]
    kinds = {
        "limit_points": itertools.repeat("limit point"),
        "bifurcations": iter(times) if times else itertools.repeat("bifurcation"),
        "flutter_points": itertools.repeat("flutter"),
    }
    for kind, names in kinds.items():
        for number, word in zip(equilibrium.special_points(kind), names, strict=False):
            after = unstable[min(number + 1, unstable.size - 1)]
            lines.append(f"  {word} at {factors[number]:.7g} of the loads ({what} beyond it: {after})")
    lines += [
        f"  near {factor:.4g} of the loads it turns off beside another path, which it does not meet: an imperfection, "
        "such as a small load or a shape that is not quite symmetric, decides which way"
        for factor in json.loads(equilibrium.data.attrs.get("parting", "[]"))
    ]
    return "\n".join(lines)


def _stability(equilibrium: Equilibrium) -> str:
    lines = [f"Elastic energy {quantity(equilibrium.elastic_energy, 'J')}"]
    if "negative_eigenvalues" in equilibrium.data.attrs:
        count = equilibrium.negative_eigenvalues
        if equilibrium.stability == "tangent stiffness":
            lines.append(
                f"Unstable: the tangent stiffness has {counted(count, 'negative eigenvalues')}"
                if count
                else "Stable: the tangent stiffness has no negative eigenvalue"
            )
        else:
            flutter = int(equilibrium.data.attrs["flutter"])
            why = (
                "following loads or moments make the tangent stiffness unsymmetric: judged by "
                f"{equilibrium.stability}"
            )
            lines.append(
                f"Unstable: {counted(count, 'small motions')} grow{'' if count > 1 else 's'}, "
                f"{flutter} of them oscillating ({why})"
                if count
                else f"Stable: no small motion grows ({why})"
            )
    if equilibrium.found_by:
        lines.append(f"Found by {equilibrium.found_by}")
    return "\n".join(lines)
