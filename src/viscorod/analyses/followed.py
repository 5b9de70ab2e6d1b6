"""What the results of followed modes have in common, whatever the parameter is."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import SolveError
from viscorod.results.followed_modes import FollowedModes
from viscorod.results.late_attributes import LateAttributes
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import nodal_motions, rigid_parts
from viscorod.solve.modes.mode_names import StrainEnergies, numbered
from viscorod.solve.problem.division import divisions_of
from viscorod.solve.refinement.finer_divisions import MOST_CHOSEN_NODES
from viscorod.solve.refinement.followed_errors import FinerModes, critical_errors
from viscorod.solve.statics.newton import interruption
from viscorod.solve.tracking.engine_orders import Critical
from viscorod.solve.tracking.meetings import Meeting
from viscorod.solve.tracking.mode_tracking import SWINGS, Family, Sample, Tracker
from viscorod.solve.tracking.special_values import Limit, grows, limits
from viscorod.typing import Floats

__all__ = [
    "common_attributes",
    "common_variables",
    "doubts",
    "errors_of",
    "followed",
    "found_in",
    "limits_of",
    "names_of",
    "on_fine_mesh",
    "whole",
]

MOST_MESHES = 12
"""Meshes that are tried at most."""
STILL = 1e-6
"""Part of the largest root below which one is that of a motion at rest."""
SAME = 1e-6
"""Distance of two roots, as a part of them, within which they are one."""
SOUGHT = 10.0
"""Size of a root over the largest that is followed, beyond which the search for slow ones does not find it exactly."""
GAIN = 0.7
"""Part of the error before that refinement leaves at most, where it is the mesh that makes the error."""
ROUNDING = float(np.finfo(float).eps)
"""Least error of a root that was compared, in parts of it; 0 stands for one that was not."""


T = TypeVar("T")


def followed(
    discrete: DiscreteModel, family: Family, count: int, values: tuple[float, ...], first: int = 0
) -> tuple[Tracker, tuple[float, ...]]:
    """Return a tracker that has followed modes, and the values that it reached.

    Args:
        discrete: the model; family: its small motions; count: of modes; values: of the parameter; first: to begin at.
    """
    tracker = Tracker(family, count, discrete.static.check_interrupt, discrete.options.progress)
    tracker.follow(values, first)
    if tracker.stopped:
        discrete.static.stop = None
    return tracker, tuple(tracker.reached(values))


def found_in(discrete: DiscreteModel, tracker: Tracker, words: str, what: Callable[[], T], nothing: T) -> T:
    """Return what is sought among modes that were followed; ``nothing`` if that is stopped, or fails.

    The tracker keeps the reason; ``words`` are for what is missing.
    """
    try:
        return what()
    except (SolveError, KeyboardInterrupt) as error:
        discrete.static.stop = None
        why = interruption(error) if isinstance(error, KeyboardInterrupt) else str(error)
        tracker.stop(f"{words} were not sought to the end: {why}")
        return nothing


def limits_of(discrete: DiscreteModel, tracker: Tracker) -> list[Limit]:
    """Return where modes that were followed begin and cease to grow, as far as that was sought."""
    nothing: list[Limit] = []
    return found_in(discrete, tracker, "limits of stability", lambda: limits(tracker), nothing)


class Errors(NamedTuple):
    """Estimated errors by the mesh, in parts of what they are of: of modes, limits and critical speeds."""

    modes: Floats
    limits: Floats
    critical: Floats
    known: bool = True


def errors_of(
    discrete: DiscreteModel,
    finer: Callable[[], Family] | None,
    tracker: Tracker,
    samples: list[Sample],
    limited: list[Limit],
    critical: Sequence[Critical] = (),
    waves: Sequence[int] = (),
) -> Errors:
    """Return the errors by comparison with a finer mesh; zeros where there is none, or all was stopped before.

    Rigid bodies alone have no mesh that could err.
    """
    known = not discrete.problem.rods
    none = Errors(np.zeros(len(samples[0].roots)), np.zeros(len(limited)), np.zeros(len(critical)), known)
    if finer is None or tracker.stopped:
        return none

    def compared() -> Errors:
        modes = FinerModes(finer(), tracker)
        of_limits = np.array([modes.limit_error(one) for one in limited], dtype=float)
        of_modes, of_speeds = modes.errors(samples), critical_errors(modes, critical, waves)
        return Errors(np.maximum(of_modes, ROUNDING), of_limits, np.maximum(of_speeds, ROUNDING))

    return found_in(discrete, tracker, "errors of the mesh", compared, none)


F = TypeVar("F", bound=FollowedModes)


def whole(result: F, tracker: Tracker) -> F:
    """Return a result.

    Raises:
        SolveError: it is not whole; `run` has it.
    """
    if not tracker.stopped:
        return result
    raise SolveError(f"Modes were followed to {result.values[-1]:.6g}: {tracker.stopped}", result)


def on_fine_mesh(
    discrete: DiscreteModel,
    family: Callable[[DiscreteModel], Family],
    at: float,
    count: int,
    accuracy: float,
) -> tuple[DiscreteModel, DiscreteModel | None]:
    """Return a model on a mesh that is fine enough, where the program may choose it, and that with elements halved.

    Args:
        discrete: to begin with; family: returns its small motions over the parameter; at: value at which frequencies
            are compared; count: of them; accuracy: wanted of each.
    """
    if not discrete.watch.feasible:
        return discrete, None
    free = {name for name, rod in discrete.model.rods.items() if rod.elements is None}
    before = np.inf
    for _ in range(MOST_MESHES):
        coarse = divisions_of(discrete.problem)
        finer = discrete.on_mesh({name: division.halved() for name, division in coarse.items()})
        if not free:
            break
        mine, theirs = (_frequencies(family(one), at, count) for one in (discrete, finer))
        paired = min(len(mine), len(theirs), count)
        worst = float((np.abs(mine[:paired] - theirs[:paired]) / theirs[:paired]).max(initial=0.0))
        if worst <= accuracy or worst > GAIN * before or finer.problem.size > MOST_CHOSEN_NODES:
            break
        before = worst
        discrete = discrete.on_mesh({n: d.halved() if n in free else d for n, d in coarse.items()})
    return discrete.renewed(discrete.options, {}), finer.renewed(discrete.options, {})


def _frequencies(family: Family, at: float, count: int) -> np.ndarray:
    """Return the angular frequencies of the slowest motions that oscillate [rad/s]."""
    found = Tracker(family, count).spectrum(at, 0.0).roots
    return np.sort(found.imag[found.imag > SWINGS * np.abs(found)])


def _stray(samples: list[Sample]) -> float | None:
    """Return the first value of the parameter at which a motion grows that is not followed; None without."""
    still = STILL * max(float(np.abs(sample.roots).max()) for sample in samples)
    for sample in samples:
        known = np.concatenate([sample.roots, sample.roots.conj()])
        far = SOUGHT * float(np.abs(sample.roots).max())
        for s in sample.spectrum.roots:
            if still < abs(s) < far and grows(complex(s)) and np.abs(known - s).min() > SAME * abs(s):
                return sample.parameter
    return None


def names_of(discrete: DiscreteModel, state: State, sample: Sample) -> list[str]:
    """Return the names of the modes by their strains in a sample, about a state."""
    rigid = rigid_parts(discrete.system, discrete.supports, state)
    energies = StrainEnergies(discrete.system, state, nodal_motions(discrete.problem), rigid)
    order = np.argsort(np.abs(sample.roots), kind="stable")
    kinds = energies.kinds(sample.shapes[:, order])
    found = numbered(kinds, sample.roots[order].imag == 0.0)
    names = [""] * len(found)
    for place, name in zip(order, found, strict=True):
        names[place] = name
    return names


def common_variables(
    along: str,
    samples: list[Sample],
    names: list[str],
    limited: list[Limit],
    meetings: list[Meeting],
    errors: Errors,
    shifts: Floats | float = 0.0,
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return variables and coordinates of a data set.

    Args:
        along: name of the parameter; samples: at its values; names: of the modes.
        limited: limits of stability; meetings: of frequencies; errors: by the mesh.
        shifts: by how much angular frequencies [rad/s] are told larger than those of the motions ``(values, modes)``.
    """
    roots = np.array([sample.roots for sample in samples])
    seen = roots + 1j * shifts
    tau, modes = 2.0 * np.pi, (along, "mode")
    variables: dict[str, Any] = {
        "eigenvalue": ((along, "mode", "part"), np.stack([roots.real, roots.imag], axis=-1)),
        "likeness": (modes, np.array([sample.likeness for sample in samples])),
        "mesh_error": ("mode", errors.modes),
        f"limit_{along}": ("limit", np.array([one.parameter for one in limited], dtype=float)),
        "limit_mode": ("limit", np.array([one.mode for one in limited], dtype=np.int64)),
        "limit_kind": ("limit", np.array([one.kind for one in limited], dtype=str)),
        "limit_unstable": ("limit", np.array([one.unstable for one in limited], dtype=np.int64)),
        "limit_frequency": ("limit", np.array([abs(one.root.imag) / tau for one in limited], dtype=float)),
        "limit_error": ("limit", errors.limits),
        f"meeting_{along}": ("meeting", np.array([one.parameter for one in meetings], dtype=float)),
        "meeting_modes": (
            ("meeting", "pair"),
            np.array([one.modes for one in meetings], dtype=np.int64).reshape(-1, 2),
        ),
        "meeting_crosses": ("meeting", np.array([one.crosses for one in meetings], dtype=np.int64)),
        "meeting_frequency": ("meeting", np.array([one.frequency / tau for one in meetings], dtype=float)),
        "meeting_gap": ("meeting", np.array([one.gap / tau for one in meetings], dtype=float)),
        "frequency": (modes, np.abs(seen.imag) / tau),
        "damping_ratio": (modes, -seen.real / np.maximum(np.abs(seen), np.finfo(float).tiny) + 0.0),
    }
    return variables, {"mode": names, "part": ["real", "imaginary"]}


def doubts(
    along: str, samples: list[Sample], names: list[str], errors: Errors, tracker: Tracker
) -> list[str]:
    """Return what is uncertain about followed modes, in sentences; see :func:`common_variables`."""
    notes = []
    for low, high, numbers in tracker.doubts:
        which = ", ".join(names[k] for k in numbers)
        notes.append(
            f"between {low:.8g} and {high:.8g} these modes may have been taken for one another, their shapes change "
            f"too fast: {which}"
        )
    if not all(sample.spectrum.complete for sample in samples):
        notes.append("it is not known whether all slow motions were found: others may grow")
    stray = _stray(samples)
    if stray is not None:
        notes.append(
            f"motions that are not followed grow from {along.replace('_', ' ')} {stray:.6g} on: follow more modes"
        )
    if tracker.stopped:
        notes.append(f"this is not all that was asked for: {tracker.stopped}")
    elif not errors.known:
        notes.append(
            "errors of the mesh were not estimated: the model is too large for a finer one beside it, or nobody asked"
        )
    return notes


def common_attributes(
    discrete: DiscreteModel, kind: str, tracker: Tracker, iterations: int, notes: list[str], **own: str
) -> LateAttributes:
    """Return the attributes of a data set.

    Args:
        kind: of the result; iterations: that its states took; notes: what is uncertain; own: those of its kind alone.
    """
    return discrete.complete(
        {
            "kind": kind,
            "outcome": "stopped" if tracker.stopped else "completed",
            **own,
            "nodes": discrete.problem.size,
            "iterations": iterations,
            "warnings": json.dumps([*json.loads(discrete.attributes.get("warnings", "[]")), *notes]),
        }
    )
