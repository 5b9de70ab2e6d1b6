"""From the loads of a model to wrenches on nodes or within elements."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from itertools import pairwise

import numpy as np

from viscorod.mechanics.elements.basis import gauss, lagrange
from viscorod.model.actions.load import (
    AnyLoad,
    DistributedForce,
    DistributedMoment,
    Force,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.model.connections.place import Place
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import NodalLoad, StationLoad, TimeFactor
from viscorod.typing import Floats, Integers


def place_load(load: AnyLoad, model: ModelDescription, places: Placement) -> NodalLoad | StationLoad:
    """Return a load on nodes, or within elements."""
    mesh = places.mesh
    none: Integers = np.empty(0, dtype=np.int64)
    if isinstance(load, Gravity):
        empty = np.empty((0, 6))
        return NodalLoad(none, empty, empty, np.array(load.acceleration), np.empty((0, 3)), load.factor)
    if isinstance(load, MovingForce):
        dead, following = _wrenches(load.value, load.following, moment=False)
        position, factor = _travel(load, model.rods[load.rod].length)
        return StationLoad(mesh.rod_index(load.rod), position, dead, following, factor)
    if isinstance(load, DistributedForce | DistributedMoment):
        return _distributed(load, places)
    assert isinstance(load, Force | Moment)
    place = places.find(load.at)
    dead, following = _wrenches(load.value, load.following, moment=isinstance(load, Moment))
    spot = places.spot(place)
    if spot is None:
        assert isinstance(place, Place)
        s = place.s

        def here(_t: float, _before: bool) -> float:
            return s

        return StationLoad(mesh.rod_index(place.rod), here, dead, following, load.factor)
    return NodalLoad(
        np.array([spot.node], dtype=np.int64),
        dead[None, :],
        spot.wrench(following)[None, :],
        np.zeros(3),
        spot.arm[None, :],
        load.factor,
    )


def _wrenches(value: object, following: bool, *, moment: bool) -> tuple[Floats, Floats]:
    """Dead and following wrenches (6,) of a force or moment vector."""
    wrench = np.zeros(6)
    wrench[3 if moment else 0 : 6 if moment else 3] = np.asarray(value, dtype=float)
    return (np.zeros(6), wrench) if following else (wrench, np.zeros(6))


def _distributed(load: DistributedForce | DistributedMoment, places: Placement) -> NodalLoad:
    """Nodal wrenches of a distributed load: its density integrated with the shape functions over the loaded part."""
    mesh = places.mesh
    index = mesh.rod_index(load.rod)
    rod = mesh.rods[index]
    begin = load.from_s or 0.0
    end = rod.rod.length if load.to_s is None else load.to_s
    points, weights = gauss(rod.order + 2)
    column = 3 if isinstance(load, DistributedMoment) else 0
    nodes: list[int] = []
    wrenches: list[Floats] = []
    arms: list[Floats] = []
    for e, (a, b) in enumerate(zip(rod.ends[:-1], rod.ends[1:], strict=True)):
        low, high = max(a, begin), min(b, end)
        if high <= low:
            continue
        s = 0.5 * (low + high) + 0.5 * (high - low) * points
        shapes, _ = lagrange(rod.order, 2.0 * (s - a) / (b - a) - 1.0)
        density = np.array([load.density(float(x)) for x in s])
        forces = np.einsum("gk,gi,g->ki", shapes, density, 0.5 * (high - low) * weights)
        for k in range(rod.order + 1):
            wrench = np.zeros(6)
            wrench[column : column + 3] = forces[k]
            spot = places.at_station(index, e * rod.order + k)
            nodes.append(spot.node)
            wrenches.append(spot.wrench(wrench) if load.following else wrench)
            arms.append(spot.arm)
    values = np.array(wrenches)
    zero = np.zeros_like(values)
    dead, following = (zero, values) if load.following else (values, zero)
    return NodalLoad(
        np.array(nodes, dtype=np.int64), dead, following, np.zeros(3), np.array(arms), load.factor
    )


def _travel(load: MovingForce, length: float) -> tuple[TimeFactor, TimeFactor]:
    """Arc length and factor of a moving force as functions of time.

    Whether it acts is decided by which of its passages over the rod's ends a time lies between, not by the rounding of
    its arc length there.
    """
    ends = passages(load, length)
    if not ends:
        return load.arc_length, load.factor
    middles = [0.5 * (a + b) for a, b in pairwise(ends)]
    samples = [ends[0] - 1.0, *middles, ends[-1] + 1.0]
    on_rod = [0.0 <= load.arc_length(t) <= length for t in samples]

    def position(t: float, before: bool) -> float:
        return min(max(load.arc_length(t, before), 0.0), length)

    def factor(t: float, before: bool) -> float:
        acts = on_rod[(bisect_left if before else bisect_right)(ends, t)]
        return load.factor(t, before) if acts else 0.0

    return position, factor


def passages(load: MovingForce, length: float) -> list[float]:
    """Times at which a moving force passes an end of its rod; between breakpoints of its position, if that is given."""
    if load.position is None:
        speed, start = load.speed or 0.0, load.arc_length(0.0)
        return sorted((s - start) / speed for s in (0.0, length)) if speed else []
    from scipy.optimize import brentq

    position = load.position
    times = set(position.jumps)
    for a, b in pairwise(position.breakpoints):
        for end in (0.0, length):
            low, high = position.value(a) - end, position.value(b, before=True) - end
            if low * high < 0.0:
                times.add(
                    float(brentq(lambda t, end=end: position.value(t) - end, a, b, xtol=1e-15, rtol=1e-14))
                )
            times.update(t for t, gap in ((a, low), (b, high)) if gap == 0.0)
    return sorted(times)
