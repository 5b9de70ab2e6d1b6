"""The data set that results are built from: names, units and what must be there.

Everything a result says is derived from one ``xarray.Dataset`` with these variables, so a file read back does
all that a fresh run does. States are stored along ``time`` (kind "simulate"), ``load_factor`` (kind "equilibrium") or
``spin`` (kind "steady", one state); modes and critical loads have the one state that they are about along
``load_factor``.

Stations are the nodes of the rods, by increasing arc length rod by rod, and after them the mass centres of rigid
bodies, each followed by the body's named points: ``station_rod`` is the name of the body, or "plate.corner", with
``station_order`` 0. A joint or spring has a ``joint_coordinate`` for each motion that it holds, drives, springs
or measures. Where a rod holds a strain, ``section_force`` is the reaction that holds it, and no energy is stored
or lost there. Springs of joints are part of the elastic energy, their dampers of what is lost to viscosity,
motors of the work from outside. Runs with joints or held strains have the attributes ``drift_position`` and
``drift_velocity``: the largest gap that was found between what these hold and the motion, over the size of the
model (or in rad, or strain), and that of velocities over the fastest one, before it was removed. The attributes
``damping_assumptions`` and ``damping_laws`` (JSON by rod) state what was assumed of the damping and what it was
computed with (``viscorod.analyses.provenance``). Strains are measured from the reference shape and the rest strains.
``found_by`` says how an equilibrium was found, ``stage_ends`` (JSON) are the states at the ends of its stages,
``began_from`` is what a motion started from.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from viscorod.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

AXES = ("x", "y", "z")
"""Global axes, in the order of every ``axis`` dimension."""

DIMENSION = {
    "simulate": "time",
    "equilibrium": "load_factor",
    "steady": "spin",
    "modes": "load_factor",
    "buckling": "load_factor",
}
"""Kind of result -> the dimension along which its states are stored."""

VARIABLES: dict[str, tuple[str, str]] = {
    "time": ("s", "time"),
    "load_factor": ("1", "part of the loads applied"),
    "spin": ("rad/s", "angular speed"),
    "station_rod": ("", "rod of the station, or body or named point of a body"),
    "station_s": ("m", "arc length of the station in the reference shape, 0 on bodies"),
    "station_order": ("1", "order of the elements of the station's rod, 0 on bodies"),
    "station_body": ("", "body that the station belongs to or is rigidly attached to, empty for none"),
    "point_rod": ("", "rod of the Gauss point"),
    "point_s": ("m", "arc length of the Gauss point in the reference shape"),
    "point_weight": ("m", "quadrature length of the Gauss point"),
    "reference_position": ("m", "position in the reference shape"),
    "reference_rotation": ("1", "orientation in the reference shape, quaternion from body to global axes"),
    "position": ("m", "position"),
    "rotation": ("1", "orientation, quaternion from body to global axes"),
    "velocity": ("m/s", "velocity, global axes"),
    "angular_velocity": ("rad/s", "angular velocity, body axes"),
    "strain": ("1, 1, 1, 1/m, 1/m, 1/m", "strain: shear 1, shear 2, stretch, bend 1, bend 2, twist"),
    "section_force": (
        "N, N m",
        "force and moment of the section, elastic and viscous, reactions of held strains, body axes",
    ),
    "half_width": ("m", "largest distance of the section's outline from the centre line, 0 if unknown"),
    "dissipation": ("W/m", "power lost to viscosity per length"),
    "relaxation_time": ("s", "relaxation time of a Maxwell branch"),
    "branch_loss": ("J", "energy lost by the Maxwell branch so far, part of viscous"),
    "branch_strain": ("1, 1, 1, 1/m, 1/m, 1/m", "strain of the spring of a Maxwell branch"),
    "kinetic": ("J", "kinetic energy"),
    "elastic": ("J", "elastic energy of rods, their Maxwell branches and springs"),
    "viscous": ("J", "energy lost to viscosity, Maxwell branches and dampers so far"),
    "outside": ("J", "energy lost outside of the rods, to drag, so far"),
    "external": ("J", "work of loads, moving supports and motors so far"),
    "actuator": ("J", "work of what changes rest strains so far"),
    "numerical": ("J", "numerical remainder of the energy account"),
    "reaction": ("N, N m", "force and moment of the support on the rod, global axes"),
    "joint": ("", "joint or spring of the coordinate"),
    "joint_motion": ("", "motion word of the coordinate, of a relative to b along the joint's axes"),
    "joint_held": ("", "whether the joint or a motor holds the coordinate"),
    "joint_value": (
        "m, rad",
        "coordinate of a joint or spring, from the reference shape; of a line its length",
    ),
    "joint_rate": ("m/s, rad/s", "rate of the coordinate"),
    "joint_force": (
        "N, N m",
        "force or moment of the joint or spring on its first place, along the coordinate",
    ),
    "connection": ("", "joint or spring"),
    "connection_kind": ("", "joint or spring"),
    "connection_station": ("1", "stations that it connects, the carrier of its axes first, -1 the ground"),
    "connection_arm": ("m", "where it sits, in the axes of each station; global at the ground"),
    "step_size": ("s", "step that ended here"),
    "linear_momentum": ("N s", "linear momentum of all rods and bodies, global axes"),
    "angular_momentum": ("N m s", "angular momentum of all rods and bodies about the origin, global axes"),
    "spin_vector": ("rad/s", "angular velocity, global axes"),
    "joint_spin": ("rad/s", "angular velocity in the axes of the node at the joint, or of the first one"),
    "centre": ("m", "point on the axis of rotation"),
    "momentum": ("N m s", "angular momentum about the centre, global axes"),
    "eigenvalue": (
        "1/s",
        "real and imaginary part of s, small motions exp(s t) about the state; natural frequency |s|/2 pi, "
        "of the oscillation |Im s|/2 pi",
    ),
    "mode_shape": ("1", "displacement in a small motion, largest component 1, real and imaginary part"),
    "mode_rotation": ("rad/m", "rotation in it, body axes, per displacement of 1 m"),
    "mode_name": ("", "what most of the strain energy of a small motion is in, and its number among these"),
    "mode_share": ("1", "part of the strain energy of a small motion in every strain"),
    "mode_residual": ("1", "what a small motion leaves of its equations, as a part of what adds up to them"),
    "mode_error": ("1", "estimated error of the frequency by the mesh, as a part of it"),
    "critical_load": ("1", "critical multiple of the loads that grow"),
    "critical_limit": ("", "whether the load has an extreme there; elsewhere equilibria branch off"),
    "critical_shape": ("1", "displacement in the direction without stiffness, largest component 1"),
    "critical_rotation": ("rad/m", "rotation in it, body axes, per displacement of 1 m"),
    "critical_position": ("m", "position in the critical state"),
    "critical_error": ("1", "estimated error of the critical load by the mesh, as a part of it"),
    "linear_load": ("1", "critical multiple of the linear problem"),
    "negative_eigenvalues": (
        "1",
        "number of negative eigenvalues of the tangent stiffness, or of growing motions if it is not symmetric",
    ),
    "iterations": ("1", "Newton iterations of the step that ended here"),
}
"""Name -> (unit, long name), written into the attributes of every data set."""

STATES = "states"
"""Stands for the dimension of the states in ``DIMENSIONS``: time, load_factor or spin (see ``DIMENSION``)."""

DIMENSIONS: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    "load_factor": ("load_factor",),
    "spin": ("spin",),
    **dict.fromkeys(("station_rod", "station_s", "station_order", "station_body"), ("station",)),
    **dict.fromkeys(("point_rod", "point_s", "point_weight", "half_width"), ("point",)),
    "reference_position": ("station", "axis"),
    "reference_rotation": ("station", "quaternion"),
    **dict.fromkeys(("position", "velocity", "angular_velocity"), (STATES, "station", "axis")),
    "rotation": (STATES, "station", "quaternion"),
    **dict.fromkeys(("strain", "section_force"), (STATES, "point", "component")),
    "dissipation": (STATES, "point"),
    "relaxation_time": ("branch",),
    "branch_loss": (STATES, "branch"),
    "branch_strain": (STATES, "point", "branch", "component"),
    **dict.fromkeys(
        ("kinetic", "elastic", "viscous", "outside", "external", "actuator", "numerical"), (STATES,)
    ),
    "reaction": (STATES, "support", "motion"),
    **dict.fromkeys(("joint", "joint_motion", "joint_held"), ("joint_coordinate",)),
    **dict.fromkeys(("joint_value", "joint_rate", "joint_force"), (STATES, "joint_coordinate")),
    **dict.fromkeys(("connection", "connection_kind"), ("connection",)),
    "connection_station": ("connection", "side"),
    "connection_arm": ("connection", "side", "axis"),
    **dict.fromkeys(("step_size", "iterations", "negative_eigenvalues"), (STATES,)),
    **dict.fromkeys(("linear_momentum", "angular_momentum"), (STATES, "axis")),
    **dict.fromkeys(("spin_vector", "joint_spin", "centre", "momentum"), ("axis",)),
    "eigenvalue": ("small_motion", "part"),
    **dict.fromkeys(("mode_shape", "mode_rotation"), ("small_motion", "part", "station", "axis")),
    **dict.fromkeys(("mode_name", "mode_residual", "mode_error"), ("small_motion",)),
    "mode_share": ("small_motion", "component"),
    **dict.fromkeys(("critical_load", "critical_limit", "critical_error"), ("critical",)),
    **dict.fromkeys(
        ("critical_shape", "critical_rotation", "critical_position"), ("critical", "station", "axis")
    ),
    "linear_load": ("linear",),
}
"""Name -> dimensions of every variable."""

TEXTS = {
    "station_rod",
    "station_body",
    "point_rod",
    "joint",
    "joint_motion",
    "connection",
    "connection_kind",
    "mode_name",
}
"""Variables whose values are texts."""
INTEGERS = {"station_order", "connection_station", "negative_eigenvalues", "iterations"}
"""Variables whose values are whole numbers."""
FLAGS = {"joint_held", "critical_limit"}
"""Variables whose values are true or false; all others are real numbers."""

LABELS = {
    "axis": AXES,
    "quaternion": tuple("wxyz"),
    "component": ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"),
    "motion": ("fx", "fy", "fz", "mx", "my", "mz"),
    "part": ("real", "imaginary"),
}
"""Dimension -> the words for its places."""

FRAMES = {
    **dict.fromkeys(
        (
            "reference_position",
            "position",
            "velocity",
            "reaction",
            "linear_momentum",
            "angular_momentum",
            "spin_vector",
            "centre",
            "momentum",
            "mode_shape",
            "critical_shape",
            "critical_position",
        ),
        "global",
    ),
    **dict.fromkeys(("reference_rotation", "rotation"), "body to global"),
    **dict.fromkeys(
        (
            "angular_velocity",
            "strain",
            "branch_strain",
            "section_force",
            "joint_spin",
            "mode_rotation",
            "mode_share",
            "critical_rotation",
        ),
        "body (d1, d2, d3)",
    ),
    **dict.fromkeys(("joint_value", "joint_rate", "joint_force"), "of the joint"),
    "connection_arm": "of the station",
}
"""Name -> axes in which the components of a vector are."""

PLACES = {
    "station": "nodes of the elements, rod by rod by increasing arc length, then bodies and their points",
    "point": "Gauss points of the elements, rod by rod by increasing arc length",
    "axis": "x, y, z: components in the axes that the variable names (body axes: d1, d2, d3)",
    "quaternion": "w, x, y, z",
    "component": "shear_1, shear_2, stretch, bend_1, bend_2, twist: along and about d1, d2, d3",
    "support": "supports, by name",
    "motion": "fx, fy, fz, mx, my, mz",
    "branch": "Maxwell branches, by relaxation time",
    "joint_coordinate": "motions of joints and springs",
    "connection": "joints and springs",
    "side": "the two places of a connection",
    "small_motion": "eigenvalues and their shapes, slowest first",
    "part": "real and imaginary",
    "critical": "critical loads, in the order in which the equilibria pass them",
    "linear": "critical loads of the linear problem, the nearest first",
}
"""Dimension -> what its places are."""

COUNTERS = {
    "steps": "steps",
    "rejected": "rejected steps",
    "iterations": "iterations",
    "evaluations": "evaluations of the forces",
    "jacobians": "Jacobians",
    "factorisations": "factorisations",
}
"""Integer attributes, what the solution took, and what they count."""

_ALWAYS = (
    "station_rod",
    "station_s",
    "station_order",
    "reference_position",
    "reference_rotation",
    "position",
    "rotation",
    "elastic",
)
REQUIRED = {
    "simulate": (*_ALWAYS, "velocity", "kinetic", "viscous", "external", "numerical"),
    "equilibrium": _ALWAYS,
    "modes": (
        *_ALWAYS,
        *("eigenvalue", "mode_shape", "mode_rotation", "mode_name", "mode_share", "mode_residual"),
    ),
    "buckling": (
        *_ALWAYS,
        *("critical_load", "critical_limit", "critical_shape", "critical_rotation", "critical_position"),
        "linear_load",
    ),
    "steady": (
        *_ALWAYS,
        *("velocity", "kinetic", "spin_vector", "joint_spin", "centre", "momentum", "eigenvalue"),
    ),
}
"""Kind of result -> variables that it has in any case, beside the levels of its states."""


def annotated(data: xr.Dataset, kind: str, *, own: bool = False) -> xr.Dataset:
    """Return ``data`` with units and long names, after checking that it is a result of this kind.

    Args:
        data: the data set; it is not changed, unless it is the caller's own, of whom nobody else has it.
        kind: "simulate", "equilibrium", "steady", "modes" or "buckling".
        own: whether it is.

    Raises:
        InputError: the data set is of another kind, or variables are missing.
    """
    found = data.attrs.get("kind")
    if not isinstance(found, str) or found != kind:
        raise InputError(
            f"this data set has kind = {found!r} where {kind!r} is needed; viscorod.load opens any kind"
        )
    missing = [name for name in (DIMENSION[kind], *REQUIRED[kind]) if name not in data.variables]
    if missing:
        raise InputError(
            f"this data set is not a complete viscorod result: {', '.join(missing)} missing; "
            "use a file that viscorod wrote"
        )
    result = data if own else data.copy()
    for name, variable in result.variables.items():
        unit, long_name = VARIABLES.get(str(name), ("", ""))
        attributes = variable.attrs
        if unit:
            attributes.setdefault("units", unit)
        if long_name:
            attributes.setdefault("long_name", long_name)
    return result
