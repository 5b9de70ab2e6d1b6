"""Numbers of a measurement that nobody knows: when it was released, where zero is, how the camera stood."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from viscorod.argument_names import known_arguments
from viscorod.checks import number, text
from viscorod.errors import Fault, InputError

__all__ = ["Unknown", "resolved"]


@known_arguments
@dataclass(frozen=True)
class Unknown:
    """A number that is not the material's and is fitted along: of the measurement, or of the model by its key.

    What is believed beforehand is a normal distribution about `start` with the standard deviation `deviation`, cut at
    `low` and `high`; without a deviation everything between the two is as likely.

    Attributes:
        name: a word that the kind of record knows, such as "offset" or "release_time"; with `key` any name, such as
            "clamp_compliance", "air_drag" or "start_shape".
        start: the likeliest value beforehand; left out, 0, of a gain 1, of a key what the case says.
        deviation: standard deviation of that belief, in the SI unit of the number; infinite where nothing is known.
        low, high: bounds; left out, those of the word.
        key: of the number of the case that it stands for, "springs[0].stiffness.ry".
        shared: a name under which several records mean the same number, "camera"; left out, each record has its own.

    Raises:
        InputError: a number is none, a deviation is not positive, or the start is outside the bounds.
    """

    name: str
    start: float | None = None
    deviation: float = math.inf
    low: float | None = None
    high: float | None = None
    key: str | None = None
    shared: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.replace("_", "").isalnum():
            raise InputError(
                Fault("name", repr(self.name), "no name of an unknown", "give a word such as 'offset'")
            )
        where = f"unknown {self.name}"
        for name in ("start", "low", "high", "deviation"):
            value = getattr(self, name)
            unbounded = isinstance(value, float) and math.isinf(value) and name != "start"
            if (value is not None or name == "deviation") and not unbounded:
                object.__setattr__(self, name, number(f"{where}: {name}", value))
        for name in ("key", "shared"):
            if getattr(self, name) is not None:
                text(f"{where}: {name}", getattr(self, name))
        if not self.deviation > 0.0:
            raise InputError(
                Fault(where, f"{self.deviation:g}", "a deviation is positive", "give a number > 0")
            )
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise InputError(
                Fault(where, f"{self.low:g} to {self.high:g}", "low is not below high", "exchange them")
            )
        for name, over in (("low", -1.0), ("high", 1.0)):
            bound = getattr(self, name)
            if bound is not None and self.start is not None and over * (self.start - bound) > 0.0:
                raise InputError(
                    Fault(where, f"{self.start:g}", f"the start is beyond {name} = {bound:g}", "change one")
                )

    def over(self, start: float, low: float, high: float) -> Unknown:
        """Return it with what was left out."""
        start = start if self.start is None else self.start
        low = min(low, start) if self.low is None else self.low
        high = max(high, start) if self.high is None else self.high
        return replace(self, start=min(max(start, low), high), low=low, high=high)


def resolved(
    record: str, unknown: Sequence[str | Unknown], known: dict[str, tuple[float, float, float]]
) -> dict[str, Unknown]:
    """Return the unknowns of a record by their full names, "tip.offset", or "camera.gain" of a shared one.

    Args:
        record: its name.
        unknown: words or `Unknown`.
        known: words of this kind of record, with start, low and high.

    Raises:
        InputError: a word is not known, or comes twice.
    """
    if isinstance(unknown, str | Unknown):
        unknown = [unknown]
    found: dict[str, Unknown] = {}
    for item in unknown:
        one = item if isinstance(item, Unknown) else Unknown(str(item) if isinstance(item, str) else "")
        if one.key is None and one.name not in known:
            raise InputError(
                Fault(
                    f"record {record}: unknown",
                    repr(one.name),
                    "this kind of record has no such unknown",
                    f"give one of {', '.join(known) or 'none'}, or Unknown({one.name!r}, key=...) with the key of a "
                    "number of the case",
                )
            )
        full = f"{one.shared or record}.{one.name}"
        if full in found:
            raise InputError(
                Fault(f"record {record}: unknown", one.name, "it is there twice", "leave one out")
            )
        found[full] = one if one.key is not None else one.over(*known[one.name])
    return found
