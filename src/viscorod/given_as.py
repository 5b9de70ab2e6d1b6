"""Types of what users give, where it is more than what they get.

A field of a described object is read as one type, such as a float, and given as several: a number, a text with a unit,
a quantity of Pint. Type checkers read the latter from the descriptor, as in a dataclass; while a program runs there is
only the former.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Generic, SupportsFloat, TypeAlias, TypeVar

import numpy.typing as npt

__all__ = ["Amount", "Amounts", "GivenAs", "Words"]

Got_co = TypeVar("Got_co", covariant=True)
Taken_contra = TypeVar("Taken_contra", contravariant=True)

Amount: TypeAlias = SupportsFloat | str
"""A number in SI, text with a unit, such as "10 um", or a quantity of Pint or Astropy."""
Amounts: TypeAlias = Sequence[Amount] | npt.NDArray[Any]
"""Several of them, such as the components of a vector."""
Words: TypeAlias = str | Sequence[str]
"""One word, or several."""

if TYPE_CHECKING:

    class GivenAs(Generic[Got_co, Taken_contra]):
        """A field that is read as the first type and given as the second."""

        def __get__(self, instance: object, owner: object) -> Got_co: ...

        def __set__(self, instance: object, value: Taken_contra) -> None: ...

else:

    class GivenAs:
        """The type that is got."""

        def __class_getitem__(cls, kinds: tuple[Any, Any]) -> Any:
            return kinds[0]
