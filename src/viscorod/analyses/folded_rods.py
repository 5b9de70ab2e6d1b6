"""Motions whose elements fold: a mesh that is too coarse for a shape lets its sections pass through each other.

A linear material law takes finite work for that, so nothing stops it, and what follows is no motion of a rod: its
elements snap to and fro, with steps of nanoseconds. Shorter elements bend in their place.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.errors import SolveError
from viscorod.results.run import Run
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.integrators.contract import Integrator

__all__ = ["FOLDED", "folded", "on_unfolded"]

FOLDED = "an element folds"
MOST_HALVINGS = 4
"""Times that elements are halved at most: what folds on these too is pressed so by its loads."""
PRESSED = 0.5
"""Compression or shear from which on an element counts as folded: no material law for rods reaches as far."""


def folded(integrator: Integrator) -> bool:
    """Return whether an element is pressed together or sheared as no rod is that bends instead."""
    if integrator.strain < PRESSED:
        return False
    shear, stretch = np.split(integrator.snapshot().strain[:, :3], [2], axis=1)
    return bool((stretch <= -PRESSED).any() or (np.abs(shear) >= PRESSED).any())


def on_unfolded(
    analysis: Callable[[DiscreteModel, SimulateSettings], Run],
    discrete: DiscreteModel,
    settings: SimulateSettings,
) -> tuple[Run, DiscreteModel]:
    """Compute a motion, on elements half as long where it folds those that the program chose.

    Returns:
        the run, and the model on the mesh that it has.
    """
    plain = discrete
    for _ in range(MOST_HALVINGS + 1):
        finer = discrete.watch.halved()
        if finer is None:
            break
        try:
            watched = replace(discrete, options=replace(discrete.options, stop_folded=True))
            return analysis(watched, settings), discrete
        except SolveError as error:
            if not error.coarse:
                raise
        logging.getLogger("viscorod").info(
            "viscorod: the mesh is too coarse, its elements fold; again on a finer one"
        )
        anew = replace(discrete.options, resume=False)
        plain, discrete = plain.renewed(anew, {}), discrete.on_mesh(finer).renewed(anew, {})
    return analysis(plain, settings), plain
