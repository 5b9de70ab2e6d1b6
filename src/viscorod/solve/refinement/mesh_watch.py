"""Watches the solutions of one problem for what a finer mesh would make of them, and says where to refine."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.formulations.system import State, System
from viscorod.solve.history import History, Snapshot
from viscorod.solve.problem.division import Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.correction import Balance, counterpart
from viscorod.solve.refinement.finer_divisions import MOST_CHOSEN_NODES, FinerDivisions, free_rods
from viscorod.solve.refinement.finer_mesh import Carried, FinerMesh, Shape
from viscorod.solve.refinement.finer_motion import finer_start, run_gaps
from viscorod.solve.refinement.half_elements import read
from viscorod.solve.refinement.inertial_forces import CoarseMotion
from viscorod.solve.refinement.linear_counterpart import LinearCounterpart
from viscorod.solve.refinement.mesh_estimate import MeshEstimate, difference
from viscorod.solve.refinement.noted_states import NotedStates
from viscorod.solve.refinement.phase_drift import AtRest, PhaseDrift
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.refinement.travelling_jumps import TravellingJumps
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.linear_model import LinearModel
from viscorod.typing import Floats

__all__ = ["MeshWatch"]

MOST_NODES = 20_000
"""Nodes of a problem beyond which no finer mesh is made."""
ANCHOR = 0.01
"""Part of the squared rate of a motion by which inertia resists errors, which change about as fast as it does."""
STILL = 1e-3
"""Part of the displacements at the start of a motion below which it hardly moves."""
INSTANTS = 6
"""Points of a path, about evenly chosen, that are looked at."""


class MeshWatch:
    """Estimates the errors that the mesh of one problem leaves in its solutions.

    Args:
        model: that was discretised; problem: what came of it; system: that solves it.
        wanted: whether errors are estimated; where the program chooses the mesh they always are.

    Attributes:
        estimate: the largest errors of all solutions seen, None before the first.
        found, lost: how many solutions had a counterpart on a finer mesh, and how many had none.
        noted: states that a motion passed.
    """

    def __init__(
        self, model: ModelDescription, problem: Problem, system: System, *, wanted: bool = True
    ) -> None:
        self.model, self.problem, self.system = model, problem, system
        self.wanted = wanted or bool(self.free)
        self.estimate: MeshEstimate | None = None
        self.found = self.lost = 0
        self.noted = NotedStates()
        self._at_rest: AtRest | None = None

    @cached_property
    def finer(self) -> FinerMesh:
        """The problem on elements half as long."""
        return FinerMesh(self.model, self.problem)

    @cached_property
    def _jumps(self) -> TravellingJumps:
        return TravellingJumps(self.model, self.problem)

    @cached_property
    def _moving(self) -> CoarseMotion:
        return CoarseMotion(self.finer)

    @property
    def _lengths(self) -> dict[str, float]:
        """Lengths of the rods [m]."""
        return dict(zip(self.problem.rods, map(float, self.problem.rod_lengths), strict=True))

    @property
    def affordable(self) -> bool:
        """Whether errors are wanted, of steps or of the mesh, and the problem is small enough."""
        return self.wanted and self.problem.size <= MOST_NODES

    @property
    def feasible(self) -> bool:
        """Whether errors of the mesh are estimated: there are rods that a finer one divides."""
        return self.affordable and bool(self.problem.rods)

    # --- what is seen

    def see(self, equilibrium: Snapshot, factor: float = 1.0, t: float = 0.0, *, before: bool = True) -> None:
        """Estimate the errors of an equilibrium under a multiple of the loads at a time [s]."""
        if self.feasible:
            self._compare(equilibrium, Balance(self.finer, t, before=before, factor=factor))

    def see_path(self, history: History, unit: float) -> None:
        """Estimate the errors of a path, orthogonally to it; ``unit`` is that of the load factor.

        Looked at are some of its points, the last one and that with the largest load, or one beside them: next to
        special points the finer mesh is singular elsewhere on the path.
        """
        if not self.feasible or not history.instant:
            return
        last = len(history.instant) - 1
        chosen = {int(k) for k in np.linspace(0, last, INSTANTS).round()} - {0}
        chosen |= {int(np.argmax(np.abs(history.instant)))}

        snapshots = history.snapshots

        def estimated(k: int) -> bool:
            return self._estimate(snapshots[k], Balance(self.finer, factor=history.instant[k], unit=unit))

        for k in sorted(chosen):
            beside = (near for near in (k, k - 1, k + 1) if 0 < near <= last)
            self._count_in(any(estimated(near) for near in beside))

    def phases(
        self, static: StaticSolver, start: Snapshot, scale: float, modes: StartModes | None = None
    ) -> PhaseDrift:
        """Compare the slowest vibrations about a state at rest under a multiple of the loads at t = 0."""
        found = PhaseDrift(self._moving, static, Shape.of(start), scale, modes, self._at_rest)
        self._at_rest = found.finer
        return found

    def share(self, other: MeshWatch) -> None:
        """Use the finer mesh of another watch of the same problem, and what is known of states at rest there."""
        assert self.problem is other.problem
        made = {"finer", "_moving", "_at_rest", "_jumps"}
        vars(self).update({name: value for name, value in vars(other).items() if name in made})

    def see_motion(
        self, last: tuple[float, Snapshot], static: StaticSolver, scale: float, modes: StartModes
    ) -> None:
        """Estimate the errors of the noted states of a motion: of their balance with inertia and viscosity, in time.

        Args:
            last: time [s] and state at its end; static: solver of its problem.
            scale: multiple of the loads at t = 0 under which it begins; modes: small motions about its start.
        """
        if not self.feasible:
            return
        noted = self.noted.with_last(last)
        times = [t for t, _ in noted]
        start, anchor = self.noted.start, (np.pi / last[0]) ** 2
        still = start is not None and self._still(start, noted)
        rates = self._compare_moving(noted, before=True, anchor=anchor, still=still)
        if start is not None:
            drift = self.phases(static, start, scale, modes)
            self._drift(drift, times, rates, drift.kicked(start.state.twist, self._begins(start)))

    def see_linear_motion(
        self, last: tuple[float, Snapshot], static: StaticSolver, scale: float, modes: StartModes
    ) -> None:
        """Estimate the errors of the noted states of a linear motion; see :meth:`see_motion`."""
        first = self.noted.start
        if not self.feasible or first is None:
            return
        start, finer = first.state, self.finer
        drift = self.phases(static, first, scale, modes)
        rest = drift.finer.state
        if rest is None or self.problem.relaxing:
            self._count_in(False)
            return
        coarse = LinearModel(self.system, self._moving.supports, 0.0, start)
        finely = LinearCounterpart(coarse, LinearModel(finer.system, finer.supports, 0.0, rest), self._moving)
        rates, seen, shape = [], [], start.twist.shape
        noted = self.noted.with_last(last)
        for t, snapshot in noted:
            now = finely.state(snapshot, t, before=True)
            rates.append(now.acceleration.reshape(shape))
            found = finely.better(
                now,
                t,
                before=True,
                anchor=self._resisting(rates[-1], snapshot.state.twist, (np.pi / last[0]) ** 2),
            )
            seen.append(found)
            self._count_in(True)
        shapes = [Shape.of(snapshot) for _, snapshot in noted]
        self._take_in(finer.carried(shapes), seen, [(t, True) for t, _ in noted])
        begun = finely.state(first, 0.0, before=False)
        kick = drift.kicked(start.twist, begun.acceleration.reshape(shape))
        self._drift(drift, [t for t, _ in noted], np.array(rates), kick)

    def _drift(self, drift: PhaseDrift, times: list[float], rates: Floats, kick: Floats) -> None:
        """Add what wrong frequencies make of the motion in time."""
        if self.estimate is not None:
            gaps, seen = drift.gaps(times, rates, (kick, 0.0))
            self.estimate = self.estimate.drifted(gaps, seen, self._lengths)

    def _still(self, start: Snapshot, noted: list[tuple[float, Snapshot]]) -> bool:
        """Return whether a motion that begins at rest, in a strained shape, hardly leaves it.

        On a finer mesh it would begin at another equilibrium: inertia does not hold it where this one is.
        """
        if start.state.twist.any():
            return False
        r = start.state.r
        strained = float(np.abs(r - self.problem.positions).max())
        near = all(np.abs(snapshot.state.r - r).max() <= STILL * strained for _, snapshot in noted)
        return near and strained > 0.0

    def _begins(self, start: Snapshot) -> Floats:
        """Return the rates of the twists of all nodes when a motion begins, after a jump of its loads ``(n, 6)``."""
        stress = self._moving.other_stress(start.state, start.section_force, 0.0, before=False)
        return np.asarray(self._moving.rates([Shape.of(start)], [stress], [0.0], before=False)[0])

    def finer_start(self, start: Snapshot, anchor: float) -> State | None:
        """Return where a motion from a state begins on the finer mesh; see :func:`finer_motion.finer_start`."""
        return finer_start(self._moving, start, anchor)

    def see_steady(self, rotation: Snapshot, spin: float) -> None:
        """Estimate the errors of a steady rotation at an angular speed [rad/s]."""
        if self.feasible:
            self._compare_moving([(0.0, rotation)], before=False, anchor=1e-4 * spin**2)

    def _compare_moving(
        self, noted: list[tuple[float, Snapshot]], *, before: bool, anchor: float, still: bool = False
    ) -> Floats:
        """Compare states whose inertial forces are those that the coarse mesh leaves unbalanced, at their times [s].

        Inertia holds errors of those that are ``still`` only where nothing else does, as a body that turns freely.

        Returns:
            the rates of the twists of all nodes, of every state ``(k, n, 6)``.
        """
        moving, finer = self._moving, self.finer
        shapes = [Shape.of(snapshot) for _, snapshot in noted]
        stresses = [moving.other_stress(s.state, s.section_force, t, before=before) for t, s in noted]
        rates = moving.rates(shapes, stresses, [t for t, _ in noted], before=before)
        carried = finer.carried(shapes)
        r, q = (np.array([getattr(shape.state, name) for shape in shapes]) for name in "rq")
        inertia = moving.inertia(r, q, rates, carried.q)
        prestress = read(finer.halves.points, np.array(stresses))
        found = []
        for k, (t, snapshot) in enumerate(noted):
            finer.set_prestress(prestress[k])
            resisting = self._resisting(rates[k], snapshot.state.twist, anchor)
            other = None
            for anchored in [0.0, resisting] if still else [resisting]:
                balance = Balance(finer, t, before=before, inertia=inertia[k], anchor=anchored)
                other = other or counterpart(balance, carried, k)
            found.append(other)
        there = [k for k, other in enumerate(found) if other is not None]
        self.found, self.lost = self.found + len(there), self.lost + len(found) - len(there)
        if there:
            kept = [other for other in found if other is not None]
            self._take_in(carried.of(there), kept, [(noted[k][0], before) for k in there])
        return rates

    def _resisting(self, rate: Floats, twist: Floats, least: float) -> float:
        """Return stiffness over mass [1/s^2] by which inertia resists errors of a motion like this."""
        a, v = (float(np.vdot(x, self.problem.mass @ x[:, :, None])) for x in (rate, twist))
        # a / v is the squared rate of a vibration with these accelerations and velocities
        return max(least, ANCHOR * a / v) if v > 0.0 else least

    def _compare(self, snapshot: Snapshot, balance: Balance) -> None:
        self._count_in(self._estimate(snapshot, balance))

    def _count_in(self, found: bool) -> None:
        """Count a solution that has a counterpart on the finer mesh, or one that has none."""
        self.found, self.lost = self.found + found, self.lost + (not found)

    def _estimate(self, snapshot: Snapshot, balance: Balance) -> bool:
        """Take the errors of a state into the estimate; return whether it has a counterpart on the finer mesh."""
        carried = self.finer.carried([Shape.of(snapshot)])
        found = counterpart(balance, carried)
        if found is not None:
            self._take_in(carried, [found], [(balance.t, balance.before)])
        return found is not None

    def _take_in(self, carried: Carried, found: list[Shape], times: list[tuple[float, bool]]) -> None:
        """Take the differences of solutions from those on the finer mesh into the estimate.

        Args:
            carried, found: the solutions; times: of each the time [s] of its loads, and whether from the left.
        """
        jumping = [self._jumps.at(t, before=before) for t, before in times] if self._jumps.loads else []
        self.estimate = difference(self.finer, carried, found, jumping).joined(self.estimate)

    def grow(self, factor: float) -> None:
        """Take errors of positions to be so many times as large, as a motion makes those of steps."""
        if self.estimate is not None and factor > 1.0:
            self.estimate = self.estimate.grown(factor)

    def see_runs(self, r: Floats, fine_r: Floats) -> None:
        """Take errors of positions from a whole motion on both meshes, in place of what its states tell of them.

        Args:
            r, fine_r: positions of the finer stations at the same times, on both meshes ``(k, stations, 3)`` [m].
        """
        if self.estimate is not None:
            gaps, moved = run_gaps(self.finer, r, fine_r)
            self.estimate = self.estimate.of_runs(gaps, self._lengths, moved)

    # --- what is said

    def once_asked(self, look: Callable[[], None]) -> Callable[[], dict[str, Any]]:
        """Return what makes the :attr:`attributes` of a result that nothing but a ``look`` is seen of.

        It looks when they are asked for, at the model as it is now; but at once where the program chooses the mesh and
        needs them.
        """
        if self.free:
            look()
            return lambda: self.attributes

        def told() -> dict[str, Any]:
            look()
            return self.attributes

        return told

    @property
    def unknown(self) -> bool:
        """Whether most of the solutions had no counterpart on a finer mesh."""
        return self.lost > self.found

    @property
    def attributes(self) -> dict[str, Any]:
        """What a result says of its mesh."""
        found: dict[str, Any] = {}
        if self.estimate is not None:
            found["mesh_errors"] = json.dumps(self.estimate.rods)
            found["mesh_motion_error"], found["mesh_force_error"] = self.estimate.motion, self.estimate.force
            if self._jumps.loads:
                found["mesh_jumps"] = len(self._jumps.loads)
        if self.unknown:
            found["mesh_lost"] = self.lost
        return found

    # --- where to refine

    @cached_property
    def free(self) -> list[str]:
        """The rods whose mesh the program may choose."""
        return free_rods(self.model)

    def refined(
        self, accuracy: float, forces: float | None = None, *, most: int = MOST_CHOSEN_NODES
    ) -> Divisions | None:
        """Return finer divisions of the rods whose mesh the program may choose, where elements are too large.

        Args:
            accuracy: largest error of positions over the displacements; forces: of section forces, by default the same.
            most: nodes at most.

        Returns:
            None if there is nothing to refine, or the mesh would become too large.
        """
        seen = None if self.unknown else self.estimate
        if self.estimate is None and not self.unknown:
            return None
        return FinerDivisions(self.model, self.problem, accuracy, forces or accuracy).of(seen, most)

    def halved(self) -> Divisions | None:
        """Return the divisions with all elements of these rods halved; None if there are none, or too many."""
        if not self.free or 2 * self.problem.size > MOST_CHOSEN_NODES:
            return None
        divisions = divisions_of(self.problem)
        return divisions | {name: divisions[name].halved() for name in self.free}
