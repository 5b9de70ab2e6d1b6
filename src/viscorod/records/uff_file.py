"""Functions of universal files (UFF, data sets 58) as columns, with the units that the file says.

A file holds functions of several kinds, over several abscissae: time histories beside responses, a coherence beside
every response. Time histories are named by node and direction, "3:+z", responses by both ends, "3:+z/1:+z", all others
with their kind before it, "coherence 3:+z/1:+z".

Units are those of the type of data, in SI; data set 164 has the inverses of length and force of other systems, and the
labels of axes say what no data set 164 does. Where both speak and differ, nobody knows, and the column has no unit.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError, let_interrupts_through
from viscorod.records.column_units import si_factor
from viscorod.records.columns import Columns, stacked

__all__ = ["columns_of_uff"]

QUANTITIES = {8: "m", 9: "N", 11: "m/s", 12: "m/s^2", 13: "N", 2: "1", 3: "1"}
"""SI units by the type of data of an axis."""
TIME, RESPONSES = 1, (4, 5)
"""Types of functions: a history; responses and transmissibilities."""
KINDS = {2: "autospectrum", 3: "cross spectrum", 6: "coherence", 7: "autocorrelation", 8: "cross correlation",
         9: "psd", 10: "esd", 12: "spectrum", 26: "multiple coherence"}  # fmt: skip
DIFFER = 1e-3
"""Relative difference of two units that contradict each other."""


def columns_of_uff(path: Path, library: Any, wanted: str | None = None) -> Columns:
    """Return the functions of a file that share an abscissa: those beside the wanted one, or the most.

    Args:
        path: of the file; library: pyuff.
        wanted: name of one of the functions.

    Raises:
        InputError: it cannot be read, or has no functions.
    """
    try:
        everything = library.UFF(str(path)).read_sets()
        everything = [everything] if isinstance(everything, dict) else everything
        sets = [one for one in everything if one.get("type") == 58]
        told = next((one for one in everything if one.get("type") == 164), None)
        sizes = None if told is None else {name: 1.0 / float(told[name]) for name in ("length", "force")}
    except Exception as error:  # the reader fails in many ways on what is no UFF
        let_interrupts_through(error)
        raise InputError(
            Fault(str(path), "", f"it cannot be read as UFF ({error})", "check the file")
        ) from None
    if not sets:
        raise InputError(
            Fault(str(path), "", "it has no functions (data sets 58)", "export time histories or responses")
        )
    groups: list[list[dict[str, Any]]] = []
    for one in sets:
        group = next((group for group in groups if _same_abscissa(group[0], one)), None)
        if group is None:
            groups.append([one])
        else:
            group.append(one)
    beside = [group for group in groups if wanted is not None and wanted in map(_name, group)]
    chosen = beside[0] if beside else max(groups, key=len)
    others = [_name(one) for group in groups if group is not chosen for one in group]
    first = chosen[0]
    names = ["time" if _is_time(first) else "frequency", *map(_name, chosen)]
    columns = [np.asarray(first["x"], dtype=float)]
    units: list[str | None] = ["s" if _is_time(first) else "Hz"]
    for one in chosen:
        size, unit = _size_and_unit(one, sizes)
        columns.append(np.asarray(one["data"]) * size)
        units.append(unit)
    found = stacked(str(path), names, columns, units)
    if wanted is not None and not beside and others and wanted not in names:
        raise InputError(
            Fault(
                f"{path}: value",
                repr(wanted),
                "no function has this name",
                f"give one of {', '.join([*names[1:], *others][:24])}",
            )
        )
    return found


def _is_time(one: dict[str, Any]) -> bool:
    """Return whether a function goes over time: a history, or one of no kind whose abscissa is time."""
    kind = int(one.get("func_type") or 0)
    return kind == TIME or (kind not in RESPONSES and int(one.get("abscissa_spec_data_type") or 0) == 17)


def _same_abscissa(one: dict[str, Any], other: dict[str, Any]) -> bool:
    x, y = np.asarray(one["x"], dtype=float), np.asarray(other["x"], dtype=float)
    return _is_time(one) == _is_time(other) and len(x) == len(y) and bool(np.allclose(x, y))


def _name(one: dict[str, Any]) -> str:
    """Return "3:+z" of a history, "3:+z/1:+z" of a response, "coherence 3:+z/1:+z" of others."""
    kind = int(one.get("func_type") or 0)
    place = f"{one.get('rsp_node', 0)}{_axis(one.get('rsp_dir', 0))}"
    if kind == TIME:
        return place
    whole = f"{place}/{one.get('ref_node', 0)}{_axis(one.get('ref_dir', 0))}"
    return whole if kind in (*RESPONSES, 0) else f"{KINDS.get(kind, f'function {kind}')} {whole}"


def _axis(code: int) -> str:
    """Return the direction of a node, "+x" of 1, "-z" of -3."""
    word = {1: "x", 2: "y", 3: "z", 4: "rx", 5: "ry", 6: "rz"}.get(abs(int(code)), "")
    return f":{'-' if code < 0 else '+'}{word}" if word else ""


def _size_and_unit(one: dict[str, Any], sizes: dict[str, float] | None) -> tuple[float, str | None]:
    """Return the factor on the numbers of a function, and their unit then; None where it is not known."""
    if int(one.get("func_type") or 0) not in RESPONSES:
        return _axis_unit(one, "ordinate", sizes)
    label = str(one.get("ordinate_axis_units_lab") or "").strip()
    whole = re.fullmatch(r"\(?(.+?)\)?\s*/\s*\(?([^/()]+)\)?", label)  # "g/N", all of it beside the numerator
    if whole is not None:
        parts = {**one, "ordinate_axis_units_lab": whole[1], "orddenom_axis_units_lab": whole[2]}
        if all(_label_size(parts, axis) is not None for axis in ("ordinate", "orddenom")):
            one = parts
    over, under = (_axis_unit(one, axis, sizes) for axis in ("ordinate", "orddenom"))
    if over[1] is None or under[1] is None:
        return 1.0, None
    return over[0] / under[0], over[1] if under[1] == "1" else f"({over[1]})/({under[1]})"


def _axis_unit(one: dict[str, Any], axis: str, sizes: dict[str, float] | None) -> tuple[float, str | None]:
    told = QUANTITIES.get(int(one.get(f"{axis}_spec_data_type") or 0))
    if told is None:
        return 1.0, None
    by_set = 1.0 if sizes is None or told == "1" else sizes["force" if told == "N" else "length"]
    by_label = _label_size(one, axis)
    if by_label is None or abs(by_label / by_set - 1.0) < DIFFER:
        return by_set, told
    return (by_label, told) if sizes is None else (1.0, None)


def _label_size(one: dict[str, Any], axis: str) -> float | None:
    """Return the SI value of the unit in an axis' label; None where there is none of its kind."""
    told = QUANTITIES.get(int(one.get(f"{axis}_spec_data_type") or 0))
    label = str(one.get(f"{axis}_axis_units_lab") or "").strip()
    try:
        return si_factor("", "", label, told) if told is not None and label not in ("", "NONE") else None
    except InputError:  # a remark
        return None
