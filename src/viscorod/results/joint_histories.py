"""Places of bodies, joints and springs in terms of stations, for pictures of results."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.mechanics.joints.joint_coordinates import AT_RHO_A, AT_RHO_B
from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.solve.history import StationReader
from viscorod.solve.problem.joint_set import GROUND
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.recorded_states import RecordedStates


def unique(names: Sequence[str]) -> list[str]:
    """Return the names with a number added from the second of the same on."""
    seen: Counter[str] = Counter()
    found = []
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return found


def bodies_of_stations(problem: Problem, reader: StationReader) -> np.ndarray:
    """Return the name of the body that each station is part of, or is rigidly attached to; empty for none."""
    bodies = problem.bodies
    of_points = [name.partition(".")[0] for name in bodies.names]
    names: dict[int, str] = {}
    for node, name in zip(bodies.nodes.tolist(), of_points, strict=True):
        names.setdefault(node, name)
    on_rods = reader.nodes[: len(reader.nodes) - len(of_points)]
    return np.array([*(names.get(node, "") for node in on_rods.tolist()), *of_points])


def connections(problem: Problem, reader: StationReader) -> dict[str, Any]:
    """Return the places of joints and springs: two stations each, and points in their axes."""
    joints = problem.joints
    geometry = joints.arrays.geometry
    count = len(joints.names)
    station = np.full((count, 2), -1, dtype=np.int64)
    arm = np.zeros((count, 2, 3))
    for k in range(count):
        c = int(np.argmax(joints.joint == k))
        for side, at in enumerate((AT_RHO_A, AT_RHO_B)):
            point = geometry[c, at : at + 3]
            station[k, side], arm[k, side] = _seat(reader, int(joints.arrays.nodes[c, side]), point)
    return {
        "connection_kind": ("connection", np.where(joints.row >= 0, "joint", "spring")),
        "connection_station": (("connection", "side"), station),
        "connection_arm": (("connection", "side", "axis"), arm),
    }


def _seat(reader: StationReader, node: int, point: Floats) -> tuple[int, Floats]:
    """Return the nearest station of a node and a point, given in the node's axes, in the axes of that station."""
    if node == GROUND:
        return GROUND, point
    offset, turn = reader.places
    mine = np.flatnonzero(reader.nodes == node)
    distance = np.linalg.norm(offset[mine] - point, axis=1)
    nearest = int(mine[np.argmin(distance)])
    return nearest, np.asarray(matrices(turn[nearest][None])[0].T @ (point - offset[nearest]))


def coordinates_of(result: RecordedStates, name: str) -> xr.Dataset:
    """Return the coordinates of a joint or spring, see ``Result.joint``."""
    import xarray as xr

    known = list(dict.fromkeys(result.data["joint"].values.tolist())) if "joint" in result.data else []
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1) or known
        hint = f"did you mean {near[0]!r}?" if near else "this result has no joints or springs"
        raise InputError(f"no joint or spring is called {name!r}; {hint}")
    mine = np.flatnonzero(result.data["joint"].values == name)
    words = result.data["joint_motion"].values[mine]
    units = {
        "value": ["m" if word.startswith("u") else "rad" for word in words],
        "rate": ["m/s" if word.startswith("u") else "rad/s" for word in words],
        "force": ["N" if word.startswith("u") else "N m" for word in words],
    }
    return xr.Dataset(
        {
            key: (
                (result.dimension, "motion"),
                result.data[f"joint_{key}"].values[:, mine],
                {"units": ", ".join(dict.fromkeys(unit)), "long_name": f"{key} of {name}"},
            )
            for key, unit in units.items()
        },
        {
            result.dimension: result.data[result.dimension],
            "motion": words,
            "held": ("motion", result.data["joint_held"].values[mine].astype(bool)),
        },
    )
