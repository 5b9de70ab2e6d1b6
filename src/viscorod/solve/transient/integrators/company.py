"""Collocation of models that differ little, side by side: the first one leads, and the others use what it found.

Where their steps end at the same times, what the prediction of a step lacks is nearly the same for all, and so are the
factors: what follows needs some iterations, and no factorisation. Each keeps a Jacobian of its own, as old as that of
the leader. What predictions lack is nearly linear in a number, so that of two models with one number changed to both
sides the second one's follows from the first one's, to second order, and between the first two is that of no change.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.transient.integrators.collocation import Collocation
    from viscorod.solve.transient.integrators.stage_systems import StageSystems

__all__ = ["Company", "Member"]

LEFT = 1e-15
"""Left by the iteration (displacement over model length, rotation in rad): it goes on until nothing improves."""


STALE = 0.05
"""Convergence rate of the leader from which on Jacobians are renewed: all iterate far."""
UNCHANGED = -1
"""In the place of a number: a model in which none is changed."""


class Member(NamedTuple):
    """Which number a model differs by, and by how much."""

    number: int
    change: float


class Company:
    """Integrators that take the same steps; in every step the leader is the first to do so.

    Args:
        leader: of the same method as those that follow; member: what it is.
    """

    def __init__(self, leader: Collocation, member: Member) -> None:
        self.leader = leader
        leader.company, leader.stale = self, STALE
        self._members: dict[int, Member] = {id(leader): member}
        self._lacks: dict[
            int, list[Floats]
        ] = {}  # of the first member of each number, and where nothing changes
        self._of: tuple[Collocation, list[Floats]] | None = None  # who tried last, and what was predicted
        self._jacobians: dict[int, int] = {}  # of the leader, when those that follow had theirs
        self._begun: dict[int, float] = {}
        self._own: dict[int, StageSystems] = {}
        self._again = False

    def join(self, one: Collocation, member: Member) -> None:
        """Let an integrator follow, which has not begun."""
        one.company = self
        self._members[id(one)] = member
        self._own[id(one)] = one.systems

    def begin(self, one: Collocation) -> bool | None:
        """Begin a step.

        Returns:
            whether the Jacobian of one that follows is as old as that of the leader; None of the leader itself, and of
            one that tries the step again. False of a leader with joints or held strains: recorded states are closed
            with its matrix, which derivatives take as that of the step.
        """
        one.newton_tolerance = LEFT
        self._again = self._begun.get(id(one)) == one.t
        if self._again:
            return None
        self._begun[id(one)] = one.t
        if one is self.leader:
            return None if one.stage_constraints is None else False
        self._solve_with(one, self.leader.systems)
        seen = self._jacobians.get(id(one))
        self._jacobians[id(one)] = self.leader.jacobians
        return seen == self.leader.jacobians

    def helped(self, one: Collocation) -> bool:
        """Return whether the leader had part in what has just been tried."""
        return one is not self.leader and not self._again

    def lends_factors(self, one: Collocation, h: float) -> bool:
        """Return whether the factors of the leader serve for a step of ``h`` [s]: not if it is tried again.

        The Jacobian is a new one then, and all renew theirs in the next step.
        """
        if one is self.leader:
            return False
        if self._again:
            self._solve_with(one, self._own[id(one)])
            self.leader.forget_jacobian()
            return False
        return self.leader.factors_of(h)

    def _solve_with(self, one: Collocation, systems: StageSystems) -> None:
        one.systems = one.recorder.systems = systems

    def correct(self, one: Collocation) -> None:
        """Correct the predicted stages by what those of others lacked, but for a step that is tried again.

        A first change next to round-off can be less than the second one, as if the iteration diverged.
        """
        mine = _predicted(one)
        if one is self.leader:
            self._lacks.clear()
        elif self._of is not None and self._of[0] is not one:
            self._learn(*self._of)
        self._of = one, [values.copy() for values in mine]
        if one is self.leader or self._again:
            return
        for values, lack in zip(mine, self._expected(self._members[id(one)]), strict=True):
            np.add(values, lack, out=values)

    def _learn(self, other: Collocation, predicted: list[Floats]) -> None:
        """Keep what the prediction of another integrator lacked in this step."""
        lacked = [found - before for found, before in zip(_predicted(other), predicted, strict=True)]
        leading, (number, change) = self._members[id(self.leader)], self._members[id(other)]
        if number not in self._lacks:
            self._lacks[number] = lacked
        elif number == leading.number and UNCHANGED not in self._lacks and change != leading.change:
            first, part = self._lacks[number], leading.change / (leading.change - change)
            self._lacks[UNCHANGED] = [a + part * (b - a) for a, b in zip(first, lacked, strict=True)]

    def _expected(self, member: Member) -> list[Floats]:
        """Return what the prediction of a member will lack."""
        number, change = member
        unchanged = self._lacks.get(UNCHANGED)
        if unchanged is None:
            return self._lacks[self._members[id(self.leader)].number]
        earlier, first = self._lacks.get(number), self._first(number)
        if earlier is None or first.change == 0.0:
            return unchanged
        return [a + change / first.change * (b - a) for a, b in zip(unchanged, earlier, strict=True)]

    def _first(self, number: int) -> Member:
        return next(member for member in self._members.values() if member.number == number)


def _predicted(one: Collocation) -> list[Floats]:
    """Return what is predicted of a step."""
    links = one.stage_constraints
    joints = [] if links is None else [links.arrays.states.multiplier, links.arrays.states.carried]
    return [one.stages.X, one.stages.stress, *joints]
