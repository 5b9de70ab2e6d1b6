"""Records from tables of a case file, one table a record."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from viscorod.argument_names import MISSING
from viscorod.checks import file_path
from viscorod.errors import Fault, InputError
from viscorod.records.any_record import AnyRecord
from viscorod.records.arguments import described
from viscorod.records.modes_record import ModesRecord
from viscorod.records.moduli_record import ModuliRecord
from viscorod.records.motion_record import Record
from viscorod.records.other_files import columns_of
from viscorod.records.response_record import ResponseRecord
from viscorod.records.static_record import StaticRecord
from viscorod.records.unknown import Unknown

__all__ = ["record_of"]

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
    """Return a table of frequencies; from a file by the columns `frequency` and, if given, `damping_ratio`."""
    file = given.pop("file", None)
    if file is not None:
        gaps, wanted = given.pop("gaps", "refuse"), [("frequency", given.get("frequency", 1))]
        if "damping_ratio" in given:
            wanted.append(("damping_ratio", given["damping_ratio"]))
        columns = columns_of(file).kept(gaps, wanted)
        given["frequencies"] = columns.si(
            "frequency", given.pop("frequency", 1), "Hz", given.pop("frequency_unit", None)
        )
        if "damping_ratio" in given:
            ratio = given.pop("damping_ratio")
            plain = "1" if given.get("damping_as", "ratio") != "ratio" else None
            if plain is not None and columns.units[columns.number("damping_ratio", ratio)] is not None:
                plain = None  # per cent of critical that the table calls so are ratios by then
            given["damping_ratios"] = columns.si(
                "damping_ratio", ratio, "1", given.pop("damping_ratio_unit", plain)
            )
    return ModesRecord(**given)


def _static(given: dict[str, Any]) -> AnyRecord:
    """Return static loads; from a file by the columns `load` and `value`."""
    file = given.pop("file", None)
    if file is not None:
        load, value = given.pop("load", 1), given.pop("value", 2)
        columns = columns_of(file).kept(given.pop("gaps", "refuse"), [("load", load), ("value", value)])
        unit = "1" if given.get("quantity") == "strain" else "N" if given.get("quantity") == "force" else "m"
        given["loads"] = columns.si("load", load, "N", given.pop("load_unit", None))
        given["values"] = columns.si("value", value, unit, given.pop("unit", None))
    return StaticRecord(**given)


def _moduli(given: dict[str, Any]) -> AnyRecord:
    file = given.pop("file", None)
    return ModuliRecord(**given) if file is None else ModuliRecord.read(file, **given)


_MAKERS = {"motion": _motion, "response": _response, "modes": _modes, "static": _static, "moduli": _moduli}
