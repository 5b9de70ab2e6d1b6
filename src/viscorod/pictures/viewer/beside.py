"""Other results and measured records beside one in its page: their curves in its charts, their rods in its space."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import InputError
from viscorod.records.motion_record import Record
from viscorod.results.data_schema import AXES
from viscorod.results.probe import instants_of, poses_at
from viscorod.results.run import Run
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.pictures.viewer.frames import Frames
    from viscorod.pictures.viewer.packing import Pack
    from viscorod.results.result import Result

__all__ = ["Beside", "Others"]

Others: TypeAlias = Sequence[Run | Record] | Mapping[str, Run | Record]
"""What is shown beside a motion, with names of its own or those of a table."""

_MEASURED = ("displacement", "velocity")


def _axis_of(record: Record) -> int | None:
    """Return the number of the global axis along which a record was measured, None of others."""
    if isinstance(record.direction, str):
        return AXES.index(record.direction) if record.direction in AXES else None
    along = np.asarray(record.direction, dtype=float)
    axes = np.flatnonzero(np.isclose(along, 1.0))
    return int(axes[0]) if axes.size == 1 and np.isclose(np.abs(along).sum(), 1.0) else None


class Beside:
    """Motions and records that are shown beside a motion.

    Args:
        result: the motion; samples: numbers of its stored states in the charts.
        others: motions and records of displacement or velocity along global axes, or a table of them by their names.

    Raises:
        InputError: one of them cannot be shown beside it.
    """

    def __init__(self, result: Result, samples: np.ndarray, others: Others) -> None:
        self._runs: list[tuple[int, str, Run]] = []
        self._records: list[tuple[int, str, Record]] = []
        if others and not isinstance(result, Run):
            raise InputError("beside: only motions over time have others beside them; give a run")
        self._times = np.asarray(result.data[result.dimension].values, dtype=float)[samples]
        named = isinstance(others, Mapping)
        listed = list(others.items()) if isinstance(others, Mapping) else [("", other) for other in others]
        for number, (name, other) in enumerate(listed):
            if isinstance(other, Run):
                self._runs.append((number, name or other.title or f"result {number + 2}", other))
            elif isinstance(other, Record) and other.quantity in _MEASURED and _axis_of(other) is not None:
                self._records.append((number, name or other.name or "measured", other))
            else:
                what = type(other).__name__
                raise InputError(
                    f"beside: {what}: give motions over time, or records of displacement or velocity along x, y or z"
                )
        if named:
            return
        titles = [name for _, name, _ in self._runs]
        own = getattr(result, "title", "")
        self._runs = [
            (number, f"{name} ({number + 2})" if titles.count(name) > 1 or name == own else name, run)
            for number, name, run in self._runs
        ]

    def curves(self, label: str, place: str, names: list[str]) -> list[tuple[dict[str, Any], Floats]]:
        """Return what others have for a group of curves: what each is, and its values at the times of the charts.

        Args:
            label: of the group, "displacement of beam.end"; place: of it; names: of its curves, x, y, z.
        """
        quantity: Any = label.split(" of ", maxsplit=1)[0]
        found: list[tuple[dict[str, Any], Floats]] = []
        for number, name, run in self._runs:
            try:
                values = run.history(place, quantity).values
            except InputError:  # it has no such place
                continue
            for k, word in enumerate(names):
                told = {"name": f"{word}, {name}", "curve": k, "result": number}
                found.append((told, self._at(run.time, values[:, k])))
        for number, name, record in self._records:
            axis = _axis_of(record)
            if axis is not None and record.place == place and record.quantity == quantity:
                told = {"name": f"{names[axis]}, {name}", "curve": axis, "result": number}
                found.append((told, self._at(record.times, record.values)))
        return found

    def _at(self, times: Floats, values: Floats) -> Floats:
        found: Floats = np.interp(self._times, times, values, left=np.nan, right=np.nan)
        return found

    def ghosts(self, frames: Frames, pack: Pack) -> list[dict[str, Any]]:
        """Put the rods of other motions into the page at the times of its frames; return what they are called."""
        told = []
        for number, name, run in self._runs:
            times = np.clip(frames.instants, run.time[0], run.time[-1])
            stations = [run.sites.stations(rod) for rod in run.sites.rods]
            poses = poses_at(run, np.concatenate(stations), instants_of(run, times))
            array = f"ghost{number}"
            pack.quantised(array, poses.position, 3)
            told.append({"name": name, "array": array, "counts": [len(part) for part in stations]})
        return told
