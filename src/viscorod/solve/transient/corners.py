"""Instants at which loads or prescribed motions are not smooth, which steps must hit."""

from __future__ import annotations

from viscorod.solve.problem.problem import Problem

__all__ = ["corners_of"]


def corners_of(problem: Problem, start: float, end: float, *, within: bool) -> tuple[list[float], set[float]]:
    """Return the times from ``start`` to ``end`` [s] that steps must hit, and those after which to restart.

    ``end`` is the last of the former, ``start`` may be one of the latter. Instants that only rounding keeps apart
    are one, the later, but ``start`` where one is next to it. ``within``: rows of records are looked at within steps,
    and are no corners.
    """
    near = 1e-12 * end
    corners = [start]
    jumps: set[float] = set()
    known = problem.breakpoints if within else {*problem.breakpoints, *problem.rows}
    for t in [*sorted(t for t in known if start - near < t < end), end]:
        jumped = t in problem.jumps and t < end
        if t - corners[-1] < near and len(corners) > 1:
            jumped = jumped or corners[-1] in jumps
            corners.pop()
        if t - start >= near:
            corners.append(t)
        if jumped:
            jumps.add(corners[-1])
    return corners[1:], jumps
