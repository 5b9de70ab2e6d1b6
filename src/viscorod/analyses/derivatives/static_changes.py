"""How an equilibrium changes with numbers of the case: one linear solution for each, with the tangent that is there.

With the imposed balance ``F(x; p) = 0`` of nodes, supports, joints and held strains, ``F_x dx/dp = -F_p`` (implicit
function theorem). ``F_p`` is the derivative of the balance of one and the same state, which nothing is solved for.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import SolveError
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.node_names import describe_node
from viscorod.solve.statics.newton import NewtonReport, SingularMatrixError
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["Instant", "StaticChange", "settle"]

ROUNDING = 1e-14
"""Of increments (displacement over model length, rotation in rad)."""
REPEATED = 10
"""Most repetitions until an equilibrium is found to round-off."""


class Instant(NamedTuple):
    """The loads of an equilibrium: at a time [s], as limits from the left if ``before``, times a factor."""

    t: float = 0.0
    before: bool = True
    scale: float = 1.0


class StaticChange:
    """Derivatives of an equilibrium.

    Args:
        discrete: the model; state: the equilibrium, which is found to round-off; at: its loads.

    Attributes:
        angles: of joints, which those of states nearby are next to ``(c,)``.

    Raises:
        SolveError: it is none, or at a point where it branches or turns back.
    """

    def __init__(self, discrete: DiscreteModel, state: State, at: Instant) -> None:
        static = discrete.static
        report = settle(static, state, at)
        if not report.converged:
            raise SolveError(f"The state is no equilibrium of this model.{discrete.where(report)}")
        self.state, self.at = state, at
        system, supports = static.system, static.supports
        supports.update(at.t, at.before, at.scale)
        system.constraints.update(at.t, at.before, at.scale)
        loads = static.loads.at(at.t, at.before, at.scale)
        system.assemble(state, loads, None, tangent=True, moving=False)
        supports.impose(state, system.residual(), system.matrix, tangent=True)
        self._weights, self.angles = supports.weights.copy(), system.constraints.near.copy()
        try:
            system.matrix.factorise()
        except SingularMatrixError as error:
            raise SolveError(
                f"The equilibrium has no derivatives: the tangent stiffness is singular at "
                f"{describe_node(system.problem, error.row // 6)}"
            ) from None
        self.system = system

    def increment(self, neighbours: Neighbours) -> Floats:
        """Return the body increments of all nodes and scaled multipliers ``(N, 6)`` per unit of the number."""
        changed = neighbours.derivative(self._balance)
        found: Floats = self.system.matrix.solve(-changed)
        return found

    def moved(self, increment: Floats, change: float) -> State:
        """Return the state to first order for a change of the number."""
        found, step = self.state.copy(), np.ascontiguousarray(change * increment[: len(self.state.r)])
        retract(found.r, found.q, step, found.r, found.q)
        if len(found.multiplier):
            found.multiplier += change * self.system.multiplier_change(increment)
        return found

    def _balance(self, one: Neighbour) -> Floats:
        """Return the imposed balance of a neighbour in the state of the equilibrium ``(N, 6)``."""
        at, static = self.at, one.resting
        near(static, self.system.constraints.near)
        state = self.state.copy()
        static.restore(state, at.t, before=at.before, scale=at.scale)
        static.system.constraints.scale[:] = self.system.constraints.scale
        residual: Floats = static.system.residual().copy()
        static.supports.impose(state, residual, static.system.matrix, tangent=False)
        return residual * self._weights


def settle(static: StaticSolver, state: State, at: Instant) -> NewtonReport:
    """Find the equilibrium next to a ``state`` (overwritten) until increments do not fall any more.

    An equilibrium ends at a tolerance, and where loads see the motion their tangent is not exact: what was left of two
    that are close by spoilt what they differ by.
    """
    last = np.inf
    for _ in range(REPEATED):
        report = static.newton(state, at.t, before=at.before, scale=at.scale)
        if not report.converged or report.change <= ROUNDING or report.change > 0.5 * last:
            break
        last = report.change
    return report


def near(static: StaticSolver, angles: Floats) -> None:
    """Let angles of joints be those next to known ones, beyond full turns."""
    static.system.constraints.near[:] = angles
