"""Newton's method on steady rotations, and the ways to one: along a measure, and up a bent branch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.solve.steady.equations import Measure, SteadyEquations, least_squares

TOLERANCE = 1e-10
"""Last change of the unknowns, in sizes of theirs."""
ITERATIONS = 30
SMALLEST_STEP = 1.0 / 1024.0
STALLED = 1e-5
"""Change below which round-off of a stiff rod may keep changes from shrinking further."""
LARGEST_GAP = 1e-4
"""Imbalance, as a part of the forces that balance, beyond which a state that no longer changes is no solution;
round-off of positions is multiplied by the stiffness against stretching."""
GROWTH = 2.0
"""Growth of the elastic energy from one state of a bent branch to the next."""
BRANCH = 40
"""States tried along a bent branch."""


@dataclass
class Effort:
    """What a search took."""

    iterations: int = 0
    gap: float = np.inf


def newton(equations: SteadyEquations, kind: Measure, target: float, effort: Effort) -> bool:
    """Solve for the steady rotation whose measure has a value; False, with the unknowns restored, if that fails."""
    kept = equations.keep()
    if kind == "spin":
        equations.set_spin(target)
    before, smallest = np.inf, np.inf
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            balance = equations.balance()
            value, slope = equations.measure(kind)
            if not (np.isfinite(balance.matrix).all() and np.isfinite(slope).all()):
                break
            sizes = equations.sizes()
            matrix = np.vstack([balance.matrix, slope])
            change = least_squares(matrix, -np.append(balance.residual, value - target), sizes)
            effort.iterations += 1
            size = float(np.abs(change / sizes).max())
            if not size < 1e3:
                break
            equations.move(change)
            stalled = size < STALLED and size > 0.3 * before
            if size < TOLERANCE or stalled:
                _, effort.gap = equations.residual()
                value, _ = equations.measure(kind)
                if effort.gap < LARGEST_GAP and abs(value - target) < 1e-7 * abs(target):
                    return True
                break
            smallest = min(smallest, size)
            if size > 100.0 * smallest and size > 0.1:
                break
            before = size
    equations.restore(kept)
    return False


def follow(
    equations: SteadyEquations, kind: Measure, target: float, effort: Effort, start: float | None = None
) -> bool:
    """Move to the value ``target`` of a measure from where the unknowns are; steps halve where Newton's method fails.

    Args:
        start: the present value, if not that of the measure.
    """
    origin = equations.measure(kind)[0] if start is None else start
    done, step = 0.0, 1.0
    while done < 1.0:
        step = min(step, 1.0 - done)
        if newton(equations, kind, origin + (done + step) * (target - origin), effort):
            done = 1.0 if done + step > 1.0 - 1e-12 else done + step
            step *= 2.0
        else:
            step *= 0.5
            if step < SMALLEST_STEP:
                return False
    return True


def climb(
    equations: SteadyEquations, kind: Measure, target: float, elastic: float, effort: Effort
) -> tuple[bool, tuple[float, float]]:
    """Find the steady rotation with a measure on the bent branch that begins near where the unknowns are.

    The elastic energy, ``elastic`` [J] at first, parametrises the branch, up which the search goes until the measure
    has passed the target.

    Returns:
        whether it was found, and the range of the measure on the branch as far as it was followed.
    """
    values: list[float] = []
    low = high = np.nan
    growth = GROWTH
    if not newton(equations, "elastic", elastic, effort):
        return False, (low, high)
    values.append(equations.measure(kind)[0])
    for _ in range(BRANCH):
        kept = equations.keep()
        if not newton(equations, "elastic", elastic * growth, effort):
            growth = np.sqrt(growth)
            if growth < 1.01:
                break
            continue
        elastic *= growth
        values.append(equations.measure(kind)[0])
        if (values[-1] - target) * (values[-2] - target) <= 0.0:
            nearer = abs(values[-1] - target) < abs(values[-2] - target)
            ends = (equations.keep(), kept) if nearer else (kept, equations.keep())
            for end in ends:
                equations.restore(end)
                if follow(equations, kind, target, effort):
                    return True, (min(values), max(values))
            break
    return False, (min(values), max(values))
