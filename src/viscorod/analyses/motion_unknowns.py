"""Which unknowns the linear systems of a motion are solved for: those of nodes that move, in a plane of symmetry."""

from __future__ import annotations

from typing import NamedTuple

from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.plan import Plan
from viscorod.solve.problem.mirror_plane import MirrorPlane, find_mirror_plane, free_unknowns
from viscorod.solve.settings.motion import SimulateSettings

__all__ = ["MotionUnknowns", "motion_unknowns"]


class MotionUnknowns(NamedTuple):
    """How the linear systems of a motion are solved, and a word on its symmetry."""

    plan: Plan
    symmetry: str


def motion_unknowns(discrete: DiscreteModel, settings: SimulateSettings, state: State) -> MotionUnknowns:
    """Choose the unknowns of a motion.

    Args:
        discrete: the model; settings: of the motion; state: that it starts from.
    """
    problem = discrete.problem
    if settings.dynamics == "linear" or settings.modes is not None:
        return MotionUnknowns(problem.plan, "")
    if discrete.options.derivatives:  # what a number of the model changes need not be symmetric
        return MotionUnknowns(problem.plan, "none: derivatives are asked for")
    plane: MirrorPlane | None = None
    symmetry = "ignored"
    if settings.symmetry == "used":
        system = discrete.system
        plane, why = find_mirror_plane(problem, system.elements(), state, system.given_strain)
        symmetry = f"none: {why}" if plane is None else f"about the plane normal to {plane.direction}"
    unknowns = free_unknowns(problem) if plane is None else plane.unknowns(problem)
    plan = problem.plan if unknowns is None else Plan.of(problem.pattern, problem.interiors, unknowns)
    return MotionUnknowns(plan, symmetry)
