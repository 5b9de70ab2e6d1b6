"""The state of a run as plain data, and back: what a run needs to go on, bit for bit, in another process.

The objects of a run are walked attribute by attribute, but for those that they name as ``unsaved``: what is computed
anew before it is read. What is read back is put into objects that were made anew from
the same model, arrays in place, so that views and compiled code see them. Reading makes objects of the few small
classes named here and of no other; nothing in a file is ever executed.
"""

from __future__ import annotations

import operator
from collections import deque
from functools import cache
from typing import Any

import numpy as np

from viscorod.mechanics.compilation.callback import Callback
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.elements.gauss_batch import ElementGroup
from viscorod.mechanics.elements.held_strains import HeldStrains
from viscorod.mechanics.elements.internal_force import Elements, ElementWork
from viscorod.mechanics.joints.joint_forces import JointLaws, Joints
from viscorod.mechanics.nodes.applied_loads import StationWork
from viscorod.mechanics.nodes.motion_loads import MotionLoads, MotionWork
from viscorod.mechanics.nodes.support_rows import SupportedNodes
from viscorod.solve.constraints.constraints import JointState
from viscorod.solve.formulations.system import GaussPositions, State
from viscorod.solve.history import Snapshot
from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan
from viscorod.solve.linear.stacked_solvers import StackedSolvers
from viscorod.solve.problem.external_loads import ExternalLoads, LoadState
from viscorod.solve.problem.imposed_strains import ImposedStrains
from viscorod.solve.problem.joint_set import JointSet
from viscorod.solve.problem.law_callbacks import LawCallbacks, MotionLaws
from viscorod.solve.problem.problem import ElementSet, Problem, SupportSet
from viscorod.solve.reduced.reduced_loads import ReducedLoads
from viscorod.solve.reduced.reduced_model import ReducedModel
from viscorod.solve.transient.integrators.balance_iteration import BalanceIteration
from viscorod.solve.transient.integrators.momentum_model import Coefficients, Relation, Solution
from viscorod.solve.transient.integrators.record_kernels import Kept, Reading
from viscorod.solve.transient.integrators.stage_data import (
    Discretisation,
    StageFactors,
    StageLoads,
    Stages,
    SupportMotion,
    Work,
)
from viscorod.solve.transient.integrators.step_task import StepAccount
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.solve.transient.load_content import StepContent

SavedTree = Any
"""Nested dicts and lists of arrays, numbers, words, truth values and None."""

MADE: dict[str, type[Any]] = {kind.__name__: kind for kind in (State, Snapshot, JointState)}
"""Classes whose objects come and go in a run: they are made from what was saved."""

UNCHANGED = (
    Problem, ElementSet, SupportSet, Elements, ElementGroup, Discretisation, Pattern, Plan, Tableau, HeldStrains,
    JointSet, LawCallbacks, Joints, JointLaws, SupportedNodes, StepContent, Callback, DirectSolver, ExternalLoads,
    LoadState, MotionLoads, MotionLaws, MotionWork, StationWork, StageFactors, StageLoads, SupportMotion, Work,
    Coefficients, Relation, Solution, GaussPositions, ElementWork, ImposedStrains, StackedSolvers, Reading,
    ReducedModel, ReducedLoads, Kept, Stages, StepAccount, KnownTypes,
    BalanceIteration,
)  # fmt: skip
"""What a run does not change, or makes again from the rest: it is not saved."""

_LEFT_OUT: Any = object()


def saved(value: Any) -> SavedTree:
    """Return the state of an object as plain data."""
    return _saved(value, set())


@cache
def _kind(of: type[Any]) -> str:
    """Return how objects of a class are saved."""
    if issubclass(of, np.generic):
        return "scalar"
    if issubclass(of, bool | int | float | str | None):
        return "plain"
    if issubclass(of, complex):
        return "complex"
    if issubclass(of, np.ndarray):
        return "array"
    # functions and the like, which have no attributes of their own, cannot be saved
    callables = any("__call__" in vars(base) for base in of.__mro__)
    if issubclass(of, UNCHANGED) or hasattr(of, "__get__") or (callables and not of.__dictoffset__):
        return "left out"
    if issubclass(of, dict):
        return "dict"
    if issubclass(of, list | deque) or (issubclass(of, tuple) and not hasattr(of, "_fields")):
        return "sequence"
    return "tuple" if issubclass(of, tuple) else "object"


def _saved(value: Any, seen: set[int]) -> SavedTree:
    of: Any = type(value)
    kind = _kind(of)
    if kind == "plain":
        return value
    if kind == "array":
        return value.copy() if value.dtype != object else _LEFT_OUT
    if kind == "left out":
        return _LEFT_OUT
    if kind == "scalar":
        return _saved(value.item(), seen)
    if kind == "complex":
        return {"kind": "complex", "parts": [value.real, value.imag]}
    if of.__name__ not in MADE:  # one object that many share is saved once; small ones wherever they are
        if id(value) in seen:
            return _LEFT_OUT
        seen.add(id(value))
    if kind == "dict":
        items = [[_saved(part, seen) for part in entry] for entry in value.items()]
        if any(part is _LEFT_OUT for entry in items for part in entry):
            return _LEFT_OUT
        return {"kind": "dict", "items": items}
    if kind == "sequence":
        items = [_saved(item, seen) for item in value]
        if any(item is _LEFT_OUT for item in items):
            return _LEFT_OUT
        return {"kind": "sequence", "type": of.__name__, "items": items}
    fields = (
        dict(zip(value._fields, value, strict=True)) if kind == "tuple" else getattr(value, "__dict__", None)
    )
    if fields is None:
        return _LEFT_OUT
    left: frozenset[str] = getattr(value, "unsaved", frozenset())
    content = {key: _saved(item, seen) for key, item in fields.items() if key not in left}
    return {
        "kind": "object",
        "type": of.__name__,
        "fields": {key: item for key, item in content.items() if item is not _LEFT_OUT},
    }


def restore(value: Any, tree: SavedTree) -> Any:
    """Put back what :func:`saved` returned for an object that was made from the same model, and return it."""
    return _restored(value, tree)


def hand_over(source: Any, target: Any) -> Any:
    """Do what ``restore(target, saved(source))`` does, without a tree between: return ``target`` in that state."""
    return _handed_over(source, target, set())


def _handed_over(source: Any, target: Any, seen: set[int]) -> Any:
    of: Any = type(source)
    if of is np.ndarray and source.dtype.char != "O":
        same = type(target) is of and target.shape == source.shape and target.dtype == source.dtype
        if not same or not target.flags.writeable:
            return source.copy()
        target[...] = source
        return target
    kind = _kind(of)
    if kind == "plain":
        return source
    if kind == "left out":
        if of is KnownTypes:
            target.take_over(source)
        return target
    if of.__name__ in MADE:
        return _copied(source)
    if kind != "tuple" and (kind != "object" or not hasattr(source, "__dict__")):
        tree = _saved(source, seen)
        return target if tree is _LEFT_OUT else _restored(target, tree)
    if id(source) in seen or type(target) is not of:
        return target
    seen.add(id(source))
    if kind == "tuple":
        items = [_handed_over(old, new, seen) for old, new in zip(source, target, strict=True)]
        same = all(map(operator.is_, items, target))
        return target if same else target._make(items)
    left: frozenset[str] = getattr(source, "unsaved", frozenset())
    fields = vars(target)
    for key, item in vars(source).items():
        if key in left:
            continue
        old = fields.get(key)
        new = _handed_over(item, old, seen)
        if new is not old:
            fields[key] = new
    return target


def _copied(value: Any) -> Any:
    """Return a copy of an array, of one of the classes that are made, or what never changes itself."""
    of: Any = type(value)
    if of is np.ndarray:
        return value.copy()
    if of.__name__ not in MADE:
        return value
    fields = value if isinstance(value, tuple) else vars(value).values()
    return of(*map(_copied, fields))


def _restored(value: Any, tree: SavedTree) -> Any:
    """Return what is to stand where ``value`` stands now, which may be that object itself, changed."""
    if isinstance(tree, np.ndarray):
        same = isinstance(value, np.ndarray) and value.shape == tree.shape and value.dtype == tree.dtype
        if same and value.flags.writeable:
            value[...] = tree
            return value
        return tree.copy()
    if not isinstance(tree, dict):
        return tree
    if tree["kind"] == "complex":
        return complex(*tree["parts"])
    if tree["kind"] == "dict":
        known = value if isinstance(value, dict) else {}
        entries = [(_restored(None, key), item) for key, item in tree["items"]]
        items = {key: _restored(known.get(key), item) for key, item in entries}
        known.clear()
        known.update(items)
        return known
    if tree["kind"] == "sequence":
        return _sequence(value, tree)
    if tree["type"] in MADE:  # others may hold the one that is there
        return MADE[tree["type"]](**{key: _restored(None, item) for key, item in tree["fields"].items()})
    if type(value).__name__ != tree["type"]:
        return value
    if hasattr(value, "_replace"):
        fields = value._asdict()
        return value._replace(**{k: _restored(fields[k], item) for k, item in tree["fields"].items()})
    for key, item in tree["fields"].items():
        old = value.__dict__.get(key)
        new = _restored(old, item)
        if new is not old:
            setattr(value, key, new)
    return value


def _sequence(value: Any, tree: SavedTree) -> Any:
    known = list(value) if isinstance(value, tuple | list | deque) else []
    known += [None] * (len(tree["items"]) - len(known))
    items = [_restored(old, item) for old, item in zip(known, tree["items"], strict=False)]
    if tree["type"] == "deque":
        return deque(items, maxlen=value.maxlen if isinstance(value, deque) else None)
    return tuple(items) if tree["type"] == "tuple" else items
