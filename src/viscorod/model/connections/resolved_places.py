"""Places named in a model: their positions, and which of them are one node."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from viscorod.model.connections.joint_base import ResolvedJoint
from viscorod.model.connections.place import (
    GROUND,
    ROUND_OFF,
    AnyPlace,
    BodyPlace,
    Place,
    find_place,
    find_rod,
    station_on,
)
from viscorod.model.connections.rigid_clusters import Pieces
from viscorod.model.connections.spring import LineSpring, ResolvedSpring, Spring
from viscorod.model.connections.support_base import ResolvedSupport
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = [
    "find",
    "is_located",
    "joined_places",
    "position_of",
    "required_breaks",
    "required_stations",
    "resolved_joints",
    "resolved_springs",
    "resolved_supports",
    "same",
    "sides",
    "size_of",
]

Sides: TypeAlias = tuple[tuple[AnyPlace, AnyPlace | None], tuple[Floats, Floats]]


def find(model: ModelDescription, text: str) -> AnyPlace:
    """Return the place that `text` names.

    Raises:
        RefusedError: there is none.
    """
    return find_place(text, model.rods, model.bodies)


def position_of(model: ModelDescription, place: AnyPlace) -> tuple[Floats, Floats]:
    """Return the position (3,) and frame (3, 3) of a place in the reference shape."""
    if isinstance(place, BodyPlace):
        body = model.bodies[place.body]
        return body.position(place.point), body.frame()
    position, frame = model.rods[place.rod].frames([place.s])
    return position[0], frame[0]


def size_of(model: ModelDescription) -> float:
    """Return the length that others are small or large beside [m].

    It is that of the longest rod. Of rigid bodies alone it is the distance between the farthest corners of the box
    around their mass centres, their points and the ends of springs, or their largest radius of
    gyration, or 1 where all that is one point.
    """
    if model.rods:
        return max(rod.length for rod in model.rods.values())
    bodies = list(model.bodies.values())
    known = [body.position(point) for body in bodies for point in (None, *body.points)]
    known += [end for spring in resolved_springs(model) for end in (spring.at_a, spring.at_b)]
    gyration = [np.sqrt(np.trace(body.inertia_matrix()) / (2.0 * body.total_mass())) for body in bodies]
    return max(float(np.linalg.norm(np.ptp(known, axis=0))), *gyration) or 1.0


def is_located(place: AnyPlace | None) -> bool:
    """Return whether a place locates a joint: a body without a named point does not, nor does the ground."""
    return isinstance(place, Place) or (place is not None and place.point is not None)


def sides(model: ModelDescription, a: str, b: str) -> Sides:
    """Return the two places of a joint or bushing, and its position on each side in the reference shape.

    On a body without a named point, and on the ground, it is the position of the other side.

    Args:
        model: of the places.
        a: place.
        b: place, or "ground".
    """
    first, second = find(model, a), None if b == GROUND else find(model, b)
    at_first = position_of(model, first)[0]
    at_second = at_first if second is None else position_of(model, second)[0]
    if is_located(first) and not is_located(second):
        at_second = at_first
    elif is_located(second) and not is_located(first):
        at_first = at_second
    return (first, second), (at_first, at_second)


def resolved_supports(model: ModelDescription) -> list[ResolvedSupport]:
    """Return the supports with their places and axes, in order."""
    resolved = []
    for index, support in enumerate(model.supports):
        place = find(model, support.at)
        resolved.append(support.resolve(f"supports[{index}]", place, position_of(model, place)[1]))
    return resolved


def resolved_joints(model: ModelDescription) -> list[ResolvedJoint]:
    """Return the joints with their places and axes, in order."""
    return [
        joint.resolve(f"joints[{index}]", *sides(model, *joint.ends))
        for index, joint in enumerate(model.joints)
    ]


def resolved_springs(model: ModelDescription) -> list[ResolvedSpring]:
    """Return the springs with their places and axes, in order."""
    resolved = []
    for index, spring in enumerate(model.springs):
        path = f"springs[{index}]"
        if isinstance(spring, Spring):
            resolved.append(spring.resolve(path, *sides(model, *spring.ends)))
        elif isinstance(spring, LineSpring):
            first = find(model, spring.at)
            second = find(model, spring.to) if isinstance(spring.to, str) else None
            end = np.array(spring.to) if second is None else position_of(model, second)[0]
            resolved.append(spring.resolve(path, (first, second), (position_of(model, first)[0], end)))
    return resolved


def joined_places(model: ModelDescription) -> list[tuple[AnyPlace, ...]]:
    """Return the groups of places that attachments join into one node each, in the order of their first mention."""
    return Pieces(model).groups


def same(model: ModelDescription, a: AnyPlace, b: AnyPlace) -> bool:
    """Return whether two places are the same station of the same rod, or on the same body."""
    if isinstance(a, BodyPlace) or isinstance(b, BodyPlace):
        return isinstance(a, BodyPlace) and isinstance(b, BodyPlace) and a.body == b.body
    return a.rod == b.rod and abs(a.s - b.s) <= ROUND_OFF * model.rods[a.rod].length


def required_breaks(model: ModelDescription) -> list[Place]:
    """Return places at which elements must end, whatever the mesh: supports, attachments, joints, springs, drag.

    Loads that see motion act at nodes, each for a part of an element: an element that lies in them in part has no such
    parts.
    """
    texts = [support.at for support in model.supports]
    texts += [text for attachment in model.attachments for text in (attachment.a, attachment.b)]
    texts += [text for joint in model.joints for text in joint.ends if text != GROUND]
    texts += [text for spring in model.springs for text in spring.ends if text != GROUND]
    places = [place for place in (find(model, text) for text in texts) if isinstance(place, Place)]
    return places + [place for load in model.loads if load.sees_motion for place in load.breaks(model)]


def required_stations(model: ModelDescription, name: str) -> tuple[float, ...]:
    """Return arc lengths at which an element of the rod must end, increasing, without near-duplicates."""
    rod = find_rod(name, model.rods, model.bodies)
    stations = [0.0, rod.length, *rod.section_breaks]
    places = [*required_breaks(model), *(place for load in model.loads for place in load.breaks(model))]
    stations += [station_on(rod, place.s, name) for place in places if place.rod == name]
    kept: list[float] = []
    for s in sorted(stations):
        if not kept or s - kept[-1] > ROUND_OFF * rod.length:
            kept.append(s)
    return (*kept[:-1], rod.length)
