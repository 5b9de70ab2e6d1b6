"""A sweep in a folder: what its members are, and a line for every one that is finished, on disk before it is reported.

``sweep.json`` has the values and the names of all members. Every thread that computes appends its finished members to a
file of its own in ``members``, one line of JSON each, so that nothing is shared and a process that is killed loses
the member that it was at and no other. Whole results, where they are kept, are netCDF files beside these.
"""

from __future__ import annotations

import json
import os
import socket
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError, reading
from viscorod.results.ensemble import Design, Ensemble
from viscorod.results.sweep_result import NOT_RUN, Sweep, SweepRun
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["MANIFEST", "SweepFolder"]

MANIFEST = "sweep.json"
DESIGN = "ensemble.json"
MEMBERS = "members"


@dataclass(frozen=True)
class SweepFolder:
    """The folder of a sweep."""

    path: Path

    def describe(self, design: str) -> None:
        """Say how the members of an ensemble were chosen, before any is computed.

        Raises:
            InputError: the folder cannot be written.
        """
        with replacing(self.path / DESIGN, needs=len(design), instead="name another folder") as new:
            new.write_text(design, encoding="utf-8")

    def begin(
        self, title: str, rows: Sequence[Mapping[str, Any]], names: Sequence[str], notes: Sequence[str]
    ) -> None:
        """Say what the members are, before any is computed.

        Raises:
            InputError: the folder cannot be written.
        """
        columns = {key: [row[key] for row in rows] for key in rows[0]}
        text = json.dumps(
            {"title": title, "notes": list(notes), "names": list(names), "values": columns}, default=plain
        )
        try:
            (self.path / MEMBERS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written ({error.strerror}); name another folder"
            ) from None
        with replacing(self.path / MANIFEST, needs=len(text), instead="name another folder") as new:
            new.write_text(text, encoding="utf-8")

    def add(self, name: str, found: Mapping[str, Any], result: AnyResult | None) -> Path | None:
        """Keep a finished member; returns the file of its result, if that is kept."""
        members = self.path / MEMBERS
        file = None if result is None else result.save(members / f"{name}.nc")
        line = json.dumps({"name": name, "file": file is not None, **found}, default=plain)
        own = f"{socket.gethostname()}-{os.getpid()}-{threading.get_native_id()}.jsonl"
        with (members / own).open("a", encoding="utf-8") as lines:
            lines.write(f"\n{line}\n")  # what was torn off before it stays a line of its own
        return file

    def finished(self) -> dict[str, dict[str, Any]]:
        """Return what was found of all members that are finished, by name; lines that were cut off do not count."""
        found: dict[str, dict[str, Any]] = {}
        for file in sorted((self.path / MEMBERS).glob("*.jsonl")):
            with file.open(encoding="utf-8", errors="replace") as lines:
                for line in lines:
                    if line.startswith("{") and line.endswith("}\n"):
                        try:
                            record = json.loads(line)
                        except ValueError:
                            continue
                        found[str(record.pop("name", ""))] = record
        return found

    def parts(self, name: str, record: Mapping[str, Any]) -> tuple[Any, ...]:
        """Return what was recorded of a member: file or None, message, outcome, quantities, figures.

        Raises:
            InputError: its record is damaged.
        """
        try:
            return (
                self.path / MEMBERS / f"{name}.nc" if record.get("file") else None,
                str(record["message"]),
                str(record["outcome"]),
                {str(key): _number(value) for key, value in record["quantities"].items()},
                {str(key): float(value) for key, value in record["measured"].items()},
            )
        except (KeyError, TypeError, ValueError, AttributeError):
            raise InputError(
                f"{self.path}: the record of a member is damaged; remove the files in {MEMBERS} and "
                "compute the sweep again"
            ) from None

    def load(self) -> Sweep:
        """Return the sweep, finished or not.

        Raises:
            InputError: the folder holds no sweep, or a damaged one.
        """
        path = self.path / MANIFEST
        with reading(path):
            try:
                about = json.loads(path.read_text(encoding="utf-8"))
                names, columns = about["names"], about["values"]
                rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
                if len(rows) != len(names):
                    raise ValueError("names and values differ in number")
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                raise InputError(
                    f"{path} is damaged ({error}); compute the sweep again in its folder"
                ) from None
        found = self.finished()
        members = [
            SweepRun(k, row, *(self.parts(name, found[name]) if name in found else (None, "", NOT_RUN)))
            for k, (row, name) in enumerate(zip(rows, names, strict=True))
        ]
        notes = [str(note) for note in about.get("notes", [])]
        sweep = Sweep(members, str(about.get("title", "")), notes)
        record = self.path / DESIGN
        if not record.is_file():
            return sweep
        design = Design.of_record(record.read_text(encoding="utf-8"), str(record))
        fits = design.members == len(members) and set(design.keys) <= set(columns)
        return Ensemble.of_sweep(sweep, design) if fits else sweep  # else another sweep used the folder later


def _number(value: Any) -> float | list[float]:
    return [float(x) for x in value] if isinstance(value, list) else float(value)


def plain(value: Any) -> Any:
    """Return numbers of NumPy as those of Python, anything else as text."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
