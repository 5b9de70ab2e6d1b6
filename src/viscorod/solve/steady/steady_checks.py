"""Checks that a model can rotate steadily: how it is held, what its loads do, and how large it is."""

from __future__ import annotations

from collections.abc import Iterator
from enum import Enum

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.mechanics.rotations.adjoint_maps import skew
from viscorod.model.actions.load import AnyLoad
from viscorod.model.actions.load_effects import CompiledLaw, MotionLaw
from viscorod.model.actions.time_function import Constant
from viscorod.model.connections.motion_words import MOTIONS
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.checks import unfit_for_steady
from viscorod.solve.settings.steady import SteadySettings
from viscorod.typing import Floats

LARGEST = 3000
"""Unknowns up to which the dense linear algebra of the intrinsic formulation, and of branches, takes seconds."""

PARALLEL = 1e-9
"""Part of a load that may stand across the axis: round-off."""


class SupportKind(Enum):
    """Support of a model, by which it may turn freely."""

    FREE = "no supports"
    JOINT = "ball joint"
    HELD = "supports that turn with the rotation"


def support_kind(problem: Problem) -> SupportKind:
    """Return how a model is held; pins at one node make a ball joint."""
    supports, joints = problem.supports, problem.joints.arrays
    if (joints.place >= 0).any() or (joints.nodes < 0).any():
        return SupportKind.HELD
    if len(supports.nodes) == 0:
        return SupportKind.FREE
    pinned = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    if len(supports.nodes) == 1 and np.array_equal(supports.fixed[0], pinned):
        return SupportKind.JOINT
    return SupportKind.HELD


def require_steady(
    model: ModelDescription, problem: Problem, settings: SteadySettings, loads: int | None = None
) -> None:
    """Check that there can be such a rotation.

    Args:
        model, problem, settings: of the rotation; loads: how many of the model's act, all unless given.

    Raises:
        InputError: with everything that is in its way, by name.
    """
    faults = [*unfit_for_steady(model, settings.formulation, settings.damping), *_size(problem, settings)]
    if support_kind(problem) is SupportKind.HELD and not settings.driven:
        held = [_label(model, name) for name in problem.supports.names]
        joined = [joint.label for joint in model.joints] + [spring.label for spring in model.springs]
        name = [*held, *joined][0]
        faults.append(
            Fault(
                settings.measure,
                "",
                f"this model does not turn freely: there is a {name}",
                "give spin as the angular velocity of the supports, such as [0, 0, 4.0], "
                "or hold the rod by one pin only",
            )
        )
    for index in np.flatnonzero(problem.supports.in_body)[:1]:
        faults.append(
            Fault(
                "supports",
                _label(model, problem.supports.names[index]),
                "it holds velocities along moving axes, which do not define a steady rotation",
                "hold positions: a pin, a clamp or another support",
            )
        )
    constant = settings.driven and settings.formulation == "geometric"
    for index, component, motion in problem.supports.motions:
        if constant and isinstance(motion, Constant):
            continue  # it turns with the support
        word = MOTIONS[component]
        faults.append(
            Fault(
                "supports",
                _label(model, problem.supports.names[index]),
                f"its prescribed motion {word} is a function of time, not a steady rotation",
                "leave the motion out, or give a number: supports turn with the given spin as they are"
                if constant
                else "leave the motion out: supports turn with the given spin as they are",
            )
        )
        break
    faults += _springs(model, settings)
    for index, load in enumerate(model.loads[:loads]):
        faults += _load(index, load, problem, settings)
    if settings.formulation == "intrinsic":
        faults += _intrinsic_supports(model, problem, settings)
    if faults:
        raise InputError(faults)


def beside_the_axis(problem: Problem, settings: SteadySettings) -> list[str]:
    """Return a doubt where one pin holds a model off the axis through the origin, about which it does not turn."""
    if not settings.driven or settings.centre is not None or support_kind(problem) is not SupportKind.JOINT:
        return []
    spin = np.asarray(settings.spin, dtype=float)
    pin = problem.positions[problem.supports.nodes[0]]
    if np.linalg.norm(np.cross(pin, spin)) <= PARALLEL * problem.length * np.linalg.norm(spin):
        return []
    where = ", ".join(f"{x:.6g}" for x in pin + 0.0)
    return [
        f"a single pin is a ball joint at rest: the model turns about the pin at ({where}) m, not about an axis "
        "through the origin; give centre = (0, 0, 0) where a hub carries the pin round, or its place if it is meant"
    ]


def _size(problem: Problem, settings: SteadySettings) -> Iterator[Fault]:
    points = 6 * sum(e.section.size for e in problem.sets)
    unknowns = 6 * problem.size + points
    springs = 12 * problem.size + points * len(problem.relaxation_times)
    if problem.relaxing and springs > LARGEST:
        yield Fault(
            "rods",
            f"{springs} unknowns",
            f"small motions with Maxwell branches have full matrices, for up to {LARGEST} unknowns",
            "give fewer elements, of higher order, or fewer branches",
        )
    if settings.formulation == "intrinsic" and unknowns > LARGEST:
        yield Fault(
            "rods",
            f"{unknowns} unknowns",
            f"the intrinsic formulation has full matrices, for up to {LARGEST} unknowns",
            "leave out formulation, or give fewer elements, of higher order",
        )
    most = {SupportKind.FREE: 6, SupportKind.JOINT: 3}.get(support_kind(problem))
    if most is not None and len(free_motions(problem)) > most:
        yield Fault("rods", "", "the rods are not connected", "attach them, or compute them one by one")


def _springs(model: ModelDescription, settings: SteadySettings) -> Iterator[Fault]:
    """Refuse springs that are not the same however the model has turned about the axis."""
    advice = "make it alike in all directions across the axis, to the ground, on the axis; or compute with simulate"
    totals: dict[tuple[float, ...], tuple[int, Floats]] = {}
    for index, spring in enumerate(model.resolved_springs()):
        label, where = model.springs[index].label, f"springs[{index}]"
        if spring.a is not None and spring.b is not None:
            continue  # it turns with the model
        numbers = not any(callable(law) for law in (*spring.stiffness.values(), *spring.damping.values()))
        moves = all(word in MOTIONS[:3] for word in (*spring.stiffness, *spring.damping))
        if settings.formulation == "intrinsic":
            continue  # refused already
        if spring.kind == "line" or not moves or not numbers:
            why = "a steady rotation allows springs and dampers to the ground along ux, uy and uz only, with numbers"
            yield Fault(where, label, why, advice)
        elif settings.driven:
            spin, point = np.asarray(settings.spin, dtype=float), spring.at_a
            axis = spin / np.linalg.norm(spin)
            arm = np.cross(point - np.asarray(settings.centre or (0.0, 0.0, 0.0)), axis)
            rest = spring.frame @ np.array([spring.rest.get(word, 0.0) for word in MOTIONS[:3]])
            length = max([float(np.linalg.norm(point)), *(rod.length for rod in model.rods.values())])
            if (
                np.linalg.norm(arm) > PARALLEL * length
                or np.linalg.norm(np.cross(rest, axis)) > PARALLEL * length
            ):
                yield Fault(
                    where, label, "its point without force is not on the axis of the rotation", advice
                )
                continue
            both = [
                spring.frame @ np.diag([laws.get(word, 0.0) for word in MOTIONS[:3]]) @ spring.frame.T
                for laws in (spring.stiffness, spring.damping)
            ]
            first, total = totals.get(tuple(point), (index, np.zeros((2, 3, 3))))
            totals[tuple(point)] = first, total + np.array(both)
    turn = skew(np.asarray(settings.spin, dtype=float)) if settings.driven else np.zeros((3, 3))
    for index, matrices in totals.values():
        if (
            np.abs(turn @ matrices - matrices @ turn).max()
            > PARALLEL * np.abs(matrices).max() * np.abs(turn).max()
        ):
            why = "it is not the same in all directions across the axis, so it changes while everything turns"
            yield Fault(f"springs[{index}]", model.springs[index].label, why, advice)


def _load(index: int, load: AnyLoad, problem: Problem, settings: SteadySettings) -> Iterator[Fault]:
    """Refuse a load that does not stay as it is while everything turns."""
    kind, where = load.word, f"loads[{index}]"
    if load.until is not None and load.until <= 0.0:
        return  # gone
    if not settings.driven:
        yield Fault(
            where,
            kind,
            "a rod that turns freely is free of load",
            "leave it out, or give spin as three numbers",
        )
        return
    if load.travels:
        yield Fault(where, kind, "it travels along the rod", "leave it out")
        return
    if load.until is not None or not (load.time is None or isinstance(load.time, Constant)):
        yield Fault(where, kind, "it changes with time", "leave out time and until")
        return
    if any(placed.load == index for placed in problem.station_loads):
        yield Fault(
            where,
            kind,
            "it acts between nodes, and a steady rotation takes loads at nodes only",
            "leave out elements, so that one ends there",
        )
        return
    sees_motion = [placed for placed in problem.motion_loads if placed.load == index]
    if sees_motion:
        yield from _sees_motion(where, kind, sees_motion[0].law, settings)
        return
    if load.follows:
        return
    if settings.formulation == "intrinsic":
        yield Fault(
            where,
            kind,
            "it keeps its direction in space, which the intrinsic formulation does not know",
            "leave out formulation, or let it follow (following = true)",
        )
        return
    spin = np.asarray(settings.spin, dtype=float)
    nodal = [placed for placed in problem.nodal_loads if placed.load == index]
    vectors = [placed.dead.reshape(-1, 3) for placed in nodal] + [placed.gravity for placed in nodal]
    if _across(np.vstack(vectors), spin):
        yield Fault(
            where,
            kind,
            "it is not parallel to the axis, so it does not stay as it is while everything turns",
            "give a load along the axis, or one that follows",
        )


def _sees_motion(where: str, kind: str, law: MotionLaw, settings: SteadySettings) -> Iterator[Fault]:
    """Refuse a load that sees motion and may change while everything turns."""
    if settings.formulation == "intrinsic":
        why = "it sees the motion, and the intrinsic formulation has no such loads in steady rotations"
        yield Fault(where, kind, why, "leave out formulation, for the geometric one")
    elif not isinstance(law, CompiledLaw):
        why = "it is a Python function of position and rotation, which may change while everything turns"
        yield Fault(where, kind, why, "compute the motion with simulate")
    elif _across(np.array([law.axis]), np.asarray(settings.spin, dtype=float)):
        why = "the medium moves across the axis, so its drag does not stay as it is while everything turns"
        yield Fault(where, kind, why, "give a velocity along the axis, or none; or compute it with simulate")


def _across(vectors: Floats, spin: Floats) -> bool:
    """Return whether any of ``vectors (m, 3)`` has a part across ``spin``."""
    axis = spin / np.linalg.norm(spin)
    across = vectors - np.outer(vectors @ axis, axis)
    return bool(np.abs(across).max(initial=0.0) > PARALLEL * np.abs(vectors).max(initial=0.0))


def _intrinsic_supports(
    model: ModelDescription, problem: Problem, settings: SteadySettings
) -> Iterator[Fault]:
    supports = problem.supports
    chains = 1 + sum(e.order * len(e.nodes) for e in problem.sets)
    if len(supports.names) > 1 or problem.size != chains:
        # strains and velocities do not say by how much the ends of a chain turned about the axis, or moved along it
        yield Fault(
            "supports" if len(supports.names) > 1 else "rods",
            ", ".join(_label(model, name) for name in supports.names[1:]),
            "without positions nothing keeps a second support, or a closed ring of rods, together",
            "leave out formulation, for the geometric one",
        )
        return
    for k, name in enumerate(supports.names):
        fixed = supports.fixed[k]
        if fixed.all():
            continue
        advice = "leave out formulation, for the geometric one"
        if not (fixed[:3].all() and not fixed[3:].any()):
            yield Fault(
                "supports",
                _label(model, name),
                "the intrinsic formulation knows clamps and ball joints: other supports hold directions in space",
                advice,
            )
            continue
        if settings.driven and settings.centre is not None:
            arm = problem.positions[supports.nodes[k]] - np.asarray(settings.centre)
            spin = np.asarray(settings.spin)
            if np.linalg.norm(np.cross(arm, spin)) > PARALLEL * problem.length * np.linalg.norm(spin):
                yield Fault(
                    "supports",
                    _label(model, name),
                    "off the axis it moves in a direction in space, which the intrinsic formulation does not know",
                    advice,
                )


def _label(model: ModelDescription, place: str) -> str:
    """Return kind and place of a support."""
    return next((support.label for support in model.supports if str(support.at) == place), place)


def no_loads(loads: LoadState) -> bool:
    """Return whether nothing acts (loads may be there with the factor 0)."""
    acts = loads.dead.any() or loads.following.any() or loads.gravity.any() or loads.sees_motion
    return not acts
