"""Size limits of cases, checked by estimates before anything is allocated."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from viscorod.errors import Fault
from viscorod.limits import (
    DEEPEST_NESTING,
    LONGEST,
    MOST_CHOSEN,
    MOST_NODES,
    MOST_RECORDED,
    MOTION_BYTES,
    NODE_BYTES,
    NODE_SECONDS,
    STATE_BYTES,
)
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import path_text, show
from viscorod.model.rod import DEFAULT_ORDER, Rod
from viscorod.solve.settings.analysis import AnySettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import PathSettings

__all__ = ["size_problems", "too_deep"]


def too_deep(value: Any, path: tuple[str | int, ...] = ()) -> str | None:
    """Find where tables and lists are nested deeper than any case needs: the path to there, shortened."""
    if not isinstance(value, Mapping | list | tuple):
        return None
    if len(path) >= DEEPEST_NESTING:
        return path_text(path[:6])
    items = value.items() if isinstance(value, Mapping) else enumerate(value)
    return next((found for key, item in items if (found := too_deep(item, (*path, key)))), None)


def size_problems(model: ModelDescription, settings: AnySettings) -> list[Fault]:
    """List what is too large in a case: nodes, stored states, steps, with estimates of memory and time."""
    return list(_problems(model, settings))


def _problems(model: ModelDescription, settings: AnySettings) -> Iterator[Fault]:
    for name, rod in model.rods.items():
        if rod.elements is None and rod.chosen_elements(0.0, rod.length) > MOST_CHOSEN:
            yield Fault(
                f"rods.{name}",
                "",
                f"it turns so often that {rod.chosen_elements(0.0, rod.length):.3g} elements would be needed",
                f"check angle, turns or twist; give elements if more than {MOST_CHOSEN} are meant",
            )
            return
    nodes = {name: _nodes(rod) for name, rod in model.rods.items()}
    total = sum(nodes.values())
    moves = isinstance(settings, SimulateSettings)
    if total > MOST_NODES:
        name = max(nodes, key=lambda word: nodes[word])
        rod = model.rods[name]
        alone = nodes[name] > MOST_NODES
        where = f"rods.{name}.elements" if alone and rod.elements else f"rods.{name}" if alone else "rods"
        found = f"{rod.elements}" if alone and rod.elements else f"{len(nodes)} rods" if not alone else ""
        memory = total * (MOTION_BYTES if moves else NODE_BYTES)
        yield Fault(
            where,
            found,
            f"{total} nodes would need about {_bytes(memory)} and {_time(total * NODE_SECONDS)} for every step",
            f"give elements and order that make at most {MOST_NODES} nodes together (elements x order)",
        )
        return
    if isinstance(settings, PathSettings):
        for allowed in (_TIME, _MEMORY):
            yield from allowed.exceeded("path.points", settings.points, settings.points, total, "points")
    if isinstance(settings, SimulateSettings):
        for key in ("time_step", "output_interval"):
            interval = getattr(settings, key)
            if interval is not None:
                count = settings.duration / interval
                allowed, noun = (_TIME, "steps") if key == "time_step" else (_MEMORY, "stored states")
                yield from allowed.exceeded(f"simulate.{key}", interval, count, total, noun)


def _nodes(rod: Rod) -> int:
    elements = rod.elements or rod.chosen_elements(0.0, rod.length)
    return elements * (rod.order or DEFAULT_ORDER) + 1


def _bytes(size: float) -> str:
    return f"{size / 1e9:.3g} GB of memory or disk"


def _time(seconds: float) -> str:
    if seconds < 86_400.0:
        return f"{seconds:.3g} s"
    return f"{seconds / 86_400.0:.3g} days"


@dataclass(frozen=True)
class _Allowed:
    """A limit: the cost of a step or state of a node, how much of it is allowed, and how it is written."""

    each: float
    most: float
    verb: str
    text: Callable[[float], str]

    def exceeded(self, key: str, value: float, count: float, nodes: int, noun: str) -> Iterator[Fault]:
        cost = count * nodes * self.each
        if cost > self.most:
            yield Fault(
                key,
                show(value),
                f"{count:.3g} {noun} of {nodes} nodes would {self.verb} {self.text(cost)}",
                f"make {noun} fewer by a factor of {math.ceil(cost / self.most):.3g}, or take fewer elements",
            )


_TIME = _Allowed(NODE_SECONDS, LONGEST, "take at least", _time)
_MEMORY = _Allowed(STATE_BYTES, MOST_RECORDED, "need about", _bytes)
