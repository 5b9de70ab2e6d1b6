"""Attributes that are not there: told with the nearest one that is."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Self, TypeVar

from viscorod.errors import Fault, InputError, problems_text
from viscorod.wording import did_you_mean, some_of

__all__ = ["ByName", "UnknownAttributeError", "UnknownNameError", "WellNamed"]

T = TypeVar("T")

ELSEWHERE = {
    "to_dataframe": ("table", "data"),
    "to_pandas": ("table", "data"),
    "df": ("table", "data"),
    "to_xarray": ("data",),
    "dataset": ("data",),
    "to_csv": ("save_csv", "table"),
    "to_netcdf": ("save",),
    "write": ("save",),
    "show": ("plot", "draw"),
    "summary": ("report",),
    "t": ("time",),
    "solve": ("equilibrium",),
    "run": ("simulate",),
    "eigenvalues": ("modes",),
    "damping": ("damping_ratios",),
}
"""What other libraries call it, and what it is here: the first that an object has."""


INNER = frozenset(
    [
        "resolved_supports",
        "resolved_joints",
        "resolved_springs",
        "with_known_times",
        "hints",
        "renamed",
        "tag",
        "unused",
        "pending",
        "resolve",
        "held",
        "axes_at",
        "label",
        "ends",
        "free_motions",
        "held_motions",
        "word",
        "arrows",
        "breakpoints",
        "breaks",
        "figures",
        "jumps",
        "misfits",
        "passages",
        "sees_motion",
        "travels",
        "wrench",
        "by_material",
        "can_taper",
        "needs_material",
        "no_material",
        "refuse_material",
        "inertial_density",
        "given_moduli",
        "chosen_elements",
        "section_breaks",
        "typical_sections",
        "relaxing",
        "viscous",
        "owning",
        "later",
        "recorded_rods",
        "displacement_range",
        "rests",
        "ends_of_steps",
        "with_errors",
        "count_completed",
    ]
)
"""What other modules read of the objects that a user makes and gets, and what is no answer to a slip of the user's."""


class UnknownNameError(InputError, KeyError):
    """Nothing has this name."""

    def __str__(self) -> str:
        return problems_text(self.problems, self.heading)


class ByName(dict[str, T]):
    """Parts by their names: a name that none has is told with the nearest one.

    Args:
        nouns: what the parts are called, several, such as "rods".
    """

    def __init__(self, nouns: str) -> None:
        super().__init__()
        self._nouns = nouns

    def __missing__(self, name: Any) -> T:
        advice = did_you_mean(str(name), self) + (
            f"the {self._nouns} are {some_of(self)}" if self else f"there are no {self._nouns}"
        )
        raise UnknownNameError(Fault(f"{self._nouns}[{name!r}]", "", "nothing has this name", advice))

    def __getattr__(self, name: str) -> Any:
        """Refuse a name that is asked for with a dot, and say how parts are asked for."""
        if name.startswith("_"):
            raise AttributeError(name)
        raise UnknownAttributeError(self._nouns, name, [f"[{part!r}]" for part in self])

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._nouns,), None, None, iter(self.items())


class UnknownAttributeError(InputError, AttributeError):
    """An object has no attribute of this name.

    The nearest name is looked for when the message is read: ``hasattr`` asks for many names, and reads none.
    """

    def __init__(self, called: str, name: str, known: Callable[[], list[str]] | list[str]) -> None:
        ValueError.__init__(self)
        self._called, self._name, self._known = called, name, known
        self.heading = ""

    @classmethod
    def of(
        cls, owner: object, name: str, known: Callable[[], list[str]] | None = None, *, called: str = ""
    ) -> Self:
        """Return the error for a name that an object has not."""

        def public() -> list[str]:
            return [word for word in dir(owner) if not word.startswith("_") and word not in INNER]

        return cls(called or type(owner).__name__, name, known or public)

    @property
    def problems(self) -> tuple[Fault, ...]:
        """What is wrong, with the nearest name that there is."""
        words = self._known if isinstance(self._known, list) else self._known()
        meant = next((word for word in ELSEWHERE.get(self._name, ()) if word in words), None)
        near = f"did you mean {meant}?" if meant else did_you_mean(self._name, words, str).strip()
        advice = near or f"it has {some_of(words)}"
        return (Fault(f"{self._called}.{self._name}", "", f"there is no attribute {self._name!r}", advice),)

    def __str__(self) -> str:
        return problems_text(self.problems, self.heading)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (
            self._called,
            self._name,
            self._known if isinstance(self._known, list) else self._known(),
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
