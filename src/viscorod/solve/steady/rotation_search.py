"""The search for a steady rotation: the first guess, the continuation from it, and what is refused."""

from __future__ import annotations

import numpy as np

from viscorod.errors import InputError, SolveError
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.statics.newton import Outcome
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady import continuation, initial_guess
from viscorod.solve.steady.geometric_steady import GeometricSteady
from viscorod.solve.steady.intrinsic_steady import IntrinsicSteady
from viscorod.solve.steady.rigid_rotation import (
    RotationAxis,
    coriolis,
    inertia_about,
    mass_centre,
    mean_spin,
    rigid_twists,
    spatial_momenta,
)
from viscorod.solve.steady.steady_checks import SupportKind, no_loads, support_kind
from viscorod.solve.steady.steady_equations import Measure, SteadyEquations
from viscorod.solve.steady.steady_rotation import SteadyRotation, describe_rotation
from viscorod.typing import Floats

STILL = 1e-9
"""Inertial forces of an unstrained rod that spins about its own axis, as a part of those about any axis."""


class Search:
    """Searches for the steady rotation that the settings select.

    Args:
        solver: of the model's statics, with its system and supports.
        start: the motion to start from, poses and twists of all nodes.
    """

    def __init__(self, solver: StaticSolver, settings: SteadySettings, start: State | None) -> None:
        self.solver, self.settings, self.start = solver, settings, start
        self.problem: Problem = solver.system.problem
        self.elements = solver.system.elements()
        self.held = support_kind(self.problem)
        self.loads: LoadState = solver.loads.at(0.0)
        self.joint = int(self.problem.supports.nodes[0]) if len(self.problem.supports.nodes) else 0
        self.effort = continuation.IterationCounts(solver.check_interrupt)
        solver.supports.update(0.0)

    def run(self) -> SteadyRotation:
        """Find the steady rotation and its small motions.

        Raises:
            InputError: there is none of this kind; SolveError: none was found.
        """
        equations = self.equations()
        return describe_rotation(self.solver, equations, self.effort.iterations, self.settings.modes)

    def equations(self) -> SteadyEquations:
        """Return the equations at the steady rotation.

        Raises:
            InputError: there is none of this kind; SolveError: none was found.
        """
        settings = self.settings
        linearised = settings.damping == "linearised"
        target = (
            float(np.linalg.norm(settings.spin))
            if settings.spin is not None
            else float(settings.energy or settings.momentum or 0.0)
        )
        kind = settings.measure
        if self.start is not None:
            equations = self._from_start()
            found = continuation.continue_to(equations, kind, target, self.effort, equations.measure(kind)[0])
        elif settings.driven or settings.axis is not None or linearised:
            equations = self._from_reference(target)
            found = continuation.continue_to(equations, kind, target, self.effort, 0.0)
        else:
            for way in (1.0, -1.0):  # a mode has no sign, but a curved rod may stay bent one way only
                equations, elastic = self._from_mode(way)
                found, (low, high) = continuation.search_branch(equations, kind, target, elastic, self.effort)
                if np.isfinite(low):
                    break
            if not found:
                raise SolveError(self._no_bent_message(kind, target, low, high))
        if not found:
            raise SolveError(
                f"No steady rotation was found with {kind} = {target:g} {_UNIT[kind]}, after {self.effort.iterations} "
                "iterations. What to try: another axis or start; begin from a slower or faster rotation "
                "(start = its result); of what is slack, the equilibrium in which it hangs (start), or a finer mesh"
            )
        return equations

    def driven(self) -> GeometricSteady:
        """Return the equations of rotations with the spin of the settings, from the unloaded or settled shape on."""
        found = self._from_reference(float(np.linalg.norm(np.asarray(self.settings.spin, dtype=float))))
        assert isinstance(found, GeometricSteady)
        return found

    # --- first guesses

    def _from_start(self) -> SteadyEquations:
        """Start from the given motion, rotating with its mean angular velocity."""
        assert self.start is not None
        state, mass = self.start.copy(), self.problem.mass
        centre = self._centre(state)
        if self.settings.driven:
            spin = np.asarray(self.settings.spin, dtype=float)
            turned = float(mean_spin(mass, state, centre) @ spin) / float(np.linalg.norm(spin)) ** 2
            spin = spin * turned if turned > 0.0 else spin
        else:
            if self.held is SupportKind.FREE:  # what travels is left out
                linear, _ = spatial_momenta(mass, state.r, state.q, state.twist, centre)
                unit = rigid_twists(state.r, state.q, [1.0, 0.0, 0.0], [0.0] * 3, centre)
                total = float(spatial_momenta(mass, state.r, state.q, unit, centre)[0][0])
                state.twist -= rigid_twists(state.r, state.q, linear / total, [0.0] * 3, centre)
            spin = mean_spin(mass, state, centre)
        rate = float(np.linalg.norm(spin))
        if not rate > 0.0:
            raise InputError("start: its last state does not turn; give one that does, or axis instead")
        return self._equations(state, None, RotationAxis(spin / rate, centre), rate)

    def _from_reference(self, target: float) -> SteadyEquations:
        """Start from the reference shape, or the equilibrium under the loads, about a given axis."""
        settings, problem = self.settings, self.problem
        state = State.reference(problem)
        acts = not no_loads(self.loads) or bool(problem.supports.motions)
        if settings.driven and acts and settings.formulation == "geometric":
            settled = state.copy()
            with np.errstate(all="ignore"):
                path_ = self.solver.solve(settled, before=False)
            if path_.outcome is Outcome.COMPLETED:
                state = settled
        centre = self._centre(state)
        if settings.driven:
            axis = np.asarray(settings.spin, dtype=float) / target
        elif settings.axis is not None:
            axis = np.array(settings.axis)
        else:
            axis = initial_guess.principal_axis(problem, state, centre)
        line = RotationAxis(axis, centre)
        if settings.damping == "linearised" and not settings.driven:
            self._require_principal_axis(state, line)
        return self._equations(state, None, line, self._rate(state, line, target))

    def _rate(self, state: State, line: RotationAxis, target: float) -> float:
        """Return the angular speed [rad/s] at which the given shape has the ``target``."""
        kind = self.settings.measure
        if kind == "spin":
            return target
        tensor = inertia_about(self.problem.mass, state.r, state.q, line.centre)
        inertia = float(line.direction @ tensor @ line.direction)
        return float(np.sqrt(2.0 * target / inertia)) if kind == "energy" else target / inertia

    def _from_mode(self, way: float) -> tuple[SteadyEquations, float]:
        """Start bent in the slowest elastic mode, about the axis of least inertia; return its elastic energy too."""
        state, strain, frequency, elastic = initial_guess.bent_shape(
            self.solver, self.problem, self.elements, self.joint, way
        )
        centre = self._centre(state)
        line = RotationAxis(initial_guess.principal_axis(self.problem, state, centre), centre)
        return self._equations(state, strain, line, frequency), elastic

    def _centre(self, state: State) -> Floats:
        if self.settings.centre is not None:
            return np.array(self.settings.centre)
        if self.held is SupportKind.JOINT:
            return np.array(self.problem.positions[self.joint])
        if self.held is SupportKind.FREE:
            return mass_centre(self.problem.mass, state.r, state.q)
        return np.zeros(3)

    def _equations(
        self, state: State, strain: Floats | None, line: RotationAxis, rate: float
    ) -> SteadyEquations:
        problem, supports = self.problem, self.problem.supports
        geometric = GeometricSteady(self.solver.system, self.solver.supports, self.loads, line, state, rate)
        if self.settings.formulation == "geometric":
            return geometric
        turned = geometric.state()
        free = np.ones((problem.size, 6), dtype=bool)
        for node, fixed in zip(supports.nodes, supports.fixed, strict=True):
            free[node] &= fixed == 0.0
        if self.held is SupportKind.JOINT:
            turned.twist[self.joint, :3] = 0.0
        return IntrinsicSteady(
            problem,
            self.elements,
            linearised=self.settings.damping == "linearised",
            free=free,
            following=self.loads.following,
            joint=self.joint,
            still=self.held is SupportKind.FREE,
            line=line,
            state=turned,
            strain=geometric.fields()[0] if strain is None else strain,
            relaxation=self.solver.system.relaxation,
        )

    # --- refusals

    def _require_principal_axis(self, state: State, line: RotationAxis) -> None:
        """Refuse axes about which gyroscopic forces arise: linearised damping makes such rotations fade (AWP 33)."""
        mass, (axis, centre) = self.problem.mass, (line.direction, line.centre)
        own = np.abs(coriolis(mass, rigid_twists(state.r, state.q, [0.0] * 3, axis, centre))).max()
        any_axis = max(
            np.abs(coriolis(mass, rigid_twists(state.r, state.q, [0.0] * 3, unit, centre))).max()
            for unit in np.eye(3)
        )
        if own <= STILL * any_axis:
            return
        curved = bool(np.abs(self.elements.reference[..., 3:5]).max() * self.problem.length > 1e-9)
        shape = "a curved rod has no such axis" if curved else "the mass is not on this axis"
        raise InputError(
            "damping = 'linearised': there is no such steady rotation. This damping fades everything but x1' = E^T x1 "
            "without strain: turning about the axis of a straight rod, on which its mass must be centred; "
            f"{shape}. Leave damping out for the full one, with which rods turn steadily about other axes as well"
        )

    def _no_bent_message(self, kind: Measure, target: float, low: float, high: float) -> str:
        unit = _UNIT[kind]
        known = (
            f"bent shapes were followed from {kind} = {low:g} to {high:g} {unit}"
            if np.isfinite(low)
            else "no bent shape was found near the slowest bending mode"
        )
        return (
            f"No bent steady rotation was found with {kind} = {target:g} {unit}: {known}. What to try: a value in "
            "between; axis = a direction about which the rod turns straight; start = a motion that has settled"
        )


_UNIT = {"spin": "rad/s", "energy": "J", "momentum": "N m s", "elastic": "J"}
