"""Loads in the picture: arrows whose feet travel with the model and whose length follows their size in time."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.results.text_numbers import scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.actions.load import AnyLoad
    from viscorod.model.actions.load_effects import Arrows
    from viscorod.model.description.model_description import ModelDescription
    from viscorod.pictures.viewer.frames import Frames
    from viscorod.pictures.viewer.marks import Marks
    from viscorod.results.result import Result
    from viscorod.results.result_places import ResultPlace

__all__ = ["loads_of", "tips_of"]


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
        drawn, feet, vectors = _arrows(result, load, model, frames, marks)
        vectors = vectors * factor[:, None, None]
        size = np.linalg.norm(vectors, axis=-1).max(axis=1)
        largest = float(size.max())
        if largest == 0.0:
            continue
        scale, word = scaled(drawn.unit, largest)
        found.append(
            {
                "kind": "load" if drawn.feet else "gravity",
                "label": drawn.label,
                "unit": word,
                "family": drawn.unit,
                "scale": scale,
                "turning": drawn.turning,
                "feet": feet,
                "arrows": [marks.add(vectors[:, k] / largest) for k in range(vectors.shape[1])],
                "largest": largest,
            }
        )
        sizes.append(size)
    return found, np.stack(sizes, axis=1) if sizes else np.zeros((frames.count, 0))


def tips_of(loads: list[dict[str, Any]], marks: Marks) -> Floats:
    """Return feet of the loads and directions to tips of their longest arrows, ``(2, n, feet, 3)``, without gravity."""
    feet = [foot for load in loads for foot in load["feet"]]
    arrows = [arrow for load in loads for arrow in load["arrows"] if load["feet"]]
    points = marks.points
    return np.stack([points[:, feet], points[:, arrows]])


def _factors(result: Result, load: AnyLoad, frames: Frames) -> Floats:
    """Return a load's factor in the frames; loads of equilibria are those just before t = 0, times the load factor."""
    if result.dimension != "time":
        return frames.instants * load.factor(0.0, before=True)
    # the first state is that before anything is let go
    return np.array([load.factor(float(t), before=k == 0) for k, t in enumerate(frames.instants)])


def _arrows(
    result: Result, load: AnyLoad, model: ModelDescription, frames: Frames, marks: Marks
) -> tuple[Arrows, list[int], Floats]:
    """Return what is drawn of a load, its feet, and its vectors ``(n, arrows, 3)`` at full size, global axes."""
    times = frames.instants if result.dimension == "time" else np.zeros(frames.count)
    shown = [load.arrows(model, float(t)) for t in (times if load.travels else times[:1])]
    if load.travels:
        feet = [
            _travelling_foot(result, places, marks)
            for places in zip(*(each.feet for each in shown), strict=True)
        ]
    else:
        feet = [marks.site(_site(result, place)) for place in shown[0].feet]
    values = np.stack([each.acting * each.values for each in shown])
    vectors = np.broadcast_to(values, (frames.count, *values.shape[1:]))
    if shown[0].following:
        turns = marks.turns[:, feet]
        R = matrices(turns.reshape(-1, 4)).reshape(*turns.shape[:2], 3, 3)
        vectors = np.einsum("nfij,nfj->nfi", R, vectors)
    return shown[0], feet, vectors


def _site(result: Result, place: AnyPlace) -> ResultPlace:
    if isinstance(place, BodyPlace):
        return result.sites.at(str(place))
    return result.sites.along(place.rod, place.s)


def _travelling_foot(result: Result, places: Sequence[AnyPlace], marks: Marks) -> int:
    """Add a mark that is at another place in every frame."""
    track, turn = np.empty((marks.frames, 3)), np.empty((marks.frames, 4))
    for k, place in enumerate(places):
        site = _site(result, place)
        track[k], turn[k] = site.of(marks.positions[k]), site.rotation(marks.rotations[k])
    return marks.add(track, turn)
