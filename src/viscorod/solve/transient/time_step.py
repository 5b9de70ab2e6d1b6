"""Time steps when the user gives none: the first one, and that of integrators with equal steps."""

from __future__ import annotations

import numpy as np

from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

PER_FIRST = 250
"""Methods of second order are then less than 1 % of the amplitude late after 20 periods (midpoint: 0.7 %)."""
PER_THIRD = 20
PER_TURN = 1000
"""Of rigid motions, which last: a body that turns is then off by less than 0.05 % of its motion after 20 turns."""
PER_LOAD_PERIOD = 50
PER_RUN = 100
START_FRACTION = 1e-3
START_MOTION = 1e-3


def distinct(frequencies: Floats, tolerance: float = 0.01) -> Floats:
    """Return nonzero frequencies without repetitions (equal bending planes give pairs)."""
    kept: list[float] = []
    for f in np.sort(frequencies):
        if f > 0.0 and (not kept or f > kept[-1] * (1.0 + tolerance)):
            kept.append(float(f))
    return np.array(kept)


def choose_time_step(problem: Problem, frequencies: Floats, duration: float, rigid: float = 0.0) -> float:
    """Return a step [s] that resolves the motion.

    It is the smallest of 1/250 of the longest natural period, 1/20 of the third distinct one, 1/1000 of that of rigid
    motions, 1/50 of the period of a harmonic load or motion and 1/100 of the run.

    Args:
        problem: for the periods of loads.
        frequencies: lowest angular frequencies of small vibrations about the initial state [rad/s], zeros ignored.
        duration: simulated time [s]; rigid: angular frequency of what rigid motions do [rad/s].
    """
    candidates = [duration / PER_RUN, *(period / PER_LOAD_PERIOD for period in problem.periods)]
    if rigid > 0.0:
        candidates.append(2.0 * np.pi / rigid / PER_TURN)
    elastic = distinct(frequencies)
    if len(elastic):
        candidates.append(2.0 * np.pi / elastic[0] / PER_FIRST)
        candidates.append(2.0 * np.pi / elastic[min(2, len(elastic) - 1)] / PER_THIRD)
    return float(min(candidates))


def first_time_step(
    mass: Floats, force: Floats, twist: Floats, held: Floats, length: float, duration: float
) -> float:
    """Return a cautious first step [s]: nodes move by at most 1e-3 of the length or 1e-3 rad.

    Args:
        mass: nodal inertia ``(n, 6, 6)``; force: what accelerates the nodes; twist: body twists ``(n, 6)``.
        held: 1 at nodes with prescribed motion.
        length: of the model [m]; duration: of the run [s].
    """
    scale = np.array([length] * 3 + [1.0] * 3)
    inertia = np.einsum("nii->ni", mass)
    free = (held[:, None] == 0.0) & (inertia > 0.0)
    fastest = float(np.max(np.abs(force / scale)[free] / inertia[free], initial=0.0))
    speed = float(np.max(np.abs(twist / scale)[held == 0.0], initial=0.0))
    step = START_FRACTION * duration
    if fastest > 0.0:
        step = min(step, np.sqrt(2.0 * START_MOTION / fastest))
    if speed > 0.0:
        step = min(step, START_MOTION / speed)
    return step
