"""Kinds of the arguments that functions about measurements take; see `viscorod.checks`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

from viscorod.checks import checked_with, file_path, flag, number, text, word
from viscorod.errors import Fault, InputError

__all__ = ["described"]


def _column(name: str, value: Any) -> str | int:
    """Return the name or the number of a column."""
    if isinstance(value, str) or (isinstance(value, int) and not isinstance(value, bool)):
        return value
    raise InputError(
        Fault(name, type(value).__name__, "a column has a name or a number", "give 'tip_y', or 2")
    )


def _columns(name: str, value: Any) -> Any:
    """Return one column, or a list of them."""
    if isinstance(value, list | tuple) and value:
        return [_column(name, one) for one in value]
    return _column(name, value)


def _span(name: str, value: Any) -> tuple[float, float]:
    """Return two increasing numbers."""
    if isinstance(value, str | bytes) or not isinstance(value, Sequence) or len(value) != 2:
        raise InputError(Fault(name, type(value).__name__, "two numbers are needed here", "give (0.1, 10.0)"))
    low, high = (number(name, one) for one in value)
    if not low < high:
        raise InputError(Fault(name, f"{low:g} to {high:g}", "they do not increase", "exchange them"))
    return low, high


def _values_of_unknowns(name: str, value: Any) -> Mapping[str, float]:
    """Return numbers by name."""
    if not isinstance(value, Mapping):
        raise InputError(
            Fault(name, type(value).__name__, "values by name are needed", "give {'tip.offset': 0.0}")
        )
    return {str(key): number(f"{name}[{key}]", one) for key, one in value.items()}


def _listed(name: str, value: Any) -> Any:
    """Return one thing, or a list of them; what they are is up to the function."""
    one = isinstance(value, str | PathLike) or hasattr(value, "kind") or hasattr(value, "deviation")
    if not one and not isinstance(value, list | tuple):
        raise InputError(
            Fault(name, type(value).__name__, "this is none, and no list of them", "give one, or a list")
        )
    return value


described = checked_with(
    place=text, name=text, quantity=word, of=word, unit=word, time_unit=word, frequency_unit=word, gaps=text, law=word,
    title=text, rate=number, window=word, window_time=number, excitation=word, damping_as=word,
    value=_columns, frequency=_column,
    time=_column, start=number, end=number, full_load=number, relative_noise=number,
    reference=number, temperature=number, density=number, poissons_ratio=number, vertical=flag, band=_span,
    law_range=_span, nuisances=_values_of_unknowns, unknown=_listed, records=_listed,
    files=_listed, folder=file_path,
)  # fmt: skip
"""Check the arguments of a function by their names."""
