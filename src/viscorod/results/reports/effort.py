"""What a result cost, and what its mesh and its steps make wrong, in sentences."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from viscorod.results.data_schema import COUNTERS
from viscorod.results.step_error import step_errors
from viscorod.results.text_numbers import number, quantity

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["MOST_NAMES", "counted", "effort"]

MOST_NAMES = 4
"""Rods that are told one by one at most."""
LIMITING = 10.0
"""Times the tolerance of the steps beyond which an error of the mesh makes it worthless."""


def effort(result: Result) -> str:
    """Return steps and times, solver, estimated errors of mesh and steps."""
    attrs = result.stored.attrs
    parts = [counted(int(attrs[name]), words) for name, words in COUNTERS.items() if name in attrs]
    if "wall_time_s" in attrs:
        parts.append(f"{attrs['wall_time_s']:.3g} s wall time")
    if attrs.get("compile_time_s", 0.0) >= 0.1:
        parts.append(f"{attrs['compile_time_s']:.3g} s compiling before that")
    lines = [f"Effort: {', '.join(parts)}"] if parts else []
    if "linear_solver" in attrs:
        lines.append(f"Linear systems: {attrs['linear_solver']}")
    if result.mesh_errors:
        lines.append(_mesh(result))
    if step_errors(attrs):
        lines.append(_steps(attrs))
    elif not result.mesh_errors and result.dimension == "time" and attrs.get("outcome") == "completed":
        lines.append("Errors of steps and mesh were not estimated")
    if attrs.get("smallest_step_why"):
        lines.append(
            f"Smallest step: {quantity(attrs['smallest_step'], 's', 3)} at t = "
            f"{quantity(attrs['smallest_step_at'], 's')}, limited by {attrs['smallest_step_why']}"
        )
    if "modes" in attrs:
        lines.append(_modes(attrs))
    if "pose_gap" in attrs:
        lines.append(
            f"Poses integrated in time and along the rods differ by at most {quantity(attrs['pose_gap'], 'm', 3)} "
            f"and {quantity(attrs['rotation_gap'], 'rad', 3)}"
        )
    return "\n".join(lines)


def _modes(attrs: Mapping[str, Any]) -> str:
    """Say in which modes a motion was sought, and what fewer of them would have made of it."""
    rigid, count = int(attrs["modes_rigid"]), int(attrs["modes"])
    beside = int(attrs["modes_velocities"]) - rigid - count
    turning = f", {counted(rigid, 'rigid motions')}" if rigid else ""
    text = (
        f"Modes: {counted(count, 'vibrations')} up to {quantity(attrs['modes_highest'], 'Hz', 4)}"
        f"{turning} and {beside} quasi-static answers"
    )
    if "modes_fewer" not in attrs:
        return f"{text}; what fewer of them would make of it is not known"
    return (
        f"{text}; in {attrs['modes_fewer']} modes positions differ by up to "
        f"{quantity(attrs['modes_position_gap'], 'm', 2)}, "
        f"{attrs['modes_motion_gap']:.2g} of the largest displacement, rotations by "
        f"{quantity(attrs['modes_rotation_gap'], 'rad', 2)}, and section forces by {attrs['modes_force_gap']:.2g} of "
        "the largest"
    )


def _mesh(result: Result) -> str:
    """Say how the rods are divided and what that makes wrong."""
    data = result.stored
    rods, orders = (data[f"station_{name}"].values.tolist() for name in ("rod", "order"))
    order = dict(zip(rods, orders, strict=True))
    meshes = [
        f"{rod!r} {counted((rods.count(rod) - 1) // int(order[rod]), 'elements')} of order {int(order[rod])}"
        for rod in list(result.mesh_errors)[:MOST_NAMES]
    ]
    more = len(result.mesh_errors) - len(meshes)
    errors = [f"positions by {number(max(result.mesh_errors.values()), 1)} of the length of a rod"]
    for name, what in (
        ("motion", "{} of the largest displacement"),
        ("force", "section forces by {} of the largest"),
    ):
        if f"mesh_{name}_error" in data.attrs:
            errors.append(what.format(number(data.attrs[f"mesh_{name}_error"], 1)))
    if data.attrs.get("mesh_jumps"):
        errors.append(
            "beside the element that a travelling force is in, over which the jump of forces is spread"
        )
    text = f"Mesh: {', '.join(meshes)}{f' and {more} more rods' if more else ''}; estimated errors: {', '.join(errors)}"
    if max(result.mesh_errors.values()) > LIMITING * float(data.attrs.get("tolerance", math.inf)):
        text += (
            f"; they are more than the tolerance of the steps, {number(data.attrs['tolerance'], 1)}: without a finer "
            "mesh (accuracy, or elements) steps as small gain nothing"
        )
    return text


def _steps(attrs: Mapping[str, Any]) -> str:
    """Say what the steps make wrong."""
    found = step_errors(attrs)
    return (
        f"Steps: estimated errors: positions by {quantity(found['position'], 'm', 1)}, rotations by "
        f"{quantity(found['rotation'], 'rad', 1)}, {number(attrs['step_motion_error'], 1)} of the motion, "
        f"section forces by {number(attrs['step_force_error'], 1)} of the largest"
    )


def counted(count: int, name: str) -> str:
    """Return a number of things, "1 step" or "3 steps"."""
    if count == 1:
        name = name.replace("evaluations", "evaluation") if "evaluations" in name else name.removesuffix("s")
    return f"{count} {name}"
