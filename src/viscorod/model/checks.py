"""Checks of how the parts of a model fit together, and what follows from the places they name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import Problem
from viscorod.model.any_support import ResolvedSupport
from viscorod.model.described import RefusedError, path_text, show
from viscorod.model.load import DistributedForce, DistributedMoment, Force, Moment, MovingForce
from viscorod.model.motion_words import MOTIONS
from viscorod.model.place import ROUND_OFF, Place, find_place, find_rod, station_on
from viscorod.model.rod import Rod
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description import ModelDescription

__all__ = ["joined_places", "problems", "required_stations", "resolved_supports"]

GAP = 1e-6
"""Largest distance of attached places, as a part of the longer rod's length."""


def problems(model: ModelDescription) -> Iterator[Problem]:
    """Everything that is wrong with the model as a whole, with key paths."""
    if not model.rods:
        yield Problem(
            "rods", "", "the model has no rod", "add one with add(name, rod), or a table [rods.NAME]"
        )
        return
    found = [*_unknown_places(model), *_wrong_attachments(model)]
    yield from found
    if not found:
        yield from _clashes(model)
    yield from _once_per_rod(model, "velocities", "velocity")
    strains = list(_once_per_rod(model, "strains", "strain"))
    yield from strains
    if not found and not strains:
        yield from _unfit_strains(model)


def _unknown_places(model: ModelDescription) -> Iterator[Problem]:
    named = [(("supports", index, "at"), support.at) for index, support in enumerate(model.supports)]
    for index, load in enumerate(model.loads):
        if isinstance(load, Force | Moment):
            named.append((("loads", index, "at"), load.at))
        elif isinstance(load, DistributedForce | DistributedMoment | MovingForce):
            yield from _unknown_rod(("loads", index), load, model.rods)
    for index, attachment in enumerate(model.attachments):
        named += [(("attachments", index, "a"), attachment.a), (("attachments", index, "b"), attachment.b)]
    for path, text in named:
        try:
            find_place(text, model.rods)
        except RefusedError as error:
            yield Problem(path_text(path), error.found or show(text), error.why, error.instead)


def _unknown_rod(
    path: tuple[str | int, ...],
    load: DistributedForce | DistributedMoment | MovingForce,
    rods: Mapping[str, Rod],
) -> Iterator[Problem]:
    try:
        rod = find_rod(load.rod, rods)
    except RefusedError as error:
        yield Problem(path_text((*path, "rod")), error.found or "", error.why, error.instead)
        return
    if isinstance(load, MovingForce):
        return
    for key, s in (("from_s", load.from_s), ("to_s", load.to_s)):
        try:
            station_on(rod, s or 0.0, load.rod)
        except RefusedError as error:
            yield Problem(path_text((*path, key)), error.found or "", error.why, error.instead)
    try:
        load.density(rod.length / 2.0)
    except RefusedError as error:
        yield Problem(path_text((*path, "value")), error.found or "", error.why, error.instead)


def _wrong_attachments(model: ModelDescription) -> Iterator[Problem]:
    seen: set[frozenset[Place]] = set()
    for index, attachment in enumerate(model.attachments):
        try:
            a, b = find_place(attachment.a, model.rods), find_place(attachment.b, model.rods)
        except RefusedError:
            continue  # reported with the places
        where = f"attachments[{index}]"
        positions = [position_of(model, place)[0] for place in (a, b)]
        gap = float(np.linalg.norm(positions[0] - positions[1]))
        if a.rod == b.rod and abs(a.s - b.s) <= ROUND_OFF * model.rods[a.rod].length:
            yield Problem(where, str(a), "a place cannot be attached to itself", "give two places")
        elif gap > GAP * max(model.rods[place.rod].length for place in (a, b)):
            yield Problem(
                where,
                f"{attachment.a} at {_point(positions[0])} and {attachment.b} at {_point(positions[1])}",
                f"places can be attached only where they coincide; the gap is {gap:.6g} m",
                "move one of the rods so that the places meet",
            )
        elif frozenset((a, b)) in seen:
            yield Problem(
                where, f"{attachment.a} and {attachment.b}", "they are attached already", "leave one out"
            )
        seen.add(frozenset((a, b)))


def _once_per_rod(model: ModelDescription, key: str, noun: str) -> Iterator[Problem]:
    """Initial velocities or strains of rods that do not exist, or of one rod twice."""
    first: dict[str, int] = {}
    for index, given in enumerate(getattr(model, key)):
        where = f"{key}[{index}].rod"
        try:
            find_rod(given.rod, model.rods)
        except RefusedError as error:
            yield Problem(where, error.found or "", error.why, error.instead)
            continue
        if given.rod in first:
            yield Problem(
                where,
                show(given.rod),
                f"the rod has its initial {noun} already from {key}[{first[given.rod]}]",
                "give each rod one at most",
            )
        first.setdefault(given.rod, index)


def _unfit_strains(model: ModelDescription) -> Iterator[Problem]:
    """Strains of rods whose shape is given elsewhere than at their starts."""
    for index, strain in enumerate(model.strains):
        places = [(f"attachments[{k}]", text) for k, a in enumerate(model.attachments) for text in (a.a, a.b)]
        places += [(f"supports[{k}]", support.at) for k, support in enumerate(model.supports)]
        for path, text in places:
            place = find_place(text, model.rods)
            if place.rod == strain.rod and (path.startswith("attachments") or place.s > 0.0):
                yield Problem(
                    f"strains[{index}].rod",
                    show(strain.rod),
                    f"initial strains move all of the rod but its start, and {path} holds {text}",
                    "leave the strain out and start from an equilibrium, or hold the rod at its start only",
                )
                break


def position_of(model: ModelDescription, place: Place) -> tuple[Floats, Floats]:
    """Position (3,) and frame (3, 3) of a place in the reference shape."""
    position, frame = model.rods[place.rod].frames([place.s])
    return position[0], frame[0]


def resolved_supports(model: ModelDescription) -> list[ResolvedSupport]:
    """The supports with their stations and axes, in order."""
    resolved = []
    for index, support in enumerate(model.supports):
        place = find_place(support.at, model.rods)
        resolved.append(support.resolve(f"supports[{index}]", place, position_of(model, place)[1]))
    return resolved


def joined_places(model: ModelDescription) -> list[tuple[Place, ...]]:
    """The groups of places that attachments join into one node each, in the order of their first mention."""
    groups: list[list[Place]] = []
    for attachment in model.attachments:
        joined = [find_place(attachment.a, model.rods), find_place(attachment.b, model.rods)]
        for group in [group for group in groups if any(same(model, p, q) for p in group for q in joined)]:
            groups.remove(group)
            joined = group + [p for p in joined if not any(same(model, p, q) for q in group)]
        groups.append(joined)
    return [tuple(group) for group in groups]


def same(model: ModelDescription, a: Place, b: Place) -> bool:
    """Whether two places are the same station of the same rod."""
    return a.rod == b.rod and abs(a.s - b.s) <= ROUND_OFF * model.rods[a.rod].length


def required_stations(model: ModelDescription, name: str) -> tuple[float, ...]:
    """Arc lengths at which an element of the rod must end, increasing, without near-duplicates."""
    rod = find_rod(name, model.rods)
    stations = [0.0, rod.length, *rod.section_breaks]
    texts = [support.at for support in model.supports]
    texts += [text for attachment in model.attachments for text in (attachment.a, attachment.b)]
    for load in model.loads:
        if isinstance(load, Force | Moment):
            texts.append(load.at)
        elif isinstance(load, DistributedForce | DistributedMoment) and load.rod == name:
            stations += [station_on(rod, s, name) for s in (load.from_s, load.to_s) if s is not None]
    places = [find_place(text, model.rods) for text in texts]
    stations += [place.s for place in places if place.rod == name]
    kept: list[float] = []
    for s in sorted(stations):
        if not kept or s - kept[-1] > ROUND_OFF * rod.length:
            kept.append(s)
    return (*kept[:-1], rod.length)


def _clashes(model: ModelDescription) -> Iterator[Problem]:
    """Pairs of supports that hold the same motion of the same node.

    Two supports clash when the directions they hold are linearly dependent, whatever axes they are given in.
    """
    if len(model.supports) < 2:
        return
    groups = joined_places(model)
    for first, second in combinations(resolved_supports(model), 2):
        if not _one_node(model, first.place, second.place, groups):
            continue
        for words, noun in ((MOTIONS[:3], "displacement"), (MOTIONS[3:], "rotation")):
            held = [_directions(support, words) for support in (first, second)]
            both = np.vstack(held)
            if len(both) and np.linalg.matrix_rank(both, tol=1e-8) < len(both):
                common = [word for word in words if word in first.held and word in second.held]
                what = ", ".join(common) if common and first.frame == second.frame else f"a {noun}"
                yield Problem(
                    f"{second.path}.at",
                    f"{second.label}, with {first.label} ({first.path}) before it",
                    f"both hold {what} of the same node",
                    "leave one of the two supports out, or let each hold other motions",
                )
                break


def _directions(support: ResolvedSupport, words: Sequence[str]) -> Floats:
    columns = [index for index, word in enumerate(words) if word in support.held]
    return support.axes[:, columns].T.reshape(-1, 3)


def _one_node(model: ModelDescription, a: Place, b: Place, groups: list[tuple[Place, ...]]) -> bool:
    return same(model, a, b) or any(
        any(same(model, a, p) for p in group) and any(same(model, b, p) for p in group) for group in groups
    )


def _point(position: Floats) -> str:
    return f"({', '.join(f'{x:.6g}' for x in position)})"
