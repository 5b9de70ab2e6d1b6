"""From recorded arrays to the data set that results are built from."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.mechanics.elements.section_laws import POWER
from viscorod.mechanics.nodes import inertia
from viscorod.results.data_schema import DIMENSION, LABELS
from viscorod.results.joint_histories import bodies_of_stations, connections, unique
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.history import History, StationReader
from viscorod.solve.problem.law_responses import law_responses
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr


def dataset(
    kind: str, problem: Problem, gauss: GaussPositions, history: History, attrs: dict[str, Any]
) -> xr.Dataset:
    """Arrange a history as the data set of a result that has states.

    Args:
        kind: "simulate", "equilibrium", "steady", "modes" or "buckling".
        problem: the solved one; gauss: positions of its Gauss points.
        history: recorded states.
        attrs: attributes of the whole data set (see ``schema``).
    """
    import xarray as xr

    along = DIMENSION[kind]
    reader = StationReader(problem)
    r0, q0, _, _ = reader.read(problem.positions, problem.quaternions, np.zeros((problem.size, 6)))
    recorded, (energy, branch_loss) = history.states(), history.energies()
    r, q, twist = recorded.r, recorded.q, recorded.twist
    position, rotation, velocity, spin = reader.read(r, q, twist)
    names, bodies = np.array(problem.rods), problem.bodies.names
    still = np.zeros(len(bodies))
    states = (along, "station")
    points = (along, "point")
    variables: dict[str, Any] = {
        "reference_position": (("station", "axis"), r0),
        "reference_rotation": (("station", "quaternion"), q0),
        "position": ((*states, "axis"), position),
        "rotation": ((*states, "quaternion"), _continuous(rotation)),
        "strain": ((*points, "component"), recorded.strain),
        "section_force": ((*points, "component"), recorded.section_force),
        "half_width": ("point", gauss.half_width),
        "iterations": (along, np.array(history.iterations, dtype=np.int64)),
    }
    variables["elastic"] = (along, energy[:, 1])
    if kind not in ("equilibrium", "modes", "buckling"):
        variables |= {
            "velocity": ((*states, "axis"), velocity),
            "angular_velocity": ((*states, "axis"), spin),
            "kinetic": (along, energy[:, 0]),
        }
    if history.unstable:
        variables["negative_eigenvalues"] = (along, np.array(history.unstable, dtype=np.int64))
    if kind == "simulate":
        rate = recorded.strain_rate
        momentum = _momenta(problem, r, q, twist)
        power = np.einsum("kgi,gij,kgj->kg", rate, gauss.damping, rate)
        if problem.laws.present:
            sections = np.tile(gauss.section, (len(rate), 1))
            power += law_responses(problem.laws, sections, recorded.strain, rate)[..., POWER]
        if problem.relaxing:
            power += recorded.branch_power
            variables["branch_loss"] = ((along, "branch"), branch_loss)
            if recorded.branch_strain is not None:
                where = (along, "point", "branch", "component")
                variables["branch_strain"] = (where, recorded.branch_strain)
        if problem.motion_loads:
            variables["outside"] = (along, energy[:, 5])
        if any(strain.changes for _, strain in problem.rest_strains):
            variables["actuator"] = (along, energy[:, 6])
        variables |= {
            "dissipation": (points, power),
            "viscous": (along, energy[:, 2]),
            "external": (along, energy[:, 3]),
            "numerical": (along, energy[:, 4]),
            "step_size": (along, np.array(history.step_size)),
            "linear_momentum": ((along, "axis"), momentum[:, :3]),
            "angular_momentum": ((along, "axis"), momentum[:, 3:]),
        }
    coordinates: dict[str, Any] = {
        "axis": _labels("axis"),
        "quaternion": _labels("quaternion"),
        "component": _labels("component"),
        along: np.array(history.instant),
        "station_rod": ("station", np.array([*names[problem.stations.rod], *bodies])),
        "station_s": ("station", np.append(problem.stations.s, still)),
        "station_order": (
            "station",
            np.append(problem.rod_orders[problem.stations.rod], still.astype(np.int64)),
        ),
        "point_rod": ("point", names[gauss.rod]),
        "point_s": ("point", gauss.s),
        "point_weight": ("point", gauss.length),
    }
    if problem.relaxing:
        coordinates["relaxation_time"] = ("branch", problem.relaxation_times)
    if problem.supports.names:
        variables["reaction"] = ((along, "support", "motion"), recorded.reaction)
        coordinates |= {"support": list(problem.supports.names), "motion": _labels("motion")}
    if bodies:
        coordinates["station_body"] = ("station", bodies_of_stations(problem, reader))
    if problem.joints.count:
        coordinates |= connections(problem, reader)
        joints = _joints(along, problem, recorded.joints)
        variables, coordinates = variables | joints[0], coordinates | joints[1]
    return xr.Dataset(variables, coordinates, attrs={"kind": kind, **attrs})


def _joints(along: str, problem: Problem, states: JointState | None) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and dimensions for the coordinates of joints and springs."""
    if states is None:
        return {}, {}
    joints = problem.joints
    names = np.array(unique(joints.names))
    where = "joint_coordinate"
    variables = {f"joint_{name}": ((along, where), getattr(states, name)) for name in JointState._fields}
    return variables, {
        "joint": (where, names[joints.joint]),
        "joint_motion": (where, np.array(joints.words)),
        "joint_held": (where, joints.arrays.place >= 0),
    }


@lru_cache
def _labels(dimension: str) -> xr.Variable:
    """Return the coordinate of a dimension whose places have names; its index is made once for all results."""
    import xarray as xr

    return xr.Dataset(coords={dimension: list(LABELS[dimension])}).variables[dimension]


def _momenta(problem: Problem, r: Floats, q: Floats, twist: Floats) -> Floats:
    """Return total linear and angular momentum about the origin, global axes ``(instants, 6)``."""
    total = np.empty((len(r), 6))
    nodal = np.empty(twist.shape[1:])
    for k in range(len(r)):
        inertia.momenta(problem.mass, r[k], q[k], twist[k], nodal)
        total[k] = nodal.sum(axis=0)
    return total


def _continuous(q: np.ndarray) -> np.ndarray:
    """Flip quaternions so that each is nearest to the one before it in time: both signs mean one rotation."""
    if len(q) > 1:
        flips = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
        q[1:][np.cumsum(flips, axis=0) % 2 == 1] *= -1.0
    return q
