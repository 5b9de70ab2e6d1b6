"""Named numbers of a result, in words: ``("displacement", "beam.end", "y", "max")``, ``("frequency", 1)``.

A sweep computes them where a member is computed, so that whole results need not be kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.results.any_result import result_class
from viscorod.results.data_schema import VARIABLES
from viscorod.results.function_record import function_record
from viscorod.results.quantity_values import FIELDS, HISTORY, OTHERS, Number, Word, field_value, unit_of
from viscorod.results.quantity_words import checked_words
from viscorod.results.sweep_figures import FIGURES

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["Quantities", "Quantity", "evaluated", "quantities_of"]

Quantities: TypeAlias = Mapping[str, Any]
"""Name -> words (a tuple, or a text with spaces), or a function of the result that returns a number."""

_RESERVED = ("member", "instant", "outcome", "message", "number", "axis", "station", "point", "component")


@dataclass(frozen=True)
class Quantity:
    """A named number of a result.

    Attributes:
        name: in tables.
        words: what it is; empty where there is a function.
        function: of the result.
    """

    name: str
    words: tuple[Word, ...] = ()
    function: Callable[[Any], Any] | None = None

    @property
    def place(self) -> str:
        """The place that it is read at; empty if there is none."""
        head = self.words[0] if self.words else ""
        return str(self.words[1]) if head == "decrement" or head in FIELDS else ""

    @property
    def unit(self) -> str:
        """SI unit; empty where it has none, is not known, as of functions, or its name says one: "tip [m]"."""
        return "" if self.name.endswith("]") else unit_of(self.words)

    @property
    def is_history(self) -> bool:
        """Whether it is many numbers, one after the other in time."""
        return bool(self.words) and self.words[-1] == HISTORY

    @property
    def record(self) -> str:
        """What it is, for comparison with another one: the words, or the function with what it takes from around it."""
        return repr(self.words) if self.function is None else function_record(self.function)

    def of(self, result: AnyResult) -> Number:
        """Return its value.

        Raises:
            InputError: the result has no such number.
        """
        if self.function is not None:
            return self._number(self.function(result))
        head = str(self.words[0])
        if head in FIELDS:
            return field_value(result, self.words)
        return self._number(OTHERS[head](result, self.words[1:]))

    def _number(self, value: Any) -> float:
        found = np.asarray(value)
        if found.size == 1 and found.dtype.kind in "fiub" and np.isfinite(found).all():
            return float(found.reshape(())[()])
        raise InputError(f"{value!r:.80} is not one finite number")


def evaluated(
    quantities: Sequence[Quantity], result: AnyResult | None
) -> tuple[dict[str, Number], list[str]]:
    """Return the numbers of a result by name, and why some could not be computed; none without a result."""
    numbers: dict[str, Number] = {}
    wrong: list[str] = []
    if result is None:
        return numbers, wrong
    for quantity in quantities:
        try:
            numbers[quantity.name] = quantity.of(result)
        except InputError as error:
            wrong.append(f"{quantity.name}: {error}")
        except (Exception, SystemExit) as error:  # a user's function may fail, or give up, for one member
            let_interrupts_through(error)
            wrong.append(f"{quantity.name}: {type(error).__name__}: {error}")
    return numbers, wrong


def quantities_of(given: Any, kind: str, taken: Iterable[str] = ()) -> tuple[Quantity, ...]:
    """Return quantities from their words, checked as far as there is no result.

    Args:
        given: name -> words or function.
        kind: the analysis, its table in a case file.
        taken: names that stand for something else in the same table.

    Raises:
        InputError: all that is wrong.
    """
    if not isinstance(given, Mapping):
        why, instead = (
            "names with their words are needed",
            'give {"tip": ("displacement", "beam.end", "y", "max")}',
        )
        raise InputError(Fault("quantities", repr(given)[:60], why, instead))
    found, faults = [], []
    reserved = {*taken, *FIGURES, *VARIABLES, *_variables(kind), *_RESERVED}
    for name, spec in given.items():
        if not isinstance(name, str) or not name or "/" in name:
            faults.append(Fault(f"quantities.{name}", "", "this is no name", "give a text without a slash"))
            continue
        if name in reserved:
            why = f"the table has a column or a variable {name!r} of its own"
            faults.append(Fault(f"quantities.{name}", "", why, f"give another name, such as 'my_{name}'"))
            continue
        if callable(spec):
            found.append(Quantity(name, (), spec))
            continue
        try:
            found.append(Quantity(name, checked_words(spec, kind)))
        except InputError as error:
            faults += [problem.within(f"quantities.{name}") for problem in error.problems]
    if faults:
        raise InputError(faults)
    return tuple(found)


def _variables(kind: str) -> Iterable[str]:
    """Return the names of the variables of a result without states."""
    found = getattr(result_class(kind), "variables", None)
    return () if found is None else found()
