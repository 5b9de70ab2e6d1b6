"""Stations of a rod from a file of columns: distances, stiffness by name or dimensions of a shape, twist.

With the tension centre at (t1, t2) and the shear centre at (s1, s2) of the section's plane, both from the rod's line,
a section has the energy per length

    2 U = GA1 (shear_1 - s2 twist)^2 + GA2 (shear_2 + s1 twist)^2 + EA (stretch + t2 bend_1 - t1 bend_2)^2
          + EI1 bend_1^2 + EI2 bend_2^2 + GJ twist^2,

and with the mass centre in the place of both, and velocities in that of strains, twice its kinetic energy: the terms
are those of the displacement and of the rotation crossed with the place of a point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.actions.record_file import Columns, read_columns
from viscorod.model.fields.metadata import accepted, units_of
from viscorod.model.sections.isotropic_section import SectionProperties
from viscorod.model.sections.named_numbers import (
    INERTIA_NAMES,
    STIFFNESS_NAMES,
    diagonal_by_name,
    inertia_by_name,
)
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_shapes import SHAPES
from viscorod.model.sections.stiffness_section import StiffnessSection
from viscorod.typing import Floats
from viscorod.units import si_value
from viscorod.wording import RefusedError, did_you_mean, show

__all__ = ["STIFFNESS", "StationRow", "shapes_of_files", "station_rows"]

STIFFNESS = "stiffness"
PLACE, ANGLE = "s", "twist"
OTHER_WORDS = {
    "distance": PLACE,
    "arc length": PLACE,
    "station": PLACE,
    "span": PLACE,
    "mass per length": "mass",
    "twist angle": ANGLE,
}
"""What else the columns are called, in small letters."""
CENTRES = tuple(f"{which} centre {axis}" for which in ("tension", "shear", "mass") for axis in (1, 2))
"""Where along d1 and d2 the centres of a section are."""
STIFFNESS_UNITS = (
    dict(zip(STIFFNESS_NAMES, ("N", "N", "N", "N m^2", "N m^2", "N m^2"), strict=True))
    | dict(zip(INERTIA_NAMES, ("kg/m", "kg m", "kg m", "kg m"), strict=True))
    | dict.fromkeys(CENTRES, "m")
)


_NOT_NEGATIVE = (*STIFFNESS_NAMES, *INERTIA_NAMES)


class StationRow(NamedTuple):
    """A row of the file: arc length [m], section, twist [rad] or None, and the line where it stands, from 1."""

    at: float
    section: AnySection
    twist: float | None
    line: int


def shapes_of_files() -> dict[str, type[AnySection]]:
    """Return the sections whose dimensions a file can give, by their word."""
    return {"given": SectionProperties, **SHAPES}


def station_rows(
    path: str, shape: str, columns: Mapping[str, str | int], times: Sequence[float] | None
) -> list[StationRow]:
    """Return the stations of a file.

    Args:
        path: of the file; shape: of its sections.
        columns: which column is what, by its name or its number from 1; empty for those with the known names.
        times: retardation times (6,) of stiffnesses, s.

    Raises:
        RefusedError: the file cannot be read, or its columns are not those of the shape.
        InputError: a section cannot be used.
    """
    table = read_columns(path)
    units = _units(shape)
    found = _named(table, columns, units, path) if columns else _known(table, units, path)
    numbers = {name: table.numbers[:, k] * _factor(table, k, name, units[name]) for name, k in found.items()}
    if PLACE not in numbers:
        raise RefusedError(
            "no column says where the stations are",
            f"name one {PLACE}, the distance along the rod, or give columns = {{ {PLACE} = ... }}",
            found=show(path),
            at=("file",),
        )
    _usable(table, found, allowed=-np.inf if shape != STIFFNESS else 0.0)
    places, angles = numbers.pop(PLACE), numbers.pop(ANGLE, None)
    rows = []
    for k, line in enumerate(table.lines):
        one = {name: float(values[k]) for name, values in numbers.items()}
        try:
            section = stiffness_from(one, times) if shape == STIFFNESS else shapes_of_files()[shape](**one)
        except InputError as error:
            raise _in_line(error, line) from None
        angle = None if angles is None else float(angles[k])
        rows.append(StationRow(float(places[k]), section, angle, line))
    return rows


def stiffness_from(numbers: Mapping[str, float], times: Sequence[float] | None = None) -> StiffnessSection:
    """Return a section from its stiffnesses, inertias and centres by their names; see the module.

    Raises:
        InputError: some are missing, or such a section does not exist.
    """
    stiffnesses, inertias = (
        {name: numbers[name] for name in names if name in numbers}
        for names in (STIFFNESS_NAMES, INERTIA_NAMES)
    )
    problems: list[Fault] = []
    try:
        stiffness = diagonal_by_name(stiffnesses, all_needed=True)
    except InputError as error:
        problems += error.problems
    try:
        moving = inertia_by_name(inertias) if inertias else None
    except InputError as error:
        problems += error.problems
    if problems:
        raise InputError(problems)
    tension, shear, mass = (
        tuple(numbers.get(f"{which} centre {axis}", 0.0) for axis in (1, 2))
        for which in ("tension", "shear", "mass")
    )
    inertia = _about_line(moving, mass, mass) if moving else None
    return StiffnessSection(_about_line(stiffness, tension, shear), inertia, times=times)


def _about_line(diagonal: Sequence[float], tension: Sequence[float], shear: Sequence[float]) -> Floats:
    """Return the matrix (6, 6) about the rod's line of what is diagonal about its centres."""
    seen = np.eye(6)
    seen[0, 5], seen[1, 5] = -shear[1], shear[0]
    seen[2, 3], seen[2, 4] = tension[1], -tension[0]
    return np.asarray(seen.T @ np.diag(diagonal) @ seen)


def _units(shape: str) -> dict[str, str]:
    """Return the columns that a shape may have, with their units in SI."""
    found = {PLACE: "m", ANGLE: "rad"}
    if shape == STIFFNESS:
        return found | STIFFNESS_UNITS
    kind = shapes_of_files()[shape]
    for name, field in kind.model_fields.items():
        check = accepted(field)
        if name != kind.tag and check is not None and any(map(_numeric, (check.form or {}).get("anyOf", ()))):
            found[name] = (units_of(field) or ("1",))[0]
    return found


def _numeric(form: Mapping[str, Any]) -> bool:
    return form.get("type") == "number"


def _plain(name: str) -> str:
    return " ".join(name.replace("_", " ").casefold().replace("center", "centre").split())


def _known(table: Columns, units: Mapping[str, str], path: str) -> dict[str, int]:
    """Return the columns by what they are; a name that is not known is refused."""
    words = {_plain(name): name for name in units} | OTHER_WORDS
    found: dict[str, int] = {}
    for k, given in enumerate(table.names):
        name = words.get(_plain(given), "")
        if name not in units:
            hint = did_you_mean(_plain(given), words)
            raise RefusedError(
                f"column {k + 1} is not known here" if given else f"column {k + 1} has no name",
                f"{hint}the columns are {', '.join(units)}; of a file with others say what is what, such as "
                f"columns = {{ {PLACE} = 1, {list(units)[2]} = 2 }}",
                found=show(given) if given else show(path),
                at=("file",),
            )
        if name in found:
            raise RefusedError(
                f"columns {found[name] + 1} and {k + 1} are both {name}",
                "leave one out",
                found=show(given),
                at=("file",),
            )
        found[name] = k
    return found


def _named(
    table: Columns, columns: Mapping[str, str | int], units: Mapping[str, str], path: str
) -> dict[str, int]:
    """Return the columns that the user names."""
    words = {_plain(name): name for name in units} | OTHER_WORDS
    found: dict[str, int] = {}
    for given, column in columns.items():
        name = words.get(_plain(given), "")
        if name not in units:
            raise RefusedError(
                "no such number of a section",
                f"{did_you_mean(_plain(given), words)}there are {', '.join(units)}",
                found=show(given),
                at=("columns",),
            )
        found[name] = _index(table, column, given, path)
    return found


def _index(table: Columns, column: str | int, key: str, path: str) -> int:
    if isinstance(column, int):
        if 1 <= column <= len(table.names):
            return column - 1
        raise RefusedError(
            f"the table {path} has {len(table.names)} columns",
            f"give 1 to {len(table.names)}, or a name",
            found=show(column),
            at=("columns", key),
        )
    fits = [k for k, name in enumerate(table.names) if _plain(name) == _plain(column)]
    if len(fits) != 1:
        known = ", ".join(show(name) for name in table.names if name) or "none has a name"
        raise RefusedError(
            "several columns have this name" if fits else "no column has this name",
            f"give its number, from 1, or one of the names there: {known}",
            found=show(column),
            at=("columns", key),
        )
    return fits[0]


def _factor(table: Columns, k: int, name: str, unit: str) -> float:
    """Return how much the unit of a column is in SI."""
    given = table.units[k]
    if given is None or given == unit or (given in ("-", "1") and unit == "1"):
        return 1.0
    try:
        return si_value(f"1 {given.strip('()')}", unit, name)
    except RefusedError as error:
        raise RefusedError(
            f"the unit of column {k + 1}, {name}: {error.why}",
            error.instead,
            found=show(given),
            at=("file",),
        ) from None


def _usable(table: Columns, found: Mapping[str, int], allowed: float) -> None:
    """Refuse what is no finite number, and stiffnesses and inertias below what is allowed."""
    for name, k in found.items():
        values, least = table.numbers[:, k], allowed if name in _NOT_NEGATIVE else -np.inf
        wrong = np.flatnonzero(~np.isfinite(values) | (values < least))
        if len(wrong):
            number = values[wrong[0]]
            raise RefusedError(
                f"line {table.lines[wrong[0]]}, column {name}: "
                + ("it cannot be negative" if np.isfinite(number) else "no finite number"),
                "complete the table" if not np.isfinite(number) else "give a number > 0",
                found=f"{number:g}",
                at=("file",),
            )


def _in_line(error: InputError, line: int) -> InputError:
    """Return an error about a section, with the line of the file."""

    def told(problem: Fault) -> Fault:
        column = problem.where.rpartition(".")[2]
        where = f"line {line}, column {column}" if column else f"line {line}"
        return Fault("file", problem.found, f"{where}: {problem.why}", problem.instead)

    return InputError(told(problem) for problem in error.problems)
