"""How far supports and motors turn the ends of rods against each other: the mesh must be able to follow."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.connections.place import AnyPlace, BodyPlace
from viscorod.model.connections.resolved_places import find, position_of, size_of
from viscorod.model.description.model_description import ModelDescription
from viscorod.typing import Floats

__all__ = ["prescribed_turn"]

LARGEST = 2.0 * np.pi * 200.0
"""Largest prescribed rotation [rad] for which a mesh is chosen; it needs 600 elements of the default order."""
MOST_PARTS = 100
"""Parts up to which it is found what they may do as rigid ones; beyond, all that is prescribed counts."""
ROUND_OFF = 1e-10
"""Size of a motion of rigid parts, over the largest, that is none."""


@dataclass(frozen=True)
class Held:
    """What a support or a joint holds: its conditions on the motions of rigid parts.

    Attributes:
        rows: of the six motions of every part, about the origin ``(held, parts, 6)``; displacements over the length.
        turns: which of the held motions are rotations ``(held,)``.
        motions: functions of time of the held motions, None where they stay ``(held,)``.
    """

    rows: Floats
    turns: np.ndarray
    motions: list[TimeFunction | None]


def prescribed_turn(model: ModelDescription) -> float:
    """Return the largest rotation [rad] by which prescribed motions turn places of a model against each other.

    Those at t = 0 and where functions of time have corners count, of supports and of motors. What parts do as rigid
    ones turns nothing against anything: a blade on a hub, a shaft in bearings, the crank of a mechanism. What is
    prescribed beyond that, to first order in the reference shape, is left to the rods.
    """
    supports, joints = model.resolved_supports(), model.resolved_joints()
    prescribed = [one.motion for one in supports] + [one.motion for one in joints]
    functions = [f for motion in prescribed for word, f in motion.items() if word in MOTIONS[3:]]
    if not functions:
        return 0.0
    held = _held(model)
    times = sorted({0.0, *(t for one in held for f in one.motions if f is not None for t in f.breakpoints)})
    if len(held[0].rows[0]) > MOST_PARTS:
        every = max(abs(f.value(t, before)) for f in functions for t in times for before in (True, False))
        return every if every < LARGEST else 0.0
    rows = np.concatenate([one.rows for one in held]).reshape(sum(len(one.rows) for one in held), -1)
    moving = np.array([f is not None for one in held for f in one.motions])
    values = np.array([_values(held, t, before) for t in times for before in (True, False)]).T
    left = np.zeros_like(values)
    driven = rows[moving] @ null_space(rows[~moving], rcond=ROUND_OFF) if not moving.all() else rows
    left[moving] = values[moving] - driven @ np.linalg.lstsq(driven, values[moving], rcond=ROUND_OFF)[0]
    turned, first = np.zeros(values.shape[1]), 0
    for one in held:
        own = left[first : first + len(one.rows)][one.turns & [f is not None for f in one.motions]]
        turned += np.linalg.norm(own, axis=0)
        first += len(one.rows)
    turn = float(turned.max())
    return turn if turn < LARGEST else 0.0


def _values(held: list[Held], t: float, before: bool) -> list[float]:
    """Return what is prescribed of all held motions [rad], displacements left out: rods follow them."""
    return [
        f.value(t, before) if f is not None and turn else 0.0
        for one in held
        for f, turn in zip(one.motions, one.turns, strict=True)
    ]


def _held(model: ModelDescription) -> list[Held]:
    """Return what supports and joints hold."""
    parts = _parts(model)
    length = size_of(model)

    def of(
        axes: Floats,
        sides: list[tuple[AnyPlace | None, Floats, float]],
        words: tuple[str, ...],
        motion: Mapping[str, TimeFunction],
    ) -> Held:
        rows = np.zeros((len(words), max(parts.values()) + 1, 6))
        for place, at, sign in sides:
            if place is None:
                continue
            mine = parts[place.body if isinstance(place, BodyPlace) else place.rod]
            for row, word in zip(rows, words, strict=True):
                k = MOTIONS.index(word)
                axis = sign * axes[:, k % 3]
                if k < 3:
                    row[mine] += np.concatenate([axis, np.cross(at, axis)]) / length
                else:
                    row[mine, 3:] += axis
        return Held(rows, np.array([word in MOTIONS[3:] for word in words]), [motion.get(w) for w in words])

    found = []
    for support in model.resolved_supports():
        at, frame = position_of(model, support.place)
        axes = support.axes if support.axes.any() else frame
        found.append(of(axes, [(support.place, at, 1.0)], support.held, support.motion))
    for joint in model.resolved_joints():
        words = tuple(word for word in MOTIONS if word in joint.held or word in joint.motion)
        sides = [(joint.a, joint.at_a, 1.0), (joint.b, joint.at_b, -1.0)]
        found.append(of(joint.frame, sides, words, joint.motion))
    return [one for one in found if len(one.rows)]


def _parts(model: ModelDescription) -> dict[str, int]:
    """Return the number of the part that every rod and body belongs to: attachments make one of several."""
    names = [*model.rods, *model.bodies]
    number = {name: k for k, name in enumerate(names)}

    def name_of(text: str) -> str:
        place = find(model, text)
        return place.body if isinstance(place, BodyPlace) else place.rod

    for attachment in model.attachments:
        one, other = number[name_of(attachment.a)], number[name_of(attachment.b)]
        number = {name: one if k == other else k for name, k in number.items()}
    order = {k: place for place, k in enumerate(dict.fromkeys(number.values()))}
    return {name: order[k] for name, k in number.items()}
