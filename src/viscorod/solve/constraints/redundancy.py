"""Conditions that others imply already: joints, held strains and supports that hold the same motion twice."""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from viscorod.errors import Fault, InputError
from viscorod.solve.constraints.null_space import dependent_rows
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State, System
from viscorod.typing import Floats

CLEAR = 1e-10
"""Square of the part of a condition, of unit length, that others leave of it, above which it is surely independent."""

STRAINS = ("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist")


def require_independent(system: System, supports: SupportState) -> None:
    """Refuse conditions that depend on each other in the reference shape: their forces would be undetermined.

    Raises:
        InputError: with the condition and those that imply it.
    """
    problem = system.problem
    if system.constraints.rows == 0:
        return
    state = State.reference(problem)
    unit = sparse.diags_array(np.tile(np.repeat([problem.length, 1.0], 3), problem.size))
    # joints last: rather they are in doubt than what they join
    own = np.argsort(np.isin(system.constraints.used, problem.joints.arrays.place), kind="stable")
    gradients = sparse.csr_array(system.constraint_gradients(state)[own] @ unit)
    held = sparse.csr_array(_support_gradients(system, supports, state) @ unit)
    rows = _normalised(sparse.csr_array(sparse.vstack([held, gradients])))
    if _clearly_independent(rows):
        return
    dependent = dependent_rows(rows)
    dependent = dependent[dependent >= held.shape[0]]
    if len(dependent) == 0:
        return
    named = _names(system)
    names = [*_support_names(supports), *(named[k] for k in own)]
    row = int(dependent[0])
    before = [k for k in range(row) if k not in set(dependent.tolist())]
    dense = rows.toarray()
    weights = np.linalg.lstsq(dense[before].T, dense[row], rcond=None)[0]
    # without motion words: who holds, not what, leads to the remedy
    others = dict.fromkeys(
        names[k].split(",")[0] for k, w in zip(before, weights, strict=True) if abs(w) > 1e-6
    )
    listed = [name for name in others if name != names[row].split(",")[0]]
    shown = "; ".join(listed[:6]) + (f" and {len(listed) - 6} more" if len(listed) > 6 else "")
    raise InputError(
        Fault(
            "joints" if names[row].startswith("joint") else "rods",
            names[row],
            (
                f"in the reference shape this is held already by {shown}"
                if listed
                else "nothing is left to hold here"
            )
            + _open_by(system, names[row]),
            "let one of them leave that motion free (a joint of kind 'general' with a list of free motions), "
            "or make a part between them flexible",
        )
    )


def _open_by(system: System, name: str) -> str:
    """Say in words how far the joint of a condition is open in the reference shape; return "" if it is closed."""
    for text in system.constraints.open_joints():
        joint, _, gap = text.rpartition(", ")
        if name.rpartition(",")[0] == f"joint {joint}":
            return f"; the joint is open there, {gap}, which nothing can close"
    return ""


def _support_gradients(system: System, supports: SupportState, state: State) -> sparse.csr_array:
    """Return the derivatives of the held motions of supports by body increments ``(rows, 6 n)``."""
    problem = system.problem
    rows, columns, values = [], [], []
    count = 0
    for k, node in enumerate(supports.set.nodes):
        for row in supports.motion_gradients(k, state)[supports.set.fixed[k] > 0.0]:
            rows.append(np.full(6, count))
            columns.append(6 * int(node) + np.arange(6))
            values.append(row)
            count += 1
    shape = (count, 6 * problem.size)
    if count == 0:
        return sparse.csr_array(shape)
    flat = (np.concatenate(rows), np.concatenate(columns))
    return sparse.csr_array(sparse.coo_array((np.concatenate(values), flat), shape=shape))


def _normalised(rows: sparse.csr_array) -> sparse.csr_array:
    size = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=1)).ravel())
    return sparse.csr_array(sparse.diags_array(1.0 / np.where(size > 0.0, size, 1.0)) @ rows)


def _clearly_independent(rows: sparse.csr_array) -> bool:
    """Return whether all pivots of the Gram matrix, the squared independent parts of the rows, exceed round-off."""
    gram = sparse.csc_array(rows @ rows.T)
    try:
        factor = splu(
            gram, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:
        return False
    pivots: Floats = factor.U.diagonal()
    return bool(pivots.min(initial=1.0) > CLEAR)


def _support_names(supports: SupportState) -> list[str]:
    found: list[str] = []
    for k, name in enumerate(supports.set.names):
        found += [f"the support of {name}"] * int(supports.set.fixed[k].sum())
    return found


def _names(system: System) -> list[str]:
    """Name every condition, in the order of its multiplier."""
    problem, constraints = system.problem, system.constraints
    names: dict[int, str] = {}
    for c in np.flatnonzero(constraints.is_held):
        names[int(constraints.arrays.place[c])] = f"joint {problem.joints.label(int(c))}"
    rods = np.concatenate([e.rod for e in problem.sets])
    held = problem.held
    for element, component, place in zip(held.element, held.component, held.place, strict=True):
        names[int(place)] = f"rod {problem.rods[rods[element]]}, which holds its {STRAINS[component]}"
    return [names[int(place)] for place in constraints.used]
