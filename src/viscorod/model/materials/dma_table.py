"""Tables of storage and loss modulus over frequency, as instruments of dynamic mechanical analysis export them.

A table is text in columns: one line with the names of the columns, with their units beside the names or in a line
below; then the numbers. Lines before the names are skipped, and so are lines that begin with ``#`` (but NETZSCH marks
the line of the names itself with ``##``), empty ones, and remarks at the end. The names may come again, where a
program writes one table for every sweep.

A column is taken by the place of its name, and a row whose number of cells is another is refused, unless columns that
say the same twice (both frequencies, tan delta, the size of the complex modulus) leave one way to read it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from viscorod.checks import checked
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.materials.column_names import MEASURE, OF_SHEAR, unit_of
from viscorod.model.materials.column_units import NOUNS, factor
from viscorod.model.materials.moduli_over_frequency import DmaTable, beside_slope
from viscorod.model.materials.other_moduli import IN_THEIR_PLACE, moduli_of
from viscorod.model.materials.sweeps import Points, every_sweep, one_sweep, side_by_side
from viscorod.model.materials.table_blocks import Block, blocks_of
from viscorod.model.materials.table_text import Numbers, lines_of
from viscorod.typing import Floats

__all__ = ["read_dma_sweeps", "read_dma_table"]

_AGREE = 0.03
"""Relative difference, of half the rows, that rounding explains between columns that say the same twice."""
_LARGEST = 690.0
"""Logarithm of the largest number."""
_POWER = 0.03
"""Part of a power of ten by which a ratio may be off that of two units."""
_ROUNDED = 0.0051
"""Difference of tan delta that its printed digits explain."""


@checked
def read_dma_table(
    path: str | Path,
    *,
    frequency_unit: str | None = None,
    modulus_unit: str | None = None,
    temperature: float | None = None,
) -> DmaTable:
    """Read a table of one frequency sweep, or one sweep of a table of several.

    Args:
        path: of a text file with columns of frequency or angular frequency, storage modulus, and loss modulus, tan
            delta or phase angle, separated by tabs, semicolons, commas, bars or blanks; decimal commas are
            understood where commas do not separate.
        frequency_unit: "Hz", "kHz", "rad/s", "mHz" or "MHz", where the file does not state it.
        modulus_unit: a word of `MODULUS_UNITS`, where the file does not state it.
        temperature: of the sweep, degrees C, where the file has sweeps at several.

    Raises:
        RefusedError: the file cannot be read, a column or a unit is missing, a row does not fit the names, a text
            stands in place of a number, columns contradict each other, or several sweeps leave a choice.
    """
    return one_sweep(_parts(path, frequency_unit, modulus_unit), temperature)


@checked
def read_dma_sweeps(
    path: str | Path, *, frequency_unit: str | None = None, modulus_unit: str | None = None
) -> list[tuple[float, float, DmaTable]]:
    """Read all sweeps of a file: temperature of the sample [C], how far it went from it [K], and the table of each.

    Args:
        path, frequency_unit, modulus_unit: see `read_dma_table`.

    Raises:
        RefusedError: see `read_dma_table`; or the file has no temperatures.
    """
    return every_sweep(_parts(path, frequency_unit, modulus_unit))


def _parts(path: str | Path, frequency_unit: str | None, modulus_unit: str | None) -> list[Points]:
    """Return the measured points of the tables of a file."""
    blocks = blocks_of(lines_of(Path(path)))
    given = {"frequency": frequency_unit, "modulus": modulus_unit}
    numbers = Numbers(
        row[at] for block in blocks for _, row in block.rows for at in range(len(row)) if at in _near(block)
    )
    parts = [
        side_by_side([_points(one, index, numbers, given) for one in block.unfolded()])
        for index, block in enumerate(blocks)
    ]
    parts = [part for part in parts if part.line.size]
    if not parts:
        raise RefusedError("there are no numbers below the names of the columns", "give one row at least")
    strains = {part.strain for part in parts}
    if len(strains) > 1:
        raise RefusedError("the file has tables of different strains", "keep one of them in the file")
    return parts


def _near(block: Block) -> set[int]:
    return {at + shift for at in block.columns for shift in (-1, 0, 1)}


def _points(block: Block, index: int, numbers: Numbers, given: dict[str, str | None]) -> Points:
    """Return the measured points of a table in rad/s and Pa; nan where there is none."""
    factors = _used_factors(block, given)
    by_count: dict[int, list[int]] = {}
    for k, (_, cells) in enumerate(block.rows):
        by_count.setdefault(len(cells), []).append(k)
    values = {at: np.full(len(block.rows), math.nan) for at in factors}
    for count, rows in by_count.items():
        for at, column in _placed(block, count, rows, numbers, factors).items():
            values[at][rows] = column
    return _quantities(block, index, _single(block, values))


def _used_factors(block: Block, given: dict[str, str | None]) -> dict[int, float]:
    """Return the SI value of the unit of every column that is used; columns that only confirm others may lack one."""
    kinds = {known.kind for known in block.columns.values()}
    instead = kinds & IN_THEIR_PLACE
    needed = {"storage", "loss" if "loss" in kinds else "tan_delta" if "tan_delta" in kinds else "phase"}
    if "storage" not in kinds:
        one = "loss" if "loss" in kinds else "complex"
        needed = {one, "tan_delta" if "tan_delta" in kinds else "phase"}
    if instead:  # which stand there only where moduli do not
        needed = {*instead, *needed} - {"storage", "loss", "complex"}
    factors, refused = {}, {}
    for at, known in block.columns.items():
        if known.kind in ("temperature", "set_temperature", "group"):
            factors[at] = 1.0
            continue
        try:
            factors[at] = factor(known, given)
        except RefusedError as error:
            refused[at] = error
            if known.kind in needed:
                raise
    if "frequency" not in block.common and not any(
        block.columns[at].kind in ("frequency", "angular") for at in factors
    ):
        raise next(
            error for at, error in refused.items() if block.columns[at].kind in ("frequency", "angular")
        )
    return factors


def _placed(
    block: Block, count: int, rows: list[int], numbers: Numbers, factors: dict[int, float]
) -> dict[int, Floats]:
    """Return the columns of rows of one number of cells, placed by the names or by what two columns say together."""
    missing = len(block.names) - count
    as_named = {at: at for at in factors}
    if missing == 0 or _ends_blank(block, rows, missing):
        found = _columns(block, rows, as_named, numbers, factors)
        checks = list(_checks(block, rows, found))
        contradiction = next((text for ok, text in checks if not ok), None)
        if contradiction:
            raise RefusedError(
                "the columns contradict each other: " + contradiction,
                "check names and units in the file, or leave the wrong column out",
            )
        if checks or not _label_above_numbers(block, rows):
            return found
    if missing == -1 and _counted_from_zero(block, rows):
        return _columns(block, rows, {at: at + 1 for at in factors}, numbers, factors)
    if missing == 1 and block.names[0].endswith(":"):  # a label before the names, and none before the rows
        found = _columns(block, rows, {at: at - 1 for at in factors}, numbers, factors)
        agree = [ok for ok, _ in _checks(block, rows, found)]
        if agree and all(agree):
            return found
    line, cells = block.rows[rows[0]]
    raise RefusedError(
        f"line {line} has {count} cells, and line {block.line} names {len(block.names)} columns "
        f"({', '.join(block.names)}): which column a number belongs to is not known",
        "give every row as many cells as there are names, empty ones too, and decimals with a point where commas "
        "separate",
        found=show(" ".join(cells)),
    )


def _label_above_numbers(block: Block, rows: list[int]) -> bool:
    """Return whether the first name is a label, such as "Interval data:", and the first cells are no count of rows."""
    first = [block.rows[row][1][0] for row in rows]
    counts = [[str(k) for k in range(start, start + len(first))] for start in (0, 1)]
    return block.names[0].endswith(":") and 0 not in block.columns and any(first) and first not in counts


def _counted_from_zero(block: Block, rows: list[int]) -> bool:
    """Return whether an index 0, 1, ... stands before the first column, which zero shows to be none of its values."""
    first = block.columns.get(0)
    positive = first is not None and first.kind in ("frequency", "angular", "storage", "complex")
    return positive and len(rows) > 1 and all(block.rows[row][1][0] == str(k) for k, row in enumerate(rows))


def _ends_blank(block: Block, rows: list[int], missing: int) -> bool:
    """Return whether rows are short because their last cells are empty.

    The separators show it; or other rows are as long as the names, and the short ones end before the last column.
    """
    if missing < 0:
        return False
    if all(block.full.get(block.rows[k][0], 0) >= len(block.names) for k in rows):
        return True
    whole = any(len(cells) == len(block.names) for _, cells in block.rows)
    return block.separated and whole and max(block.columns) < len(block.names) - missing


def _columns(
    block: Block, rows: list[int], places: dict[int, int], numbers: Numbers, factors: dict[int, float]
) -> dict[int, Floats]:
    """Return the columns of rows, from the cells at the places given for each."""
    found = {}
    for at, size in factors.items():
        known = block.columns[at]
        column = np.full(len(rows), math.nan)
        for k, row in enumerate(rows):
            line, cells = block.rows[row]
            place = places.get(at, len(cells))
            cell = cells[place] if place < len(cells) else ""
            value = numbers.of(cell)
            if value is None and known.kind in NOUNS:
                allowed = "> 0" if known.kind in ("frequency", "angular", "storage", "complex") else ">= 0"
                raise RefusedError(
                    f"line {line}: the {known.kind.replace('_', ' ')} is not usable",
                    f"give a number {allowed}",
                    found=show(cell),
                )
            column[k] = math.nan if value is None else _plain(value, known.logarithm) * size
        found[at] = column
    return found


def _plain(value: float, logarithm: str) -> float:
    """Return the number whose logarithm was read."""
    if not logarithm:
        return value
    power = value * (math.log(10.0) if logarithm == "10" else 1.0)
    return math.exp(power) if abs(power) < _LARGEST else math.nan


def _checks(block: Block, rows: list[int], columns: dict[int, Floats]) -> Iterator[tuple[bool, str]]:
    """Compare columns that say the same twice; yields whether they agree, and a sentence."""
    by_kind: dict[str, tuple[str, Floats]] = {}
    for at, column in columns.items():
        by_kind.setdefault(block.columns[at].kind, (block.columns[at].text, column))
    lines = [block.rows[row][0] for row in rows]

    def compared(
        first: str, a: Floats, second: str, b: Floats, slack: float = 0.0
    ) -> Iterator[tuple[bool, str]]:
        known = np.flatnonzero(np.isfinite(a) & np.isfinite(b) & ((a > 0.0) | (b > 0.0)))
        if known.size:
            x, y = a[known], b[known]
            off = np.maximum(np.abs(x - y) - slack, 0.0) / np.maximum(np.abs(x), np.abs(y))
            worst = int(np.argsort(off)[(len(off) - 1) // 2])
            text = f"in line {lines[known[worst]]} {first} is {x[worst]:.4g} and {second} {y[worst]:.4g}"
            power = abs(math.log10(y[worst] / x[worst])) if x[worst] > 0.0 and y[worst] > 0.0 else 0.0
            if any(abs(power - one) < _POWER for one in (2.0, 3.0, 6.0)):
                text += f" (a factor of {10.0 ** round(power):g}, as between units)"
            yield bool(off[worst] <= _AGREE), text

    with np.errstate(all="ignore"):
        if "angular" in by_kind and "frequency" in by_kind:
            (first, omega), (second, same) = by_kind["angular"], by_kind["frequency"]
            yield from compared(f"{first} [rad/s]", omega, f"2 pi {second} [rad/s]", same)
        if "storage" not in by_kind:
            return
        storage = by_kind["storage"][1]
        loss = by_kind["loss"][1] if "loss" in by_kind else None
        if "tan_delta" in by_kind:
            name, tangent = by_kind["tan_delta"]
            if loss is not None:
                yield from compared(name, tangent, "loss over storage", loss / storage, _ROUNDED)
            else:
                loss = tangent * storage
        if "complex" in by_kind and loss is not None:
            name, size = by_kind["complex"]
            yield from compared(
                f"{name} [Pa]", size, "the size of storage and loss [Pa]", np.hypot(storage, loss)
            )


def _single(block: Block, values: dict[int, Floats]) -> dict[str, Floats]:
    """Return one column of each kind; two of a kind must agree."""
    found: dict[str, tuple[int, Floats]] = {}
    for at, column in values.items():
        kind = block.columns[at].kind
        if kind in found and kind in NOUNS:
            first, other = found[kind]
            both = np.isfinite(column) & np.isfinite(other)
            off = np.abs(column - other)[both] / np.maximum(np.abs(column), np.abs(other))[both]
            if off.size == 0 or not np.median(off) <= 0.01:
                raise RefusedError(
                    f"line {block.line} names two columns for the same: {block.columns[first].text} and "
                    f"{block.columns[at].text}",
                    "leave one of them in the file",
                )
        found.setdefault(kind, (at, column))
    return {kind: column for kind, (_, column) in found.items()}


def _strain(block: Block) -> str | None:
    """Return the strain that the names of the moduli show, or else those of other columns, as rheometers have."""
    strains = {
        known.strain
        for known in block.columns.values()
        if MEASURE[known.kind] in ("modulus", "compliance", "viscosity")
    }
    strains.discard(None)
    if not strains and any(OF_SHEAR.search(name.lower()) for name in block.names):
        return "shear"
    return strains.pop() if len(strains) == 1 else None


def _quantities(block: Block, index: int, values: dict[str, Floats]) -> Points:
    """Return frequencies, moduli and temperatures of the rows of a table."""
    unknown = np.full(len(block.rows), math.nan)
    omega = values.get("frequency")
    if "frequency" in block.common:
        omega = np.full(len(block.rows), block.common["frequency"])
    elif omega is None or (
        "angular" in values and _digits(values["angular"]) > _digits(omega / (2.0 * math.pi))
    ):
        omega = values["angular"]
    with np.errstate(all="ignore"):
        tangent = (
            values["tan_delta"]
            if "tan_delta" in values
            else np.tan(values.get("phase", np.full(1, math.nan)))
        )
        values = {**moduli_of(values, omega, tangent), **values}
        if "storage" in values:
            storage = values["storage"]
            loss = values["loss"] if "loss" in values else tangent * storage
        elif "loss" in values:
            loss = values["loss"]
            storage = loss / tangent
        else:
            storage = values["complex"] / np.hypot(1.0, tangent)
            loss = storage * tangent
    notes = []
    if "frequency" not in block.common and "storage" in values:
        if "loss" in values:
            with np.errstate(all="ignore"):
                notes += beside_slope(omega, storage, loss / storage, of_loss=True)
        elif "tan_delta" in values:
            notes += beside_slope(omega, storage, tangent)
    units = {known.kind: known.unit or "C" for known in block.columns.values()}
    return Points(
        line=np.array([line for line, _ in block.rows], dtype=np.int64),
        omega=omega,
        storage=storage,
        loss=loss,
        temperature=np.full(len(block.rows), block.common["temperature"])
        if "temperature" in block.common and "temperature" not in values
        else _celsius(values.get("temperature", unknown), units.get("temperature", "C")),
        set_temperature=_celsius(values.get("set_temperature", unknown), units.get("set_temperature", "C")),
        group=values.get("group", unknown) * 1.0 + 0.0,
        block=np.full(len(block.rows), index),
        strain=_strain(block),
        notes=tuple(notes),
    )


def _celsius(values: Floats, unit: str) -> Floats:
    known = unit_of(unit, "temperature")
    return values - 273.15 if known == "K" else (values - 32.0) / 1.8 if known == "F" else values


def _digits(values: Floats) -> float:
    """Return the mean number of digits of numbers, at most 12."""
    texts = [f"{value:.12g}" for value in values if math.isfinite(value) and value > 0.0]
    plain = [len(text.split("e")[0].replace(".", "").strip("0")) for text in texts]
    return sum(plain) / max(len(plain), 1)
