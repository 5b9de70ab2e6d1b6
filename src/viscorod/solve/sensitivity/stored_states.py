"""What a scalar of stored states sees in a motion: derivatives by stations and times as ones by nodes and steps.

States within a step are those of a polynomial through both of its ends (see ``pose_interpolation``). Node by node it
depends on poses, twists and their rates there; these derivatives are central differences, of what takes microseconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.rotations.pose_interpolation import MovingPoses, interpolate
from viscorod.mechanics.rotations.quaternion import matrices as matrices_of
from viscorod.mechanics.rotations.quaternion import product
from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.sensitivity.closed_states import ClosedStates
from viscorod.solve.sensitivity.motion_sensitivity import Look
from viscorod.solve.sensitivity.stage_records import StageRecord
from viscorod.solve.sensitivity.step_looks import OneNode, Seen, look_at_states, look_within
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats, Integers

__all__ = ["READ", "StoredWeights"]

READ = ("position", "rotation", "velocity", "angular_velocity")
"""What is stored of stations."""
TURN = 3e-5
"""Rotation [rad] of differences."""
PART = 1e-3
"""Part of the length of the model, of twists and of their rates: what follows is linear or quadratic in these."""


def matrices(q: Floats) -> Floats:
    """Return the rotation matrices ``(..., 3, 3)`` of unit quaternions ``(..., 4)``."""
    return matrices_of(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3)


class _Nodal(NamedTuple):
    """Derivatives by body increments of poses, and by twists, of some nodes ``(k, m, 6)`` at some times."""

    pose: Floats
    twist: Floats


class StoredWeights:
    """Derivatives of a scalar by stored states; ``seen`` is what :func:`~.motion_sensitivity.gradient` asks for.

    Args:
        reader: of the stations; times: that are stored ``(k,)`` [s], the first one 0.
        weights: by :data:`READ` ``(k, stations, 3 or 4)``, of those that the scalar looks at.
        stored: rotations of the stations ``(k, stations, 4)``, whose signs count.
        split, tableau, length: of the nodes ``(n,)``, of the method, of the model [m].
        closing: of models whose states are closed when they are recorded; None of others.
    """

    def __init__(
        self,
        reader: StationReader,
        times: Floats,
        weights: Mapping[str, Floats],
        stored: Floats,
        split: Floats,
        tableau: Tableau,
        length: float,
        closing: ClosedStates | None = None,
    ) -> None:
        self._closing = closing
        self.reader, self.times, self.weights = reader, times, dict(weights)
        self.stored = np.ascontiguousarray(stored)
        self._split, self._tableau, self._length = split, tableau, length
        self._interpolate = KnownTypes(interpolate)
        looked = np.zeros(len(reader.nodes), dtype=bool)
        self._instants = np.zeros(len(times), dtype=bool)
        for values in self.weights.values():
            looked |= values.any(axis=(0, 2))
            self._instants |= values.any(axis=(1, 2))
        self._stations = np.flatnonzero(looked)
        beside = np.zeros(0, dtype=np.int64) if closing is None else closing.nodes
        self._nodes = np.unique(np.concatenate([reader.nodes[self._stations], beside]))
        self._of = np.searchsorted(self._nodes, reader.nodes[self._stations])
        self._look, self._scratch = KnownTypes(look_within), dict[int, OneNode]()
        self._look_at, none = KnownTypes(look_at_states), np.zeros((0, 0, 0))
        self._seen = Seen(*(np.ascontiguousarray(self.weights.get(name, none)) for name in READ))
        self._passed: list[tuple[Integers, Floats, Floats, Floats]] = []

    def seen(self, number: int, state: State, step: StageRecord | None) -> Look | None:
        """Return what the scalar sees at the end of a step and within; see :data:`~.motion_sensitivity.Seen`."""
        if step is None or number == 0:
            return self._at_end(state, 0) if self._instants[0] else None
        t, end = step.t, float(step.times[-1])
        slack = 1e-9 * step.h
        first, last = np.searchsorted(self.times, [t + slack, end + slack], side="right")
        inside = [k for k in range(first, last) if self._instants[k]]
        found = None
        if inside and abs(self.times[inside[-1]] - end) <= slack:
            found = self._at_end(state, inside.pop(), end)
        return self._within(state, step, inside, found) if inside else found

    def _at_end(self, state: State, k: int, end: float | None = None) -> Look:
        """Return what is seen in one stored state, at the ``end`` [s] of a step; None at the start."""
        nodes, size, closing = self._nodes, len(state.r), self._closing
        closed = None if closing is None or end is None else closing.at_end(state, end)
        here = state if closed is None else closed.state
        weights = self._nodal(
            np.array([k]), here.r[None, nodes], here.q[None, nodes], here.twist[None, nodes]
        )
        pose, twist = np.zeros((2, size, 6))
        pose[nodes], twist[nodes] = weights.pose[0], weights.twist[0]
        if closed is not None and closing is not None:
            pose, twist = closing.back(closed, pose, twist)
        return Look(pose, twist)

    def _inside(
        self, places: Integers, parts: Floats, step: StageRecord, start: list[Floats], end: list[Floats]
    ) -> _Nodal:
        """Return the derivatives by states within a step, of all its nodes, that are closed when they are recorded."""
        closing, nodes, (n, _) = self._closing, self._nodes, step.state.r.shape
        assert closing is not None
        ends = [MovingPoses(*map(np.ascontiguousarray, fields)) for fields in (start, end)]
        fields = self._states(parts, step.h, ends, np.arange(n))
        poses, twists = [], []
        for k, part, r, q, twist in zip(places, parts, *fields, strict=True):
            closed = closing.within(State(r, q, twist, step.state.multiplier), step.t + part * step.h)
            base = closed.state.r[None, nodes], closed.state.q[None, nodes], closed.state.twist[None, nodes]
            weights = self._nodal(np.array([k]), *base)
            by_pose, by_twist = np.zeros((2, n, 6))
            by_pose[nodes], by_twist[nodes] = weights.pose[0], weights.twist[0]
            by_pose, by_twist = closing.back(closed, by_pose, by_twist)
            poses.append(by_pose[nodes])
            twists.append(by_twist[nodes])
        return _Nodal(np.array(poses), np.array(twists))

    def _within(self, state: State, step: StageRecord, inside: list[int], also: Look | None) -> Look:
        """Return what is seen at the stored times with the numbers ``inside`` of a step, beside what is at its end."""
        nodes, method, h, old = self._nodes, self._tableau, step.h, step.state
        m, n = len(nodes), len(old.r)
        starting = method.start_derivative / h
        start_rate = np.tensordot(starting, step.twist - old.twist, 1)
        starts = [old.r, old.q, old.twist, start_rate]
        ends = [state.r, state.q, state.twist, step.acceleration[-1]]
        start, end = ([part[nodes] for part in parts] for parts in (starts, ends))
        parts = (self.times[inside] - step.t) / h
        ends_of_nodes = [MovingPoses(*map(np.ascontiguousarray, fields)) for fields in (start, end)]
        base = self._states(parts, h, ends_of_nodes, nodes)
        if self._closing is None:
            weights = self._nodal(np.array(inside), *base)
        else:
            weights = self._inside(np.array(inside), parts, step, starts, ends)
        if len(parts) not in self._scratch:
            self._scratch[len(parts)] = OneNode.of(len(parts))
        sums = np.empty((36, m))
        fields = self._split[nodes], base[1], *map(np.ascontiguousarray, weights), self._sizes(start, end, h)
        self._look.call(parts, h, *ends_of_nodes, *fields, self._scratch[len(parts)], sums)
        # by pose, twist and rate at the start, then at the end
        by = np.swapaxes(sums.reshape(6, 6, m), 1, 2)
        pose, end_twist = np.zeros((2, n, 6)) if also is None else np.array([also.pose, also.twist])
        stages, start_pose, start_twist = np.zeros(step.twist.shape), *np.zeros((2, n, 6))
        pose[nodes] += by[3]
        end_twist[nodes] += by[4]
        start_pose[nodes] = by[0]
        start_twist[nodes] = by[1] - starting.sum() * by[2]
        stages[:, nodes] = starting[:, None, None] * by[2]
        ending = method.derivative[-1] / h
        stages[:, nodes] += ending[:, None, None] * by[5]
        start_twist[nodes] -= ending.sum() * by[5]
        return Look(pose, end_twist, stages, start_pose, start_twist)

    def _sizes(self, start: list[Floats], end: list[Floats], h: float) -> Floats:
        """Return by how much poses, twists and rates at the start, then at the end, are changed ``(36,)``."""
        sizes = np.empty(36)
        for side, ends in enumerate((start, end)):
            speed = max(float(np.abs(ends[2]).max(initial=0.0)), h * float(np.abs(ends[3]).max(initial=0.0)))
            size = PART * max(speed, 1e-6 * self._length / h)
            given = [*[PART * self._length] * 3, *[TURN] * 3, *[size] * 6, *[size / h] * 6]
            sizes[18 * side : 18 * side + 18] = given
        return sizes

    def _states(
        self, parts: Floats, h: float, ends: Sequence[MovingPoses], nodes: Integers
    ) -> tuple[Floats, Floats, Floats]:
        """Return positions, rotations and twists ``(k, m, ...)`` at ``parts (k,)`` of a step with these ``ends``."""
        k, m = len(parts), len(nodes)
        r, q, twist = np.empty((k, m, 3)), np.empty((k, m, 4)), np.empty((k, m, 6))
        self._interpolate.call(parts, h, *ends, self._split[nodes], True, r, q, twist, np.empty((10, 6)))
        return r, q, twist

    def _nodal(self, instants: Integers, r: Floats, q: Floats, twist: Floats) -> _Nodal:
        """Return the derivatives by the states ``(k, m, ...)`` of the nodes at stored times."""
        self._passed.append((instants, r, q, twist))
        pose, by_twist = np.empty((2, len(instants), len(self._nodes), 6))
        offset, turn = self.reader.places
        given = self._stations, self._of, offset, turn, self.stored, self._seen, q, twist
        self._look_at.call(instants, *given, pose, by_twist)
        return _Nodal(pose, by_twist)

    def value(self, reader: StationReader) -> float:
        """Return the sum of the weights times what another reader reads of the states that were seen.

        It changes with a number that moves stations away from their nodes.
        """
        total, of = 0.0, self._of
        offset, turn = (part[self._stations] for part in reader.places)
        for instants, r, q, twist in self._passed:
            here = np.ix_(instants, self._stations)
            R, whole = matrices(q)[:, of], product(q[:, of], np.broadcast_to(turn, q[:, of].shape))
            sign = np.sign(np.sum(whole * self.stored[here], axis=-1, keepdims=True))
            v, w = twist[:, of, :3], twist[:, of, 3:]
            read = {
                "position": r[:, of] + np.einsum("ksij,sj->ksi", R, offset),
                "rotation": sign * whole,
                "velocity": np.einsum("ksij,ksj->ksi", R, v + np.cross(w, offset)),
                "angular_velocity": np.einsum("sji,ksj->ksi", matrices(turn), w),
            }
            total += sum(float(np.vdot(by[here], read[name])) for name, by in self.weights.items())
        return total
