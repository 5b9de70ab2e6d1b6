"""What is sought: numbers of cases by their keys, numbers of measurements, and what was believed of them beforehand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from viscorod.analyses.identification.case_numbers import number_at, where_to_look
from viscorod.analyses.identification.members import Member, earliest_release
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.records.moduli_record import ModuliRecord
from viscorod.records.response_record import ResponseRecord
from viscorod.solve.estimation.noise import Series
from viscorod.solve.estimation.unknowns import Unknown, Unknowns
from viscorod.typing import Floats

__all__ = ["Belief", "Range", "series_of", "sought"]

Range: TypeAlias = float | Sequence[float] | None
"""A start, (low, start, high), or None: what the case has."""
Belief: TypeAlias = tuple[int, float, float]
"""Number of an unknown, its likeliest value beforehand, and the standard deviation of that."""


def sought(
    members: Sequence[Member],
    parameters: Mapping[str, Range],
    nuisances: Mapping[str, Range],
    *,
    free: bool = False,
) -> tuple[Unknowns, list[Belief]]:
    """Return the unknowns, those of the model first, and what was believed of them.

    Args:
        members: cases with their records.
        parameters, nuisances: see `identify`.
        free: whether there may be no parameter.

    Raises:
        InputError: a key is none of a case or record, or a range is none; all faults at once.
    """
    faults: list[Fault] = []
    found: list[Unknown] = []
    beliefs: list[Belief] = []
    of_records = dict(_of_records(members))
    for group, listed in ((False, parameters), (True, nuisances)):
        for name, given in listed.items():
            if group and any(name in (full, one.name) for full, (one, _) in of_records.items()):
                continue
            try:
                found.append(_of_case(members, name, given, nuisance=group))
            except InputError as error:
                faults += error.problems
    for full, (one, span) in of_records.items():
        given = nuisances.get(full, nuisances.get(one.name))
        try:
            unknown = _of_measurement(members, full, one, span, given)
        except InputError as error:
            faults += error.problems
            continue
        if np.isfinite(one.deviation):
            beliefs.append((len(found), unknown.start if one.start is None else one.start, one.deviation))
        found.append(unknown)
    if not any(not one.nuisance for one in found) and not faults and not free:
        faults.append(Fault("parameters", "", "nothing is sought", "name a number of the case and a start"))
    if faults:
        raise InputError(faults)
    return Unknowns(found), beliefs


def _of_records(members: Sequence[Member]) -> Iterator[tuple[str, tuple[Any, float]]]:
    for member in members:
        for record in member.records:
            times = getattr(record, "times", None)
            span = 0.0 if times is None else float(times[-1] - times[0])
            for full, one in record.nuisances.items():
                yield full, (one, span)


def _range(name: str, given: Range, start: float | None) -> tuple[float, float, float]:
    """Return low, start and high."""
    values = [given] if isinstance(given, int | float) or given is None else list(given)
    if values == [None]:
        values = [start]
    numbers = [v for v in values if isinstance(v, int | float | np.number) and not isinstance(v, bool)]
    if len(numbers) != len(values) or len(values) not in (1, 3) or not np.isfinite(numbers[len(values) // 2]):
        why = (
            "a start, or low, start and high are needed"
            if given is not None
            else "the case has no number there"
        )
        raise InputError(Fault(name, show(given), why, "give 0.02, or (0.001, 0.02, 0.5)"))
    low, middle, high = (-np.inf, numbers[0], np.inf) if len(numbers) == 1 else numbers
    if not low <= middle <= high or low == high:
        raise InputError(Fault(name, show(given), "low <= start <= high is needed", "put them in order"))
    return float(low), float(middle), float(high)


def _of_case(members: Sequence[Member], name: str, given: Range, *, nuisance: bool) -> Unknown:
    having = [number for one in members if (number := number_at(one.case, name, strict=True)) is not None]
    if not having:
        hint = where_to_look(members[0].case, name)
        instead = f"{hint}; or give the name of an unknown of a record"
        raise InputError(Fault(name, "", "no case has a number there", instead))
    low, start, high = _range(name, given, having[0])
    positive = start > 0.0 and (low >= 0.0 or not np.isfinite(low))
    return Unknown(name, start, low, high, logarithmic=positive, nuisance=nuisance)


def _of_measurement(members: Sequence[Member], name: str, one: Any, span: float, given: Range) -> Unknown:
    if one.key is not None:
        inside = None if one.low is None or one.high is None else (one.low, one.start, one.high)
        found = _of_case(members, one.key, given if given is not None else inside or one.start, nuisance=True)
        return replace(found, name=name)
    low, start, high = one.low, one.start, one.high
    if given is not None:
        low, start, high = _range(name, given, one.start)
    if one.name == "release_time":  # where the motion must have been computed
        low, high = max(low, earliest_release(one, span)), min(high, start + 0.5 * span)
        start = min(max(start, low), high)
    return Unknown(name, float(start), float(low), float(high), nuisance=True)


def series_of(
    members: Sequence[Member], unknowns: Unknowns, beliefs: Sequence[Belief]
) -> tuple[Floats, list[Series]]:
    """Return what was measured, then what was believed ``(n,)``, and the series of it."""
    series: list[Series] = []
    measured: list[Floats] = []
    begin = 0
    for member in members:
        for record in member.records:
            observed = np.asarray(record.observed, dtype=float)
            for label, part, group, regular, curves in _channels(record):
                told = record.noise is not None
                noise = (
                    record.noise[part]
                    if told
                    else _in_proportion(observed[part], relative=record.analysis == "modes")
                )
                rows = slice(begin + part.start, begin + part.stop)
                size = np.asarray(noise, dtype=float)
                halves = isinstance(record, ResponseRecord | ModuliRecord)
                times = None if regular else getattr(record, "times", None)
                series.append(Series(label, rows, regular, size, told, False, group, curves, halves, times))
            measured.append(observed)
            begin += len(observed)
    for number, value, deviation in beliefs:
        row = slice(begin, begin + 1)
        label = f"{unknowns[number].name} beforehand"
        series.append(Series(label, row, False, np.array([deviation]), told=True, certain=True))
        measured.append(np.array([value]))
        begin += 1
    return np.concatenate(measured), series


def _channels(record: Any) -> Iterator[tuple[str, slice, str, bool, int]]:
    """Yield the series of a record.

    That is label, rows, what short ones share their noise with, whether they are regular, and how many curves they are.
    """
    count = len(record.observed)
    if record.analysis == "modes" and record.damping_ratios is not None:
        half = count // 2
        yield f"{record.name}: frequencies", slice(0, half), "frequencies", False, 0
        yield f"{record.name}: damping ratios", slice(half, count), "ratios", False, 0
    elif record.analysis == "modes":
        yield f"{record.name}: frequencies", slice(0, count), "frequencies", False, 0
    else:
        regular = getattr(record, "interval", None) is not None
        quantity = getattr(record, "quantity", record.analysis)
        curves = 0 if regular else len(record.axes)
        yield record.name, slice(0, count), f"{record.analysis} {quantity}", regular, curves


def _in_proportion(observed: Floats, *, relative: bool) -> Floats:
    """Return what noise that was not told is in proportion to: each value, or the spread of a history."""
    spread = float(np.std(observed)) or float(np.abs(observed).max()) or 1.0
    if not relative:
        return np.full(len(observed), spread)
    return np.asarray(np.maximum(np.abs(observed), 1e-3 * float(np.abs(observed).max()) or 1.0))
