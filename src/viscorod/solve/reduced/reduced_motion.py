"""Motions of the reduced intrinsic equations by collocation: Radau IIA, or the midpoint rule, which keeps energy."""

from __future__ import annotations

import numpy as np

from viscorod.solve.energy_account import StepShare
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot, Snapshots
from viscorod.solve.loss_within_steps import loss_within
from viscorod.solve.reduced.collocation_factors import CollocationFactors
from viscorod.solve.reduced.reduced_loads import ReducedLoads
from viscorod.solve.reduced.reduced_model import ReducedModel
from viscorod.solve.reduced.root_poses import stage_poses, unit
from viscorod.solve.reduced.sizes import distance, largest
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.transient.integrators.contract import Inside, Integrator, StepReport
from viscorod.solve.transient.integrators.stability import seen_by_halving, stability
from viscorod.solve.transient.integrators.tableau import MIDPOINT, Tableau, radau
from viscorod.solve.transient.motion_scale import GivenTolerance, Tolerance
from viscorod.solve.transient.time_step import first_time_step
from viscorod.typing import Floats

__all__ = ["ReducedMotion", "reduced_midpoint", "reduced_radau"]

ITERATIONS = 25
CONVERGED, FINEST = 1e-9, 1e-12
"""Change of the unknowns over the largest at which an iteration ends, of steps that follow the error and of others."""
ROUNDING = 1e-9
"""What rounding may leave of such a change."""
MOST_PARTS = 64
"""Parts of a step at most in which the motion in fewer modes follows."""
EXTRAPOLATED = 2.0
"""Length of a step over that of the last one up to which its stages are extrapolated."""
FAR = 1e3
"""Growth of the correction in an iteration beyond which it is given up."""
DIFFERENCE = 1e-7
"""Change of strains, over their size, by which loads are differentiated."""


class ReducedMotion:
    """Radau IIA or the midpoint rule, see :class:`~viscorod.solve.transient.integrators.contract.Integrator`.

    Args:
        model: the reduced one; tableau: the method.
        tolerance: wanted accuracy of the motion where the method has an error estimate.
        fewer: the same motion in fewer modes, which goes along to see what modes that are left out matter.

    Attributes:
        apart: by how much displacements [m] and rotations [rad] have differed from those in fewer modes ``(2,)``.
        moved: largest displacement and rotation from the start, likewise.
        forces_apart, loaded: the same of section forces [N] and moments [N m], and the largest of these ``(2,)``.
        open: how far loops of rods were from closed at most, and held places missed [m].
    """

    step_factor = 2.0
    looks_within = False
    drift = 0.0, 0.0
    """Supports are fulfilled by the basis."""

    def __init__(
        self,
        model: ReducedModel,
        tableau: Tableau,
        tolerance: float | Tolerance | None = None,
        fewer: ReducedMotion | None = None,
    ) -> None:
        self.model, self.tableau, self.fewer = model, tableau, fewer
        self.tolerance = GivenTolerance(tolerance) if isinstance(tolerance, float) else tolerance
        self.loads = ReducedLoads(model.problem)
        size = sum(model.equations.sizes)
        stages, roots, problem = len(tableau.nodes), len(model.shape.roots), model.problem
        self.estimate_order = stages
        self.t = 0.0
        self.state = State.reference(problem)
        self.kinetic = self.elastic = self.work = self.loss = self.outside = self.actuator = 0.0
        self.evaluations = self.factorisations = self.jacobians = 0
        self.apart, self.moved, self.open = np.zeros(2), np.zeros(2), 0.0
        self.forces_apart, self.loaded, self._gap = np.zeros(2), np.zeros(2), 0.0
        self._factors = CollocationFactors(tableau)
        self._begun = False
        self._last = stages - 1
        self._step = 0.0
        self._stages = np.zeros((stages, size))
        self._y, self._rate = np.zeros((2, size))
        self._before, self._rate_before = np.zeros((2, size))
        self._root, self._root_before = np.zeros((2, roots, 7))
        self._roots = np.zeros((stages, roots, 7))
        self._external = np.zeros((problem.size, 6))
        self._powers = np.zeros((stages, 3))
        self._start_r, self._start_q = np.zeros((problem.size, 3)), np.zeros((problem.size, 4))

    @property
    def records(self) -> int:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self._last + 2 if self._last else 1

    @property
    def strain(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return float(np.abs(self.model.strains(self._y[self._velocities :])[:, :3]).max())

    @property
    def branch_loss(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: there are no branches."""
        return np.zeros(0)

    @property
    def _velocities(self) -> int:
        return self.model.equations.sizes[0]

    # --- the contract

    def start(self, t: float, state: State) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        self.t = t
        if not self._begun:
            self._begun = True
            self._y = self.model.begun(state)
            nodes = [root.node for root in self.model.shape.roots]
            self._root = np.concatenate([state.r[nodes], state.q[nodes]], axis=1)
            self._start_r, self._start_q = state.r.copy(), state.q.copy()
        if self.fewer is not None:
            self.fewer.start(t, state)
        self._step = 0.0
        self._take(self._y, self._root, self._state(self._y, self._root), before=False)
        if self.tolerance is not None:
            self.tolerance.begin(t, self.state, self.unbalanced())

    def _take(self, y: Floats, root: Floats, state: State, *, before: bool) -> None:
        """Take over unknowns, roots and their state at the present time."""
        k = self._velocities
        self._y, self._root, self.state = y, root, state
        force, self._external, _ = self._forces(self.t, self.state, before=before)
        self._rate = self.model.equations.rates(y[None], force[None])[0]
        self.kinetic, self.elastic = 0.5 * float(y[:k] @ y[:k]), 0.5 * float(y[k:] @ y[k:])

    def unbalanced(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        rates = self.model.twists(self._rate[: self._velocities])
        return np.asarray(np.einsum("nij,nj->ni", self.model.problem.mass, rates))

    def first_step(self, duration: float) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        problem = self.model.problem
        held = np.zeros(problem.size)
        held[problem.supports.nodes[problem.supports.complete]] = 1.0
        return first_time_step(
            problem.mass, self.unbalanced(), self.state.twist, held, problem.length, duration
        )

    def attempt(self, end: float, *, before: bool) -> StepReport:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h, tableau, equations = end - self.t, self.tableau, self.model.equations
        D = tableau.derivative / h
        times = [
            end if i == self._last and self._last else self.t + c * h for i, c in enumerate(tableau.nodes)
        ]
        left = [before and i == self._last for i in range(len(times))]
        posed = any(self.loads.see_poses(t, before=b) for t, b in zip(times, left, strict=True))
        J = self._jacobian(posed=posed)
        self.jacobians += 1
        self.factorisations += 1
        if not self._factors.factorise(J, h):
            return StepReport(Outcome.SINGULAR, 0, 0.0, 0.0, 0)
        y, Z = self._y, self._guessed(h)
        converged = FINEST if self.tolerance is None else min(CONVERGED, 1e-3 * self.tolerance.value)
        size = max(float(np.abs(y).max()), float(np.abs(Z).max()), 1e-300)
        correction, iterations = np.inf, 0
        forces = self._stage_forces(h, times, left, y + Z, posed=posed)
        while True:
            change = self._factors.solve(
                D @ Z - equations.rates(y + Z, np.array([force for force, _, _ in forces]))
            )
            Z = Z - change
            iterations += 1
            previous, correction = correction, float(np.abs(change).max())
            size = max(size, float(np.abs(Z).max()))
            if not correction < FAR * max(size, previous if np.isfinite(previous) else size):
                return StepReport(Outcome.DIVERGED, iterations, 0.0, 0.0, 0)
            if correction <= converged * size:
                break
            if iterations == ITERATIONS or (
                iterations > 4 and correction > 0.5 * previous and correction > 1e-9 * size
            ):
                return StepReport(Outcome.SLOW, iterations, correction / size, 0.0, 0)
            if iterations > 4 and correction > 0.5 * previous:
                break  # round-off
            if posed:
                forces = self._stage_forces(h, times, left, y + Z, posed=True)
        self._stages = stage = y + Z
        self._roots = self._stage_roots(h, stage)
        self._loads = self._stage_forces(h, times, left, stage, posed=True) if posed else forces
        self._end, self._left = end, before
        self._reached = stage[-1] if self._last else 2.0 * stage[0] - y
        self._root_reached = unit(self._roots[-1] if self._last else 2.0 * self._roots[0] - self._root)
        self._state_reached = self._state(self._reached, self._root_reached)
        report = StepReport(Outcome.CONVERGED, iterations, correction / size, 0.0, 0)
        if self.tolerance is None:
            return report
        error = self.model.errors(self._factors.error(self._rate, Z, h), h)
        node, component = divmod(int(np.argmax(error)), 6)
        allowed = self.step_factor * self.tolerance.at(end, self._state_reached)
        return report._replace(error=float(error.max()) / allowed, node=node, component=component)

    def accept(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        h, k, equations = self._end - self.t, self._velocities, self.model.equations
        rates = self.tableau.derivative / h @ (self._stages - self._y)
        self._powers = np.array(
            [
                (float(u[:k] @ force) + outside, equations.dissipated(u, rate), outside)
                for u, rate, (force, _, outside) in zip(self._stages, rates, self._loads, strict=True)
            ]
        )
        self.work, self.loss, self.outside = (h * (self.tableau.weights @ self._powers)).tolist()
        self._before, self._rate_before, self._root_before = self._y, self._rate, self._root
        self.t, self._step = self._end, h
        self._take(self._reached, self._root_reached, self._state_reached, before=True)
        if self.tolerance is not None:
            self.tolerance.accept(self.t, self.state)
        self._compare()

    def _compare(self) -> None:
        """Let the motion in fewer modes take the same step, in parts if need be."""
        self.moved = np.maximum(self.moved, distance(self.state, self._start_r, self._start_q))
        self.open = max(self.open, self._gap)
        if self.fewer is None:
            return
        forces = self._section_forces()
        self.loaded = np.maximum(self.loaded, largest(forces))
        if not self.fewer.follow(self.t, before=self._left):
            self.apart = np.full(2, np.inf)
            self.fewer = None
            return
        self.apart = np.maximum(self.apart, distance(self.state, self.fewer.state.r, self.fewer.state.q))
        self.forces_apart = np.maximum(self.forces_apart, largest(forces - self.fewer._section_forces()))

    def _section_forces(self) -> Floats:
        return self.model.sections(self._y, self._rate)[2]

    def follow(self, end: float, *, before: bool) -> bool:
        """Go to the time ``end`` [s] in as few equal steps as converge; return whether that was possible."""
        begin, done, parts = self.t, 0, 1
        while done < parts:
            at = end if done + 1 == parts else begin + (end - begin) * (done + 1) / parts
            if self.attempt(at, before=before and at == end).converged:
                self.accept()
                done += 1
            elif parts < MOST_PARTS:
                done, parts = 2 * done, 2 * parts
            else:
                return False
        return True

    @property
    def section_force(self) -> Floats:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self.snapshot().section_force

    def snapshot(self) -> Snapshot:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return self.model.snapshot(self.state, self._y, self._rate, self._external)

    def between(self, parts: Floats) -> Inside:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: cubic between both ends."""
        h, model, s = self._step, self.model, parts[:, None]
        until = h * self.tableau.partial_weights(parts)
        work, _, outside = (until @ self._powers).T
        gap, first, last = self._y - self._before, h * self._rate_before, h * self._rate
        b, c = 3.0 * gap - 2.0 * first - last, first + last - 2.0 * gap
        y = self._before + s * (first + s * (b + s * c))
        rate = (first + s * (2.0 * b + s * 3.0 * c)) / h
        weights = self.tableau.polynomials(parts)
        roots = self._root_before + np.tensordot(weights, self._roots - self._root_before, 1)
        found = []
        for k, state in enumerate(self._states(y, unit(roots))):
            t = self.t - (1.0 - float(parts[k])) * h
            _, external, _ = self._forces(t, state, before=False)
            found.append(Snapshots.of(model.snapshot(state, y[k], rate[k], external)))
        loss = loss_within(until, self._powers[:, 1], self.loss)
        none = np.zeros((len(parts), 0))  # no rest strain changes here, and there are no branches
        share = StepShare(work, loss, outside, np.zeros(len(parts)), none)
        return Inside(Snapshots.joined(found), share)

    def watch(self, duration: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: rows of records are corners."""

    def resume(self) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`: all is saved."""

    def begin_half(self, whole: Integrator, place: float) -> None:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        del whole, place

    @property
    def seen_by_halving(self) -> float:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return seen_by_halving(self.tableau)

    def stability(self, z: np.ndarray) -> np.ndarray:
        """See :class:`~viscorod.solve.transient.integrators.contract.Integrator`."""
        return stability(self.tableau, z)

    # --- parts of a step

    def _guessed(self, h: float) -> Floats:
        """Return where the stages may be, less the state at the start ``(s, k + l)``."""
        nodes = self.tableau.nodes
        if self._step == 0.0 or h > EXTRAPOLATED * self._step:
            return nodes[:, None] * h * self._rate
        weights = self.tableau.polynomials(1.0 + nodes * h / self._step)
        return self._before + weights @ (self._stages - self._before) - self._y

    def _stage_roots(self, h: float, stage: Floats) -> Floats:
        """Return the poses of the roots at all stages ``(s, roots, 7)``."""
        twists = self.model.root_twists(stage[:, : self._velocities])
        return stage_poses(self.model.shape.roots, self._root, twists, h * self.tableau.matrix)

    def _states(self, y: Floats, roots: Floats) -> list[State]:
        """Return the nodal states of unknowns ``(s, k + l)`` and poses of roots ``(s, roots, 7)``."""
        k = self._velocities
        strains = self.model.strains(y[:, k:])
        r, q, self._gap = self.model.shape.poses(strains, roots[..., :3], roots[..., 3:], self.state.q)
        return [State(*one) for one in zip(r, q, self.model.twists(y[:, :k]), strict=True)]

    def _state(self, y: Floats, root: Floats) -> State:
        return self._states(y[None], root[None])[0]

    def _stage_forces(
        self, h: float, times: list[float], before: list[bool], stage: Floats, *, posed: bool
    ) -> list[tuple[Floats, Floats, float]]:
        """Return generalised forces, wrenches of the nodes, and what loads dissipate outside, at all stages."""
        self.evaluations += len(times)
        states = [self.state] * len(times)
        if posed:
            states = self._states(stage, self._stage_roots(h, stage))
        return [
            self._forces(t, state, before=left) for t, state, left in zip(times, states, before, strict=True)
        ]

    def _forces(self, t: float, state: State, *, before: bool) -> tuple[Floats, Floats, float]:
        external, outside = self.loads.wrenches(t, state, before=before)
        return self.model.basis.velocity.T @ external.ravel(), external, outside

    def _jacobian(self, *, posed: bool) -> Floats:
        """Return the derivatives of the rates at the start of the step, those of loads by differences."""
        J = self.model.equations.jacobian(self._y)
        if not posed:
            return J
        k, y = self._velocities, self._y
        first = 0 if self.loads.see_twists else k
        delta = DIFFERENCE * max(float(np.abs(y).max()), 1e-12)
        varied = y + delta * np.eye(len(y))[first:]
        roots = np.broadcast_to(self._root, (len(varied), *self._root.shape))
        base = self._forces(self.t, self.state, before=False)[0]
        for column, state in enumerate(self._states(varied, roots), first):
            J[:k, column] += (self._forces(self.t, state, before=False)[0] - base) / delta
        return J


def reduced_radau(
    model: ReducedModel, *, tolerance: float | Tolerance, stages: int = 3, fewer: ReducedMotion | None = None
) -> ReducedMotion:
    """Return Radau IIA with error control."""
    return ReducedMotion(model, radau(stages), tolerance, fewer)


def reduced_midpoint(model: ReducedModel, *, fewer: ReducedMotion | None = None) -> ReducedMotion:
    """Return the implicit midpoint rule, which keeps the energy of the reduced equations exactly."""
    return ReducedMotion(model, MIDPOINT, None, fewer)
