"""Steady rotations of one model over the speed, each found from the nearest one that is known."""

from __future__ import annotations

from bisect import insort

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.continuation import LARGEST_GAP, TOLERANCE, continue_to
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil
from viscorod.solve.steady.rotation_search import Search
from viscorod.solve.steady.stability import SecondOrder
from viscorod.solve.steady.steady_checks import SupportKind, no_loads, support_kind
from viscorod.solve.steady.whirl import Rounds, pure, rounds
from viscorod.solve.tracking.moving_pencil import MovingPencil
from viscorod.typing import Floats

__all__ = ["AT_REST", "DrivenRotations"]

AT_REST = 1e-9
"""Part of the highest speed that stands for none: its inertial forces are 1e-18 of those there."""
IDLE = 1e-7
"""Distance of a root from the speed, as a part of it, within which a free model only moves as a whole."""
QUICK, FAR = 8, 0.3
"""Iterations from a rotation nearby, and the change, in sizes of the unknowns, beyond which it is not near."""


class DrivenRotations:
    """Finds steady rotations about one axis, and their small motions.

    Args:
        static: solver of the model's statics; settings: of the rotation at the highest speed, whose spin is a vector.
    """

    def __init__(self, static: StaticSolver, settings: SteadySettings) -> None:
        self._static, self._search = static, Search(static, settings, None)
        self._resting: object | None = None
        self._copies: int | None = None
        self._equations = self._search.driven()
        self.highest = float(np.linalg.norm(np.asarray(settings.spin, dtype=float)))
        self.direction = self._equations.line.direction
        self.problem = static.system.problem
        self._known: list[tuple[float, int]] = []
        self._kept: list[object] = []
        self.mass = sparse.csr_array(block_diagonal(self.problem.mass))

    @property
    def iterations(self) -> int:
        """Iterations of Newton's method so far."""
        return self._search.effort.iterations

    def state(self, speed: float) -> State:
        """Return poses and twists at a speed [rad/s].

        Raises:
            SolveError: no rotation was found there.
        """
        self._turn_to(speed)
        return self._equations.state().copy()

    def pencil(self, speed: float) -> MovingPencil:
        """Return the small motions about the rotation with a speed [rad/s].

        Raises:
            SolveError: no rotation was found there.
        """
        self._turn_to(speed)
        small, free, copies = self._equations.motions_of_second_order()
        self._copies = len(copies)
        basis, inverse = free.basis, free.inverse
        M, C, K = (
            sparse.csr_array(basis.T @ (m @ basis)) for m in (small.mass, small.damping, small.stiffness)
        )
        count = basis.shape[1]
        A, Z = sparse.csr_array((count, count)), np.zeros((count, 0))
        if copies:
            A = sparse.csr_array(inverse @ (sparse.block_diag(list(small.ad), format="csr") @ basis))
            Z, _ = np.linalg.qr(inverse @ np.array(copies).T)
        branches, times = _branches(small, basis)
        return MovingPencil(QuadraticPencil(M, C, K, A, Z), basis, branches, times)

    def rounds(self, speed: float, shapes: np.ndarray) -> Rounds:
        """Return how motions ``(6 n, m)`` go round the axis."""
        frames = matrices(self.state(speed).q)
        return rounds(self._global(frames, shapes), self.problem.mass, frames, self.direction)

    def idle(self, speed: float, roots: np.ndarray) -> np.ndarray:
        """Return which roots are those of a model that rests, or drifts, beside its rotation: nothing holds it."""
        free = support_kind(self.problem) is not SupportKind.HELD
        near = np.hypot(roots.real, np.abs(roots.imag) - speed) <= IDLE * speed
        return np.asarray(near & free)

    def principal(self, speed: float, shapes: np.ndarray) -> np.ndarray:
        """Return combinations of motions with one root that go round one way each, as far as they can."""
        frames = matrices(self.state(speed).q)
        weights = pure(self._global(frames, shapes), self.problem.mass, frames, self.direction)
        return np.asarray(shapes @ weights)

    @staticmethod
    def _global(frames: Floats, shapes: np.ndarray) -> np.ndarray:
        """Return translations and rotations of the nodes in global axes ``(n, 6, m)``."""
        local = shapes.reshape(len(frames), 2, 3, -1)
        return np.asarray(np.einsum("nij,nbjm->nbim", frames, local).reshape(len(frames), 6, -1))

    def _newton(self, speed: float) -> bool:
        """Solve for the shape at a speed from one nearby, where no copies make it ambiguous; False if that fails."""
        equations = self._equations
        kept = equations.save()
        equations.set_spin(speed)
        for _ in range(QUICK):
            self._search.effort.check_interrupt()
            change = equations.change_at_spin()
            if change is None:
                break
            self._search.effort.iterations += 1
            size = float(np.abs(change / equations.scales()).max())
            if not size < FAR:
                break
            equations.update(change)
            if size < TOLERANCE:
                _, gap = equations.residual()
                if gap < LARGEST_GAP:
                    return True
                break
        equations.restore(kept)
        return False

    def _rest(self) -> None:
        """Move the equations to the equilibrium at rest, with a speed that stands for none.

        Raises:
            SolveError: there is none.
        """
        static, equations = self._static, self._equations
        state = State.reference(self.problem)
        strained = static.system.constraints.is_strained(state, 0.0, before=False)
        moved = bool(self.problem.supports.motions)
        if not no_loads(equations.loads) or moved or strained or self.problem.rest_strains:
            path = static.solve(state, before=False)
            if path.outcome is not Outcome.COMPLETED:
                raise SolveError("No equilibrium was found at rest. What to try: speeds from above 0 on")
        equations.restore((state, AT_REST * self.highest))

    def _turn_to(self, speed: float) -> None:
        equations = self._equations
        if speed <= AT_REST * self.highest:
            if self._resting is None:
                self._rest()
                self._resting = equations.save()
            equations.restore(self._resting)
            return
        if self._known:
            near = min(self._known, key=lambda one: abs(one[0] - speed))
            equations.restore(self._kept[near[1]])
            if near[0] == speed:
                return
            start: float | None = near[0]
        else:
            start = 0.0
        quick = start != 0.0 and self._copies == 0 and self._newton(speed)
        if not quick and not continue_to(equations, "spin", speed, self._search.effort, start):
            raise SolveError(
                f"No steady rotation was found at {speed:.6g} rad/s, continued from "
                f"{start or 0.0:.6g} rad/s. What to try: lower speeds, or more of them"
            )
        insort(self._known, (speed, len(self._kept)))
        self._kept.append(equations.save())


def _branches(
    small: SecondOrder, basis: sparse.csr_array
) -> tuple[tuple[sparse.csr_array, ...], tuple[float, ...]]:
    """Return the stiffnesses of Maxwell branches in free motions, and their times [s]."""
    if small.branches is None:
        return (), ()
    springs = small.branches.within(basis)
    times = np.unique(springs.times)
    parts = [springs.stretch[np.flatnonzero(springs.times == tau)] for tau in times]
    return tuple(sparse.csr_array(F.T @ F) for F in parts), tuple(float(tau) for tau in times)
