"""Settling: from any state downhill to a stable equilibrium, as a thing sinks in a thick fluid.

Pseudo-transient continuation (Kelley and Keyes 1998, SIAM J. Numer. Anal. 35): a flow against a drag is followed by
implicit steps (see ``drag_flow``). As their ``mu`` falls they become those of Newton's method.

Where loads have a potential the flow runs downhill in it. An equilibrium is taken if the tangent stiffness has no
negative eigenvalue there (Sylvester's law of inertia); else it is left along its fastest way, and near it steps keep
``K + mu A`` positive definite: so they are minima of the potential plus ``mu/2 d.A d``, which never lead back.

Loads act in full from the beginning while prescribed motions, gaps of joints included, grow from step to step: slack
ropes sag before their ends approach. Where nothing but motions acts, a flow may follow a straight path far beyond where
it branches; a careful one looks for the first bifurcation on its way and leaves the path there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.drag_flow import LARGEST, LOOSE, DragFlow, FlowStep
from viscorod.solve.statics.stability import circulatory
from viscorod.solve.statics.static_solver import StaticSolver

__all__ = ["FAR", "Settling", "SettlingReport"]

NEUTRAL = 1e-5
"""Drag, as a part of the first, that neutral motions have at the end: a rod that hangs on a ball may spin."""
LARGEST_TURN = 0.5
"""Largest prescribed rotation of a step [rad]."""
WANTED = 0.3
"""Size of step that is aimed at."""
FOLLOWING = 1.1
"""Size of a step over that of the prescribed motion below which nothing but this has moved so far."""
NEAR = 0.3
"""Distance from an unstable equilibrium below which a step is not to be so long that it leads back there."""
STILL = 1e-2
"""Size of a step below which Newton's method is tried on the equilibrium itself."""
CREEP = 30
"""Steps at most with hardly any drag."""
STEPS = 500
FAR = 100.0
"""Displacement over the size of the model beyond which nothing holds it."""
FEW, FAINT, LEAST_GROWTH = 2, 1e-3, 1e-9
"""Of a careful flow: ways in which it may leave a state at most, size of the displacement by which it does, and least
growth of motions in a step."""
KNOCK = 0.05
"""Size of the displacement by which an unstable equilibrium is left."""


@dataclass
class SettlingReport:
    """What it took.

    Attributes:
        found: a stable equilibrium, or any where loads have no potential.
        steps, rejected, iterations: of the flow; knocks: unstable equilibria that were left.
        reason: why none was found; falls: nothing holds it.
        unstable: negative eigenvalues at the end, where loads have a potential.
    """

    found: bool = False
    steps: int = 0
    rejected: int = 0
    iterations: int = 0
    knocks: int = 0
    reason: str = ""
    falls: bool = False
    unstable: int = 0


class Settling:
    """Follows the flow of one static problem.

    Args:
        static: solves it. t, before: time at which loads and motions are taken; factor: their multiple.
        careful: look for the first bifurcations while motions grow, and leave the straight path there.

    Attributes:
        downhill: loads have a potential, in which the flow runs downhill.
        moving: motions are prescribed, or joints open.
    """

    def __init__(
        self,
        static: StaticSolver,
        t: float = 0.0,
        *,
        before: bool = True,
        factor: float = 1.0,
        careful: bool = False,
    ) -> None:
        self.static, self.careful = static, careful
        self.flow = DragFlow(static, t, before=before, factor=factor)
        self.downhill = not circulatory(static.loads.at(t, before, factor))
        self.report = SettlingReport()
        self.motion = 0.0
        self.moving = False
        self._saddle: State | None = None

    def run(self, state: State, *, motion: float = 0.0) -> SettlingReport:
        """Move ``state`` to an equilibrium.

        Args:
            state: start, overwritten by the equilibrium if one is found.
            motion: part of the prescribed motions and gaps at the start.
        """
        report, x = self.report, state.copy()
        self._start(x, motion)
        first, tried = x.r.copy(), STILL
        ready = self.careful or not self.moving  # else loads settle before motions grow
        while report.steps + report.rejected < STEPS:
            self.static.check_interrupt()
            goal = min(1.0, self.motion + (self._growth if ready else 0.0))
            # of the size, what is prescribed and no drag holds back
            own = (goal - self.motion) * self.flow.turn
            trial, size, iterations = self._step(x, self._mu, goal)
            report.iterations += iterations
            count = 0 if trial is None else self._unstable_on_the_way(trial, goal)
            if trial is None or (count > FEW and self._growth > LEAST_GROWTH):
                self._shorten(size, own)
                if not self._mu < 1e30 * self._least:
                    report.reason = "no step was small enough"
                    return report
                continue
            report.steps += 1
            x, self.motion = trial, goal
            ready = ready or size < STILL
            self._lengthen(size, own, iterations)
            if count:
                self._knock(x, FAINT)
                continue
            if np.abs(x.r - first).max() > FAR * self.flow.span:
                report.reason, report.falls = "it falls without end", True
                return report
            if self.motion == 1.0 and size < tried:
                left = report.knocks
                if self._finish(x):
                    state.set(x)
                    report.found = True
                    return report
                tried = 0.1 * (size if report.knocks == left else STILL)  # off a saddle the way begins anew
        report.reason = f"it did not come to rest in {STEPS} steps"
        return report

    def _start(self, x: State, motion: float) -> None:
        """Choose the first step."""
        self.motion = motion
        self.moving = self.flow.motions_from(motion)
        self._most = min(0.1, LARGEST_TURN / max(self.flow.turn, LARGEST_TURN))
        self._growth = 0.5 * self._most if self.moving else 1.0
        self.motion = motion if self.moving else 1.0
        self._mu = self.flow.first_drag(x, self.motion)
        self._neutral, self._least, self._floor = NEUTRAL * self._mu, 1e-14 * self._mu, 0.0

    def _shorten(self, size: float, own: float) -> None:
        """Shorten the next step after one that failed: one of some ``size``, or 0 without any.

        Motions grow by as much less as the step is shorter in the time of the flow: else they would outrun it, and
        crush what is next to them.
        """
        self.report.rejected += 1
        less = 2.0
        if not 0.0 < size < FOLLOWING * own:
            if size:
                self._floor = 1.5 * self._mu
            less = 2.0 if size else 4.0
            self._mu *= less
        self._growth = max(self._growth / less, LEAST_GROWTH)

    def _lengthen(self, size: float, own: float, iterations: int) -> None:
        """Choose the next step by how easy the last one was."""
        easy = 0.1 if iterations <= 4 else 0.5
        free = 0.0 if size < FOLLOWING * own else size
        last = self._mu
        self._mu = max(last * min(max(easy, free / WANTED), 2.0), self._floor, self._least)
        longer = min(max(last / self._mu, 1.2), 4.0) if size < WANTED else 0.5
        self._growth = min(longer * self._growth, self._most)
        self._floor *= 0.7

    def _unstable_on_the_way(self, x: State, goal: float) -> int:
        """Return the number of ways in which a careful flow may leave a state while motions grow; 0 once it has."""
        if not self.careful or not self.downhill or self.report.knocks or goal == 1.0:
            return 0
        return self.flow.unstable(x, self._neutral)

    def _step(self, start: State, mu: float, goal: float, accuracy: float = LOOSE) -> FlowStep:
        """Take a step of the flow; one that leads back to an unstable equilibrium fails."""
        found = self.flow.step(start, mu, (self.motion, goal), accuracy)
        if found.end is not None and self._near_saddle(found.end) and self.flow.unstable(found.end, mu):
            return found._replace(end=None)
        return found

    def _near_saddle(self, x: State) -> bool:
        if self._saddle is None or not self.downhill:
            return False
        return (self.careful and self.motion < 1.0) or distance(x, self._saddle, self.flow.span) < NEAR

    def _finish(self, x: State) -> bool:
        """Move ``x`` to the equilibrium nearby; knock it off an unstable one.

        Returns:
            whether it is at a stable equilibrium.
        """
        static, report, flow = self.static, self.report, self.flow
        trial = x.copy()
        static.restore(trial, flow.t, before=flow.before, scale=flow.factor)
        newton = static.newton(trial, flow.t, before=flow.before, scale=flow.factor)
        report.iterations += newton.iterations
        if not (newton.converged and self._near(trial, x)):
            trial = x.copy()
            if not (self._creep(trial) and self._near(trial, x)):
                return False
        x.set(trial)
        flow.place(1.0)
        flow.begin(x)
        report.unstable = flow.unstable(x, self._neutral)
        if not self.downhill or report.unstable == 0:
            static.restore(x, flow.t, before=flow.before, scale=flow.factor)
            return True
        self._knock(x, KNOCK)
        return False

    def _near(self, a: State, b: State) -> bool:
        return bool(np.abs(a.r - b.r).max() <= LARGEST * self.flow.span) and not self.flow.jumped(b, a)

    def _creep(self, x: State) -> bool:
        """Move ``x`` to the equilibrium with a little drag, which keeps neutral motions where they are."""
        for _ in range(CREEP):
            trial, size, iterations = self._step(x, self._neutral, 1.0, self.static.tolerance)
            self.report.iterations += iterations
            if trial is None:
                return False
            x.set(trial)
            if size <= 2.0 * self.static.tolerance:
                return True
        return False

    def _knock(self, x: State, size: float) -> None:
        """Displace an unstable equilibrium by some ``size`` along the way in which the flow leaves it fastest.

        Where several are as fast, such as those of a strut that may buckle to all sides, it is the first of those along
        the global axes z, y, x.
        """
        self.report.knocks += 1
        mu = self._neutral
        while self.flow.unstable(x, mu):
            mu *= 4.0
        ways = [self.flow.fastest(x, mu, axis) for axis in range(4)]
        fastest = min(rate for rate, _ in ways)
        way = next(way for rate, way in ways if rate <= fastest + 1e-3 * abs(fastest))
        self._saddle = x.copy()
        retract(x.r, x.q, size * way, x.r, x.q)
        self._mu = max(self._mu, 4.0 * mu)


def distance(a: State, b: State, length: float) -> float:
    """Return the largest displacement over ``length``, or rotation [rad], between two states."""
    cosine = np.minimum(np.abs(np.sum(a.q * b.q, axis=1)), 1.0)
    return max(float(np.abs(a.r - b.r).max()) / length, float(2.0 * np.arccos(cosine).max()))
