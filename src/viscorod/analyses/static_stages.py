"""The stages of an equilibrium: from names of loads and motions to their parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import Fault, InputError
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.fields.definition import did_you_mean, show, some_of
from viscorod.solve.settings.statics import EquilibriumSettings
from viscorod.solve.statics.stage import Stage

__all__ = ["constant_stage", "stages_of"]

REST = "rest_strains"

Growing: TypeAlias = tuple[str, int, int]
"""What grows in a stage: ("loads", number, 0), ("supports", support, component) or ("motors", coordinate, 0)."""
Named: TypeAlias = Mapping[str, set[Growing]]


def stages_of(discrete: DiscreteModel, settings: EquilibriumSettings) -> list[Stage]:
    """Return what acts at the end of every stage; without stages all, in one.

    Raises:
        InputError: a stage names what the model has not, or no stage names something.
    """
    whole = Stage.whole(discrete.static, len(discrete.model.loads), settings.load_factor)
    if not settings.stages:
        return [whole]
    loads, motions = _loads(discrete, len(whole.loads)), _motions(discrete)
    every = {member for known in (loads, motions) for members in known.values() for member in members}
    parts: list[dict[Growing, float]] = []
    for index, stage in enumerate(settings.stages):
        part: dict[Growing, float] = {}
        for key, known, given in (("loads", loads, stage.loads), ("motions", motions, stage.motions)):
            for name, value in given.items():
                part |= dict.fromkeys(_known(known, name, f"stages[{index}].{key}"), value)
        parts.append(part)
    left = every.difference(*parts)
    empty = next((index for index, part in enumerate(parts) if not part), None)
    if empty is not None:
        parts[empty] = dict.fromkeys(left, 1.0)
    elif left:
        text = some_of(
            [name for known in (loads, motions) for name, members in known.items() if members & left]
        )
        raise InputError(
            Fault(
                "stages", text, "no stage names this", "name it in a stage, or add a stage that names nothing"
            )
        )
    last = Stage(*(np.zeros_like(array) for array in (whole.loads, whole.supports, whole.motors)))
    found = []
    for part in parts:
        last = Stage(last.loads.copy(), last.supports.copy(), last.motors.copy())
        for (kind, k, component), value in part.items():
            if kind == "supports":
                last.supports[k, component] = value * settings.load_factor
            else:
                (last.loads if kind == "loads" else last.motors)[k] = value * settings.load_factor
        found.append(last)
    return found


def constant_stage(discrete: DiscreteModel, names: Sequence[str]) -> Stage:
    """Return the stage at whose end what is named acts in full, and nothing else.

    Raises:
        InputError: the model has none of such a name.
    """
    whole = Stage.whole(discrete.static, len(discrete.model.loads))
    known = _loads(discrete, len(whole.loads)) | _motions(discrete)
    stage = Stage(*(np.zeros_like(array) for array in (whole.loads, whole.supports, whole.motors)))
    for index, name in enumerate(names):
        for kind, k, component in _known(known, name, f"constant[{index}]"):
            if kind == "supports":
                stage.supports[k, component] = 1.0
            else:
                (stage.loads if kind == "loads" else stage.motors)[k] = 1.0
    return stage


def _loads(discrete: DiscreteModel, count: int) -> dict[str, set[Growing]]:
    """Return the loads by their names, or their kinds."""
    found: dict[str, set[Growing]] = {}
    for number, load in enumerate(discrete.model.loads):
        found.setdefault(load.name or load.word, set()).add(("loads", number, 0))
    if discrete.problem.rest_strains:
        found[REST] = {("loads", count - 1, 0)}
    return found


def _motions(discrete: DiscreteModel) -> dict[str, set[Growing]]:
    """Return the prescribed motions by place and word, by place, and by joint."""
    problem = discrete.problem
    found: dict[str, set[Growing]] = {}
    for k, component, _ in problem.supports.motions:
        for at in problem.supports.names[k].split(" + "):
            for name in (f"{at}.{MOTIONS[component]}", at):
                found.setdefault(name, set()).add(("supports", k, component))
    for c, _ in problem.joints.motions:
        found.setdefault(problem.joints.names[problem.joints.joint[c]], set()).add(("motors", c, 0))
    return found


def _known(known: Named, name: str, where: str) -> set[Growing]:
    if name not in known:
        others = f"there are {some_of(known)}" if known else "there are none"
        raise InputError(
            Fault(
                where, show(name), "the model has none of this name", f"{did_you_mean(name, known)}{others}"
            )
        )
    return known[name]
