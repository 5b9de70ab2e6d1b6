"""A run whose states leave it in pieces as they come: into arrays, or to disk, from where it can go on."""

from __future__ import annotations

import difflib
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.journal import Journal
from viscorod.results.files.journal_folder import FOLDER
from viscorod.results.files.storage import write
from viscorod.results.files.stored_journal import about, complete, last_checkpoint, mended
from viscorod.solve.history import History, Records, Snapshot
from viscorod.solve.transient.pose_check import MOST
from viscorod.whole_files import why_not

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.state_arrays import Stored

FLUSH = 1.0
"""Seconds of wall time after which states are written at the latest."""

MANY = 1024
"""States that are kept at most before they are written."""
MUCH = 64e6
"""Bytes of states that are kept at most, unless one has more."""

CHECKPOINT = 1.0
"""Seconds of wall time between two checkpoints at least."""

SHARE = 0.02
"""Part of the wall time that checkpoints take at most."""


class Sink(Protocol):
    """Where states go: a journal, or arrays."""

    count: int

    def append(self, data: xr.Dataset) -> None:
        """Put the states of a data set from number ``count`` on."""

    def contents(self) -> xr.Dataset:
        """Return the data set of all states so far."""


class Stream(History):
    """A history that keeps no more than some states: the others have gone to a sink.

    An interrupt may come between any two of its instructions: states that are here have not been counted there, and
    are put there once more.

    Args:
        sink: where they go.
        build: makes a data set of a history.
        sampled: some states stay here, evenly chosen, for :meth:`sample`.
    """

    def __init__(self, sink: Sink, build: Callable[[History], xr.Dataset], *, sampled: bool = False) -> None:
        super().__init__()
        self.sink, self.build, self.sampled = sink, build, sampled
        self._gone = sink.count
        self._signs: np.ndarray | None = None
        self._most = MANY
        self._samples: list[tuple[float, Snapshot]] = []
        self._stride = 1

    @property
    def count(self) -> int:
        """States recorded so far."""
        return self._gone + len(self.instant)

    @property
    def whole(self) -> bool:
        """Whether all states so far are here: of a short run none has gone, and none needs to."""
        return not self._gone and self.count > 0

    def extend(
        self,
        instants: list[float],
        records: Records,
        step_size: float | list[float],
        iterations: int | list[int],
    ) -> None:
        """See :class:`~viscorod.solve.history.History`."""
        states = records.states
        if not self.count:
            self._most = max(1, min(MANY, int(MUCH // _size(states.at(0)))))
        if self.instant and len(self.instant) + len(instants) > self._most:
            self.flush()
        super().extend(instants, records, step_size, iterations)
        if self.sampled:
            first = self.count - len(instants) + 1
            for k, instant in enumerate(instants):
                if (first + k) % self._stride == 0:
                    self._sample(instant, states.at(k))

    def _sample(self, instant: float, snapshot: Snapshot) -> None:
        self._samples.append((instant, _own(snapshot)))
        if len(self._samples) >= 2 * MOST:  # half as many, twice as far apart
            self._samples, self._stride = self._samples[::2], 2 * self._stride

    def sample(self, most: int) -> list[tuple[float, Snapshot]]:
        """See :class:`~viscorod.solve.history.History`: if ``sampled``; of a run that went on, those since then."""
        return self._samples[:: max(1, len(self._samples) // most)]

    def flush(self) -> None:
        """Let the states that are here go to the sink."""
        count = len(self.instant)
        if not count:
            return
        self.truncate(count)  # an interrupt may have left a part of another one
        data, signs = self._continued(self.build(self))
        self.sink.count = self._gone
        self.sink.append(data)
        # all at once: an interrupt comes before that or after it
        fresh = vars(History(start=self.start))
        vars(self).update(fresh, _gone=self._gone + count, _signs=signs)

    def contents(self) -> xr.Dataset:
        """Return the data set of all states that have gone, of which there will be no more."""
        return self.sink.contents()

    def _continued(self, data: xr.Dataset) -> tuple[xr.Dataset, np.ndarray]:
        """Let orientations go on with the sign of the quaternions before; return the last of them, too."""
        rotation = data["rotation"].values
        if self._signs is not None:
            flip = np.sum(rotation[0] * np.asarray(self._signs), axis=-1) < 0.0
            rotation = np.where(flip[None, :, None], -rotation, rotation)
            data["rotation"] = data["rotation"].copy(data=rotation)
        return data, rotation[-1].copy()


class JournalStream(Stream):
    """A stream to a journal on disk, from which the run can go on.

    Args:
        folder: of ``run.nc``; the journal is a folder in it.
        build: makes a data set of a history.
        attributes: of the run; ``case`` and ``settings`` among them have to be those of a run that goes on.
        resume: go on from the checkpoint of the journal that is there.
        sampled: see :class:`Stream`.

    Attributes:
        checkpoint: the state from which to go on, None at the beginning.
        doubt: what was damaged in it, so that it was mended or went back to an earlier state; empty usually.
        broken: states can no longer be written.
    """

    def __init__(
        self,
        folder: Path,
        build: Callable[[History], xr.Dataset],
        attributes: Mapping[str, str],
        *,
        resume: bool = False,
        sampled: bool = False,
    ) -> None:
        self.folder = folder
        place, found = folder / FOLDER, None
        told: list[str] = []
        if resume:
            _require_same(about(place), attributes, folder)
            told = mended(place)
            found = last_checkpoint(place)
        self.journal = Journal(place, keep=None if found is None else found.count)
        super().__init__(self.journal, build, sampled=sampled)
        self.checkpoint: Any = None
        self.broken = False
        if found is not None and found.state is not None:
            self.checkpoint, self._signs = found.state, np.array(found.about["signs"])
            told = [found.about["doubt"], *told, found.doubt]
            if found.doubt:
                self.journal.forget_last_checkpoint()
        self.doubt = "; ".join(filter(None, told))
        self._flushed = self._checked = (
            math.nan
        )  # until the first step is done, which loads or compiles its code
        self._cost = 0.0

    def flush(self) -> None:
        """See :class:`Stream`."""
        with self._writing():
            super().flush()
        self._flushed = time.monotonic()

    def after_step(self, state: Callable[[], Any]) -> None:
        """Write what is due: states, and with ``state`` from what the run can go on."""
        now = time.monotonic()
        if math.isnan(self._checked):
            self._flushed = self._checked = now
        if now - self._flushed > FLUSH or len(self.instant) >= MANY:
            self.flush()
        if now - self._checked > max(CHECKPOINT, self._cost / SHARE):
            self.save(state)

    def save(self, state: Callable[[], Any]) -> None:
        """Write a checkpoint now; between two steps only, where a run can go on bit for bit."""
        begin = time.monotonic()
        self.flush()
        signs = None if self._signs is None else self._signs.tolist()
        with self._writing():
            self.journal.checkpoint(state(), {"signs": signs, "doubt": self.doubt})
        self._checked = time.monotonic()
        self._cost = self._checked - begin

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Turn a full disk into one message: what is there can be read, and the run can go on."""
        try:
            yield
        except OSError as error:
            self.broken = True
            raise InputError(
                f"{self.folder}: states can no longer be written ({why_not(error, self.journal.folder)}); what was "
                "written is complete up to its last state; make room and go on with: viscorod resume "
                f"{self.folder} (in Python resume=True)"
            ) from None

    def write(self, data: Stored) -> Path:
        """Make ``run.nc`` of all states, none of which has gone to the journal; a stopped run there is removed then.

        Raises:
            InputError: it cannot be written.
        """
        advice = (
            "make room, or name another folder, and compute it again: no state of a run this short is kept"
        )
        place = write(data, self.folder / "run.nc", instead=advice)
        self.journal.remove()
        return place

    def finish(self, attrs: dict[str, Any], *, keep: bool) -> Path:
        """Make ``run.nc`` of the journal, with these attributes; ``keep`` the journal, to go on from it."""
        count = self.journal.count
        self.journal.close()
        return complete(self.journal.folder, self.folder / "run.nc", attrs, keep=keep, count=count)


def _require_same(known: Mapping[str, Any], attributes: Mapping[str, str], folder: Path) -> None:
    """Refuse to go on with another model or other settings, and show what differs."""
    before, now = (_lines(attrs) for attrs in (known, attributes))
    if before != now:
        difference = difflib.unified_diff(before, now, "the run that was stopped", "now", lineterm="", n=1)
        raise InputError(
            f"{folder}: model and settings are not the same as those of the run that was stopped there:\n"
            + "\n".join(f"  {line}" for line in difference)
            + "\nGive the same ones, or another folder for another run"
        )


def _lines(attrs: Mapping[str, Any]) -> list[str]:
    found = {name: json.loads(str(attrs.get(name, "null"))) for name in ("case", "settings")}
    return json.dumps(found, indent=1).splitlines()


def _own(snapshot: Snapshot) -> Snapshot:
    """Return a copy: the arrays of a snapshot are parts of those of all states of a piece of its step."""
    fields: dict[str, Any] = {k: v.copy() for k, v in snapshot._asdict().items() if isinstance(v, np.ndarray)}
    return snapshot._replace(state=snapshot.state.copy(), **fields)


def _size(snapshot: Snapshot) -> int:
    """Return about how many bytes a snapshot has."""
    fields = [*snapshot, *vars(snapshot.state).values(), *(snapshot.joints or ())]
    return sum(field.nbytes for field in fields if isinstance(field, np.ndarray)) or 1
