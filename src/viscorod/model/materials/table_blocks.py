"""Divide the text of measured tables into names, units and rows of cells."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.materials.column_names import MEASURE, Heading, heading, unit_of
from viscorod.model.materials.column_units import NOUNS, refuse_unit
from viscorod.model.materials.other_moduli import enough, spared
from viscorod.model.materials.table_text import SEPARATORS, Numbers, looks_like_a_number, wide_words, words
from viscorod.model.materials.table_wide import (
    Label,
    celsius,
    labelled,
    labels_above,
    labels_within,
)

__all__ = ["Block", "blocks_of"]

_REMARK = re.compile(r"\s*(#|%|//)|[\s|:+=-]*$")
_TEMPERATURE = re.compile(
    r"\W*(?:set|test|sample|soll|proben?)?[\s_-]*temp(?:erature|eratur|\.)?\s*[:=\t;,]+\s*([-+]?[\d.,]*\d)\s*[;,\t]?\s*"
    r"[(\[]?(°?\s?[CFK]|℃)[)\]]?\W*",
    re.IGNORECASE,
)
"""A line above a table that gives the temperature of all its rows."""
_OVER_TIME = re.compile(r"creep|relaxation|kriech|\b[EGJD]\s?\(t\)", re.IGNORECASE)
"""Names of columns of other tests than sweeps of frequency."""
_UNITS_WITHIN = 4
"""Lines below the names in which the units are looked for."""


@dataclass
class Block:
    """One line of names, and the rows below it."""

    line: int
    names: list[str]
    columns: dict[int, Heading]
    divide: Callable[[str], list[str]]
    rows: list[tuple[int, list[str]]] = field(default_factory=list)
    full: dict[int, int] = field(default_factory=dict)
    """Cells of the rows with empty ones at the end, by line."""
    labels: dict[int, Label] = field(default_factory=dict)
    """Frequencies or temperatures of single columns."""
    common: dict[str, float] = field(default_factory=dict)
    """What all rows have: "frequency" [rad/s] or "temperature" [C]."""

    def unfolded(self) -> list[Block]:
        """Return a table for every frequency or temperature that columns are labelled with."""
        if not self.labels:
            return [self]
        return [
            replace(
                self,
                columns={at: k for at, k in self.columns.items() if self.labels.get(at, label) == label},
                labels={},
                common=self.common | {label[0]: label[1]},
            )
            for label in dict.fromkeys(self.labels.values())
        ]

    def same_columns(self, other: Block) -> bool:
        """Return whether another line of names, such as one of symbols, has the same columns."""
        kinds = [{at: known.kind for at, known in block.columns.items()} for block in (self, other)]
        return kinds[0] == kinds[1]

    @property
    def separated(self) -> bool:
        """Whether a mark divides the cells, so that an empty cell between others can be seen."""
        return self.divide is not words


def blocks_of(lines: list[str]) -> list[Block]:
    """Return the tables of a file: names, units, and rows as cells."""
    blocks: list[Block] = []
    ended = 0
    index = 0
    above: dict[str, float] = {}
    while index < len(lines):
        line = lines[index]
        index += 1
        if stated := _TEMPERATURE.fullmatch(line):
            value = Numbers([stated[1]]).of(stated[1])
            above = {} if value is None else {"temperature": celsius(value, stated[2])}
            continue
        found = _names(lines, index) if _may_be_names(line) else None
        if found is not None:
            found.common |= above
            if blocks and not blocks[-1].rows and blocks[-1].same_columns(found):
                found.columns = {
                    at: old.completed(found.columns[at]) for at, old in blocks.pop().columns.items()
                }
            _units(lines, index, found)
            blocks.append(found)
            ended = 0
            continue
        if not blocks or _REMARK.match(line):
            continue
        block = blocks[-1]
        full = block.divide(line)
        cells = _trimmed(full)
        if not block.separated and len(cells) == len(block.names) + 1 and re.fullmatch('".*"', cells[0]):
            cells = cells[1:]  # R writes names of rows, and none above them
        first = next((cell for cell in cells if cell), "")
        if not first:
            continue
        if len(cells) != len(block.names) and not looks_like_a_number(first):
            ended = ended or (index if block.rows else 0)
        elif not block.rows and _is_units(cells):
            continue
        elif ended:
            raise RefusedError(
                f"line {ended} is no row of the table, and line {index} below it is",
                "leave one table in the file, with remarks above or below it",
                found=show(lines[ended - 1].strip()),
            )
        else:
            block.rows.append((index, cells))
            block.full[index] = len(full)
    if blocks:
        return blocks
    raise _no_names(lines)


def _no_names(lines: list[str]) -> RefusedError:
    """Return what says that no line names columns of complex moduli, and what the file may have instead."""
    instead = "begin the file with a line such as: Frequency (Hz), Storage Modulus (MPa), Loss Modulus (MPa)"
    line, kinds = _nearest(lines)
    if kinds <= {
        "frequency",
        "angular",
        "tan_delta",
        "phase",
        "temperature",
        "set_temperature",
        "group",
    } and (kinds & {"tan_delta", "phase"} and kinds & {"frequency", "angular"}):
        instead = (
            "a loss factor without moduli is damping of the kind loss_factor, with its lists of frequencies and loss "
            "factors beside youngs_modulus"
        )
    elif any(map(_OVER_TIME.search, lines)):
        instead = (
            "a table of creep or relaxation over time has no moduli over frequency: damping of the kind prony takes "
            "the moduli and times of its branches"
        )
    return RefusedError(
        "no line names columns of frequency, storage modulus, and loss modulus or tan delta",
        instead,
        found=line,
    )


def _nearest(lines: list[str]) -> tuple[str, set[str]]:
    """Return the line that names most of what is needed, for a message, and the kinds of its columns."""
    best, known = "", set[str]()
    for number, line in enumerate(lines, 1):
        if _may_be_names(line):
            for divide, _ in SEPARATORS.values():
                kinds = {found.kind for cell in divide(line) if (found := heading(cell)) is not None}
                if len(kinds) > max(len(known), 1):
                    best, known = f"line {number} names {', '.join(sorted(kinds))} only", kinds
    return best, known


def _may_be_names(line: str) -> bool:
    """Return whether a line has other letters than those of numbers, and is short enough for names."""
    return len(line) < 5000 and any(c.isalpha() and c not in "eEdD" for c in line)


def _trimmed(cells: list[str]) -> list[str]:
    last = max((at for at, cell in enumerate(cells) if cell), default=-1)
    return cells[: last + 1]


def _names(lines: list[str], number: int) -> Block | None:
    """Return the columns that a line (counted from one) names, if it names enough."""
    line = lines[number - 1]
    for divide, below in SEPARATORS.values():
        cells = _trimmed(divide(line))
        if cells[:1] in (["#"], ["%"]) and len(cells) - 1 == _first_count(lines[number:], below):
            cells = cells[1:]
        columns = spared(
            {at: found for at, cell in enumerate(cells) if (found := _heading(cell, cells)) is not None}
        )
        kinds = {found.kind for found in columns.values()}
        labels: dict[int, Label] = {}
        if not kinds & {"frequency", "angular"} or not enough(kinds):
            named = labels_within(cells)
            if not named and number > 1 and enough(kinds):
                named = labels_above(divide(lines[number - 2]), columns)
            columns |= {at: known for at, (_, _, known) in named.items()}
            labels = labelled(number, named, columns) if named else {}
            if not labels:
                continue
        return Block(number, cells, _without_logarithms(number, columns), below, labels=labels)
    return None


def _without_logarithms(number: int, columns: dict[int, Heading]) -> dict[int, Heading]:
    """Return the columns without logarithms of numbers that stand in another one.

    Raises:
        RefusedError: a logarithm may be of the base 10 or e.
    """
    plain = {known.kind for known in columns.values() if not known.logarithm}
    kept = {at: known for at, known in columns.items() if not (known.logarithm and known.kind in plain)}
    unknown = [known.text for known in kept.values() if known.logarithm == "?"]
    if unknown:
        raise RefusedError(
            f"line {number} names columns of logarithms, and not of which base",
            "name them log10 or ln",
            found=", ".join(unknown),
        )
    return kept


def _heading(cell: str, cells: list[str]) -> Heading | None:
    """Return what a name says; "E' (MPa).1" is a second "E' (MPa)", as data frames number them."""
    base = re.sub(r"\.\d+$", "", cell)
    return heading(base if base in cells else cell)


def _first_count(lines: list[str], divide: Callable[[str], list[str]]) -> int:
    """Return the number of cells of the first row of numbers."""
    rows = (_trimmed(divide(line)) for line in lines)
    return next((len(row) for row in rows if row and all(map(looks_like_a_number, row))), 0)


def _is_units(cells: list[str]) -> bool:
    """Return whether cells below the names are units: no numbers, one of them a unit of a frequency or modulus."""
    return not any(looks_like_a_number(cell) and cell != "1" for cell in cells) and any(
        unit_of(cell, measure)
        for cell in cells
        if cell
        for measure in ("frequency", "modulus", "compliance", "viscosity")
    )


def _units(lines: list[str], start: int, block: Block) -> None:
    """Add the units that stand in a line below the names."""
    for line in lines[start : start + _UNITS_WITHIN]:
        cells = block.divide(line)
        if not block.separated and len(cells) != len(block.names) == len(wide := wide_words(line)):
            cells = wide  # "deg C" between blanks of two
        if not any(cells) or _REMARK.match(line):
            continue
        if {found.kind for cell in cells if (found := heading(cell))} >= {
            known.kind for known in block.columns.values()
        }:
            return  # names again, such as symbols
        if any(looks_like_a_number(cell) and cell.strip("[]()") != "1" for cell in cells):
            return
        if not any(cell.strip("[]() \t") for cell in cells):
            continue
        if not (_is_units(cells) or any(cell.startswith(("[", "(")) for cell in cells) or _words_only(cells)):
            continue
        for at, column in block.columns.items():
            cell, known = cells[at].strip() if at < len(cells) else "", column
            if known.kind == "tan_delta" and unit_of(cell, "ratio") is None and unit_of(cell, "angle"):
                known = block.columns[at] = replace(column, kind="phase")
            if cell.strip("[]()") and unit_of(cell, MEASURE[known.kind]) is None and known.kind in NOUNS:
                refuse_unit(known, cell)
            if (
                known.unit
                and cell.strip("[]()")
                and unit_of(known.unit, MEASURE[known.kind]) != unit_of(cell, MEASURE[known.kind])
            ):
                raise RefusedError(
                    f"the unit below {known.text} is another than the one beside it",
                    "leave one of them in the file",
                    found=cell,
                )
            if cell.strip("[]()") and not known.unit:
                block.columns[at] = replace(known, unit=cell)
        block.rows.clear()
        return


def _words_only(cells: list[str]) -> bool:
    return len(cells) > 1 and all(len(cell) < 12 for cell in cells)
