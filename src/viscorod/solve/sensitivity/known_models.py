"""Which models and methods have derivatives by the arrays of the problem."""

from __future__ import annotations

from viscorod.errors import InputError
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.problem.problem import Problem
from viscorod.solve.transient.integrators.collocation import Collocation

__all__ = ["require_differentiable", "require_linearisable"]


def require_differentiable(problem: Problem) -> None:
    """Refuse a model with parts whose derivatives by the arrays are not known here.

    Raises:
        InputError: it has loads that are records.
    """
    if problem.records:
        raise InputError(
            "derivatives are not known for models with loads that are records; take differences of two runs"
        )


def require_linearisable(integrator: Collocation) -> None:
    """Refuse an integrator or a model whose steps cannot be linearised here.

    Raises:
        InputError: it is not a collocation method that ends with its last stage, in the geometric formulation, or the
            model has supports that hold velocities along the axes of a node, or what has no derivatives in statics.
    """
    problem = integrator.system.problem
    require_differentiable(problem)
    parts = {
        "supports that hold velocities along the axes of their place": integrator.supports.set.in_body[
            integrator.supports.partial
        ].any(),
        "the midpoint rule": len(integrator.ends.r) > 0,
        "rest strains that change with time": integrator.system.imposed.changes,
        "the intrinsic formulation": not isinstance(integrator.system, GeometricSystem)
        or integrator.forces.motion is not None,
    }
    for part, there in parts.items():
        if there:
            raise InputError(
                f"derivatives of motions are not known with {part}; take differences of two runs"
            )
