"""Attributes that are not there: told with the nearest one that is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from viscorod.errors import Fault, InputError
from viscorod.wording import did_you_mean, some_of

__all__ = ["UnknownAttributeError", "WellNamed"]


class UnknownAttributeError(InputError, AttributeError):
    """An object has no attribute of this name."""

    @classmethod
    def of(cls, owner: object, name: str, known: list[str] | None = None, *, called: str = "") -> Self:
        """Return the error for a name that an object has not, with the nearest that it has."""
        words = known if known is not None else [word for word in dir(owner) if not word.startswith("_")]
        advice = did_you_mean(name, words, str)
        return cls(
            Fault(
                f"{called or type(owner).__name__}.{name}",
                "",
                f"there is no attribute {name!r}",
                advice.strip() or f"it has {some_of(words)}",
            )
        )


class WellNamed:
    """What gives an object's missing attributes a message, and lets none be set that nobody would read."""

    if not TYPE_CHECKING:  # or every name would pass for an attribute

        def __getattr__(self, name: str) -> Any:
            """Refuse a name that is not there, with the nearest one that is."""
            if name.startswith("_"):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            if hasattr(type(self), name):  # a property of this name failed: what it said counts
                return object.__getattribute__(self, name)
            raise UnknownAttributeError.of(self, name)
