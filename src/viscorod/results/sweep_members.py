"""The members of a sweep, kept as columns: a million of them take some hundred bytes each.

Whole results that are on disk are read when they are asked for, and the last few stay.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, overload

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.results.files.storage import load
from viscorod.results.quantity_values import Number
from viscorod.results.sweep_figures import figures_of
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult

    Stored: TypeAlias = AnyResult | Path | Callable[[], AnyResult] | None

__all__ = [
    "COMPLETED",
    "NOT_KEPT",
    "NOT_RUN",
    "Found",
    "FoundMembers",
    "Rows",
    "Stack",
    "SweepMembers",
    "SweepRun",
]

COMPLETED = "completed"
NOT_RUN = "not run"
NOT_KEPT = "not kept"
"""Of a member that is finished and that the folder could not take."""

Found: TypeAlias = tuple[Any, ...]
"""What is known of a member: its result or its file or None, message, outcome, quantities, figures."""
NOTHING: Found = (None, "", NOT_RUN, {}, {})
READ = 16
"""Members read from disk that stay in memory."""


class Stack(Protocol):
    """Whole results of all completed members in one place, see ``viscorod.results.files.sweep_store``."""

    separate: str

    def parts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return variables and coordinates of all members."""


def opened(stored: Stored) -> AnyResult | None:
    """Return a whole result, read if it is not in memory; None if none is kept."""
    if isinstance(stored, Path):
        found: AnyResult = load(stored)  # a member is no sweep
        return found
    return stored() if callable(stored) else stored


@known_arguments
@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep.

    Attributes:
        number: place in the table of values, from 0.
        values: parameter -> value, as given.
        stored: the result, the file that it is in, a function that reads it, or None.
        message: why it failed, empty if it did not, and which quantities could not be computed.
        outcome: "completed", or what stopped it.
        quantities: the numbers that were asked for, by name; those that there are.
        measured: cost and other figures, where the result itself is not kept.
    """

    number: int
    values: Mapping[str, Any]
    stored: Stored = None
    message: str = ""
    outcome: str = COMPLETED
    quantities: Mapping[str, Number] = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def result(self) -> AnyResult | None:
        """The run, equilibrium or other result; where it failed, what there is up to there; None if none is kept."""
        return opened(self.stored)

    @property
    def completed(self) -> bool:
        """True if it was computed to its end."""
        return self.outcome == COMPLETED

    def figures(self) -> dict[str, float]:
        """Return numbers of the result by which members are compared, see ``viscorod.results.sweep_figures``."""
        return dict(self.measured) or figures_of(self.result)


class Rows(Sequence[dict[str, Any]]):
    """The values of all members, a column for every key.

    Attributes:
        columns: key -> its values, one per member.
        units: key, or name of a quantity -> SI unit of its numbers, of those that have one and for which it is known.
    """

    def __init__(
        self, columns: Mapping[str, Sequence[Any]], count: int, units: Mapping[str, str] | None = None
    ) -> None:
        self.columns = {key: list(column) for key, column in columns.items()}
        self.units = dict(units or {})
        self._count = count

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, at: int) -> dict[str, Any]: ...
    @overload
    def __getitem__(self, at: slice) -> list[dict[str, Any]]: ...
    def __getitem__(self, at: int | slice) -> dict[str, Any] | list[dict[str, Any]]:
        if isinstance(at, slice):
            return [self[k] for k in range(*at.indices(self._count))]
        k = range(self._count)[at]
        return {key: column[k] for key, column in self.columns.items()}


class FoundMembers(MutableMapping[int, Found]):
    """What is known of the members of a sweep, by their numbers; nothing of those that are not in it.

    Args:
        count: members of the sweep.
        names: of the quantities that are numbers, which have a column also where no member has them.
    """

    def __init__(self, count: int, names: Iterable[str] = ()) -> None:
        self._outcomes = [NOT_RUN]
        self._outcome = np.full(count, -1, dtype=np.int16)
        self._messages: dict[int, str] = {}
        self._stored: dict[int, Any] = {}
        self._numbers: tuple[dict[str, Floats], dict[str, Floats]] = (
            {name: np.full(count, np.nan) for name in names},
            {},
        )
        self._histories: dict[int, dict[str, Floats]] = {}
        self._known = 0

    def __len__(self) -> int:
        return self._known

    def __iter__(self) -> Iterator[int]:
        return iter(np.flatnonzero(self._outcome >= 0).tolist())

    def __contains__(self, number: object) -> bool:
        return isinstance(number, int) and 0 <= number < len(self._outcome) and self._outcome[number] >= 0

    def __setitem__(self, number: int, found: Found) -> None:
        stored, message, outcome, quantities, measured = (*found, {}, {})[:5]
        self._known += number not in self
        if outcome not in self._outcomes:
            self._outcomes.append(outcome)
        self._outcome[number] = self._outcomes.index(outcome)
        for notes, note in ((self._messages, message), (self._stored, stored)):
            notes.pop(number, None)
            if note is not None and note != "":
                notes[number] = note
        histories = {
            name: np.array(value, dtype=float)
            for name, value in quantities.items()
            if isinstance(value, list)
        }
        self._histories.pop(number, None)
        if histories:
            self._histories[number] = histories
        for columns, given in zip(self._numbers, (quantities, measured), strict=True):
            for name in [*columns, *(name for name in given if name not in columns)]:
                value = given.get(name, np.nan)
                if not isinstance(value, list):
                    if name not in columns:
                        columns[name] = np.full(len(self._outcome), np.nan)
                    columns[name][number] = value

    def __delitem__(self, number: int) -> None:
        if number not in self:
            raise KeyError(number)
        self[number] = NOTHING
        self._outcome[number] = -1
        self._known -= 1

    def __getitem__(self, number: int) -> Found:
        if number not in self:
            raise KeyError(number)
        quantities, measured = (
            {name: float(column[number]) for name, column in columns.items() if not np.isnan(column[number])}
            for columns in self._numbers
        )
        return (
            self._stored.get(number),
            self._messages.get(number, ""),
            self._outcomes[self._outcome[number]],
            quantities | {name: value.tolist() for name, value in self._histories.get(number, {}).items()},
            measured,
        )

    def is_completed(self, number: int) -> bool:
        """Return whether a member was computed to its end."""
        return number in self and self._outcomes[self._outcome[number]] == COMPLETED

    def first_of(self, outcome: str) -> int | None:
        """Return the number of the first member with an outcome; None if there is none."""
        if outcome not in self._outcomes:
            return None
        return next(iter(np.flatnonzero(self._outcome == self._outcomes.index(outcome)).tolist()), None)

    def outcomes(self) -> list[str]:
        """Return the outcomes of all members."""
        return [self._outcomes[max(0, code)] for code in self._outcome.tolist()]

    def completed(self) -> np.ndarray:
        """Return which members were computed to their end ``(members,)``."""
        if COMPLETED not in self._outcomes:
            return np.zeros(len(self._outcome), dtype=bool)
        return np.asarray(self._outcome == self._outcomes.index(COMPLETED))

    def with_results(self) -> list[int]:
        """Return the numbers of the members whose whole results are kept, in order."""
        return sorted(self._stored)

    def stored(self, number: int) -> Stored:
        """Return the whole result of a member, or where it is; None if it is not kept."""
        found: Stored = self._stored.get(number)
        return found

    def told(self) -> dict[int, str]:
        """Return the messages, by member, in order."""
        return dict(sorted(self._messages.items()))

    @property
    def quantities(self) -> dict[str, Floats]:
        """Quantities that are numbers, in columns of all members; NaN of those that do not have one."""
        return self._numbers[0]

    @property
    def measured(self) -> dict[str, Floats]:
        """Figures in such columns; of results that are kept they are read from these."""
        return self._numbers[1]

    def history(self, number: int, name: str) -> Floats | None:
        """Return a history of a member, if it has it."""
        return self._histories.get(number, {}).get(name)

    @property
    def histories(self) -> tuple[str, ...]:
        """Names of the quantities that are histories."""
        return tuple(dict.fromkeys(name for found in self._histories.values() for name in found))


class SweepMembers(Sequence[SweepRun]):
    """All members of a sweep, each of which is made when it is asked for.

    Attributes:
        rows: their values; found: what is known of them.
        stack: whole results of all of them in one place, where they are.
    """

    def __init__(self, rows: Rows, found: FoundMembers) -> None:
        self.rows, self.found = rows, found
        self.stack: Stack | None = None
        self._kept: dict[int, SweepRun] = {}
        self._read: dict[int, SweepRun] = {}

    @classmethod
    def of(cls, members: Iterable[SweepRun], names: Iterable[str] = ()) -> SweepMembers:
        """Return members that are there one by one, of which quantities with these ``names`` were asked."""
        given = list(members)
        keys = list(given[0].values) if given else []
        rows = Rows({key: [member.values[key] for member in given] for key in keys}, len(given))
        found = FoundMembers(len(given), names)
        for k, m in enumerate(given):
            found[k] = m.stored, m.message, m.outcome, m.quantities, m.measured
        return cls(rows, found)

    def __len__(self) -> int:
        return len(self.rows)

    @overload
    def __getitem__(self, at: int) -> SweepRun: ...
    @overload
    def __getitem__(self, at: slice) -> tuple[SweepRun, ...]: ...
    def __getitem__(self, at: int | slice) -> SweepRun | tuple[SweepRun, ...]:
        if isinstance(at, slice):
            return tuple(self[k] for k in range(*at.indices(len(self))))
        k = range(len(self))[at]
        if k in self._kept:
            return self._kept[k]
        member = self._read.pop(k, None) or SweepRun(k, self.rows[k], *self.found.get(k, NOTHING))
        if isinstance(member.stored, Path) or callable(member.stored):
            self._read[k] = member  # the last one is read last
            if len(self._read) > READ:
                del self._read[next(iter(self._read))]
        elif member.stored is not None:
            self._kept[k] = member
        return member

    def stored(self, number: int) -> Stored:
        """Return the whole result of a member, or where it is; None if it is not kept."""
        return self.found.stored(number)

    def data(self, number: int) -> xr.Dataset:
        """Return the data set of the whole result of a member that is kept, which does not stay in memory."""
        result = opened(self.stored(number))
        assert result is not None
        return result.data

    def kept(self) -> bool:
        """Return whether any whole result is kept."""
        return bool(self.found._stored)
