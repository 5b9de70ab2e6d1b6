"""Collocation of models that differ little, side by side: the first one leads, and the others use what it found.

Where their steps end at the same times, what the prediction of a step lacks is nearly the same for all, and so are the
factors: what follows needs some iterations, and no factorisation. They share its frozen Jacobian as well, which the
iteration takes stresses along by; with joints, held strains, or strains as states each keeps one of its own, as old as
that of the leader. What predictions lack is nearly linear in a number, so that of two models with one number changed
to both sides the second one's follows from the first one's, to second order, and between the first two is that of no
change.

With joints or held strains the midpoint rule ends a step with velocities that are wrong to second order, and corrects
them with the matrix of the step before they are recorded. So much depends on that matrix, and on its age, that each
goes as by itself there, with factors of its own; only the ages of all are those of the leader.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.transient.integrators.collocation import Collocation
    from viscorod.solve.transient.integrators.stage_data import Matrices
    from viscorod.solve.transient.integrators.stage_systems import StageSystems

__all__ = ["LEFT", "Company", "Member", "predicted_rows"]

LEFT = 1e-15
"""Left by the iteration (displacement over model length, rotation in rad): it goes on until nothing improves."""


STALE = 0.005
"""Convergence rate of the leader from which on Jacobians are renewed: all iterate far."""
UNCHANGED = -1
"""In the place of a number: a model in which none is changed."""
NOTHING = np.zeros(0)


class Member(NamedTuple):
    """Which number a model differs by, and by how much."""

    number: int
    change: float


class Company:
    """Integrators that take the same steps; in every step the leader is the first to do so.

    Args:
        leader: of the same method as those that follow; member: what it is.

    Attributes:
        shares: whether its Jacobian serves all.
    """

    def __init__(self, leader: Collocation, member: Member) -> None:
        self.leader = leader
        # the midpoint rule, whose ends of steps are corrected
        self._ages_only = leader.stage_constraints is not None and len(leader.ends.r) > 0
        self.shares = leader.stage_constraints is None and leader.forces.motion is None
        leader.company = self
        if not self._ages_only:
            leader.stale = STALE
        self.followers: list[Collocation] = []
        self._members: dict[int, Member] = {id(leader): member}
        self._first: dict[int, Member] = {member.number: member}
        self._lacks: dict[int, Floats] = {}  # of the first member of each number, and where nothing changes
        self._of: tuple[Collocation, Floats] | None = None  # who tried last, and what was predicted
        self._jacobians: dict[int, int] = {}  # of the leader, when those that follow had theirs
        self._begun: dict[int, float] = {}
        self._own: dict[int, tuple[StageSystems, Matrices]] = {}
        self._again = False

    def join(self, one: Collocation, member: Member) -> None:
        """Let an integrator follow, which has not begun."""
        one.company = self
        self.followers.append(one)
        self._members[id(one)] = member
        self._first.setdefault(member.number, member)
        self._own[id(one)] = one.systems, one.matrices

    def begin(self, one: Collocation) -> bool | None:
        """Begin a step.

        Returns:
            whether one that follows has a Jacobian that is as old as that of the leader; None of the leader itself, and
            of one that tries the step again. False of a leader with joints or held strains: recorded states are closed
            with its matrix, which derivatives take as that of the step.
        """
        if not self._ages_only:
            one.newton_tolerance = LEFT
        self._again = self._begun.get(id(one)) == one.t
        if self._again:
            return None
        self._begun[id(one)] = one.t
        if one is self.leader:
            return None if one.stage_constraints is None or self._ages_only else False
        if not self._ages_only:
            self._solve_with(one, self.leader.systems, self.leader.matrices)
        have = self.shares or self.up_to_date(one)
        self._jacobians[id(one)] = self.leader.jacobians
        return have

    def up_to_date(self, one: Collocation) -> bool:
        """Return whether the Jacobian of one that follows is as old as that of the leader."""
        return self._jacobians.get(id(one)) == self.leader.jacobians

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
            self._solve_with(one, *self._own[id(one)])
            self.leader.forget_jacobian()
            return False
        return not self._ages_only and self.leader.factors_of(h)

    def _solve_with(self, one: Collocation, systems: StageSystems, matrices: Matrices) -> None:
        one.systems = one.recorder.systems = systems
        if self.shares:
            one.matrices = matrices

    def correct(self, one: Collocation) -> None:
        """Correct the predicted stages by what those of others lacked, but for a step that is tried again.

        A first change next to round-off can be less than the second one, as if the iteration diverged.
        """
        if self._ages_only:
            return
        rows = predicted_rows(one)
        if one is self.leader:
            self.forget()
        elif self._of is not None and self._of[0] is not one:
            other, predicted = self._of
            self.learn(other, np.concatenate(predicted_rows(other)) - predicted)
        self._of = one, np.concatenate(rows)
        if one is self.leader or self._again:
            return
        lack, at = np.empty(sum(map(len, rows))), 0
        self.expect(one, lack)
        for row in rows:
            np.add(row, lack[at : at + len(row)], out=row)
            at += len(row)

    def forget(self) -> None:
        """Forget what predictions of the last step lacked: the leader begins another one."""
        self._lacks.clear()
        self._of = None

    def learn(self, one: Collocation, lacked: Floats) -> None:
        """Keep what the prediction of an integrator ``lacked`` in this step, as one row of numbers."""
        leading, (number, change) = self._members[id(self.leader)], self._members[id(one)]
        if number not in self._lacks:
            self._lacks[number] = lacked
        elif number == leading.number and UNCHANGED not in self._lacks and change != leading.change:
            first, part = self._lacks[number], leading.change / (leading.change - change)
            self._lacks[UNCHANGED] = first + part * (lacked - first)

    def expect(self, one: Collocation, lack: Floats) -> None:
        """Write what the prediction of a follower will lack."""
        number, change = self._members[id(one)]
        unchanged = self._lacks.get(UNCHANGED)
        if unchanged is None:
            lack[:] = self._lacks[self._members[id(self.leader)].number]
            return
        earlier, first = self._lacks.get(number), self._first[number]
        if earlier is None or first.change == 0.0:
            lack[:] = unchanged
            return
        np.subtract(earlier, unchanged, out=lack)
        lack *= change / first.change
        lack += unchanged

    # --- steps that are taken in compiled calls

    def lend(self) -> None:
        """Let all that follow solve with the factors of the leader, and its Jacobian where it is shared."""
        for one in self.followers:
            self._solve_with(one, self.leader.systems, self.leader.matrices)

    def take_back(self, up_to_date: Sequence[Collocation]) -> None:
        """Go on step by step; some followers have a Jacobian as old as that of the leader."""
        for one in self.followers:
            self._jacobians[id(one)] = self.leader.jacobians if one in up_to_date else -1


def predicted_rows(one: Collocation) -> tuple[Floats, ...]:
    """Return what is predicted of a step, as rows of numbers, which may be written to."""
    links = one.stage_constraints
    joints = (NOTHING, NOTHING)
    if links is not None:
        joints = links.arrays.states.multiplier, links.arrays.states.carried
    return tuple(values.reshape(-1) for values in (one.stages.X, one.stages.stress, *joints))
