"""Columns of numbers with names and units, whatever file or object they come from."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.records.clock_times import is_date
from viscorod.records.column_units import COUNTS, is_of_kind, name_and_unit, si_factor, weight_of
from viscorod.records.complex_cells import is_phase_without_unit
from viscorod.typing import Floats

__all__ = ["Columns", "stacked"]


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

    def timed(self, interval: float, name: str, unit: str = "s") -> Columns:
        """Return the columns with one of times or lines in the place of that of this name, or behind all others."""
        k = self.names.index(name) if name in self.names else len(self.names)
        times = interval * np.arange(len(self.values))
        return replace(
            self,
            names=(*self.names[:k], name, *self.names[k + 1 :]),
            units=(*self.units[:k], unit, *self.units[k + 1 :]),
            values=np.column_stack([self.values[:, :k], times, self.values[:, k + 1 :]]),
            texts={place: one for place, one in self.texts.items() if place != k},
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
        if written is not None and (force := weight_of(written, unit)) is not None:
            if given is None:
                raise self._refused(
                    key, written, f"{column} has masses, and a force is needed",
                    f"give {argument} = {force!r} where they hang, their weight at 9.80665 m/s^2",
                )  # fmt: skip
            if given == force:
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
                f"write it beside its name, or give {argument}{self._times(unit) if key == 'time' else ''}",
            )
        values = self.values[:, k]
        if np.iscomplexobj(values):
            if (values.imag != 0.0).any():
                raise self._refused(key, wanted, "its numbers are complex", "read it as a response")
            values = values.real
        self.require_no_gaps(k, values)
        found: Floats = np.asarray(values, dtype=float) * si_factor(self.source, column, chosen, unit)
        return found

    def _times(self, unit: str) -> str:
        """Return a hint at a column that has a unit of times, where another one was taken for them."""
        own = [
            name
            for name, written in zip(self.names, self.units, strict=True)
            if written is not None and is_of_kind(written, unit)
        ]
        return f", or the column that has times: time = {own[0]!r}" if own else ""

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
            if is_date(cell):
                raise self._refused(
                    self.names[k] or f"column {k + 1}", cell, f"line {line}: dates say no time of day",
                    "give the column of the times of day as time, such as time='Time'",
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
