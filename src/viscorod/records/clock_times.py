"""What begins again: times of day and dates, as loggers stamp their samples, in seconds from the first; angles."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

import numpy as np

from viscorod.typing import Floats

__all__ = ["clock_seconds", "from_the_first", "is_clock_time", "is_date", "since_first", "turned_on"]

_CLOCK = re.compile(
    r"\s*(?:(?P<date>\d{4}-\d\d-\d\d|\d{1,2}[./]\d{1,2}[./]\d{2,4}|\d{4}/\d{1,2}/\d{1,2})[ T]\s*)?"
    r"(?P<hour>\d{1,3}):(?P<minute>[0-5]\d):(?P<second>[0-5]\d(?:[.,]\d*)?)\s*"
    r"(?P<half>[ap]\.?m\.?)?\s*(?:Z|UTC|[+-]\d\d:?\d\d)?\s*",
    re.IGNORECASE,
)
_DATE = re.compile(
    r"\s*(?:\d{4}[-./]\d{1,2}[-./]\d{1,2}|\d{1,2}[./-]\d{1,2}[./-]\d{4}|\d{1,2}[./]\d{1,2}[./]\d{2})\s*"
)
DAY = 86400.0
"""Seconds."""
OF_AN_EPOCH = 1e8
"""Time, s, from which on a record begins years after its zero: that is a calendar's."""
LEAST_JUMP = 1.5 * np.pi
"""Way of an angle between two samples, rad, from which on it has begun again: no swing is sampled that coarsely."""


def from_the_first(times: Floats) -> Floats:
    """Return times that count from an epoch, such as 1970, from their first; others as they are, s."""
    return times - times[0] if len(times) and times[0] > OF_AN_EPOCH else times


def is_clock_time(cell: str) -> bool:
    """Return whether a cell is a time of day, such as 10:11:12.5 or 2024-03-01T10:11:12.5."""
    return _CLOCK.fullmatch(cell) is not None


def is_date(cell: str) -> bool:
    """Return whether a cell is a date and nothing else, such as 01.03.2024."""
    return _DATE.fullmatch(cell) is not None


def clock_seconds(cells: Sequence[str]) -> Floats | None:
    """Return times of day as seconds from the first, over midnights; None if a cell is something else.

    Samples of a record follow each other within a day, so that dates say no more than the order.
    """
    found = [_CLOCK.fullmatch(cell) for cell in cells]
    if not found or not all(found):
        return None
    seconds = np.array(
        [
            3600.0 * _hour(one["hour"], one["half"])
            + 60.0 * float(one["minute"])
            + float(one["second"].replace(",", "."))
            for one in found
            if one is not None
        ]
    )
    midnights = np.cumsum(np.diff(seconds, prepend=seconds[0]) < -0.5 * DAY)
    return np.asarray(np.round(seconds + DAY * midnights - seconds[0], 9))


def _hour(written: str, half: str | None) -> float:
    """Return the hour of the day; of a clock of twelve hours, that begins with 12, with its half of the day."""
    hour = float(written)
    return hour if half is None else hour % 12.0 + (12.0 if half[0] in "pP" else 0.0)


def since_first(values: Any) -> Floats | None:
    """Return dates or durations of numpy or pandas as seconds, dates from the first on; None of anything else."""
    array = np.asarray(values)
    if array.dtype.kind == "O" and len(array) and hasattr(array[0], "timestamp"):
        return np.array([(one - array[0]).total_seconds() for one in array])
    if array.dtype.kind == "M":
        array = array - array[0]
    if array.dtype.kind != "m":
        return None
    seconds = array.astype("timedelta64[ns]").astype(np.int64) * 1e-9
    return np.asarray(np.where(np.isnat(array), np.nan, seconds))


def turned_on(quantity: str, values: Floats) -> Floats:
    """Return values of a history (n,); angles that begin again after a whole turn are counted on."""
    return np.unwrap(values, discont=LEAST_JUMP) if quantity == "rotation" else values
