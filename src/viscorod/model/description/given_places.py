"""Places of a part that is added to a model: those that are not there are told at once, where they are given."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, TypeVar, cast

from viscorod.errors import Fault, InputError
from viscorod.model.actions.load_base import AnyLoad
from viscorod.model.connections.joint_base import AnyJoint
from viscorod.model.connections.place import GROUND, find_rod, no_part
from viscorod.model.connections.resolved_places import find
from viscorod.model.connections.rigid_attachment import Attachment
from viscorod.model.connections.spring import AnySpring
from viscorod.model.connections.support_base import AnySupport
from viscorod.wording import RefusedError, path_text, show

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["known_rod", "misplaced", "placed"]

P = TypeVar("P")


def placed(model: object, part: P) -> P:
    """Return a part whose places, rods and bodies are all in the model.

    Raises:
        InputError: one is not; add the rod or the body first.
    """
    faults = [
        Fault(path_text((type(part).__name__, *error.at)), error.found or "", error.why, error.instead)
        for error in misplaced(cast("ModelDescription", model), part)
    ]
    if faults:
        raise InputError(faults)
    return part


def misplaced(model: ModelDescription, part: Any) -> Iterator[RefusedError]:
    """Yield why places, rods or bodies of a part are not in the model, each with its key."""
    if isinstance(part, AnyLoad):
        yield from part.misfits(model)
        return
    for key, text in _places(part).items():
        try:
            if text != GROUND:
                find(model, text)
        except RefusedError as error:
            yield RefusedError(error.why, error.instead, found=error.found or show(text), at=(key,))


def _places(part: Any) -> dict[str, str]:
    """Return the places of a part by their keys."""
    if isinstance(part, AnySupport):
        return {"at": part.at}
    if isinstance(part, AnyJoint | Attachment):
        return {"a": part.a, "b": part.b}
    if isinstance(part, AnySpring):
        return dict(zip(("at", "to"), part.ends, strict=True))
    return {}


def known_rod(model: object, rod: str, kind: str, *, or_body: bool = False) -> None:
    """Refuse the name of a rod, or of a body, that is not in the model.

    Raises:
        InputError: there is none.
    """
    parts = cast("ModelDescription", model)
    if or_body and rod in parts.bodies:
        return
    try:
        find_rod(rod, parts.rods, parts.bodies)
    except RefusedError as refused:
        either = or_body and bool(parts.bodies)
        error = no_part(rod, parts.rods, parts.bodies) if either else refused
        raise InputError(Fault(f"{kind}.rod", error.found or "", error.why, error.instead)) from None
