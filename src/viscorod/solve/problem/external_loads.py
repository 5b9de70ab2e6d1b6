"""External loads at one instant, summed from the problem's list."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.basis import lagrange
from viscorod.mechanics.nodes import applied_loads as loading
from viscorod.mechanics.nodes.attached_poses import ElementNodes, PointWrench
from viscorod.mechanics.nodes.motion_loads import MotionLoads, MotionTangent, MotionWork, add_motion_loads
from viscorod.solve.once import once
from viscorod.solve.problem.imposed_strains import Imposed
from viscorod.solve.problem.law_callbacks import MotionLaws
from viscorod.solve.problem.problem import NodalLoad, Problem
from viscorod.typing import Floats, Integers


@dataclass
class ActiveStation:
    """A concentrated load placed in an element: number, basis there, wrenches."""

    element: int
    shape: Floats
    dead: Floats
    following: Floats


@dataclass
class LoadState:
    """All loads at one time.

    Attributes:
        nodes: those that carry any nodal load; dead, following, gravity, levers: as in ``add_nodal_loads``.
        stations: within elements.
        motion: loads that see motion; factors: of their places ``(m,)``; pushes: they act on what is at rest.
        sees_motion: any place of these has a factor; laws: of these loads.
        rest: the rest strains that are imposed; None leaves them as they are.
    """

    nodes: Integers
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats
    motion: MotionLoads
    factors: Floats
    stations: list[ActiveStation] = field(default_factory=list)
    pushes: bool = False
    sees_motion: bool = False
    laws: MotionLaws | None = None
    rest: Imposed | None = None

    @property
    def none(self) -> bool:
        """True if nothing acts on a model at rest."""
        return len(self.nodes) == 0 and not self.stations and not self.pushes

    def add(
        self,
        problem: Problem,
        pose: tuple[Floats, Floats],
        twist: Floats | None,
        external: Floats,
        tangent: MotionTangent | None = None,
    ) -> float:
        """Add all loads to ``external (n, 6)``, body axes; return the power that they dissipate [W].

        Args:
            problem: whose loads these are.
            pose: positions and unit quaternions of the nodes ``(n, 3)``, ``(n, 4)``.
            twist: of the nodes ``(n, 6)``, None for none.
            external: wrenches.
            tangent: blocks of matrices, of which their derivative is taken off, if it is wanted.
        """
        r, q = pose
        into = MotionTangent.none() if tangent is None else tangent
        wanted, blocks = tangent is not None, into.blocks
        if len(self.nodes):
            loading.add_nodal_loads(
                self.nodes,
                q,
                self.dead,
                self.following,
                self.gravity,
                self.levers,
                problem.mass,
                wanted,
                external,
                blocks,
                problem.pattern.diagonal,
            )
        for load in self.stations:
            e, i = problem.element(load.element)
            own = ElementNodes(e.nodes[i], e.links[i], problem.link_positions, problem.link_quaternions)
            loading.add_station_load(
                own,
                PointWrench(load.shape, load.dead, load.following),
                r,
                q,
                wanted,
                external,
                blocks,
                e.slots[i],
                loading.StationWork.of(len(load.shape)),
            )
        if not self.sees_motion:
            return 0.0
        moving = np.zeros((len(r), 6)) if twist is None else twist
        power = add_motion_loads(self.motion, self.factors, r, q, moving, external, into, MotionWork.new())
        if self.laws is not None:
            self.laws.callback.check()
        return power


NO_LOADS = LoadState(
    np.empty(0, dtype=np.int64),
    np.empty((0, 6)),
    np.empty((0, 6)),
    np.zeros(3),
    np.empty((0, 3, 3)),
    MotionLoads.none(),
    np.empty(0),
)


class LoadRows(NamedTuple):
    """Values ``(k, ...)`` of a load at nodes ``(k,)``, which may be there several times if not ``distinct``."""

    nodes: Integers
    values: Floats
    distinct: bool


@once
def _rows_of(load: NodalLoad) -> tuple[LoadRows | None, LoadRows | None, LoadRows | None]:
    """Return dead and following wrenches of a load, and its levers, where they are not zero."""
    levers = load.arms[:, :, None] * load.dead[:, None, :3]
    found: list[LoadRows | None] = []
    for values in (load.dead, load.following, levers):
        here = values.any(axis=tuple(range(1, values.ndim)))
        nodes = load.nodes[here]
        distinct = len(set(nodes.tolist())) == len(nodes)
        found.append(LoadRows(nodes, values[here], distinct) if len(nodes) else None)
    return found[0], found[1], found[2]


def _add_rows(factor: float, rows: LoadRows, sums: Floats) -> None:
    if rows.distinct:
        sums[rows.nodes] += factor * rows.values
    else:
        np.add.at(sums, rows.nodes, factor * rows.values)


class ExternalLoads:
    """Evaluates the loads of a problem; nodal sums are kept while the time factors stay the same.

    Attributes:
        motion: places of the loads that see motion, with their laws.
        rows: dead and following wrenches of each load of nodes, and its levers, where they are not zero.
        stage: parts of the model's loads, and last of the rest strains, at ``scale`` 0 and 1 of a stage of statics;
            None: none and all of them.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.offset = any(load.arms.any() for load in problem.nodal_loads)
        self.laws = MotionLaws([load.law for load in problem.motion_loads], problem.length)
        self.motion = self._motion_loads()
        self.stage: tuple[Floats, Floats] | None = None
        self._factored = [(load.load, load.factor, True) for load in problem.nodal_loads]
        # what does nothing at rest is no load that grows in statics
        self._factored += [(load.load, load.factor, load.law.at_rest) for load in problem.motion_loads]
        self.rows = [_rows_of(load) for load in problem.nodal_loads]
        self._loaded: dict[tuple[tuple[int, ...], bool], Integers] = {}
        self._factors: tuple[float, ...] | None = None
        self._state: LoadState | None = None
        nowhere = (float("nan"), 0, np.zeros(0))
        self._located: list[tuple[float, int, Floats]] = [nowhere] * len(problem.station_loads)
        self._driven = any(strain.changes for _, strain in problem.rest_strains)
        self.last: LoadState = NO_LOADS

    def at(
        self, t: float, before: bool = False, scale: float = 1.0, given: Mapping[int, float] | None = None
    ) -> LoadState:
        """Return the loads at time ``t`` [s] times ``scale``; ``before`` takes the limit from the left at jumps.

        ``given`` are factors, by the number of the load, in place of those at ``t``.
        """
        problem = self.problem
        if not given and scale == 1.0 and self.stage is None:
            factors = tuple([factor(t, before) for _, factor, _ in self._factored])
        else:
            factors = self._parts_at(t, before, scale, given or {})
        if factors != self._factors or self._state is None:
            self._factors, self._state = factors, self._nodal(factors)
        state = self._state
        if problem.rest_strains:
            now = (t, before) if self._driven else ()
            rest = Imposed(self._part(-1, scale), *now)
            if rest != state.rest:
                self._state = state = replace(state, rest=rest)
        self.last = state
        if not problem.station_loads:
            return state
        stations = []
        for k, load in enumerate(problem.station_loads):
            own = load.factor(t, before) if not given or load.load not in given else given[load.load]
            factor = self._part(load.load, scale) * own
            s = load.position(t, before)
            if factor == 0.0 or not 0.0 <= s <= problem.rod_lengths[load.rod]:
                continue
            where, element, shape = self._located[k]
            if s != where:  # most stay where they are
                element, shape = self.locate(load.rod, s)
                self._located[k] = s, element, shape
            stations.append(ActiveStation(element, shape, factor * load.dead, factor * load.following))
        self.last = replace(state, stations=stations)
        return self.last

    def _parts_at(
        self, t: float, before: bool, scale: float, given: Mapping[int, float]
    ) -> tuple[float, ...]:
        """Return the factors of all loads, where these grow, or are given."""
        return tuple(
            [
                (self._part(load, scale) if grows else 1.0)
                * (given[load] if load in given else factor(t, before))
                for load, factor, grows in self._factored
            ]
        )

    def _part(self, load: int, scale: float) -> float:
        """Return the part of a load of the model, or of the rest strains (-1), at ``scale``."""
        if self.stage is None:
            return scale
        first, last = self.stage
        return float(first[load] + scale * (last[load] - first[load]))

    def _nodal(self, factors: tuple[float, ...]) -> LoadState:
        """Return the loads of nodes, first those that do not see motion, with their factors."""
        problem, n = self.problem, self.problem.size
        dead, following, gravity = np.zeros((n, 6)), np.zeros((n, 6)), np.zeros(3)
        levers = np.zeros((n if self.offset else 0, 3, 3))
        acting = [(factor, k) for k, factor in enumerate(factors[: len(self.rows)]) if factor != 0.0]
        for factor, k in acting:
            for row, sums in zip(self.rows[k], (dead, following, levers), strict=True):
                if row is not None:
                    _add_rows(factor, row, sums)
            gravity += factor * problem.nodal_loads[k].gravity
        nodes = self._nodes_under(tuple(k for _, k in acting), everywhere=bool(gravity.any()))
        places, pushes = np.zeros(0), False
        if problem.motion_loads:
            moving = list(zip(factors[len(problem.nodal_loads) :], problem.motion_loads, strict=True))
            places = np.concatenate([factor * load.lengths for factor, load in moving])
            pushes = any(factor != 0.0 and load.law.at_rest for factor, load in moving)
        return LoadState(
            nodes,
            dead,
            following,
            gravity,
            levers,
            self.motion,
            places,
            pushes=pushes,
            sees_motion=len(places) > 0 and bool(places.any()),
            laws=self.laws,
        )

    def _nodes_under(self, acting: tuple[int, ...], *, everywhere: bool) -> Integers:
        """Return the nodes that nodal loads, by their numbers, act on; all of them under gravity."""
        found = self._loaded.get((acting, everywhere))
        if found is None:
            marked = np.full(self.problem.size, everywhere)
            for k in acting:
                for row in self.rows[k]:
                    if row is not None:
                        marked[row.nodes] = True
            found = self._loaded[acting, everywhere] = np.flatnonzero(marked).astype(np.int64)
        return found

    def _motion_loads(self) -> MotionLoads:
        loads = self.problem.motion_loads
        if not loads:
            return MotionLoads.none()
        rows = np.repeat(self.laws.rows, [len(load.nodes) for load in loads], axis=0)
        nodes, arms, turns = (
            np.concatenate([getattr(load, name) for load in loads]) for name in ("nodes", "arms", "turns")
        )
        return MotionLoads.of(nodes, arms, turns, rows)

    def locate(self, rod: int, s: float) -> tuple[int, Floats]:
        """Return the number of the element among all, and basis values ``(m,)``, at arc length ``s`` [m] of a rod."""
        first = 0
        for elements in self.problem.sets:
            mine = np.flatnonzero(elements.rod == rod)
            if len(mine) == 0:
                first += len(elements.nodes)
                continue
            starts = elements.start[mine]
            place = int(np.clip(np.searchsorted(starts, s, side="right") - 1, 0, len(mine) - 1))
            element = int(mine[place])
            xi = (s - elements.start[element]) / elements.half_lengths[element] - 1.0
            values, _ = lagrange(elements.order, np.array([min(max(xi, -1.0), 1.0)]))
            return first + element, np.ascontiguousarray(values[0])
        raise AssertionError(f"rod {rod} has no elements")


def load_count(problem: Problem) -> int:
    """Return one more than the largest number of a load."""
    numbers = [load.load for load in problem.nodal_loads]
    numbers += [load.load for load in problem.station_loads] + [load.load for load in problem.motion_loads]
    return 1 + max(numbers, default=-1)
