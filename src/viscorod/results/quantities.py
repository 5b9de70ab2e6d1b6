"""Named numbers of a result, in words: ``("displacement", "beam.end", "y", "max")``, ``("frequency", 1)``.

A sweep computes them where a member is computed, so that whole results need not be kept.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.results.any_result import result_class
from viscorod.results.components import STRAINS
from viscorod.results.data_schema import AXES, LABELS, VARIABLES
from viscorod.results.function_record import function_record
from viscorod.results.sweep_figures import FIGURES

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult
    from viscorod.results.between_records import Instants
    from viscorod.results.result import Result
    from viscorod.typing import Floats

__all__ = ["HISTORY", "HISTORY_TIMES", "Number", "Quantities", "Quantity", "evaluated", "quantities_of"]

Number: TypeAlias = float | list[float]
"""Value of a quantity: a number, or those of a history."""
Quantities: TypeAlias = Mapping[str, Any]
"""Name -> words (a tuple, or a text with spaces), or a function of the result that returns a number."""
Word: TypeAlias = str | float

HISTORY = "history"
HISTORY_TIMES = 201
"""Instants of a history, equally spaced from 0 to the end of the motion."""

_DIRECTORS = ("d1", "d2", "d3")
_SIZE = "size"
FIELDS: dict[str, tuple[str, ...]] = {
    "position": AXES,
    "displacement": AXES,
    "velocity": AXES,
    "angular_velocity": _DIRECTORS,
    "strain": tuple(STRAINS),
    "section_force": tuple(STRAINS),
    "dissipation": (),
    "reaction": tuple(LABELS["motion"]),
}
"""What can be read at a place -> its components; vectors of three have a size too."""
_RESERVED = ("member", "instant", "outcome", "message", "number", "axis", "station", "point", "component")
_DECAY = ("damping_ratio", "period", "log_decrement", "amplitude")
_NUMBERED = {
    "frequency": ("modes", "response"),
    "damping_ratio": ("modes", "response"),
    "load_factor": ("buckling",),
}
_STATES = ("simulate", "equilibrium", "path", "steady", "modes", "buckling")


def _mean(t: Floats, x: Floats) -> float:
    return float(np.trapezoid(x, t) / (t[-1] - t[0])) if t[-1] > t[0] else float(x[0])


_REDUCTIONS: dict[str, Callable[[Floats, Floats], float]] = {
    "first": lambda _, x: float(x[0]),
    "last": lambda _, x: float(x[-1]),
    "min": lambda _, x: float(x.min()),
    "max": lambda _, x: float(x.max()),
    "max_abs": lambda _, x: float(np.abs(x).max()),
    "range": lambda _, x: float(x.max() - x.min()),
    "mean": _mean,
    "rms": lambda t, x: math.sqrt(_mean(t, x * x)),
}
"""What makes a number of a history: of stored states, means by the trapezoidal rule over time."""
_OVER_TIME = ("mean", "rms", HISTORY)


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
            return _read(result, self.words)
        return self._number(_OTHERS[head](result, self.words[1:]))

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
        except Exception as error:  # a user's function may fail for one member; the others keep theirs
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
        if not isinstance(name, str) or not name or "/" in name or name in reserved:
            why = "this is no name, or one that the table has for something else"
            faults.append(Fault(f"quantities.{name}", "", why, "give another, without a slash"))
            continue
        if callable(spec):
            found.append(Quantity(name, (), spec))
            continue
        try:
            found.append(Quantity(name, _checked(_words(spec), kind)))
        except InputError as error:
            faults += [problem.within(f"quantities.{name}") for problem in error.problems]
    if faults:
        raise InputError(faults)
    return tuple(found)


def _variables(kind: str) -> Iterable[str]:
    """Return the names of the variables of a result without states."""
    found = getattr(result_class(kind), "variables", None)
    return () if found is None else found()


def _words(spec: Any) -> tuple[Word, ...]:
    if isinstance(spec, str):
        spec = shlex.split(spec)
    if not isinstance(spec, Sequence) or not spec:
        raise InputError(Fault("", repr(spec)[:60], "no quantity", 'give words such as ("frequency", 1)'))
    return tuple(_word(word) for word in spec)


def _word(word: Any) -> Word:
    if isinstance(word, str):
        try:
            value = float(word)
        except ValueError:
            return word
        return value if math.isfinite(value) else word
    numeric = isinstance(word, int | float | np.integer | np.floating) and not isinstance(word, bool)
    if numeric and math.isfinite(float(word)):
        return float(word)
    raise InputError(Fault("", repr(word)[:60], "neither a word nor a number", "give words in quotes"))


def _one_of(word: Word, known: Sequence[str], what: str) -> None:
    if word not in known:
        raise InputError(Fault("", str(word), f"no {what}", f"give one of {', '.join(known)}"))


def _checked(words: tuple[Word, ...], kind: str) -> tuple[Word, ...]:
    """Return words with what may be left out, or refuse them."""
    head, *rest = words
    _one_of(head, (*FIELDS, *_OTHERS), "quantity")
    kinds = ("simulate",) if head in ("decrement", "energy") else _NUMBERED.get(str(head), _STATES)
    if head in ("peak", "peak_frequency"):
        kinds = ("response", "periodic")
    if kind not in kinds:
        raise InputError(
            Fault("", str(head), f"a result of [{kind}] has none", f"it goes with {', '.join(kinds)}")
        )
    if head in FIELDS:
        return _checked_field(str(head), rest, kind)
    if head == "decrement":
        return _checked_decay(rest)
    if head == "energy":
        terms = ("kinetic", "elastic", "viscous", "external", "outside", "actuator", "numerical", "total")
        _count(rest, 2, 2, '("energy", "viscous", "last")')
        _one_of(rest[0], terms, "term of the energy account")
        _one_of(rest[1], tuple(_REDUCTIONS), "way to make a number of a history")
    elif head in _NUMBERED:
        _count(
            rest,
            1,
            1,
            f'("{head}", 1), or ("{head}", "bend_1 1"), whose name stands in quotes on a command line',
        )
        if isinstance(rest[0], float) and (rest[0] < 1.0 or rest[0] % 1.0):
            raise InputError(Fault("", f"{rest[0]:g}", "numbers count from 1", "give 1 for the first"))
    else:
        _count(rest, 0, 2, f'("{head}", "beam.end uz", "beam.end fz"), output and input')
    return words


def _count(rest: Sequence[Word], least: int, most: int, example: str) -> None:
    if not least <= len(rest) <= most:
        found = " ".join(f"{word:g}" if isinstance(word, float) else word for word in rest) or "nothing"
        several = f"{least} more words are" if least > 1 else "one more word is"
        needed = several if least == most else f"{least} to {most} more words are"
        raise InputError(Fault("", found, f"{needed} needed", f"write {example}"))


def _checked_field(head: str, rest: list[Word], kind: str) -> tuple[Word, ...]:
    components = FIELDS[head]
    example = f'("{head}", "beam.end", {f"{components[1]!r}, " if components else ""}"max")'.replace("'", '"')
    least = 2 if components else 1
    _count(rest, least + (kind == "simulate"), least + 1, example)
    if not isinstance(rest[0], str):
        raise InputError(Fault("", f"{rest[0]:g}", "this is no place", 'name one such as "beam.end"'))
    if components:
        _one_of(rest[1], (*components, _SIZE) if len(components) == 3 else components, "component")
    if len(rest) == least:
        rest = [*rest, "last"]
    how = rest[-1]
    if isinstance(how, float) and kind == "simulate" and head != "reaction":
        return (head, *rest)  # a time
    ways = tuple(_REDUCTIONS) if kind == "simulate" else tuple(set(_REDUCTIONS) - set(_OVER_TIME))
    if kind == "simulate" and head != "reaction":
        ways = (*ways, HISTORY)
    _one_of(how, ways, "way to make a number of a history")
    return (head, *rest)


def _checked_decay(rest: list[Word]) -> tuple[Word, ...]:
    _count(rest, 2, 4, '("decrement", "beam.end", "y", "period", 1)')
    _one_of(rest[1], AXES, "global axis")
    rest = rest if len(rest) > 2 else [*rest, "damping_ratio"]
    _one_of(rest[2], _DECAY, "number of a decay")
    if len(rest) > 3 and not (isinstance(rest[3], float) and rest[3] >= 1.0 and not rest[3] % 1.0):
        raise InputError(Fault("", str(rest[3]), "cycles are numbered from 1", "give 1 for the first"))
    return ("decrement", *rest)


def _read(result: AnyResult, words: tuple[Word, ...]) -> Number:
    """Return what is read at a place, reduced."""
    from viscorod.results.probe import instants_of
    from viscorod.results.run import Run

    head, place, how = str(words[0]), str(words[1]), words[-1]
    component = str(words[2]) if FIELDS[head] else ""
    found: Any = result
    along: Floats = np.asarray(found.data[found.dimension].values, dtype=float)
    instants = None
    if head == "reaction":
        values = _reaction(found, place)
    else:
        if isinstance(result, Run) and isinstance(how, float):
            instants = instants_of(result, how)
        elif isinstance(result, Run) and how == HISTORY:
            instants = instants_of(result, np.linspace(0.0, result.time[-1], HISTORY_TIMES))
        values = _at(found, place, head, instants)
    if component == _SIZE:
        values = np.linalg.norm(values, axis=-1)
    elif component:
        values = values[:, FIELDS[head].index(component)]
    if not np.isfinite(values).all():
        raise InputError(f"{head} of {place} is not finite")
    if how == HISTORY:
        return [float(value) for value in values]
    return float(values[0]) if isinstance(how, float) else _REDUCTIONS[how](along, values)


def _at(result: Result, place: str, head: str, instants: Instants | None) -> Floats:
    """Return a field at a place, in stored states or at instants."""
    from viscorod.results.probe import fields_at

    site = result.sites.at(place)
    if instants is None and head in ("position", "displacement"):  # no other field is read
        return result.vector(site, "position" if head == "position" else "displacement")
    fields = fields_at(result, [site], instants)
    if head not in fields:
        raise InputError(f"{head} is not known at {place}")
    return fields[head][:, 0]


def _reaction(result: Result, place: str) -> Floats:
    known = [str(name) for name in result.data["support"].values] if "reaction" in result.data else []
    if place not in known:
        raise InputError(f"{place} has no support; there are {', '.join(known) or 'none'}")
    values: Floats = result.data["reaction"].values[:, known.index(place)]
    return values


def _decay(result: Any, words: Sequence[Word]) -> float:
    place, axis, what = map(str, words[:3])
    found = result.decay(place, axis)
    if len(words) == 3 and not found.regular:
        raise InputError(
            f"{place} along {axis} does not decay regularly over three maxima or more; simulate longer, or name a cycle"
        )
    if len(words) == 3:
        if what == "damping_ratio":
            return float(found.limit[1])
        return float(np.mean(getattr(found, what))) if what != "amplitude" else float(found.amplitude[0])
    values, cycle = getattr(found, what), int(words[3])
    if cycle > len(values):
        raise InputError(f"{place} along {axis} has {len(values)} cycles; there is no cycle {cycle}")
    return float(values[cycle - 1])


def _numbered(what: str) -> Callable[[Any, Sequence[Word]], float]:
    """Return what reads a number of a mode, a pole or a critical load, by its number or name."""

    def read(result: Any, words: Sequence[Word]) -> float:
        word = words[0]
        if what == "load_factor":
            values, names = result.load_factors, []
        elif hasattr(result, "poles"):
            s = result.poles
            names = [str(name) for name in result.data["pole_name"].values]
            values = np.abs(s) / (2.0 * np.pi) if what == "frequency" else -s.real / np.abs(s)
        else:
            values = result.frequencies if what == "frequency" else result.damping_ratios
            names = list(result.names)
        if isinstance(word, str):
            if word not in names:
                raise InputError(f"there is no {word!r}; there are {', '.join(names) or 'numbers only'}")
            return float(values[names.index(word)])
        if word > len(values):
            raise InputError(f"there are {len(values)}; there is no number {word:g}")
        return float(values[int(word) - 1])

    return read


def _peak(what: str) -> Callable[[Any, Sequence[Word]], float]:
    """Return what reads the largest size of a response, or where it is."""

    def read(result: Any, words: Sequence[Word]) -> float:
        size_of = result.amplification if hasattr(result, "amplification") else result.amplitude
        size = size_of(*(int(word) if isinstance(word, float) else word for word in words))
        return float(size.max() if what == "peak" else result.frequencies[np.argmax(size)])

    return read


def _energy(result: Any, words: Sequence[Word]) -> float:
    account = result.energy
    values = np.broadcast_to(getattr(account, str(words[0])), account.time.shape)
    return _REDUCTIONS[str(words[1])](account.time, values)


_OTHERS: dict[str, Callable[[Any, Sequence[Word]], float]] = {
    "decrement": _decay,
    "energy": _energy,
    "frequency": _numbered("frequency"),
    "damping_ratio": _numbered("damping_ratio"),
    "load_factor": _numbered("load_factor"),
    "peak": _peak("peak"),
    "peak_frequency": _peak("peak_frequency"),
}
"""First word of what is no field at a place -> what reads it from the other words."""
