"""The intrinsic formulation of a whole problem (AWP): only motions differ from those of the geometric one.

Statics, and the strains that a motion starts from, are those of the geometric formulation.
"""

from __future__ import annotations

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.formulations.element_forces import ElementForces, IntrinsicForces
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.problem.problem import Problem


class IntrinsicSystem(GeometricSystem):
    """Keeps strains as states while a body moves.

    Args:
        problem: the discretised model.
        linearised: damping is the linearised one of AWP (22), else the full one of AWP (13).
    """

    def __init__(self, problem: Problem, *, linearised: bool = False) -> None:
        super().__init__(problem)
        self.linearised = linearised

    def element_forces(self, elements: Elements, stages: int) -> ElementForces:
        """See :class:`~viscorod.solve.formulations.system.System`."""
        return IntrinsicForces(self, elements, stages, linearised=self.linearised)
