"""Which models are planar straight beams, and in which plane; the others are refused by name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.solve.planar.planar_beam import Plane, nodal_loads
from viscorod.solve.problem.external_loads import LoadState
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["plane_of", "require_planar"]

STRAIGHT = 1e-9
"""Departure from a straight line, from one orientation and from one plane, that is round-off."""
MOST_NODES = 400
"""Nodes up to which the full matrices of these theories are computed."""
_LEAVE_OUT = "leave it out; only the exact theory has it"


def require_planar(model: ModelDescription, problem: Problem, *, moving: bool) -> None:
    """Refuse what is no straight beam with dead loads and fixed supports; motions also Maxwell branches.

    Raises:
        InputError: with everything that does not fit.
    """
    faults = list(_unfit(model, problem, moving=moving))
    if faults:
        raise InputError(faults)


def _unfit(model: ModelDescription, problem: Problem, *, moving: bool) -> Iterator[Fault]:
    yield from _unfit_parts(model)
    yield from _unfit_actions(model, problem)
    for name, rod in model.rods.items():
        where = f"rods.{name}"
        if rod.law is not None:
            yield Fault(
                f"{where}.law", type(rod.law).__name__, "these theories have linear sections only", _LEAVE_OUT
            )
        if moving and rod.relaxing:
            why = "motions of these theories have Kelvin-Voigt damping only"
            yield Fault(where, "Maxwell branches", why, "give Kelvin-Voigt damping, or compare equilibria")
        held = [word for word in rod.constraints if not word.startswith("shear")]
        if held:
            yield Fault(f"{where}.constraints", show(held), "these theories can hold shear only", _LEAVE_OUT)
    line = problem.positions - problem.positions[0]
    along = line @ Plane.of(problem, 0).tangent
    bent = np.abs(line - np.outer(along, Plane.of(problem, 0).tangent)).max() > STRAIGHT * problem.length
    turned = 1.0 - np.abs(problem.quaternions @ problem.quaternions[0]).min() > STRAIGHT
    if len(model.rods) == 1 and (bent or turned):
        why = "these theories are those of straight beams whose sections are not turned along them"
        yield Fault(f"rods.{next(iter(model.rods))}", "curved or twisted", why, _LEAVE_OUT)
    if problem.size > MOST_NODES:
        yield Fault(
            "rods",
            f"{problem.size} nodes",
            "these theories are computed with full matrices",
            f"give fewer elements, {MOST_NODES} nodes at most",
        )


def _unfit_parts(model: ModelDescription) -> Iterator[Fault]:
    """Say which parts other than one rod at rest the model has."""
    only = "the theories of planar straight beams are those of one rod"
    if len(model.rods) != 1:
        yield Fault("rods", f"{len(model.rods)} rods", only, "give a model with one rod")
    for key in ("bodies", "attachments", "joints", "springs"):
        if found := getattr(model, key):
            yield Fault(key, f"{len(found)}", f"{only}, without {key}", _LEAVE_OUT)
    for key in ("velocities", "strains", "rest_strains"):
        if found := getattr(model, key):
            yield Fault(key, f"{len(found)}", "these theories begin unstrained and at rest", _LEAVE_OUT)


def _unfit_actions(model: ModelDescription, problem: Problem) -> Iterator[Fault]:
    """Say which supports move, and which loads turn with the rod or see its motion."""
    for index, support in enumerate(model.supports):
        if support.motion or problem.supports.in_body.any():
            why = "in these theories supports stay where they are"
            yield Fault(f"supports[{index}]", support.label, why, _LEAVE_OUT)
            break
    following = {load.load for load in problem.nodal_loads if load.following.any()}
    following |= {load.load for load in problem.station_loads if load.following.any()}
    for index, load in enumerate(model.loads):
        if load.sees_motion or index in following:
            why = "in these theories loads keep their directions, and do not see the motion"
            yield Fault(f"loads[{index}]", load.word, why, _LEAVE_OUT)


def plane_of(problem: Problem, loads: Sequence[LoadState]) -> Plane:
    """Return the plane in which loads act; of axial loads alone that of the weaker bending.

    Raises:
        InputError: loads act out of one plane, or the sections couple it with others.
    """
    unit = np.repeat([1.0, 1.0 / problem.length], 3)
    size = np.max([np.abs(nodal_loads(problem, state) * unit).max(axis=0) for state in loads], axis=0)
    planes = [max(size[0], size[4]), max(size[1], size[3])]
    largest = float(size.max())
    if min(planes) > STRAIGHT * largest or size[5] > STRAIGHT * largest:
        raise InputError(
            Fault(
                "loads",
                f"forces up to {size[0]:.4g} N along d1 and {size[1]:.4g} N along d2, torque up to "
                f"{size[5] * problem.length:.4g} N m",
                "loads of a planar beam act in the plane of its axis and of d1, or of d2",
                "turn d1 of the rod into the plane of the loads (key d1), or leave out the others",
            )
        )
    if max(planes) <= STRAIGHT * largest:
        bending = problem.sets[0].stiffness[:, [4, 3], [4, 3]].min(axis=0)
        transverse = int(np.argmin(bending))
    else:
        transverse = int(np.argmax(planes))
    plane = Plane.of(problem, transverse)
    _require_split_supports(problem, plane)
    if _coupled(problem, plane):
        raise InputError(
            Fault(
                "rods",
                "a coupled section",
                "its stiffness, damping or inertia couple motions in the plane with others",
                "give a section whose axes d1 and d2 are its principal axes",
            )
        )
    return plane


def _require_split_supports(problem: Problem, plane: Plane) -> None:
    """Refuse supports that couple motions in the plane with others: what they hold is another thing in a mirror.

    Raises:
        InputError: there is such a support, by name.
    """
    supports = problem.supports
    mirror = np.eye(3) - 2.0 * np.outer(plane.normal, plane.normal)
    for name, axes, fixed in zip(supports.names, supports.axes, supports.fixed, strict=True):
        for held in (fixed[:3], fixed[3:]):
            directions = axes[:, held > 0.0]
            both = np.hstack([directions, mirror @ directions])
            if directions.size and np.linalg.matrix_rank(both, tol=STRAIGHT) > directions.shape[1]:
                raise InputError(
                    Fault(
                        "supports",
                        name,
                        "it holds a direction that is neither in the plane of the beam nor normal to it",
                        "hold directions along and across the beam and normal to its plane",
                    )
                )


def _coupled(problem: Problem, plane: Plane) -> bool:
    (elements,) = problem.sets

    def couples(matrix: Floats, inside: Integers) -> bool:
        outside = np.setdiff1d(np.arange(6), inside)
        size = np.sqrt(np.abs(np.einsum("gii->gi", matrix)))
        scaled = np.abs(matrix) - STRAIGHT * size[:, :, None] * size[:, None, :]
        return bool((scaled[:, inside[:, None], outside] > 0.0).any())

    return (
        couples(elements.stiffness, plane.strains)
        or couples(elements.damping, plane.strains)
        or couples(problem.mass, plane.motions)
    )
