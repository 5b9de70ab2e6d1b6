"""Derivatives of all gaps by the motions of the nodes, as a sparse matrix."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.constraints import Constraints
from viscorod.solve.formulations.system import State
from viscorod.typing import Floats, Integers


def gradients_of_gaps(
    constraints: Constraints, state: State, held_rows: tuple[Integers, Floats] | None
) -> sparse.csr_array:
    """Return the derivatives of held coordinates and strains by body increments ``(rows, 6 n)``.

    Args:
        held_rows: orders of all elements and the change of their strains, see ``add_held_strains``.
    """
    problem, held, arrays = constraints.problem, constraints.held, constraints.arrays
    mine = np.flatnonzero(constraints.is_held)
    gradients = constraints.measure(state)[2][mine].reshape(-1, 2, 6)
    nodes = arrays.nodes[mine]
    present = nodes >= 0
    rows = [np.repeat(np.broadcast_to(arrays.place[mine][:, None], nodes.shape)[present], 6)]
    columns = [(6 * nodes[present][:, None] + np.arange(6)).ravel()]
    values = [gradients[present].ravel()]
    if held_rows is not None:
        orders, B = held_rows
        members = constraints.elements.nodes
        own = np.repeat(np.arange(members.shape[1]) <= orders[held.element][:, None], 6, axis=1)
        found = B[held.element, 6 * held.point + held.component]
        at = (6 * members[held.element][:, :, None] + np.arange(6)).reshape(found.shape)
        rows.append(np.broadcast_to(held.place[:, None], found.shape)[own])
        columns.append(at[own])
        values.append(found[own])
    shape = (6 * problem.multipliers, 6 * problem.size)
    flat = [np.concatenate(parts) for parts in (values, rows, columns)]
    whole = sparse.coo_array((flat[0], (flat[1], flat[2])), shape=shape).tocsr()
    return sparse.csr_array(whole[constraints.used])
