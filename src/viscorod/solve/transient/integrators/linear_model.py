"""A model linear about a state at rest that may be strained and stressed (AWP V.A, "L. Dyn. - L. Damp.").

With nodal displacements ``xi`` along the body axes of that state (``r_t = T v`` with a constant ``T``),

    M xi'' + C xi' + K xi = F(t) - F_0
    C = int B0^T D B0 + load damping      K = int (B^T C B + N L2(S_0) B) + load stiffness

where ``F`` are the loads as they act at that state. The energy is ``W_0 + F_0 . xi + xi.K xi/2 + xi'.M xi'/2``. A part
of ``K`` that is not symmetric (following loads) does work from outside.

Springs and their dampers are part of ``K`` and ``C``. Joints and held strains are conditions ``G xi = 0``: motions are
sought in a basis of what they allow, and their forces follow from what the balance lacks. Maxwell branches are relaxed
in the state; their forces act as elastic ones do, ``B^T C_j (B xi - alpha_j)``.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.internal_force import Elements, GaussStates, energies
from viscorod.mechanics.elements.intrinsic_linearised import linearise_intrinsic
from viscorod.mechanics.elements.poses_from_strains import rotated
from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.dashpot_memory import at_points
from viscorod.solve.formulations.element_forces import GeometricForces, IntrinsicForces
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import Snapshot
from viscorod.solve.linear.block_diagonal import block_diagonal
from viscorod.solve.modes.linearisation import Linearisation, factored
from viscorod.solve.transient.integrators.linear_branches import LinearBranches
from viscorod.solve.transient.integrators.linear_conditions import LinearConditions
from viscorod.solve.transient.integrators.stage_data import Discretisation, Matrices
from viscorod.solve.transient.integrators.step_actions import StepActions
from viscorod.typing import Floats

NO_BRANCHES = np.zeros((0, 0))
"""Dashpot strains of a model without Maxwell branches."""


class LinearModel:
    """Forces, energies and poses for displacements ``xi`` and velocities ``x``, each ``(6 n,)``.

    Args:
        system, supports: the model.
        t: time [s] just before which its loads hold the state.
        state: about which it is linear; its twists do not matter.

    Attributes:
        reduced: matrices of the motions that the supports leave free.
        mass: of all nodes ``(6 n, 6 n)``; unit: length of the model at displacements, 1 at rotations ``(6 n,)``.
    """

    def __init__(self, system: System, supports: SupportState, t: float, state: State) -> None:
        n = len(state.twist)
        self.system, self.supports = system, supports
        self.base = State(state.r.copy(), state.q.copy(), np.zeros((n, 6)), state.multiplier.copy())
        self.body = body = Discretisation.of(system.problem, system.elements(), supports)
        self.unit = np.tile([body.length] * 3 + [1.0] * 3, n)
        self.actions = StepActions(system, supports, body, 1)
        self._places = system.gauss_indices()
        carried = len(system.problem.held.place) > 0 or system.problem.relaxing
        points, internal = GaussStates.of(body.elements, 1, carried=carried), np.zeros((n, 6))
        system.constraints.update(t, True)
        if system.relaxation is not None:
            system.relaxation.known = False
        GeometricForces(system, body.elements).evaluate(self.base, points, internal)
        system.constraints.add_forces(self.base, internal)
        self._force, self._strain = internal.ravel().copy(), points.strain[0].copy()
        self._forces = IntrinsicForces(system, body.elements, 1, linearised=True)
        elastic, unused = np.zeros((2, 1))
        energies(body.elements, points.strain, np.zeros_like(points.strain), elastic, unused)
        self._energy = float(elastic[0]) + system.constraints.energy
        self._load_stiffness, self._load_damping, self._damper_blocks = np.zeros(
            (3, *system.matrix.blocks.shape)
        )
        ad, derivatives = np.zeros((n, 6, 6)), (self._load_stiffness, self._load_damping)
        self.actions.add_load_stiffness(t, self.base, ad, *derivatives, before=True)
        if not internal.any():
            self._load_stiffness.fill(0.0)
        if system.problem.joints.count:
            system.constraints.add_tangent(
                self.base, ad, self._load_stiffness, self._damper_blocks, moving=True, held=None
            )
        self._drag, self._dampers = self._sparse(self._load_damping), self._sparse(self._damper_blocks)
        self.mass = block_diagonal(body.mass)
        self.reduced = self._reduce(self._matrices(self._strain, points.section_force[0], body.elements))
        self._separate(self._strain, points.section_force[0])
        self.branches: LinearBranches | None = None
        if system.relaxation is not None:
            self.branches = LinearBranches(system.relaxation, body.elements, self._B, self.reduced.basis)

    def _reduce(self, matrices: Matrices) -> Linearisation:
        """Return the matrices of the motions that supports, joints and held strains leave free."""
        self.system.matrix.blocks[:] = matrices.K
        residual = self._force.reshape(-1, 6).copy()
        stiffness, basis = self.supports.reduce_tangent(self.base, residual, self.system.matrix)
        damping, mass = (
            sparse.csr_array(basis.T @ matrix @ basis) for matrix in (self._sparse(matrices.C), self.mass)
        )
        self.conditions: LinearConditions | None = None
        if not self.system.problem.constrained:
            return Linearisation(stiffness, damping, mass, basis, None)
        held = (self.body.elements.order, matrices.operators.strain)
        rows = held if len(self.system.problem.held.place) else None
        self.conditions = LinearConditions(self.system.constraints, self.base, rows, basis)
        return Linearisation(stiffness, damping, mass, basis, self.conditions.conditions).unconditional()

    def _sparse(self, blocks: Floats) -> sparse.csr_array:
        size = 6 * len(self.body.mass)  # multipliers come after the nodes
        return sparse.csr_array(self.body.pattern.sparse(blocks)[:size, :size])

    def _matrices(self, strain: Floats, section_force: Floats, elements: Elements) -> Matrices:
        """Return operators, stiffness and damping matrix at rest (those of the loads too), not projected."""
        matrices = Matrices.of(self.body)
        matrices.K[:], matrices.C[:] = self._load_stiffness, self._load_damping + self._damper_blocks
        still = np.zeros_like(section_force)
        linearise_intrinsic(
            elements,
            True,
            strain,
            still,
            still,
            np.zeros((len(self.body.mass), 6, 6)),
            section_force,
            matrices.operators,
            matrices.K,
            matrices.C,
        )
        return matrices

    def _separate(self, strain: Floats, section_force: Floats) -> None:
        """Split the stiffness into ``B^T C B`` and what loads and stresses add.

        The rounding of sums of stiff terms would disturb an equilibrium; applied factor by factor, ``C`` multiplies
        strains, in which rounding does no harm.
        """
        elements = self.body.elements
        weights = [
            elements.weights[p] * h for p, h in zip(elements.order, elements.half_lengths, strict=True)
        ]
        blocks = np.array(weights)[..., None, None] * elements.stiffness[elements.section]
        self._weighted_stiffness = block_diagonal(blocks.reshape(-1, 6, 6))
        blocks = np.array(weights)[..., None, None] * elements.damping[elements.section]
        self._weighted_damping = block_diagonal(blocks.reshape(-1, 6, 6))
        soft = elements._replace(
            stiffness=np.zeros_like(elements.stiffness), damping=np.zeros_like(elements.damping), damped=False
        )
        matrices = self._matrices(strain, section_force, soft)
        self._B = _operator(matrices.operators.strain, elements, len(self.body.mass))
        rest = self._sparse(matrices.K)
        self._skew = 0.5 * (rest - rest.T)
        self._rest = rest - self._skew
        matrices = self._matrices(np.zeros_like(strain), section_force, soft)
        self._B0 = _operator(matrices.operators.strain, elements, len(self.body.mass))

    # --- what an integrator asks

    def loads(self, t: float, before: bool, stage: int | None = None) -> Floats:
        """Return the loads ``(6 n,)`` at time ``t`` [s], body axes of the state it is linear about.

        Those that are records have their mean course over the step where ``t`` is one of its stages.
        """
        external = np.zeros((len(self.body.mass), 6))
        means = {} if stage is None else self.actions.means(stage)
        self.actions.add_loads(t, self.base, external, before=before, given=means)
        return external.ravel()

    def internal(self, xi: Floats, x: Floats, dashpot: Floats = NO_BRANCHES) -> Floats:
        """Return ``F_0 + K xi + C xi'`` with the forces of branches at dashpot strains ``(n, m)``."""
        strain = self._B @ xi
        sections = self._weighted_stiffness @ strain
        if self.branches is not None:
            sections = sections + self.branches.force(strain, dashpot)
        soft = self._rest @ xi + self._skew @ xi
        return np.asarray(self._force + self._B.T @ sections + soft + self.damping(x))

    def strains(self, xi: Floats) -> Floats:
        """Return the change of all strains ``(m,)``."""
        return np.asarray(self._B @ xi)

    def nodal(self, sections: Floats) -> Floats:
        """Return the forces on the nodes ``(6 n,)`` of weighted section forces ``(m,)``."""
        return np.asarray(self._B.T @ sections)

    def damping(self, x: Floats) -> Floats:
        """Return ``C x``."""
        viscous = self._B0.T @ (self._weighted_damping @ (self._B0 @ x))
        return np.asarray(viscous + self._drag @ x + self._dampers @ x)

    def power(self, xi: Floats, x: Floats, load: Floats) -> tuple[float, float, float]:
        """Return the power of loads, and what viscosity (not branches) and loads that see motion dissipate [W]."""
        rate = self._B0 @ x
        viscous = float(rate @ (self._weighted_damping @ rate)) + float(x @ (self._dampers @ x))
        return float(x @ load - x @ (self._skew @ xi)), viscous, float(x @ (self._drag @ x))

    def allowed(self, x: Floats) -> Floats:
        """Return the velocities ``(6 n,)`` nearest to given ones that joints and held strains allow."""
        if self.conditions is None or self.conditions.conditions is None:
            return x
        return self._pushed(self.mass @ x)

    def acceleration(self, force: Floats) -> Floats:
        """Return how forces ``(6 n,)`` accelerate the nodes, on which forces of conditions depend; else 0."""
        if self.conditions is None or self.conditions.conditions is None:
            return np.zeros_like(force)
        return self._pushed(force)

    def _pushed(self, momentum: Floats) -> Floats:
        """Return the motion within the conditions that has a momentum ``(6 n,)``."""
        basis = self.reduced.basis
        return np.asarray(basis @ factored(self.reduced.mass).solve(basis.T @ momentum))

    def kinetic(self, x: Floats) -> float:
        """Return the kinetic energy [J]."""
        return 0.5 * float(x @ (self.mass @ x))

    def elastic(self, xi: Floats, dashpot: Floats = NO_BRANCHES) -> float:
        """Return the elastic energy [J], that of the state it is linear about included."""
        strain = self._B @ xi
        second = strain @ (self._weighted_stiffness @ strain) + xi @ (self._rest @ xi)
        stored = 0.0 if self.branches is None else self.branches.energy(strain, dashpot)
        return self._energy + float(self._force @ xi + 0.5 * second) + stored

    def state(self, xi: Floats, x: Floats) -> State:
        """Return poses and twists: positions are linear in the displacements, rotations made of rotation vectors."""
        n = len(self.base.r)
        moved, increment = xi.reshape(n, 6), np.zeros((n, 6))
        increment[:, 3:] = moved[:, 3:]
        state = State(np.empty((n, 3)), np.empty((n, 4)), x.reshape(n, 6).copy(), self.base.multiplier.copy())
        retract(self.base.r, self.base.q, increment, state.r, state.q)
        state.r[:] = self.base.r + rotated(self.base.q, moved[:, :3])
        return state

    def snapshot(
        self, xi: Floats, x: Floats, acceleration: Floats, load: Floats, dashpot: Floats = NO_BRANCHES
    ) -> Snapshot:
        """Return everything about a state with given accelerations and loads ``(6 n,)`` and dashpot strains."""
        state, joints = self.state(xi, x), None
        left = self.internal(xi, x, dashpot) + self.mass @ acceleration - load
        if self.conditions is not None:
            left, state.multiplier = self.conditions.balanced(left)
            joints = self.conditions.joints(xi, x, state.multiplier)
        residual = left.reshape(-1, 6)
        points, unused = GaussStates.of(self.body.elements, 1), np.zeros_like(state.twist)
        self._forces.set_strains(self._strain + (self._B @ xi).reshape(self._strain.shape))
        if self.branches is not None:
            self.branches.remember(dashpot)
        self._forces.evaluate(state, points, unused)
        self.supports.impose(self.base, residual, self.system.matrix, tangent=False)
        strain, rate, force = (field[0].reshape(-1, 6)[self._places] for field in points[:3])
        reactions = self.supports.global_reactions(self.base)
        energies_ = self.kinetic(x), self.elastic(xi, dashpot)
        found = Snapshot(state, strain, rate, force, reactions, *energies_, joints)
        if self.branches is None:
            return found
        memory, now = self.branches.memory, points.strain[0]
        return found._replace(
            branch_power=memory.power(now).ravel()[self._places],
            branch_strain=at_points(now - memory.dashpot, self._places),
        )


def _operator(blocks: Floats, elements: Elements, nodes: int) -> sparse.csr_array:
    """Return operators of all elements ``(e, 6 points, 6 m)`` as one sparse array, Gauss points times nodes."""
    count, rows, columns = blocks.shape
    at = (6 * elements.nodes[:, :, None] + np.arange(6)).reshape(count, 1, columns)
    row = np.arange(count * rows).reshape(count, rows, 1)
    at, row = np.broadcast_to(at, blocks.shape), np.broadcast_to(row, blocks.shape)
    stored = blocks != 0.0
    return sparse.csr_array((blocks[stored], (row[stored], at[stored])), shape=(count * rows, 6 * nodes))
