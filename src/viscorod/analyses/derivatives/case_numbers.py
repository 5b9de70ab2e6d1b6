"""Numbers of a model by their keys, as in sweeps, and the model with another value of one of them."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from viscorod.analyses.derivatives.number_places import places_of
from viscorod.casefile.case_keys import keys_of, parts_of
from viscorod.casefile.case_reader import SECTION_KEYS, SETTINGS, TABLES, read_entry, read_part
from viscorod.casefile.list_entries import ENTRIES
from viscorod.errors import Fault, InputError
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import Definition, did_you_mean, plain_value, show, some_of
from viscorod.model.fields.metadata import units_of
from viscorod.model.rod import Rod

__all__ = ["CaseNumber", "with_values"]

M = TypeVar("M", bound=ModelDescription)


@dataclass(frozen=True)
class CaseNumber:
    """A number of a model.

    Attributes:
        key: as in a sweep, such as ``"materials.rubber.youngs_modulus"``.
        value: in SI units; unit: its symbol, empty where it is not known.
        size: of numbers of its kind, the value's own or that of the vector it stands in; 0 where all are zero.
    """

    key: str
    value: float
    unit: str
    size: float
    _with: Callable[[float], ModelDescription]

    @classmethod
    def of(cls, model: ModelDescription, key: str) -> CaseNumber:
        """Find a number; ``"a, b"`` are two that are equal and change together.

        Raises:
            InputError: there is no such number, or it is none of a model.
        """
        several = keys_of(key)
        if len(several) > 1:
            return cls._together(model, key, several)
        table, name, within = _place(key)
        if within[-1] == "mesh_size":
            why = "it says how a section is meshed, and meshes stay while numbers vary"
            raise InputError(Fault("derivatives", show(key), why, "name a number of its shape"))
        part = _part(model, key, table, name)
        content = _completed(part, part.to_dict(), within)
        places = places_of(content, within)
        within = places[0]
        value, size = _number(key, content, within, part)
        started = [_at(content, place) for place in places]

        def changed(other: float) -> ModelDescription:
            new = copy.deepcopy(content)
            for place, before in zip(places, started, strict=True):
                *way, last = place
                _at(new, way)[last] = other if before == value else before + (other - value)
            if isinstance(part, Rod) and within[0] not in SECTION_KEYS:
                _end_with_rod(part, name, new)
            return _with_part(model, table, name, part, new, within)

        return cls(key, value, _unit(part, within), size, changed)

    @classmethod
    def _together(cls, model: ModelDescription, key: str, several: Sequence[str]) -> CaseNumber:
        each = [cls.of(model, one) for one in several]
        different = [one for one in each if one.value != each[0].value]
        if different:
            shown = f"{each[0].value:g} and {different[0].value:g}"
            raise InputError(
                Fault(show(key), shown, "numbers that change together are equal", "name them one by one")
            )

        def changed(other: float) -> ModelDescription:
            found = model
            for one in several:
                found = cls.of(found, one)._with(other)
            return found

        return cls(key, each[0].value, each[0].unit, max(one.size for one in each), changed)

    def at(self, value: float) -> ModelDescription:
        """Return the model with another value.

        Raises:
            InputError: the value is refused.
        """
        found = self._with(value)
        found.validate()
        return found


def with_values(model: M, values: dict[str, float]) -> M:
    """Return the model with other numbers, by their keys.

    Raises:
        InputError: there is no such number, or a value is refused.
    """
    found: ModelDescription = model
    for key, value in values.items():
        found = CaseNumber.of(found, key).at(value)
    result: M = type(model).of(**found.parts())
    result.materials, result.sections = found.materials, found.sections
    return result


def _place(key: str) -> tuple[str, str | int, list[str | int]]:
    """Return the table, the part in it and the way within it to a number."""
    parts = parts_of(key)
    table, rest = parts[0], list(parts[1:])
    if isinstance(table, str) and table in SETTINGS:
        raise InputError(
            Fault("derivatives", show(key), "this is a setting of the analysis", "name a number of the model")
        )
    named = table in TABLES and len(rest) > 1 and isinstance(rest[0], str)
    listed = table in ENTRIES and len(rest) > 1 and isinstance(rest[0], int)
    if not isinstance(table, str) or not (named or listed):
        raise InputError(
            Fault(
                "derivatives",
                show(key),
                "this is not the key of a number",
                'write "materials.rubber.youngs_modulus", "rods.beam.section.width" or "loads[0].value[1]"',
            )
        )
    return table, rest[0], rest[1:]


def _part(model: ModelDescription, key: str, table: str, name: str | int) -> Definition:
    """Return the part of a model that a key begins with."""
    parts: Any = getattr(model, table)
    if isinstance(name, int):
        if name < len(parts):
            found: Definition = parts[name]
            return found
        advice = f"there are {len(parts)} {table}, the first is [0]"
    else:
        if name in parts:
            part: Definition = parts[name]
            return part
        advice = f"{did_you_mean(name, parts, str)}the names here are {some_of(parts)}"
        if table in ("materials", "sections") and not parts:
            advice = f'write "rods.NAME.{table[:-1]}..." for that of one rod, or name it: model.{table}[{name!r}] = ...'
    raise InputError(Fault("derivatives", show(key), "there is no such part", advice))


def _completed(part: Definition, content: dict[str, Any], within: list[str | int]) -> dict[str, Any]:
    """Return the content of a part with the default of the number that is wanted, where it is left out."""
    place: Any = content
    owner: Any = part
    for word in within:
        if isinstance(place, dict) and word not in place:
            value = getattr(owner, str(word), None)
            if value is not None and not callable(value):
                place[word] = plain_value(value)
        owner = _inside(owner, word)
        try:
            place = place[word]
        except (KeyError, IndexError, TypeError):
            break
    return content


def _inside(owner: Any, word: str | int) -> Any:
    """Return what a word or a number names in an object, None if nothing."""
    if isinstance(word, int):
        return owner[word] if isinstance(owner, list | tuple) and word < len(owner) else None
    if isinstance(owner, Rod) and word in ("sections", "taper"):
        inner = owner.section
        return getattr(inner, "pieces", None) if word == "sections" else inner
    if isinstance(owner, Rod) and not hasattr(owner, word):
        owner = owner.centreline
    return owner.get(word) if isinstance(owner, dict) else getattr(owner, word, None)


def _at(content: Any, way: Sequence[str | int]) -> Any:
    """Return what stands at the end of a way; None if it leads nowhere."""
    place = content
    for word in way:
        try:
            place = place[word]
        except (KeyError, IndexError, TypeError):
            return None
    return place


def _end_with_rod(rod: Rod, name: str | int, content: dict[str, Any]) -> None:
    """Let the last piece or station of the sections of a rod end where one with this ``content`` does."""
    given = content.get("sections")
    listed, word = (given, "until") if isinstance(given, list) else ((given or {}).get("stations"), "at")
    if listed:
        plain = {key: value for key, value in content.items() if key != "sections"}
        other: Rod = read_part("rods", str(name), plain | {"section": listed[-1]["section"]})
        if other.length != rod.length:
            listed[-1] = listed[-1] | {word: other.length}


def _number(
    key: str, content: dict[str, Any], within: list[str | int], part: Definition
) -> tuple[float, float]:
    """Return the number that a key ends at, and the size of numbers of its kind."""
    place: Any = content
    owner: Any = part
    around: list[Any] = []
    for word in within:
        around = place if isinstance(place, list) else [place]
        try:
            place = place[word]
        except (KeyError, IndexError, TypeError):
            words = _words(place, owner)
            if word in words:
                why = "it has no value here, and is not a number of this model"
                raise InputError(Fault("derivatives", show(key), why, "give it one in the model")) from None
            known = some_of(words) if words else show(place)
            hint = did_you_mean(word, words, str) if words else ""
            raise InputError(
                Fault("derivatives", show(key), "there is no such number", f"{hint}here are {known}")
            ) from None
        owner = _inside(owner, word)
    if isinstance(place, str) and "function" in place:
        why = "a Python function stands here, whose numbers have no keys"
        raise InputError(Fault("derivatives", show(key), why, "give it by numbers"))
    if isinstance(place, int) and not isinstance(place, bool):
        why = "this is a whole number, which nothing has a derivative by"
        raise InputError(Fault("derivatives", show(key), why, "name a number that may vary a little"))
    if not isinstance(place, float):
        raise InputError(Fault("derivatives", show(key), f"this is {show(place)}", "name a number"))
    beside = [abs(x) for x in around if isinstance(x, int | float)] if len(around) > 1 else []
    return float(place), max([abs(float(place)), *beside])


def _words(place: Any, owner: Any) -> list[str]:
    """Return the words that may follow in a key: what is given, and what has a default."""
    if not isinstance(place, dict):
        return []
    fields = list(type(owner).model_fields) if isinstance(owner, Definition) else []
    return list(dict.fromkeys([*map(str, place), *fields]))


def _with_part(
    model: ModelDescription,
    table: str,
    name: str | int,
    part: Definition,
    content: dict[str, Any],
    within: list[str | int],
) -> ModelDescription:
    """Return the model with another content of one of its parts."""
    parts = model.parts()
    materials, sections = dict(model.materials), dict(model.sections)
    if isinstance(name, int):
        new: Any = read_entry(table, name, content)
        parts[table] = [new if k == name else other for k, other in enumerate(parts[table])]
    elif table in ("materials", "sections"):
        new = read_part(table, name, content)
        (materials if table == "materials" else sections)[name] = new
        parts["rods"] = {key: _with_inner(key, rod, table, part, new) for key, rod in model.rods.items()}
    elif table == "rods" and within[0] in ("material", "section") and isinstance(part, Rod):
        inner = getattr(part, str(within[0]))  # whatever else describes the rod, functions too, stays
        if isinstance(inner, Definition) and "regions" not in content.get("section", {}):
            new = read_part(f"{within[0]}s", name, content[within[0]])
            parts["rods"] = parts["rods"] | {name: _renewed(part, str(within[0]), new)}
        else:
            parts["rods"] = parts["rods"] | {name: read_part(table, name, content)}
    else:
        parts[table] = parts[table] | {name: read_part(table, name, content)}
    found = type(model).of(**parts)
    found.materials, found.sections = materials, sections
    return found


def _with_inner(name: str, rod: Rod, table: str, old: Definition, new: Definition) -> Rod:
    """Return a rod with another material or section wherever it has the old one."""
    field = table[:-1]
    if getattr(rod, field) == old:
        return _renewed(rod, field, new)
    content = rod.to_dict()
    swapped = _swapped(content, old.to_dict(), new.to_dict())
    if swapped == content:
        return rod
    found: Rod = read_part("rods", name, swapped)
    return found


def _renewed(rod: Rod, field: str, new: Definition) -> Rod:
    """Return a rod with another material or section; what it has computed of its section is forgotten."""
    found = rod.model_copy(update={field: new})
    for computed in ("kinks", "_turning"):
        found.__dict__.pop(computed, None)
    return found


def _swapped(value: Any, old: dict[str, Any], new: dict[str, Any]) -> Any:
    """Return plain data with one table in the place of another that is equal to it."""
    if isinstance(value, dict):
        return new if value == old else {key: _swapped(item, old, new) for key, item in value.items()}
    return [_swapped(item, old, new) for item in value] if isinstance(value, list) else value


def _unit(part: Definition, within: list[str | int]) -> str:
    """Return the SI unit of a number, empty if it is not known."""
    owner: Any = part
    unit = ""
    for word in within:
        if isinstance(owner, Rod) and isinstance(word, str) and word not in type(owner).model_fields:
            owner = owner.centreline if word not in ("sections", "taper") else owner
        if isinstance(owner, Definition) and word in type(owner).model_fields:
            units = units_of(type(owner).model_fields[str(word)])
            unit = units[0] if len(units) == 1 else ""
        owner = _inside(owner, word)
    return "" if "*" in unit else unit
