"""Watches the solutions of one problem for what a finer mesh would make of them, and says where to refine."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import DEFAULT_ORDER
from viscorod.solve.formulations.system import System
from viscorod.solve.history import History, Snapshot
from viscorod.solve.problem.division import Division, Divisions, divisions_of
from viscorod.solve.problem.problem import Problem
from viscorod.solve.refinement.correction import Balance, corrected, held_back
from viscorod.solve.refinement.finer_mesh import Carried, FinerMesh, Shape
from viscorod.solve.refinement.half_elements import read
from viscorod.solve.refinement.inertial_forces import CoarseMotion
from viscorod.solve.refinement.linear_counterpart import LinearCounterpart
from viscorod.solve.refinement.mesh_estimate import MeshEstimate, difference
from viscorod.solve.refinement.phase_drift import AtRest, PhaseDrift
from viscorod.solve.refinement.start_modes import StartModes
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.transient.integrators.linear_model import LinearModel
from viscorod.typing import Floats

__all__ = ["MeshWatch"]

MOST_NODES = 20_000
"""Nodes of a problem beyond which no finer mesh is made."""
MOST_CHOSEN_NODES = 4_000
"""Nodes beyond which the program refines no mesh that it chose."""
SHARE = 0.5
"""Part of the accuracy beyond which an element is too large."""
ANCHOR = 0.01
"""Part of the squared rate of a motion by which inertia resists errors, which change about as fast as it does."""
STILL = 1e-3
"""Part of the displacements at the start of a motion below which it hardly moves."""
INSTANTS = 6
"""Points of a path, about evenly chosen, and states of a motion that are looked at."""
GROWTH, NEAR = 1.5, 0.85
"""Recorded states from one of these to the next, in parts; nearer than this part to the next the last one is that."""


class MeshWatch:
    """Estimates the errors that the mesh of one problem leaves in its solutions.

    Args:
        model: that was discretised; problem: what came of it; system: that solves it.
        wanted: whether errors are estimated; where the program chooses the mesh they always are.

    Attributes:
        estimate: the largest errors of all solutions seen, None before the first.
        found, lost: how many solutions had a counterpart on a finer mesh, and how many had none.
        noted: states that a motion passed, with their times [s]; start: the one at t = 0.
    """

    def __init__(
        self, model: ModelDescription, problem: Problem, system: System, *, wanted: bool = True
    ) -> None:
        self.model, self.problem, self.system = model, problem, system
        self.wanted = wanted or bool(self.free)
        self.estimate: MeshEstimate | None = None
        self.found = self.lost = 0
        self.noted: list[tuple[float, Snapshot]] = []
        self.start: Snapshot | None = None
        self._count, self._next = 0, 1
        self._at_rest: AtRest | None = None

    @cached_property
    def finer(self) -> FinerMesh:
        """The problem on elements half as long."""
        return FinerMesh(self.model, self.problem)

    @cached_property
    def _moving(self) -> CoarseMotion:
        return CoarseMotion(self.finer)

    @property
    def feasible(self) -> bool:
        """Whether errors are wanted, and the problem is small enough for a finer one beside it."""
        return self.wanted and self.problem.size <= MOST_NODES

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

    def coming(self, steps: int) -> list[int]:
        """Return after which of the next ``steps`` of a motion, counted from 1, :meth:`note` keeps the state."""
        found, at = [], self._next
        while at <= self._count + steps:
            found.append(at - self._count)
            at = int(GROWTH * at) + 1
        return found

    def note(self, start: Snapshot | None, t: float, state: Callable[[], Snapshot], steps: int = 1) -> None:
        """Keep the ends of some steps of a motion for :meth:`see_motion`: the first, the last, early ones more closely.

        Errors of a motion that fades are largest early, those of one that lasts in the end. States between the ends of
        steps would not do: polynomials in time do not balance.

        Args:
            start: the state at t = 0, None if it is known; t: end of a step [s]; state: returns the one there.
            steps: since the last call, the last of which ends here.
        """
        if start is not None:
            self.start = start
        self._count += steps
        if self._count >= self._next:
            self.noted = [*self.noted[1 - INSTANTS :], (t, state())]
            self._next = int(GROWTH * self._count) + 1

    def notes(self) -> dict[str, Any]:
        """Return what was noted, for another run of the same problem that goes on from there."""
        if not self.feasible:
            return {}
        return {"noted": self.noted, "start": self.start, "_count": self._count, "_next": self._next}

    def take_over(self, notes: dict[str, Any]) -> None:
        """Go on with what another run noted."""
        vars(self).update(notes)

    def phases(
        self, static: StaticSolver, start: Snapshot, scale: float, modes: StartModes | None = None
    ) -> PhaseDrift:
        """Compare the slowest vibrations about a state at rest under a multiple of the loads at t = 0."""
        found = PhaseDrift(self._moving, static, _shape(start), scale, modes, self._at_rest)
        self._at_rest = found.finer
        return found

    def share(self, other: MeshWatch) -> None:
        """Use the finer mesh of another watch of the same problem, and what is known of states at rest there."""
        assert self.problem is other.problem
        made = {"finer", "_moving", "_at_rest"}
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
        noted = self._chosen(last)
        times = [t for t, _ in noted]
        anchor, still = (np.pi / last[0]) ** 2, self._still(noted)
        rates = self._compare_moving(noted, before=True, anchor=anchor, still=still)
        if self.start is not None:
            drift = self.phases(static, self.start, scale, modes)
            self._drift(drift, times, rates, drift.kicked(self.start.state.twist, self._begins()))

    def see_linear_motion(
        self, last: tuple[float, Snapshot], static: StaticSolver, scale: float, modes: StartModes
    ) -> None:
        """Estimate the errors of the noted states of a linear motion; see :meth:`see_motion`."""
        if not self.feasible or self.start is None:
            return
        start, finer = self.start.state, self.finer
        drift = self.phases(static, self.start, scale, modes)
        rest = drift.finer.state
        if rest is None or self.problem.relaxing:
            self._count_in(False)
            return
        coarse = LinearModel(self.system, self._moving.supports, 0.0, start)
        counterpart = LinearCounterpart(
            coarse, LinearModel(finer.system, finer.supports, 0.0, rest), self._moving
        )
        rates, seen, shape = [], [], start.twist.shape
        noted = self._chosen(last)
        for t, snapshot in noted:
            now = counterpart.state(snapshot, t, before=True)
            rates.append(now.acceleration.reshape(shape))
            found = counterpart.better(
                now,
                t,
                before=True,
                anchor=self._resisting(rates[-1], snapshot.state.twist, (np.pi / last[0]) ** 2),
            )
            seen.append(found)
            self._count_in(True)
        shapes = [_shape(snapshot) for _, snapshot in noted]
        self._take_in(finer.carried(shapes), seen)
        begun = counterpart.state(self.start, 0.0, before=False)
        kick = drift.kicked(start.twist, begun.acceleration.reshape(shape))
        self._drift(drift, [t for t, _ in noted], rates, kick)

    def _drift(self, drift: PhaseDrift, times: list[float], rates: list[Floats], kick: Floats) -> None:
        """Add what wrong frequencies make of the motion in time."""
        if self.estimate is not None:
            lengths = dict(zip(self.problem.rods, map(float, self.problem.rod_lengths), strict=True))
            self.estimate = self.estimate.drifted(
                drift.gaps(times, rates, kick), drift.gaps(times, rates), lengths
            )

    def _still(self, noted: list[tuple[float, Snapshot]]) -> bool:
        """Return whether a motion that begins at rest, in a strained shape, hardly leaves it.

        On a finer mesh it would begin at another equilibrium: inertia does not hold it where this one is.
        """
        if self.start is None or self.start.state.twist.any():
            return False
        r = self.start.state.r
        strained = float(np.abs(r - self.problem.positions).max())
        return (
            all(np.abs(snapshot.state.r - r).max() <= STILL * strained for _, snapshot in noted)
            and strained > 0.0
        )

    def _chosen(self, last: tuple[float, Snapshot]) -> list[tuple[float, Snapshot]]:
        """Return the noted states that are looked at, with the last one."""
        if self.noted and last[0] <= self.noted[-1][0]:
            return self.noted
        return [*self.noted[: None if self._count > NEAR * self._next else -1], last]

    def _begins(self) -> Floats:
        """Return the rates of the twists of all nodes when a motion begins, after a jump of its loads ``(n, 6)``."""
        assert self.start is not None
        stress = self._moving.other_stress(self.start.state, self.start.section_force, 0.0, before=False)
        return self._moving.rate(self.start.state, stress, _angles(self.start), 0.0, before=False)

    def see_steady(self, rotation: Snapshot, spin: float) -> None:
        """Estimate the errors of a steady rotation at an angular speed [rad/s]."""
        if self.feasible:
            self._compare_moving([(0.0, rotation)], before=False, anchor=1e-4 * spin**2)

    def _compare_moving(
        self, noted: list[tuple[float, Snapshot]], *, before: bool, anchor: float, still: bool = False
    ) -> list[Floats]:
        """Compare states whose inertial forces are those that the coarse mesh leaves unbalanced, at their times [s].

        Inertia holds errors of those that are ``still`` only where nothing else does, as a body that turns freely.

        Returns:
            the rates of the twists of all nodes ``(n, 6)``, of every state.
        """
        moving, finer = self._moving, self.finer
        shapes = [_shape(snapshot) for _, snapshot in noted]
        stresses = [moving.other_stress(s.state, s.section_force, t, before=before) for t, s in noted]
        rates = [
            moving.rate(shape.state, stress, shape.near, t, before=before)
            for shape, stress, (t, _) in zip(shapes, stresses, noted, strict=True)
        ]
        carried = finer.carried(shapes)
        r, q = (np.array([getattr(shape.state, name) for shape in shapes]) for name in "rq")
        inertia = moving.inertia(r, q, np.array(rates), carried.q)
        prestress = read(finer.halves.points, np.array(stresses))
        found = []
        for k, (t, snapshot) in enumerate(noted):
            finer.set_prestress(prestress[k])
            resisting = self._resisting(rates[k], snapshot.state.twist, anchor)
            other = None
            for anchored in [0.0, resisting] if still else [resisting]:
                balance = Balance(finer, t, before=before, inertia=inertia[k], anchor=anchored)
                other = other or self._counterpart(balance, carried, k)
            found.append(other)
        there = [k for k, other in enumerate(found) if other is not None]
        self.found, self.lost = self.found + len(there), self.lost + len(found) - len(there)
        if there:
            self._take_in(carried.of(there), [other for other in found if other is not None])
        return rates

    def _resisting(self, rate: Floats, twist: Floats, least: float) -> float:
        """Return stiffness over mass [1/s^2] by which inertia resists errors of a motion like this."""
        a, v = (float(np.einsum("ni,nij,nj", x, self.problem.mass, x)) for x in (rate, twist))
        # a / v is the squared rate of a vibration with these accelerations and velocities
        return max(least, ANCHOR * a / v) if v > 0.0 else least

    def _compare(self, snapshot: Snapshot, balance: Balance) -> None:
        self._count_in(self._estimate(snapshot, balance))

    def _count_in(self, found: bool) -> None:
        """Count a solution that has a counterpart on the finer mesh, or one that has none."""
        self.found, self.lost = self.found + found, self.lost + (not found)

    def _estimate(self, snapshot: Snapshot, balance: Balance) -> bool:
        """Take the errors of a state into the estimate; return whether it has a counterpart on the finer mesh."""
        carried = self.finer.carried([_shape(snapshot)])
        found = self._counterpart(balance, carried)
        if found is not None:
            self._take_in(carried, [found])
        return found is not None

    def _counterpart(self, balance: Balance, carried: Carried, k: int = 0) -> Shape | None:
        """Return what one of some solutions is on the finer mesh, None if it has no counterpart there."""
        other = corrected(balance, self.finer.take_over(carried, k))
        if other is None and balance.at_rest:
            other = held_back(balance, self.finer.take_over(carried, k))
        if other is None:
            return None
        return Shape(other, self.finer.system.gauss_points().section_force, carried.shapes[k].near)

    def _take_in(self, carried: Carried, found: list[Shape]) -> None:
        """Take the differences of solutions from those on the finer mesh into the estimate."""
        self.estimate = difference(self.finer, carried, found).joined(self.estimate)

    # --- what is said

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
        if self.unknown:
            found["mesh_lost"] = self.lost
        return found

    # --- where to refine

    @property
    def free(self) -> list[str]:
        """The rods whose mesh the program may choose."""
        return [name for name, rod in self.model.rods.items() if rod.elements is None]

    def too_coarse(self, accuracy: float, forces: float | None = None) -> bool:
        """Whether an error is larger than wanted, of ``forces`` by default too, or could not be estimated."""
        if self.estimate is None or self.unknown:
            return self.unknown
        return self.estimate.mendable > accuracy or self.estimate.force > (forces or accuracy)

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
        divisions, free = divisions_of(self.problem), self.free
        if not free or not self.too_coarse(accuracy, forces):
            return None
        marked = {name: self._marked(name, divisions[name], accuracy, forces or accuracy) for name in free}
        if not any(mask.any() for mask in marked.values()):
            marked = {name: np.ones(divisions[name].count, dtype=bool) for name in free}
        refined = {name: self._finer(name, divisions[name], mask) for name, mask in marked.items()}
        found = divisions | refined
        if sum(division.order * division.count for division in found.values()) > most:
            return None
        return found

    def _marked(self, name: str, division: Division, accuracy: float, forces: float) -> np.ndarray:
        """Return which elements are too large: all, where no solution on a finer mesh was found."""
        if self.estimate is None or self.unknown:
            return np.ones(division.count, dtype=bool)
        errors = self.estimate.of_elements(name)
        too_large = np.zeros(division.count, dtype=bool)
        if self.estimate.mendable > accuracy:
            too_large |= errors[:, 0] > SHARE * accuracy
        if self.estimate.force > forces:
            too_large |= errors[:, 1] > SHARE * forces
        return too_large

    def halved(self) -> Divisions | None:
        """Return the divisions with all elements of these rods halved; None if there are none, or too many."""
        if not self.free or 2 * self.problem.size > MOST_CHOSEN_NODES:
            return None
        divisions = divisions_of(self.problem)
        return divisions | {name: divisions[name].halved() for name in self.free}

    def _finer(self, name: str, division: Division, marked: np.ndarray) -> Division:
        """Return a division whose marked elements are halved; many small ones of low order get a higher one instead."""
        rod = self.model.rods[name]
        if rod.order is None and division.order < DEFAULT_ORDER and marked.mean() > SHARE:
            return Division(division.order + 1, division.ends)
        return division.halved(marked)


def _shape(snapshot: Snapshot) -> Shape:
    return Shape(snapshot.state, snapshot.section_force, _angles(snapshot))


def _angles(snapshot: Snapshot) -> np.ndarray:
    """Return the values of all coordinates of joints, to which those on the finer mesh are near."""
    return np.zeros(0) if snapshot.joints is None else snapshot.joints.value
