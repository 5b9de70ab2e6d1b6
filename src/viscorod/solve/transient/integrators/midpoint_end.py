"""The end of a step of the midpoint rule: poses there, and supports that hold there."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.nodes.support_rows import Directions, SupportedNodes, impose, in_body
from viscorod.mechanics.rotations.nodal_motion import place
from viscorod.solve.transient.integrators.stage_data import Discretisation, Ends, StepStart, SupportMotion
from viscorod.typing import Floats


@part
def place_end(
    body: Discretisation,
    motion: SupportMotion,
    start: StepStart,
    X: Floats,
    double: Floats,
    still: Floats,
    ends: Ends,
) -> None:
    """Write the poses at the end of a step of the midpoint rule, where the coordinates are ``2 X``.

    Args:
        X: coordinates in the middle ``(1, n, 6)``; double, still: scratch ``(6,)``.
    """
    nodes, complete = body.supports.nodes, body.complete
    for k in range(X.shape[1]):
        for a in range(6):
            double[a] = 2.0 * X[0, k, a]
            still[a] = 0.0
        if body.held[k] == 0.0:
            apart = body.split[k] != 0.0
            place(start.r[k], start.q[k], double, still, apart, ends.r[0, k], ends.q[0, k], ends.twist[0, k])
    for m in range(nodes.shape[0]):
        if complete[m] != 0.0:
            k = nodes[m]
            for a in range(3):
                ends.r[0, k, a] = motion.end_r[m, a]
            for a in range(4):
                ends.q[0, k, a] = motion.end_q[m, a]


@part
def strains_at_end(start: Floats, middle: Floats, end: Floats) -> None:
    """Write the strains at the end of a step ``(1, e, points, 6)`` from those at its start and in its middle."""
    for e in range(start.shape[0]):
        for g in range(start.shape[1]):
            for a in range(6):
                end[0, e, g, a] = 2.0 * middle[0, e, g, a] - start[e, g, a]


@part
def hold_ends(
    supports: SupportedNodes,
    target: Floats,
    ends: Ends,
    gap: Floats,
    reaction: Floats,
    directions: Directions,
    residual: Floats,
) -> None:
    """Hold nodes at their targets at the end of the step rather than in its middle.

    Args:
        target: ``(1, m, 6)``; gap: scratch ``(n, 6)``; reaction, directions: scratch.
        residual: of the middle ``(1, n, 6)``, held components are replaced.
    """
    nodes, fixed, axes = supports[:3]
    for m in range(nodes.shape[0]):
        for a in range(6):
            gap[nodes[m], a] = 0.0
    impose(supports, target[0], ends.r[0], ends.q[0], gap, reaction, directions)
    for m in range(nodes.shape[0]):
        for a in range(6):
            # velocities along moving axes are held in the middle
            if fixed[m, a] != 0.0 and not in_body(axes[m]):
                residual[0, nodes[m], a] = 0.5 * gap[nodes[m], a]
