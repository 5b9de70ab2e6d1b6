"""External loads at one instant, summed from the problem's list."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from viscorod.mechanics.elements.basis import lagrange
from viscorod.mechanics.nodes import applied_loads as loading
from viscorod.solve.problem.problem import Problem
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
    """All loads at one time; ``nodes`` lists those that carry any nodal load; ``levers`` as in ``add_nodal_loads``.

    ``rest`` is the part of the rest strains that is imposed.
    """

    nodes: Integers
    dead: Floats
    following: Floats
    gravity: Floats
    levers: Floats
    stations: list[ActiveStation] = field(default_factory=list)
    rest: float = 1.0

    @property
    def none(self) -> bool:
        """True if nothing acts."""
        return len(self.nodes) == 0 and not self.stations

    def add_nodal(
        self, q: Floats, mass: Floats, external: Floats, blocks: Floats, diagonal: Integers, *, tangent: bool
    ) -> None:
        """Add the loads of nodes to ``external (n, 6)``; with ``tangent`` take their derivative off the ``blocks``.

        Args:
            q: unit quaternions of the nodes ``(n, 4)``; mass: of the nodes ``(n, 6, 6)``.
            external: wrenches, body axes; blocks, diagonal: of a matrix, see ``add_nodal_loads``.
            tangent: whether the derivative is wanted.
        """
        if len(self.nodes):
            loading.add_nodal_loads(
                self.nodes,
                q,
                self.dead,
                self.following,
                self.gravity,
                self.levers,
                mass,
                tangent,
                external,
                blocks,
                diagonal,
            )


NO_LOADS = LoadState(
    np.empty(0, dtype=np.int64), np.empty((0, 6)), np.empty((0, 6)), np.zeros(3), np.empty((0, 3, 3))
)


class ExternalLoads:
    """Evaluates the loads of a problem; nodal sums are kept while the time factors stay the same.

    Attributes:
        stage: parts of the model's loads, and last of the rest strains, at ``scale`` 0 and 1 of a stage of statics;
            None: none and all of them.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.offset = any(load.arms.any() for load in problem.nodal_loads)
        self.stage: tuple[Floats, Floats] | None = None
        self._factors: tuple[float, tuple[float, ...]] | None = None
        self._state: LoadState | None = None
        self.last: LoadState = NO_LOADS

    def at(
        self, t: float, before: bool = False, scale: float = 1.0, given: Mapping[int, float] | None = None
    ) -> LoadState:
        """Return the loads at time ``t`` [s] times ``scale``; ``before`` takes the limit from the left at jumps.

        ``given`` are factors, by the number of the load, in place of those at ``t``.
        """
        problem, given = self.problem, given or {}
        factors = tuple(
            self._part(load.load, scale)
            * (given[load.load] if load.load in given else load.factor(t, before))
            for load in problem.nodal_loads
        )
        rest = self._part(-1, scale)
        if (rest, factors) != self._factors or self._state is None:
            self._factors = rest, factors
            self._state = replace(self._nodal(factors), rest=rest)
        state = self._state
        self.last = state
        if not problem.station_loads:
            return state
        stations = []
        for load in problem.station_loads:
            factor = self._part(load.load, scale) * (
                given[load.load] if load.load in given else load.factor(t, before)
            )
            s = load.position(t, before)
            if factor == 0.0 or not 0.0 <= s <= problem.rod_lengths[load.rod]:
                continue
            element, shape = self.locate(load.rod, s)
            stations.append(ActiveStation(element, shape, factor * load.dead, factor * load.following))
        self.last = replace(state, stations=stations)
        return self.last

    def _part(self, load: int, scale: float) -> float:
        """Return the part of a load of the model, or of the rest strains (-1), at ``scale``."""
        if self.stage is None:
            return scale
        first, last = self.stage
        return float(first[load] + scale * (last[load] - first[load]))

    def _nodal(self, factors: tuple[float, ...]) -> LoadState:
        n = self.problem.size
        dead, following, gravity = np.zeros((n, 6)), np.zeros((n, 6)), np.zeros(3)
        levers = np.zeros((n if self.offset else 0, 3, 3))
        for factor, load in zip(factors, self.problem.nodal_loads, strict=True):
            if factor == 0.0:
                continue
            np.add.at(dead, load.nodes, factor * load.dead)
            np.add.at(following, load.nodes, factor * load.following)
            gravity += factor * load.gravity
            if load.arms.any():
                np.add.at(levers, load.nodes, factor * load.arms[:, :, None] * load.dead[:, None, :3])
        if gravity.any():
            nodes = np.arange(n, dtype=np.int64)
        else:
            nodes = np.flatnonzero(dead.any(axis=1) | following.any(axis=1)).astype(np.int64)
        return LoadState(nodes, dead, following, gravity, levers)

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
