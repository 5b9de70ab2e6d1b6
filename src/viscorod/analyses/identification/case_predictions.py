"""What cases say of records, by the unknowns, and the derivatives of that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from viscorod.analyses.identification.members import Member
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["CasePredictions"]

STEP = 1e-3
"""Part of a number (or of its scale) by which it is changed to either side for a difference."""
ACCURACY = 1e-4
"""Relative error of derivatives by differences."""
ONE_SIDED = 3e-4
"""The same as :data:`STEP` of differences to one side, by which a search is led; they err by some 1e-3."""
OF_HELD = 3e-6
"""The same of motions with held steps, to one side: 1e-4 is left of the curvature and of the iteration of steps."""


class CasePredictions:
    """Predictions of all records by all unknowns, and of what was believed beforehand.

    Derivatives by numbers of a case are central differences of results on one mesh; those by numbers of a
    measurement need no further result.
    """

    accuracy = ACCURACY

    def __init__(self, members: Sequence[Member], unknowns: Unknowns, believed: Sequence[int]) -> None:
        self._members, self._unknowns, self._believed = members, unknowns, list(believed)
        self._last: tuple[bytes, list[Floats]] | None = None
        self._steep: dict[int, tuple[bytes, Floats]] = {}  # slopes of members whose steps are held

    def values(self, unknowns: Floats) -> Floats:
        """See `Predictions`."""
        return np.concatenate([*self._parts(unknowns), unknowns[self._believed]])

    def jacobian(self, unknowns: Floats, *, rough: bool = False) -> Floats:
        """See `Predictions`."""
        blocks = []
        for k, (member, here) in enumerate(zip(self._members, self._parts(unknowns), strict=True)):
            key = unknowns.tobytes()
            found = self._steep.get(k)
            if found is None or found[0] != key or not member.step_ends:
                found = key, self._slopes(member, here, unknowns, rough=rough)
                self._steep[k] = found
            blocks.append(found[1])
        return np.concatenate([*blocks, np.eye(len(unknowns))[self._believed]])

    def hold(self, unknowns: Floats) -> None:
        """See `Predictions`: steps of motions."""
        named = self._named(unknowns)
        self._last = None
        self._steep.clear()
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
        named = self._named(unknowns)
        own = [record.by_nuisances(member.compared(record, named), named) for record in member.records]
        sizes = [len(record.observed) for record in member.records]
        out = np.zeros((sum(sizes), len(unknowns)))
        for k, one in enumerate(self._unknowns):
            if member.key_of(one.name) is not None:
                one_sided = rough or bool(member.step_ends)
                part = OF_HELD if member.step_ends else ONE_SIDED if rough else STEP
                step = part * (abs(unknowns[k]) if one.logarithmic else one.scale)
                if one_sided and unknowns[k] + step > one.high:
                    step = -step
                high = unknowns[k] + step if one_sided else min(unknowns[k] + step, one.high)
                low = unknowns[k] if one_sided else max(unknowns[k] - step, one.low)
                above = self._of_member(member, {**named, one.name: high})
                below = here if one_sided else self._of_member(member, {**named, one.name: low})
                out[:, k] = (above - below) / (high - low)
            else:
                begin = 0
                for slopes, size in zip(own, sizes, strict=True):
                    if one.name in slopes:
                        out[begin : begin + size, k] = slopes[one.name]
                    begin += size
        return out
