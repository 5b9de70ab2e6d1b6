"""What a number changes of a discretised problem: arrays that a gradient is known by, loads, or anything else."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from functools import partial
from types import FunctionType, MethodType
from typing import Any

import numpy as np

from viscorod.analyses.derivatives.neighbours import Neighbour, Neighbours
from viscorod.solve.problem.element_arrays import all_branches
from viscorod.solve.problem.problem import ElementSet, Problem
from viscorod.solve.sensitivity.array_changes import ArrayChanges

__all__ = ["Kind", "array_changes", "kind_of"]

ARRAYS = {
    "relaxation_times",
    "sets.branches",
    "mass",
    "sets.stiffness",
    "sets.damping",
    "sets.half_widths",
    "rest_strains",
    "length",
}
"""Fields that come to the arrays of ``ArrayChanges``, or to nothing that moves."""
KNOWN = ("stiffness", "damping", "mass", "reference", "branches", "times")
"""Fields of ``ArrayChanges`` that come from these."""
LOADS = {"nodal_loads", "station_loads", "motion_loads"}
START = {"initial_twist", "initial_strain"}
"""Fields that only the start of a motion depends on."""


class Kind(Enum):
    """What the balances of a motion change by: section matrices, inertia and strains at rest; loads; or anything."""

    ARRAYS = "arrays"
    LOADS = "loads"
    MORE = "more"


def kind_of(problem: Problem, neighbours: Neighbours) -> Kind:
    """Return what a number changes."""
    differing: set[str] = set()
    for one in neighbours.each:
        differing |= _differing(problem, one.problem)
    differing -= START
    if differing <= ARRAYS:
        return Kind.ARRAYS
    return Kind.LOADS if differing <= LOADS else Kind.MORE


def array_changes(neighbours: Neighbours) -> ArrayChanges:
    """Return the derivatives of the arrays by a number; those of loads are left zero."""

    def array(name: str, one: Neighbour) -> np.ndarray:
        problem = one.problem
        if name in ("stiffness", "damping"):
            return np.concatenate([getattr(elements, name) for elements in problem.sets])
        if name == "reference":  # nodes are where they are: only rest strains may be others
            return (one if problem.rest_strains else one.base).system.elements().reference
        if name == "branches":
            return all_branches(problem)
        return problem.mass if name == "mass" else problem.relaxation_times

    base = neighbours.each[0].base
    none = ArrayChanges.none(base.problem, base.system.elements())
    return none._replace(**{name: neighbours.derivative(partial(array, name)) for name in KNOWN})


def _differing(problem: Problem, other: Problem) -> set[str]:
    """Return the fields in which two problems differ, those of element sets as ``sets.field``."""
    found = set()
    for field in dataclasses.fields(Problem):
        if not field.compare:
            continue
        if field.name == "sets":
            for mine, its in zip(problem.sets, other.sets, strict=True):
                names = [part.name for part in dataclasses.fields(ElementSet)]
                found |= {
                    f"sets.{name}" for name in names if not _same(getattr(mine, name), getattr(its, name))
                }
        elif not _same(getattr(problem, field.name), getattr(other, field.name)):
            found.add(field.name)
    return found


def _same(one: Any, other: Any) -> bool:
    """Return whether two values have the same content; of functions their code, and what they enclose."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, MethodType):
        return one.__func__ is other.__func__ and _same(one.__self__, other.__self__)
    if isinstance(one, FunctionType):
        enclosed = [tuple(cell.cell_contents for cell in f.__closure__ or ()) for f in (one, other)]
        return one.__code__ is other.__code__ and _same(*enclosed)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if dataclasses.is_dataclass(one):
        return all(_same(getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one))
    if hasattr(one, "__dict__") and not callable(one):
        return _same(vars(one), vars(other))
    return bool(one == other)
