"""Linear dynamics about the state that a motion starts from: constant matrices, one solution per step.

Body velocities, strains and displacements are linear about a rod at rest that may be strained and stressed (AWP V.A,
model "L. Dyn. - L. Damp."). With nodal displacements ``xi`` along the body axes of that state (``r_t = T v`` with a
constant T),

    M xi'' + C xi' + K xi = F(t) - F_0      C = int B0^T D B0      K = int (B^T C B + N L2(S_0) B) - load stiffness

where ``F`` are the loads as they act at that state. The energy is ``W_0 + F_0 . xi + xi.K xi/2 + xi'.M xi'/2``: the
midpoint rule keeps it exactly. A part of ``K`` that is not symmetric (following loads) does work from outside.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla
from scipy import sparse

from viscorod.errors import InputError
from viscorod.mechanics.along_rod import rotated
from viscorod.mechanics.internal_force import Elements, Points, energies
from viscorod.mechanics.intrinsic_linearised import linearise_intrinsic
from viscorod.mechanics.rotation import retract
from viscorod.solve.element_forces import GeometricForces, IntrinsicForces
from viscorod.solve.history import Snapshot
from viscorod.solve.integrators.actions import Actions
from viscorod.solve.integrators.contract import StepReport
from viscorod.solve.integrators.jacobian import project
from viscorod.solve.integrators.stage_data import Body, Matrices
from viscorod.solve.integrators.tableau import MIDPOINT, RADAU, Tableau
from viscorod.solve.newton import Outcome
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.solve.time_step import start_step
from viscorod.typing import Floats

SWEEPS = 3
"""Solutions with the same factors per step."""

RECORDS = 4
"""States per step that draw the motion smoothly."""


class LinearMotion:
    """Radau IIA or the midpoint rule, see :class:`~viscorod.solve.integrators.contract.Integrator`.

    Args:
        system, supports: what is integrated; the first state that it starts from is the one it is linear about.
        tableau: the method.
        tolerance: wanted accuracy of the motion where the method has an error estimate: displacement over model
            length, rotation in rad.

    Raises:
        InputError: a support moves.
    """

    step_factor = 2.0
    """Error that a step may have by its estimate, over the tolerance, as for nonlinear motions."""

    def __init__(
        self, system: System, supports: SupportState, tableau: Tableau, tolerance: float | None = None
    ) -> None:
        if supports.moving:
            raise InputError(
                "dynamics = 'linear': the supports must stay where they are, but one has a prescribed motion. "
                "Take dynamics = 'nonlinear'"
            )
        self.system, self.supports, self.tableau = system, supports, tableau
        self.tolerance = tolerance
        self.body = Body.of(system.problem, system.elements(), supports)
        self.actions = Actions(system, supports, self.body, 1)
        self.forces = IntrinsicForces(self.body.elements, 1, linearised=True)
        self._places = system.gauss_places()
        n = system.problem.size
        self.t = 0.0
        self.state = State(
            system.problem.positions.copy(), system.problem.quaternions.copy(), np.zeros((n, 6))
        )
        self.kinetic = self.elastic = self.work = self.loss = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        self._unit = np.tile([self.body.length] * 3 + [1.0] * 3, n)
        self._known = False
        self._step = self._factor_step = 0.0
        self._xi = np.zeros((2, 6 * n))  # displacements and velocities at t
        self._stages = np.zeros((2, len(tableau.nodes), 6 * n))
        self._powers = np.zeros((2, len(tableau.nodes)))

    order = 3
    """Of the error estimate."""

    @property
    def records(self) -> int:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        return RECORDS if len(self.tableau.nodes) > 1 else 1

    # --- the state it is linear about

    def _linearise(self, t: float, state: State) -> None:
        """Set up the constant matrices about ``state``."""
        system, body, n = self.system, self.body, len(state.twist)
        self.base = State(state.r.copy(), state.q.copy(), np.zeros((n, 6)))
        points, internal = Points.of(body.elements, 1), np.zeros((n, 6))
        GeometricForces(body.elements).evaluate(self.base, points, internal)
        self._base_force = internal.ravel().copy()
        self._base_strain = points.strain[0].copy()
        self.forces.arrive(self._base_strain)
        self._load_stiffness = np.zeros((6 * n, 2 * system.band.width + 1))
        if internal.any():
            self.actions.add_load_stiffness(t, self.base, np.zeros((n, 6)), self._load_stiffness, before=True)
        matrices = self._matrices(points.strain[0], points.section_force[0], body.elements)
        self._mass = sparse.block_diag(list(body.mass), format="csr")
        matrices.mass[:] = body.mass
        supports = self.supports
        supports.impose(self.base, internal.copy(), system.band, tangent=False)
        project(
            body.nodes,
            body.fixed,
            body.axes,
            body.r0,
            body.q0,
            supports.target,
            supports.reaction,
            self.base.r,
            self.base.q,
            matrices.K,
            matrices.C,
            matrices.mass,
            matrices.G,
            matrices.Z,
        )
        self._free = supports.free_basis(self.base)
        rows, unit = supports.free_rows(), sparse.diags_array(self._unit[supports.free_rows()])
        self._basis = sparse.csr_array(self._free @ unit)
        mass = sparse.block_diag(list(matrices.mass), format="csr")
        self._reduced = [
            sparse.csc_array(unit @ matrix[rows] @ self._basis)
            for matrix in (_sparse(matrices.K), _sparse(matrices.C), mass)
        ]
        self._separate(points.strain[0], points.section_force[0])
        elastic, unused = np.zeros((2, 1))
        energies(body.elements, points.strain, np.zeros_like(points.strain), elastic, unused)
        self._base_energy = float(elastic[0])
        self.jacobians += 1
        self._known = True

    def _matrices(self, strain: Floats, section_force: Floats, elements: Elements) -> Matrices:
        """Operators, stiffness (that of the loads too) and damping matrix at rest, not projected."""
        matrices = Matrices.of(self.body, self.system.band.width)
        matrices.K[:] = self._load_stiffness
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

        Sums of stiff terms leave a rest that is no equilibrium; applied factor by factor, ``C`` multiplies strains, and
        what rounding adds to them does no harm.
        """
        elements = self.body.elements
        weights = [
            elements.weights[p] * h for p, h in zip(elements.order, elements.half_lengths, strict=True)
        ]
        blocks = np.array(weights)[..., None, None] * elements.stiffness[elements.section]
        self._weighted_stiffness = sparse.block_diag(list(blocks.reshape(-1, 6, 6)), format="csr")
        blocks = np.array(weights)[..., None, None] * elements.damping[elements.section]
        self._weighted_damping = sparse.block_diag(list(blocks.reshape(-1, 6, 6)), format="csr")
        soft = elements._replace(
            stiffness=np.zeros_like(elements.stiffness), damping=np.zeros_like(elements.damping), damped=False
        )
        matrices = self._matrices(strain, section_force, soft)
        self._B = _operator(matrices.operators.strain, elements, len(self.body.mass))
        rest = _sparse(matrices.K)
        self._skew = 0.5 * (rest - rest.T)
        self._rest = rest - self._skew
        matrices = self._matrices(np.zeros_like(strain), section_force, soft)
        self._B0 = _operator(matrices.operators.strain, elements, len(self.body.mass))

    # --- the contract

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        self.supports.update(t, False)
        self.t = t
        if not self._known:
            self.supports.project_twists(state)
            self._linearise(t, state)
            self._xi[1] = state.twist.ravel()
            for node in self.supports.set.nodes[self.supports.complete]:
                self._xi[1, 6 * node : 6 * node + 6] = 0.0
        self._load = self._loads(t, False)
        self.evaluations += 1
        self._arrive(self._xi)
        self._snapshot = self._take(self._xi, np.zeros(len(self._load)), self._load)

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        force = (self._load - self._internal(*self._xi)).reshape(-1, 6)
        return start_step(self.body.mass, force, self.state.twist, self.body.held, self.body.length, duration)

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        h, tableau = end - self.t, self.tableau
        if h != self._factor_step and not self._factorise(h):
            return StepReport(Outcome.SINGULAR, 0, 0.0, 0.0, 0)
        last = len(tableau.nodes) - 1
        times = self.t + tableau.nodes * h
        self._stage_loads = np.array(
            [self._loads(end if i == last and last else t, before and i == last) for i, t in enumerate(times)]
        )
        self.evaluations += len(times)
        xi, x = self._xi
        D = tableau.derivative / h
        changes = np.zeros_like(self._stages[0])
        size = 0.0
        for _ in range(SWEEPS):  # the first solves, the others mend what rounding of stiff terms spoilt
            rates = D @ changes
            residual = D @ (rates - x) @ self._mass - self._stage_loads
            residual += [self._internal(xi + c, r) for c, r in zip(changes, rates, strict=True)]
            modes = -(tableau.to_modes @ residual @ self._basis)
            change = np.empty_like(modes)
            change[0] = self._real.solve(modes[0])
            if last:
                pair = self._pair.solve(modes[1] + 1j * modes[2])
                change[1], change[2] = pair.real, pair.imag
            correction = (tableau.to_stages @ change) @ self._basis.T
            changes += correction
            size = float(np.abs(correction / self._unit).max())
            if not size < np.inf:
                return StepReport(Outcome.NOT_FINITE, 1, 0.0, 0.0, 0)
        self._stages[0], self._stages[1] = xi + changes, D @ changes
        self._end = end
        report = StepReport(Outcome.CONVERGED, SWEEPS, size, 0.0, 0)
        if self.tolerance is None:
            return report
        return report.erring(*self._error(h, changes))

    def _error(self, h: float, changes: Floats) -> tuple[float, int]:
        """Estimated error over the tolerated one (see ``solved_step.estimate_error``), and the unknown it is at."""
        tableau, (_, x) = self.tableau, self._xi
        p = x + tableau.error @ changes / h
        v = tableau.error @ (self._stages[1] - x) / h + tableau.real / h * p
        side = self._load - self._internal(*self._xi) + self._mass @ v + self._damping(p)
        error = np.abs(self._basis @ self._real.solve(self._basis.T @ side)) / self._unit
        where = int(np.argmax(error))
        return float(error[where]) / (self.step_factor * (self.tolerance or 1.0)), where

    def accept(self) -> None:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        h, last = self._end - self.t, len(self.tableau.nodes) - 1
        D = self.tableau.derivative / h
        self._before = (self._xi, self._snapshot)
        rates = D @ (self._stages[1] - self._xi[1])
        self._rates = self.tableau.start_derivative / h @ (self._stages[1] - self._xi[1]), rates[last]
        for i, (xi, x) in enumerate(zip(*self._stages, strict=True)):
            self._powers[0, i] = x @ self._stage_loads[i] - x @ (self._skew @ xi)
            rate = self._B0 @ x
            self._powers[1, i] = rate @ (self._weighted_damping @ rate)
        self.work, self.loss = h * (self._powers @ self.tableau.weights)
        end = self._stages[:, last].copy() if last else 2.0 * self._stages[:, 0] - self._xi
        self.t, self._step = self._end, h
        self._load = self._stage_loads[last] if last else self._loads(self.t, True)
        self._arrive(end)
        self._snapshot = self._take(end, self._rates[1], self._load)

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`."""
        return self._snapshot

    def between(self, parts: Floats) -> list[tuple[Snapshot, float, float]]:
        """See :class:`~viscorod.solve.integrators.contract.Integrator`.

        Displacements are polynomials of degree 5 through both ends, with velocities and accelerations.
        """
        (old, new), h = (self._before[0], self._xi), self._step
        work, losses = h * self._powers @ self.tableau.partial_weights(parts).T
        found = []
        loss = 0.0
        for k, part in enumerate(parts):
            xi, x, a = _quintic(float(part), h, old, new, self._rates)
            load = self._loads(self.t - (1.0 - float(part)) * h, False)
            loss = max(loss, min(float(losses[k]), self.loss))
            found.append((self._take(np.array([xi, x]), a, load), float(work[k]), loss))
        return found

    # --- parts

    def _loads(self, t: float, before: bool) -> Floats:
        """Loads ``(6 n,)`` at time ``t`` [s], body axes of the base state."""
        external = np.zeros((len(self.state.twist), 6))
        self.actions.add_loads(t, self.base, external, np.zeros((1, 1)), before=before)
        return external.ravel()

    def _internal(self, xi: Floats, x: Floats) -> Floats:
        """Return ``F_0 + K xi + C xi'``."""
        stiff = self._B.T @ (self._weighted_stiffness @ (self._B @ xi))
        soft = self._rest @ xi + self._skew @ xi
        return np.asarray(self._base_force + stiff + soft + self._damping(x))

    def _damping(self, x: Floats) -> Floats:
        return np.asarray(self._B0.T @ (self._weighted_damping @ (self._B0 @ x)))

    def _arrive(self, moved: Floats) -> None:
        xi, x = moved
        self._xi = moved
        self.kinetic = 0.5 * float(x @ (self._mass @ x))
        self.elastic = self._elastic(xi)
        self.state = self._pose(moved)

    def _elastic(self, xi: Floats) -> float:
        strain = self._B @ xi
        second = strain @ (self._weighted_stiffness @ strain) + xi @ (self._rest @ xi)
        return self._base_energy + float(self._base_force @ xi + 0.5 * second)

    def _pose(self, moved: Floats) -> State:
        n = len(self.base.r)
        state = State(np.empty((n, 3)), np.empty((n, 4)), moved[1].reshape(n, 6).copy())
        increment = moved[0].reshape(n, 6).copy()
        increment[:, :3] = 0.0
        retract(self.base.r, self.base.q, increment, state.r, state.q)
        state.r[:] = self.base.r + rotated(self.base.q, moved[0].reshape(n, 6)[:, :3])
        return state

    def _take(self, moved: Floats, acceleration: Floats, load: Floats) -> Snapshot:
        """Return the snapshot of displacements and velocities ``(2, 6 n)``."""
        elements, state = self.body.elements, self._pose(moved)
        points, internal = Points.of(elements, 1), np.zeros_like(state.twist)
        strain = (self._B @ moved[0]).reshape(self._base_strain.shape)
        self.forces.arrive(self._base_strain + strain)
        self.forces.evaluate(state, points, internal)
        residual = (self._internal(*moved) + self._mass @ acceleration - load).reshape(-1, 6)
        self.supports.impose(self.base, residual, self.system.band, tangent=False)
        strain, rate, force = (field[0].reshape(-1, 6)[self._places] for field in points[:3])
        kinetic = 0.5 * float(moved[1] @ (self._mass @ moved[1]))
        reactions = self.supports.global_reactions(self.base)
        return Snapshot(state, strain, rate, force, reactions, kinetic, self._elastic(moved[0]))

    def _factorise(self, h: float) -> bool:
        K, C, M = self._reduced
        self._factor_step = h
        self.factorisations += 1
        mu = self.tableau.real / h
        try:
            self._real = spla.splu(sparse.csc_array(K + mu * C + mu**2 * M))
            if len(self.tableau.nodes) > 1:
                pair = self.tableau.pair / h
                self._pair = spla.splu(sparse.csc_array(K + pair * C + pair**2 * M))
        except RuntimeError:  # exactly singular
            return False
        return True


def _sparse(band: Floats) -> sparse.csr_array:
    """A band of width 2 w + 1, row j holding column j, as a sparse array."""
    size, width = band.shape[0], (band.shape[1] - 1) // 2
    rows = np.arange(size)[:, None] + np.arange(-width, width + 1)
    stored = (band != 0.0) & (rows >= 0) & (rows < size)
    columns = np.broadcast_to(np.arange(size)[:, None], band.shape)[stored]
    return sparse.csr_array((band[stored], (rows[stored], columns)), shape=(size, size))


def _operator(blocks: Floats, elements: Elements, nodes: int) -> sparse.csr_array:
    """Operators of all elements ``(e, 6 points, 6 m)`` as one sparse array, Gauss points times nodes."""
    count, rows, columns = blocks.shape
    at = (6 * elements.nodes[:, :, None] + np.arange(6)).reshape(count, 1, columns)
    row = np.arange(count * rows).reshape(count, rows, 1)
    at, row = np.broadcast_to(at, blocks.shape), np.broadcast_to(row, blocks.shape)
    stored = blocks != 0.0
    return sparse.csr_array((blocks[stored], (row[stored], at[stored])), shape=(count * rows, 6 * nodes))


def _quintic(
    part: float, h: float, old: Floats, new: Floats, rates: tuple[Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """Displacement, velocity and acceleration at a ``part`` of a step ``h`` between two ends with all three given."""
    x0, x1 = old[0], new[0]
    v0, v1, a0, a1 = h * old[1], h * new[1], h * h * rates[0], h * h * rates[1]
    gap, slope, bend = x1 - x0 - v0 - 0.5 * a0, v1 - v0 - a0, a1 - a0
    c3 = 10.0 * gap - 4.0 * slope + 0.5 * bend
    c4 = -15.0 * gap + 7.0 * slope - bend
    c5 = 6.0 * gap - 3.0 * slope + 0.5 * bend
    s = part
    xi = x0 + s * (v0 + s * (0.5 * a0 + s * (c3 + s * (c4 + s * c5))))
    x = (v0 + s * (a0 + s * (3.0 * c3 + s * (4.0 * c4 + s * 5.0 * c5)))) / h
    a = (a0 + s * (6.0 * c3 + s * (12.0 * c4 + s * 20.0 * c5))) / h**2
    return xi, x, a


def linear_radau(system: System, supports: SupportState, *, tolerance: float) -> LinearMotion:
    """Radau IIA of order 5 with error control."""
    return LinearMotion(system, supports, RADAU, tolerance)


def linear_midpoint(system: System, supports: SupportState) -> LinearMotion:
    """The implicit midpoint rule."""
    return LinearMotion(system, supports, MIDPOINT)
