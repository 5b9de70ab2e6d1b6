"""Symbols of what holds and joins the rods: supports, rigid bodies, joints, springs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.rotations.quaternion import conjugate, from_matrices, product
from viscorod.pictures.plots.assemblies import Assembly

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription
    from viscorod.pictures.viewer.marks import Marks
    from viscorod.results.result import Result

__all__ = ["bodies_of", "connections_of", "supports_of"]

Symbol = dict[str, Any]


def supports_of(result: Result, model: ModelDescription | None, marks: Marks) -> list[Symbol]:
    """Return the supports: kind, label, and the mark at which each sits."""
    found = []
    if model is not None:
        places = [
            (support.at, str(getattr(support, "kind", "support")), support.at) for support in model.supports
        ]
    else:
        names = result.data["support"].values if "support" in result.data.coords else ()
        places = [(str(name), str(name).partition(" at ")[0], str(name).rsplit(" at ")[-1]) for name in names]
    for label, kind, place in places:
        try:
            mark = marks.site(result.sites.at(place))
        except InputError:  # a support may bear a name of its own that is not a place
            continue
        found.append({"kind": kind, "label": f"{kind} at {label}" if kind != label else label, "mark": mark})
    return found


def bodies_of(result: Result, model: ModelDescription | None, marks: Marks) -> list[Symbol]:
    """Return the rigid bodies: shape and sizes [m], its turn in the axes of the station, what is fixed to it."""
    reference = np.asarray(result.data["reference_rotation"].values, dtype=float)
    found = []
    for body in Assembly(result).bodies:
        given = model.bodies.get(body.name) if model is not None else None
        symbol: Symbol = {
            "label": body.name,
            "mark": marks.site(result.sites.at(body.centre)),
            "fixed": [marks.site(result.sites.at(int(station))) for station in body.fixed],
            "shape": "point",
            "turn": [1.0, 0.0, 0.0, 0.0],
        }
        shape = str(getattr(given, "shape", ""))
        if given is not None and shape in ("box", "sphere", "cylinder"):
            symbol["shape"] = shape
            symbol["size"] = _sizes(given)
            frame = from_matrices(given.frame()[None])
            symbol["turn"] = product(conjugate(reference[body.centre][None]), frame)[0].tolist()
        found.append(symbol)
    return found


def _sizes(body: Any) -> list[float]:
    """Return sizes of a body with a shape [m]: three sides, a radius, or radius and length."""
    if body.shape == "box":
        return list(body.sides)
    return [body.radius] if body.shape == "sphere" else [body.radius, body.length]


def connections_of(result: Result, model: ModelDescription | None, marks: Marks) -> list[Symbol]:
    """Return joints and springs: the marks of both sides, and the directions that a joint leaves free."""
    data = result.data
    if "connection" not in data.coords:
        return []
    assembly = Assembly(result)
    ends = np.stack(
        [assembly.ends(r, q) for r, q in zip(marks.positions, marks.rotations, strict=True)]
    )  # (n, connections, 2, 3)
    kinds = np.asarray(data["connection_kind"].values, dtype=str)
    stations = np.asarray(data["connection_station"].values, dtype=int)
    joints = {joint.label: joint for joint in model.resolved_joints()} if model is not None else {}
    found = []
    for k, name in enumerate(np.asarray(data["connection"].values, dtype=str).tolist()):
        sides = [marks.add(ends[:, k, side]) for side in (0, 1)]
        symbol: Symbol = {"kind": str(kinds[k]), "label": name, "marks": sides, "axes": []}
        joint = joints.get(name)
        if joint is not None:
            turns = [j for j, word in enumerate(("rx", "ry", "rz")) if word in joint.free]
            if len(turns) < 3:  # a ball needs no axes
                symbol["axes"] = [
                    marks.add(marks.turned(int(stations[k, 0]), joint.frame[:, j])) for j in turns
                ]
        found.append(symbol)
    return found
