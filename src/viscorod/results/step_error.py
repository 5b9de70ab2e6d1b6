"""The error of the steps as a result tells it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from viscorod.results.text_numbers import number, quantity

__all__ = ["KINDS", "force_doubt", "motion_doubt", "step_errors"]

KINDS = {"position": "m", "rotation": "rad", "section_force": "N", "section_moment": "N m"}
"""What is estimated, and its unit."""

MOTION = 0.01  # accepted error of displacements or rotations, as a part of the largest
FORCE = 0.5  # accepted error of section forces or moments, as a part of the largest: a sudden release makes a third


def step_errors(attrs: Mapping[str, Any]) -> dict[str, float]:
    """Return the estimated errors of a motion by its steps (``solve.transient.step_errors``).

    They are what single steps err by, added up over the run: the largest at any node and any time. Where a motion may
    make them grow, as tumbling bodies, linked pendulums and arches that snap do, positions and rotations are those by
    which a second run with smaller steps differs (``analyses.second_run``). Section forces are those of small
    vibrations about the start; axial forces that come of turning, in whirling shafts, may be off by ten times as much.

    Args:
        attrs: attributes of the result.

    Returns:
        "position" [m], "rotation" [rad], "section_force" [N] and "section_moment" [N m]; empty if not estimated.
    """
    found = {kind: attrs.get(f"step_{kind}_error") for kind in KINDS}
    return {kind: float(error) for kind, error in found.items() if error is not None}


def motion_doubt(attrs: Mapping[str, Any]) -> str:
    """Return a warning if positions or rotations may be off by more than 1 % of the motion, else nothing."""
    if float(attrs.get("step_motion_error", 0.0)) <= MOTION:
        return ""
    return (
        f"the steps may leave positions off by {quantity(attrs['step_position_error'], 'm', 2)} and rotations by "
        f"{quantity(attrs['step_rotation_error'], 'rad', 2)}, {number(100.0 * attrs['step_motion_error'], 2)} % of the "
        "motion; "
        f"use {_smaller(attrs)}"
    )


def force_doubt(attrs: Mapping[str, Any]) -> str:
    """Return a warning if section forces or moments may be off by more than half of the largest, else nothing.

    Forces that are small beside the moments over the length count as a hundredth of these, and the other way round.
    """
    error = float(attrs.get("step_force_error", 0.0))
    if error <= FORCE:
        return ""
    return (
        f"the steps may leave section forces off by {number(100.0 * error, 2)} % of the largest at single instants, "
        "where fast vibrations that little damps carry them; means over some of their periods are hardly wrong. Use "
        f"{_smaller(attrs)}, or damping: without it such vibrations, as a sudden load sets them off, depend on the "
        "mesh too"
    )


def _smaller(attrs: Mapping[str, Any]) -> str:
    setting = "tolerance" if "tolerance" in attrs else "time_step"
    used = f" than {attrs[setting]:.2g}" if setting in attrs else ""
    return f"a smaller {setting}{used}"
