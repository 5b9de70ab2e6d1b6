"""Result of a sweep: its members, one data set over all of them, a table, the file."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BaseModel, Field, ValidationError, model_validator

from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import InputError
from viscorod.results.data_schema import DIMENSION
from viscorod.results.files.storage import read, result_of, write
from viscorod.results.quantities import HISTORY_TIMES
from viscorod.results.sweep_figures import FIGURES, shown
from viscorod.results.sweep_members import COMPLETED, SweepMembers, SweepRun
from viscorod.results.text_table import page, table
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


ALONG = DIMENSION | {
    "response": "frequency",
    "campbell": "speed",
    "stability": "load_factor",
    "periodic": "point",
}
"""Kind of a result -> dimension of its states."""
KIND = "sweep"
DRAWN = 200
"""Members in a small drawing."""
MOST_ROWS = 60
"""Members that a report lists; a table has all."""


class Sweep(WellNamed, Shown):
    """The members of a sweep, in the order of their values.

    Attributes:
        members: all of them, failed ones too.
        notes: choices made for the user.
    """

    def __init__(self, members: Sequence[SweepRun], title: str = "", notes: Sequence[str] = ()) -> None:
        if not isinstance(members, SweepMembers):
            if not isinstance(members, Sequence) or not all(isinstance(one, SweepRun) for one in members):
                raise InputError("members: a list of SweepRun is needed here; viscorod.sweep computes one")
            members = SweepMembers.of(members)
        if not isinstance(notes, Sequence):
            raise InputError(f"notes: {notes!r}: a list of texts is needed here")
        self.members = members
        self.title = title
        self.notes = tuple(notes)

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.members), "member")
        if missing := len(self.members) - self.count_completed:
            yield f"{missing} not completed"
        yield f"over {', '.join(self.parameters)}" if self.parameters else "no parameters"
        if self.quantities:
            yield f"quantities {', '.join(self.quantities)}"

    def _drawing(self) -> str:
        """Return the first quantity over the first parameter, where both are numbers."""
        drawing = Drawing(equal=False)
        if self.parameters and self.quantities:
            members = (self.members[k] for k in range(min(len(self.members), DRAWN)))
            x, y = self.parameters[0], self.quantities[0]
            rows = [(m.values[x], m.quantities.get(y)) for m in members if m.completed]
            kept = [row for row in rows if all(isinstance(one, int | float) for one in row)]
            drawing.dots(np.array(kept, dtype=float).reshape(-1, 2))
        return drawing.svg()

    @property
    def parameters(self) -> tuple[str, ...]:
        """The keys that were varied."""
        return tuple(self.members.rows.columns)

    @property
    def completed(self) -> tuple[SweepRun, ...]:
        """The members that were computed to their end."""
        return tuple(member for member in self.members if member.completed)

    @property
    def count_completed(self) -> int:
        """How many members were computed to their end."""
        return self.members.found.outcomes().count(COMPLETED)

    @property
    def failed(self) -> tuple[SweepRun, ...]:
        """The other members."""
        return tuple(member for member in self.members if not member.completed)

    @cached_property
    def separate(self) -> str:
        """The reason why ``data`` holds no fields: differences between completed members; empty if they are stacked."""
        if not self.members.kept():
            return ""
        results = [member.result.data for member in self.completed if member.result is not None]
        return next((text for other in results[1:] if (text := _difference(results[0], other))), "")

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the numbers that were asked for, histories too."""
        found = self.members.found
        return (*found.quantities, *found.histories)

    def table(self) -> pd.DataFrame:
        """Return one row per member, failed ones too: values, quantities, cost and other figures, outcome, message.

        What a member does not have is missing (NaN, as in any table of pandas), and ``message`` says why. Histories are
        in ``data``.
        """
        import pandas as pd

        found = self.members.found
        columns: dict[str, Any] = dict(self.members.rows.columns)
        columns |= {name: column for name, column in found.quantities.items() if name not in found.histories}
        columns |= self._figures()
        columns["outcome"] = found.outcomes()
        told = found.told()
        columns["message"] = [told.get(k, "") for k in range(len(self.members))]
        return pd.DataFrame(columns, index=pd.RangeIndex(len(self.members), name="member"))

    def _figures(self) -> dict[str, Floats]:
        """Return the figures of all members in columns, in their order; NaN where a member has none."""
        columns = {name: column.copy() for name, column in self.members.found.measured.items()}
        if self.members.kept():
            for member in self.members:
                for name, value in member.figures().items() if not member.measured else ():
                    columns.setdefault(name, np.full(len(self.members), np.nan))[member.number] = value
        return {name: columns[name] for name in FIGURES if name in columns}

    @cached_property
    def data(self) -> xr.Dataset:
        """The completed members as one ``xarray.Dataset`` with a dimension ``member``.

        Coordinates along it are the number of the member and its values. There are the quantities that all of them
        have. Fields of the runs are stacked if they are kept and all members have the same stations and the same times
        (or load factors); otherwise, see ``separate``, only quantities, steps, wall time and numerical fraction are
        there, and fields are read from ``members``. Nothing is padded.
        """
        import xarray as xr

        kept, known = self.completed, self.members.found
        numbers = np.array([member.number for member in kept], dtype=np.int64)
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {"member": numbers}
        for name, column in self.members.rows.columns.items():
            coordinates[name] = ("member", _column([column[k] for k in numbers]))
        for name, values in self._figures().items():
            if kept and not np.isnan(values[numbers]).any():
                attributes = {"units": FIGURES[name].unit, "long_name": FIGURES[name].words}
                dtype = np.int64 if name == "steps" else np.float64
                variables[name] = ("member", values[numbers].astype(dtype), attributes)
        for name in self.quantities:
            if name not in known.histories:
                if not np.isnan(known.quantities[name][numbers]).any():
                    variables[name] = ("member", known.quantities[name][numbers], {"long_name": name})
                continue
            found = [member.quantities[name] for member in kept if name in member.quantities]
            if len(found) == len(kept):
                variables[name] = (("member", "instant"), np.array(found, dtype=float), {"long_name": name})
                coordinates["instant"] = np.linspace(0.0, 1.0, HISTORY_TIMES)
        if (
            kept
            and self.members.kept()
            and not self.separate
            and all(member.result is not None for member in kept)
        ):
            fields, axes = _stacked([member.result.data for member in kept if member.result is not None])
            variables = fields | variables
            coordinates |= axes
        return xr.Dataset(variables, coordinates, attrs={"kind": KIND, "title": self.title})

    def report(self) -> str:
        """Return a table of the members: values, quantities, figures, outcome; then what failed."""
        listed = self.members[:MOST_ROWS]
        figures = [member.figures() for member in listed]
        columns = shown(figures)
        numbers = [
            name
            for name in self.quantities
            if not any(isinstance(member.quantities.get(name), list) for member in listed)
        ]
        header = (
            "member",
            *self.parameters,
            *numbers,
            *(FIGURES[name].heading for name in columns),
            "outcome",
        )
        rows = [
            (
                str(member.number),
                *(_text(value) for value in member.values.values()),
                *(f"{member.quantities[name]:.6g}" if name in member.quantities else "-" for name in numbers),
                *(FIGURES[name].show(row[name]) if name in row else "-" for name in columns),
                member.outcome,
            )
            for member, row in zip(listed, figures, strict=True)
        ]
        count = f"{len(self.members)} members, {self.count_completed} completed"
        blocks = [table(f"{self.title}: {count}" if self.title else count, header, rows)]
        if len(self.members) > MOST_ROWS:
            blocks.append(f"These are the first {MOST_ROWS}; all are in the table")
        told = list(self.members.found.told().items())
        blocks += [f"member {number}: {message}" for number, message in told[:MOST_ROWS]]
        if len(told) > MOST_ROWS:
            blocks.append(f"and {len(told) - MOST_ROWS} more messages in the table")
        blocks += self.notes
        if self.separate:
            blocks.append(f"The members are kept apart: {self.separate}")
        return page(blocks)

    def __str__(self) -> str:
        return self.report()

    @checked
    def plot(
        self,
        path: str | Path | None = None,
        *,
        name: str | None = None,
        x: str | None = None,
        ax: Axes | None = None,
    ) -> Figure:
        """Draw numbers of the members over a parameter, a line for every combination of the others.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            name: of a number that is drawn alone: a quantity, or another column of ``table``.
            x: the parameter, by default the first.
            ax: axes of yours to draw into: one number, by default the first.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: there is no such number or parameter, or the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_sweep import draw_sweep

        return delivered(draw_sweep(self, name, x, ax), path)

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
                    "quantities": member.quantities,
                    "measured": member.measured,
                }
                for member in self.members
            ],
        }
        groups = {
            f"member_{member.number}": member.result.data
            for member in self.members
            if member.result is not None and (self.separate or not member.completed)
        }
        attrs = {"sweep": json.dumps(record, default=_plain), **self._attributes()}
        return write(self.data.assign_attrs(attrs), path, groups)

    def _attributes(self) -> dict[str, str]:
        """Return what a file says beside its members."""
        return {}

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
    quantities: dict[str, float | list[float]] = {}
    measured: dict[str, float] = {}


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
        own = [*FIGURES, *row.quantities, *row.values, "instant"]
        fields = data.drop_vars(own, errors="ignore")
        whole = _unstacked(fields, row.number) if stacked else read(path, group=f"member_{row.number}")
        whole.attrs = row.attrs
        result = result_of(whole, path)
    parts = (row.message, row.outcome, row.quantities, row.measured)
    return SweepRun(row.number, row.values, result, *parts)


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
    return data.sel(member=number, drop=True)


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
