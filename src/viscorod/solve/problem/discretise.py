"""From the user's model to the arrays of a :class:`~viscorod.solve.problem.problem.Problem`."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.load import AnyLoad
from viscorod.model.actions.time_function import Sine, TimeFunction
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.connections.place import BodyPlace
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.strain_multipliers import held_strains
from viscorod.solve.problem.division import Divisions
from viscorod.solve.problem.layout import chosen_layout, layout_of
from viscorod.solve.problem.load_placing import place_loads
from viscorod.solve.problem.massless_turns import refuse_massless_turns
from viscorod.solve.problem.mesh import element_sets
from viscorod.solve.problem.placement import Placement
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

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
    pattern, joints, supports = layout.pattern, layout.joints, layout.supports
    sets, mass, relaxation_times = element_sets(mesh, layout.sets)
    refuse_massless_turns(model.bodies, mesh, mass, supports, joints)
    nodal_loads, station_loads, motion_loads = place_loads(model, places)
    motions = [motion for _, _, motion in supports.motions] + [motion for _, motion in joints.motions]
    breakpoints, jumps, periods = _times(model, motions)
    times = {k: load.time for k, load in enumerate(model.loads)}
    records = {k: f for k, f in times.items() if isinstance(f, TimeTable) and _sampled(model.loads[k])}
    problem = Problem(
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
        bodies=layout.bodies,
        joints=joints,
        held=held_strains(sets, pattern, layout.nodes, layout.first_held),
        multipliers=layout.multipliers,
        interiors=layout.interiors,
        supports=supports,
        nodal_loads=nodal_loads,
        station_loads=station_loads,
        motion_loads=motion_loads,
        stations=layout.stations,
        initial_strain={mesh.rod_index(strain.rod): strain.at for strain in model.strains},
        rest_strains=tuple(
            (mesh.rod_index(strain.rod), strain.on(model.rods[strain.rod])) for strain in model.rest_strains
        ),
        initial_twist=_initial_twist(model, places),
        relaxation_times=relaxation_times,
        length=layout.length,
        breakpoints=breakpoints,
        jumps=jumps,
        rows=tuple(sorted({t for k in records for t in model.loads[k].breakpoints})),
        records=records,
        record_ends={k: np.inf if (end := model.loads[k].until) is None else end for k in records},
        functions={k: f for k, f in times.items() if isinstance(f, FunctionOfTime)},
        periods=periods,
    )
    object.__setattr__(problem, "of_layout", layout.found)
    return problem


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
