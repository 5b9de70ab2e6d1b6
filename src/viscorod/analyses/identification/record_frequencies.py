"""Frequencies of records: those at which they move, and the band that they hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from viscorod.analyses.identification.members import Member
from viscorod.typing import Floats

__all__ = ["dominant_frequencies", "held_band", "vibrating"]

BESIDE = 10.0
"""Ratio by which the band goes beyond the frequencies at which something vibrates: motions that die out hold others."""
SLOW = 0.1
"""Cycles in the time of a history of what still is no constant to it."""


def dominant_frequencies(members: Sequence[Member]) -> list[list[float]]:
    """Return the frequencies at which the records of every case move, Hz, at most three."""
    found = []
    for member in members:
        unlike: list[float] = []
        for one in [hertz for record in member.records for hertz in vibrating(record)]:
            if one > 0.0 and all(abs(one / other - 1.0) > 0.05 for other in unlike):
                unlike.append(one)
        found.append(unlike[:3])
    return found


def held_band(members: Sequence[Member]) -> tuple[float, float] | None:
    """Return the lowest and the highest frequency that records hold, Hz; None where nothing vibrates in them.

    A history holds what creeps in its time and what its samples are close enough for.
    """
    ends: list[float] = []
    for record in [record for member in members for record in member.records]:
        moving = [one for one in vibrating(record) if one > 0.0]
        if not moving:
            continue
        ends += [min(moving) / BESIDE, max(moving) * BESIDE]
        times = getattr(record, "times", None)
        if times is not None:
            ends += [SLOW / float(times[-1] - times[0]), 0.5 / float(np.median(np.diff(times)))]
        if record.analysis == "response":
            ends += [one for one in (record.frequencies[0], record.frequencies[-1]) if one > 0.0]
    return (float(min(ends)), float(max(ends))) if ends else None


def vibrating(record: Any) -> list[float]:
    """Return the frequencies at which a record vibrates: natural ones, or that of the largest peak."""
    if record.analysis == "modes":
        return [float(one) for one in record.frequencies]
    if record.analysis == "response":
        return [float(record.frequencies[int(np.argmax(np.abs(record.values)))])]
    if record.analysis != "simulate":
        return []
    times, values = record.times, np.asarray(record.observed)
    if record.interval is None:  # gaps are bridged: that says where the peak is
        even = np.linspace(times[0], times[-1], len(times))
        return [_peak(np.interp(even, times, values), float(even[1] - even[0]))]
    return [_peak(values, record.interval)]


def _peak(values: Floats, interval: float) -> float:
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values)), 8 * len(values))) ** 2
    return float(np.argmax(power) / (8 * len(values) * interval))
