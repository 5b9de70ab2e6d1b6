"""Tables of storage and loss modulus over frequency, as instruments of dynamic mechanical analysis export them.

A table is text in columns: one line with the names of the columns, with their units in brackets or after a slash, or in
a line below; then the numbers. Lines before the names are skipped, and so are lines that begin with ``#`` (but NETZSCH
marks the line of the names itself with ``##``) and empty ones.
"""

from __future__ import annotations

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from viscorod.limits import LARGEST_TABLE
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.values import LARGEST
from viscorod.typing import Floats

__all__ = ["FREQUENCY_UNITS", "MODULUS_UNITS", "DmaTable", "read_dma_table"]

FREQUENCY_UNITS = {"Hz": 2.0 * math.pi, "kHz": 2e3 * math.pi, "rad/s": 1.0}
"""Angular frequency [rad/s] of the unit."""
MODULUS_UNITS = {
    "Pa": 1.0,
    "kPa": 1e3,
    "MPa": 1e6,
    "GPa": 1e9,
    "N/mm2": 1e6,
    "N/m2": 1.0,
    "psi": 6894.757293168361,
}
"""Pa of the unit."""

NAMES = {
    "frequency": r"(ang(ular|\.)? ?)?freq(uency|\.)?|f|omega|ω",
    "storage": r"([eg]'[- ]*)?((shear|tensile|young'?s|flexural|dynamic) )?storage modulus|storage|[eg]'|[eg]_storage",
    "loss": r"([eg]''[- ]*)?((shear|tensile|young'?s|flexural|dynamic) )?loss modulus|loss|[eg](''|\")|[eg]_loss",
    "tan_delta": r"tan ?[(_ ]?(d|delta|δ)\)?|loss factor",
}
STRAINS = {"extension": r"e['_]|tensile|young|flexural", "shear": r"g['_]|shear"}
"""Beginnings of the name of the storage modulus that show the strain."""
SEPARATORS = ("\t", ";", ",")


@dataclass(frozen=True, eq=False)
class DmaTable:
    """Storage and loss modulus over frequency.

    Attributes:
        omega: increasing angular frequencies (n,), rad/s.
        storage, loss: moduli (n,), Pa.
        strain: "shear" or "extension" where the names of the columns show it, else None.
    """

    omega: Floats
    storage: Floats
    loss: Floats
    strain: str | None = None


def read_dma_table(
    path: str | Path, *, frequency_unit: str | None = None, modulus_unit: str | None = None
) -> DmaTable:
    """Read a table of a frequency sweep at one temperature.

    Args:
        path: of a text file with columns of frequency, storage modulus, and loss modulus or tan delta, separated by
            tabs, semicolons or commas; decimal commas are understood where commas do not separate.
        frequency_unit: "Hz", "kHz" or "rad/s", where the file does not state it.
        modulus_unit: "Pa", "kPa", "MPa", "GPa", "N/mm2", "N/m2" or "psi", where the file does not state it.

    Raises:
        InputError: the file cannot be read, a column or a unit is missing, or a text stands in place of a number.
    """
    lines = _text(Path(path)).splitlines()
    start, separator, columns, header = _names(lines)
    units, first = _units(lines, start, separator, columns, header)
    for name, unit in (("frequency", frequency_unit), ("storage", modulus_unit), ("loss", modulus_unit)):
        _declare(units, name, unit, columns)
    values = _values(lines, first, separator, columns)
    omega = values["frequency"] * FREQUENCY_UNITS[units["frequency"]]
    storage = values["storage"] * MODULUS_UNITS[units["storage"]]
    loss = (
        values["loss"] * MODULUS_UNITS[units["loss"]] if "loss" in values else values["tan_delta"] * storage
    )
    name = _bare(header[columns["storage"]])[0]
    strain = next((strain for strain, pattern in STRAINS.items() if re.match(pattern, name)), None)
    order = np.argsort(omega, kind="stable")
    return DmaTable(omega[order], storage[order], loss[order], strain)


def _text(path: Path) -> str:
    try:
        if not path.is_file():
            raise RefusedError("there is no such file", "give the path of a table of a frequency sweep")
        size = path.stat().st_size
        if size > LARGEST_TABLE:
            raise RefusedError(
                "the file is larger than any table of a measurement",
                f"give one of less than {LARGEST_TABLE // 1_000_000} MB",
                found=f"{size / 1e6:.0f} MB",
            )
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, RefusedError):
            raise
        raise RefusedError(f"it cannot be read ({error})", "check the path and its permissions") from None
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _cells(line: str, separator: str) -> list[str]:
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator), [])]


def _bare(cell: str) -> tuple[str, str | None]:
    """Return name and unit of a cell such as ``E'/MPa``, ``Storage Modulus (MPa)`` or ``Frequency [Hz]``."""
    text = (
        cell.strip()
        .lstrip("#")
        .strip()
        .replace("\N{PRIME}", "'")
        .replace("\N{RIGHT SINGLE QUOTATION MARK}", "'")
    )
    text = text.replace("\N{DOUBLE PRIME}", "''")
    found = re.fullmatch(r"(.*?)\s*(?:\(([^()]*)\)|\[([^\[\]]*)\]|/\s*([A-Za-z].*))", text)
    if found is None or re.fullmatch(NAMES["tan_delta"], text.lower()):
        return text.lower(), None
    name, *units = found.groups()
    return name.strip().lower(), next(unit.strip() for unit in units if unit is not None)


def _kind(cell: str) -> str | None:
    name = _bare(cell)[0]
    return next((kind for kind, pattern in NAMES.items() if re.fullmatch(pattern, name)), None)


def _names(lines: list[str]) -> tuple[int, str, dict[str, int], list[str]]:
    """Return the line of the names, the separator, the column of every known name, and the names."""
    for index, line in enumerate(lines):
        for separator in SEPARATORS:
            cells = _cells(line, separator)
            kinds = [_kind(cell) for cell in cells]
            if not {"frequency", "storage"} <= set(kinds) or not {"loss", "tan_delta"} & set(kinds):
                continue
            columns: dict[str, int] = {}
            for column, kind in enumerate(kinds):
                if kind in columns:
                    raise RefusedError(
                        f"line {index + 1} names two columns for the same: {cells[columns[kind]]} and {cells[column]}",
                        "leave one of them in the file",
                    )
                if kind is not None:
                    columns[kind] = column
            if "loss" in columns:
                columns.pop("tan_delta", None)
            return index, separator, columns, cells
    raise RefusedError(
        "no line names columns of frequency, storage modulus, and loss modulus or tan delta",
        "begin the file with a line such as: Frequency (Hz), Storage Modulus (MPa), Loss Modulus (MPa)",
    )


def _units(
    lines: list[str], start: int, separator: str, columns: dict[str, int], header: list[str]
) -> tuple[dict[str, str], int]:
    """Return the units declared beside the names or in the line below, and the first line that may hold numbers."""
    units = {name: unit for name, column in columns.items() if (unit := _bare(header[column])[1])}
    first = start + 1
    if first < len(lines):
        below = _cells(lines[first], separator)
        cells = {name: below[column] for name, column in columns.items() if column < len(below)}
        if "frequency" in cells and cells["frequency"] and _number(cells["frequency"]) is None:
            first += 1
            for name, cell in cells.items():
                text = cell.strip("()[]")
                if text and name not in units:
                    units[name] = text
    return {name: _known_unit(name, unit) for name, unit in units.items() if name != "tan_delta"}, first


def _known_unit(name: str, unit: str) -> str:
    known = FREQUENCY_UNITS if name == "frequency" else MODULUS_UNITS
    plain = unit.replace("²", "2").replace("^", "").replace("rad/sec", "rad/s").replace(" ", "")
    for word in known:
        if plain == word or (plain.lower() == word.lower() and word not in ("MPa", "Pa")):
            return word
    if plain.lower() in ("pa", "mpa") and plain not in ("mPa",):
        return {"pa": "Pa", "mpa": "MPa"}[plain.lower()]
    raise RefusedError(
        f"the unit {show(unit)} of the column of {_noun(name)} is not known",
        f"use one of {', '.join(known)}",
    )


def _declare(units: dict[str, str], name: str, given: str | None, columns: dict[str, int]) -> None:
    """Take a unit from the file or the keys, and refuse neither or both."""
    if name not in columns:
        return
    key = "frequency_unit" if name == "frequency" else "modulus_unit"
    if given is None and name not in units:
        raise RefusedError(
            f"the file does not give the unit of the column of {_noun(name)}",
            f"write it beside the name, or give {key}",
        )
    if given is not None and units.setdefault(name, given) != given:
        raise RefusedError(
            f"the file gives the {_noun(name)} in {units[name]}, and {key} says {given}",
            f"leave {key} out",
        )


def _noun(name: str) -> str:
    return {"frequency": "frequency", "storage": "storage modulus", "loss": "loss modulus"}[name]


def _number(cell: str) -> float | None:
    try:
        value = float(cell.replace(",", "."))
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _values(lines: list[str], first: int, separator: str, columns: dict[str, int]) -> dict[str, Floats]:
    """Return the numbers of the known columns."""
    rows: list[list[float]] = []
    seen: dict[float, int] = {}
    marks: set[str] = set()
    for index in range(first, len(lines)):
        line = lines[index]
        if not line.strip(f"{separator} ") or line.lstrip().startswith("#"):
            continue
        cells = _cells(line, separator)
        texts = [cells[column] if column < len(cells) else "" for column in columns.values()]
        marks |= {mark for mark in ",." for text in texts if mark in text}
        row = [_number(text) for text in texts]
        for name, text, value in zip(columns, texts, row, strict=True):
            zero = name in ("loss", "tan_delta")
            if value is None or not (1.0 / LARGEST <= value <= LARGEST or (zero and value == 0.0)):
                allowed = "a number >= 0" if zero else "a number > 0"
                raise RefusedError(
                    f"line {index + 1}: the {name.replace('_', ' ')} is not usable",
                    f"give {allowed}",
                    found=show(text),
                )
        numbers = [value for value in row if value is not None]
        frequency = numbers[list(columns).index("frequency")]
        if frequency in seen:
            raise RefusedError(
                f"lines {seen[frequency]} and {index + 1} have the same frequency",
                "keep one sweep at one temperature in the file",
                found=f"{frequency:g}",
            )
        seen[frequency] = index + 1
        rows.append(numbers)
    if len(marks) == 2:
        raise RefusedError(
            "the numbers have both points and commas", "write decimals one way, and no thousands"
        )
    if not rows:
        raise RefusedError("there are no numbers below the names of the columns", "give one row at least")
    return {name: np.array(rows)[:, index] for index, name in enumerate(columns)}
