"""Cases: a model with the settings of one analysis, from a TOML file."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from viscorod.casefile.analysis_tables import ANALYSES
from viscorod.casefile.case_reader import CaseReader
from viscorod.casefile.known_parts import KnownParts
from viscorod.casefile.shipped import shipped_cases
from viscorod.casefile.sizes import size_problems, too_deep
from viscorod.casefile.unit_conversion import converted
from viscorod.checks import checked
from viscorod.errors import Fault, InputError, last_warnings
from viscorod.limits import DEEPEST_NESTING, LARGEST_CASE
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.quantities import has_quantity
from viscorod.solve.settings.analysis import AnySettings
from viscorod.units import Conversion
from viscorod.wording import nearest

__all__ = ["Case", "case_from_dict", "is_plain", "load_case", "parse_case"]

M = TypeVar("M", bound=ModelDescription)


@dataclass(frozen=True)
class Case:
    """The content of a case file.

    Attributes:
        title: of the case, by default the file's name.
        description: the model.
        settings: of the analysis that is asked for.
        source: the file, if there is one.
        content: the keys and values it was read from, quantities as they were given.
        text: of the file.
        conversions: quantities such as "10 mm" and what they are in SI.
        changes: keys that were given other values than in the text, and these, as JSON; empty if none were.
    """

    title: str
    description: ModelDescription
    settings: AnySettings
    source: Path | None = None
    content: Mapping[str, Any] = field(default_factory=dict, compare=False, repr=False)
    text: str = field(default="", compare=False, repr=False)
    conversions: tuple[Conversion, ...] = field(default=(), compare=False, repr=False)
    changes: str = field(default="", compare=False, repr=False)

    @property
    def kind(self) -> str:
        """Return the analysis: its table in a case file, such as "simulate"."""
        return next(word for word, settings in ANALYSES.items() if isinstance(self.settings, settings))

    def model(self, kind: type[M]) -> M:
        """Return the model as an object of a class derived from `ModelDescription`."""
        found = kind.of(**self.description.parts())
        found.materials.update(self.description.materials)
        found.sections.update(self.description.sections)
        return found

    def to_dict(self) -> dict[str, Any]:
        """Return the content of a case file that describes the same."""
        return {"title": self.title, **self.description.to_dict(), self.kind: self.settings.to_dict()}


@checked
def load_case(path: str | Path) -> Case:
    """Read a case file.

    Args:
        path: of a TOML file.

    Raises:
        InputError: the file cannot be read, is not TOML, or describes something that cannot be computed; the
            message lists everything that is wrong, with key paths.
    """
    path = Path(path)
    text = _content(path)
    return parse_case(text, path)


def parse_case(text: str, source: Path | None = None) -> Case:
    """Read the text of a case file; see `load_case`."""
    heading = str(source) if source is not None else "case"
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(_syntax(error, text), heading=heading) from None
    except (ValueError, RecursionError) as error:
        found = "tables or lists nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(
            Fault("file", found, "this cannot be read as TOML", "simplify it"), heading=heading
        ) from None
    return case_from_dict(data, source, text)


def case_from_dict(
    data: Mapping[str, Any],
    source: Path | None = None,
    text: str = "",
    known: KnownParts | None = None,
    *,
    plain: bool = False,
) -> Case:
    """Read the content of a case file given as nested dicts and lists; see `load_case`.

    Args:
        data: the content; source, text: of the file, if there is one.
        known: parts of a case like this one, such as another member of a sweep; those that are the same are not read
            again.
        plain: whether it is known to be `is_plain`.
    """
    heading = str(source) if source is not None else "case"
    if source is not None and "records" in data and not {"rods", "bodies", "materials"} & set(data):
        says = "it says what is identified from records, and is no case file"
        raise InputError(f"{source}: {says}; compute it with: viscorod identify {source}")
    if not plain and (deep := too_deep(data)):
        why = f"tables or lists are nested more than {DEEPEST_NESTING} deep"
        raise InputError(Fault(deep, "", why, "give what the key needs"), heading=heading)
    in_si, conversions, refused = (data, [], []) if plain else converted(data)
    reader = CaseReader(in_si if source is None else _found_from(source.parent, in_si), known)
    with last_warnings() as told:
        reader.read(whole=not refused)
        told.clear()  # results and checks tell them, with their keys
    reported = {problem.where for problem in refused}
    problems = [*refused, *(problem for problem in reader.problems if problem.where not in reported)]
    if not problems and reader.settings is not None:
        problems = size_problems(reader.model, reader.settings)
    if problems or reader.settings is None:
        raise InputError(problems, heading=heading)
    title = reader.title or (source.stem if source is not None else "untitled")
    return Case(title, reader.model, reader.settings, source, data, text, tuple(conversions))


def is_plain(data: Mapping[str, Any]) -> bool:
    """Return whether a content has no quantities with units, and no more tables within tables than a case needs."""
    return not too_deep(data) and not has_quantity(data)


def _found_from(folder: Path, value: Any) -> Any:
    """Return the same content with paths of files (the keys ``file``) taken from the case file's folder on."""
    if isinstance(value, Mapping):
        return {
            key: str(folder / item) if key == "file" and isinstance(item, str) else _found_from(folder, item)
            for key, item in value.items()
        }
    if isinstance(value, list):
        return [_found_from(folder, item) for item in value]
    return value


def _content(path: Path) -> str:
    try:
        size = path.stat().st_size
        if size <= LARGEST_CASE:
            return path.read_text(encoding="utf-8-sig")
        why = f"larger than any case file ({size / 1e6:.3g} MB)"
        problem = Fault("file", str(path), why, f"give one of less than {LARGEST_CASE // 1_000_000} MB")
    except FileNotFoundError:
        instead = "give the path of a case file"
        if path.parent.is_dir():
            close = nearest(path.name, sorted(other.name for other in path.parent.glob("*.toml")))
            instead = f"did you mean {path.parent / close}?" if close else instead
        if path.suffix in ("", ".toml") and path.stem in shipped_cases():
            instead = f"a shipped case has this name: viscorod example {path.stem} copies it"
        problem = Fault("file", str(path), "there is no such file", instead)
    except IsADirectoryError:
        problem = Fault("file", str(path), "this is a folder", "give the path of a case file in it")
    except UnicodeDecodeError as error:
        why = f"it is not text in UTF-8 (byte {error.start})"
        problem = Fault("file", str(path), why, "give a TOML file, saved as UTF-8")
    except (OSError, ValueError) as error:
        problem = Fault(
            "file", str(path), f"it cannot be read ({error})", "check the path and its permissions"
        )
    raise InputError(problem)


def _syntax(error: tomllib.TOMLDecodeError, text: str) -> Fault:
    """Describe a TOML syntax error with its line."""
    position = re.search(r"line (\d+)", str(error))
    lines = text.splitlines()
    where, line = "end of the file", ""
    if position and 0 < int(position[1]) <= len(lines):
        where, line = f"line {position[1]}", lines[int(position[1]) - 1].strip()[:80]
    why = re.sub(r"\s*\(at .*\)$", "", str(error))
    advice = 'write KEY = VALUE, with text in "quotes", lists in [brackets] and tables as [name]'
    return Fault(where, repr(line) if line else "", f"not TOML: {why[:1].lower()}{why[1:]}", advice)
