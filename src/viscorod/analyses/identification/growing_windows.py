"""Searches that are led by the first cycles of a free decay or of a response, then by more and more of them.

Over many cycles a sum of squares has a minimum for every period by which model and record may be out of step: from a
modulus that is 30 % off fourteen cycles end in a wrong one. Over the first cycle and a half there is one minimum, and
each fit starts the next, longer one (as scales in the inversion of seismic waveforms: C. Bunks et al.,
Geophysics 60 (1995) 1457-1473). Sharp peaks of a frequency response that do not overlap those of the model tell it
nothing of where to go; what follows a blow, cut after the first cycles, has wide ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.identification.record_frequencies import vibrating
from viscorod.casefile.case import Case
from viscorod.records.decay_span import start_of
from viscorod.records.early_response import EarlyResponse
from viscorod.records.motion_record import Record
from viscorod.records.response_record import ResponseRecord
from viscorod.solve.settings.motion import SimulateSettings

if TYPE_CHECKING:
    from viscorod.analyses.identification.search import Fitted

__all__ = ["growing_windows", "out_of_step"]

FIRST, GROWTH = 1.5, 2.0
"""Cycles after the first passage through rest, and how many times as many come next."""
FEWEST = 8
"""Samples of a window at least."""
LINE = 0.5
"""Lines that a peak of a response is widened by at least."""
LEFT = 0.003
"""Part of a record's variance that is left where model and record are out of step."""
LEFT_OF_PEAKS = 0.02
"""The same of responses, whose noise may be in proportion to their peaks."""


def out_of_step(found: Fitted) -> bool:
    """Return whether so much of a history or response is left that model and record may be out of step."""
    residual, begin = found.estimate.measured - found.estimate.predicted, 0
    for record in [record for member in found.members for record in member.records]:
        rows = slice(begin, begin + len(record.observed))
        begin = rows.stop
        part = LEFT if isinstance(record, Record) else LEFT_OF_PEAKS
        if isinstance(record, Record | ResponseRecord) and np.mean(residual[rows] ** 2) > part * np.var(
            record.observed
        ):
            return True
    return False


def growing_windows(pairs: Sequence[tuple[Case, Any]]) -> Iterator[list[tuple[Case, Any]]]:
    """Yield the pairs with histories cut after the first cycles, after twice as many, and so on; not those as given."""
    cycles = FIRST
    cut: dict[int, Case] = {}
    while True:
        windows = [_window(record, cycles) for _, record in pairs]
        if all(window is record for window, (_, record) in zip(windows, pairs, strict=True)):
            return
        for case, _ in pairs:  # pairs of one case go on sharing it
            cut.setdefault(id(case), _no_longer_than_needed(case))
        yield [(cut[id(case)], window) for window, (case, _) in zip(windows, pairs, strict=True)]
        cycles *= GROWTH


def _window(record: Any, cycles: float) -> Any:
    """Return the first cycles of what vibrates; other records, and short ones, as they are."""
    if isinstance(record, ResponseRecord):
        span = cycles / _highest(record)
        fine = len(record.frequencies) >= FEWEST and 1.0 / span > 2.0 * np.pi * LINE * float(
            np.median(np.diff(record.frequencies))
        )
        return EarlyResponse(record, span) if fine else record
    hertz = vibrating(record)[0] if isinstance(record, Record) else 0.0
    if hertz <= 0.0:
        return record
    passage = start_of(record.times, record.values)
    releases = {full: one for full, one in record.nuisances.items() if one.name == "release_time"}
    end = max([passage, *(one.start or 0.0 for one in releases.values())]) + cycles / hertz
    inside = int(np.count_nonzero(record.times <= end))
    if not FEWEST <= inside < len(record.times):
        return record
    found = record.window(record.times[0], end)
    for full, one in releases.items():  # what was held aside passes through rest a quarter of a period later
        if not np.isfinite(one.deviation):  # else the start is what is believed
            start = float(np.clip(passage - 0.25 / hertz, one.low, one.high))
            found.nuisances[full] = replace(one, start=start)
    return found


def _highest(record: ResponseRecord) -> float:
    """Return the highest frequency at which a response is as large as usual, Hz."""
    size = np.abs(record.values)
    return float(record.frequencies[np.flatnonzero(size >= np.median(size))[-1]]) or 1.0


def _no_longer_than_needed(case: Case) -> Case:
    """Return a case whose motion lasts no longer than its records ask for."""
    if not isinstance(case.settings, SimulateSettings):
        return case
    return replace(
        case, settings=case.settings.model_copy(update={"duration": 1e-3 * case.settings.duration})
    )
