"""Newton's method on steady rotations, and continuation: along a measure, and along a branch of bent shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from viscorod.errors import SolveError
from viscorod.solve.steady.steady_equations import Measure, SteadyEquations, least_squares
from viscorod.typing import Floats

TOLERANCE = 1e-10
"""Last change of the unknowns, in sizes of theirs."""
ITERATIONS = 30
SMALLEST_STEP = 1.0 / 1024.0
FARTHEST = 6
"""Halvings or doublings of a measure that is sought from a state which fits less or more of it."""
STALLED = 1e-5
"""Change below which round-off of a stiff rod may keep changes from shrinking further."""
LARGEST_GAP = 1e-4
"""Imbalance, as a part of the forces that balance, beyond which a state that no longer changes is not a solution;
round-off of positions is multiplied by the stiffness against stretching."""
GROWTH = 2.0
"""Growth of the elastic energy from one state of a bent branch to the next."""
BRANCH = 40
"""States tried up a bent branch."""
DOWN = 16
"""States tried down a bent branch, to 1/65000 of the elastic energy."""


@dataclass
class IterationCounts:
    """Iterations of a search, and how to interrupt it.

    Attributes:
        check_interrupt: called in every iteration; raises what ends the search.
        iterations: so far; gap: imbalance of the last solution.
    """

    check_interrupt: Callable[[], None]
    iterations: int = 0
    gap: float = np.inf


def newton(equations: SteadyEquations, kind: Measure, target: float, effort: IterationCounts) -> bool:
    """Solve for the steady rotation whose measure has a value; False, with the unknowns restored, if that fails."""
    kept = equations.save()
    if kind == "spin":
        equations.set_spin(target)
    before, smallest = np.inf, np.inf
    with np.errstate(all="ignore"):
        for _ in range(ITERATIONS):
            effort.check_interrupt()
            change = equations.change_at_spin() if kind == "spin" else None
            if change is None:
                change = _smallest_change(equations, kind, target)
            if change is None:
                break
            effort.iterations += 1
            size = float(np.abs(change / equations.scales()).max())
            if not size < 1e3:
                break
            equations.update(change)
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


def _smallest_change(equations: SteadyEquations, kind: Measure, target: float) -> Floats | None:
    """Return the smallest change that solves the linearised equations best; None if they are not finite."""
    balance = equations.balance()
    value, slope = equations.measure(kind)
    if not (np.isfinite(balance.matrix.sum()) and np.isfinite(slope).all()):
        return None
    right = -np.append(balance.residual, value - target)
    try:
        return least_squares(balance.with_row(slope), right, equations.scales())
    except SolveError:
        return None


def continue_to(
    equations: SteadyEquations,
    kind: Measure,
    target: float,
    effort: IterationCounts,
    start: float | None = None,
) -> bool:
    """Move to the value ``target`` of a measure from where the unknowns are; steps halve where Newton's method fails.

    Args:
        start: the present value, if not that of the measure.
    """
    origin = equations.measure(kind)[0] if start is None else start
    if origin == target:  # nothing to halve
        return newton(equations, kind, target, effort) or _from_another(equations, kind, target, effort)
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


def _from_another(equations: SteadyEquations, kind: Measure, target: float, effort: IterationCounts) -> bool:
    """Begin with less or more of a measure, where the unknowns fit: a rope at rest is as taut as it hangs."""
    first = equations.save()
    for halvings in range(1, FARTHEST + 1):
        for other in (target / 2.0**halvings, target * 2.0**halvings):
            equations.restore(first)
            if newton(equations, kind, other, effort) and continue_to(equations, kind, target, effort, other):
                return True
    equations.restore(first)
    return False


def search_branch(
    equations: SteadyEquations, kind: Measure, target: float, elastic: float, effort: IterationCounts
) -> tuple[bool, tuple[float, float]]:
    """Find the steady rotation with a measure on the branch of bent shapes near where the unknowns are.

    The elastic energy, ``elastic`` [J] at first, parametrises the branch. The search goes down if the measure is too
    large there (a curved rod bends however slowly it turns; a straight one begins to at a critical speed), and up.

    Returns:
        whether it was found, and the range of the measure on the branch as far as it was followed.
    """
    if not newton(equations, "elastic", elastic, effort):
        return False, (np.nan, np.nan)
    first, values = equations.save(), [equations.measure(kind)[0]]
    downwards = ((1.0 / GROWTH, DOWN),) if values[0] > target else ()
    for growth, count in (*downwards, (GROWTH, BRANCH)):
        equations.restore(first)
        if _step_along_branch(equations, kind, target, elastic, growth, count, values, effort):
            return True, (min(values), max(values))
    return False, (min(values), max(values))


def _step_along_branch(
    equations: SteadyEquations,
    kind: Measure,
    target: float,
    elastic: float,
    growth: float,
    count: int,
    values: list[float],
    effort: IterationCounts,
) -> bool:
    """Multiply the elastic energy by ``growth`` until the measure passes the target; adds its ``values``."""
    last = equations.measure(kind)[0]
    for _ in range(count):
        kept = equations.save()
        if not newton(equations, "elastic", elastic * growth, effort):
            growth = np.sqrt(growth)
            if abs(growth - 1.0) < 0.01:
                break
            continue
        elastic *= growth
        value = equations.measure(kind)[0]
        values.append(value)
        if (value - target) * (last - target) <= 0.0:
            ends = [equations.save(), kept]
            for end in ends if abs(value - target) < abs(last - target) else ends[::-1]:
                equations.restore(end)
                if continue_to(equations, kind, target, effort):
                    return True
            break
        last = value
    return False
