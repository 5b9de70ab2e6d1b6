"""Collocation of models that differ little, side by side: the first one leads, and the others use what it found.

Where their steps end at the same times, what the prediction of a step lacks is nearly the same for all, and so are the
factors: what follows needs one or two iterations, and no factorisation. Each keeps a Jacobian of its own, as old as
that of the leader.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.solve.transient.integrators.collocation import Collocation
    from viscorod.solve.transient.integrators.stage_systems import StageSystems

__all__ = ["Company"]

LEFT = 1e-15
"""Left by the iteration (displacement over model length, rotation in rad): it goes on until nothing improves."""


STALE = 0.05
"""Convergence rate of the leader from which on Jacobians are renewed: all iterate far."""


class Company:
    """Integrators that take the same steps; in every step the leader is the first to do so.

    Args:
        leader: of the same method as those that follow.
    """

    def __init__(self, leader: Collocation) -> None:
        self.leader = leader
        leader.company, leader.stale = self, STALE
        self._predicted: list[Floats] = []
        self._jacobians: dict[int, int] = {}  # of the leader, when those that follow had theirs
        self._begun: dict[int, float] = {}
        self._own: dict[int, StageSystems] = {}
        self._again = False

    def join(self, one: Collocation) -> None:
        """Let an integrator follow, which has not begun."""
        one.company = self
        self._own[id(one)] = one.systems

    def begin(self, one: Collocation) -> bool | None:
        """Begin a step.

        Returns:
            whether the Jacobian of one that follows is as old as that of the leader; None of the leader itself, and of
            one that tries the step again.
        """
        one.newton_tolerance = LEFT
        self._again = self._begun.get(id(one)) == one.t
        if one is self.leader or self._again:
            return None
        self._begun[id(one)] = one.t
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
        one.systems, one.recorder.solve_real = systems, systems.solve_real

    def correct(self, one: Collocation) -> None:
        """Correct the predicted stages by what the prediction of the leader lacked, but for a step that is tried again.

        A first change next to round-off can be less than the second one, as if the iteration diverged.
        """
        mine = _predicted(one)
        if one is self.leader:
            self._predicted = [values.copy() for values in mine]
            return
        if self._again:
            return
        for values, found, predicted in zip(mine, _predicted(self.leader), self._predicted, strict=True):
            np.add(values, found - predicted, out=values)


def _predicted(one: Collocation) -> list[Floats]:
    """Return what is predicted of a step."""
    links = one.stage_constraints
    joints = [] if links is None else [links.arrays.states.multiplier, links.arrays.states.carried]
    return [one.stages.X, one.stages.stress, *joints]
