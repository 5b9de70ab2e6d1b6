"""What of a sweep is looked at before any member is computed."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace

from viscorod.analyses.case_run import discretised_case
from viscorod.analyses.sweeps.member_work import MemberWork, member_case
from viscorod.analyses.sweeps.rows import Row
from viscorod.casefile.case import Case
from viscorod.casefile.known_parts import KnownParts
from viscorod.casefile.unit_conversion import unit_at
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.results.quantities import Quantity
from viscorod.results.sweep_members import Rows

__all__ = ["checked", "require_sendable", "units_of"]


def checked(
    case: Case, rows: Mapping[int, Row], quantities: Sequence[Quantity], keep: bool
) -> tuple[list[str], dict[int, Case]]:
    """Refuse wrong keys, values and places before anything is computed.

    Args:
        rows: the values of members that are looked at, by their numbers.

    Returns:
        What was chosen for all members, and the cases of those that were looked at, about 10 kB each.
    """
    notes: list[str] = []
    read: dict[int, Case] = {}
    problems: dict[tuple[str, str], tuple[Fault, list[int]]] = {}
    known = KnownParts()
    places = {quantity.place: quantity.name for quantity in quantities if quantity.place}
    for k, row in rows.items():
        try:
            read[k], note = member_case(case.content, case.source, case.title, row, keep, known)
            if k == 0 and places:
                _require_places(read[k], places)
        except InputError as error:
            for problem in error.problems:  # the same mistake in many members is reported once
                problems.setdefault((problem.where, problem.why), (problem, []))[1].append(k)
            continue
        notes += [note] if note else []
    if problems:
        told = [_with_members(fault, numbers, rows) for fault, numbers in problems.values()]
        raise InputError(told, heading=str(case.source) if case.source else "case")
    return list(dict.fromkeys(notes)), read


def units_of(case: Case, rows: Rows) -> dict[str, str]:
    """Return the SI units of the keys whose values are numbers that have one."""
    found = {
        key: unit_at(case.content, key)
        for key, column in rows.columns.items()
        if isinstance(column[0], int | float | str) and not isinstance(column[0], bool)
    }
    return {key: unit for key, unit in found.items() if unit not in ("", "1")}


def _with_members(fault: Fault, numbers: Sequence[int], rows: Mapping[int, Row]) -> Fault:
    """Return a fault with the members that have it, unless all have; and its values, if it is told elsewhere."""
    if len(numbers) == len(rows):
        return fault
    first, more = numbers[0], len(numbers) - 1
    which = f"member {first}" + (f" and {more} more" if more else "")
    if not any(fault.where.startswith(key) for key in rows[first]):
        varied = {
            key: value
            for key, value in rows[first].items()
            if any(row[key] != value for row in rows.values())
        }
        which += (
            f", where {', '.join(f'{key} = {show(value)}' for key, value in varied.items())}"
            if varied
            else ""
        )
    return replace(fault, why=f"{fault.why} ({which})")


def _require_places(case: Case, places: Mapping[str, str]) -> None:
    """Refuse places that the model does not have."""
    try:
        discrete = discretised_case(case)
    except InputError:  # that is a failure of this member
        return
    for place, name in places.items():
        try:
            discrete.place(place)
        except InputError as error:
            raise InputError(Fault(f"quantities.{name}", place, str(error), "")) from None


def require_sendable(work: MemberWork) -> None:
    """Refuse functions that other processes would not find."""
    for quantity in work.quantities:
        try:
            pickle.dumps(quantity)
        except (pickle.PicklingError, AttributeError, TypeError):
            why = "this function cannot be sent to other processes"
            instead = "define it in a module, give workers=1, or executor='threads:2'"
            raise InputError(Fault(f"quantities.{quantity.name}", "", why, instead)) from None
