"""Reports of results as plain text, SI units."""

from __future__ import annotations

import itertools
import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from viscorod.errors import InputError
from viscorod.results.damping_validity import damping_validity
from viscorod.results.data_schema import COUNTERS
from viscorod.results.largest_stress import largest_stress
from viscorod.results.result_warnings import warnings_of
from viscorod.results.step_error import step_errors
from viscorod.results.text_table import listed, table
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result
    from viscorod.results.result_places import ResultPlace
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady

_WORKING = 0.01  # more work of the loads than this part of what moved, meanwhile, makes it no free decay
_MOST_EVENTS = 20
_MOST_MESHES = 4
"""Rods whose division a report tells at most."""
_ROUND_OFF = 1e-10  # a number below this part of its table's largest reads 0


def run_report(run: Run) -> str:
    """Return the report of a run."""
    attrs = run.data.attrs
    time = run.time
    steps = f" in {attrs['steps']} steps" if "steps" in attrs else ""
    size = f" of {attrs['time_step']:g} s" if "time_step" in attrs else ""
    size += f" that follow the error, tolerance {attrs['tolerance']:g}" if "tolerance" in attrs else ""
    size += f" ({100.0 * attrs['part_of_motion']:g} % of the motion)" if "part_of_motion" in attrs else ""
    method = f", {str(attrs['integrator']).replace('_', '-')}" if attrs.get("integrator") else ""
    blocks = [
        _heading(run, f"{time[-1] - time[0]:g} s simulated{steps}{size}{method}{_formulation(run)}"),
        _began(run),
        _ends(run, *_shown_state(run)),
        _decay(run),
        str(run.energy),
        _events(run),
        _stress(run),
        _validity(run),
        _heating(run),
        _drift(run),
        _effort(run),
        _warnings(run),
    ]
    return "\n\n".join(block for block in blocks if block)


def _began(run: Run) -> str:
    """Report what the motion started from, unless it is the reference shape or the plain equilibrium."""
    text = str(run.data.attrs.get("began_from", ""))
    return f"Started from {text}" if "settling" in text or " at " in text else ""


def _events(run: Run) -> str:
    """Report the events of the run."""
    attrs = run.data.attrs
    if "events" not in attrs:
        return ""
    events = json.loads(attrs["events"])
    if not events:
        return "Events: none of those that the run watched for"
    lines = [f"  {event['time']:.9g} s  {event['event']}" for event in events[:_MOST_EVENTS]]
    if len(events) > _MOST_EVENTS:
        lines.append(f"  and {len(events) - _MOST_EVENTS} more")
    if attrs.get("ended_by"):
        lines.append("The last of them ended the run")
    return "\n".join(["Events", *lines])


def _validity(result: Result) -> str:
    """Tell the conditions of a rod model, each with its number, and whether the motion kept to the bands of losses."""
    found = result.validity()
    lines = [str(found)] if found.conditions else []
    return "\n".join([*lines, *_band_notes(result)])


def _band_notes(result: Result) -> list[str]:
    """Say which rods moved beyond the band over which their loss factor is followed."""
    if result.kind != "simulate" or "damping_laws" not in result.data.attrs:
        return []
    try:
        notes = damping_validity(cast("Run", result)).notes
    except InputError:  # too short for a spectrum
        return []
    return [note for note in notes if "loss factor" in note]


def _heating(run: Run) -> str:
    """Say how much the motion warms the rods whose specific heat is known."""
    known = "heat_capacities" in run.data.attrs and "dissipation" in run.data and run.time.size > 1
    return str(run.self_heating()) if known else ""


def _formulation(run: Run) -> str:
    attrs = run.data.attrs
    if attrs.get("formulation", "geometric") == "geometric":
        return ""
    kind = "linear dynamics, " if attrs["dynamics"] == "linear" else ""
    kind += f"{attrs['modes']} modes, " if "modes" in attrs else ""
    return f"; intrinsic formulation, {kind}{attrs['damping']} damping"


def equilibrium_report(equilibrium: Equilibrium) -> str:
    """Return the report of an equilibrium."""
    reached = equilibrium.load_factor[-1]
    level = load_level(reached)
    blocks = [
        _heading(equilibrium, f"static equilibrium under {level}"),
        _ends(equilibrium, _places(equilibrium), -1),
        _rotations(equilibrium),
        _reactions(equilibrium),
        _path(equilibrium),
        _joints(equilibrium),
        _stability(equilibrium),
        _stress(equilibrium),
        _validity(equilibrium),
        _effort(equilibrium),
        _warnings(equilibrium),
    ]
    return "\n\n".join(block for block in blocks if block)


def steady_report(steady: Steady) -> str:
    """Return the report of a steady rotation."""
    rate = float(np.linalg.norm(steady.spin))
    damping = "" if steady.damping == "full" else f", {steady.damping} damping"
    blocks = [
        _heading(steady, f"steady rotation at {rate:.6g} rad/s ({steady.formulation} formulation{damping})"),
        _turning(steady, rate),
        _ends(steady, _places(steady), -1),
        _reactions(steady),
        _small_motions(steady),
        _stress(steady),
        _validity(steady),
        _effort(steady),
        _warnings(steady),
    ]
    return "\n\n".join(block for block in blocks if block)


def _turning(steady: Steady, rate: float) -> str:
    axis, centre = (_vector(values, 1.0) for values in (steady.spin / rate, steady.centre))
    momentum = float(np.linalg.norm(steady.angular_momentum))
    return "\n".join(
        [
            f"Axis ({', '.join(axis)}) through ({', '.join(centre)}) m",
            f"Kinetic energy {steady.kinetic_energy:.6g} J, elastic energy {steady.elastic_energy:.6g} J, "
            f"angular momentum {momentum:.6g} N m s",
            f"Balanced to {steady.residual:.2g} of the largest force",
        ]
    )


def _small_motions(steady: Steady) -> str:
    rows = [
        (str(number), f"{s.real:.6g}", f"{s.imag:.6g}", f"{frequency:.6g}", f"{ratio:.6g}")
        for number, (s, frequency, ratio) in enumerate(
            zip(steady.eigenvalues, steady.frequencies, steady.damping_ratios, strict=True), 1
        )
    ]
    header = ("motion", "Re s [1/s]", "Im s [1/s]", "frequency [Hz]", "damping ratio")
    verdict = (
        "Stable: no small motion grows"
        if steady.stable
        else f"Unstable: a small motion grows by e in {1.0 / steady.growth_rate:.4g} s"
    )
    neutral = steady.neutral
    if neutral:
        verdict += (
            f"; {neutral} neither grow{'s' if neutral == 1 else ''} nor fade{'s' if neutral == 1 else ''}"
        )
    return table("Slowest small motions about it, exp(s t)", header, rows) + f"\n{verdict}"


def _heading(result: Result, summary: str) -> str:
    lines = [result.title] if result.title else []
    lines.append(summary)
    if result.outcome != "completed":
        lines.append(f"stopped early ({result.outcome}): {result.data.attrs.get('message', '')}".rstrip(": "))
    return "\n".join(lines)


def _ends(result: Result, title: str, state: int) -> str:
    position = result.field("position", states=state)
    displacement = result.field("displacement", states=state)
    size = float(np.max(np.abs(position)))
    rows = [
        (site.label, *_vector(site.of(position), size), *_vector(site.of(displacement), size))
        for site in _named_sites(result)
    ]
    header = ("place", "x [m]", "y [m]", "z [m]", "moved x [m]", "y [m]", "z [m]")
    return table(title + ": position, and displacement from the reference shape", header, rows)


def _named_sites(result: Result, *, points: bool = True) -> list[ResultPlace]:
    """Return the ends of the rods and the places on bodies; ``points`` False leaves named points out."""
    sites = result.sites
    bodies = [sites.at(place) for place in sites.bodies if points or "." not in place]
    return [end for rod in sites.rods for end in sites.ends(rod)] + bodies


def _places(result: Result) -> str:
    return "Rod ends and bodies" if result.sites.bodies else "Rod ends"


def _shown_state(run: Run) -> tuple[str, int]:
    """Return the state whose rod ends are reported: the held start, or the end where the rods start undeformed."""
    time = run.time
    if time.size == 1 or np.any(run.field("displacement", states=0)):
        return f"{_places(run)} at {time[0]:g} s, the start", 0
    return f"{_places(run)} at {time[-1]:g} s", -1


def _decay(run: Run) -> str:
    site, axis = run.main_motion
    spread = float(np.ptp(run.history(site.label, "displacement").sel(axis=axis).values))
    largest = f"{site.label} along {axis} has the largest range of displacement, {spread:.6g} m"
    decay = run.free_decay(site.label, axis)
    if decay is None:
        return (
            f"No regular decay: {largest},\nand its maxima make no cycles of a damping ratio "
            "(model.modes() gives those of small vibrations)"
        )
    energy = run.energy
    since = energy.time >= decay.time[0]
    late, drag = energy.supplied[since], float(np.ptp(energy.outside[since]))
    lines = [str(decay), f"  ({largest})"]
    if drag > _WORKING * energy.moved:
        share = drag / (drag + float(np.ptp(energy.viscous[since])))
        lines.append(f"  (drag takes {100.0 * share:.3g} % of what is lost meanwhile, the material the rest)")
    if float(np.ptp(late)) > _WORKING * energy.moved:
        who = "rest strains, loads or supports" if energy.actuator.any() else "loads or supports"
        lines.append(f"  ({who} do work meanwhile: these ratios describe the motion, not only the material)")
    return "\n".join(lines)


def _rotations(equilibrium: Equilibrium) -> str:
    rows = [
        (site.label, *_vector(equilibrium.rotation(site.label), 1.0))
        for site in _named_sites(equilibrium, points=False)
    ]
    return table(
        "Rotation from the reference orientation (rotation vector)",
        ("place", "x [rad]", "y [rad]", "z [rad]"),
        rows,
    )


def _reactions(equilibrium: Equilibrium | Steady) -> str:
    if "reaction" not in equilibrium.data or equilibrium.data.sizes.get("support", 0) == 0:
        return ""
    names = equilibrium.data["support"].values
    values = equilibrium.data["reaction"].isel({equilibrium.dimension: -1}).values
    size = float(np.max(np.abs(equilibrium.field("position", states=-1))))
    force, moment = (float(np.max(np.abs(part))) for part in (values[:, :3], values[:, 3:]))
    force = max(force, moment / size) if size > 0.0 else force  # round-off of either spoils both
    moment = max(moment, force * size)
    rows = [
        (str(name), *_vector(row[:3], force), *_vector(row[3:], moment))
        for name, row in zip(names, values, strict=True)
    ]
    header = ("support", "fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]")
    return table("Reactions of the supports", header, rows)


def _joints(equilibrium: Equilibrium) -> str:
    """Report coordinates that joints leave free or drive, springs, and all forces."""
    data = equilibrium.data
    if "joint_value" not in data:
        return ""
    value, force = (data[name].values[-1] for name in ("joint_value", "joint_force"))
    words = data["joint_motion"].values
    lengths = np.array([word.startswith("u") for word in words])
    size = float(data.attrs.get("scale_length", 1.0))
    largest = float(np.abs(np.where(lengths, force, force / size)).max())
    rows = []
    for k, (joint, word) in enumerate(zip(data["joint"].values, words, strict=True)):
        scale = 1.0 if lengths[k] else size
        name = str(joint) if k == 0 or joint != data["joint"].values[k - 1] else ""
        held = "held" if data["joint_held"].values[k] else ""
        rows.append(
            (
                name,
                str(word),
                *_vector(value[k : k + 1], scale),
                *_vector(force[k : k + 1], largest * scale),
                held,
            )
        )
    return table(
        "Joints and springs: coordinates, and what acts along them on the first place",
        ("joint", "motion", "value [m, rad]", "force [N, N m]", ""),
        rows,
    )


def _stress(result: Result) -> str:
    """Report the largest von Mises stress, and where it is."""
    found = largest_stress(result)
    if found is None or not found.value:
        return ""
    place = result.sites.along(found.rod, found.s).label
    x, y = _vector(np.array(found.point), max(map(abs, found.point)) or 1.0)
    when = {"time": f" at {found.level:.6g} s", "load_factor": f" under {load_level(found.level)}"}
    text = (
        f"Largest von Mises stress {found.value:.6g} Pa, {place}, at ({x}, {y}) m of the section along d1, d2"
        f"{when.get(result.dimension, '')}"
    )
    if found.missing:
        more = f" and {len(found.missing) - _MOST_MESHES} more" if len(found.missing) > _MOST_MESHES else ""
        names = ", ".join(found.missing[:_MOST_MESHES])
        text += f"\n  (not of {names}{more}: sections without a known shape, or with a law)"
    return text


def _drift(result: Result) -> str:
    attrs = result.data.attrs
    if "drift_position" not in attrs:
        return ""
    return (
        f"Joints and held strains: largest violation {attrs['drift_position']:.2g} (positions, over the size), "
        f"{attrs['drift_velocity']:.2g} (velocities)"
    )


def load_level(factor: float, digits: int = 6) -> str:
    """Return a load factor in words: a part of the loads, or a multiple of small reference loads."""
    if factor == 1.0:
        return "all of the loads"
    if abs(factor) <= 10.0:
        return f"{100.0 * factor:.{digits}g} % of the loads"
    return f"{factor:.{digits}g} times the loads"


def _path(equilibrium: Equilibrium) -> str:
    if not equilibrium.is_path:
        return ""
    factors = equilibrium.load_factor
    unstable = np.asarray(equilibrium.data["negative_eigenvalues"].values)
    lines = [f"Path of {factors.size} points; load factors from {factors.min():.6g} to {factors.max():.6g}"]
    motions = equilibrium.stability != "tangent stiffness"
    counted = "growing motions" if motions else "negative eigenvalues"
    times = [f"{k}-fold bifurcation" if k > 1 else "bifurcation" for k in equilibrium.multiplicity]
    words = {
        "limit_points": itertools.repeat("limit point"),
        "bifurcations": iter(times) if times else itertools.repeat("bifurcation"),
        "flutter_points": itertools.repeat("flutter"),
    }
    for kind, names in words.items():
        for number, word in zip(equilibrium.special_points(kind), names, strict=False):
            after = unstable[min(number + 1, unstable.size - 1)]
            lines.append(f"  {word} at {factors[number]:.7g} of the loads ({counted} beyond it: {after})")
    lines += [
        f"  near {factor:.4g} of the loads it turns off beside another path, which it does not meet: an imperfection, "
        "such as a small load or a shape that is not quite symmetric, decides which way"
        for factor in json.loads(equilibrium.data.attrs.get("parting", "[]"))
    ]
    return "\n".join(lines)


def _stability(equilibrium: Equilibrium) -> str:
    lines = [f"Elastic energy {equilibrium.elastic_energy:.6g} J"]
    if "negative_eigenvalues" in equilibrium.data.attrs:
        count = equilibrium.negative_eigenvalues
        plural = "s" if count > 1 else ""
        if equilibrium.stability == "tangent stiffness":
            lines.append(
                f"Unstable: the tangent stiffness has {count} negative eigenvalue{plural}"
                if count
                else "Stable: the tangent stiffness has no negative eigenvalue"
            )
        else:
            flutter = int(equilibrium.data.attrs["flutter"])
            why = (
                "following loads or moments make the tangent stiffness unsymmetric: judged by "
                f"{equilibrium.stability}"
            )
            lines.append(
                f"Unstable: {count} small motion{plural} grow{'' if count > 1 else 's'}, "
                f"{flutter} of them oscillating ({why})"
                if count
                else f"Stable: no small motion grows ({why})"
            )
    if equilibrium.found_by:
        lines.append(f"Found by {equilibrium.found_by}")
    return "\n".join(lines)


def _effort(result: Result) -> str:
    attrs = result.data.attrs
    parts = [_counted(int(attrs[name]), words) for name, words in COUNTERS.items() if name in attrs]
    if "wall_time_s" in attrs:
        parts.append(f"{attrs['wall_time_s']:.3g} s wall time")
    if attrs.get("compile_time_s", 0.0) >= 0.1:
        parts.append(f"{attrs['compile_time_s']:.3g} s compiling before that")
    lines = [f"Effort: {', '.join(parts)}"] if parts else []
    if "linear_solver" in attrs:
        lines.append(f"Linear systems: {attrs['linear_solver']}")
    if str(attrs.get("symmetry", "")).startswith("about"):
        lines.append(
            f"Symmetric {attrs['symmetry']}: solved for motions in it only. No motion leaves it, not even where it is "
            'unstable: give a small imperfection to see that, or symmetry = "ignored" to let rounding begin it'
        )
    if result.mesh_errors:
        lines.append(_mesh(result))
    if step_errors(attrs):
        lines.append(_steps(attrs))
    if attrs.get("smallest_step_why"):
        lines.append(
            f"Smallest step: {attrs['smallest_step']:.3g} s at t = {attrs['smallest_step_at']:.6g} s, "
            f"limited by {attrs['smallest_step_why']}"
        )
    if "modes" in attrs:
        lines.append(_modes(attrs))
    if "pose_gap" in attrs:
        lines.append(
            f"Poses integrated in time and along the rods differ by at most {attrs['pose_gap']:.3g} m "
            f"and {attrs['rotation_gap']:.3g} rad"
        )
    return "\n".join(lines)


def _modes(attrs: Mapping[str, Any]) -> str:
    """Say in which modes a motion was sought, and what fewer of them would have made of it."""
    rigid, count = int(attrs["modes_rigid"]), int(attrs["modes"])
    beside = int(attrs["modes_velocities"]) - rigid - count
    turning = f", {_counted(rigid, 'rigid motions')}" if rigid else ""
    text = (
        f"Modes: {_counted(count, 'vibrations')} up to {attrs['modes_highest']:.4g} Hz"
        f"{turning} and {beside} quasi-static answers"
    )
    if "modes_fewer" not in attrs:
        return f"{text}; what fewer of them would make of it is not known"
    return (
        f"{text}; in {attrs['modes_fewer']} modes positions differ by up to {attrs['modes_position_gap']:.2g} m, "
        f"{attrs['modes_motion_gap']:.2g} of the largest displacement, rotations by "
        f"{attrs['modes_rotation_gap']:.2g} rad, and section forces by {attrs['modes_force_gap']:.2g} of the largest"
    )


def _mesh(result: Result) -> str:
    """Say how the rods are divided and what that makes wrong."""
    data = result.data
    rods, orders = (data[f"station_{name}"].values.tolist() for name in ("rod", "order"))
    order = dict(zip(rods, orders, strict=True))
    meshes = [
        f"{rod!r} {_counted((rods.count(rod) - 1) // int(order[rod]), 'elements')} of order {int(order[rod])}"
        for rod in list(result.mesh_errors)[:_MOST_MESHES]
    ]
    more = len(result.mesh_errors) - len(meshes)
    errors = [f"positions by {max(result.mesh_errors.values()):.1g} of the length of a rod"]
    for name, what in (
        ("motion", "{} of the largest displacement"),
        ("force", "section forces by {} of the largest"),
    ):
        if f"mesh_{name}_error" in data.attrs:
            errors.append(what.format(f"{data.attrs[f'mesh_{name}_error']:.1g}"))
    return f"Mesh: {', '.join(meshes)}{f' and {more} more rods' if more else ''}; estimated errors: {', '.join(errors)}"


def _steps(attrs: Mapping[str, Any]) -> str:
    """Say what the steps make wrong."""
    found = step_errors(attrs)
    return (
        f"Steps: estimated errors: positions by {found['position']:.1g} m, rotations by {found['rotation']:.1g} rad, "
        f"{attrs['step_motion_error']:.1g} of the motion, section forces by {attrs['step_force_error']:.1g} of the "
        "largest"
    )


def _warnings(result: Result) -> str:
    warnings = warnings_of(result)
    return listed("Warnings", warnings) if warnings else "No warnings"


def _vector(values: Floats, scale: float) -> list[str]:
    """Format numbers with six digits; round-off against ``scale`` becomes 0."""
    return [f"{0.0 if abs(value) < _ROUND_OFF * scale else value:.6g}" for value in values]


def _counted(count: int, name: str) -> str:
    if count == 1:
        name = name.replace("evaluations", "evaluation") if "evaluations" in name else name.removesuffix("s")
    return f"{count} {name}"
