"""Linear dynamics about the state that a motion starts from: constant matrices, one solution per step."""

from __future__ import annotations

import numpy as np
import scipy.sparse.linalg as spla
from scipy import sparse

from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.energy_account import StepShare
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import Snapshot, Snapshots
from viscorod.solve.loss_within_steps import loss_within
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.contract import Inside, Integrator, StepReport
from viscorod.solve.transient.integrators.linear_model import LinearModel
from viscorod.solve.transient.integrators.stability import seen_by_halving, stability
from viscorod.solve.transient.integrators.tableau import MIDPOINT, Tableau, radau
from viscorod.solve.transient.load_content import StepContent
from viscorod.solve.transient.motion_scale import GivenTolerance, Tolerance
from viscorod.solve.transient.time_step import first_time_step
from viscorod.typing import Floats

SWEEPS = 3
"""Solutions with the same factors per step."""


class LinearMotion:
    """Radau IIA or the midpoint rule, see :class:`~viscorod.solve.transient.integrators.contract.Integrator`.

    Args:
        system, supports: the model; the supports stay where they are, and the first
            state that it starts from is the one it is linear about.
        tableau: the method.
        tolerance: wanted accuracy of the motion where the method has an error estimate: displacement over model
            length, rotation in rad.
    """

    step_factor = 2.0
    """Error that a step may have by its estimate, over the tolerance, as for nonlinear motions."""

    looks_within = True

    drift = 0.0, 0.0
    """Linear conditions are fulfilled to round-off."""

    def __init__(
        self,
        system: System,
        supports: SupportState,
        tableau: Tableau,
        tolerance: float | Tolerance | None = None,
    ) -> None:
        self.system, self.supports, self.tableau = system, supports, tableau
        self.tolerance = GivenTolerance(tolerance) if isinstance(tolerance, float) else tolerance
        problem, stages = system.problem, len(tableau.nodes)
        self.estimate_order = stages
        self.t = 0.0
        self.state = State.reference(problem)
        self.kinetic = self.elastic = self.work = self.loss = self.outside = self.actuator = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        self._body: LinearModel | None = None
        self._last = stages - 1
        self._step = self._factor_step = 0.0
        self._now = np.zeros((2, 6 * problem.size))  # displacements and velocities at t
        self._stages = np.zeros((2, stages, 6 * problem.size))
        self._powers = np.zeros((stages, 3))
        branches = 0 if system.relaxation is None else len(system.relaxation.times)
        points = system.elements().reference.size if branches else 0
        # strains of dashpots at t, at the start of the last step, at its stages; what they dissipate there
        self._dashpot, self._earlier = np.zeros((2, branches, points))
        self._dashpots = np.zeros((stages, branches, points))
        self._branch_powers = np.zeros((stages, branches))

    @property
    def records(self) -> int:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._last + 2 if self._last else 1

    @property
    def strain(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return float(np.abs(self._snapshot.strain[:, :3]).max())

    @property
    def body(self) -> LinearModel:
        """The linear model, known from the first start on."""
        assert self._body is not None
        return self._body

    # --- the contract

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        self.supports.update(t, False)
        self.t = t
        if self._body is None:
            self.supports.project_twists(state)
            self._body = LinearModel(self.system, self.supports, t, state)
            self.jacobians += 1
            self._now[1] = state.twist.ravel()
            held = self.supports.set.nodes[self.supports.complete]
            self._now[1].reshape(-1, 6)[held] = 0.0
            self._now[1] = self.body.allowed(self._now[1])
        self._load = self.body.loads(t, False)
        self.evaluations += 1
        self._set_state(self._now, self.body.acceleration(self.unbalanced().ravel()))
        if self.tolerance is not None:
            self.tolerance.begin(t, self.state, self.unbalanced())

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        body = self.body.body
        return first_time_step(
            body.mass, self.unbalanced(), self.state.twist, body.held, body.length, duration
        )

    def unbalanced(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return (self._load - self._internal_now()).reshape(-1, 6)

    def _internal_now(self) -> Floats:
        """Return the internal forces at t ``(6 n,)``."""
        return self.body.internal(self._now[0], self._now[1], self._dashpot)

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h, tableau, body, basis = end - self.t, self.tableau, self.body, self.body.reduced.basis
        if h != self._factor_step and not self._factorise(h):
            return StepReport(Outcome.SINGULAR, 0, 0.0, 0.0, 0)
        last = self._last
        times = [end if i == last and last else self.t + c * h for i, c in enumerate(tableau.nodes)]
        body.actions.look_within(self.t, end)
        self._stage_loads = np.array([body.loads(t, before and i == last, i) for i, t in enumerate(times)])
        self.evaluations += len(times)
        xi, x = self._now
        D = tableau.derivative / h
        changes = np.zeros_like(self._stages[0])
        size = 0.0
        for _ in range(SWEEPS):  # the first solves, the others remove the rounding errors of stiff terms
            rates = D @ changes
            residual = D @ (rates - x) @ body.mass - self._stage_loads
            dashpots = self._at_stages(D, xi + changes)
            residual += [
                body.internal(xi + c, r, d) for c, r, d in zip(changes, rates, dashpots, strict=True)
            ]
            modes = -(tableau.to_modes @ residual @ basis)
            change = np.empty_like(modes)
            change[0] = self._real.solve(modes[0])
            for m, pair in enumerate(self._pairs):
                solution = pair.solve(modes[2 * m + 1] + 1j * modes[2 * m + 2])
                change[2 * m + 1], change[2 * m + 2] = solution.real, solution.imag
            correction = (tableau.to_stages @ change) @ basis.T
            changes += correction
            size = float(np.abs(correction / body.unit).max())
            if not size < np.inf:
                return StepReport(Outcome.NOT_FINITE, 1, 0.0, 0.0, 0)
        self._stages[0], self._stages[1] = xi + changes, D @ changes
        self._dashpots = self._at_stages(D, self._stages[0])
        self._end = end
        report = StepReport(Outcome.CONVERGED, SWEEPS, size, 0.0, 0)
        if self.tolerance is None:
            return report
        error = np.maximum(self._error(h, changes), self._unseen())
        node, component = divmod(int(np.argmax(error)), 6)
        reached = body.state(*self._stages[:, last])
        allowed = self.step_factor * self.tolerance.at(end, reached)
        return report._replace(error=float(error.max()) / allowed, node=node, component=component)

    def _at_stages(self, D: Floats, xi: Floats) -> Floats:
        """Return the strains of the dashpots at the stages of a step with displacements ``(s, 6 n)``."""
        body = self.body
        if body.branches is None:
            return self._dashpots
        return body.branches.at_stages(D, np.array([body.strains(one) for one in xi]), self._dashpot)

    def _error(self, h: float, changes: Floats) -> Floats:
        """Return estimated errors ``(6 n,)``: displacements over model length, rotations (see ``step_error``)."""
        tableau, body, x = self.tableau, self.body, self._now[1]
        p = x + tableau.error @ changes / h
        v = tableau.error @ (self._stages[1] - x) / h + tableau.real / h * p
        side = self._load - self._internal_now() + body.mass @ v + body.damping(p)
        if body.branches is not None:
            rates = body.branches.rates(body.strains(self._now[0]), self._dashpot)
            rates = rates + np.tensordot(tableau.error / h, self._dashpots - self._dashpot, 1)
            side = side + body.nodal(body.branches.unfinished(tableau.real / h, rates))
        basis = body.reduced.basis
        return np.asarray(np.abs(basis @ self._real.solve(basis.T @ side)) / body.unit)

    def _unseen(self) -> Floats:
        """Return what loads move between the stages ``(6 n,)``: displacements over model length, rotations."""
        force, basis = self.body.actions.unseen(self.t, self.body.base), self.body.reduced.basis
        if force is None:
            return np.zeros(len(self.body.unit))
        return np.asarray(np.abs(basis @ self._real.solve(basis.T @ force.ravel())) / self.body.unit)

    def watch(self, duration: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        self.body.actions.content = StepContent.of(self.system.problem, self.tableau.nodes, duration)

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h, last, tableau, body = self._end - self.t, self._last, self.tableau, self.body
        change = self._stages[1] - self._now[1]
        rates = tableau.start_derivative / h @ change, (tableau.derivative / h @ change)[last]
        self._powers = np.array(
            [body.power(xi, x, load) for xi, x, load in zip(*self._stages, self._stage_loads, strict=True)]
        )
        self._earlier = self._dashpot
        if body.branches is not None:
            self._branch_powers = np.array(
                [
                    body.branches.powers(body.strains(xi), d)
                    for xi, d in zip(self._stages[0], self._dashpots, strict=True)
                ]
            )
            self._powers[:, 1] += self._branch_powers.sum(axis=1)
            self._dashpot = self._dashpots[last] if last else 2.0 * self._dashpots[0] - self._dashpot
        self.work, self.loss, self.outside = (h * (tableau.weights @ self._powers)).tolist()
        end = self._stages[:, last].copy() if last else 2.0 * self._stages[:, 0] - self._now
        self._before, self._rates = self._now, rates
        self.t, self._step = self._end, h
        self._load = self._stage_loads[last] if last else body.loads(self.t, True)
        self._set_state(end, rates[1])
        if self.tolerance is not None:
            self.tolerance.accept(self.t, self.state)

    @property
    def section_force(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._snapshot.section_force

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._snapshot

    @property
    def branch_loss(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return np.asarray(self._step * (self.tableau.weights @ self._branch_powers))

    def resume(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: the next step factorises."""
        self._factor_step = 0.0

    def between(self, parts: Floats) -> Inside:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`.

        Displacements are polynomials of degree 5 through both ends, with velocities and accelerations, corrected
        towards the stages if they are many.
        """
        h, found, tableau = self._step, [], self.tableau
        until = tableau.partial_weights(parts)
        totals = h * until @ self._powers
        ends = h, self._before, self._now, self._rates
        missed = [
            self._stages[:, i] - _quintic(float(c), *ends)[:2] for i, c in enumerate(tableau.exact_inside)
        ]
        weights, change = tableau.polynomials(parts), self._dashpots - self._earlier
        dashpots = self._earlier + np.tensordot(weights, change, 1)
        for part, own, dashpot in zip(parts, weights, dashpots, strict=True):
            xi, x, a = _quintic(float(part), *ends)
            for weight, (shift, speed) in zip(own, missed, strict=False):
                xi, x = xi + weight * shift, x + weight * speed
            load = self.body.loads(self.t - (1.0 - float(part)) * h, False)
            found.append(Snapshots.of(self.body.snapshot(xi, x, a, load, dashpot)))
        loss = loss_within(h * until, self._powers[:, 1], self.loss)
        outside, branches = (h * (until @ powers) for powers in (self._powers[:, 2], self._branch_powers))
        still = np.zeros(len(parts))  # no rest strain changes here
        return Inside(Snapshots.joined(found), StepShare(totals[:, 0], loss, outside, still, branches))

    @property
    def seen_by_halving(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return seen_by_halving(self.tableau)

    def stability(self, z: np.ndarray) -> np.ndarray:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return stability(self.tableau, z)

    def begin_half(self, whole: Integrator, place: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        del whole, place

    # --- parts

    def _set_state(self, now: Floats, acceleration: Floats) -> None:
        self._now = now
        self._snapshot = self.body.snapshot(now[0], now[1], acceleration, self._load, self._dashpot)
        self.state = self._snapshot.state
        self.kinetic, self.elastic = self._snapshot.kinetic, self._snapshot.elastic

    def _factorise(self, h: float) -> bool:
        reduced = self.body.reduced
        K, C, M, branches = reduced.stiffness, reduced.damping, reduced.mass, self.body.branches

        def matrix(mu: complex) -> sparse.csc_array:
            whole = K + mu * C + mu**2 * M
            return sparse.csc_array(whole if branches is None else whole + branches.added(mu))

        self._factor_step = h
        self.factorisations += 1
        mu = self.tableau.real / h
        try:
            self._real = spla.splu(matrix(mu))
            self._pairs = [spla.splu(matrix(pair)) for pair in self.tableau.pairs / h]
        except RuntimeError:  # exactly singular
            return False
        return True


def _quintic(
    part: float, h: float, old: Floats, new: Floats, rates: tuple[Floats, Floats]
) -> tuple[Floats, Floats, Floats]:
    """Return displacement, velocity and acceleration at a ``part`` of a step ``h`` from all three at both ends."""
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


def linear_radau(
    system: System, supports: SupportState, *, tolerance: float | Tolerance, stages: int = 3
) -> LinearMotion:
    """Return Radau IIA with error control."""
    return LinearMotion(system, supports, radau(stages), tolerance)


def linear_midpoint(system: System, supports: SupportState) -> LinearMotion:
    """Return the implicit midpoint rule."""
    return LinearMotion(system, supports, MIDPOINT)
