"""Attributes of a result: which there are, what each holds, and what goes together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, Json, ValidationError

__all__ = ["faults_of_attributes"]

Count = Annotated[int, Field(ge=0)]
Amount = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Numbers = Json[list[Count]]


class Series(BaseModel):
    """What a Kelvin-Voigt material stands for: moduli [Pa], viscosity [Pa s], the Prony series."""

    modulus: Positive
    viscosity: Amount
    equilibrium: Amount
    moduli: Annotated[list[Amount], Field(min_length=1)]
    times: Annotated[list[Positive], Field(min_length=1)]


class Law(BaseModel):
    """Damping of a rod, see ``viscorod.analyses.provenance``."""

    times: Annotated[list[Amount | None], Field(min_length=6, max_length=6)]
    maxwell: bool
    extension: Series | None = None
    shear: Series | None = None
    loss_band: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = None


class HeatCapacity(BaseModel):
    """Heat capacity per length of a rod, J/(m K), over its arc length, m."""

    s: Annotated[list[Amount], Field(min_length=1)]
    capacity: Annotated[list[Positive], Field(min_length=1)]


class Event(BaseModel):
    """An event of a motion: time [s] and label."""

    time: FiniteFloat
    event: str


class ResultAttributes(BaseModel):
    """Attributes that viscorod writes and reads; all may be missing but those that a kind of result needs."""

    model_config = ConfigDict(extra="allow")

    kind: Literal["simulate", "equilibrium", "steady", "modes", "buckling"]
    title: str = ""
    outcome: str = "completed"
    message: str = ""
    case: Json[dict[str, Any]] | None = None
    settings: Json[dict[str, Any]] | None = None
    divisions: Json[dict[str, Any]] | None = None
    sections: Json[dict[str, Any]] | None = None
    case_text: str = ""
    case_file: str = ""
    case_changes: Json[dict[str, Any]] | None = None
    case_hash: str = ""
    version: str = ""
    platform: str = ""
    warnings: Json[list[str]] | None = None
    doubts: Json[list[str]] | None = None
    began_from: str = ""
    found_by: str = ""
    linear_solver: str = ""
    events: Json[list[Event]] | None = None
    ended_by: str = ""
    damping_assumptions: Json[dict[str, list[str]]] | None = None
    damping_laws: Json[dict[str, Law]] | None = None
    heat_capacities: Json[dict[str, HeatCapacity]] | None = None
    mesh_errors: Json[dict[str, Amount]] | None = None
    mesh_motion_error: Amount = 0.0
    mesh_force_error: Amount = 0.0
    mesh_jumps: Count = 0
    mesh_lost: Count = 0
    steps: Count = 0
    rejected: Count = 0
    iterations: Count = 0
    evaluations: Count = 0
    jacobians: Count = 0
    factorisations: Count = 0
    wall_time_s: Amount = 0.0
    compile_time_s: Amount = 0.0
    loop_time_s: Amount = 0.0
    scale_length: Positive = 1.0
    energy_scale: Amount = 0.0
    integrator: str = ""
    formulation: Literal["geometric", "intrinsic"] = "geometric"
    dynamics: Literal["nonlinear", "linear"] | None = None
    damping: Literal["full", "linearised"] | None = None
    time_step: Positive | None = None
    tolerance: Positive | None = None
    part_of_motion: Positive | None = None
    smallest_step: Amount | None = None
    smallest_step_at: Amount | None = None
    smallest_step_why: str = ""
    drift_position: Amount | None = None
    drift_velocity: Amount | None = None
    pose_gap: Amount | None = None
    rotation_gap: Amount | None = None
    modes: Count | None = None
    modes_velocities: Count | None = None
    modes_strains: Count | None = None
    modes_rigid: Count | None = None
    modes_highest: Amount | None = None
    modes_open: Amount | None = None
    modes_fewer: Count | None = None
    modes_position_gap: Amount | None = None
    modes_rotation_gap: Amount | None = None
    modes_motion_gap: Amount | None = None
    modes_force_gap: Amount | None = None
    stage_ends: Json[list[Count]] | None = None
    limit_points: Numbers | None = None
    bifurcations: Numbers | None = None
    flutter_points: Numbers | None = None
    multiplicity: Numbers | None = None
    negative_eigenvalues: Count | None = None
    flutter: Count | None = None
    stability: str = "tangent stiffness"
    residual: Amount | None = None
    unstable: Count | None = None
    neutral: Count | None = None
    growth_rate: FiniteFloat | None = None
    mode_rigid: Count | None = None
    mode_certified: Literal[0, 1] | None = None
    mode_about: str = ""
    buckling_exact: Literal[0, 1] | None = None
    buckling_complete: Literal[0, 1] | None = None
    buckling_reached: float | None = None


_TOGETHER = {
    "drift_position": ("drift_velocity",),
    "pose_gap": ("rotation_gap",),
    "smallest_step_why": ("smallest_step", "smallest_step_at"),
    "mesh_motion_error": ("mesh_errors",),
    "modes": ("modes_velocities", "modes_strains", "modes_rigid", "modes_highest", "modes_open"),
    "modes_fewer": ("modes_position_gap", "modes_rotation_gap", "modes_motion_gap", "modes_force_gap"),
}
"""Attribute -> others without which it says nothing."""
_STEADY = ("formulation", "damping", "residual", "unstable", "neutral", "growth_rate")


def faults_of_attributes(attrs: Mapping[Any, Any], states: int) -> Iterator[str]:
    """Yield what is wrong with the attributes of a result that has so many states."""
    plain = {str(name): _plain(value) for name, value in attrs.items()}
    try:
        found = ResultAttributes.model_validate(plain)
    except ValidationError as error:
        for fault in error.errors(include_url=False):
            path = ".".join(str(part) for part in fault["loc"])
            value = _shown(plain.get(str(fault["loc"][0])))
            yield f"the attribute {path} is {value}: {fault['msg'][0].lower()}{fault['msg'][1:]}"
        return
    yield from _missing(found, plain)
    for name in ("stage_ends", "limit_points", "bifurcations", "flutter_points"):
        numbers = getattr(found, name) or []
        if any(number >= states for number in numbers):
            yield f"the attribute {name} names state {max(numbers)} of {states}"
    for name, law in (found.damping_laws or {}).items():
        for series in (law.extension, law.shear):
            if series is not None and len(series.moduli) != len(series.times):
                count = f"{len(series.moduli)} moduli with {len(series.times)} times"
                yield f"the attribute damping_laws has {count} for {name}"
    for name, known in (found.heat_capacities or {}).items():
        if len(known.s) != len(known.capacity):
            yield f"the attribute heat_capacities has {len(known.s)} stations with {len(known.capacity)} for {name}"


def _missing(found: ResultAttributes, plain: Mapping[str, Any]) -> Iterator[str]:
    needed = {other: name for name, others in _TOGETHER.items() if plain.get(name) for other in others}
    if found.kind == "steady":
        needed |= dict.fromkeys(_STEADY, "kind")
    if found.kind == "modes":
        needed |= dict.fromkeys(("mode_rigid", "mode_certified"), "kind")
    if found.kind == "buckling":
        needed |= dict.fromkeys(("buckling_exact", "buckling_complete"), "kind")
    if found.formulation == "intrinsic" and found.kind == "simulate":
        needed |= dict.fromkeys(("dynamics", "damping"), "formulation")
    if found.negative_eigenvalues is not None and found.stability != "tangent stiffness":
        needed["flutter"] = "stability"
    for other, name in needed.items():
        if plain.get(other) is None:
            yield f"the attribute {other} is missing, which belongs to {name}"


def _plain(value: Any) -> Any:
    return value.item() if isinstance(value, np.generic) else value


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
