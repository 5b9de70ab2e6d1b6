"""The search for an equilibrium: load steps first, then settling where they fail or end at an unstable one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from viscorod.analyses.discrete import DiscreteModel, named, unheld
from viscorod.mechanics.rotations.quaternion import (
    conjugate,
    from_matrices,
    matrices,
    product,
    rotation_vector,
)
from viscorod.solve.constraints.free_motion import FreeMotion
from viscorod.solve.constraints.parts import many_parts
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.formulations.system import State
from viscorod.solve.statics.newton import Outcome, interruption
from viscorod.solve.statics.settling import FAR, Settling, SettlingReport
from viscorod.solve.statics.stability import Stability, circulatory, stability_of
from viscorod.solve.statics.static_solver import StaticPath

__all__ = ["Search"]

FULL_TURN = 2.0 * math.pi * (1.0 + 1e-9)
"""Prescribed rotation [rad] beyond which an unstable equilibrium is kept: no contact keeps the turns of a wound rod."""

TORN = f"parts of it moved by more than {FAR:g} times its size; check the loads against the stiffness, and their units"
"""What is said where a model that supports hold is pulled apart."""

TURNED, TOGETHER, FLAT = 0.1, 0.9, 1e-4
"""Angle [rad] by which a model has turned as a whole that is told; part of it that does so together; part of the larger
spread of its places below which they are in a line."""

CRUSHED = -0.1
"""Stretch below which a straight rod is one that load steps have crushed: beyond what the material law is meant for."""


def turned_together(before: State, after: State, loose: Sequence[FreeMotion]) -> float:
    """Return the angle [rad] by which a model has turned as a whole about axes that supports leave free; 0 if not.

    By its sections or its places. What supports turn it by as they move, across those axes, does not count.
    The mean rotation of the sections is that whose outer products are the mean ones (Markley et al. 2007); that of the
    places is the rotation that brings them nearest to where they are (Kabsch 1976), unless they are in a line.
    """
    turns = product(after.q, conjugate(before.q))
    weights, axes = np.linalg.eigh(turns.T @ turns / len(turns))
    frames = matrices(before.q)
    free = np.array([np.einsum("nij,nj->i", frames, motion.increments[:, 3:]) for motion in loose])
    free = np.linalg.svd(free, full_matrices=False)[2]
    angle = float(np.linalg.norm(free @ rotation_vector(axes[:, -1]))) if weights[-1] > TOGETHER else 0.0
    was, now = (r - r.mean(axis=0) for r in (before.r, after.r))
    left, sizes, right = np.linalg.svd(was.T @ now)
    if sizes[1] > FLAT * sizes[0]:
        sign = np.sign(np.linalg.det(left @ right))
        turn = left @ np.diag([1.0, 1.0, sign]) @ right
        if np.linalg.norm(was @ turn - now) < (1.0 - TOGETHER) * np.linalg.norm(was):
            angle = max(angle, float(np.linalg.norm(free @ rotation_vector(from_matrices(turn.T[None])[0]))))
    return angle


OnStep = Callable[[float, State, int], None]


@dataclass
class Search:
    """One search, and how it went.

    Attributes:
        discrete: the model, whose stage is begun.
        factor: multiple of loads and motions, or of what the stage changes; before: time t = 0-, else 0+.
        allowed: whether it may go on by settling; forced: whether where rotations of more than a full turn are
            prescribed too; wound: whether it did not, because there are.
        loose: motions that loads hold elsewhere only.
        origin: where it begins, in words; near: a state near by, which settling tries before it begins there;
            resumed: whether this led to the result.
        steps: the load steps; settling: what came after them, None if it was not needed.
        turned: angle [rad] by which the model has turned as a whole, where supports at several places let it.
        stability: of the equilibrium at the end.
    """

    discrete: DiscreteModel
    factor: float = 1.0
    before: bool = True
    allowed: bool = True
    forced: bool = False
    wound: bool = False
    loose: list[FreeMotion] = field(default_factory=list)
    origin: str = "the reference shape"
    near: State | None = None
    resumed: bool = False
    steps: StaticPath = field(default_factory=StaticPath)
    settling: SettlingReport | None = None
    turned: float = 0.0
    stability: Stability = field(default_factory=lambda: Stability(0, 0, False))

    def run(self, state: State, *, stops: Sequence[float] = (), on_step: OnStep | None = None) -> bool:
        """Move ``state`` to an equilibrium; returns whether it was found.

        Args:
            state: start; overwritten by the last equilibrium that was found.
            stops: load factors at which steps end, before the last one; on_step: called after each of them.

        Raises:
            InputError: nothing holds the model.
        """
        static, start = self.discrete.static, state.copy()
        if not self.loose:
            static.restore(state, 0.0, before=self.before, scale=0.0)
            self.steps = static.solve(
                state, before=self.before, factor=self.factor, stops=stops, on_step=on_step
            )
            if self.steps.outcome is Outcome.INTERRUPTED:
                return False
            if self.steps.outcome is Outcome.COMPLETED:
                self.stability = stability_of(
                    static, state, before=self.before, scale=self.factor, solved=True
                )
                loads = static.loads.at(0.0, self.before, self.factor)
                self._restore(state)
                self.wound = self.stability.unstable > 0 and not self.forced and self._is_wound()
                if self.stability.unstable == 0 or not self.allowed or circulatory(loads) or self.wound:
                    return True
            if self.coarse or (self.steps.outcome is Outcome.INSIDE_OUT and not self._moves()):
                return False
        if not (self.allowed and self._settle(start, state)):
            return False
        problem = self.discrete.problem
        hung = len(set(problem.supports.nodes.tolist())) < 2  # as a pendulum is, to swing where it likes
        if self.loose and not hung and not any(rod.is_cable for rod in self.discrete.model.rods.values()):
            self.turned = turned_together(start, state, self.loose)
        return True

    def _moves(self) -> bool:
        """Return whether motions are prescribed, with which other shapes than the straight one may go."""
        return self.discrete.supports.moving or bool(self.discrete.problem.joints.motions)

    def _is_wound(self) -> bool:
        """Return whether more than a full turn is prescribed, and rods are not crushed beside that."""
        if float(self.discrete.system.gauss_points().strain[:, 2].min()) < CRUSHED:
            return False
        supports, constraints = self.discrete.supports, self.discrete.system.constraints
        return max(supports.largest_turn, constraints.largest_turn) > FULL_TURN

    def _settle(self, start: State, state: State) -> bool:
        """Settle from ``start``; without success ``state`` stays where load steps led."""
        static, led = (
            self.discrete.static,
            self.steps.outcome is Outcome.COMPLETED and bool(self.steps.factors),
        )
        unloaded = static.loads.at(0.0, self.before, self.factor).none
        tries = [(start, 0.0, careful) for careful in ((True,) if unloaded else (False, True))]
        if self.near is not None:
            tries.insert(0, (self.near, 1.0, False))
        for begun, motion, careful in tries:
            settling = Settling(static, before=self.before, factor=self.factor, careful=careful)
            self.settling = settling.report
            at = begun.copy()
            try:
                settling.run(at, motion=motion)
            except KeyboardInterrupt as asked:
                self.steps.outcome, self.steps.reason = Outcome.INTERRUPTED, interruption(asked)
                return False
            if settling.report.found or (begun is start and (settling.report.falls or not settling.moving)):
                break
        if settling.report.found:
            state.set(at)
            self.resumed = begun is self.near
            if settling.downhill:  # neutral motions are none that leave
                self.stability = Stability(settling.report.unstable, settling.report.unstable, False)
            else:
                self.stability = stability_of(
                    self.discrete.static, state, before=self.before, scale=self.factor
                )
            self._restore(state)
            return True
        if settling.report.falls:
            free = self.loose or free_motions(self.discrete.problem)
            if free:
                raise unheld(free, settling.report.reason)
            settling.report.reason = TORN
        if led:
            self._restore(state)
        return led

    def _restore(self, state: State) -> None:
        self.discrete.static.restore(state, 0.0, before=self.before, scale=self.factor)

    @property
    def settled(self) -> bool:
        """Whether it was found by settling."""
        return self.settling is not None and self.settling.found

    @property
    def coarse(self) -> bool:
        """Whether it failed where elements cannot tell any more which way their nodes turn."""
        return self.steps.outcome is Outcome.WRAPPED

    @property
    def count(self) -> int:
        """Steps that were taken."""
        return len(self.steps.factors) + (0 if self.settling is None else self.settling.steps)

    @property
    def iterations(self) -> int:
        """Newton iterations that were taken."""
        done = sum(self.steps.iterations) + self.steps.wasted
        return done + (0 if self.settling is None else self.settling.iterations)

    @property
    def found_by(self) -> str:
        """How the equilibrium was found, in words."""
        if not self.settled:
            count = len(self.steps.factors)
            return f"{count} load step{'s' if count != 1 else ''} from {self.origin}"
        assert self.settling is not None
        if self.loose:
            why = f"supports leave it {named(self.loose)}"
        elif self.steps.outcome is Outcome.COMPLETED:
            why = "load steps ended at an unstable equilibrium"
        else:
            why = f"load steps found none beyond {self._reached:.4g} of the loads"
        text = (
            f"settling from {self.origin} ({why}): pseudo-transient continuation, {self.settling.steps} steps"
        )
        if self.resumed:
            text += " on from that of a coarser mesh"
        if self.settling.knocks:
            text += f", off {self.settling.knocks} unstable"
        return f"{text}; where several equilibria are stable, this is one of them"

    @property
    def fallen(self) -> list[str]:
        """A warning where the model has turned as a whole because supports let it."""
        if self.turned <= TURNED:
            return []
        return [
            f"supports leave it {named(self.loose)}, and it has turned by {math.degrees(self.turned):.3g} degrees "
            "from where it was drawn, to where the loads hold it; if that is not meant, hold the rotation at a "
            "support (such as rx)"
        ]

    @property
    def doubts(self) -> list[str]:
        """Warnings about an equilibrium that was found."""
        if self.wound:
            return [
                f"the equilibrium is unstable ({self.stability.unstable} negative eigenvalues); no stable one was "
                "sought, because rotations of more than a full turn are prescribed, and rods may pass "
                "through each other then (search = true seeks one)"
            ]
        if self.fallen:
            return self.fallen
        if self.settling is None or self.settling.found or self.stability.unstable == 0:
            return []
        return [
            f"the equilibrium is unstable ({self.stability.unstable} negative eigenvalues), and the search for a "
            f"stable one ended without any: {self.settling.reason}"
        ]

    @property
    def _reached(self) -> float:
        return self.steps.factors[-1] if self.steps.factors else 0.0

    def failure(self) -> str:
        """Say why none was found, and what to try."""
        path, discrete, reached = self.steps, self.discrete, self._reached
        if path.outcome is Outcome.INTERRUPTED:
            return f"Stopped at {reached:.6g} of the loads (trying {path.load_level:.6g}): {path.reason}"
        text = ""
        if path.report is not None:
            text = (
                f"No equilibrium beyond {reached:.6g} of the loads (tried {path.load_level:.6g}): {path.outcome.value}."
                f"{discrete.where(path.report)} What to try: {path.outcome.advice(static=True)}."
            )
        if self.settling is not None:
            text += (
                f" Settling from {self.origin} found no stable equilibrium either: {self.settling.reason}."
            )
        gaps = discrete.system.constraints.open_joints(1.0 - reached)
        if gaps:
            text += f" Joints that are open in the reference shape could not be closed; still open: {', '.join(gaps)}."
        free = [] if many_parts(discrete.problem) else free_motions(discrete.problem)
        if free:
            text += f" Free rigid motions: {named(free)}."
        return text.strip()
