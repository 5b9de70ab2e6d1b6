"""The state of an earlier result on the nodes of a model."""

from __future__ import annotations

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import Fault, InputError
from viscorod.results.between_records import Instants
from viscorod.results.files.storage import load
from viscorod.results.probe import fields_at, instants_of
from viscorod.results.result import Result
from viscorod.results.result_places import ResultPlace
from viscorod.results.run import Run
from viscorod.solve.formulations.system import State
from viscorod.solve.start import Start
from viscorod.solve.steady.steady_poses import nodal_state
from viscorod.typing import Floats

__all__ = ["StartState", "require_still"]

STILL = 1e-4
"""Part of the largest kinetic energy of a motion up to which a state of it rests."""
SAME = 1e-6
"""Part of a rod's length by which its reference shape may differ."""


class StartState:
    """One state of an earlier result.

    Args:
        discrete: the model that starts there; start: what a user gave.

    Attributes:
        state: on the nodes of the model, with velocities unless it is to be at rest.
        label: in words; load_factor: of the state, None of a motion.
        notes: what could not be taken over.

    Raises:
        InputError: there is no such result or state, or it is one of another model.
    """

    def __init__(self, discrete: DiscreteModel, start: Start) -> None:
        self.discrete, self.start = discrete, start
        result = load(start.file) if start.file is not None else start.result
        if not isinstance(result, Result):
            raise _refused("file", str(start.file), "this holds no single result", "give the file of a run")
        self.result: Result = result
        self.notes: list[str] = []
        self._require_same_rods()
        self._instant, self._index = self._chosen()
        self.state = self._read()
        self._track_joints()

    @property
    def label(self) -> str:
        """The state in words."""
        kind = self.result.kind
        source = self.start.file or f"{'an' if kind[0] in 'aeiou' else 'a'} {kind} result"
        level = np.asarray(self.result.stored[self.result.dimension].values, dtype=float)
        value = self._instant.time[0] if self._instant is not None else level[self._index]
        unit = {"time": f"t = {value:.6g} s", "spin": f"{value:.6g} rad/s"}
        return f"{source} at {unit.get(self.result.dimension, f'{value:.6g} of the loads')}"

    @property
    def load_factor(self) -> float | None:
        """Load factor of the state."""
        if self.result.dimension != "load_factor":
            return None
        return float(self.result.stored["load_factor"].values[self._index])

    def _require_same_rods(self) -> None:
        """Refuse a result whose rods or bodies are not those of the model; note what it has more."""
        problem, sites = self.discrete.problem, self.result.sites
        s = np.asarray(self.result.stored["station_s"].values, dtype=float)
        reference = np.asarray(self.result.stored["reference_position"].values, dtype=float)
        known = ", ".join(sites.rods)
        for rod, (name, length) in enumerate(zip(problem.rods, problem.rod_lengths, strict=True)):
            if name not in sites.rods:
                raise _refused(
                    "", name, "the earlier result has no rod of this name", f"its rods are {known}"
                )
            there = sites.stations(name)
            mine = np.flatnonzero(problem.stations.rod == rod)
            ends = [problem.positions[problem.stations.nodes[k]] for k in (mine[0], mine[-1])]
            attached = problem.stations.links[mine[[0, -1]]] >= 0
            apart = max(
                (0.0 if linked else float(np.abs(reference[k] - end).max()))
                for k, end, linked in zip(there[[0, -1]], ends, attached, strict=True)
            )
            if abs(s[there[-1]] - length) > SAME * length or apart > SAME * length:
                raise _refused(
                    "",
                    name,
                    "in the earlier result this rod has another length or reference shape",
                    "give a result of the same rods; sections, loads, supports and mesh may differ",
                )
        missing = [name for name in problem.bodies.names if name not in sites.bodies]
        if missing:
            raise _refused(
                "", missing[0], "the earlier result has no such body or point", "give one that has"
            )
        more = [name for name in sites.rods if name not in problem.rods]
        if more:
            self.notes.append(
                f"start: the earlier result has rods that this model has not: {', '.join(more)}"
            )

    def _chosen(self) -> tuple[Instants | None, int]:
        """Return the instant, or the number of the stored state."""
        result, start = self.result, self.start
        if isinstance(result, Run):
            if start.load_factor is not None:
                raise _refused("load_factor", f"{start.load_factor:g}", "this is a motion", "give a time")
            return instants_of(result, result.time[-1] if start.time is None else start.time), -1
        if start.time is not None:
            raise _refused(
                "time", f"{start.time:g}", "this is no motion", "give load_factor, or leave it out"
            )
        if start.load_factor is None:
            return None, -1
        level = np.asarray(result.stored[result.dimension].values, dtype=float)
        nearest = int(len(level) - 1 - np.argmin(np.abs(level[::-1] - start.load_factor)))
        if abs(level[nearest] - start.load_factor) > 1e-6 * max(1.0, abs(start.load_factor)):
            raise _refused(
                "load_factor",
                f"{start.load_factor:g}",
                f"no state is stored there; the nearest has {level[nearest]:.9g}",
                "give one that is stored, or let the earlier analysis end there",
            )
        return None, nearest

    def _fields(self, sites: list[ResultPlace]) -> dict[str, Floats]:
        """Return the fields of sites in the state."""
        found = fields_at(self.result, sites, self._instant)
        index = 0 if self._instant is not None else self._index
        return {name: values[index] for name, values in found.items()}

    def _parts(self) -> list[dict[str, Floats]]:
        """Return the fields of all stations of rods and of the bodies; interpolated where these were not stored."""
        problem, data = self.discrete.problem, self.result.stored
        stations, sites, bodies = problem.stations, self.result.sites, problem.bodies.names
        rods = [problem.rods[rod] for rod in stations.rod]
        stored = self._stored()
        same = np.array_equal(data["station_rod"].values, [*rods, *bodies])
        if stored is not None and same and np.array_equal(data["station_s"].values[: len(rods)], stations.s):
            names = ("position", "rotation", "velocity", "angular_velocity")
            return [
                {
                    name: np.array(data[name].isel({self.result.dimension: stored}).values, dtype=float)
                    for name in names
                    if name in data
                }
            ]
        places = [sites.along(rod, float(s)) for rod, s in zip(rods, stations.s, strict=True)]
        return [self._fields(some) for some in (places, [sites.at(name) for name in bodies]) if some]

    def _stored(self) -> int | None:
        """Return the number of the stored state that this is, None if it is one between."""
        if self._instant is None:
            return self._index
        times = np.asarray(self.result.stored[self.result.dimension].values, dtype=float)
        nearest = int(np.argmin(np.abs(times - self._instant.time[0])))
        return nearest if times[nearest] == self._instant.time[0] else None

    def _read(self) -> State:
        discrete, problem = self.discrete, self.discrete.problem
        sites = self.result.sites
        parts = self._parts()
        position, rotation = (
            np.concatenate([part[name] for part in parts]) for name in ("position", "rotation")
        )
        still = self.start.at_rest or "velocity" not in parts[0]
        velocity, spin = (
            np.zeros_like(position) if still else np.concatenate([part[name] for part in parts])
            for name in ("velocity", "angular_velocity")
        )
        state = nodal_state(problem, position, rotation, velocity, spin)
        held = problem.held
        if len(held.place) and "section_force" in self.result.stored:
            gauss = discrete.system.gauss_positions()
            forces = self._fields(
                [sites.along(problem.rods[rod], float(s)) for rod, s in zip(gauss.rod, gauss.s, strict=True)]
            )["section_force"]
            arranged = np.zeros((discrete.system.elements().reference[..., 0].size, 6))
            arranged[discrete.system.gauss_indices()] = forces
            points = discrete.system.elements().reference.shape[1]
            state.multiplier[held.place] = (
                held.weight * arranged[held.element * points + held.point, held.component]
            )
        if problem.relaxing:
            self.notes.append(
                "start: the strains of the dashpots are not stored with a result; the Maxwell branches begin relaxed"
            )
        return state

    def _track_joints(self) -> None:
        """Let angles of joints go on from their stored values, beyond full turns."""
        data, constraints = self.result.stored, self.discrete.system.constraints
        if "joint_value" not in data or data.sizes["joint_coordinate"] != len(constraints.near):
            return
        state = self._index
        if self._instant is not None:
            times = np.asarray(data[self.result.dimension].values, dtype=float)
            state = int(np.argmin(np.abs(times - self._instant.time[0])))
        constraints.near[:] = np.asarray(data["joint_value"].values, dtype=float)[state]


def require_still(found: StartState) -> None:
    """Refuse a state of a motion that moves as one about which small motions are wanted.

    Raises:
        InputError: it moves, and nobody said that its velocities are to be left out.
    """
    result, problem = found.result, found.discrete.problem
    if not isinstance(result, Run) or found.start.at_rest:
        return
    twist = found.state.twist
    kinetic = 0.5 * float(np.einsum("ni,nij,nj->", twist, problem.mass, twist))
    largest = float(np.asarray(result.data["kinetic"].values, dtype=float).max())
    speed = max(float(np.abs(twist[:, :3]).max()), problem.length * float(np.abs(twist[:, 3:]).max()))
    way = speed * float(np.ptp(result.time))  # [m] in the duration of the motion
    if kinetic > STILL * largest and way > SAME * problem.length:
        raise InputError(
            Fault(
                "about",
                found.label,
                "this state moves: small motions about it are not about a rest, and have no frequencies and damping of "
                "their own",
                "add at_rest = true for those about the equilibrium that is found near it, or give a steady rotation; "
                "periodic motions have their Floquet multipliers",
            )
        )


def _refused(key: str, found: str, why: str, instead: str) -> InputError:
    return InputError(Fault(f"start.{key}" if key else "start", found, why, instead))
