"""The end of a step of the midpoint rule: poses there, and supports that hold there."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.nodes import support_rows as supports
from viscorod.mechanics.rotations.nodal_motion import place
from viscorod.typing import Floats, Integers


@part
def place_end(
    r0: Floats,
    q0: Floats,
    X: Floats,
    split: Floats,
    held: Floats,
    nodes: Integers,
    complete: Floats,
    given_r: Floats,
    given_q: Floats,
    double: Floats,
    still: Floats,
    r: Floats,
    q: Floats,
    twist: Floats,
) -> None:
    """Write the poses at the end of a step of the midpoint rule, where the coordinates are ``2 X``.

    Args:
        r0, q0: poses at the start ``(n, ...)``; X: coordinates in the middle ``(1, n, 6)``.
        given_r, given_q: poses of completely held supports at the end ``(m, ...)``.
        double, still: scratch ``(6,)``; r, q, twist: outputs ``(1, n, ...)``; the twists are not used.
    """
    for k in range(X.shape[1]):
        for a in range(6):
            double[a] = 2.0 * X[0, k, a]
            still[a] = 0.0
        if held[k] == 0.0:
            place(r0[k], q0[k], double, still, split[k] != 0.0, r[0, k], q[0, k], twist[0, k])
    for m in range(nodes.shape[0]):
        if complete[m] != 0.0:
            k = nodes[m]
            for a in range(3):
                r[0, k, a] = given_r[m, a]
            for a in range(4):
                q[0, k, a] = given_q[m, a]


@part
def hold_ends(
    nodes: Integers,
    fixed: Floats,
    axes: Floats,
    r0: Floats,
    q0: Floats,
    target: Floats,
    r: Floats,
    q: Floats,
    gap: Floats,
    reaction: Floats,
    G: Floats,
    Z: Floats,
    psi: Floats,
    residual: Floats,
) -> None:
    """Hold nodes at their targets at the end of the step rather than in its middle.

    Args:
        target: ``(1, m, 6)``; r, q: poses at the end ``(1, n, ...)``; gap: scratch ``(n, 6)``.
        residual: of the middle ``(1, n, 6)``, held components are replaced; the rest as in ``supports.impose``.
    """
    for m in range(nodes.shape[0]):
        for a in range(6):
            gap[nodes[m], a] = 0.0
    supports.impose(nodes, fixed, axes, r0, q0, target[0], r[0], q[0], gap, reaction, G, Z, psi)
    for m in range(nodes.shape[0]):
        for a in range(6):
            # velocities along moving axes are held in the middle
            if fixed[m, a] != 0.0 and not supports.in_body(axes[m]):
                residual[0, nodes[m], a] = 0.5 * gap[nodes[m], a]
