"""Checks of attachments, joints and springs, and of bodies that are not connected to anything."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import Fault
from viscorod.model.connections.place import GROUND, AnyPlace, BodyPlace, Place
from viscorod.model.connections.resolved_places import (
    find,
    is_located,
    position_of,
    resolved_joints,
    resolved_springs,
    same,
    size_of,
)
from viscorod.model.connections.rigid_clusters import Pieces
from viscorod.model.connections.spring import ResolvedSpring
from viscorod.model.fields.definition import show
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.connections.joint_base import ResolvedJoint
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["loose_bodies", "names_twice", "wrong_attachments", "wrong_joints"]

GAP = 1e-6
"""Largest distance of attached places, as a part of the longer rod's length, or of the model."""


def wrong_attachments(model: ModelDescription) -> Iterator[Fault]:
    """Find attachments of places that do not meet, of one place, or given twice."""
    seen: set[frozenset[AnyPlace]] = set()
    for index, attachment in enumerate(model.attachments):
        a, b = find(model, attachment.a), find(model, attachment.b)
        pair = frozenset(BodyPlace(p.body) if isinstance(p, BodyPlace) else p for p in (a, b))
        where = f"attachments[{index}]"
        positions = [position_of(model, place)[0] for place in (a, b)]
        gap = float(np.linalg.norm(positions[0] - positions[1]))
        lengths = [model.rods[p.rod].length for p in (a, b) if isinstance(p, Place)]
        reach = GAP * (max(lengths) if lengths else size_of(model))
        if same(model, a, b):
            yield Fault(where, str(a), "a place cannot be attached to itself", "give two places")
        elif is_located(a) and is_located(b) and gap > reach:
            yield Fault(
                where,
                f"{attachment.a} at {_point(positions[0])} and {attachment.b} at {_point(positions[1])}",
                f"places can be attached only where they coincide; the gap is {gap:.6g} m",
                _closed(a, b),
            )
        elif pair in seen:
            yield Fault(
                where, f"{attachment.a} and {attachment.b}", "they are attached already", "leave one out"
            )
        seen.add(pair)


def _closed(a: AnyPlace, b: AnyPlace) -> str:
    for place in (a, b):
        if isinstance(place, BodyPlace):
            return f"move the rod or the point, or attach the rod to {place.body!r}, which reaches everywhere"
    return "move one of the rods so that the places meet"


def wrong_joints(model: ModelDescription) -> Iterator[Fault]:
    """Find joints and springs within one rigid part, without a position, or given twice."""
    if not model.joints and not model.springs:
        return
    pieces = Pieces(model)
    size = size_of(model)
    before: dict[frozenset[AnyPlace | None], ResolvedJoint] = {}
    for joint in resolved_joints(model):
        found = list(_wrong_ends(model, joint, pieces, size))
        yield from found
        gap = float(np.linalg.norm(joint.gap))
        if not found and gap > size:
            yield Fault(
                joint.path,
                f"{joint.a} at {_point(joint.at_a)} and {joint.b} at {_point(joint.at_b)}",
                f"the places are {gap:.6g} m apart along motions that the joint holds, "
                f"more than {'the longest rod' if model.rods else 'the model'} ({size:.6g} m)",
                "move the parts so that the places meet",
            )
        other = before.setdefault(frozenset((joint.a, joint.b)), joint)
        if other is not joint:
            yield Fault(
                joint.path,
                joint.label,
                f"the two places have a joint already, {other.label} ({other.path})",
                "give one joint, which leaves free what both do",
            )
    for spring in resolved_springs(model):
        yield from _wrong_ends(model, spring, pieces, size)


def _wrong_ends(
    model: ModelDescription,
    joint: ResolvedJoint | ResolvedSpring,
    pieces: Pieces,
    size: float,
) -> Iterator[Fault]:
    noun = "spring" if isinstance(joint, ResolvedSpring) else "joint"
    gap = float(np.linalg.norm(joint.at_a - joint.at_b))
    if joint.b is not None:
        found = f"{joint.a} and {joint.b}"
        if same(model, joint.a, joint.b):
            what = "the same body" if isinstance(joint.a, BodyPlace) else "the same place"
            yield Fault(
                joint.path, found, f"both sides of the {noun} are {what}", "give two different things"
            )
            return
        if pieces.of(joint.a) == pieces.of(joint.b):
            yield Fault(
                joint.path,
                found,
                f"they are attached, so nothing is left for the {noun}",
                f"leave the attachment or the {noun} out",
            )
            return
    if joint.kind == "line":
        if gap <= GAP * size:
            yield Fault(
                joint.path,
                f"{joint.label}: both ends at {_point(joint.at_a)}",
                "the line between the ends has no direction",
                "give ends that are apart, or a spring of kind 'bushing'",
            )
    elif joint.b is not None and not is_located(joint.a) and not is_located(joint.b) and gap > GAP * size:
        yield Fault(
            joint.path,
            f"{joint.a} and {joint.b}",
            f"nothing says where the {noun} between the two bodies is",
            f"name a point of one of them, such as {joint.a}.tip, and give that",
        )


def names_twice(model: ModelDescription) -> Iterator[Fault]:
    """Find names that two joints or springs share."""
    first: dict[str, str] = {}
    named = [(f"joints[{index}]", joint.name) for index, joint in enumerate(model.joints)]
    named += [(f"springs[{index}]", spring.name) for index, spring in enumerate(model.springs)]
    for path, name in named:
        if name is None:
            continue
        if name in first:
            yield Fault(
                f"{path}.name", show(name), f"{first[name]} has this name already", "give another name"
            )
        first.setdefault(name, path)


def loose_bodies(model: ModelDescription) -> Iterator[Fault]:
    """Find bodies that are not connected to anything; where there are no rods, bodies may fly."""
    if not model.rods:
        return
    texts = [text for attachment in model.attachments for text in (attachment.a, attachment.b)]
    texts += [text for joint in model.joints for text in joint.ends]
    texts += [text for spring in model.springs for text in spring.ends]
    texts += [support.at for support in model.supports]
    named = _named(model, texts) if model.bodies else set()
    for name in model.bodies:
        if name not in named:
            yield Fault(
                f"bodies.{name}",
                show(name),
                "the body is connected to nothing",
                f"attach a rod to {name!r}, or give it a joint, a spring or a support",
            )


def _named(model: ModelDescription, texts: list[str] | tuple[str, ...]) -> set[str]:
    """Return the bodies that texts name."""
    places = [find(model, text) for text in texts if text != GROUND]
    return {place.body for place in places if isinstance(place, BodyPlace)}


def _point(position: Floats) -> str:
    return f"({', '.join(f'{x:.6g}' for x in position)})"
