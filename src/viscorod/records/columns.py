"""Columns of numbers with names and units, whatever file or object they come from."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError, show
from viscorod.records.complex_cells import is_phase_without_unit
from viscorod.typing import Floats
from viscorod.units import si_of, si_value

__all__ = ["COUNTS", "Columns", "is_unit", "name_and_unit", "si_factor", "si_size", "stacked"]

GRAVITY = 9.80665
"""m/s^2 of the unit g of accelerometers."""
_BRACKETS = re.compile(
    r"^(?P<name>.*?)\s*(?:[\[{<](?P<a>[^\[\]{}<>]*)[\]}>]|\((?P<b>[^()]*(?:\([^()]*\)[^()]*)*)\)|\s+in\s+(?P<d>\S+)|\s*/\s*(?P<c>[^/\s].*))$"
)
_PLAIN = {"-": "1", "": "", "1": "1", **dict.fromkeys(("sec", "Sec", "seconds", "Seconds", "sec."), "s")}
_SPELT = {
    **{"m/s2": "m/s^2", "m/s²": "m/s^2", "mm/s2": "mm/s^2", "mm/s²": "mm/s^2", "um": "µm"},
    **dict.fromkeys(("ue", "µe", "µm/m", "um/m", "microstrain", "microstrains"), "ustrain"),
    **dict.fromkeys(("m/m", "strain", "e"), "1"),
    **dict.fromkeys(("mil", "mils"), "thou"),
}
"""Other spellings of units; micro and epsilon are written as u or µ, and e."""
_GRAVITIES = {"g": 1.0, "G": 1.0, "gn": 1.0, "mg": 1e-3, "mG": 1e-3, "ug": 1e-6, "µg": 1e-6}
"""Units of accelerometers, in `GRAVITY`: of an acceleration g is no gram."""
_PLAIN_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
COUNTS = (
    "VOLT",
    "Volt",
    "Volts",
    "px",
    "pix",
    "pixel",
    "pixels",
    "V",
    "mV",
    "volt",
    "volts",
    "counts",
    "digits",
    "LSB",
)
"""What cameras and amplifiers give, of which only the user knows the size."""


@dataclass(frozen=True, eq=False)
class Columns:
    """A table.

    Attributes:
        source: the file or object, for messages.
        names: of the columns, without units.
        units: of the columns as written, None where the source does not say.
        values: real, or complex (rows, columns).
        texts: of columns with a cell that is no number: its line and what it says; the value there is NaN.
    """

    source: str
    names: tuple[str, ...]
    units: tuple[str | None, ...]
    values: np.ndarray
    texts: Mapping[int, tuple[int, str]] = field(default_factory=dict)

    def number(self, key: str, wanted: str | int) -> int:
        """Return the place of a column that is named or numbered from 1.

        Raises:
            InputError: there is none, or several.
        """
        if isinstance(wanted, int) and not isinstance(wanted, bool):
            if 1 <= wanted <= len(self.names):
                return wanted - 1
            raise self._refused(
                key, wanted, f"there are {len(self.names)} columns", f"give 1 to {len(self.names)}"
            )
        fits = [k for k, name in enumerate(self.names) if name == wanted]
        fits = fits or [
            k for k, name in enumerate(self.names) if name.casefold() == str(wanted).strip().casefold()
        ]
        fits = fits or [k for k, name in enumerate(self.names) if f".{name}".endswith(f".{wanted}")]
        if not fits:  # a heading as it stands in the file, with its unit
            name, unit = name_and_unit(str(wanted))
            pairs = list(zip(self.names, self.units, strict=True))
            fits = [k for k, own in enumerate(pairs) if own == (name, unit)]
            fits = fits or [
                k for k, own in enumerate(pairs) if f".{own[0]}".endswith(f".{name}") and own[1] == unit
            ]
        if len(fits) == 1:
            return fits[0]
        if not any(self.names):
            raise self._refused(
                key, wanted, "no names stand above the columns", f"give its number, 1 to {len(self.names)}"
            )
        near = difflib.get_close_matches(str(wanted), self.names, n=1)
        listed = ", ".join(self.names[:12]) + (
            f" and {len(self.names) - 12} more" if len(self.names) > 12 else ""
        )
        raise self._refused(
            key,
            wanted,
            "several columns have this name" if fits else "no column has this name",
            f"did you mean {near[0]!r}?"
            if near and not fits
            else f"give its number, from 1, or one of {listed}",
        )

    def timed(self, interval: float, name: str) -> Columns:
        """Return the columns with one of times before them, which takes the place of one of the same name."""
        kept = [k for k, own in enumerate(self.names) if own != name]
        times = interval * np.arange(len(self.values))
        return replace(
            self,
            names=(name, *(self.names[k] for k in kept)),
            units=("s", *(self.units[k] for k in kept)),
            values=np.column_stack([times, self.values[:, kept]]),
            texts={place: self.texts[k] for place, k in enumerate(kept, 1) if k in self.texts},
        )

    def kept(self, gaps: str, wanted: Sequence[tuple[str, str | int]]) -> Columns:
        """Return the rows that `gaps` says: all of "refuse", those in which columns have numbers of "leave out".

        Raises:
            InputError: it says something else.
        """
        if gaps not in ("refuse", "leave out"):
            raise InputError(Fault("gaps", repr(gaps), "it is not known", "use 'refuse' or 'leave out'"))
        return self if gaps == "refuse" else self._without_gaps(wanted)

    def _without_gaps(self, wanted: Sequence[tuple[str, str | int]]) -> Columns:
        """Return the rows in which some columns, each with its argument, have numbers."""
        places = [self.number(key, one) for key, one in wanted]
        for k in places:
            self.require_numbers(k)
        chosen = self.values[:, places]
        return replace(self, values=self.values[np.isfinite(chosen).all(axis=1)])

    def si(self, key: str, wanted: str | int, unit: str, given: str | None = None) -> Floats:
        """Return a column in SI.

        Args:
            key: of the argument, for messages.
            wanted: name or number.
            unit: SI unit that it must have.
            given: the unit, where the source does not say.

        Raises:
            InputError: no unit is known, or one of another kind; or there is a gap.
        """
        k = self.number(key, wanted)
        self.require_numbers(k)
        written = self.units[k]
        column = f"column {self.names[k] or k + 1}"
        argument = "unit" if key == "value" else f"{key}_unit"
        if written is not None and written.strip() in COUNTS:
            if given is None:
                raise self._refused(
                    key,
                    written,
                    f"nothing says how much one of {column} is",
                    f"give {argument}, the size of one, such as {argument}='0.21 {unit}'",
                )
            written = None
        if (
            given is not None
            and written is not None
            and si_factor(self.source, column, written, unit) != si_factor(self.source, argument, given, unit)
        ):
            raise self._refused(argument, given, f"the source says {written!r} of {column}", "leave it out")
        chosen = given if given is not None else written
        if chosen is None:
            raise self._refused(
                key,
                wanted,
                f"the source does not give the unit of {column}",
                f"write it beside its name, or give {argument}",
            )
        values = self.values[:, k]
        if np.iscomplexobj(values):
            if (values.imag != 0.0).any():
                raise self._refused(key, wanted, "its numbers are complex", "read it as a response")
            values = values.real
        self.require_no_gaps(k, values)
        found: Floats = np.asarray(values, dtype=float) * si_factor(self.source, column, chosen, unit)
        return found

    def require_no_gaps(self, k: int, values: np.ndarray) -> None:
        """Raise `InputError` where one of the values of column k (rows,) is none."""
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            raise InputError(
                Fault(
                    f"{self.source}: column {self.names[k] or k + 1}",
                    f"row {bad[0] + 1} of the numbers",
                    "there is no number",
                    f"give gaps='leave out' to read the other {len(values) - len(bad)} rows, or complete the "
                    f"{len(bad)} without one",
                )
            )

    def require_numbers(self, k: int) -> None:
        """Raise `InputError` where a cell of column k is neither a number nor empty."""
        if k in self.texts:
            line, cell = self.texts[k]
            if is_phase_without_unit(cell):
                raise self._refused(
                    self.names[k] or f"column {k + 1}", cell, f"line {line}: of a phase its unit is needed",
                    "write it beside the number, such as 1.2@45deg, or magnitude and phase in two columns",
                )  # fmt: skip
            raise InputError(
                Fault(
                    self.source,
                    show(cell),
                    f"line {line}, column {self.names[k] or k + 1}: this is no number",
                    "give a number, or leave the cell empty where nothing was measured",
                )
            )

    def _refused(self, key: str, found: object, why: str, instead: str) -> InputError:
        return InputError(Fault(f"{self.source}: {key}", show(found), why, instead))


def si_factor(source: str, column: str, written: str, unit: str) -> float:
    """Return the SI value of a unit of the kind of an SI unit.

    Raises:
        InputError: it is no unit, or one of another kind.
    """
    size, written = _number_and_unit(written)
    if size is not None:
        return size * si_factor(source, column, written, unit)
    plain = _PLAIN.get(written.strip(), written.strip()).replace("μ", "µ").replace("ε", "e")
    if unit == "m/s^2" and plain in _GRAVITIES:
        return GRAVITY * _GRAVITIES[plain]
    plain = _small(_SPELT.get(plain, plain))
    if unit == "1":
        if plain in ("1", "%", "ustrain", "mm/m"):
            return {"1": 1.0, "%": 1e-2, "ustrain": 1e-6, "mm/m": 1e-3}[plain]
        raise InputError(
            Fault(
                f"{source}: {column}",
                show(written),
                "this quantity is a plain number",
                "use 1, %, mm/m or ustrain",
            )
        )
    try:
        return si_value(f"1 {plain}", unit, column)
    except RefusedError as error:
        raise InputError(Fault(f"{source}: {column}", show(written), error.why, error.instead)) from None


def _number_and_unit(text: str) -> tuple[float | None, str]:
    """Return the number and the unit of the size of one count, "0.21 mm", "1/30 s"; None where a unit stands alone."""
    found = re.fullmatch(rf"\s*([+-]?{_PLAIN_NUMBER})(?:\s*/\s*({_PLAIN_NUMBER}))?\s+(\S.*)", text)
    if found is None or (found[2] is not None and float(found[2]) == 0.0):
        return None, text
    return float(found[1]) / float(found[2] or 1.0), found[3]


def si_size(source: str, column: str, written: str) -> float:
    """Return the SI value of a unit of a response, of any kind; g is that of accelerometers.

    Raises:
        InputError: it is no unit.
    """
    size, written = _number_and_unit(written)
    if size is not None:
        return size * si_size(source, column, written)
    if written.strip() in ("1", "-", ""):
        return 1.0
    gravities = re.match(r"\s*\(?\s*(m?[gG]|gn)\s*\)?\s*(?:/|$)", written)
    if gravities:  # of an accelerometer over a force: no response is a mass
        over = written[gravities.end() :].strip()
        size = GRAVITY * _GRAVITIES[gravities[1]]
        return size / si_size(source, column, over) if over else size
    try:
        return si_of(re.sub(r"/([^/()]+)/([^/()]+)$", r"/(\1 \2)", written.replace("²", "^2")))
    except RefusedError as error:
        raise InputError(Fault(f"{source}: {column}", show(written), error.why, error.instead)) from None


def name_and_unit(cell: str) -> tuple[str, str | None]:
    """Return the name and the unit of a heading: "t [s]", "t (s)", "t / s", "x in mm", "tip_x_m", "time, s"."""
    text = cell.strip().lstrip("#%").strip()
    if len(text) > 1 and text[0] == text[-1] == '"':
        text = text[1:-1]
    found = _BRACKETS.match(text)
    if found:
        unit = next(part for part in (found["a"], found["b"], found["c"], found["d"]) if part is not None)
        if found["c"] is None or _is_unit(unit):
            return found["name"].strip(), _PLAIN.get(unit.strip(), unit.strip()) or None
    for mark in (",", "_", " "):
        name, _, unit = text.rpartition(mark)
        if name and (_is_unit(unit.strip()) or (mark == "_" and unit in COUNTS)):
            return name.strip(), unit.strip()
    two = re.fullmatch(r"(.+?)[_ ](mm?|cm|[km]?N|um|µm)_(s2?)", text)
    if two:
        return two[1], f"{two[2]}/{two[3].replace('s2', 's^2')}"
    return text, None


_ENDINGS = (
    *(
        "s",
        "ms",
        "us",
        "µs",
        "min",
        "h",
        "m",
        "mm",
        "cm",
        "um",
        "µm",
        "in",
        "N",
        "mN",
        "kN",
        "Hz",
        "kHz",
        "N m",
    ),
    *(
        "Pa",
        "kPa",
        "MPa",
        "GPa",
        "m/s",
        "mm/s",
        "m/s^2",
        "m/s2",
        "mm/s^2",
        "g",
        "rad",
        "deg",
        "°",
        "rad/s",
        "%",
        "ustrain",
    ),
)
"""Units that are known after a name without brackets."""


def _is_unit(text: str) -> bool:
    return text in _ENDINGS


def is_unit(text: str) -> bool:
    """Return whether a text is a unit and nothing else, as in a line of units below names."""
    if _is_unit(text) or text in _PLAIN or text in _SPELT:
        return True
    try:
        si_of(_small(text))
    except RefusedError:
        return False
    return True


def _small(text: str) -> str:
    """Return a unit that is written out, in small letters; symbols as they are."""
    return text.lower() if len(text) > 3 and text.isalpha() and not text[1:].isupper() else text


def stacked(
    source: str, names: Sequence[str], columns: Sequence[np.ndarray], units: Sequence[str | None]
) -> Columns:
    """Return columns of equal length as a table.

    Raises:
        InputError: the lengths differ.
    """
    lengths = {len(column) for column in columns}
    if len(lengths) != 1:
        raise InputError(f"{source}: its columns have different lengths, {sorted(lengths)}")
    return Columns(source, tuple(names), tuple(units), np.column_stack(columns))
