"""What a netCDF file of a sweep says of its members beside their numbers, and its members read back."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BaseModel, Field, ValidationError, model_validator

from viscorod.errors import InputError
from viscorod.results.files.storage import read, result_of
from viscorod.results.stacked_members import ALONG, plain, unstacked
from viscorod.results.sweep_figures import FIGURES
from viscorod.results.sweep_members import SweepMembers, SweepRun

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["members_of", "record_of"]


def record_of(members: SweepMembers, notes: Sequence[str]) -> str:
    """Return what a file says of its members, as JSON."""
    record = {
        "notes": notes,
        "quantities": list(members.found.quantities),
        "units": members.rows.units,
        "members": [
            {
                "number": member.number,
                "values": member.values,
                "message": member.message,
                "outcome": member.outcome,
                "attrs": None if member.result is None else member.result.data.attrs,
                "quantities": member.quantities,
                "measured": member.measured,
            }
            for member in members
        ],
    }
    return json.dumps(record, default=plain)


def members_of(data: xr.Dataset, path: Path) -> tuple[SweepMembers, list[str]]:
    """Return members and notes of the file ``path`` whose root is ``data``.

    Raises:
        InputError: it is damaged.
    """
    try:
        record = _Record.model_validate_json(data.attrs["sweep"])
    except (KeyError, ValidationError) as error:
        why = " ".join(str(error).split())[:200]
        raise InputError(
            f"{path} is damaged: the attribute sweep is no record of a sweep ({why}); "
            "take another copy of the file, or compute it again"
        ) from None
    members = SweepMembers.of((_member(row, data, path) for row in record.members), record.quantities)
    members.rows.units = record.units
    return members, record.notes


class _Row(BaseModel):
    """A member in the record of a file."""

    number: Annotated[int, Field(ge=0)]
    values: dict[str, Any]
    message: str
    outcome: str
    attrs: dict[str, Any] | None
    quantities: dict[str, float | list[float]] = {}
    measured: dict[str, float] = {}


class _Record(BaseModel):
    """What a file says of all members."""

    notes: list[str]
    quantities: list[str] = []
    units: dict[str, str] = {}
    members: list[_Row]

    @model_validator(mode="after")
    def _of_one_table(self) -> Self:
        if [row.number for row in self.members] != list(range(len(self.members))):
            raise ValueError("members are not numbered from 0")
        if any(list(row.values) != list(self.members[0].values) for row in self.members):
            raise ValueError("members have different parameters")
        return self


def _member(row: _Row, data: xr.Dataset, path: Path) -> SweepRun:
    """Return a member of a file, whose fields are stacked with those of others or in a group of its own."""
    result = None
    if row.attrs is not None:
        along = ALONG.get(str(row.attrs.get("kind")), "")
        stacked = "member" in data.coords and along in data.dims and row.number in data["member"].values
        own = [*FIGURES, *row.quantities, *row.values, "instant"]
        fields = data.drop_vars(own, errors="ignore")
        whole = unstacked(fields, row.number) if stacked else read(path, group=f"member_{row.number}")
        whole.attrs = row.attrs
        result = result_of(whole, path)
    parts = (row.message, row.outcome, row.quantities, row.measured)
    return SweepRun(row.number, row.values, result, *parts)
