"""Tables with one column for every frequency or temperature, which stands in the names or above them.

``E' (1 Hz)/MPa``, ``E' 10 Hz [MPa]`` over temperature, or ``E' 20 °C`` over frequency: each frequency or temperature
has its own columns of moduli, and is read as a table of its own with that number in all rows.
"""

from __future__ import annotations

import re

from viscorod.model.fields.definition import RefusedError
from viscorod.model.materials.column_names import Heading, heading, unit_of
from viscorod.model.materials.column_units import FREQUENCY_UNITS
from viscorod.model.materials.other_moduli import enough
from viscorod.model.materials.table_text import Numbers

__all__ = ["Label", "celsius", "labelled", "labels_above", "labels_within"]

Label = tuple[str, float]
"""What all rows of a column have in common: "frequency" and rad/s, or "temperature" and degrees C."""

_UNIT = r"k?Hz|mHz|rad/s(?:ec)?|°\s?C|℃|deg\s?C|°\s?F|C|K"
_LABEL = re.compile(
    r"(?:@|\bat\b|\bbei\b|\b[fT]\s*=)?\s*[(\[]?\s*(?<![A-Za-z0-9.,'])"
    rf"([-+]?\d+(?:[.,]\d+)?)[\s_]*({_UNIT})(?![A-Za-z0-9/])\s*[)\]]?"
)
_MODULI = ("storage", "loss", "complex", "tan_delta", "phase")


def celsius(value: float, unit: str) -> float:
    """Return degrees C."""
    known = unit_of(unit, "temperature")
    return value - 273.15 if known == "K" else (value - 32.0) / 1.8 if known == "F" else value


def labels_within(cells: list[str]) -> dict[int, tuple[str, str, Heading]]:
    """Return number, unit and the rest of the names of moduli that have a frequency or temperature within."""
    found = {}
    for at, cell in enumerate(cells):
        label = _LABEL.search(cell)
        if label is None:
            continue
        rest = (cell[: label.start()] + " " + cell[label.end() :]).strip(" :;,-_")
        known = heading(rest)
        if known is not None and known.kind in _MODULI:
            found[at] = (
                label[1],
                label[2],
                Heading(known.kind, cell, known.unit, known.strain, known.logarithm),
            )
    return found


def labels_above(above: list[str], columns: dict[int, Heading]) -> dict[int, tuple[str, str, Heading]]:
    """Return the same of a line above the names, each of whose cells holds for the columns up to the next."""
    found: dict[int, tuple[str, str, Heading]] = {}
    label = None
    for at in range(max(columns, default=-1) + 1):
        cell = above[at].strip() if at < len(above) else ""
        if cell:
            label = _LABEL.fullmatch(cell)
            if label is None:
                return {}
        known = columns.get(at)
        if label is not None and known is not None and known.kind in _MODULI:
            found[at] = label[1], label[2], known
    return found


def labelled(
    line: int, labels: dict[int, tuple[str, str, Heading]], columns: dict[int, Heading]
) -> dict[int, Label]:
    """Return the labels of columns, if they and the other columns make tables over frequency; else none.

    Raises:
        RefusedError: a frequency or temperature has not the columns of a complex modulus.
    """
    plain = {known.kind for at, known in columns.items() if at not in labels}
    numbers = Numbers(text for text, _, _ in labels.values())
    found: dict[int, Label] = {}
    for at, (text, unit, _) in labels.items():
        value = numbers.of(text)
        assert value is not None
        of_frequency = unit_of(unit, "frequency")
        if of_frequency:
            found[at] = "frequency", value * FREQUENCY_UNITS[of_frequency]
        else:
            found[at] = "temperature", celsius(value, unit)
    kinds = {kind for kind, _ in found.values()}
    over_frequency = bool(plain & {"frequency", "angular"})
    if len(kinds) != 1 or over_frequency != (kinds == {"temperature"}):
        return {}
    for label in dict.fromkeys(found.values()):
        mine = [at for at, one in found.items() if one == label]
        if not enough({labels[at][2].kind for at in mine}):
            text, unit, _ = labels[mine[0]]
            raise RefusedError(
                f"line {line} names no complex modulus for {text} {unit}",
                "give a storage modulus and a loss modulus, tan delta or phase for each",
                found=", ".join(labels[at][2].text for at in mine),
            )
    return found
