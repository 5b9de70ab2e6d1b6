"""The analyses of one discretised model, put together from the solvers; each returns a result object."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError, SolveError
from viscorod.material_record import material_record
from viscorod.mechanics import geometric, intrinsic
from viscorod.mechanics.compiled import announce_compilation, announce_formulation
from viscorod.mechanics.held_strains import add_held_strains
from viscorod.mechanics.joints import joint_forces
from viscorod.mechanics.relaxation import remember
from viscorod.modal_damping import with_known_times
from viscorod.model.description import ModelDescription
from viscorod.model.event import Crossing, Decayed
from viscorod.model.settings import LEAST_TOLERANCE, PathSettings, SimulateSettings
from viscorod.results.dataset import dataset
from viscorod.results.places import Site, Sites
from viscorod.results.run import Equilibrium, Run
from viscorod.results.schema import AXES, annotated
from viscorod.results.storage import read
from viscorod.solve import modes as small_motion
from viscorod.solve.arc_length import Path, PathFollower, PathPoint
from viscorod.solve.discretise import discretise
from viscorod.solve.events import CrossingMonitor, FadedMotion, LastingMonitor, Monitor, StillStrains, Watch
from viscorod.solve.formulations import FORMULATIONS
from viscorod.solve.history import EnergyAccount, History, Snapshot, StationReader
from viscorod.solve.initial_shape import strain_rods
from viscorod.solve.integrators import INTEGRATORS, LINEAR_INTEGRATORS, Integrator
from viscorod.solve.integrators.contract import StepReport
from viscorod.solve.loads import LoadState
from viscorod.solve.modes import Modes
from viscorod.solve.newton import NewtonReport, Outcome
from viscorod.solve.pose_check import pose_gap
from viscorod.solve.problem import Problem
from viscorod.solve.redundancy import require_independent
from viscorod.solve.rigid import free_motions, undetermined
from viscorod.solve.static import StaticPath, StaticSolver
from viscorod.solve.step_control import ErrorControl, FixedSteps, StepControl
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State, System
from viscorod.solve.time_step import chosen_time_step
from viscorod.solve.transient import Transient

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.streaming import Stream

__all__ = ["Workplace"]

TOLERANCE = 1e-4
PART_OF_MOTION = 1e-3
"""Largest tolerance as a part of the displacement from which a free vibration starts."""
ROUND_OFF = 1e-9
"""Displacement over the size of the model that is none."""
SPECTRAL_RADIUS = 0.6
LEAST_STEPS = 10
"""Steps of a run at least, when steps follow the error."""
STEPS_PER_PERIOD = 6
"""Steps per period of harmonic loads and motions at least: an error estimate cannot see what lies between stages."""

Progress = Callable[[float, float], None]


@dataclass
class Workplace:
    """One discretised model with the objects that solve it."""

    problem: Problem
    system: System
    supports: SupportState
    static: StaticSolver
    materials: dict[str, str]
    history: History = field(default_factory=History)
    began: float = field(default_factory=time.perf_counter)

    @classmethod
    def of(cls, model: ModelDescription, formulation: str = "geometric", damping: str = "full") -> Workplace:
        """Discretise a model.

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
        return cls(problem, system, supports, StaticSolver(system, supports), material_record(model))

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
        attrs["negative_eigenvalues"] = small_motion.negative_eigenvalues(tangent)
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

    def _displacement(self, settings: PathSettings) -> Callable[[PathPoint], float]:
        """How far a displacement is from that at which a path is to end, of the model's length."""
        assert settings.place is not None
        assert settings.axis is not None
        assert settings.displacement is not None
        problem, reader = self.problem, StationReader(self.problem)
        start = reader.read(problem.positions, problem.quaternions, np.zeros((problem.size, 6)))[0]
        site = self._site(settings.place)
        component, wanted = AXES.index(settings.axis), settings.displacement

        def lacking(point: PathPoint) -> float:
            position = reader.read(point.state.r, point.state.q, point.state.twist)[0]
            return float(site.of(position - start)[component] - wanted) / problem.length

        return lacking

    def _path_failure(self, path: Path) -> str:
        reached = self.history.instant[-1] if self.history.instant else 0.0
        text = (
            f"The path was followed to {reached:.6g} of the loads, {path.count} points: {path.outcome.value}."
        )
        if path.outcome is Outcome.POINTS:
            return f"{text} What to try: {path.outcome.advice(static=True)}."
        where = self._where(path.report) if path.report is not None else ""
        advice = "give a smaller arc_length, or a small load that prefers one way where the path branches"
        if path.count < 2:
            advice = "look for what moves freely, or is held twice, in the reference shape"
        return f"{text}{where} What to try: {advice}."

    def modes(self, count: int, about: str) -> Modes:
        """Find the ``count`` slowest small motions; see ``Model.modes``."""
        state = State.reference(self.problem)
        if about == "equilibrium":
            self.settle(state)
        linear = small_motion.linearise(self.static, state, scale=1.0 if about == "equilibrium" else 0.0)
        return small_motion.complex_modes(self.static, state, linear, count)

    def settle(self, state: State) -> None:
        """Move ``state`` to the equilibrium at t = 0-; the reference shape itself if nothing acts."""
        self.supports.update(0.0, True)
        loads = self.static.loads.at(0.0, True)
        if loads.none and not self.supports.target.any() and not self.system.constraints.strained(state, 0.0):
            return
        self._require_held(loads)
        path = self.static.solve(state)
        if path.outcome is not Outcome.COMPLETED:
            raise SolveError(f"The initial equilibrium was not found. {self._static_failure(path)}")

    def _require_closed(self) -> None:
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
                "Add supports, or start a simulation from the reference shape (initial = 'reference')"
            )

    def simulate(
        self,
        settings: SimulateSettings,
        progress: Progress | None,
        attrs: dict[str, Any],
        stream: Stream | None = None,
        stop: Callable[[], str] | None = None,
    ) -> Run:
        """Compute the motion; see ``Model.simulate``.

        Args:
            settings, progress: as there; attrs: of the data set.
            stream: where states go as they come; without one they stay in memory.
            stop: called after every step; returns why the run is to stop, or nothing.
        """
        state = State.reference(self.problem)
        if self.problem.initial_strain:
            self.system.given_strain = strain_rods(self.system, state)
        elif settings.initial == "equilibrium":
            self.settle(state)
        else:
            self._require_closed()
        state.twist[:] = self.problem.initial_twist(state.r, state.q)
        if settings.formulation == "intrinsic":
            announce_formulation(intrinsic.forces_at)
        integrator, control, chosen = self._stepping(settings, state)
        transient = Transient(self.problem, integrator, control, self.system.worst_place)
        began = time.perf_counter()

        def build(history: History) -> xr.Dataset:
            data = dataset("simulate", self.problem, self.system.gauss_positions(), history, attrs)
            return annotated(data, "simulate")

        def after_step() -> str:
            if stream is not None:
                stream.after_step(build, transient.saved)
            return "" if stop is None else stop()

        result = transient.run(
            state,
            settings.duration,
            output_interval=settings.output_interval,
            progress=progress,
            history=stream,
            checkpoint=None if stream is None else stream.checkpoint,
            after_step=after_step,
            watch=Watch(self._monitors(settings, state)),
        )
        effort = result.effort
        self.history = result.history
        if stream is not None and result.outcome is Outcome.INTERRUPTED:
            if stream.broken:
                raise InputError(result.reason)
            stream.save(build, transient.saved)
        attrs |= chosen | {
            "outcome": result.outcome.name.lower(),
            "integrator": settings.integrator,
            "formulation": settings.formulation,
            "damping": settings.damping,
            "dynamics": settings.dynamics,
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
            "warnings": json.dumps([*json.loads(attrs.get("doubts", "[]")), *result.notes]),
        }
        if settings.events:
            watch = transient.watch
            events = [{"time": t, "event": label} for t, label in zip(watch.times, watch.labels, strict=True)]
            attrs |= {"events": json.dumps(events), "ended_by": watch.ended_by}
        if self.system.constraints.rows:
            attrs["drift_position"], attrs["drift_velocity"] = integrator.drift
        if settings.dynamics == "nonlinear":
            attrs["linear_solver"] = self.problem.plan.description
        if settings.formulation == "intrinsic" and settings.dynamics == "nonlinear":
            attrs["pose_gap"], attrs["rotation_gap"] = pose_gap(self.system, self.history)
        message = ""
        if result.outcome is Outcome.INTERRUPTED:
            message = f"Stopped at t = {integrator.t:.6g} s: {result.reason}"
        elif result.outcome is not Outcome.COMPLETED:
            assert result.report is not None
            message = (
                f"The motion could not be followed beyond t = {integrator.t:.6g} s (a step to {result.failed_at:.6g} s "
                f"failed): {result.outcome.value}.{self._where(result.report)} "
                f"What to try: {result.outcome.advice(static=False)}."
            )
        run = self._run(attrs | {"message": message}, stream, build, result.outcome is Outcome.INTERRUPTED)
        if message:
            raise SolveError(message, run)
        return run

    def _run(
        self,
        attrs: dict[str, Any],
        stream: Stream | None,
        build: Callable[[History], xr.Dataset],
        interrupted: bool,
    ) -> Run:
        """Return the result of a motion; one that was streamed is a file then, unless it can still go on."""
        if stream is None:
            return Run(self._dataset("simulate", attrs))
        stream.flush(build)
        return Run(read(stream.finish(self._complete(attrs), keep=interrupted)))

    def _monitors(self, settings: SimulateSettings, state: State) -> list[Monitor]:
        """What the run is watched for."""
        found: list[Monitor] = []
        for event in settings.events:
            if isinstance(event, Crossing):
                found.append(
                    CrossingMonitor(
                        event.label,
                        event.stop,
                        self._quantity(event),
                        rising=event.direction != "falling",
                        falling=event.direction != "rising",
                    )
                )
                continue
            during = event.during or self._slowest_period(settings, state)
            so: Callable[[Snapshot], bool]
            if isinstance(event, Decayed):
                so = FadedMotion(event.amplitude**2)
            else:
                so = StillStrains(self.system.gauss_positions(), event.change / during)
            found.append(LastingMonitor(event.label, event.stop, so, during))
        return found

    def _quantity(self, event: Crossing) -> Callable[[Snapshot], float]:
        """The quantity of a crossing, less the value that is crossed."""
        reader, site = StationReader(self.problem), self._site(event.at)
        start = reader.read(
            self.problem.positions, self.problem.quaternions, np.zeros((self.problem.size, 6))
        )[0]
        component = AXES.index(event.quantity[-1])
        kind = event.quantity[:-1]

        def quantity(snapshot: Snapshot) -> float:
            state = snapshot.state
            position, _, velocity, _ = reader.read(state.r, state.q, state.twist)
            field = velocity if kind == "v" else position - start if kind == "u" else position
            return float(site.of(field)[component]) - event.value

        return quantity

    def _site(self, place: str) -> Site:
        """A place by its name, before there is a data set."""
        problem = self.problem
        stations = problem.stations
        names, still = list(problem.bodies.names), np.zeros(len(problem.bodies.names))
        return Sites.of(
            np.array([*np.array(problem.rods)[stations.rod], *names]),
            np.append(stations.s, still),
            np.append(problem.rod_orders[stations.rod], still.astype(np.int64)),
        ).at(place)

    def _slowest_period(self, settings: SimulateSettings, state: State) -> float:
        """Period of the slowest undamped vibration about the state that a motion starts from [s]."""
        linear = small_motion.linearise(
            self.static, state, scale=1.0 if settings.initial == "equilibrium" else 0.0
        )
        frequencies = small_motion.natural_frequencies(linear, 16)
        vibrating = frequencies[frequencies > 0.0]
        if not len(vibrating):
            raise InputError(
                "events: nothing vibrates, so that there is no period to wait for; give during (s)"
            )
        return float(2.0 * np.pi / vibrating.min())

    def _stepping(
        self, settings: SimulateSettings, state: State
    ) -> tuple[Integrator, StepControl, dict[str, Any]]:
        """Return integrator, step control and what was chosen, by name."""
        tolerance, duration = settings.tolerance, settings.duration
        if settings.integrator == "radau" and tolerance is None:
            tolerance = self._chosen_tolerance(state, duration)
        make = (LINEAR_INTEGRATORS if settings.dynamics == "linear" else INTEGRATORS)[settings.integrator]
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

    def _chosen_tolerance(self, state: State, duration: float) -> float:
        """The usual tolerance, or less where a free vibration starts so near to rest that this would swallow it."""
        problem = self.problem
        loads = self.static.loads.at(0.0)
        later = any(0.0 < t < duration for t in problem.breakpoints) or problem.periods
        if not loads.none or later or self.supports.moving or problem.joints.motions or state.twist.any():
            return TOLERANCE
        moved = float(np.abs(state.r - problem.positions).max()) / problem.length
        if moved < ROUND_OFF:
            return TOLERANCE
        return min(TOLERANCE, max(PART_OF_MOTION * moved, LEAST_TOLERANCE))

    def _dataset(self, kind: str, attrs: dict[str, Any]) -> xr.Dataset:
        return self._later(kind, attrs)()

    def _later(self, kind: str, attrs: dict[str, Any]) -> Callable[[], xr.Dataset]:
        """The data set of what is known now, built when asked for: that takes half as long as a small equilibrium."""
        complete = self._complete(attrs)
        return partial(dataset, kind, self.problem, self.system.gauss_positions(), self.history, complete)

    def _complete(self, attrs: dict[str, Any]) -> dict[str, Any]:
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
        assert path.report is not None
        reached = path.factors[-1] if path.factors else 0.0
        text = (
            f"No equilibrium beyond {reached:.6g} of the loads (tried {path.load_level:.6g}): {path.outcome.value}."
            f"{self._where(path.report)} What to try: {path.outcome.advice(static=True)}."
        )
        gaps = self.system.constraints.open_joints(1.0 - reached)
        if gaps:
            text += f" Joints that are open in the reference shape could not be closed; still open: {', '.join(gaps)}."
        free = free_motions(self.problem)
        if free:
            text += f" Free rigid motions: {', '.join(motion.text for motion in free)}."
        return text

    def _where(self, report: NewtonReport | StepReport) -> str:
        return (
            f" Largest imbalance {report.residual:.3g} N at {self.system.worst_place(report.node)}, "
            f"after {report.iterations} iterations."
        )
