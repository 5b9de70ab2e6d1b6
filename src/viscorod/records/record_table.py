"""Records from tables of a case file, one table a record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from viscorod.argument_names import MISSING
from viscorod.checks import file_path
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError
from viscorod.records.any_record import AnyRecord
from viscorod.records.arguments import described
from viscorod.records.columns import Columns
from viscorod.records.modes_record import ModesRecord, spread_of_ratios
from viscorod.records.moduli_record import ModuliRecord
from viscorod.records.motion_record import Record
from viscorod.records.other_files import columns_of
from viscorod.records.read_off import QUANTITIES
from viscorod.records.response_record import ResponseRecord
from viscorod.records.static_record import StaticRecord
from viscorod.records.unknown import Unknown
from viscorod.typing import Floats
from viscorod.unit_text import factor_of

__all__ = ["record_of"]

MODE_COLUMNS = {
    "frequency": "Hz",
    "damping_ratio": "1",
    "frequency_noise": "Hz",
    "ratio_noise": "1",
    "modes": "1",
}
"""Columns of a table of modes, with their units."""
BRANCHES = ("loading", "unloading")
MOTION_KEYS = ("window", "every", "still", "window_time")
"""What is done to a history after it was read: an exponential window taken off, then noise, cut, decimated."""


@described
def record_of(table: Mapping[str, Any], folder: str | Path = ".") -> AnyRecord:
    """Return the record that a table describes.

    Its `kind` is "motion" (the default), "response", "modes", "static" or "moduli"; `file` is its path from the folder
    on; the other keys are the arguments of `Record`, `ResponseRecord`, `ModesRecord`, `StaticRecord`, `ModuliRecord`
    and their `read`. An unknown is a word or a table with the attributes of `Unknown`. Of histories also
    `window_time` of an exponential window that is taken off, s; `still` [from, to], a stretch at rest that gives the
    noise; `window` [from, to]; `every`, for decimation.

    Raises:
        InputError: a key is missing, unknown or wrong.
    """
    if not isinstance(table, Mapping):
        raise InputError(
            Fault("record", type(table).__name__, "no table of a record", "give keys with values")
        )
    given = {str(key): value for key, value in table.items()}
    kind = given.pop("kind", "motion")
    if not isinstance(kind, str) or kind not in _MAKERS:
        raise InputError(Fault("kind", repr(kind), "no kind of record", f"use one of {', '.join(_MAKERS)}"))
    if "file" in given:
        given["file"] = str(Path(folder) / file_path("file", given["file"]))
    if "unknown" in given:
        listed = given["unknown"] if isinstance(given["unknown"], list) else [given["unknown"]]
        given["unknown"] = listed
    try:
        if "unknown" in given:
            given["unknown"] = [
                Unknown(**one) if isinstance(one, Mapping) else one for one in given["unknown"]
            ]
        return _MAKERS[kind](given)
    except InputError as error:
        lacking = [one.where.rpartition(": ")[2] for one in error.problems if one.why == MISSING]
        if not lacking:
            raise
        why = f"a record of kind {kind} needs this key, which is missing"
        raise InputError([Fault(key, "", why, f"add {key}") for key in lacking]) from None


def _motion(given: dict[str, Any]) -> AnyRecord:
    after = {key: given.pop(key) for key in MOTION_KEYS if key in given}
    file = given.pop("file", None)
    record = Record(**given) if file is None else Record.read(file, **given)
    if "window_time" in after:
        record = record.without_exponential(after["window_time"])
    if "still" in after:
        record = record.with_noise_of(*_two("still", after["still"]))
    if "window" in after:
        record = record.window(*_two("window", after["window"]))
    return record.decimated(after["every"]) if "every" in after else record


def _two(key: str, value: Any) -> Sequence[float]:
    if isinstance(value, str | bytes) or not isinstance(value, Sequence) or len(value) != 2:
        raise InputError(Fault(key, repr(value)[:60], "two times are needed", "give [from, to], s"))
    return value


def _response(given: dict[str, Any]) -> AnyRecord:
    file = given.pop("file", None)
    return ResponseRecord(**given) if file is None else ResponseRecord.read(file, **given)


def _modes(given: dict[str, Any]) -> AnyRecord:
    """Return a table of frequencies; from a file by the names or numbers of its columns.

    `frequency`, and if given `damping_ratio`, their standard deviations `frequency_noise` and `ratio_noise`, and
    `modes` (whole numbers) are columns then; numbers and lists of the last three are what they say.
    """
    file = given.pop("file", None)
    if file is None:
        return ModesRecord(**given)
    given.setdefault("frequency", 1)
    named = [key for key in MODE_COLUMNS if isinstance(given.get(key), str) or key == "frequency"]
    named += ["damping_ratio"] if isinstance(given.get("damping_ratio"), int) else []
    columns = columns_of(file).kept(given.pop("gaps", "refuse"), [(key, given[key]) for key in named])
    of_ratios = given.pop("damping_ratio_unit", None)
    hertz = given.pop("frequency_unit", None)
    found = {
        key: columns.si(key, one := given.pop(key), MODE_COLUMNS[key],
                        _unit_of_mode(columns, key, one, hertz, of_ratios, given.get("damping_as", "ratio")))
        for key in named
    }  # fmt: skip
    given["frequencies"] = found.pop("frequency")
    if "damping_ratio" in found:
        given["damping_ratios"] = found.pop("damping_ratio")
    if "ratio_noise" in found and "damping_ratios" in given:
        found["ratio_noise"] = spread_of_ratios(
            given["damping_ratios"], found["ratio_noise"], given.get("damping_as", "ratio")
        )
    if "modes" in found:
        given["modes"] = [int(one) if one == int(one) else float(one) for one in found.pop("modes")]
    given.update(found)
    return ModesRecord(**given)


def _unit_of_mode(
    columns: Columns, key: str, column: str | int, hertz: str | None, of_ratios: str | None, measure: str
) -> str | None:
    """Return the unit of a column of a table of modes where the file does not say."""
    if key in ("frequency", "frequency_noise"):
        return hertz
    if key == "modes":
        return "1"
    if measure != "ratio" and columns.units[columns.number(key, column)] is None:
        return of_ratios or "1"
    return of_ratios  # per cent of critical that the table calls so are ratios by then


def _static(given: dict[str, Any]) -> AnyRecord:
    """Return static loads; from a file by the columns `load` and `value`, of there and back one `branch`."""
    file = given.pop("file", None)
    if file is not None:
        load, value = given.pop("load", 1), given.pop("value", 2)
        columns = columns_of(file).kept(given.pop("gaps", "refuse"), [("load", load), ("value", value)])
        quantity = given.get("quantity", "displacement")
        unit = (
            "1" if quantity == "strain" else QUANTITIES[quantity].units[0] if quantity in QUANTITIES else "m"
        )
        load_unit = given.pop("load_unit", None)
        loads = columns.si("load", load, _kind_of_load(columns, load, load_unit), load_unit)
        values = columns.si("value", value, unit, given.pop("unit", None))
        rows = _branch(columns.source, loads, given.pop("branch", None))
        given["loads"], given["values"] = loads[rows], values[rows]
    return StaticRecord(**given)


def _kind_of_load(columns: Columns, load: str | int, given: str | None) -> str:
    """Return the SI unit of the loads of a file: that of a moment where the file or `load_unit` has one."""
    written = columns.units[columns.number("load", load)] or given
    try:
        kind = factor_of(str(written))[1]
    except RefusedError:
        return "N"  # what is wrong with it is told where it is read
    return "N m" if kind == factor_of("N m")[1] else "N"


def _branch(source: str, loads: Floats, branch: Any) -> np.ndarray:
    """Return the rows of loads that go from nothing on, or those that come back, or all.

    Raises:
        InputError: it is no word, or loads go there and back and nobody says which part is meant.
    """
    size, rows = np.abs(loads), np.arange(len(loads))
    top = int(np.argmax(size))
    if branch not in (None, *BRANCHES):
        raise InputError(Fault("branch", repr(branch), "it is not known", f"use {' or '.join(BRANCHES)}"))
    if branch is not None:
        rows = rows[: top + 1] if branch == "loading" else rows[top:]
    elif (
        0 < top < len(loads) - 1
        and (np.diff(size[: top + 1]) > 0.0).all()
        and (np.diff(size[top:]) < 0.0).all()
    ):
        why = f"the loads go up to {loads[top]:g} in row {top + 1}, and back"
        raise InputError(
            Fault(f"{source}: load", "", why, "give branch = 'loading' or 'unloading', one record of each")
        )
    return rows


def _moduli(given: dict[str, Any]) -> AnyRecord:
    file = given.pop("file", None)
    return ModuliRecord(**given) if file is None else ModuliRecord.read(file, **given)


_MAKERS = {"motion": _motion, "response": _response, "modes": _modes, "static": _static, "moduli": _moduli}
