"""How far supports and motors turn the ends of rods against each other: the mesh must be able to follow."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.model.connections.resolved_places import find
from viscorod.model.description.model_description import ModelDescription
from viscorod.typing import Floats

__all__ = ["prescribed_turn"]

LARGEST = 2.0 * np.pi * 200.0
"""Largest prescribed rotation [rad] for which a mesh is chosen; it needs 600 elements of the default order."""
GROUND = "ground"


def prescribed_turn(model: ModelDescription) -> float:
    """Return the largest rotation [rad] by which prescribed motions turn two places of a model against each other.

    Those at t = 0 and where functions of time have corners count, of supports and of motors that close a loop. What
    turns as a whole, such as a blade on a hub, is not turned against anything.
    """
    largest = 0.0
    supports = model.resolved_supports()
    if any(support.motion for support in supports):
        turns = [_turns(support.axes, support.motion) for support in supports if support.held]
        times = sorted({0.0, *(t for turn in turns for t in turn[0])})
        at = np.array([[_at(turn, t, before) for turn in turns] for t in times for before in (True, False)])
        for first, second in combinations(range(len(turns)), 2):
            largest = max(largest, float(np.linalg.norm(at[:, first] - at[:, second], axis=1).max()))
    for number, joint in enumerate(model.resolved_joints()):
        functions = [motion for word, motion in joint.motion.items() if word in MOTIONS[3:]]
        if functions and _in_loop(model, number):
            corners = [(t, f) for f in functions for t in (0.0, *f.breakpoints)]
            largest += max(abs(f.value(t, before)) for t, f in corners for before in (True, False))
    return largest if largest < LARGEST else 0.0


Turn = tuple[list[float], list[tuple[Floats, TimeFunction]]]


def _turns(axes: Floats, motion: dict[str, TimeFunction]) -> Turn:
    """Return the corners of a support's rotations, and the axis and the function of each."""
    found = [(axes[:, i], motion[word]) for i, word in enumerate(MOTIONS[3:]) if word in motion]
    return [t for _, function in found for t in function.breakpoints], found


def _at(turn: Turn, t: float, before: bool) -> Floats:
    """Return a prescribed rotation vector [rad]."""
    return np.asarray(sum((axis * function.value(t, before) for axis, function in turn[1]), np.zeros(3)))


def _in_loop(model: ModelDescription, number: int) -> bool:
    """Return whether the two sides of a joint are connected without it, through the ground too."""
    group: dict[str, str] = {}

    def root(part: str) -> str:
        while group.setdefault(part, part) != part:
            part = group[part]
        return part

    def part_of(place: AnyPlace | None) -> str:
        if place is None:
            return GROUND + " "  # no name of a rod or a body has a space
        return place.body if isinstance(place, BodyPlace) else place.rod

    def join(a: str, b: str) -> None:
        group[root(a)] = root(b)

    for attachment in model.attachments:
        join(part_of(find(model, attachment.a)), part_of(find(model, attachment.b)))
    for support in model.resolved_supports():
        join(part_of(support.place), part_of(None))
    joints = model.resolved_joints()
    for other, joint in enumerate(joints):
        if other != number:
            join(part_of(joint.a), part_of(joint.b))
    return root(part_of(joints[number].a)) == root(part_of(joints[number].b))
