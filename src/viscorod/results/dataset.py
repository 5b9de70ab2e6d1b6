"""From recorded arrays to the data set that results are built from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.mechanics.elements.section_laws import POWER
from viscorod.mechanics.nodes import inertia
from viscorod.results.data_schema import DIMENSION, LABELS
from viscorod.results.joint_histories import bodies_of_stations, connections, unique
from viscorod.results.late_attributes import LateAttributes, Later
from viscorod.results.result_places import ResultPlaces
from viscorod.results.state_arrays import StateArrays
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.history import History, Snapshots, StationReader, station_reader
from viscorod.solve.once import once_of_layout
from viscorod.solve.problem.law_responses import law_responses
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    import xarray as xr

AT_ONCE = 4096
"""Nodes whose momenta are computed at once."""
OF_MESH = ("mesh_errors", "mesh_motion_error", "mesh_force_error", "mesh_jumps", "mesh_lost")
"""Attributes that a comparison with a finer mesh makes."""


def dataset(
    kind: str, problem: Problem, gauss: GaussPositions, history: History, attrs: Mapping[str, Any]
) -> xr.Dataset:
    """Arrange a history as the data set of a result that has states; see :func:`state_arrays`."""
    return state_arrays(kind, problem, gauss, history, attrs).data_set()


def state_arrays(
    kind: str,
    problem: Problem,
    gauss: GaussPositions,
    history: History,
    attrs: Mapping[str, Any],
    late: Callable[[], dict[str, Any]] | None = None,
) -> StateArrays:
    """Arrange a history as the arrays of a result that has states.

    Args:
        kind: "simulate", "equilibrium", "steady", "modes" or "buckling".
        problem: the solved one; gauss: positions of its Gauss points.
        history: recorded states.
        attrs: attributes of the whole data set (see ``schema``); late: what makes those about the mesh, if they are
            not known yet.
    """
    content = _content(kind, problem, gauss, history)
    known = LateAttributes({"kind": kind}) | attrs
    levels = DIMENSION[kind], np.array(history.instant)
    attributes = known if late is None else known | LateAttributes({}, Later(OF_MESH, late))
    return StateArrays(*content, levels, attributes, _sites(problem))


@dataclass
class ArraysBeside(StateArrays):
    """The arrays of a model that differs from that of a result in numbers only; their data set is made beside its.

    Attributes:
        result: returns the data set of the result, which is asked for where that of these arrays is.
    """

    result: Callable[[], xr.Dataset] = field(kw_only=True)

    def data_set(self) -> xr.Dataset:
        """Return the data set, of the same arrays."""
        given = {name: values for name, (_, values) in (self.arrays | self.coordinates).items()}
        return _beside(self.result(), given, self.attrs)


def arrays_beside(
    kind: str,
    result: Callable[[], xr.Dataset],
    problem: Problem,
    gauss: GaussPositions,
    history: History,
    attrs: Mapping[str, Any],
) -> ArraysBeside:
    """Arrange a history as arrays, of a model that differs in numbers only from that of a ``result``, in its states."""
    made = state_arrays(kind, problem, gauss, history, attrs)
    return ArraysBeside(
        made.arrays, made.coordinates, made.places, made.levels, made.attrs, made.sites, result=result
    )


def dataset_beside(
    result: xr.Dataset,
    problem: Problem,
    gauss: GaussPositions,
    history: History,
    attrs: dict[str, Any],
    more: Mapping[str, Floats | Callable[[], Floats]] | None = None,
) -> xr.Dataset:
    """Arrange a history of a model that differs from that of a ``result`` in numbers only, in the same states.

    Names, units and indexes are those of the result; to make them again takes three quarters of :func:`dataset`. What
    takes long to compute is computed when it is read.

    Args:
        more: other variables of the result, or what makes them.
    """
    kind = str(result.attrs["kind"])
    variables, coordinates, _ = _content(kind, problem, gauss, history)
    given = {name: values for name, (_, values) in (variables | coordinates).items()} | dict(more or {})
    return _beside(result, given, {"kind": kind, **attrs})


def _beside(result: xr.Dataset, given: Mapping[str, Any], attrs: Mapping[str, Any]) -> xr.Dataset:
    """Return the data set of a result with other numbers, by their names, and other attributes."""
    from viscorod.results.deferred_array import defer

    beside = [name for name in result.data_vars if name not in given]  # what the mesh makes wrong, for one
    found = result.drop_vars(beside) if beside else result.copy()
    for name, values in given.items():
        variable = found.variables[name]
        if callable(values):
            defer(variable, values)
        elif (numbers := np.asarray(values)).dtype.kind in "fi":
            variable.data = numbers
    found.attrs = dict(attrs)
    return found


def _content(
    kind: str, problem: Problem, gauss: GaussPositions, history: History
) -> tuple[dict[str, Any], dict[str, Any], dict[str, tuple[str, ...]]]:
    """Return variables, coordinates along stations, points and others, and dimensions whose places have names."""
    along = DIMENSION[kind]
    reader = station_reader(problem)
    r0, q0 = (array.copy() for array in _reference(problem))
    recorded, (energy, branch_loss) = history.states(), history.energies()
    r, q, twist = recorded.r, recorded.q, recorded.twist
    position, rotation, velocity, spin = reader.read(r, q, twist)
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
        variables |= _of_motion(problem, gauss, recorded, history, (energy, branch_loss))
    places = {name: LABELS[name] for name in ("axis", "quaternion", "component")}
    coordinates = _coordinates(problem, gauss, reader)
    if problem.supports.names:
        variables["reaction"] = ((along, "support", "motion"), recorded.reaction)
        places |= {"support": problem.supports.names, "motion": LABELS["motion"]}
    if problem.joints.count:
        places["connection"] = tuple(unique(problem.joints.names))
        coordinates |= connections(problem, reader)
        joints = _joints(along, problem, recorded.joints)
        variables, coordinates = variables | joints[0], coordinates | joints[1]
    return variables, coordinates, places


def _of_motion(
    problem: Problem,
    gauss: GaussPositions,
    recorded: Snapshots,
    history: History,
    energies: tuple[Floats, Floats],
) -> dict[str, Any]:
    """Return the variables that motions alone have: what is lost, the energy account, momenta."""
    along = DIMENSION["simulate"]
    variables: dict[str, Any] = {}
    energy, branch_loss = energies
    # few ask for these, and they take as long as the rest; what a user's law answers is asked for now
    momenta = cache(partial(_momenta, problem, recorded.r, recorded.q, recorded.twist))
    power = partial(_dissipation, problem, gauss, recorded)
    if problem.relaxing:
        variables["branch_loss"] = ((along, "branch"), branch_loss)
        if recorded.branch_strain is not None:
            where = (along, "point", "branch", "component")
            variables["branch_strain"] = (where, recorded.branch_strain)
    if problem.motion_loads:
        variables["outside"] = (along, energy[:, 5])
    if any(strain.changes for _, strain in problem.rest_strains):
        variables["actuator"] = (along, energy[:, 6])
    return variables | {
        "dissipation": ((along, "point"), power() if problem.laws.present else power),
        "viscous": (along, energy[:, 2]),
        "external": (along, energy[:, 3]),
        "numerical": (along, energy[:, 4]),
        "step_size": (along, np.array(history.step_size)),
        "linear_momentum": ((along, "axis"), lambda: momenta()[:, :3]),
        "angular_momentum": ((along, "axis"), lambda: momenta()[:, 3:]),
    }


def _dissipation(problem: Problem, gauss: GaussPositions, recorded: Snapshots) -> Floats:
    """Return the power that is lost per length at all Gauss points ``(instants, points)`` [W/m]."""
    rate = recorded.strain_rate
    power = np.einsum("kgi,gij,kgj->kg", rate, gauss.damping, rate)
    if problem.laws.present:
        sections = np.tile(gauss.section, (len(rate), 1))
        power += law_responses(problem.laws, sections, recorded.strain, rate)[..., POWER]
    if problem.relaxing:
        power += recorded.branch_power
    return np.asarray(power)


@once_of_layout
def _stations(problem: Problem) -> tuple[np.ndarray, Floats, Integers]:
    """Return of every station the rod or body, the arc length [m], and the order of its elements, 0 of bodies."""
    names, bodies, stations = np.array(problem.rods), problem.bodies.names, problem.stations
    still = np.zeros(len(bodies))
    order = np.append(problem.rod_orders[stations.rod], still.astype(np.int64))
    return np.array([*names[stations.rod], *bodies]), np.append(stations.s, still), order


@once_of_layout
def _reference(problem: Problem) -> tuple[Floats, Floats]:
    """Return positions [m] and orientations of all stations in the reference shape."""
    return station_reader(problem).poses(problem.positions, problem.quaternions)


@once_of_layout
def _sites(problem: Problem) -> ResultPlaces:
    return ResultPlaces.of(*_stations(problem))


def _coordinates(problem: Problem, gauss: GaussPositions, reader: StationReader) -> dict[str, Any]:
    """Return where stations and Gauss points are, and the relaxation times."""
    rods, s, order = (array.copy() for array in _stations(problem))
    coordinates: dict[str, Any] = {
        "station_rod": ("station", rods),
        "station_s": ("station", s),
        "station_order": ("station", order),
        "point_rod": ("point", np.array(problem.rods, dtype=str)[gauss.rod]),
        "point_s": ("point", gauss.s),
        "point_weight": ("point", gauss.length),
    }
    if problem.relaxing:
        coordinates["relaxation_time"] = ("branch", problem.relaxation_times)
    if problem.bodies.names:
        coordinates["station_body"] = ("station", bodies_of_stations(problem, reader))
    return coordinates


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


def _momenta(problem: Problem, r: Floats, q: Floats, twist: Floats) -> Floats:
    """Return total linear and angular momentum about the origin, global axes ``(instants, 6)``."""
    instants, nodes = twist.shape[:2]
    total = np.empty((instants, 6))
    some = max(1, min(instants, AT_ONCE // nodes))  # instants, whose nodes are those of one large model
    mass = np.tile(problem.mass, (some, 1, 1))
    nodal = np.empty((some * nodes, 6))
    for first in range(0, instants, some):
        part = slice(first, min(first + some, instants))
        count = (part.stop - first) * nodes
        poses = r[part].reshape(-1, 3), q[part].reshape(-1, 4)
        inertia.momenta(mass[:count], *poses, twist[part].reshape(-1, 6), nodal[:count])
        total[part] = nodal[:count].reshape(-1, nodes, 6).sum(axis=1)
    return total


def _continuous(q: np.ndarray) -> np.ndarray:
    """Flip quaternions so that each is nearest to the one before it in time: both signs mean one rotation."""
    if len(q) > 1:
        flips = np.sum(q[1:] * q[:-1], axis=-1) < 0.0
        q[1:][np.cumsum(flips, axis=0) % 2 == 1] *= -1.0
    return q
