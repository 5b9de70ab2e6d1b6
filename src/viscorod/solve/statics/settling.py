"""Settling: from any state downhill to a stable equilibrium, as a thing sinks in a thick fluid.

Pseudo-transient continuation (Kelley and Keyes 1998, SIAM J. Numer. Anal. 35): the flow ``A x' = external - internal``
is followed by implicit Euler steps, ``(mu A + K) dx = external - internal - mu A d``, where ``d`` is the way since the
start of the step and ``1/mu`` its length in the time of the flow. ``A`` is like the inertia. As ``mu`` falls the steps
become those of Newton's method.

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
from scipy import sparse

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.mechanics.rotations.rotation import increment_size, retract
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.statics.second_variation import SecondVariation
from viscorod.solve.statics.stability import circulatory
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["FAR", "Settling", "SettlingReport"]

LARGEST = 0.5
"""Largest step: displacement over the length of the model, or rotation in rad."""
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
ITERATIONS = 12
LOOSE = 1e-5
"""Size of the last Newton increment of a step."""
INVERSE = 15
"""Inverse iterations for the fastest way off an unstable equilibrium."""
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
        self.static, self.system, self.supports = static, static.system, static.supports
        self.problem = static.system.problem
        self.t, self.before, self.factor, self.careful = t, before, factor, careful
        self.span = max(self.problem.length, float(np.ptp(self.problem.positions, axis=0).max()))
        self.drag = drag(static)
        self._swapped = np.ascontiguousarray(np.swapaxes(self.drag, 1, 2))
        self.downhill = not circulatory(static.loads.at(t, before, factor))
        self.report = SettlingReport()
        self.motion = 0.0
        self.moving, self._turn = False, 0.0
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
            own = (goal - self.motion) * self._turn  # of the size, what is prescribed and no drag holds back
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
            if np.abs(x.r - first).max() > FAR * self.span:
                report.reason, report.falls = "it falls without end", True
                return report
            if self.motion == 1.0 and size < tried:
                tried = 0.1 * size
                if self._finish(x):
                    state.set(x)
                    report.found = True
                    return report
        report.reason = f"it did not come to rest in {STEPS} steps"
        return report

    def _start(self, x: State, motion: float) -> None:
        """Choose the first step."""
        self.motion = motion
        self.moving, self._turn = self._moves()
        self._most = min(0.1, LARGEST_TURN / max(self._turn, LARGEST_TURN))
        self._growth = 0.5 * self._most if self.moving else 1.0
        self.motion = motion if self.moving else 1.0
        self._mu = self._first(x)
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
        return negative_eigenvalues(self._tangent(x, self._neutral))

    # --- one step

    def _moves(self) -> tuple[bool, float]:
        """Return whether motions are prescribed or joints are open, and by how much they turn in all [rad]."""
        self._place(1.0)
        supports, joints = self.supports.target.copy(), self.system.constraints.driven.copy()
        self._place(self.motion)
        supports -= self.supports.target
        joints -= self.system.constraints.driven
        turn = max(float(np.abs(supports[:, 3:]).max(initial=0.0)), float(np.abs(joints).max(initial=0.0)))
        return bool(supports.any() or joints.any()), turn

    def _place(self, motion: float) -> None:
        self.supports.update(self.t, self.before, motion * self.factor)
        self.system.constraints.update(self.t, self.before, motion * self.factor)

    def _loads(self) -> LoadState:
        return self.static.loads.at(self.t, self.before, self.factor)

    def _begin(self, x: State) -> None:
        """Take the section forces at ``x`` as stress iterate."""
        self.system.assemble(x, self._loads(), None, tangent=False, moving=False)
        self.system.reset_stress()
        self.system.constraints.track_angles()

    def _first(self, x: State) -> float:
        """Return the first ``mu``: the whole imbalance may move the model by a tenth of the largest step."""
        self._place(self.motion)
        self._begin(x)
        residual = self.supports.unbalanced(self.system.residual()[: self.problem.size])
        force = np.abs(residual[:, :3]).max(axis=1) + np.abs(residual[:, 3:]).max(axis=1) / self.span
        mass = np.einsum("nii->ni", self.drag)[:, :3].max(axis=1)
        pace = float((force / mass).max()) / (0.1 * LARGEST * self.span)
        self.system.assemble(x, self._loads(), None, tangent=True, moving=False)
        diagonal = self.problem.pattern.diagonal[: self.problem.size]
        stiff = float(np.abs(np.einsum("nii->ni", self.system.matrix.blocks[diagonal])[:, :3]).sum())
        return max(pace, 1e-9 * stiff / float(mass.sum())) or 1.0

    def _step(
        self, start: State, mu: float, motion: float, accuracy: float = LOOSE
    ) -> tuple[State | None, float, int]:
        """Return the state at the end of a step, None if it failed, its size and the iterations that it took."""
        system, supports, n = self.system, self.supports, self.problem.size
        x, way = start.copy(), np.zeros((n, 6))
        self._place(self.motion)
        self._begin(x)
        self._place(motion)
        last = np.inf
        for count in range(1, ITERATIONS + 1):
            residual = self._assemble(x, mu)
            residual[:n] += mu * np.einsum("nij,nj->ni", self.drag, way)
            if not np.isfinite(residual).all():
                return None, 0.0, count
            supports.impose(x, residual, system.matrix, tangent=True)
            try:
                system.matrix.factorise()
            except SingularMatrixError:
                return None, 0.0, count
            increment = system.matrix.solve(-residual)
            size = increment_size(increment[:n], self.span)
            if not size < 4.0 * LARGEST or (count > 4 and size > last):
                return None, 0.0, count
            retract(x.r, x.q, increment, x.r, x.q)
            system.carry_stress(increment)
            x.multiplier += system.multiplier_change(increment)
            way += increment[:n]
            last = size
            if size <= accuracy:
                break
        else:
            return None, 0.0, ITERATIONS
        moved = increment_size(way, self.span)
        if moved > LARGEST or self._jumped(start, x):
            return None, moved, count
        self._begin(x)
        if self._near_saddle(x) and negative_eigenvalues(self._tangent(x, mu)):
            return None, moved, count
        return x, moved, count

    def _jumped(self, start: State, x: State) -> bool:
        """Return whether a prescribed rotation was closed the shorter way round between two nodes."""
        return self._turn > 0.0 and self.static.turns.jumped(start, x)

    def _near_saddle(self, x: State) -> bool:
        if self._saddle is None or not self.downhill:
            return False
        return (self.careful and self.motion < 1.0) or distance(x, self._saddle, self.span) < NEAR

    def _assemble(self, x: State, mu: float) -> Floats:
        """Assemble with the drag in the matrix; return the unbalanced forces without it."""
        self.system.constraints.pace = float(np.sqrt(mu))
        self.system.assemble(x, self._loads(), None, tangent=True, moving=False)
        self.system.constraints.pace = 0.0
        self._add_drag(self.system.matrix, mu)
        return self.system.residual()

    def _add_drag(self, matrix: Matrix, mu: float) -> None:
        matrix.blocks[self.problem.pattern.diagonal[: self.problem.size]] += mu * self._swapped

    def _tangent(self, x: State, mu: float) -> Tangent:
        """Return the tangent with the drag in the motions that the supports allow."""
        balance = self._assemble(x, mu)
        stiffness, basis = self.supports.reduce_tangent(x, balance.copy(), self.system.matrix)
        gradients = None
        if self.system.constraints.rows:
            gradients = unit_rows(sparse.csr_array(self.system.constraint_gradients(x) @ basis))
        work = SecondVariation(self.system, self.supports, x, self._loads(), balance, basis).work
        dragged = sparse.csr_array(basis.T @ block_diagonal(self.drag) @ basis)
        return Tangent(stiffness, basis, gradients, work.plus(dragged, mu))

    # --- the end

    def _finish(self, x: State) -> bool:
        """Move ``x`` to the equilibrium nearby; knock it off an unstable one.

        Returns:
            whether it is at a stable equilibrium.
        """
        static, report = self.static, self.report
        trial = x.copy()
        static.restore(trial, self.t, before=self.before, scale=self.factor)
        newton = static.newton(trial, self.t, before=self.before, scale=self.factor)
        report.iterations += newton.iterations
        if not (newton.converged and self._near(trial, x)):
            trial = x.copy()
            if not (self._creep(trial) and self._near(trial, x)):
                return False
        x.set(trial)
        self._place(1.0)
        self._begin(x)
        report.unstable = negative_eigenvalues(self._tangent(x, self._neutral))
        if not self.downhill or report.unstable == 0:
            static.restore(x, self.t, before=self.before, scale=self.factor)
            return True
        self._knock(x, KNOCK)
        return False

    def _near(self, a: State, b: State) -> bool:
        return bool(np.abs(a.r - b.r).max() <= LARGEST * self.span) and not self._jumped(b, a)

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
        while negative_eigenvalues(self._tangent(x, mu)):
            mu *= 4.0
        ways = [self._fastest(x, mu, axis) for axis in range(4)]
        fastest = min(rate for rate, _ in ways)
        way = next(way for rate, way in ways if rate <= fastest + 1e-3 * abs(fastest))
        self._saddle = x.copy()
        retract(x.r, x.q, size * way, x.r, x.q)
        self._mu = max(self._mu, 4.0 * mu)

    def _fastest(self, x: State, mu: float, axis: int) -> tuple[float, Floats]:
        """Return the lowest eigenvalue over drag and its motion ``(n, 6)``, by inverse iteration shifted by ``-mu``.

        It starts from displacements along global z, y or x (``axis`` 0 to 2), or from all motions (3).
        """
        n, rng = self.problem.size, np.random.default_rng(1)
        way = rng.standard_normal((n, 6))
        if axis < 3:
            way[:, :3] = matrices(x.q)[:, 2 - axis] * rng.uniform(0.5, 1.0, (n, 1))
            way[:, 3:] = 0.0
        rate = 0.0
        for _ in range(INVERSE):
            residual = self._assemble(x, mu)
            right = np.zeros_like(residual)
            right[:n] = np.einsum("nij,nj->ni", self.drag, way)
            before = float(np.sum(way * right[:n]))
            self.supports.impose(x, residual, self.system.matrix, tangent=True)
            right[self.supports.set.nodes] *= 1.0 - self.supports.set.fixed
            self.system.matrix.factorise()
            new = self.system.matrix.solve(right)[:n]
            gain = float(np.sum(way * np.einsum("nij,nj->ni", self.drag, new)))
            rate = before / gain - mu if gain else np.inf
            way = new / increment_size(new, self.span)
        return rate, way


def distance(a: State, b: State, length: float) -> float:
    """Return the largest displacement over ``length``, or rotation [rad], between two states."""
    cosine = np.minimum(np.abs(np.sum(a.q * b.q, axis=1)), 1.0)
    return max(float(np.abs(a.r - b.r).max()) / length, float(2.0 * np.arccos(cosine).max()))


def drag(static: StaticSolver) -> Floats:
    """Return the drag of every node ``(n, 6, 6)``: its inertia, against rotation at least that of a ball of its size.

    The rotational inertia of a slender rod is so small that its drag would let sections spin.
    """
    problem = static.system.problem
    out = problem.mass.copy()
    size = np.zeros(problem.size)
    for e in problem.sets:
        np.add.at(size, e.nodes, np.broadcast_to(e.half_lengths[:, None] * 2.0 / e.order, e.nodes.shape))
    mass = np.einsum("nii->ni", out)[:, :3].max(axis=1)
    light = mass < 1e-6 * mass.max(initial=1e-300)
    for k in np.flatnonzero(light):
        out[k, :3, :3] += np.eye(3) * (1e-3 * mass.mean() or 1.0)
    mass = np.einsum("nii->ni", out)[:, :3].max(axis=1)
    own = np.einsum("nii->ni", out)[:, 3:].min(axis=1)
    least = mass * np.where(size > 0.0, size, 0.01 * problem.length) ** 2 / 12.0
    for k in np.flatnonzero(own < least):
        out[k, 3:, 3:] += np.eye(3) * (least[k] - own[k])
    return out
