"""Loads in the picture: arrows whose feet travel with the model and whose length follows their size in time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.actions.load import (
    DistributedForce,
    DistributedMoment,
    Force,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.pictures.style import scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.actions.load import AnyLoad
    from viscorod.model.description.model_description import ModelDescription
    from viscorod.pictures.viewer.frames import Frames
    from viscorod.pictures.viewer.marks import Marks
    from viscorod.results.result import Result

__all__ = ["loads_of", "tips_of"]

ALONG = 9
"""Arrows of a load that is spread along a rod."""


def loads_of(
    result: Result, model: ModelDescription, frames: Frames, marks: Marks
) -> tuple[list[dict[str, Any]], Floats]:
    """Return what is needed to draw the loads.

    Returns:
        Each load: kind, label, unit, feet (marks) and arrows (marks whose tracks are the vectors), "turning"
        for moments; gravity has one arrow and no foot. And the sizes of all loads over the frames ``(n, loads)``
        in SI.
    """
    found: list[dict[str, Any]] = []
    sizes: list[Floats] = []
    for load in model.loads:
        factor = _factors(result, load, frames)
        label, unit, feet, vectors = _arrows(result, load, frames, marks)
        vectors = vectors * factor[:, None, None]
        size = np.linalg.norm(vectors, axis=-1).max(axis=1)
        largest = float(size.max())
        if largest == 0.0:
            continue
        scale, word = scaled(unit, largest)
        found.append(
            {
                "kind": load.kind if isinstance(load, Gravity) else "load",
                "label": label,
                "unit": word,
                "family": unit,
                "scale": scale,
                "turning": isinstance(load, Moment | DistributedMoment),
                "feet": feet,
                "arrows": [marks.add(vectors[:, k] / largest) for k in range(vectors.shape[1])],
                "largest": largest,
            }
        )
        sizes.append(size)
    return found, np.stack(sizes, axis=1) if sizes else np.zeros((frames.count, 0))


def tips_of(loads: list[dict[str, Any]], marks: Marks) -> Floats:
    """Feet of the loads and directions to the tips of their longest arrows, ``(2, n, feet, 3)``; gravity has none."""
    feet = [foot for load in loads for foot in load["feet"]]
    arrows = [arrow for load in loads for arrow in load["arrows"] if load["feet"]]
    points = marks.points
    return np.stack([points[:, feet], points[:, arrows]])


def _factors(result: Result, load: AnyLoad, frames: Frames) -> Floats:
    """Factor of a load in the frames; loads of an equilibrium are those just before t = 0, times the load factor."""
    if result.dimension != "time":
        return frames.instants * load.factor(0.0, before=True)
    # the first state is that before anything is let go
    return np.array([load.factor(float(t), before=k == 0) for k, t in enumerate(frames.instants)])


def _arrows(
    result: Result, load: AnyLoad, frames: Frames, marks: Marks
) -> tuple[str, str, list[int], Floats]:
    """Label, unit, feet and vectors ``(n, arrows, 3)`` of a load at its full size."""
    sites = result.sites
    if isinstance(load, Force | Moment):
        foot = marks.site(sites.at(load.at))
        unit = "N" if isinstance(load, Force) else "N m"
        return (
            f"{load.kind} at {load.at}",
            unit,
            [foot],
            _carried(marks, [foot], [np.array(load.value)], load.following),
        )
    if isinstance(load, DistributedForce | DistributedMoment):
        ends = sites.ends(load.rod)
        s = np.linspace(load.from_s or ends[0].s, load.to_s or ends[1].s, ALONG)
        feet = [marks.site(sites.along(load.rod, float(x))) for x in s]
        values = [load.density(float(x)) for x in s]
        unit = "N/m" if isinstance(load, DistributedForce) else "N m/m"
        return f"load along {load.rod}", unit, feet, _carried(marks, feet, values, load.following)
    if isinstance(load, MovingForce):
        return _moving(result, load, frames, marks)
    if isinstance(load, Gravity):
        vector = np.tile(np.array(load.acceleration), (frames.count, 1, 1))
        return "gravity", "m/s²", [], vector
    return "load", "", [], np.zeros((frames.count, 0, 3))


def _carried(marks: Marks, feet: list[int], values: list[Floats], following: bool) -> Floats:
    """Vectors ``(n, feet, 3)`` in global components, turned with the sections where the load follows them."""
    vectors = np.tile(np.stack(values), (marks.frames, 1, 1))
    if following:
        turns = marks.turns[:, feet]
        R = matrices(turns.reshape(-1, 4)).reshape(*turns.shape[:2], 3, 3)
        vectors = np.einsum("nfij,nfj->nfi", R, vectors)
    return vectors


def _moving(
    result: Result, load: MovingForce, frames: Frames, marks: Marks
) -> tuple[str, str, list[int], Floats]:
    sites = result.sites
    first, last = sites.ends(load.rod)
    track, turn = np.empty((frames.count, 3)), np.empty((frames.count, 4))
    on = np.empty(frames.count)
    for k, t in enumerate(frames.instants if result.dimension == "time" else np.zeros(frames.count)):
        s = load.arc_length(float(t))
        on[k] = float(first.s <= s <= last.s)
        site = sites.along(load.rod, float(np.clip(s, first.s, last.s)))
        track[k] = site.of(marks.positions[k])
        turn[k] = site.rotation(marks.rotations[k])
    foot = marks.add(track, turn)
    vectors = _carried(marks, [foot], [np.array(load.value)], load.following)
    return f"force travelling on {load.rod}", "N", [foot], vectors * on[:, None, None]
