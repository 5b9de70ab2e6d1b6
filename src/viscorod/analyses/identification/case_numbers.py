"""Numbers of a case by their keys: read, and set, several at once under one name.

They are what the text of the case has, settings of its analysis included; those that it leaves out are numbers of its
model, as derivatives are taken by.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

from viscorod.analyses.derivatives.case_numbers import CaseNumber
from viscorod.casefile.case import Case, case_from_dict
from viscorod.casefile.case_keys import keys_of, parts_of
from viscorod.casefile.known_parts import KnownParts
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show

__all__ = ["case_with", "number_at", "where_to_look"]


def case_with(case: Case, values: Mapping[str, float], known: KnownParts | None = None) -> Case:
    """Return a case with other values; keys that it does not have are left out.

    Args:
        case: that has others; values: by key.
        known: parts of the same case with still other values; those that are the same are not read again.

    Raises:
        InputError: the case refuses a value.
    """
    content = copy.deepcopy(dict(case.content))
    for name, value in values.items():
        for key in keys_of(name):
            place, last = _place(content, key)
            if place is not None:
                place[last] = value
    return case_from_dict({"title": case.title, **content}, case.source, known=known)


def number_at(case: Case, name: str, *, strict: bool = False) -> float | None:
    """Return the number that a case has at a key; None where it has none.

    Args:
        case: that may have it; name: key, or several of numbers that are equal.
        strict: whether what cannot be a key is refused: names of records, and of their unknowns, may have blanks.

    Raises:
        InputError: there is something else, or, if strict, this is no key.
    """
    for key in keys_of(name):
        try:
            place, last = _place(case.content, key)
        except InputError:
            if strict:
                raise
            continue
        if place is None:
            continue
        try:
            value = place[last]
        except (KeyError, IndexError):
            return _left_out(case, key)
        if isinstance(value, str):  # a quantity with a unit: what it is in SI the case says
            found = [one for one in case.conversions if one.where == key]
            value = found[0].value if found else value
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(
                Fault(key, show(value), "this is not one number", "name one, as in loads[0].value[1]")
            )
        return float(value)
    return None


def _left_out(case: Case, key: str) -> float | None:
    """Return the number of the model that the text of a case leaves out; None if there is none."""
    try:
        return CaseNumber.of(case.description, key).value
    except InputError:
        return None


def where_to_look(case: Case, name: str) -> str:
    """Return what to write in place of a key that is none of a case."""
    try:
        CaseNumber.of(case.description, keys_of(name)[0])
    except InputError as error:
        return error.problems[0].instead
    return "name another"


def _place(content: Any, key: str) -> tuple[Any, Any]:
    """Return the table or list that holds a key, and the last part of it; None where there is none."""
    parts = parts_of(key)
    place = content
    for part in parts[:-1]:
        if isinstance(part, int):
            if not isinstance(place, list | tuple) or part >= len(place):
                return None, None
        elif not isinstance(place, Mapping) or part not in place:
            return None, None
        place = place[part]
    last = parts[-1]
    if isinstance(last, int):
        if not isinstance(place, list) or last >= len(place):
            return None, None
    elif not isinstance(place, Mapping) or (len(parts) == 2 and last not in place):
        return None, None
    return place, last
