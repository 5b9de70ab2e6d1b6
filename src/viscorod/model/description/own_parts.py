"""What a model tells of its own parts: one line, a card, mass, a table; and how they are removed."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from viscorod.attributes import UnknownAttributeError, WellNamed
from viscorod.errors import Fault, InputError
from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.connections.place import Place
from viscorod.model.rod import Rod
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing, on_paper
from viscorod.typing import Floats
from viscorod.wording import RefusedError, did_you_mean, show, some_of

__all__ = ["OwnParts"]

NOUNS = {
    "rods": ("rod", "rods"),
    "bodies": ("body", "bodies"),
    "supports": ("support", "supports"),
    "loads": ("load", "loads"),
    "attachments": ("attachment", "attachments"),
    "joints": ("joint", "joints"),
    "springs": ("spring", "springs"),
    "velocities": ("initial velocity", "initial velocities"),
    "strains": ("initial strain", "initial strains"),
    "rest_strains": ("rest strain", "rest strains"),
}
"""Parts of a model, one and several."""
POINTS = 60
"""Points of a rod in a small drawing."""


class OwnParts(WellNamed, Shown, ABC):
    """Methods about the parts that are there; a part of `ModelDescription`."""

    rods: dict[str, Rod]
    bodies: dict[str, AnyBody]

    @abstractmethod
    def parts(self) -> dict[str, Any]:
        """Return the parts by the words of a case file."""

    @property
    def mass(self) -> float:
        """The mass of all rods and bodies, kg.

        Raises:
            InputError: a section was given without inertia.
        """
        return sum(rod.mass for rod in self.rods.values()) + sum(
            body.total_mass() for body in self.bodies.values()
        )

    def remove(self, name: str) -> None:
        """Remove a rod, a body, or what else has this name: a load, a joint, a spring.

        What holds, loads or joins a rod or body that is removed stays, and is refused when something is computed:
        remove it from ``supports``, ``loads`` and the other lists too.

        Raises:
            InputError: nothing has this name.
        """
        if not isinstance(name, str):
            raise InputError(Fault("name", show(name), "text is needed here", "give the name in quotes"))
        for table in (self.rods, self.bodies):
            if name in table:
                del table[name]
                return
        known = [*self.rods, *self.bodies]
        for listed in self.parts().values():
            if isinstance(listed, Mapping):
                continue
            for number, part in enumerate(listed):
                own = getattr(part, "name", None)
                known += [own] if own else []
                if own == name:
                    del listed[number]
                    return
        raise InputError(
            Fault(
                "name",
                show(name),
                "nothing in the model has this name",
                f"{did_you_mean(name, known)}it has {some_of(known) or 'no parts with names'}",
            )
        )

    def summary(self) -> str:
        """Return the parts of the model, a line for each."""
        lines = [repr(self).strip("<>")]
        for key, listed in self.parts().items():
            if not listed:
                continue
            lines += ["", NOUNS[key][1].capitalize()]
            if isinstance(listed, Mapping):
                lines += [f"  {name}: {part!r}" for name, part in listed.items()]
            else:
                lines += [f"  {part!r}" for part in listed]
        return "\n".join(lines)

    def _facts(self) -> Iterator[str]:
        for key, listed in self.parts().items():
            if listed:
                yield counted(len(listed), *NOUNS[key])
        if not self.rods:
            yield "no rods"

    def _drawing(self) -> str:
        """Return the reference shape: rods as lines, supports as squares, mass centres of bodies as dots."""
        lines = [rod.frames(np.linspace(0.0, rod.length, POINTS))[0] for rod in self.rods.values()]
        held = [point for support in self.parts()["supports"] if (point := self._at(support.at)) is not None]
        centres = [np.asarray(body.centre) for body in self.bodies.values()]
        *curves, squares, dots = on_paper([*lines, np.reshape(held, (-1, 3)), np.reshape(centres, (-1, 3))])
        drawing = Drawing()
        for curve in curves:
            drawing.line(curve)
        drawing.squares(squares)
        drawing.dots(dots)
        return drawing.svg()

    def _at(self, text: str) -> Floats | None:
        """Return where a place is; None if it is not in the model yet."""
        from viscorod.model.connections.place import find_place

        try:
            place = find_place(text, self.rods, self.bodies)
        except RefusedError:
            return None
        if isinstance(place, Place):
            found: Floats = self.rods[place.rod].frames([place.s])[0][0]
            return found
        return self.bodies[place.body].position(place.point)

    def __eq__(self, other: object) -> bool:
        """Return whether both are of one class and have the same parts in the same order."""
        if type(self) is not type(other):
            return NotImplemented
        assert isinstance(other, OwnParts)
        mine, theirs = self.parts(), other.parts()
        return mine == theirs and all(list(mine[key]) == list(theirs[key]) for key in ("rods", "bodies"))

    def __hash__(self) -> int:
        """Return what equal models share, for their parts may change."""
        return hash(type(self).__qualname__)

    def __setattr__(self, name: str, value: Any) -> None:
        """Set a list of parts; any other name of this class is a method, or a slip that would do nothing."""
        if name in _LISTS or name.startswith("_") or not (_is_own(type(self)) or hasattr(type(self), name)):
            super().__setattr__(name, value)
            return
        if hasattr(type(self), name):
            raise InputError(
                Fault(
                    f"{type(self).__name__}.{name}", show(value), "it cannot be set", f"call it: {name}(...)"
                )
            )
        raise UnknownAttributeError.of(self, name)


def _is_own(kind: type) -> bool:
    """Return whether a class is one of this package."""
    return kind.__module__.startswith("viscorod.")


_LISTS = frozenset((*NOUNS, "materials", "sections"))
