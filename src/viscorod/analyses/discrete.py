"""The analyses of one discretised model, put together from the solvers; each returns a result object."""

from __future__ import annotations

import json
import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.material_record import material_record
from viscorod.analyses.modal_damping import with_known_times
from viscorod.errors import InputError, SolveError
from viscorod.mechanics.compilation.compiled import announce_compilation, announce_formulation
from viscorod.mechanics.elements import geometric_element as geometric
from viscorod.mechanics.elements.held_strains import add_held_strains
from viscorod.mechanics.elements.maxwell_branches import remember
from viscorod.mechanics.joints.joint_forces import joint_forces
from viscorod.model.description.model_description import ModelDescription
from viscorod.results.data_schema import AXES
from viscorod.results.dataset import dataset
from viscorod.results.result_places import ResultPlace, ResultPlaces
from viscorod.results.run import Equilibrium
from viscorod.solve.constraints.redundancy import require_independent
from viscorod.solve.constraints.rigid_motions import free_motions, undetermined
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import EnergyAccount, History, Snapshot, StationReader
from viscorod.solve.modes import vibrations as small_motion
from viscorod.solve.modes.vibrations import Modes
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings import PathSettings
from viscorod.solve.statics.arc_length import Path, PathFollower, PathPoint
from viscorod.solve.statics.newton import NewtonReport, Outcome
from viscorod.solve.statics.static_solver import StaticPath, StaticSolver
from viscorod.solve.statics.tangent import negative_eigenvalues
from viscorod.solve.transient.integrators.contract import StepReport

if TYPE_CHECKING:
    import xarray as xr


__all__ = ["DiscreteModel"]

Progress = Callable[[float, float], None]

PATIENCE = 10.0
"""Seconds between two words on an initial equilibrium: a motion shows no progress before it has begun."""


@dataclass
class DiscreteModel:
    """One discretised model with the objects that solve it."""

    problem: Problem
    system: System
    supports: SupportState
    static: StaticSolver
    materials: dict[str, str]
    history: History = field(default_factory=History)
    began: float = field(default_factory=time.perf_counter)

    @classmethod
    def of(
        cls,
        model: ModelDescription,
        formulation: str = "geometric",
        damping: str = "full",
        stop: Callable[[], str] | None = None,
    ) -> DiscreteModel:
        """Discretise a model; ``stop`` is asked in every iteration of its statics, see ``Model.equilibrium``.

        Raises:
            InputError: it is inconsistent.
        """
        model = with_known_times(model)
        problem = discretise(model)
        announce_compilation(geometric.assemble)
        if problem.constrained:
            announce_formulation(joint_forces if problem.joints.count else add_held_strains)
        if problem.relaxing:
            announce_formulation(remember)
        system = FORMULATIONS[formulation, damping](problem)
        supports = SupportState(problem)
        require_independent(system, supports)
        static = StaticSolver(system, supports, stop=stop)
        return cls(problem, system, supports, static, material_record(model))

    def equilibrium(
        self, factor: float, load_steps: int, progress: Progress | None, attrs: dict[str, Any]
    ) -> Equilibrium:
        """Find the equilibrium at ``factor`` times the loads; see ``Model.equilibrium``."""
        self._require_held(self.static.loads.at(0.0, True, factor))
        state = State.reference(self.problem)
        last = 0.0

        def on_step(reached: float, state: State, iterations: int) -> None:
            nonlocal last
            account = EnergyAccount(elastic=self.system.elastic_energy())
            snapshot = Snapshot.of(state, self.system, self.supports)
            self.history.record(reached, snapshot, account, reached - last, iterations)
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
            "linear_solver": self.problem.plan.description,
        }
        if path.outcome is not Outcome.COMPLETED:
            message = self._static_failure(path)
            partial = (
                Equilibrium.later(self._later("equilibrium", attrs | {"message": message}))
                if path.factors
                else None
            )
            raise SolveError(message, partial)
        tangent = self.static.tangent(state, scale=factor)
        attrs["negative_eigenvalues"] = negative_eigenvalues(tangent)
        return Equilibrium.later(self._later("equilibrium", attrs))

    def path(self, settings: PathSettings, progress: Progress | None, attrs: dict[str, Any]) -> Equilibrium:
        """Follow a path of equilibria; see ``Model.path``."""
        loads = self.static.loads.at(0.0, True, 1.0)
        self.supports.update(0.0, True)
        if loads.none and not self.supports.target.any():
            raise InputError(
                "no path to follow: no load and no prescribed motion acts at t = 0; add a load without until"
            )
        self._require_held(loads)
        unit = abs(settings.target or 1.0)
        follower = PathFollower(self.static, unit)
        history = self.history

        def on_point(point: PathPoint) -> None:
            account = EnergyAccount(elastic=self.system.elastic_energy())
            snapshot = Snapshot.of(point.state, self.system, self.supports)
            step = point.factor - (history.instant[-1] if history.instant else 0.0)
            history.record(point.factor, snapshot, account, step, point.iterations)
            history.unstable.append(point.unstable)
            if progress is not None:
                progress(point.factor, step)

        path = follower.follow(
            State.reference(self.problem),
            load_factor=settings.target,
            endings=[self._displacement(settings)] if settings.place is not None else [],
            largest=settings.arc_length,
            points=settings.points,
            turns=settings.turns,
            on_point=on_point,
        )
        attrs |= {
            "outcome": path.outcome.name.lower(),
            "steps": path.count,
            "iterations": path.iterations,
            "rejected": path.rejected,
            "limit_points": json.dumps(path.limit_points),
            "bifurcations": json.dumps(path.bifurcations),
        }
        if path.outcome is Outcome.COMPLETED:
            return self._found_path(attrs)
        message = self._path_failure(path)
        if path.outcome is Outcome.POINTS:
            return self._found_path(attrs | {"message": message})
        raise SolveError(message, self._found_path(attrs | {"message": message}) if path.count else None)

    def _found_path(self, attrs: dict[str, Any]) -> Equilibrium:
        unstable = self.history.unstable[-1]
        return Equilibrium.later(self._later("equilibrium", attrs | {"negative_eigenvalues": unstable}))

    def site(self, place: str) -> ResultPlace:
        """A place by its name, before there is a data set."""
        problem = self.problem
        stations = problem.stations
        names, still = list(problem.bodies.names), np.zeros(len(problem.bodies.names))
        return ResultPlaces.of(
            np.array([*np.array(problem.rods)[stations.rod], *names]),
            np.append(stations.s, still),
            np.append(problem.rod_orders[stations.rod], still.astype(np.int64)),
        ).at(place)

    def _displacement(self, settings: PathSettings) -> Callable[[PathPoint], float]:
        """How far a displacement is from that at which a path is to end, of the model's length."""
        assert settings.place is not None
        assert settings.axis is not None
        assert settings.displacement is not None
        problem, reader = self.problem, StationReader(self.problem)
        start = reader.read(problem.positions, problem.quaternions, np.zeros((problem.size, 6)))[0]
        site = self.site(settings.place)
        component, wanted = AXES.index(settings.axis), settings.displacement

        def lacking(point: PathPoint) -> float:
            position = reader.read(point.state.r, point.state.q, point.state.twist)[0]
            return float(site.of(position - start)[component] - wanted) / problem.length

        return lacking

    def _path_failure(self, path: Path) -> str:
        reached = self.history.instant[-1] if self.history.instant else 0.0
        if path.outcome is Outcome.INTERRUPTED:
            return f"Stopped at {reached:.6g} of the loads, {path.count} points: {path.reason}"
        text = (
            f"The path was followed to {reached:.6g} of the loads, {path.count} points: {path.outcome.value}."
        )
        if path.outcome is Outcome.POINTS:
            return f"{text} What to try: {path.outcome.advice(static=True)}."
        where = self.where(path.report) if path.report is not None else ""
        advice = "give a smaller arc_length, or a small load that prefers one way where the path branches"
        if path.count < 2:
            advice = "look for what moves freely, or is held twice, in the reference shape"
        return f"{text}{where} What to try: {advice}."

    def modes(self, count: int, about: str) -> Modes:
        """Find the ``count`` slowest small motions; see ``Model.modes``."""
        state = State.reference(self.problem)
        before, loaded = about != "released", about != "reference"
        if loaded:
            self.settle(state, before=before)
        linear = small_motion.linearise(self.static, state, before=before, scale=1.0 if loaded else 0.0)
        return small_motion.complex_modes(self.static, state, linear, count)

    def settle(self, state: State, *, before: bool = True) -> None:
        """Move ``state`` to the equilibrium just before or after t = 0; the reference shape itself if nothing acts."""
        self.supports.update(0.0, before)
        loads = self.static.loads.at(0.0, before)
        strained = self.system.constraints.is_strained(state, 0.0, before=before)
        if loads.none and not self.supports.target.any() and not strained:
            return
        self._require_held(loads)
        told = time.perf_counter()

        def tell(reached: float, *_: Any) -> None:
            nonlocal told
            if reached < 1.0 and time.perf_counter() - told > PATIENCE:
                told = time.perf_counter()
                logging.getLogger("viscorod").warning(
                    "viscorod: looking for the initial equilibrium, %.3g of the loads reached", reached
                )

        path = self.static.solve(state, before=before, on_step=tell)
        if path.outcome is not Outcome.COMPLETED:
            raise SolveError(f"The initial equilibrium was not found. {self._static_failure(path)}")

    def require_closed(self) -> None:
        """Refuse to start from a reference shape in which joints are open."""
        constraints = self.system.constraints
        constraints.update(0.0)
        gaps = constraints.open_joints(driven=constraints.target)
        if gaps:
            raise InputError(
                f"initial = 'reference': joints are open in the reference shape: {', '.join(gaps)}. "
                "Start from the equilibrium (initial = 'equilibrium'), which closes them, move the parts so that they "
                "meet, or let motors begin at 0"
            )

    def _require_held(self, loads: LoadState) -> None:
        """Refuse a static solution if supports and loads leave a rigid motion undetermined."""
        motions = free_motions(self.problem)
        if not motions:
            return
        self.system.assemble(State.reference(self.problem), loads, None, tangent=True, moving=False)
        size = 6 * self.problem.size
        stiffness = self.system.matrix.sparse()[:size, :size]
        loose = undetermined(self.problem, self.system.external, stiffness, motions)
        if loose:
            raise InputError(
                "no static equilibrium: nothing holds the model against "
                f"{'; '.join(motion.text for motion in loose)}. "
                "Add supports, or take the reference shape (initial = 'reference' of a simulation, "
                "about = 'reference' of modes)"
            )

    def dataset(self, kind: str, attrs: dict[str, Any]) -> xr.Dataset:
        """The data set of what is known now."""
        return self._later(kind, attrs)()

    def _later(self, kind: str, attrs: dict[str, Any]) -> Callable[[], xr.Dataset]:
        """The data set of what is known now, built when asked for: that takes half as long as a small equilibrium."""
        complete = self.complete(attrs)
        return partial(dataset, kind, self.problem, self.system.gauss_positions(), self.history, complete)

    def complete(self, attrs: dict[str, Any]) -> dict[str, Any]:
        """Attributes of a data set, with those that all have."""
        return (
            {
                "message": "",
                "scale_length": self.problem.length,
                "energy_scale": self.problem.length
                * max(float(s.stiffness.max()) for s in self.problem.sets),
                "wall_time_s": time.perf_counter() - self.began,
            }
            | self.materials
            | attrs
        )

    def _static_failure(self, path: StaticPath) -> str:
        reached = path.factors[-1] if path.factors else 0.0
        if path.outcome is Outcome.INTERRUPTED:
            return f"Stopped at {reached:.6g} of the loads (trying {path.load_level:.6g}): {path.reason}"
        assert path.report is not None
        text = (
            f"No equilibrium beyond {reached:.6g} of the loads (tried {path.load_level:.6g}): {path.outcome.value}."
            f"{self.where(path.report)} What to try: {path.outcome.advice(static=True)}."
        )
        gaps = self.system.constraints.open_joints(1.0 - reached)
        if gaps:
            text += f" Joints that are open in the reference shape could not be closed; still open: {', '.join(gaps)}."
        free = free_motions(self.problem)
        if free:
            text += f" Free rigid motions: {', '.join(motion.text for motion in free)}."
        return text

    def where(self, report: NewtonReport | StepReport) -> str:
        """A sentence on where a solution failed."""
        return (
            f" Largest imbalance {report.residual:.3g} N at {self.system.describe_node(report.node)}, "
            f"after {report.iterations} iterations."
        )
