"""Result of a sweep: its members, one data set over all of them, a table, the file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError, model_validator

from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.data_schema import DIMENSION
from viscorod.results.files.storage import read, result_of, write
from viscorod.results.sweep_figures import FIGURES, figures_of, shown
from viscorod.results.text_table import table

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.any_result import AnyResult

ALONG = DIMENSION | {
    "response": "frequency",
    "campbell": "speed",
    "stability": "load_factor",
    "periodic": "point",
}
"""Kind of a result -> dimension of its states."""
KIND = "sweep"
COMPLETED = "completed"


@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep.

    Attributes:
        number: place in the table of values, from 0.
        values: parameter -> value, as given.
        result: the run, equilibrium or steady rotation; where it failed, what there is up to there, or None.
        message: why it failed, empty if it did not.
        outcome: "completed", or what stopped it.
    """

    number: int
    values: Mapping[str, Any]
    result: AnyResult | None
    message: str = ""
    outcome: str = COMPLETED

    @property
    def completed(self) -> bool:
        """True if there is a whole result."""
        return self.outcome == COMPLETED and self.result is not None

    def figures(self) -> dict[str, float]:
        """Return numbers of the result by which members are compared, see ``viscorod.results.sweep_figures``."""
        return figures_of(self.result)


class Sweep:
    """The members of a sweep, in the order of their values.

    Attributes:
        members: all of them, failed ones too.
        notes: choices made for the user.
    """

    def __init__(self, members: Sequence[SweepRun], title: str = "", notes: Sequence[str] = ()) -> None:
        if not isinstance(members, Sequence) or not all(isinstance(member, SweepRun) for member in members):
            raise InputError("members: a list of SweepRun is needed here; viscorod.sweep computes one")
        if not isinstance(notes, Sequence):
            raise InputError(f"notes: {notes!r}: a list of texts is needed here")
        self.members = tuple(members)
        self.title = title
        self.notes = tuple(notes)

    @property
    def parameters(self) -> tuple[str, ...]:
        """The keys that were varied."""
        return tuple(self.members[0].values) if self.members else ()

    @property
    def completed(self) -> tuple[SweepRun, ...]:
        """The members with a whole result."""
        return tuple(member for member in self.members if member.completed)

    @property
    def failed(self) -> tuple[SweepRun, ...]:
        """The other members."""
        return tuple(member for member in self.members if not member.completed)

    @cached_property
    def separate(self) -> str:
        """The reason why ``data`` holds no fields: differences between completed members; empty if they are stacked."""
        results = [member.result.data for member in self.completed if member.result is not None]
        return next((text for other in results[1:] if (text := _difference(results[0], other))), "")

    @cached_property
    def data(self) -> xr.Dataset:
        """The completed members as one ``xarray.Dataset`` with a dimension ``member``.

        Coordinates along it are the number of the member and its values. Fields of the runs are stacked if all
        members have the same stations and the same times (or load factors); otherwise, see ``separate``, only steps,
        wall time and numerical fraction are there, and fields are read from ``members``. Nothing is padded.
        """
        import xarray as xr

        kept = self.completed
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {"member": np.array([member.number for member in kept], dtype=np.int64)}
        for name in self.parameters:
            coordinates[name] = ("member", _column([member.values[name] for member in kept]))
        rows = [member.figures() for member in kept]
        for name, figure in FIGURES.items():
            if rows and all(name in row for row in rows):
                attributes = {"units": figure.unit, "long_name": figure.words}
                dtype = np.int64 if name == "steps" else np.float64
                variables[name] = ("member", np.array([row[name] for row in rows], dtype), attributes)
        if kept and not self.separate:
            fields, axes = _stacked([member.result.data for member in kept if member.result is not None])
            variables |= fields
            coordinates |= axes
        return xr.Dataset(variables, coordinates, attrs={"kind": KIND, "title": self.title})

    def report(self) -> str:
        """Return a table of the members: values, figures, outcome; then what failed."""
        figures = [member.figures() for member in self.members]
        columns = shown(figures)
        header = ("member", *self.parameters, *(FIGURES[name].heading for name in columns), "outcome")
        rows = [
            (
                str(member.number),
                *(_text(value) for value in member.values.values()),
                *(FIGURES[name].show(row[name]) if name in row else "-" for name in columns),
                member.outcome,
            )
            for member, row in zip(self.members, figures, strict=True)
        ]
        count = f"{len(self.members)} members, {len(self.completed)} completed"
        blocks = [table(f"{self.title}: {count}" if self.title else count, header, rows)]
        blocks += [f"member {member.number}: {member.message}" for member in self.failed]
        blocks += self.notes
        if self.separate:
            blocks.append(f"The members are kept apart: {self.separate}")
        return "\n\n".join(blocks)

    def __str__(self) -> str:
        return self.report()

    @checked
    def save(self, path: str | Path) -> Path:
        """Write one netCDF4 file, for ``viscorod.load`` and any HDF5 tool; returns the path.

        Its root is ``data``; results that are not in there (of members that failed or differ) are groups
        ``member_0``, ``member_1``, ...
        """
        record = {
            "notes": self.notes,
            "members": [
                {
                    "number": member.number,
                    "values": member.values,
                    "message": member.message,
                    "outcome": member.outcome,
                    "attrs": None if member.result is None else member.result.data.attrs,
                }
                for member in self.members
            ],
        }
        groups = {
            f"member_{member.number}": member.result.data
            for member in self.members
            if member.result is not None and (self.separate or not member.completed)
        }
        return write(self.data.assign_attrs(sweep=json.dumps(record, default=_plain)), path, groups)

    @classmethod
    def of(cls, data: xr.Dataset, path: Path) -> Sweep:
        """Return the sweep whose file is ``path`` and whose root is ``data``."""
        try:
            record = _Record.model_validate_json(data.attrs["sweep"])
        except (KeyError, ValidationError) as error:
            why = " ".join(str(error).split())[:200]
            raise InputError(
                f"{path} is damaged: the attribute sweep is no record of a sweep ({why}); "
                "take another copy of the file, or compute it again"
            ) from None
        return cls(
            [_member(row, data, path) for row in record.members],
            str(data.attrs.get("title", "")),
            record.notes,
        )


class _Row(BaseModel):
    """A member in the record of a file."""

    number: Annotated[int, Field(ge=0)]
    values: dict[str, Any]
    message: str
    outcome: str
    attrs: dict[str, Any] | None


class _Record(BaseModel):
    """What a file says of all members."""

    notes: list[str]
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
        whole = _unstacked(data, row.number) if stacked else read(path, group=f"member_{row.number}")
        whole.attrs = row.attrs
        result = result_of(whole, path)
    return SweepRun(row.number, row.values, result, row.message, row.outcome)


_LEVELS = {
    "time": "stored times",
    "load_factor": "load steps",
    "spin": "angular speeds",
    "speed": "angular speeds",
    "point": "motions",
    "frequency": "frequencies",
}


def _difference(one: xr.Dataset, other: xr.Dataset) -> str:
    """Say what keeps two results from being stacked; empty if nothing does."""
    if one.attrs["kind"] != other.attrs["kind"] or set(one.variables) != set(other.variables):
        return "they hold different quantities"
    along = ALONG[one.attrs["kind"]]
    for name in one.dims:
        if one.sizes[name] != other.sizes[name] and name != along:
            return f"their numbers of {name}s differ ({one.sizes[name]} and {other.sizes[name]})"
    for name in one.variables:
        a, b = one[name].values, other[name].values
        fixed = name in one.dims or a.dtype.kind not in "fi"
        if a.shape != b.shape or (fixed and not np.array_equal(a, b)):
            return f"their {_LEVELS.get(along if along in one[name].dims else '', str(name))} differ"
    return ""


def _stacked(results: Sequence[xr.Dataset]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of results that differ in values only; what is equal in all is kept once."""
    first = results[0]
    along = ALONG[first.attrs["kind"]]
    fields: dict[str, Any] = {}
    axes: dict[str, Any] = {}
    for name, variable in first.variables.items():
        columns = [result[name].values for result in results]
        states = along in variable.dims and name not in first.dims
        if states or not all(np.array_equal(columns[0], column) for column in columns[1:]):
            built = (("member", *variable.dims), np.stack(columns), dict(variable.attrs))
        else:
            built = (variable.dims, columns[0], dict(variable.attrs))
        (axes if name in first.coords else fields)[str(name)] = built
    return fields, axes


def _unstacked(data: xr.Dataset, number: int) -> xr.Dataset:
    """Return the fields of one member, as its own result holds them."""
    return data.drop_vars(list(FIGURES), errors="ignore").sel(member=number, drop=True)


def _column(values: Sequence[Any]) -> np.ndarray:
    """Return values along ``member``: numbers or texts as they are, anything else as JSON."""
    if all(isinstance(value, str) for value in values):
        return np.array(values, dtype=str)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values)
    return np.array([json.dumps(value, default=_plain) for value in values], dtype=str)


def _plain(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else str(value)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
