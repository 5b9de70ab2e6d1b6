"""Materials whose retardation times are not known yet, because they follow from a measured mode of the model."""

from __future__ import annotations

from typing import TypeVar

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.materials.material import Material

__all__ = ["all_pending", "pending", "with_materials", "without_pending_times"]

M = TypeVar("M", bound=ModelDescription)


def pending(model: ModelDescription) -> list[Material]:
    """Return the materials whose times follow from a mode, each once."""
    found: list[Material] = []
    for rod in model.rods.values():
        if rod.material is not None and rod.material.pending and rod.material not in found:
            found.append(rod.material)
    return found


def without_pending_times(model: M) -> M:
    """Return the model with these materials undamped."""
    return with_materials(model, {id(m): m.with_damping(None) for m in all_pending(model)})


def all_pending(model: ModelDescription) -> list[Material]:
    """Return the materials whose times follow from a mode, one per rod that has one."""
    return [rod.material for rod in model.rods.values() if rod.material is not None and rod.material.pending]


def with_materials(model: M, materials: dict[int, Material]) -> M:
    """Return the model with other materials, by the ``id`` of those that they replace."""
    parts = model.parts()
    parts["rods"] = {
        name: rod.model_copy(update={"material": materials[id(rod.material)]})
        if id(rod.material) in materials
        else rod
        for name, rod in model.rods.items()
    }
    return type(model).of(**parts)
