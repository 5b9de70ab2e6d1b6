"""Which unknowns the linear systems of a motion are solved for: those of nodes that move, in a plane of symmetry."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.history import Snapshot
from viscorod.solve.linear.plan import Plan
from viscorod.solve.problem.mirror_plane import MirrorPlane, find_mirror_plane, free_unknowns
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.statics.plane_stability import growth_out_of_plane
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.typing import Floats

__all__ = ["MotionUnknowns", "motion_unknowns"]

GROWN = float(np.log(100.0))
"""Exponent of growth out of the plane from which on it is told."""
MOST = 36.0
"""From which on rounding would become a motion, in space."""


class MotionUnknowns(NamedTuple):
    """How the linear systems of a motion are solved, a word on its symmetry, and the plane of this, if there is one."""

    plan: Plan
    symmetry: str
    plane: MirrorPlane | None = None

    def doubt(self, static: StaticSolver, states: Sequence[tuple[float, Snapshot]]) -> str:
        """Return a warning if some of the states of a motion [s] are unstable out of the plane, else nothing."""
        if self.plane is None:
            return ""
        exponent, begin = growth_out_of_plane(static, self.plane, states)
        if exponent < GROWN:
            return ""
        return (
            f"the motion stays in its plane of symmetry, normal to {self.plane.direction}, which is unstable from "
            f"t = {begin:.3g} s on: what is next to the plane gets {_factor(exponent)} times as far from it until the "
            'end; give a small load across, or symmetry = "ignored", to see where it goes'
        )


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
        plane, why = find_mirror_plane(problem, discrete.system.elements(), state, _given_strain(discrete))
        symmetry = f"none: {why}" if plane is None else f"about the plane normal to {plane.direction}"
    unknowns = free_unknowns(problem) if plane is None else plane.unknowns(problem)
    plan = problem.plan if unknowns is None else Plan.of(problem.pattern, problem.interiors, unknowns)
    return MotionUnknowns(plan, symmetry, plane)


def _given_strain(discrete: DiscreteModel) -> Floats | None:
    """Return the strains that a motion starts with, in the arrays of elements, if they are given."""
    system = discrete.system
    if system.given_strain is None:
        return None
    found = np.zeros_like(system.elements().reference)
    found.reshape(-1, 6)[system.gauss_indices()] = system.given_strain
    return found


def _factor(exponent: float) -> str:
    """Say what something grows by."""
    return f"{np.exp(exponent):.1g}" if exponent < MOST else f"more than {np.exp(MOST):.0g}"
