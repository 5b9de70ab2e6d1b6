"""Result of a sweep: its members, one data set over all of them, a table, the file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.alike import Alike
from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import Fault, InputError
from viscorod.results.alike_members import differing
from viscorod.results.files.storage import write
from viscorod.results.quantity_values import HISTORY_TIMES
from viscorod.results.stacked_members import along_members, stacked
from viscorod.results.sweep_figures import FIGURES, shown
from viscorod.results.sweep_members import NOT_RUN, SweepMembers, SweepRun
from viscorod.results.sweep_record import members_of, record_of
from viscorod.results.text_numbers import number, prefixed
from viscorod.results.text_table import page, table
from viscorod.results.told_members import told_members
from viscorod.results.values_in_si import in_si
from viscorod.shown import Shown, counted
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


KIND = "sweep"
DRAWN = 200
"""Members in a small drawing."""
MOST_ROWS, MOST_MESSAGES = 60, 20
"""Members and messages that a report lists; a table has all."""


class Sweep(WellNamed, Shown, Alike):
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

    def _content(self) -> Any:
        """Return what makes sweeps equal: what was asked for and found, but not how long it took."""
        members = [
            (one.values, one.message, one.outcome, one.quantities, one.result, numbers)
            for one in self.members
            for numbers in [{name: one.measured.get(name) for name in FIGURES if name != "wall_time_s"}]
        ]
        return {"title": self.title, "notes": self.notes, "members": members}

    def __hash__(self) -> int:
        return hash((type(self), self.title, len(self.members)))

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
    def pictured(self) -> np.ndarray:
        """Which members a picture over a parameter shows ``(members,)``."""
        return np.ones(len(self.members), dtype=bool)

    @property
    def count_completed(self) -> int:
        """How many members were computed to their end."""
        return int(self.members.found.completed().sum())

    @property
    def failed(self) -> tuple[SweepRun, ...]:
        """The other members."""
        return tuple(member for member in self.members if not member.completed)

    @cached_property
    def separate(self) -> str:
        """The reason why ``data`` holds no fields: differences between completed members; empty if they are stacked."""
        if not self.members.kept():
            return ""
        if self.members.stack is not None:
            return self.members.stack.separate
        return next(iter(differing(self.members).values()), "")

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the numbers that were asked for, histories too."""
        found = self.members.found
        return (*found.quantities, *found.histories)

    def table(self, *, as_given: bool = False) -> pd.DataFrame:
        """Return one row per member, failed ones too: values, quantities, cost and other figures, outcome, message.

        Values that were given with units, such as "3 mm", are numbers in SI there, so that they can be drawn and
        computed with; ``as_given`` leaves them texts. What a member does not have is missing (NaN, as in any table of
        pandas), and ``message`` says why. Histories are in ``data``.
        """
        import pandas as pd

        found = self.members.found
        given = self.members.rows.columns
        columns: dict[str, Any] = {
            key: column if as_given else in_si(column) for key, column in given.items()
        }
        columns |= {name: column for name, column in found.quantities.items() if name not in found.histories}
        columns |= self._figures()
        if "steps" in columns and np.isfinite(columns["steps"]).all():
            columns["steps"] = columns["steps"].astype(np.int64)
        columns["outcome"] = found.outcomes()
        told = found.told()
        columns["message"] = [told.get(k, "") for k in range(len(self.members))]
        return pd.DataFrame(columns, index=pd.RangeIndex(len(self.members), name="member"))

    def _figures(self) -> dict[str, Floats]:
        """Return the figures of all members in columns, in their order; NaN where a member has none."""
        columns = {name: column.copy() for name, column in self.members.found.measured.items()}
        known = np.zeros(len(self.members), dtype=bool)
        for column in columns.values():
            known |= np.isfinite(column)
        for k in self.members.found.with_results():
            for name, value in self.members[k].figures().items() if not known[k] else ():
                columns.setdefault(name, np.full(len(self.members), np.nan))[k] = value
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

        known = self.members.found
        numbers = np.flatnonzero(known.completed()).astype(np.int64)
        variables: dict[str, Any] = {}
        coordinates: dict[str, Any] = {"member": numbers}
        for name, column in self.members.rows.columns.items():
            values = along_members([column[k] for k in numbers])
            unit = self.members.rows.units.get(name) if values.dtype.kind in "if" else None
            coordinates[name] = ("member", values, {"units": unit} if unit else {})
        for name, values in self._figures().items():
            if len(numbers) and not np.isnan(values[numbers]).any():
                attributes = {"units": FIGURES[name].unit, "long_name": FIGURES[name].words}
                dtype = np.int64 if name == "steps" else np.float64
                variables[name] = ("member", values[numbers].astype(dtype), attributes)
        for name in self.quantities:
            unit = self.members.rows.units.get(name)
            attributes = {"long_name": name} | ({"units": unit} if unit else {})
            if name not in known.histories:
                if not np.isnan(known.quantities[name][numbers]).any():
                    variables[name] = ("member", known.quantities[name][numbers], attributes)
                continue
            found = [known.history(k, name) for k in numbers.tolist()]
            if all(history is not None for history in found):
                variables[name] = (("member", "instant"), np.array(found, dtype=float), attributes)
                coordinates["instant"] = np.linspace(0.0, 1.0, HISTORY_TIMES)
        if len(numbers) and self.members.kept() and not self.separate:
            if self.members.stack is not None:
                fields, axes = self.members.stack.parts()
            elif set(numbers.tolist()) <= set(known.with_results()):
                fields, axes = stacked([self.members.data(k) for k in numbers.tolist()])
            else:
                fields, axes = {}, {}
            variables = fields | variables
            coordinates |= axes
        return xr.Dataset(variables, coordinates, attrs={"kind": KIND, "title": self.title})

    def report(self) -> str:
        """Return a table of the members: values, quantities, figures, outcome; then what failed."""
        tried = [k for k, outcome in enumerate(self.members.found.outcomes()) if outcome != NOT_RUN]
        shown_rows = tried[:MOST_ROWS] or range(min(MOST_ROWS, len(self.members)))
        listed = [self.members[k] for k in shown_rows]
        figures = [member.figures() for member in listed]
        columns = shown(figures)
        numbers = {
            name: column
            for name, column in self.members.found.quantities.items()
            if name not in self.members.found.histories
        }
        heads = {
            name: prefixed(name, (some := column[list(shown_rows)])[np.isfinite(some)])
            for name, column in numbers.items()
        }
        header = (
            "member",
            *self.parameters,
            *(head for head, _ in heads.values()),
            *(FIGURES[name].heading for name in columns),
            "outcome",
        )
        rows = [
            (
                str(member.number),
                *(_text(value) for value in member.values.values()),
                *(_number(heads[name][1] * column[member.number]) for name, column in numbers.items()),
                *(FIGURES[name].show(row[name]) if name in row else "-" for name in columns),
                member.outcome,
            )
            for member, row in zip(listed, figures, strict=True)
        ]
        count = f"{len(self.members)} members, {self.count_completed} completed"
        blocks = [table(f"{self.title}: {count}" if self.title else count, header, rows)]
        if len(tried) > MOST_ROWS:
            blocks.append(f"These are the first {MOST_ROWS}; all are in the table")
        if tried and len(tried) < len(self.members):
            left = len(self.members) - len(tried)
            blocks.append(
                f"{left} members were not run and are not listed"
                if left > 1
                else "1 member was not run and is not listed"
            )
        blocks += told_members(self.members.found.told(), MOST_MESSAGES)
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
            x: the parameter, by default the first that varies.
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
    def save(self, path: str | Path, *, executor: Executor | None = None) -> Path:
        """Write one file, for ``viscorod.load`` and any tool of its kind; returns the path.

        By default it is a netCDF4 file. Its root is ``data``; results that are not in there (of members that failed or
        differ) are groups ``member_0``, ``member_1``, ... All of it passes through memory.

        A path that ends in ``.parquet`` becomes the table, without whole results; one that ends in ``.zarr`` a store of
        all whole results with the table in it, for large sweeps: it is written and read a block of members at a time.
        Both need ``pip install 'viscorod[store]'``.

        Args:
            path: of the file; its suffix gives the format.
            executor: one of ``concurrent.futures``, whose workers write the arrays of a store: each reads its members
                from the folder of the sweep, which all of them see, and writes them to pieces of their own.

        Raises:
            InputError: the place cannot be written, or a package is missing.
        """
        if executor is not None and not (Path(path).suffix == ".zarr" and hasattr(executor, "submit")):
            why = (
                "the executor that writes a store" if Path(path).suffix == ".zarr" else "only a store has one"
            )
            instead = "give one of concurrent.futures with a path that ends in .zarr, or none"
            raise InputError(Fault("executor", type(executor).__name__, why, instead))
        if Path(path).suffix == ".parquet":
            from viscorod.results.files.sweep_table import write_table

            return write_table(self, path)
        if Path(path).suffix == ".zarr":
            from viscorod.results.files.sweep_store import write_store

            return write_store(self, path, executor)
        groups = {
            f"member_{member.number}": member.result.data
            for member in self.members
            if member.result is not None and (self.separate or not member.completed)
        }
        attrs = {"sweep": record_of(self.members, self.notes), **self.attributes()}
        return write(self.data.assign_attrs(attrs), path, groups)

    def attributes(self) -> dict[str, str]:
        """Return what a file says beside its members."""
        return {}

    @classmethod
    def of(cls, data: xr.Dataset, path: Path) -> Sweep:
        """Return the sweep whose file is ``path`` and whose root is ``data``."""
        members, notes = members_of(data, path)
        return cls(members, str(data.attrs.get("title", "")), notes)


def _number(value: float) -> str:
    return "-" if np.isnan(value) else number(value)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
