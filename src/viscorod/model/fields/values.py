"""Checked numbers, vectors and words: the types of the fields of everything that a user describes.

Integers and NumPy numbers count as numbers; booleans, strings, NaN and infinities do not.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Annotated, Any, TypeAlias, TypeVar

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.given_as import Amount, Amounts, GivenAs
from viscorod.limits import LARGEST_NUMBER, SMALLEST_NUMBER
from viscorod.model.fields.definition import Definition, RefusedError, at_key, did_you_mean, show
from viscorod.model.fields.forms import NAME, POSITIVE, TEXT, Form, listed, quantity
from viscorod.model.fields.metadata import Check, accepts, optional
from viscorod.units import Measured

NOT_GIVEN = math.nan
"""Default of a number that is worked out from others when it is not given (a user's NaN is refused)."""

T = TypeVar("T")

Triple: TypeAlias = tuple[float, float, float]

TRIPLE: Form = listed(quantity(), 3, 3)


@accepts(quantity(), "number")
def number(value: Any) -> float:
    """Return `value` as a finite float."""
    if isinstance(value, np.ndarray) and value.ndim == 0:  # what SciPy's interpolants return for one time
        value = value[()]
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise RefusedError("a number is needed here", "give a plain number such as 0.25")
    try:
        converted = value if isinstance(value, Measured) else float(value)
    except OverflowError:
        converted = math.inf
    if not math.isfinite(converted):
        raise RefusedError("the number must be finite", "give a plain number such as 0.25")
    if abs(converted) > LARGEST_NUMBER:
        raise RefusedError("larger than any quantity in SI units", f"give a number below {LARGEST_NUMBER:g}")
    return converted


@accepts(quantity(), "number")
def amount(value: Any) -> float:
    """Return `value` as a finite float that is 0 or not absurdly small."""
    converted = number(value)
    if 0.0 < abs(converted) < SMALLEST_NUMBER:
        raise RefusedError(
            "smaller than any quantity in SI units", f"give 0, or a number above {SMALLEST_NUMBER:g}"
        )
    return converted


def bounded(allowed: str, **bounds: float) -> Check[float]:
    """Return a check for numbers within bounds.

    Args:
        allowed: the bounds in words, such as ">= 0".
        bounds: in words of JSON Schema: ``minimum``, ``exclusiveMinimum``, ``maximum``, ``exclusiveMaximum``.
    """
    least, most = bounds.get("minimum", -math.inf), bounds.get("maximum", math.inf)
    above, below = bounds.get("exclusiveMinimum", -math.inf), bounds.get("exclusiveMaximum", math.inf)
    check_size = amount if max(least, above) >= 0.0 else number

    @accepts(quantity(bounds=bounds), f"number {allowed}")
    def check(value: Any) -> float:
        converted = check_size(value)
        if not (least <= converted <= most and above < converted < below):
            raise RefusedError("outside what is allowed", f"give a number {allowed}")
        return converted

    return check


@accepts(quantity(bounds=POSITIVE), "number > 0")
def positive(value: Any) -> float:
    """Return `value` as a float > 0 that is not absurdly small."""
    converted = number(value)
    if converted <= 0.0:
        raise RefusedError("outside what is allowed", "give a number > 0")
    if converted < SMALLEST_NUMBER:
        raise RefusedError(
            "smaller than any quantity in SI units", f"give a number above {SMALLEST_NUMBER:g}"
        )
    return converted


def whole_number(low: int, high: int) -> Check[int]:
    """Return a check for whole numbers from `low` to `high`."""

    @accepts({"type": "integer", "minimum": low, "maximum": high}, f"whole number, {low} to {high}")
    def check(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not low <= value <= high:
            raise RefusedError("a whole number is needed here", f"give a whole number from {low} to {high}")
        return int(value)

    return check


def numbers(value: Any, *, count: int | None = None, at_least: int = 1) -> tuple[float, ...]:
    """Return `value` (list, tuple, array) as a tuple of finite floats."""
    items = sequence(value)
    if count is not None and len(items) != count:
        raise RefusedError(
            f"{count} numbers are needed here, {len(items)} were given", f"give a list of {count} numbers"
        )
    if len(items) < at_least:
        raise RefusedError(f"at least {at_least} numbers are needed here", "give a longer list of numbers")
    return each(items, number)


@accepts(listed(quantity(bounds=POSITIVE), 2, 2), "2 numbers > 0, the lower first")
def frequency_band(value: Any) -> tuple[float, float]:
    """Return `value` as a lower and a higher frequency > 0."""
    low, high = pair(value)
    if not SMALLEST_NUMBER <= low < high:
        raise RefusedError(
            "a band goes from a lower to a higher frequency", "give [low, high] in Hz, both > 0"
        )
    return low, high


def sequence(value: Any) -> Sequence[Any]:
    """Return `value` if it is a list, tuple or array, as a list or tuple."""
    if isinstance(value, np.ndarray):
        items: list[Any] = value.tolist() if value.ndim else []
        return items
    if not isinstance(value, list | tuple):
        raise RefusedError("a list is needed here", "give a list in brackets, such as [0.0, 1.0, 2.0]")
    return value


def items(value: Any) -> tuple[Any, ...]:
    """Return `value` as a tuple if it is a list, tuple or array."""
    return tuple(sequence(value))


def each(value: Any, check: Callable[[Any], T]) -> tuple[T, ...]:
    """Apply `check` to the items of a list; errors have the index of their item."""
    items, found = sequence(value), []
    try:
        for item in items:
            found.append(check(item))
    except ValueError:
        # once for the list: to enter `at_key` for every item takes longer than the check of a number
        with at_key(len(found), items[len(found)]):
            raise
    return tuple(found)


def different(value: Any, check: Callable[[Any], str], noun: str) -> tuple[str, ...]:
    """Return the words of a list, each once."""
    words = each(value, check)
    for index, given in enumerate(words):
        if given in words[:index]:
            raise RefusedError(f"the same {noun} twice", "give it once", found=show(given), at=(index,))
    return words


def entries(table: Mapping[Any, Any], name: Callable[[Any], str], check: Callable[[Any], T]) -> dict[str, T]:
    """Check the keys of a table by `name` and their values by `check`.

    Raises:
        InputError: everything that is wrong with keys and values.
    """
    found: dict[str, T] = {}
    problems: list[Fault] = []
    for key, value in table.items():
        try:
            with at_key(str(key), key):
                checked = name(key)
            with at_key(checked, value):
                found[checked] = check(value)
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    return found


@accepts(listed(quantity(), 2, 2), "2 numbers")
def pair(value: Any) -> tuple[float, float]:
    """Return `value` as two finite floats."""
    x, y = numbers(value, count=2)
    return x, y


@accepts(TRIPLE, "3 numbers")
def vector(value: Any) -> Triple:
    """Return `value` as three finite floats."""
    x, y, z = each(numbers(value, count=3), amount)
    return x, y, z


@accepts(TRIPLE, "3 numbers, not all 0; any length")
def direction(value: Any) -> Triple:
    """Return `value` as three floats scaled to unit length."""
    x, y, z = vector(value)
    size = math.hypot(x, y, z)
    if size == 0.0 or not math.isfinite(size):
        raise RefusedError(
            "this vector has no direction", "give three numbers that are not all zero, such as [0, 0, 1]"
        )
    if abs(size - 1.0) <= 4e-16:  # a unit vector read back from a file remains unchanged
        return x, y, z
    return x / size, y / size, z / size


@accepts(TEXT, "text, in quotes")
def word(value: Any) -> str:
    """Return `value` as text."""
    if not isinstance(value, str):
        raise RefusedError("text is needed here", "give it in quotes")
    return value


@accepts(NAME, "name, in quotes")
def name_of_part(value: Any) -> str:
    """Check a name of a rod, material or section: letters, digits, _ and -."""
    if not re.fullmatch(r"[A-Za-z_][\w-]{0,59}", word(value), flags=re.ASCII):
        raise RefusedError("not usable as a name", "use a letter, then letters, digits, _ or - (60 at most)")
    return str(value)


def one_of(*allowed: str) -> Check[str]:
    """Return a check for one of some fixed words."""

    @accepts({"enum": list(allowed)}, " or ".join(f'`"{word}"`' for word in allowed))
    def check(value: Any) -> str:
        if value not in allowed if isinstance(value, str) else True:
            raise RefusedError(
                "not one of the words that are known here",
                f"{did_you_mean(value, allowed)}give one of {', '.join(map(repr, allowed))}",
            )
        return str(value)

    return check


def one_number_of(*allowed: int) -> Check[int]:
    """Return a check for one of some whole numbers."""
    words = ", ".join(map(str, allowed[:-1])) + f" or {allowed[-1]}"

    @accepts({"enum": list(allowed)}, words)
    def check(value: Any) -> int:
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or value not in allowed:
            raise RefusedError("not one of the numbers that are possible here", f"give {words}")
        return int(value)

    return check


class OneOfRegistry(Check[str]):
    """A check for one of the names in a registry, to which more may be added later.

    Args:
        names: returns those that are registered at present.
    """

    def __init__(self, names: Callable[[], Iterable[str]]) -> None:
        # not by attributes: the base class is frozen
        self.__dict__.update(names=names, read=self._read_present, python="")

    def _read_present(self, value: Any) -> str:
        return self._present(value)

    @property
    def _present(self) -> Check[str]:
        return one_of(*self.__dict__["names"]())

    @property
    def form(self) -> Form | None:
        """The present names as JSON Schema."""
        return self._present.form

    @property
    def words(self) -> str:
        """The present names for people."""
        return self._present.words


@accepts({"type": "boolean"}, "`true` or `false`")
def true_or_false(value: Any) -> bool:
    """Return `value` if it is a boolean."""
    if not isinstance(value, bool):
        raise RefusedError("neither true nor false", "give true or false")
    return value


@accepts(None)
def function(value: Any) -> Callable[..., Any]:
    """Return `value` if it can be called."""
    if not callable(value):
        raise RefusedError("a Python function is needed here", "this can be given in the Python API only")
    result: Callable[..., Any] = value
    return result


def choose(
    tag: str,
    kinds: Mapping[str, type[Definition]],
    default: str | None = None,
    form: Form | None = None,
    words: str = "",
) -> Check[Definition]:
    """Return a check that lets objects of the given kinds through and reads a table by its key `tag`."""

    @accepts(form, words)
    def parse(value: Any) -> Definition:
        if isinstance(value, Definition) and isinstance(value, tuple(kinds.values())):
            return value
        known = ", ".join(map(repr, kinds))
        if isinstance(value, Definition):
            classes = ", ".join(kind.__name__ for kind in kinds.values())
            raise RefusedError(
                f"this cannot be a {type(value).__name__}",
                f"give one of {classes}",
                found=type(value).__name__,
            )
        if not isinstance(value, Mapping):
            raise RefusedError(
                "a table of keys and values is needed here", f"give a table with {tag} = one of {known}"
            )
        kind = value.get(tag, default)
        if kind is None:
            raise RefusedError(
                "this key is required and missing", f"add {tag} = one of {known}", found="", at=(tag,)
            )
        if not isinstance(kind, str) or kind not in kinds:
            advice = f"{did_you_mean(kind, kinds)}give one of {known}"
            raise RefusedError(f"no such {tag}", advice, found=show(kind), at=(tag,))
        if tag not in value:
            _require_meant(tag, kinds, kind, value)
        return kinds[kind].model_validate(value)

    return parse


def _require_meant(
    tag: str, kinds: Mapping[str, type[Definition]], default: str, value: Mapping[Any, Any]
) -> None:
    """Refuse a table without its kind, some of whose keys, or all, tell that it is none of the usual kind."""
    usual = kinds[default]
    strange = value.keys() - usual.model_fields.keys() - usual.renamed.keys()
    meant = [kind for kind, one in kinds.items() if strange and strange <= one.model_fields.keys()]
    meant = meant or [kind for kind in kinds if kind in strange]
    if meant:
        keys = ", ".join(sorted(map(str, strange)))
        raise RefusedError(
            f"this key is missing, and without it the table is of kind {default!r}, which has no {keys}",
            f"add {tag} = {' or '.join(map(repr, meant))}",
            found="",
            at=(tag,),
        )


non_negative = bounded(">= 0", minimum=0)

Number = Annotated[GivenAs[float, Amount], amount]
Positive = Annotated[GivenAs[float, Amount], positive]
NonNegative = Annotated[GivenAs[float, Amount], non_negative]
Proportion = Annotated[float, bounded("above 0 and below 1", exclusiveMinimum=0, exclusiveMaximum=1)]
OptionalUnitInterval = Annotated[float | None, optional(bounded("from 0 to 1", minimum=0, maximum=1))]
PoissonsRatio = Annotated[
    float, bounded("> -1 and <= 0.5 (0.5 is incompressible)", exclusiveMinimum=-1, maximum=0.5)
]
OptionalPositive = Annotated[GivenAs[float | None, Amount | None], optional(positive)]
OptionalNonNegative = Annotated[GivenAs[float | None, Amount | None], optional(non_negative)]
OptionalNumber = Annotated[GivenAs[float | None, Amount | None], optional(amount)]
Vector = Annotated[GivenAs[Triple, Amounts], vector]
Direction = Annotated[GivenAs[Triple, Amounts], direction]
OptionalDirection = Annotated[GivenAs[Triple | None, Amounts | None], optional(direction)]
Flag = Annotated[bool, true_or_false]
Text = Annotated[str, word]
OptionalText = Annotated[str | None, optional(word)]
Name = Annotated[str, name_of_part]
OptionalName = Annotated[str | None, optional(name_of_part)]
