"""The time step when the user gives none."""

from __future__ import annotations

import numpy as np

from viscorod.solve.problem import Problem
from viscorod.typing import Floats

PER_FIRST = 200
PER_THIRD = 20
PER_LOAD_PERIOD = 50
PER_RUN = 100


def distinct(frequencies: Floats, tolerance: float = 0.01) -> Floats:
    """Nonzero frequencies without repetitions (equal bending planes give pairs)."""
    kept: list[float] = []
    for f in np.sort(frequencies):
        if f > 0.0 and (not kept or f > kept[-1] * (1.0 + tolerance)):
            kept.append(float(f))
    return np.array(kept)


def chosen_time_step(problem: Problem, frequencies: Floats, duration: float) -> float:
    """Return a step [s] that resolves the motion.

    It is the smallest of 1/200 of the longest natural period, 1/20 of the third distinct one, 1/50 of the period
    of a harmonic
    load or motion and 1/100 of the run.

    Args:
        problem: for the periods of loads.
        frequencies: lowest angular frequencies of small vibrations about the initial state [rad/s], zeros ignored.
        duration: simulated time [s].
    """
    candidates = [duration / PER_RUN, *(period / PER_LOAD_PERIOD for period in problem.periods)]
    elastic = distinct(frequencies)
    if len(elastic):
        candidates.append(2.0 * np.pi / elastic[0] / PER_FIRST)
        candidates.append(2.0 * np.pi / elastic[min(2, len(elastic) - 1)] / PER_THIRD)
    return float(min(candidates))
