"""From the user's model to the arrays of a :class:`~viscorod.solve.problem.problem.Problem`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.load import AnyLoad
from viscorod.model.actions.time_function import Sine, TimeFunction
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.connections.place import BodyPlace
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.rod import Rod
from viscorod.solve.constraints.strain_multipliers import held_strains
from viscorod.solve.problem.division import Divisions
from viscorod.solve.problem.layout import Layout, chosen_layout, layout_of
from viscorod.solve.problem.load_placing import place_loads
from viscorod.solve.problem.massless_turns import refuse_massless_turns
from viscorod.solve.problem.mesh import Mesh, element_sets
from viscorod.solve.problem.model_parts import shape_token, token
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

OF_NO_SECTION = (
    "bodies",
    "supports",
    "attachments",
    "joints",
    "springs",
    "velocities",
    "strains",
    "rest_strains",
)
"""Parts of a model that neither sections nor loads enter."""
MANY_ROWS = 100
"""Rows from which on a table is a record, whose rows are no corners."""


def discretise(
    model: ModelDescription, *, validated: bool = False, divisions: Divisions | None = None
) -> Problem:
    """Divide the rods, number the nodes, lump the masses and place supports, loads and joints.

    Args:
        model: what is to be computed.
        validated: whether ``model.validate()`` has passed already.
        divisions: of the rods into elements; by default those that the rods say or the program chooses.

    Raises:
        InputError: the model is inconsistent, or its mesh cannot satisfy it.
    """
    if not validated:
        model.validate()
    layout = chosen_layout(model) if divisions is None else layout_of(model, divisions)
    mesh = layout.mesh_of(model)
    places = Placement(model, mesh, layout.spots)
    problem = Problem(
        rods=tuple(m.name for m in mesh.rods),
        rod_lengths=np.array([m.rod.length for m in mesh.rods]),
        rod_orders=np.array([m.order for m in mesh.rods], dtype=np.int64),
        positions=mesh.positions,
        quaternions=mesh.quaternions,
        link_positions=mesh.link_positions,
        link_quaternions=mesh.link_quaternions,
        pattern=layout.pattern,
        bodies=layout.bodies,
        joints=layout.joints,
        multipliers=layout.multipliers,
        interiors=layout.interiors,
        supports=layout.supports,
        stations=layout.stations,
        initial_strain={mesh.rod_index(strain.rod): strain.at for strain in model.strains},
        rest_strains=tuple(
            (mesh.rod_index(strain.rod), strain.on(model.rods[strain.rod])) for strain in model.rest_strains
        ),
        initial_twist=_initial_twist(model, places),
        length=layout.length,
        **_of_sections(model, mesh, layout),
        **_of_loads(model, places, layout),
    )
    return _of_layout(problem, layout)


def discretise_beside(problem: Problem, model: ModelDescription, other: ModelDescription) -> Problem | None:
    """Return the problem of a model that differs from another one in numbers of sections, materials and loads alone.

    Only what these enter is made: the rest is that of the other problem, by the very same arrays.

    Args:
        problem: of ``model``; other: that whose problem is wanted, of parts that have passed their own checks.

    Returns:
        None: the models differ in more, or in where elements must end; :func:`discretise` makes its problem.

    Raises:
        InputError: the model has bodies that turn without inertia.
    """
    layout: Layout | None = problem.layout
    if layout is None or any(
        not _are_same(getattr(model, name), getattr(other, name)) for name in OF_NO_SECTION
    ):
        return None
    here, there = model.rods, other.rods
    if list(here) != list(there) or len(model.loads) != len(other.loads):
        return None
    same_rods = _are_same(list(here.values()), list(there.values()))
    changed = [(one, there[name]) for name, one in here.items() if one is not there[name]]
    if any(strain.on(there[strain.rod]) is not strain for strain in model.rest_strains if changed):
        return None  # materials expand
    if not all(_laid_alike(*pair) for pair in changed):
        return None
    pairs = zip(model.loads, other.loads, strict=True)
    if not all(one is its or list(one.breaks(model)) == list(its.breaks(other)) for one, its in pairs):
        return None
    mesh = layout.mesh_of(other)
    fields: dict[str, Any] = {}
    if not same_rods:
        fields |= _of_sections(other, mesh, layout)
    if not same_rods or not _are_same(model.loads, other.loads):
        fields |= _of_loads(other, Placement(other, mesh, layout.spots), layout)
    return _of_layout(replace(problem, **fields), layout)


def _are_same(one: Mapping[str, Any] | Sequence[Any], other: Mapping[str, Any] | Sequence[Any]) -> bool:
    """Return whether two lists or tables hold the very same parts."""
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        return list(one) == list(other) and _are_same(list(one.values()), list(other.values()))
    return len(one) == len(other) and all(a is b for a, b in zip(one, other, strict=True))


def _laid_alike(rod: Rod, other: Rod) -> bool:
    """Return whether two rods have their nodes at the same places, and their sections between the same ones."""
    mine, its = shape_token(rod), shape_token(other)
    return all(a is b or token(a) == token(b) for a, b in zip(mine, its, strict=True)) and (
        rod.section_breaks == other.section_breaks
    )


def _of_layout(problem: Problem, layout: Layout) -> Problem:
    """Let a problem share what was found of its layout."""
    object.__setattr__(problem, "layout", layout)
    object.__setattr__(problem, "of_layout", layout.found)
    return problem


def _of_sections(model: ModelDescription, mesh: Mesh, layout: Layout) -> dict[str, Any]:
    """Return the fields of a problem that sections and materials enter."""
    sets, mass, relaxation_times = element_sets(mesh, layout.sets)
    refuse_massless_turns(model.bodies, mesh, mass, layout.supports, layout.joints)
    held = held_strains(sets, layout.pattern, layout.nodes, layout.first_held)
    return {"sets": sets, "mass": mass, "relaxation_times": relaxation_times, "held": held}


def _of_loads(model: ModelDescription, places: Placement, layout: Layout) -> dict[str, Any]:
    """Return the fields of a problem that loads enter."""
    motions = [motion for _, _, motion in layout.supports.motions]
    motions += [motion for _, motion in layout.joints.motions]
    nodal_loads, station_loads, motion_loads = place_loads(model, places)
    breakpoints, jumps, periods = _times(model, motions)
    times = {k: load.time for k, load in enumerate(model.loads)}
    records = {k: f for k, f in times.items() if isinstance(f, TimeTable) and _sampled(model.loads[k])}
    return {
        "nodal_loads": nodal_loads,
        "station_loads": station_loads,
        "motion_loads": motion_loads,
        "breakpoints": breakpoints,
        "jumps": jumps,
        "rows": tuple(sorted({t for k in records for t in model.loads[k].breakpoints})),
        "records": records,
        "record_ends": {k: np.inf if (end := model.loads[k].until) is None else end for k in records},
        "functions": {k: f for k, f in times.items() if isinstance(f, FunctionOfTime)},
        "periods": periods,
    }


def _sampled(load: AnyLoad) -> bool:
    """Return whether the rows of a load's table are so many that they are samples of something smooth."""
    own = type(load).factor is not AnyLoad.factor  # it does more with its time
    return (
        isinstance(load.time, TimeTable)
        and not own
        and not load.travels
        and len(load.time.knots) >= MANY_ROWS
    )


def _times(
    model: ModelDescription, motions: list[TimeFunction]
) -> tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...]]:
    """Return times that steps must hit, those at which the integrator must start anew, and load periods."""
    corners: set[float] = set()
    jumps: set[float] = set()
    functions: list[TimeFunction | None] = [load.time for load in model.loads]
    for load in model.loads:
        if _sampled(load) and isinstance(load.time, TimeTable):
            corners.update(t for t in load.breakpoints if t in {*load.time.corners, load.until})
        else:
            corners.update(load.breakpoints)
        jumps.update(load.jumps)
        passages = load.passages(model)
        corners.update(passages)
        jumps.update(passages)
    for motion in motions:
        corners.update(motion.breakpoints)
        jumps.update(motion.breakpoints)
        functions.append(motion)
    for strain in model.rest_strains:
        corners.update(strain.breakpoints)
        jumps.update(strain.jumps)
        functions.append(strain.time)
    periods = tuple(1.0 / f.frequency for f in functions if isinstance(f, Sine))
    return tuple(sorted(corners)), tuple(sorted(jumps)), periods


def _initial_twist(model: ModelDescription, places: Placement) -> Callable[[Floats, Floats], Floats]:
    """Return the body twists of all nodes as a function of their poses, from the given velocities."""
    mesh = places.mesh

    def twists(r: Floats, q: Floats) -> Floats:
        twist = np.zeros((len(r), 6))
        if not model.velocities:
            return twist
        R = matrices(q)

        def give(node: int, arm: Floats, linear: Floats, angular: Floats) -> None:
            turning = R[node].T @ angular
            twist[node, :3], twist[node, 3:] = R[node].T @ linear - np.cross(turning, arm), turning

        given: dict[int, str] = {}
        for index, velocity in enumerate(model.velocities):
            if velocity.rod in model.bodies:
                spot = places.spot(BodyPlace(velocity.rod, None))
                assert spot is not None
                before = twist[spot.node].copy()
                give(spot.node, spot.arm, *velocity.at(0.0, r[spot.node] + R[spot.node] @ spot.arm))
                other = given.setdefault(spot.node, velocity.rod)
                if other != velocity.rod and not np.allclose(before, twist[spot.node], rtol=1e-6, atol=1e-12):
                    raise InputError(
                        Fault(
                            f"velocities[{index}]",
                            velocity.rod,
                            f"it moves as one with {other!r}, which has another velocity",
                            "give both the same rigid motion, or one of them only",
                        )
                    )
                continue
            rod = mesh.rod_index(velocity.rod)
            for k, s in enumerate(mesh.rods[rod].s):
                spot = places.at_station(rod, k)
                give(spot.node, spot.arm, *velocity.at(float(s), r[spot.node] + R[spot.node] @ spot.arm))
        return twist

    return twists
