"""Poses and coordinates of all nodes at all phases of an orbit."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.rotations.nodal_motion import coordinates, place
from viscorod.mechanics.rotations.rotation import retract
from viscorod.typing import Floats, Integers

__all__ = ["add_to_orbit", "place_orbit"]


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
