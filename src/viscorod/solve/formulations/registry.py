"""Formulations by name, and what each of them can do. A new one implements ``System`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from viscorod.solve.deferred import deferred

if TYPE_CHECKING:
    from viscorod.solve.formulations.system import System
    from viscorod.solve.problem.problem import Problem


class Formulation(NamedTuple):
    """What a formulation with one kind of damping can do.

    Attributes:
        make: returns the :class:`~viscorod.solve.formulations.system.System` of a discretised model.
        branches: it has Maxwell branches.
        linear: it has linear dynamics.
        laws: it has laws of sections.
    """

    make: Callable[[Problem], System]
    branches: bool = True
    linear: bool = False
    laws: bool = True


_INTRINSIC = deferred("formulations.intrinsic_system:IntrinsicSystem")

FORMULATIONS: dict[tuple[str, str], Formulation] = {
    ("geometric", "full"): Formulation(deferred("formulations.geometric_system:GeometricSystem")),
    ("intrinsic", "full"): Formulation(_INTRINSIC),
    ("intrinsic", "linearised"): Formulation(
        partial(_INTRINSIC, linearised=True), branches=False, linear=True, laws=False
    ),
}
"""By formulation and damping."""


def formulation_words() -> list[str]:
    """Return the words of the formulations, each once."""
    return list(dict.fromkeys(formulation for formulation, _ in FORMULATIONS))


def damping_words() -> list[str]:
    """Return the words of the kinds of damping, each once."""
    return list(dict.fromkeys(damping for _, damping in FORMULATIONS))


def dampings(formulation: str) -> dict[str, Formulation]:
    """Return the kinds of damping of a formulation."""
    return {damping: kind for (name, damping), kind in FORMULATIONS.items() if name == formulation}
