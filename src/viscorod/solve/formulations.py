"""Formulations by name. A new one implements ``System`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable

from viscorod.solve.geometric_system import GeometricSystem
from viscorod.solve.problem import Problem
from viscorod.solve.system import System

FORMULATIONS: dict[str, Callable[[Problem], System]] = {"geometric": GeometricSystem}
