"""Files that say what is identified: cases, records, parameters, and how."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from viscorod.casefile.case import Case, case_from_dict, load_case
from viscorod.casefile.case_keys import put
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import did_you_mean, show
from viscorod.records.record_table import record_of

__all__ = ["FitFile", "load_fit"]

OPTIONS: dict[str, tuple[type, str]] = {
    "starts": (int, "a whole number"),
    "robust": (bool, "true or false"),
    "coloured": (bool, "true or false"),
    "level": (float, "a number"),
    "profile": (bool, "true or false"),
    "seed": (int, "a whole number"),
    "draws": (int, "a whole number"),
    "laws": (list, "a list of texts"),
}
"""Keys that are arguments of `identify`, and what they are."""
KEYS = ("title", "case", "records", "parameters", "nuisances", *OPTIONS)
OWN = ("case", "set", "left_out")
"""Keys of a record's table that are not the record's."""


@dataclass(frozen=True)
class FitFile:
    """What a file says of an identification: pairs of cases and records, and the arguments of `identify`."""

    title: str
    pairs: list[tuple[Case, Any]]
    left_out: list[tuple[Case, Any]]
    parameters: Mapping[str, Any]
    nuisances: Mapping[str, Any]
    options: dict[str, Any] = field(default_factory=dict)


def load_fit(path: Path) -> FitFile:
    """Read a file of an identification; paths in it are taken from its folder on.

    Raises:
        InputError: it cannot be read, or something in it is wrong; all faults at once.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except FileNotFoundError:
        raise InputError(
            Fault("file", str(path), "there is no such file", "give the path of a fit file")
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(
            Fault("file", str(path), f"it cannot be read ({error})", "give a TOML file")
        ) from None
    if {"rods", "bodies", "materials"} & set(content) and "records" not in content:
        needed = f'case = "{path.name}", [parameters] and [[records]]'
        raise InputError(
            f"{path} is a case file; what is identified stands in a file of its own, with {needed}"
        )
    return _Reader(content, path).read()


class _Reader:
    def __init__(self, content: Mapping[str, Any], path: Path) -> None:
        self._content, self._path = content, path
        self._faults: list[Fault] = []
        self._cases: dict[str, Case] = {}

    def read(self) -> FitFile:
        for key in self._content:
            if key not in KEYS:
                hint = did_you_mean(key, KEYS, str)
                self._wrong(
                    key,
                    "",
                    "no such key",
                    f"{hint}{'The' if hint else 'the'} keys here are {', '.join(KEYS)}",
                )
        options = {key: self._option(key) for key in OPTIONS if key in self._content}
        pairs, left_out = self._records()
        parameters, nuisances = self._table("parameters"), self._table("nuisances")
        title = self._content.get("title", self._path.stem)
        if self._faults:
            raise InputError(self._faults, heading=str(self._path))
        return FitFile(str(title), pairs, left_out, parameters, nuisances, options)

    def _wrong(self, where: str, found: str, why: str, instead: str) -> None:
        self._faults.append(Fault(where, found, why, instead))

    def _option(self, key: str) -> Any:
        value, (kind, words) = self._content[key], OPTIONS[key]
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if not isinstance(value, kind) or (kind is int and isinstance(value, bool)):
            self._wrong(key, show(value), f"{words} is needed here", "see the page on identification")
        return value

    def _table(self, name: str) -> Mapping[str, Any]:
        value = self._content.get(name, {})
        if isinstance(value, list):
            value = dict.fromkeys(map(str, value))
        if not isinstance(value, Mapping):
            self._wrong(
                name,
                show(value),
                "keys with their starts are needed",
                f'write [{name}] "KEY" = [low, start, high]',
            )
            return {}
        return value

    def _records(self) -> tuple[list[tuple[Case, Any]], list[tuple[Case, Any]]]:
        tables = self._content.get("records", [])
        if not isinstance(tables, list) or not tables:
            self._wrong("records", show(tables), "at least one is needed", "write [[records]] with its keys")
            return [], []
        pairs: list[tuple[Case, Any]] = []
        left_out: list[tuple[Case, Any]] = []
        for number, table in enumerate(tables):
            where = f"records[{number}]"
            if not isinstance(table, Mapping):
                self._wrong(where, show(table), "a table is needed here", "write [[records]] with its keys")
                continue
            try:
                case = self._case(table)
                record = record_of({k: v for k, v in table.items() if k not in OWN}, self._path.parent)
            except InputError as error:
                self._faults += [problem.within(where) for problem in error.problems]
                continue
            (left_out if table.get("left_out") else pairs).append((case, record))
        return pairs, left_out

    def _case(self, table: Mapping[str, Any]) -> Case:
        """Return the case of a record; records of one case with the same changes share it."""
        name = table.get("case", self._content.get("case"))
        if not isinstance(name, str):
            raise InputError(
                Fault("case", show(name), "the path of a case file is needed", 'write case = "bar.toml"')
            )
        changes = table.get("set", {})
        key = f"{name} {sorted(changes.items()) if isinstance(changes, Mapping) else changes}"
        if key not in self._cases:
            case = load_case(self._path.parent / name)
            if changes:
                if not isinstance(changes, Mapping):
                    raise InputError(Fault("set", show(changes), "keys with values are needed", "see sweeps"))
                content = copy.deepcopy(dict(case.content))
                for one, value in changes.items():
                    put(content, one, value)
                case = case_from_dict({"title": case.title, **content}, case.source)
            self._cases[key] = case
        return self._cases[key]
