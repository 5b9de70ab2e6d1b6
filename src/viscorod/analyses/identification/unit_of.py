"""The unit of a number that is sought."""

from __future__ import annotations

from collections.abc import Sequence

from viscorod.analyses.identification.case_numbers import number_at
from viscorod.analyses.identification.members import Member
from viscorod.casefile.case_keys import keys_of
from viscorod.casefile.unit_conversion import unit_at

__all__ = ["unit_of"]


def unit_of(members: Sequence[Member], name: str) -> str:
    """Return the SI unit of an unknown, "1" of a plain number, empty where it is not known."""
    for member in members:
        for record in member.records:
            one = record.nuisances.get(name)
            if one is not None and one.key is None:
                return str(record.unit_of(one))
        key = member.key_of(name)
        if key is not None:
            own = next(one for one in keys_of(key) if number_at(member.case, one) is not None)
            return unit_at(member.case.content, own)
    return ""
