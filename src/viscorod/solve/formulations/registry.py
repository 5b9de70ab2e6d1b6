"""Formulations by name. A new one implements ``System`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.intrinsic_system import IntrinsicSystem
from viscorod.solve.formulations.system import System
from viscorod.solve.problem.problem import Problem

FORMULATIONS: dict[tuple[str, str], Callable[[Problem], System]] = {
    ("geometric", "full"): GeometricSystem,
    ("intrinsic", "full"): IntrinsicSystem,
    ("intrinsic", "linearised"): partial(IntrinsicSystem, linearised=True),
}
"""By formulation and damping."""
