"""What cases say of records, by the unknowns, and the derivatives of that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from viscorod.analyses.identification.members import Member
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["CasePredictions"]

STEP = 1e-3
"""Part of a number (or of its scale) by which it is changed to either side for a difference."""
ONE_SIDED = 3e-4
"""The same of differences to one side, by which a search is led; they err by some 1e-3."""
OF_HELD = 3e-6
"""The same of motions with held steps, to one side: 1e-4 is left of the curvature and of the iteration of steps."""
ACCURACY = 1e-4
"""Relative error of derivatives: exact ones are those of steps and of a mesh that err by about as much."""


class _Steep(NamedTuple):
    """Derivatives that were found last, by the unknowns that they are at."""

    key: bytes
    rough: bool
    slopes: Floats


class CasePredictions:
    """Predictions of all records by all unknowns, and of what was believed beforehand.

    Derivatives by numbers of a case are those of its result. Rough ones, which lead a search, are differences of
    results on one mesh, as are all where a result has none: along a path, by a number of the settings. Those by numbers
    of a measurement need no further result.

    Args:
        members: the cases; unknowns: that they are predicted by; believed: numbers of unknowns with beliefs.
        exact: whether slopes are ever wanted that are better than rough.
    """

    accuracy = ACCURACY

    def __init__(
        self, members: Sequence[Member], unknowns: Unknowns, believed: Sequence[int], *, exact: bool = True
    ) -> None:
        self._members, self._unknowns, self._believed = members, unknowns, list(believed)
        self._exact = exact
        self._last: tuple[bytes, list[Floats]] | None = None
        self._steep: _Steep | None = None

    def values(self, unknowns: Floats) -> Floats:
        """See `Predictions`."""
        return np.concatenate([*self._parts(unknowns), unknowns[self._believed]])

    def jacobian(self, unknowns: Floats, *, rough: bool = False) -> Floats:
        """See `Predictions`."""
        key, rough = unknowns.tobytes(), rough or not self._exact
        if self._steep is None or self._steep.key != key or (self._steep.rough and not rough):
            parts = zip(self._members, self._parts(unknowns), strict=True)
            blocks = [self._slopes(member, here, unknowns, rough=rough) for member, here in parts]
            found = np.concatenate([*blocks, np.eye(len(unknowns))[self._believed]])
            self._steep = _Steep(key, rough, found)
        return self._steep.slopes

    def hold(self, unknowns: Floats) -> None:
        """See `Predictions`: steps of motions."""
        named = self._named(unknowns)
        self._last = self._steep = None
        for member in self._members:
            member.hold(member.numbers(named))

    def _parts(self, unknowns: Floats) -> list[Floats]:
        """Return the values of every member; the last ones are kept, beside which derivatives are taken."""
        key = unknowns.tobytes()
        if self._last is None or self._last[0] != key:
            named = self._named(unknowns)
            self._last = key, [self._of_member(member, named) for member in self._members]
        return self._last[1]

    def _named(self, unknowns: Floats) -> dict[str, float]:
        return {one.name: float(value) for one, value in zip(self._unknowns, unknowns, strict=True)}

    def _of_member(self, member: Member, named: Mapping[str, float]) -> Floats:
        return np.concatenate([member.predicted(record, named) for record in member.records])

    def _slopes(self, member: Member, here: Floats, unknowns: Floats, *, rough: bool) -> Floats:
        """Return the derivatives of what a case says of its records, by the unknowns."""
        named = self._named(unknowns)
        compared = [member.compared(record, named) for record in member.records]
        own = [record.by_nuisances(one, named) for record, one in zip(member.records, compared, strict=True)]
        results = any(record.analysis != "material" for record in member.records)
        exact = member.derivatives(member.numbers(named)) if results and not rough else {}
        out = np.zeros((len(here), len(unknowns)))
        for k, one in enumerate(self._unknowns):
            key = member.key_of(one.name)
            if key is None:
                begin = 0
                for slopes, record in zip(own, member.records, strict=True):
                    end = begin + len(record.observed)
                    if one.name in slopes:
                        out[begin:end, k] = slopes[one.name]
                    begin = end
            elif key in exact:
                readings = [partial(record.predicted, nuisances=named) for record in member.records]
                out[:, k] = np.concatenate([exact[key].of(reading) for reading in readings])
            else:
                out[:, k] = self._difference(member, here, unknowns, k, rough=rough)
        return out

    def _difference(self, member: Member, here: Floats, unknowns: Floats, k: int, *, rough: bool) -> Floats:
        """Return the derivatives of what a case says by an unknown of its, by other results."""
        named, one = self._named(unknowns), self._unknowns[k]
        one_sided = rough or bool(member.step_ends)
        part = OF_HELD if member.step_ends else ONE_SIDED if rough else STEP
        step = part * (abs(unknowns[k]) if one.logarithmic else one.scale)
        if one_sided and unknowns[k] + step > one.high:
            step = -step
        high = unknowns[k] + step if one_sided else min(unknowns[k] + step, one.high)
        low = unknowns[k] if one_sided else max(unknowns[k] - step, one.low)
        above = self._of_member(member, {**named, one.name: high})
        below = here if one_sided else self._of_member(member, {**named, one.name: low})
        return np.asarray((above - below) / (high - low))
