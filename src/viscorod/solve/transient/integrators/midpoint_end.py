"""The end of a step of the midpoint rule: poses there, and supports that hold there."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import part
from viscorod.mechanics.nodes.support_rows import SupportedNodes, in_body
from viscorod.mechanics.rotations.nodal_motion import place
from viscorod.solve.transient.integrators.stage_data import Discretisation, StepStart, SupportMotion
from viscorod.solve.transient.integrators.step_task import Ends
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
def take_gaps(supports: SupportedNodes, gap: Floats, residual: Floats) -> None:
    """Put the gaps of supports at the end of the step ``(n, 6)`` into the residual of its middle ``(1, n, 6)``."""
    nodes, fixed, axes = supports[:3]
    for m in range(nodes.shape[0]):
        for a in range(6):
            # velocities along moving axes are held in the middle
            if fixed[m, a] != 0.0 and not in_body(axes[m]):
                residual[0, nodes[m], a] = 0.5 * gap[nodes[m], a]
