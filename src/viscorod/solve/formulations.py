"""Formulations by name. A new one implements ``System`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from viscorod.solve.geometric_system import GeometricSystem
from viscorod.solve.intrinsic_system import IntrinsicSystem
from viscorod.solve.problem import Problem
from viscorod.solve.system import System

FORMULATIONS: dict[tuple[str, str], Callable[[Problem], System]] = {
    ("geometric", "full"): GeometricSystem,
    ("intrinsic", "full"): IntrinsicSystem,
    ("intrinsic", "linearised"): partial(IntrinsicSystem, linearised=True),
}
"""By formulation and damping."""
