"""From the state of a coarse mesh to the equilibrium of a finer one, with what a motion or a path adds to statics."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.problem.external_loads import NO_LOADS
from viscorod.solve.refinement.finer_mesh import Carried, FinerMesh, Shape
from viscorod.solve.statics.drag_flow import drag
from viscorod.solve.statics.newton import Convergence, Outcome
from viscorod.typing import Floats

__all__ = ["Balance", "corrected", "counterpart", "held_back"]

ITERATIONS = 15
FALLING = 0.1
"""Part of the increment before that one has to be, where it is told by both what the next one will be at most."""
DRAGS = (1e-13, 1e-11, 1e-9)
"""Parts of the mean stiffness of nodes, which stretching makes, that hold steps back where others fail."""
STEP = 1e-3
"""Part of the unit of the load factor by which the imbalance is differenced."""


class Balance:
    """What balances the internal forces of the finer mesh at one instant.

    Args:
        finer: the mesh; t, before, factor: time [s] of the loads and supports, whether from the left, their multiple.
        inertia: wrenches of the nodes beside the loads, body axes ``(n, 6)``; None in statics.
        anchor: stiffness over mass [1/s^2] that keeps every node where the coarse mesh has it: the inertia against
            errors, without which a free motion would be undetermined.
        unit: of the load factor where that follows from the point of a path; None where it is given.

    Attributes:
        drag: stiffness over mass [1/s^2] that holds steps of the iteration back, and leaves where it converges.
    """

    def __init__(
        self,
        finer: FinerMesh,
        t: float = 0.0,
        *,
        before: bool = True,
        factor: float = 1.0,
        inertia: Floats | None = None,
        anchor: float = 0.0,
        unit: float | None = None,
    ) -> None:
        self.finer, self.t, self.before, self.factor = finer, t, before, factor
        self.inertia, self.anchor, self.unit = inertia, anchor, unit
        self.drag = 0.0
        self._loads = NO_LOADS
        self._resisting = anchor * np.swapaxes(finer.problem.mass, 1, 2) if anchor else None

    @property
    def at_rest(self) -> bool:
        """Whether it is that of statics at a given load factor."""
        return self.inertia is None and self.anchor == 0.0 and self.unit is None

    def place(self, factor: float) -> None:
        """Let loads and supports be those of a load factor, until they are placed again."""
        finer = self.finer
        finer.supports.update(self.t, self.before, factor)
        finer.system.constraints.update(self.t, self.before, factor)
        self._loads = finer.static.loads.at(self.t, self.before, factor)

    def assemble(self, state: State, moved: Floats, *, tangent: bool) -> Floats:
        """Assemble the finer system in a state that ``moved (n, 6)`` from the coarse one; return the imbalance."""
        finer, size = self.finer, self.finer.problem.size
        system = finer.system
        system.assemble(state, self._loads, None, tangent=tangent, moving=False)
        residual = system.residual()
        if self.inertia is not None:
            residual[:size] -= self.inertia
        if self._resisting is not None:
            residual[:size] += (moved[:, None] @ self._resisting)[:, 0]
            if tangent:
                diagonal = finer.problem.pattern.diagonal[:size]
                system.matrix.blocks[diagonal] += self._resisting
        if self.drag and tangent:
            diagonal = finer.problem.pattern.diagonal[:size]
            system.matrix.blocks[diagonal] += self.drag * np.swapaxes(drag(finer.static), 1, 2)
        finer.supports.impose(state, residual, system.matrix, tangent=tangent)
        return residual

    def pace(self, state: State) -> float:
        """Return the mean stiffness over mass [1/s^2] of the nodes of a state."""
        finer, size = self.finer, self.finer.problem.size
        self.place(self.factor)
        self.assemble(state, np.zeros((size, 6)), tangent=True)
        diagonal = finer.problem.pattern.diagonal[:size]
        stiff = np.abs(np.einsum("nii->ni", finer.system.matrix.blocks[diagonal])[:, :3]).sum()
        return float(stiff / np.einsum("nii->ni", drag(finer.static))[:, :3].sum())


def held_back(balance: Balance, state: State) -> State | None:
    """Return the same as :func:`corrected` where some motion changes nothing, such as a spin about the own axis.

    The least drag with which the iteration converges holds its steps back; it takes no part in the balance.
    """
    pace = balance.pace(state)
    for part in DRAGS:
        balance.drag = part * pace
        found = corrected(balance, state)
        if found is not None:
            return found
    return None


def corrected(balance: Balance, state: State) -> State | None:
    """Return the equilibrium next to a state that was taken over from the coarse mesh; None if there is none.

    On a path the load factor changes too, and the way to the equilibrium is orthogonal to the path: displacements over
    the length of the model, rotations and the factor over its unit count alike (see ``PathFollower``).
    """
    finer = balance.finer
    system, problem = finer.system, finer.problem
    size, factor = problem.size, balance.factor
    state, moved = state.copy(), np.zeros((problem.size, 6))
    convergence = Convergence(problem.length, finer.static.tolerance, ITERATIONS)
    weights = np.array([*[problem.length**-2] * 3, 1.0, 1.0, 1.0]) / size
    normal: Floats | None = None
    change, moves = 0.0, 0.0  # nothing is small beside no increment
    balance.place(factor)
    for count in range(1, ITERATIONS + 1):
        varied = None
        if balance.unit is not None:
            balance.place(factor + STEP * balance.unit)
            varied = balance.assemble(state, moved, tangent=False).copy()
            balance.place(factor)
        residual = balance.assemble(state, moved, tangent=True)
        if not np.isfinite(residual).all():
            return None
        try:
            system.matrix.factorise()
        except SingularMatrixError:
            return None
        increment = system.matrix.solve(-residual)
        if varied is not None and balance.unit is not None:
            rate = system.matrix.solve((residual - varied) / (STEP * balance.unit))
            normal = rate[:size].copy() if normal is None else normal
            beside = float(np.sum(weights * normal * rate[:size])) + balance.unit**-2
            gone = float(np.sum(weights * normal * (moved + increment[:size])))
            gone += (factor - balance.factor) / balance.unit**2
            change = -gone / beside
            increment, factor = increment + change * rate, factor + change
        last = moves
        verdict, moves = convergence.judge(increment[:size], count)
        if verdict is None and moves <= FALLING * last and moves * (moves / last) <= convergence.tolerance:
            verdict = Outcome.CONVERGED  # Newton's method will not do worse than in this step
        if verdict not in (None, Outcome.CONVERGED) or not np.isfinite(factor):
            return None
        retract(state.r, state.q, increment, state.r, state.q)
        system.carry_stress(increment)
        state.multiplier += system.multiplier_change(increment)
        moved += increment[:size]
        if verdict is Outcome.CONVERGED and abs(change) <= 1e-7 * max(balance.unit or 1.0, abs(factor)):
            if balance.unit is not None:
                balance.place(factor)
            balance.assemble(state, moved, tangent=False)
            return state
    return None


def counterpart(balance: Balance, carried: Carried, k: int = 0) -> Shape | None:
    """Return what one of some solutions is on the finer mesh, None if it has no counterpart there."""
    finer = balance.finer
    other = corrected(balance, finer.take_over(carried, k))
    if other is None and balance.at_rest:
        other = held_back(balance, finer.take_over(carried, k))
    if other is None:
        return None
    return Shape(other, finer.system.gauss_points().section_force, carried.shapes[k].near)
