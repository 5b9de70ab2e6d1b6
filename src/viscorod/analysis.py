"""The analyses of a model: equilibrium, simulation, modes; each returns a result object."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from viscorod.check import CheckReport, check
from viscorod.errors import InputError, SolveError
from viscorod.mechanics import geometric
from viscorod.mechanics.compiled import announce_compilation
from viscorod.model.description import ModelDescription
from viscorod.model.settings import EquilibriumSettings, SimulateSettings
from viscorod.model.values import number
from viscorod.results.dataset import dataset
from viscorod.results.run import Equilibrium, Run
from viscorod.solve import modes as small_motion
from viscorod.solve.discretise import discretise
from viscorod.solve.formulations import FORMULATIONS
from viscorod.solve.history import EnergyAccount, History, Snapshot
from viscorod.solve.integrators import INTEGRATORS, Integrator
from viscorod.solve.integrators.contract import StepReport
from viscorod.solve.loads import LoadState
from viscorod.solve.modes import Modes
from viscorod.solve.newton import NewtonReport, Outcome
from viscorod.solve.problem import Problem
from viscorod.solve.rigid import free_motions, undetermined
from viscorod.solve.static import StaticPath, StaticSolver
from viscorod.solve.step_control import ErrorControl, FixedSteps, StepControl
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.solve.time_step import chosen_time_step
from viscorod.solve.transient import Transient

__all__ = ["Case", "CheckReport", "Model", "as_model", "check", "run_case"]

TOLERANCE = 1e-4
SPECTRAL_RADIUS = 0.6
LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""

Progress = Callable[[float, float], None]


class Model(ModelDescription):
    """Rods, supports and loads (see :class:`ModelDescription`), and what can be computed of them."""

    def equilibrium(
        self,
        *,
        load_factor: float = 1.0,
        load_steps: int | None = None,
        progress: Progress | None = None,
        title: str = "",
    ) -> Equilibrium:
        """Find the static equilibrium under the loads at t = 0- (just before t = 0).

        Args:
            load_factor: multiple of all loads and prescribed motions.
            load_steps: number of equal load steps to start with; steps adapt anyway. None starts with one.
            progress: called with (load factor, step) after every load step.
            title: kept with the result.

        Raises:
            InputError: the model is inconsistent, or free to move as a rigid body.
            SolveError: no equilibrium was found; ``run`` holds the load steps that were.
        """
        settings = EquilibriumSettings(**({} if load_steps is None else {"load_steps": load_steps}))
        work = _Workplace.of(self)
        try:
            factor = number(load_factor)
        except InputError:
            raise InputError(f"load_factor = {load_factor!r}: give a finite number such as 1.0") from None
        return work.equilibrium(factor, settings.load_steps or 1, progress, self._attrs(title))

    def simulate(
        self,
        duration: float,
        *,
        tolerance: float | None = None,
        time_step: float | None = None,
        initial: str = "equilibrium",
        integrator: str = "radau",
        spectral_radius: float | None = None,
        output_interval: float | None = None,
        progress: Progress | None = None,
        title: str = "",
    ) -> Run:
        """Compute the motion from t = 0 to ``duration``.

        Args:
            duration: simulated time [s].
            tolerance: wanted accuracy: displacements over the size of the model, rotations in rad (1e-4 for "radau";
                "generalized_alpha" has equal steps without it).
            time_step: the step [s] of integrators with equal steps (None chooses it from the lowest modes), the
                largest step of the others.
            initial: "equilibrium" under the loads at t = 0-, or the "reference" shape.
            integrator: "radau", "generalized_alpha" or "midpoint".
            spectral_radius: numerical damping of unresolved frequencies by "generalized_alpha", 0 (most) to 1 (none).
            output_interval: time between stored states [s]; None stores every step.
            progress: called with (time, step) after every step.
            title: kept with the result.

        Raises:
            InputError: the model or a setting is wrong.
            SolveError: a step failed however small; ``run`` holds the motion up to there.
        """
        given: dict[str, Any] = {"duration": duration, "initial": initial, "integrator": integrator}
        optional = {
            "tolerance": tolerance,
            "time_step": time_step,
            "spectral_radius": spectral_radius,
            "output_interval": output_interval,
        }
        given |= {name: value for name, value in optional.items() if value is not None}
        settings = SimulateSettings(**given)
        return _Workplace.of(self).simulate(settings, progress, self._attrs(title))

    def modes(self, count: int = 6, *, about: str = "equilibrium") -> Modes:
        """Find the slowest small damped vibrations about the equilibrium at t = 0- or about the reference shape.

        Args:
            count: number of modes.
            about: "equilibrium" or "reference" (as if free of load).

        Returns:
            eigenvalues [1/s], frequencies [Hz], damping ratios and shapes.
        """
        if about not in ("equilibrium", "reference"):
            raise InputError(f"about = {about!r}: give 'equilibrium' or 'reference'")
        if not isinstance(count, int | np.integer) or count < 1:
            raise InputError(f"count = {count!r}: give a whole number of at least 1")
        work = _Workplace.of(self)
        state = work.reference()
        if about == "equilibrium":
            work.settle(state)
        linear = small_motion.linearise(work.static, state, scale=1.0 if about == "equilibrium" else 0.0)
        return small_motion.complex_modes(work.static, state, linear, count)

    def _attrs(self, title: str) -> dict[str, Any]:
        from viscorod import __version__

        return {"title": title, "case": json.dumps(self.to_dict()), "version": __version__}


class Case(Protocol):
    """What a case file holds: a described model, the settings of one analysis, a title."""

    @property
    def description(self) -> ModelDescription:
        """The described model."""

    @property
    def settings(self) -> SimulateSettings | EquilibriumSettings:
        """The settings of the analysis that the file asks for."""

    @property
    def title(self) -> str:
        """The title, or empty."""


def run_case(case: Case, *, progress: Progress | None = None) -> Run | Equilibrium:
    """Do what a case file asks for."""
    model = as_model(case.description)
    given = {name: getattr(case.settings, name) for name in case.settings.model_fields_set}
    if isinstance(case.settings, EquilibriumSettings):
        return model.equilibrium(**given, progress=progress, title=case.title)
    return model.simulate(**given, progress=progress, title=case.title)


def as_model(description: ModelDescription) -> Model:
    """Give a description its analyses."""
    return Model.of(
        description.rods,
        description.supports,
        description.loads,
        description.attachments,
        description.velocities,
    )


@dataclass
class _Workplace:
    """One discretised model with the objects that solve it."""

    problem: Problem
    system: System
    supports: SupportState
    static: StaticSolver
    history: History = field(default_factory=History)
    began: float = field(default_factory=time.perf_counter)

    @classmethod
    def of(cls, model: ModelDescription, formulation: str = "geometric") -> _Workplace:
        problem = discretise(model)
        announce_compilation(geometric.assemble)
        system = FORMULATIONS[formulation](problem)
        supports = SupportState(problem)
        return cls(problem, system, supports, StaticSolver(system, supports))

    def reference(self) -> State:
        n = self.problem.size
        return State(self.problem.positions.copy(), self.problem.quaternions.copy(), np.zeros((n, 6)))

    def equilibrium(
        self, factor: float, load_steps: int, progress: Progress | None, attrs: dict[str, Any]
    ) -> Equilibrium:
        self._require_held(self.static.loads.at(0.0, True, factor))
        state = self.reference()
        last = 0.0

        def on_step(reached: float, state: State, iterations: int) -> None:
            nonlocal last
            account = EnergyAccount(elastic=self.system.elastic_energy())
            snapshot = Snapshot.of(reached, state, self.system, self.supports)
            self.history.record(snapshot, account, reached - last, iterations)
            if progress is not None:
                progress(reached, reached - last)
            last = reached

        path = self.static.solve(state, factor=factor, first_step=1.0 / load_steps, on_step=on_step)
        attrs |= {
            "outcome": path.outcome.name.lower(),
            "steps": len(path.factors),
            "iterations": sum(path.iterations) + path.wasted,
            "factorisations": sum(path.iterations) + path.wasted,
            "rejected": path.rejected,
        }
        if path.outcome is not Outcome.COMPLETED:
            message = self._static_failure(path)
            partial = (
                Equilibrium(self._dataset("equilibrium", attrs | {"message": message}))
                if path.factors
                else None
            )
            raise SolveError(message, partial)
        tangent = self.static.tangent(state, scale=factor)
        attrs["negative_eigenvalues"] = small_motion.negative_eigenvalues(tangent)
        return Equilibrium(self._dataset("equilibrium", attrs))

    def settle(self, state: State) -> None:
        """Move ``state`` to the equilibrium at t = 0-; the reference shape itself if nothing acts."""
        self.supports.update(0.0, True)
        loads = self.static.loads.at(0.0, True)
        if loads.none and not self.supports.target.any():
            return
        self._require_held(loads)
        path = self.static.solve(state)
        if path.outcome is not Outcome.COMPLETED:
            raise SolveError(f"The initial equilibrium was not found. {self._static_failure(path)}")

    def _require_held(self, loads: LoadState) -> None:
        """Refuse a static solution if supports and loads leave a rigid motion undetermined."""
        motions = free_motions(self.problem)
        if not motions:
            return
        self.system.assemble(self.reference(), loads, None, tangent=True, moving=False)
        loose = undetermined(self.problem, self.system.external, self.system.band.sparse(), motions)
        if loose:
            raise InputError(
                "no static equilibrium: nothing holds the model against "
                f"{'; '.join(motion.text for motion in loose)}. "
                "Add supports, or start a simulation from the reference shape (initial = 'reference')"
            )

    def simulate(self, settings: SimulateSettings, progress: Progress | None, attrs: dict[str, Any]) -> Run:
        state = self.reference()
        if settings.initial == "equilibrium":
            self.settle(state)
        state.twist[:] = self.problem.initial_twist(state.r, state.q)
        integrator, control, chosen = self._stepping(settings, state)
        transient = Transient(self.problem, integrator, control, self.system.worst_place)
        began = time.perf_counter()
        result = transient.run(
            state, settings.duration, output_interval=settings.output_interval, progress=progress
        )
        effort = result.effort
        self.history = result.history
        attrs |= chosen | {
            "outcome": result.outcome.name.lower(),
            "integrator": settings.integrator,
            "loop_time_s": time.perf_counter() - began,
            "steps": effort.steps,
            "iterations": effort.iterations,
            "evaluations": effort.evaluations,
            "factorisations": effort.factorisations,
            "jacobians": effort.jacobians,
            "rejected": effort.rejected,
            "smallest_step": effort.smallest_step,
            "smallest_step_at": effort.smallest_at,
            "smallest_step_why": effort.smallest_why,
            "warnings": json.dumps(result.notes),
        }
        if result.outcome is Outcome.INTERRUPTED:
            message = f"Stopped at t = {integrator.t:.6g} s: {result.reason}"
            raise SolveError(message, Run(self._dataset("simulate", attrs | {"message": message})))
        if result.outcome is not Outcome.COMPLETED:
            assert result.report is not None
            message = (
                f"The motion could not be followed beyond t = {integrator.t:.6g} s (a step to {result.failed_at:.6g} s "
                f"failed): {result.outcome.value}.{self._where(result.report)} "
                f"What to try: {result.outcome.advice(static=False)}."
            )
            raise SolveError(message, Run(self._dataset("simulate", attrs | {"message": message})))
        return Run(self._dataset("simulate", attrs))

    def _stepping(
        self, settings: SimulateSettings, state: State
    ) -> tuple[Integrator, StepControl, dict[str, Any]]:
        """Return integrator, step control and what was chosen, by name."""
        tolerance, duration = settings.tolerance, settings.duration
        if settings.integrator == "radau" and tolerance is None:
            tolerance = TOLERANCE
        make = INTEGRATORS[settings.integrator]
        given: dict[str, Any] = {}
        if settings.integrator == "generalized_alpha":
            radius = settings.spectral_radius
            given["spectral_radius"] = SPECTRAL_RADIUS if radius is None else radius
        if tolerance is not None:
            largest = settings.time_step or duration / LEAST_STEPS
            for period in self.problem.periods:
                largest = min(largest, period / STEPS_PER_PERIOD)
            integrator = make(self.system, self.supports, **given, tolerance=tolerance)
            control: StepControl = ErrorControl(integrator.order, largest, duration)
            return integrator, control, given | {"tolerance": tolerance, "largest_step": largest}
        step = settings.time_step
        if step is None:
            linear = small_motion.linearise(
                self.static, state, scale=1.0 if settings.initial == "equilibrium" else 0.0
            )
            frequencies = small_motion.natural_frequencies(linear, 16)
            step = chosen_time_step(self.problem, frequencies, duration)
        return make(self.system, self.supports, **given), FixedSteps(step), given | {"time_step": step}

    def _dataset(self, kind: str, attrs: dict[str, Any]) -> Any:
        complete = {
            "message": "",
            "scale_length": self.problem.length,
            "energy_scale": self.problem.length * max(float(s.stiffness.max()) for s in self.problem.sets),
            "wall_time_s": time.perf_counter() - self.began,
        } | attrs
        return dataset(kind, self.problem, self.system, self.history, complete)

    def _static_failure(self, path: StaticPath) -> str:
        assert path.report is not None
        reached = path.factors[-1] if path.factors else 0.0
        text = (
            f"No equilibrium beyond {reached:.6g} of the loads (tried {path.load_level:.6g}): {path.outcome.value}."
            f"{self._where(path.report)} What to try: {path.outcome.advice(static=True)}."
        )
        free = free_motions(self.problem)
        if free:
            text += f" Free rigid motions: {', '.join(motion.text for motion in free)}."
        return text

    def _where(self, report: NewtonReport | StepReport) -> str:
        return (
            f" Largest imbalance {report.residual:.3g} N at {self.system.worst_place(report.node)}, "
            f"after {report.iterations} iterations."
        )
