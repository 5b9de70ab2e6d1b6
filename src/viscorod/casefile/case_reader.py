"""Read a case file: its tables, turned into a model and the settings of one analysis.

The words are those of the Python API. Everything that is wrong is collected and reported in one message.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from viscorod.casefile.analysis_tables import ANALYSES, analyses_in_words
from viscorod.casefile.known_parts import KnownParts
from viscorod.casefile.list_entries import ENTRIES
from viscorod.errors import Fault, InputError, join_path
from viscorod.model.bodies.body import one_body
from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import (
    FaultyValue,
    did_you_mean,
    path_text,
    problems_of,
    show,
    some_of,
)
from viscorod.model.fields.values import choose, name_of_part
from viscorod.model.materials.material import Material
from viscorod.model.rod import CENTRELINES, Rod
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_kinds import one_section
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.section_stations import Stations
from viscorod.model.sections.taper import Taper
from viscorod.solve.settings.analysis import AnySettings
from viscorod.wording import nearest_key

__all__ = ["CaseReader"]

T = TypeVar("T")

TABLES = ("materials", "sections", "rods", "bodies")
LISTS = ("supports", "loads", "attachments", "joints", "springs", "velocities", "strains", "rest_strains")
KEYS = ("title", *TABLES, *LISTS, *ANALYSES)

SETTINGS = tuple(ANALYSES)
"""Tables of settings."""
SECTION_KEYS = ("section", "sections", "taper")
PLAIN_KEYS = ("elements", "order", "d1", "twist", "constraints", "law", "tilt", "curvature_correction")
ROD_KEYS = (*SECTION_KEYS, "material", *PLAIN_KEYS)


class CaseReader:
    """Reads the content of one case file; `problems` collects what is wrong with it.

    Args:
        data: the content, in SI.
        known: parts of a case that was read before; those that are the same are taken from there.

    After `read`, and if `problems` is empty, `title`, `model` and `settings` hold what the file describes.
    """

    def __init__(self, data: Mapping[str, Any], known: KnownParts | None = None) -> None:
        self.data, self._known = data, known
        self.problems: list[Fault] = []
        self.title: str | None = None
        self.model = ModelDescription()
        self.settings: AnySettings | None = None
        self._meant: list[str] = []
        self._materials: dict[str, Any] = {}
        self._sections: dict[str, Any] = {}

    def read(self, *, whole: bool = True) -> None:
        """Read everything; the model as a whole, if it is one, is checked if its parts are right."""
        self._meant = self._unknown(self.data, KEYS, "")
        title = self.data.get("title")
        if title is None or isinstance(title, str):
            self.title = title
        else:
            self._wrong("title", show(title), "a title is text", "give it in quotes")
        for name, table in self._tables("materials"):
            self._materials[name] = self._named(f"materials.{name}", Material.model_validate, table)
        for name, table in self._tables("sections"):
            self._sections[name] = self._named(f"sections.{name}", one_section, self._materials_inside(table))
        known = {name: part for name, part in self._materials.items() if isinstance(part, Material)}
        self.model.materials.update(known)
        self.model.sections.update({k: s for k, s in self._sections.items() if isinstance(s, AnySection)})
        if not {"rods", "bodies"} & {*self.data, *self._meant}:
            self._wrong(
                "rods", "", "a case needs a rod or a body", "add a table [rods.NAME] or [bodies.NAME]"
            )
        for name, table in self._tables("rods"):
            self._rod(name, table)
        for name, table in self._tables("bodies"):
            body = self._parsed(f"bodies.{name}", one_body, table)
            if isinstance(body, AnyBody):
                self._add(name, body)
        for key, parse in ENTRIES.items():
            setattr(self.model, key, self._list(key, parse))
        self._analysis()
        if whole and not self.problems:
            try:
                self.model.validate()
            except InputError as error:
                self.problems += error.problems

    def _wrong(self, where: str, found: str, why: str, instead: str) -> None:
        self.problems.append(Fault(where, found, why, instead))

    def _parsed(self, path: str, parse: Callable[[Any], T], value: Any) -> T | None:
        """Parse `value`; None, with the problems noted, if it is refused."""
        found: T | None = None if self._known is None else self._known.find(path, parse, value)
        if found is not None:
            return found
        try:
            found = parse(value)
            if self._known is not None:
                self._known.keep(path, parse, value, found)
            return found
        except (ValidationError, InputError) as error:
            self.problems += [problem.within(path) for problem in problems_of(error, value)]
            return None

    def _named(self, path: str, parse: Callable[[Any], Any], value: Any) -> Any:
        """Parse `value` as `_parsed` does, with a mark for what was refused: its uses are not reported again."""
        parsed = self._parsed(path, parse, value)
        return FaultyValue(value, reported=True) if parsed is None else parsed

    def _unknown(self, table: Mapping[str, Any], allowed: tuple[str, ...], path: str) -> list[str]:
        """Report the keys that are not allowed; the ones that they were probably meant to be."""
        meant = []
        for key in table:
            if key not in allowed:
                close = nearest_key(key, allowed, table)
                hint = f"did you mean {close}? " if close else ""
                advice = f"{hint}{'The' if hint else 'the'} keys here are {', '.join(allowed)}"
                self._wrong(join_path(path, path_text((key,))), show(table[key]), "no such key", advice)
                meant += [close] if close else []
        return meant

    def _tables(self, key: str) -> list[tuple[str, Any]]:
        """Return the named tables under `key`."""
        tables = self.data.get(key, {})
        if not isinstance(tables, Mapping):
            self._wrong(key, show(tables), "named tables are needed here", f"write them as [{key}.NAME]")
            return []
        return [(name, table) for name, table in tables.items() if self._name(key, name)]

    def _name(self, key: str, name: str) -> bool:
        return self._parsed(path_text((key, name)), name_of_part, name) is not None

    def _list(self, key: str, parse: Callable[[Any], Any]) -> list[Any]:
        items = self.data.get(key, [])
        if not isinstance(items, list):
            self._wrong(
                key, show(items), "a list of tables is needed here", f"write each of them as [[{key}]]"
            )
            return []
        parsed = [self._parsed(f"{key}[{index}]", parse, item) for index, item in enumerate(items)]
        return [item for item in parsed if item is not None]

    def _analysis(self) -> None:
        given = [key for key in ANALYSES if key in self.data]
        misspelt = not given and any(key in ANALYSES for key in self._meant)
        if len(given) != 1 and not misspelt:
            self._wrong(
                given[0] if given else "simulate",
                f"the tables {' and '.join(given)}" if given else "",
                "a case asks for exactly one analysis",
                f"give one table: {analyses_in_words()}",
            )
        for key in given:
            parsed = self._parsed(key, ANALYSES[key].model_validate, self.data[key])
            if isinstance(parsed, AnySettings):
                self.settings = parsed

    def _lookup(self, value: Any, named: Mapping[str, Any], noun: str) -> Any:
        """Return `value`, or what it names if it is a text."""
        if not isinstance(value, str):
            return value
        if value in named:
            return named[value]
        if f"{noun}s" in self._meant:
            return FaultyValue(value, reported=True)
        hint = did_you_mean(value, named)
        known = (
            f"the {noun}s of this file are {some_of(named)}"
            if named
            else f"add a table [{noun}s.{value[:30]}]"
        )
        return FaultyValue(value, f"there is no {noun} of this name", hint + known)

    def _rod(self, name: str, table: Any) -> None:
        path = f"rods.{name}"
        if not isinstance(table, Mapping):
            self._wrong(
                path, show(table), "a table of keys and values is needed here", f"write it as [{path}]"
            )
            return
        shape = table.get("shape")
        kind = CENTRELINES.get(shape) if isinstance(shape, str) else None
        own = tuple(kind.model_fields) if kind else tuple(table)
        meant = self._unknown(table, (*own, *ROD_KEYS), path) if kind else []
        curve: dict[str, Any] = {key: FaultyValue(None, reported=True) for key in meant if key in own}
        curve |= {key: value for key, value in table.items() if key in own and key not in ROD_KEYS}
        given: dict[str, Any] = {key: table[key] for key in PLAIN_KEYS if key in table}
        given["centreline"] = self._named(path, _CENTRELINE, curve)
        given["section"] = self._section(path, table, meant)
        if "material" in table:
            material = self._lookup(table["material"], self._materials, "material")
            given["material"] = self._named(f"{path}.material", _as_material, material)
        elif "material" in meant:
            return
        before = len(self.problems)
        rod = self._parsed(path, Rod.model_validate, given)
        for index in range(before, len(self.problems)):
            self.problems[index] = _in_file_words(self.problems[index], path)
        if rod is not None:
            self._add(name, rod)

    def _add(self, name: str, part: Rod | AnyBody) -> None:
        try:
            self.model.add(name, part)
        except InputError as error:
            self.problems += error.problems

    def _section(self, path: str, table: Mapping[str, Any], meant: list[str]) -> Any:
        """Read the section, pieces or taper of a rod's table."""
        given = [key for key in SECTION_KEYS if key in table]
        if len(given) != 1:
            if given or not set(meant) & set(SECTION_KEYS):
                self._wrong(
                    f"{path}.{given[1] if given else 'section'}",
                    f"{' and '.join(given)}" if given else "",
                    "a rod has one description of its section"
                    if given
                    else "this key is required and missing",
                    "give one of section, sections (pieces with until, or stations) and taper (start and end)",
                )
            return FaultyValue(None, reported=True)
        value = table[given[0]]
        if given[0] == "section":
            return self._named(f"{path}.section", one_section, self._section_named(value))
        if given[0] == "taper":
            return self._named(
                f"{path}.taper", Taper.model_validate, self._sections_inside(value, ("start", "end"))
            )
        if isinstance(value, Mapping):
            return self._named(f"{path}.sections", Stations.model_validate, self._stations_inside(value))
        if not isinstance(value, list):
            self._wrong(
                f"{path}.sections",
                show(value),
                "a list of pieces, or a table of stations, is needed here",
                'give [{until = .., section = ..}], or { file = "blade.csv" }',
            )
            return FaultyValue(None, reported=True)
        pieces = [self._sections_inside(item, ("section",)) for item in value]
        parsed = self._named(f"{path}.sections", _piecewise, pieces)
        self.problems = [
            Fault(p.where.replace(f"{path}.sections.pieces", f"{path}.sections"), p.found, p.why, p.instead)
            for p in self.problems
        ]
        return parsed

    def _stations_inside(self, table: Mapping[str, Any]) -> Mapping[str, Any]:
        stations = table.get("stations")
        if not isinstance(stations, list):
            return table
        return {**table, "stations": [self._sections_inside(item, ("section",)) for item in stations]}

    def _section_named(self, value: Any) -> Any:
        return self._materials_inside(self._lookup(value, self._sections, "section"))

    def _materials_inside(self, section: Any) -> Any:
        """Put materials and sections in the place of their names in a composite section's table."""
        regions = section.get("regions") if isinstance(section, Mapping) else None
        if not isinstance(regions, list):
            return section
        named = {"material": (self._materials, "material"), "section": (self._sections, "section")}
        found = [
            {
                key: self._lookup(value, *named[key]) if key in named else value
                for key, value in region.items()
            }
            if isinstance(region, Mapping)
            else region
            for region in regions
        ]
        return {**section, "regions": found}

    def _sections_inside(self, value: Any, keys: tuple[str, ...]) -> Any:
        if not isinstance(value, Mapping):
            return value
        return {key: self._section_named(item) if key in keys else item for key, item in value.items()}


def read_part(table: str, name: str, content: Any) -> Any:
    """Return a rod, body, material or section from its table in a case file.

    Args:
        table: "rods", "bodies", "materials" or "sections"; name: of the part; content: of its table.

    Raises:
        InputError: it is refused.
    """
    reader = CaseReader({})
    if table == "rods":
        reader._rod(name, content)
        part: Any = reader.model.rods.get(name)
    else:
        parts: dict[str, Callable[[Any], Any]] = {
            "bodies": one_body,
            "materials": Material.model_validate,
            "sections": one_section,
        }
        parse = parts[table]
        part = reader._parsed(f"{table}.{name}", parse, content)
    if reader.problems:
        raise InputError(reader.problems)
    return part


def read_entry(table: str, index: int, content: Any) -> Any:
    """Return an entry of a list of a case file, such as ``[[loads]]``.

    Raises:
        InputError: it is refused.
    """
    reader = CaseReader({})
    found = reader._parsed(f"{table}[{index}]", ENTRIES[table], content)
    if reader.problems:
        raise InputError(reader.problems)
    return found


_CENTRELINE = choose("shape", CENTRELINES)


def _piecewise(pieces: Any) -> Piecewise:
    return Piecewise.model_validate({"pieces": pieces})


def _as_material(value: Any) -> Material:
    return value if isinstance(value, Material) else Material.model_validate(value)


def _in_file_words(problem: Fault, path: str) -> Fault:
    """Put the paths of the finished rod, with its pieces and centre line, in those of the file."""
    where = problem.where
    for inside, outside in (
        (".section.pieces", ".sections"),
        (".section.stations", ".sections.stations"),
        (".section.file", ".sections.file"),
        (".centreline", ""),
    ):
        where = where.replace(path + inside, path + outside)
    return Fault(where, problem.found, problem.why, problem.instead)
