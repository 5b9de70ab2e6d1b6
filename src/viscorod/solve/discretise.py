"""From the user's model to the arrays of a :class:`~viscorod.solve.problem.Problem`."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from viscorod.errors import InputError
from viscorod.errors import Problem as Fault
from viscorod.mechanics.basis import gauss, lagrange
from viscorod.mechanics.quaternion import matrices
from viscorod.model.any_support import ResolvedSupport
from viscorod.model.description import ModelDescription
from viscorod.model.load import (
    AnyLoad,
    DistributedForce,
    DistributedMoment,
    Force,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.model.motion_words import MOTIONS
from viscorod.model.place import Place, find_place
from viscorod.model.time_function import Sine, TimeFunction
from viscorod.solve.mesh import (
    Mesh,
    couplings,
    divide,
    element_nodes,
    element_sets,
    join,
    link_matrix,
    stations_of,
)
from viscorod.solve.problem import NodalLoad, Problem, StationLoad, SupportSet, TimeFactor
from viscorod.typing import Floats, Integers


def discretise(model: ModelDescription) -> Problem:
    """Divide the rods, number the nodes, lump the masses and place supports and loads.

    Raises:
        InputError: the model is inconsistent, or its mesh cannot satisfy it.
    """
    model.validate()
    mesh = _mesh(model)
    pattern = couplings(mesh)
    sets, mass = element_sets(mesh, pattern)
    supports = _supports(model, mesh)
    nodal: list[NodalLoad] = []
    moving: list[StationLoad] = []
    for load in model.loads:
        placed = _load(load, model, mesh)
        if isinstance(placed, NodalLoad):
            nodal.append(placed)
        else:
            moving.append(placed)
    breakpoints, jumps, periods = _times(model, supports)
    return Problem(
        rods=tuple(m.name for m in mesh.rods),
        rod_lengths=np.array([m.rod.length for m in mesh.rods]),
        rod_orders=np.array([m.order for m in mesh.rods], dtype=np.int64),
        positions=mesh.positions,
        quaternions=mesh.quaternions,
        mass=mass,
        sets=sets,
        link_positions=mesh.link_positions,
        link_quaternions=mesh.link_quaternions,
        pattern=pattern,
        supports=supports,
        nodal_loads=tuple(nodal),
        station_loads=tuple(moving),
        stations=stations_of(mesh),
        initial_strain={mesh.rod_index(strain.rod): strain.at for strain in model.strains},
        initial_twist=_initial_twist(model, mesh),
        length=max(m.rod.length for m in mesh.rods),
        breakpoints=breakpoints,
        jumps=jumps,
        periods=periods,
    )


def _mesh(model: ModelDescription) -> Mesh:
    breaks: dict[str, list[float]] = {name: list(rod.section_breaks) for name, rod in model.rods.items()}
    wishes: dict[str, list[float]] = {name: [] for name in model.rods}
    pairs = [(find_place(a.a, model.rods), find_place(a.b, model.rods)) for a in model.attachments]
    held = [find_place(support.at, model.rods) for support in model.supports]
    for place in [*held, *(p for pair in pairs for p in pair)]:
        breaks[place.rod].append(place.s)
    for load in model.loads:
        if isinstance(load, Force | Moment):
            place = find_place(load.at, model.rods)
            wishes[place.rod].append(place.s)
        elif isinstance(load, DistributedForce | DistributedMoment):
            wishes[load.rod].extend(s for s in (load.from_s, load.to_s) if s is not None)
    rods = [divide(name, rod, breaks[name], wishes[name]) for name, rod in model.rods.items()]
    index = {m.name: i for i, m in enumerate(rods)}

    def station(place: Place) -> tuple[int, int]:
        node = rods[index[place.rod]].node_at(place.s)
        assert node is not None  # places of attachments are element ends
        return index[place.rod], node

    return join(rods, [(station(a), station(b)) for a, b in pairs])


def _node(mesh: Mesh, place: Place) -> tuple[int, int] | None:
    """Shared node and attachment at a place, or None between nodes."""
    rod = mesh.rod_index(place.rod)
    station = mesh.rods[rod].node_at(place.s)
    if station is None:
        return None
    return int(mesh.shared[rod][station]), int(mesh.links[rod][station])


def _supports(model: ModelDescription, mesh: Mesh) -> SupportSet:
    resolved: dict[int, list[ResolvedSupport]] = {}
    places: dict[int, dict[str, None]] = {}
    for index, support in enumerate(model.supports):
        place = find_place(support.at, model.rods)
        found = _node(mesh, place)
        assert found is not None  # places of supports are element ends
        frame = model.rods[place.rod].frames([place.s])[1][0]
        places.setdefault(found[0], {})[support.at] = None
        resolved.setdefault(found[0], []).append(support.resolve(f"supports[{index}]", place, frame))
    nodes = np.array(sorted(resolved), dtype=np.int64)
    axes = np.empty((len(nodes), 3, 3))
    fixed = np.zeros((len(nodes), 6))
    motions: list[tuple[int, int, TimeFunction]] = []
    names = []
    for k, node in enumerate(nodes):
        group = resolved[int(node)]
        axes[k] = group[0].axes
        names.append(" + ".join(places[node]))
        for held in group:
            if np.abs(held.axes - axes[k]).max() > 1e-9:
                raise InputError(
                    Fault(
                        held.path,
                        held.label,
                        f"its axes differ from those of {group[0].label}, which holds the same place",
                        "hold the place by one support, or give both the same axes",
                    )
                )
            for word in held.held:
                fixed[k, MOTIONS.index(word)] = 1.0
            motions.extend((k, MOTIONS.index(word), motion) for word, motion in held.motion.items())
    return SupportSet(nodes, np.ascontiguousarray(axes), fixed, tuple(names), tuple(motions))


def _load(load: AnyLoad, model: ModelDescription, mesh: Mesh) -> NodalLoad | StationLoad:
    none: Integers = np.empty(0, dtype=np.int64)
    if isinstance(load, Gravity):
        return NodalLoad(none, np.empty((0, 6)), np.empty((0, 6)), np.array(load.acceleration), load.factor)
    if isinstance(load, MovingForce):
        dead, following = _wrenches(load.value, load.following, moment=False)
        position, factor = _travel(load, model.rods[load.rod].length)
        return StationLoad(mesh.rod_index(load.rod), position, dead, following, factor)
    if isinstance(load, DistributedForce | DistributedMoment):
        return _distributed(load, mesh)
    assert isinstance(load, Force | Moment)
    place = find_place(load.at, model.rods)
    dead, following = _wrenches(load.value, load.following, moment=isinstance(load, Moment))
    found = _node(mesh, place)
    if found is None:
        s = place.s

        def here(_t: float, _before: bool) -> float:
            return s

        return StationLoad(mesh.rod_index(place.rod), here, dead, following, load.factor)
    node, link = found
    if link >= 0:
        following = link_matrix(mesh, link).T @ following
    return NodalLoad(
        np.array([node], dtype=np.int64), dead[None, :], following[None, :], np.zeros(3), load.factor
    )


def _wrenches(value: object, following: bool, *, moment: bool) -> tuple[Floats, Floats]:
    """Dead and following wrenches (6,) of a force or moment vector."""
    wrench = np.zeros(6)
    wrench[3 if moment else 0 : 6 if moment else 3] = np.asarray(value, dtype=float)
    return (np.zeros(6), wrench) if following else (wrench, np.zeros(6))


def _distributed(load: DistributedForce | DistributedMoment, mesh: Mesh) -> NodalLoad:
    """Nodal wrenches of a distributed load: its density integrated with the shape functions over the loaded part."""
    index = mesh.rod_index(load.rod)
    rod = mesh.rods[index]
    begin = load.from_s or 0.0
    end = rod.rod.length if load.to_s is None else load.to_s
    points, weights = gauss(rod.order + 2)
    shared = element_nodes(mesh.shared[index], rod.order)
    links = element_nodes(mesh.links[index], rod.order)
    column = 3 if isinstance(load, DistributedMoment) else 0
    nodes: list[int] = []
    wrenches: list[Floats] = []
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
            if load.following and links[e, k] >= 0:
                wrench = link_matrix(mesh, int(links[e, k])).T @ wrench
            nodes.append(int(shared[e, k]))
            wrenches.append(wrench)
    values = np.array(wrenches)
    zero = np.zeros_like(values)
    dead, following = (zero, values) if load.following else (values, zero)
    return NodalLoad(np.array(nodes, dtype=np.int64), dead, following, np.zeros(3), load.factor)


def _times(
    model: ModelDescription, supports: SupportSet
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Times that steps must hit, those at which the integrator must start anew, and load periods."""
    corners: set[float] = set()
    jumps: set[float] = set()
    functions: list[TimeFunction | None] = [load.time for load in model.loads]
    for load in model.loads:
        corners.update(load.breakpoints)
        jumps.update(load.jumps)
        if isinstance(load, MovingForce):
            ends = _passages(load, model.rods[load.rod].length)
            corners.update(ends)
            jumps.update(ends)
    for _, _, motion in supports.motions:
        corners.update(motion.breakpoints)
        jumps.update(motion.breakpoints)
        functions.append(motion)
    periods = tuple(1.0 / f.frequency for f in functions if isinstance(f, Sine))
    return tuple(sorted(corners)), tuple(sorted(jumps)), periods


def _travel(load: MovingForce, length: float) -> tuple[TimeFactor, TimeFactor]:
    """Arc length and factor of a moving force as functions of time.

    Whether it acts is decided by which of its passages over the rod's ends a time lies between, not by the rounding of
    its arc length there.
    """
    passages = _passages(load, length)
    if not passages:
        return load.arc_length, load.factor
    middles = [0.5 * (a + b) for a, b in pairwise(passages)]
    samples = [passages[0] - 1.0, *middles, passages[-1] + 1.0]
    on_rod = [0.0 <= load.arc_length(t) <= length for t in samples]

    def position(t: float, before: bool) -> float:
        return min(max(load.arc_length(t, before), 0.0), length)

    def factor(t: float, before: bool) -> float:
        acts = on_rod[(bisect_left if before else bisect_right)(passages, t)]
        return load.factor(t, before) if acts else 0.0

    return position, factor


def _passages(load: MovingForce, length: float) -> list[float]:
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


def _initial_twist(model: ModelDescription, mesh: Mesh) -> Callable[[Floats, Floats], Floats]:
    """Body twists of all nodes as a function of their poses, from the given velocities."""

    def twists(r: Floats, q: Floats) -> Floats:
        twist = np.zeros((len(r), 6))
        for velocity in model.velocities:
            rod = mesh.rod_index(velocity.rod)
            for s, node in zip(mesh.rods[rod].s, mesh.shared[rod], strict=True):
                linear, angular = velocity.at(float(s), r[node])
                R = matrices(q[node : node + 1])[0]
                twist[node, :3], twist[node, 3:] = R.T @ linear, R.T @ angular
        return twist

    return twists
