"""Analyses on meshes that the program chooses: repeated on finer ones until the estimated error is as small as wanted."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.settings import Meshed

__all__ = ["refined"]

MOST_MESHES = 12
"""Meshes that are tried at most."""

S = TypeVar("S", bound=Meshed)
R = TypeVar("R")


def refined(analysis: Callable[[DiscreteModel, S], R], discrete: DiscreteModel, settings: S) -> R:
    """Run an analysis, again and again on finer meshes while its estimated error is larger than ``accuracy``.

    Rods whose elements are given keep them.
    """
    result = analysis(discrete, settings)
    for _ in range(MOST_MESHES - 1):
        divisions = discrete.watch.refined(settings.accuracy)
        if divisions is None:
            break
        discrete = discrete.on_mesh(divisions)
        result = analysis(discrete, settings)
    return result
