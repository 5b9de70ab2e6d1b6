"""How the rods of a model are divided unless told otherwise; found once for models that differ in numbers only."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from viscorod.model.connections.resolved_places import required_breaks
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.problem.division import Divisions, divided
from viscorod.solve.problem.model_parts import Alike, computed, part_token, shape_token, token
from viscorod.solve.problem.prescribed_turns import prescribed_turn

__all__ = ["chosen_divisions"]

KEPT = 8
"""Divisions that are kept, those that were used last."""


def chosen_divisions(model: ModelDescription) -> Divisions:
    """Return how the rods of a model are divided unless told otherwise.

    Raises:
        InputError: a rod has too few elements.
    """
    known = alike_divided(model)
    return _chosen(model) if known is None else _kept(known)


def alike_divided(model: ModelDescription) -> Alike | None:
    """Return what is equal for models that are divided alike, and have one layout; None where nothing tells it."""
    driven = any(getattr(one, "motion", None) for one in (*model.supports, *model.joints))
    if driven or any(computed(rod) or not rod.uniform for rod in model.rods.values()):
        return None
    return Alike(model, _parts(model))


def _parts(model: ModelDescription) -> list[Any]:
    """Return what stands for all that the divisions of a model depend on."""
    found: list[Any] = []
    for name, rod in model.rods.items():
        found += [name, rod.order, *map(token, shape_token(rod))]
    for name, body in model.bodies.items():
        found += [name, part_token(body)]
    for parts in (model.supports, model.attachments, model.joints, model.springs):
        found += [len(parts), *map(part_token, parts)]
    for load in model.loads:
        found += [load.sees_motion, *((place.rod, place.s) for place in load.breaks(model)), None]
    return [*found, *((strain.rod, token(strain.stations)) for strain in model.rest_strains)]


@lru_cache(maxsize=KEPT)
def _kept(alike: Alike) -> Divisions:
    return _chosen(alike.taken())


def _chosen(model: ModelDescription) -> Divisions:
    breaks: dict[str, list[float]] = {name: list(rod.section_breaks) for name, rod in model.rods.items()}
    wishes: dict[str, list[float]] = {name: [] for name in model.rods}
    for place in required_breaks(model):
        breaks[place.rod].append(place.s)
    for load in model.loads:
        for place in load.breaks(model):
            wishes[place.rod].append(place.s)
    for strain in model.rest_strains:
        length = model.rods[strain.rod].length
        wishes[strain.rod] += [s for s in strain.stations or () if 1e-9 * length < s < (1.0 - 1e-9) * length]
    turn = prescribed_turn(model)
    return {name: divided(name, rod, breaks[name], wishes[name], turn) for name, rod in model.rods.items()}
