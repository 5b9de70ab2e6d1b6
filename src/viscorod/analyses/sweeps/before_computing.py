"""What of a sweep is looked at before any member is computed."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import replace

from viscorod.analyses.case_run import discretised_case
from viscorod.analyses.sweeps.looked import Looked
from viscorod.analyses.sweeps.member_work import MemberWork
from viscorod.analyses.sweeps.rows import Row
from viscorod.casefile.case import Case
from viscorod.casefile.unit_conversion import unit_at
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.results.sweep_members import Rows

__all__ = ["FEW", "checked", "require_right", "require_sendable", "units_of"]

FEW = 16
"""Members that are looked at before processes look at others."""


def checked(work: MemberWork, rows: Mapping[int, Row]) -> tuple[Looked, dict[int, Case]]:
    """Return what there is to say of some members, by their numbers, and their cases, about 10 kB each.

    The places of quantities are looked for in member 0.
    """
    looked, read = work.looked_at(rows)
    places = {quantity.place: quantity.name for quantity in work.quantities if quantity.place}
    if 0 in read and places:
        try:
            _require_places(read[0], places)
        except InputError as error:
            looked.refuse(error, 0)
    return looked, read


def require_right(
    case: Case, looked: Looked, rows: Sequence[Row], numbers: Sequence[int], same: Mapping[int, int]
) -> None:
    """Refuse wrong keys, values and places before anything is computed.

    Args:
        rows: the values of all members; numbers: of those that were looked at.
        same: members with the values of others, which were not.

    Raises:
        InputError: something is wrong.
    """
    if looked.problems:
        of_some = {k: rows[k] for k in [*numbers, *same]}
        in_order = sorted(looked.problems.values(), key=lambda problem: min(problem[1]))
        told = []
        for fault, wrong in in_order:
            known = set(wrong)
            like = [k for k, one in same.items() if one in known]
            told.append(_with_members(fault, sorted([*wrong, *like]), of_some))
        raise InputError(told, heading=str(case.source) if case.source else "case")


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
