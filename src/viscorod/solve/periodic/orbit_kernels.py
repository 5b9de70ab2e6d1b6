"""Poses, coordinates and loads of all nodes at all phases of an orbit, and the blocks of its matrix."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.nodes.applied_loads import add_nodal_loads
from viscorod.mechanics.rotations.nodal_motion import coordinates, place
from viscorod.mechanics.rotations.rotation import retract
from viscorod.typing import Floats, Integers

__all__ = ["add_orbit_blocks", "add_orbit_loads", "add_to_orbit", "place_orbit"]


@kernel
def place_orbit(
    r0: Floats,
    q0: Floats,
    X: Floats,
    rate: Floats,
    split: Floats,
    free: Integers,
    r: Floats,
    q: Floats,
    twist: Floats,
) -> None:
    """Write poses and body twists of the ``free`` nodes at all phases.

    Args:
        r0, q0: poses ``(n, 3)``, ``(n, 4)`` from which coordinates count; X, rate: coordinates and their rates
            ``(N, n, 6)``; split: as for :func:`~viscorod.mechanics.rotations.nodal_motion.place` ``(n,)``.
        r, q, twist: outputs ``(N, n, 3)``, ``(N, n, 4)``, ``(N, n, 6)``.
    """
    for i in range(X.shape[0]):
        for k in free:
            place(r0[k], q0[k], X[i, k], rate[i, k], split[k] != 0.0, r[i, k], q[i, k], twist[i, k])


@kernel
def add_to_orbit(
    r0: Floats,
    q0: Floats,
    X: Floats,
    change: Floats,
    split: Floats,
    free: Integers,
    r: Floats,
    q: Floats,
    unused: Floats,
    found: Floats,
) -> None:
    """Write the coordinates of the ``free`` nodes after body increments.

    Args:
        r0, q0, X, split: as for :func:`place_orbit`; change: increments ``(N, n or more, 6)``.
        r, q, unused: scratch ``(1, 3)``, ``(1, 4)``, zeros ``(2, 6)``.
        found: output ``(N, n, 6)``.
    """
    for i in range(X.shape[0]):
        for k in free:
            apart = split[k] != 0.0
            place(r0[k], q0[k], X[i, k], unused[0], apart, r[0], q[0], unused[1])
            retract(r, q, change[i, k : k + 1], r, q)
            coordinates(r0[k], q0[k], r[0], q[0], apart, found[i, k])


@kernel
def add_orbit_loads(
    nodes: Integers,
    dead: Floats,
    following: Floats,
    gravity: Floats,
    levers: Floats,
    q: Floats,
    mass: Floats,
    external: Floats,
) -> None:
    """Add the loads of nodes at all phases (first index) to ``external (N, n, 6)``; see ``add_nodal_loads``."""
    blocks, diagonal = np.zeros((1, 6, 6)), np.zeros(mass.shape[0], dtype=np.int64)
    for i in range(q.shape[0]):
        add_nodal_loads(
            nodes,
            q[i],
            dead[i],
            following[i],
            gravity[i],
            levers[i],
            mass,
            False,
            external[i],
            blocks,
            diagonal,
        )


@kernel
def add_orbit_blocks(
    blocks: Floats,
    rows: Integers,
    columns: Integers,
    V: Floats,
    row_places: Integers,
    column_places: Integers,
    found: Floats,
) -> None:
    """Add ``blocks V`` to the matrix of an orbit: forces at every phase by changes of twists at every other.

    Args:
        blocks: at all phases ``(N, b, 6, 6)``; rows, columns: of the blocks ``(b,)``.
        V: changes of the twists of the nodes ``(n, N, N, 6, 6)`` by their motions; of rows beyond there is none.
        row_places, column_places: of all motions in the matrix, -1 of those that are not in it ``(6 R,)``.
        found: added to ``(rows, N, columns, N)``.
    """
    for s in range(rows.shape[0]):
        node = columns[s]
        if node >= V.shape[0]:
            continue
        for p in range(V.shape[1]):
            for i in range(6):
                place = row_places[6 * rows[s] + i]
                if place < 0:
                    continue
                for k in range(6):
                    size = blocks[p, s, i, k]
                    if size == 0.0:
                        continue
                    for j in range(6):
                        column = column_places[6 * node + j]
                        if column < 0:
                            continue
                        for m in range(V.shape[2]):
                            found[place, p, column, m] += size * V[node, p, m, k, j]
