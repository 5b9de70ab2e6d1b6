"""What is recorded of an equilibrium, to first order in a number of the case that leaves the shape of the model.

Section forces, reactions and energies change with the state and with the arrays of the problem, and each share is
differentiated by itself: that of the state by the model's own arrays in four states along its increment, that of the
arrays by two neighbours in one and the same state. Neighbours in states of first order need be four, since such states
bend rods of stiff sections; so only the arrays have to be made, of half as many.

Numbers that change where nodes are, or rest strains, stretch rods by as much as the states shrink them again; what two
neighbours leave of either share would not cancel.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from viscorod.analyses.derivatives.neighbours import CLOSE, MANY, Neighbour, Neighbours
from viscorod.analyses.derivatives.static_changes import StaticChange, near
from viscorod.analyses.discrete import DiscreteModel
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.problem.element_arrays import gauss_positions
from viscorod.typing import Floats

__all__ = ["RestingStates", "neighbours_at_rest"]

MOVED = 3e-3
"""Displacement over the length of the model, or rotation [rad], of the state that is farthest along the increment."""


def neighbours_at_rest(model: ModelDescription, key: str, discrete: DiscreteModel) -> Neighbours:
    """Return the neighbours of an equilibrium by a number: two that leave the shape of the model, else four.

    Raises:
        InputError: as of :meth:`Neighbours.of`.
    """
    if not discrete.problem.rest_strains:
        few = Neighbours.of(model, key, discrete, CLOSE)
        if _keep_shape(few, discrete):
            return few
    return Neighbours.of(model, key, discrete)


def _keep_shape(neighbours: Neighbours, discrete: DiscreteModel) -> bool:
    """Return whether neighbours have nodes, supports and joints of the very same layout, and no rest strains."""
    return not discrete.problem.rest_strains and all(one.keeps_shape for one in neighbours.each)


class RestingStates:
    """The equilibria of all neighbours by one number, to first order, at one load factor after the other.

    Poses follow from one linear solution. What else is recorded takes five evaluations and more, and is made when it is
    asked for.

    Args:
        neighbours: by the number; discrete: the model itself.
    """

    def __init__(self, neighbours: Neighbours, discrete: DiscreteModel) -> None:
        self.neighbours, self._discrete = neighbours, discrete
        self._taken: list[tuple[StaticChange, Floats]] = []

    def take(self, change: StaticChange) -> None:
        """Take the next equilibrium of the model itself."""
        self._taken.append((change, change.increment(self.neighbours)))

    def poses(self, number: int) -> History:
        """Return the poses of a neighbour by its number; everything else is zero."""
        one, history = self.neighbours.each[number], History()
        problem, points = one.problem, np.zeros((len(gauss_positions(one.problem).s), 6))
        joints = JointState(*np.zeros((3, problem.joints.count))) if problem.joints.count else None
        reactions = np.zeros((len(problem.supports.nodes), 6))
        for change, increment in self._taken:
            state = change.moved(increment, one.change)
            snapshot = Snapshot(state, points, points, points, reactions, 0.0, 0.0, joints)
            history.record(change.at.scale, snapshot, EnergyAccount(), 0.0, 0)
        return history

    @cached_property
    def histories(self) -> list[History]:
        """All that is recorded of every neighbour."""
        found = [History() for _ in self.neighbours.each]
        for change, increment in self._taken:
            each = snapshots(change, self.neighbours, increment, self._discrete)
            for snapshot, history in zip(each, found, strict=True):
                account = EnergyAccount(elastic=snapshot.elastic)
                history.record(change.at.scale, snapshot, account, 0.0, 0)
        return found


def snapshots(
    change: StaticChange, neighbours: Neighbours, increment: Floats, discrete: DiscreteModel
) -> list[Snapshot]:
    """Return what is recorded of all neighbours in their equilibria, to first order.

    Args:
        change: of the equilibrium; increment: of its nodes and multipliers ``(N, 6)`` per unit of the number.
        discrete: the model itself.
    """
    moved = [change.moved(increment, one.change) for one in neighbours.each]
    if not _keep_shape(neighbours, discrete):
        return [
            _taken(change, one, state, discrete) for one, state in zip(neighbours.each, moved, strict=True)
        ]
    start = _taken(change, discrete, change.state, discrete)
    here = _packed(start)
    slope = neighbours.derivative(lambda one: _packed(_taken(change, one, change.state, discrete)) - here)
    slope = slope + _along(change, increment, discrete)
    return [
        _unpacked(here + one.change * slope, start, state)
        for one, state in zip(neighbours.each, moved, strict=True)
    ]


def _along(change: StaticChange, increment: Floats, discrete: DiscreteModel) -> Floats:
    """Return the derivative of what is recorded with the state alone, along its increment."""
    nodes = increment[: len(change.state.r)]
    length = discrete.problem.length
    size = max(float(np.abs(nodes[:, :3]).max()) / length, float(np.abs(nodes[:, 3:]).max()))
    if not increment.any():
        return np.zeros(())
    step = MOVED / size if size > 0.0 else 1.0
    central = MANY[0]
    found = [
        weight / step * _packed(_taken(change, discrete, change.moved(increment, place * step), discrete))
        for place, weight in zip(central.places, central.weights, strict=True)
    ]
    return np.asarray(sum(found))


def _taken(
    change: StaticChange, one: Neighbour | DiscreteModel, state: State, discrete: DiscreteModel
) -> Snapshot:
    """Return what is recorded of a model in a state at rest, under the loads of the equilibrium."""
    at, angles = change.at, change.angles
    static = one.resting if isinstance(one, Neighbour) else one.static
    near(static, angles)
    static.restore(state, at.t, before=at.before, scale=at.scale)
    found = Snapshot.of(state, static.system, static.supports)
    near(discrete.static, angles)
    return found


def _packed(snapshot: Snapshot) -> Floats:
    """Return all numbers of a snapshot at rest but those of its state, one after the other."""
    return np.concatenate([np.ravel(field) for field in _fields(snapshot)])


def _fields(snapshot: Snapshot) -> list[Floats | float]:
    joints: Sequence[Floats] = () if snapshot.joints is None else tuple(snapshot.joints)
    return [snapshot.strain, snapshot.section_force, snapshot.reaction, snapshot.elastic, *joints]


def _unpacked(values: Floats, start: Snapshot, state: State) -> Snapshot:
    """Return a snapshot with other numbers than those of ``start``."""
    fields = _fields(start)
    ends = np.cumsum([np.size(field) for field in fields])
    parts = np.split(values, ends[:-1])
    strain, force, reaction, elastic, *joints = (
        part.reshape(np.shape(field)) for part, field in zip(parts, fields, strict=True)
    )
    return start._replace(
        state=state,
        strain=strain,
        section_force=force,
        reaction=reaction,
        elastic=float(elastic),
        joints=JointState(*joints) if joints else None,
    )
