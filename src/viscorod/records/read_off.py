"""What a motion says that an instrument at a place along a direction would have measured."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.records.any_record import finite
from viscorod.results.probe import fields_at, instants_of
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.records.motion_record import Record

__all__ = [
    "AXES",
    "BODY_AXES",
    "COMPONENTS",
    "QUANTITIES",
    "WITHOUT_LEVER",
    "Direction",
    "Quantity",
    "direction_text",
    "motion_along",
    "strain_along",
    "turned_from_reference",
]

Direction: TypeAlias = str | Sequence[float] | Floats
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
BODY_AXES = ("d1", "d2", "d3")
COMPONENTS = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")
"""Strain components, in the order of every result."""


def _along(where: str, given: Direction) -> Floats | str:
    """Return a unit vector in global axes."""
    if isinstance(given, str) and given.lstrip("+-") in AXES:
        return np.array(AXES[given.lstrip("+-")]) * (-1.0 if given.startswith("-") else 1.0)
    if isinstance(given, str):
        raise InputError(
            Fault(where, repr(given), "no direction", "give 'x', 'y', 'z', '-x', or three numbers")
        )
    vector = finite(where, given)
    size = float(np.linalg.norm(vector))
    if vector.shape != (3,) or size == 0.0:
        raise InputError(Fault(where, repr(given), "no direction", "give three numbers, not all zero"))
    found: Floats = vector / size
    return found


def direction_text(direction: Floats | str) -> str:
    """Return a direction in words: "x", "-y", "bend_2", or three numbers."""
    if isinstance(direction, str):
        return direction
    for name, axis in AXES.items():
        for sign, mark in ((1.0, ""), (-1.0, "-")):
            if np.allclose(direction, sign * np.array(axis), atol=1e-9):
                return mark + name
    return "along (" + ", ".join(f"{one:.3g}" for one in direction) + ")"


def _along_or_body(where: str, given: Direction) -> Floats | str:
    return given if isinstance(given, str) and given in BODY_AXES else _along(where, given)


def _component(where: str, given: Direction) -> Floats | str:
    if isinstance(given, str) and (given in COMPONENTS or given == "axial"):
        return given
    raise InputError(
        Fault(
            where,
            repr(given),
            "no component of strain",
            f"use one of {', '.join(COMPONENTS)}, or axial at a lever",
        )
    )


@dataclass(frozen=True)
class Quantity:
    """What can be recorded: how its direction is read, and its SI units by direction."""

    direction: Callable[[str, Direction], Floats | str]
    units: tuple[str, str]

    def unit(self, direction: Floats | str) -> str:
        """Return the SI unit; curvatures have another than the other strains."""
        curved = isinstance(direction, str) and direction in COMPONENTS[3:]
        return self.units[1] if curved else self.units[0]


QUANTITIES = {
    "position": Quantity(_along, ("m", "m")),
    "displacement": Quantity(_along, ("m", "m")),
    "velocity": Quantity(_along_or_body, ("m/s", "m/s")),
    "acceleration": Quantity(_along_or_body, ("m/s^2", "m/s^2")),
    "strain": Quantity(_component, ("1", "1/m")),
    "force": Quantity(_along_or_body, ("N", "N")),
    "rotation": Quantity(_along, ("rad", "rad")),
    "angular_velocity": Quantity(_along_or_body, ("rad/s", "rad/s")),
    "moment": Quantity(_along_or_body, ("N m", "N m")),
}
"""The quantities of histories."""
WITHOUT_LEVER = ("force", "rotation", "angular_velocity", "moment")
"""Quantities that all points of a section have alike."""


def motion_along(result: Any, record: Record, times: Floats, lever: Floats, turn: Floats) -> Floats:
    """Return a quantity of a run along the direction of a record (n,).

    Args:
        result: a `Run`.
        record: its place, quantity and direction.
        times: of the run, s (n,); before its start it is taken as waiting there.
        lever: from the place along d1, d2, d3, m (3,).
        turn: rotation vector by which the direction is turned in global axes, rad (3,).

    Raises:
        InputError: the run ends before the record.
    """
    known = np.asarray(result.time, dtype=float)
    slack = 1e-9 * (known[-1] - known[0])
    if times[-1] > known[-1] + slack:
        raise InputError(
            f"record {record.name}: its last sample is at {times[-1]:.6g} s of the motion, and the run ends at "
            f"{known[-1]:.6g} s; simulate longer, or cut a window"
        )
    waiting = times < known[0]
    inside = np.clip(times, known[0], known[-1])
    of_body = isinstance(record.direction, str)
    turning = of_body or bool(lever.any()) or record.quantity not in ("position", "displacement")
    found = _probed(result, record, np.concatenate([[known[0]], inside]), turning=turning)
    if record.quantity == "strain":
        return strain_along(found, record.direction, lever)[1:]
    frame: Any = found.get("frame")
    vector = _VECTORS[record.quantity](result, record.place, found, lever, frame)[1:]
    if record.quantity in ("velocity", "acceleration", "angular_velocity"):
        vector[waiting] = 0.0
    if of_body:
        axis = frame[1:, :, BODY_AXES.index(record.direction)]
    else:
        axis = np.broadcast_to(record.direction, vector.shape)
    if turn.any():
        from scipy.spatial.transform import Rotation

        axis = axis @ Rotation.from_rotvec(turn).as_matrix().T
    along: Floats = np.einsum("ti,ti->t", vector, axis)
    return along


_OF_RODS = {"strain": ("strain",), "force": ("section_force",), "moment": ("section_force",)}
"""Fields of rods that quantities need; the others take longer than the rest."""


def _probed(result: Any, record: Record, times: Floats, *, turning: bool) -> dict[str, Floats]:
    """Return the fields of a run at the place of a record (n, ...) each, those that it needs."""
    of_rods = _OF_RODS.get(record.quantity, ())
    place, instants = result.sites.at(record.place), instants_of(result, times)
    fields = fields_at(result, [place], instants, of_rods, turning=turning)
    return {"time": times, **{name: field[:, 0] for name, field in fields.items()}}


def strain_along(found: Any, direction: Floats | str, lever: Floats) -> Floats:
    """Return a component of strain, or the axial strain at a point of the section, of a place that was probed."""
    if "strain" not in found:
        raise InputError("a place on a body has no strains; give a place on a rod")
    strain = np.asarray(found["strain"], dtype=float)
    if direction == "axial":
        along: Floats = strain[:, 2] + strain[:, 3] * lever[1] - strain[:, 4] * lever[0]
        return along
    assert isinstance(direction, str)
    component: Floats = strain[:, COMPONENTS.index(direction)]
    return component


def _position(_result: Any, _place: str, found: Any, lever: Floats, frame: Any) -> Floats:
    at: Floats = found["position"] + frame @ lever if lever.any() else found["position"]
    return at


def _displacement(result: Any, place: str, found: Any, lever: Floats, frame: Floats) -> Floats:
    moved = np.asarray(found["displacement"], dtype=float)
    if not lever.any():
        return moved
    by_turning: Floats = moved + (frame - _reference_frame(result, place)) @ lever
    return by_turning


def _reference_frame(result: Any, place: str) -> Floats:
    """Return the frame of a place in the reference shape (3, 3)."""
    from viscorod.mechanics.rotations.quaternion import matrices

    site = result.sites.at(place)
    found: Floats = matrices(site.rotation(np.asarray(result.data["reference_rotation"].values))[None])[0]
    return found


def _rotation(result: Any, place: str, _found: Any, _lever: Floats, frame: Floats) -> Floats:
    return turned_from_reference(result, place, frame)


def turned_from_reference(result: Any, place: str, frame: Floats) -> Floats:
    """Return rotation vectors of frames (n, 3, 3) of a place from the reference shape, half a turn at most (n, 3)."""
    from scipy.spatial.transform import Rotation

    turned: Floats = Rotation.from_matrix(frame @ _reference_frame(result, place).T).as_rotvec()
    return turned


def _angular_velocity(_result: Any, _place: str, found: Any, _lever: Floats, frame: Floats) -> Floats:
    turned: Floats = np.einsum("tij,tj->ti", frame, found["angular_velocity"])
    return turned


def _velocity(_result: Any, _place: str, found: Any, lever: Floats, frame: Floats) -> Floats:
    velocity = np.asarray(found["velocity"], dtype=float)
    if not lever.any():
        return velocity
    by_turning: Floats = velocity + np.einsum("tij,tj->ti", frame, np.cross(found["angular_velocity"], lever))
    return by_turning


def _acceleration(result: Any, place: str, found: Any, lever: Floats, _frame: Floats) -> Floats:
    """Return the slope of the cubic spline through the stored velocities (errors of order 3 in the time between)."""
    from scipy.interpolate import CubicSpline

    stored = {
        name: field[:, 0] for name, field in fields_at(result, [result.sites.at(place)], None, ()).items()
    }
    velocity = _velocity(result, place, stored, lever, stored["frame"])
    slope: Floats = CubicSpline(result.time, velocity, axis=0)(found["time"], 1)
    return slope


def _force(_result: Any, _place: str, found: Any, _lever: Floats, frame: Floats) -> Floats:
    return _of_section(found, frame, slice(3))


def _moment(_result: Any, _place: str, found: Any, _lever: Floats, frame: Floats) -> Floats:
    return _of_section(found, frame, slice(3, 6))


def _of_section(found: Any, frame: Floats, which: slice) -> Floats:
    """Return components of section forces in global axes (n, 3)."""
    if "section_force" not in found:
        raise InputError("a place on a body has no section forces; give a place on a rod")
    turned: Floats = np.einsum("tij,tj->ti", frame, found["section_force"][:, which])
    return turned


_VECTORS: dict[str, Callable[[Any, str, Any, Floats, Floats], Floats]] = {
    "position": _position,
    "displacement": _displacement,
    "velocity": _velocity,
    "acceleration": _acceleration,
    "force": _force,
    "rotation": _rotation,
    "angular_velocity": _angular_velocity,
    "moment": _moment,
}
