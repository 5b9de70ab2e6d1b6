"""A run whose states go to disk as they come, and that can go on from there."""

from __future__ import annotations

import difflib
import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.files.journal import FOLDER, Journal, checkpoint, complete, contents
from viscorod.solve.history import EnergyAccount, History, Snapshot
from viscorod.solve.transient.pose_check import MOST

if TYPE_CHECKING:
    import xarray as xr

FLUSH = 1.0
"""Seconds of wall time after which states are written at the latest."""

MANY = 256
"""States that are kept in memory at most before they are written."""

CHECKPOINT = 1.0
"""Seconds of wall time between two checkpoints at least; the first is written after the first step."""

SHARE = 0.02
"""Part of the wall time that checkpoints take at most."""


def _require_same(known: Mapping[str, Any], about: Mapping[str, str], folder: Path) -> None:
    """Refuse to go on with another model or other settings, and show what differs."""
    before, now = (_lines(attrs) for attrs in (known, about))
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


@dataclass
class Stream(History):
    """A history that is written to a journal and kept in memory only until then.

    Attributes:
        folder: of ``run.nc``; the journal is a folder beside it.
        about: attributes of the run; ``case`` and ``settings`` among them have to be those of a run that goes on.
        resuming: go on from the checkpoint of the journal that is there.
    """

    folder: Path = field(kw_only=True)
    about: dict[str, str] = field(kw_only=True)
    resuming: bool = False

    def __post_init__(self) -> None:
        self.broken = False
        self._saved: tuple[Any, int, dict[str, Any]] | None = None
        count = None
        if self.resuming:
            _require_same(contents(self.folder / FOLDER).attrs, self.about, self.folder)
            self._saved = checkpoint(self.folder / FOLDER)
            count = self._saved[1]
        self.journal = Journal(self.folder / FOLDER, keep=count)
        self.count = self.journal.count
        self._samples: list[Snapshot] = []
        self._stride = 1
        self._signs: np.ndarray | None = None
        self._flushed = self._checked = -np.inf
        self._cost = 0.0
        if self._saved is not None:
            self._signs = np.array(self._saved[2]["signs"])

    @property
    def checkpoint(self) -> Any:
        """The state from which to go on, None at the beginning."""
        return None if self._saved is None else self._saved[0]

    def record(
        self, instant: float, snapshot: Snapshot, account: EnergyAccount, step_size: float, iterations: int
    ) -> None:
        """See :class:`~viscorod.solve.history.History`."""
        super().record(instant, snapshot, account, step_size, iterations)
        if self.count % self._stride == 0:
            self._samples.append(snapshot)
            if len(self._samples) == 2 * MOST:  # half as many, twice as far apart
                self._samples, self._stride = self._samples[::2], 2 * self._stride

    def sample(self, most: int) -> list[Snapshot]:
        """See :class:`~viscorod.solve.history.History`: of a run that went on, those since then."""
        return self._samples[:: max(1, len(self._samples) // most)]

    def flush(self, build: Callable[[History], xr.Dataset]) -> None:
        """Write the states in memory, of which ``build`` makes a data set."""
        if not self.instant:
            return
        data = self._continued(build(self))
        with self._writing():
            self.journal.append(data)
        count = self.count
        self.truncate(0)
        self.count = count
        self._flushed = time.monotonic()

    def _continued(self, data: xr.Dataset) -> xr.Dataset:
        """Let orientations go on with the sign of the quaternions written last."""
        rotation = data["rotation"].values
        if self._signs is not None:
            flip = np.sum(rotation[0] * np.asarray(self._signs), axis=-1) < 0.0
            rotation = np.where(flip[None, :, None], -rotation, rotation)
            data["rotation"] = data["rotation"].copy(data=rotation)
        self._signs = rotation[-1].copy()
        return data

    def after_step(self, build: Callable[[History], xr.Dataset], state: Callable[[], Any]) -> None:
        """Write what is due: states, and with ``state`` from what the run can go on."""
        now = time.monotonic()
        if now - self._flushed > FLUSH or len(self.instant) >= MANY:
            self.flush(build)
        if now - self._checked > max(CHECKPOINT, self._cost / SHARE):
            self.save(build, state)

    def save(self, build: Callable[[History], xr.Dataset], state: Callable[[], Any]) -> None:
        """Write a checkpoint now."""
        begin = time.monotonic()
        self.flush(build)
        signs = None if self._signs is None else self._signs.tolist()
        with self._writing():
            self.journal.checkpoint(state(), {"signs": signs})
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
                f"{self.folder}: states can no longer be written ({error.strerror or error}); what was written is "
                f"complete up to its last state; make room and go on with: viscorod resume {self.folder}"
            ) from None

    def finish(self, attrs: dict[str, Any], *, keep: bool) -> Path:
        """Make ``run.nc`` of the journal, with these attributes; ``keep`` the journal, to go on from it."""
        self.journal.close()
        return complete(self.folder / FOLDER, self.folder / "run.nc", attrs, keep=keep)
