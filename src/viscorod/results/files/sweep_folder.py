"""A sweep in a folder: what its members are, and a line for every one that is finished, on disk before it is reported.

``sweep.json`` has the values and the names of all members. Every thread that computes appends its finished members to a
file of its own in ``members``, one line of JSON each with a checksum, so that nothing is shared and a process that is
killed loses the member that it was at and no other. Whole results, where they are kept, are appended to a second file
of the same thread before their lines are (see ``packed_results``).
"""

from __future__ import annotations

import json
import os
import re
import secrets
import socket
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zlib import crc32

import numpy as np

from viscorod.errors import InputError, reading
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.files.packed_results import PackedResult, append
from viscorod.results.sweep_members import Found, FoundMembers, Rows, SweepMembers
from viscorod.results.sweep_result import Sweep
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from viscorod.results.any_result import AnyResult

__all__ = ["MANIFEST", "SweepFolder"]

MANIFEST = "sweep.json"
DESIGN = "ensemble.json"
MEMBERS = "members"
RESULTS = ".results"
_SUM = re.compile(r', "sum": (\d+)}\n$')


@dataclass(frozen=True)
class SweepFolder:
    """The folder of a sweep.

    Attributes:
        path: where it is.
        design: how the members of an ensemble are chosen; empty of other sweeps.
    """

    path: Path
    design: str = ""

    def begin(
        self, title: str, rows: Rows, names: Sequence[str], notes: Sequence[str], numbers: Sequence[str]
    ) -> None:
        """Say what the members are, before any is computed.

        Args:
            title, rows: of the sweep; names: of its members; notes: choices that were made.
            numbers: names of the quantities that are numbers.

        Raises:
            InputError: the folder cannot be written.
        """
        text = json.dumps(
            {
                "title": title,
                "notes": list(notes),
                "names": list(names),
                "values": rows.columns,
                "units": rows.units,
                "quantities": list(numbers),
            },
            default=plain,
        )
        try:
            (self.path / MEMBERS).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(
                f"{self.path} cannot be written ({error.strerror}); name another folder"
            ) from None
        for name, content in ((DESIGN, self.design), (MANIFEST, text)):
            if content:
                with replacing(self.path / name, needs=len(content), instead="name another folder") as new:
                    new.write_text(content, encoding="utf-8")

    def add(self, name: str, found: Mapping[str, Any], result: AnyResult | None) -> PackedResult | None:
        """Keep a finished member; returns where its result lies, if that is kept.

        Raises:
            OSError: it cannot be written.
        """
        members = self.path / MEMBERS
        own = _writer_name()
        stored = None if result is None else append(members / f"{own}{RESULTS}", result.data)
        place = None if stored is None else (stored.path.name, stored.offset, stored.length, stored.layout)
        text = json.dumps({"name": name, "result": place, **found}, default=plain)
        line = f'{text[:-1]}, "sum": {crc32(text.encode())}}}'
        with (members / f"{own}.jsonl").open("a", encoding="utf-8") as lines:
            lines.write(f"\n{line}\n")  # what was torn off before it stays a line of its own
        return stored

    def take(self, names: Sequence[str], found: FoundMembers) -> None:
        """Take what was found of the members with these names.

        Lines that were cut off or changed do not count, and lines of results that are not there. Of a member that was
        tried again the line counts in which it is completed, else that in the file that was written last.

        Raises:
            InputError: the record of one is damaged.
        """
        places: dict[str, int | list[int]] = {}
        for number, name in enumerate(names):
            if name in places:  # members with the same values
                before = places[name]
                places[name] = [*(before if isinstance(before, list) else [before]), number]
            else:
                places[name] = number
        for name, record in self._finished():
            place = places.get(name, []) if name else []
            if place == []:
                continue
            parts = self._parts(name, record)
            if isinstance(parts[0], PackedResult) and not parts[0].there:
                continue
            for number in place if isinstance(place, list) else [place]:
                if not found.is_completed(number):
                    found[number] = parts

    def _finished(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield names and records of all members that are finished."""
        for file in sorted((self.path / MEMBERS).glob("*.jsonl"), key=_written):
            with file.open(encoding="utf-8", errors="replace") as lines:
                for line in lines:
                    if line.startswith("{") and line.endswith("}\n"):
                        whole = _SUM.search(line)  # first versions had none
                        if whole and crc32(f"{line[: whole.start()]}}}".encode()) != int(whole[1]):
                            continue
                        try:
                            record = json.loads(line)
                        except ValueError:
                            continue
                        yield str(record.pop("name", "")), record

    def _parts(self, name: str, record: Mapping[str, Any]) -> Found:
        """Return what was recorded of a member.

        Raises:
            InputError: its record is damaged.
        """
        try:
            return (
                self._stored(name, record),
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

    def _stored(self, name: str, record: Mapping[str, Any]) -> PackedResult | Path | None:
        """Return where the result of a member is, if it is kept."""
        if record.get("file"):  # as the first versions kept it
            return self.path / MEMBERS / f"{name}.nc"
        if not record.get("result"):
            return None
        file, offset, length, *layout = record["result"]  # first versions did not keep the layout
        path = _writer(self.path, str(file))
        return PackedResult(path, int(offset), int(length), sys.intern("".join(map(str, layout))))

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
                if {len(column) for column in columns.values()} != {len(names)}:
                    raise ValueError("names and values differ in number")
            except (KeyError, TypeError, ValueError, AttributeError) as error:
                raise InputError(
                    f"{path} is damaged ({error}); compute the sweep again in its folder"
                ) from None
        found = FoundMembers(len(names), map(str, about.get("quantities", [])))
        self.take(names, found)
        members = SweepMembers(Rows(columns, len(names), about.get("units")), found)
        notes = [str(note) for note in about.get("notes", [])]
        sweep = Sweep(members, str(about.get("title", "")), notes)
        record = self.path / DESIGN
        if not record.is_file():
            return sweep
        design = Design.of_record(record.read_text(encoding="utf-8"), str(record))
        fits = design.members == len(members) and set(design.keys) <= set(columns)
        return Ensemble.of_sweep(sweep, design) if fits else sweep  # else another sweep used the folder later


_own = threading.local()


def _writer_name() -> str:
    """Return the name of this thread's files: machine, process, thread, and chance, as containers may share these."""
    if getattr(_own, "process", None) != os.getpid():  # a copy of another process has files of its own
        _own.process = os.getpid()
        place = f"{socket.gethostname()}-{os.getpid()}-{threading.get_native_id()}"
        _own.name = f"{place}-{secrets.token_hex(4)}"
    name: str = _own.name
    return name


@lru_cache(maxsize=1024)
def _writer(folder: Path, name: str) -> Path:
    """Return the file of whole results of a writer, which all of its members share."""
    return folder / MEMBERS / Path(name).name


def _written(path: Path) -> tuple[float, str]:
    """Return when a file was written last, and its name."""
    try:
        return path.stat().st_mtime, path.name
    except OSError:  # it was removed meanwhile; to open it tells
        return 0.0, path.name


def _number(value: Any) -> float | list[float]:
    return [float(x) for x in value] if isinstance(value, list) else float(value)


def plain(value: Any) -> Any:
    """Return numbers of NumPy as those of Python, anything else as text."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)
