"""The length of the next step, by predictive control of the error (Gustafsson 1994): the numbers of ``ErrorControl``.

The compiled loop of steps and Python choose by the same functions, bit for bit.
"""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import exact_part, loop
from viscorod.typing import Floats

__all__ = ["COUNT", "accept_step", "choose_step", "end_of_step", "next_end"]

H, CORNER, LAST_H, LAST_ERROR, FAILED, LIMIT, ACCEPTED, LARGEST, ORDER, ITERATIONS, KEEP, GROWTH, COUNT = (
    range(13)
)
"""Places among the numbers: next step and corner [s]; the last accepted step [s] and its error (-1: none); whether the
last attempt failed; what limits the next step, and what limited the accepted one; then as in ``ErrorControl``."""

NOTHING, JUMP, BEGINNING, CONVERGENCE, ERROR, NEXT_CORNER, LARGEST_STEP = range(7)
"""What limits a step."""


@exact_part
def end_of_step(numbers: Floats, t: float) -> float:
    """Return the end [s] of the next step, which begins at ``t`` [s]."""
    left = numbers[CORNER] - t
    if numbers[H] >= left * (1.0 - 1e-9):
        return float(numbers[CORNER])
    # no tiny last step: the one before it is shortened
    return float(t + (numbers[H] if numbers[H] <= 0.5 * left else 0.5 * left))


@exact_part
def accept_step(numbers: Floats, converged: bool, error: float, iterations: int, h: float) -> bool:
    """Judge an attempt of length ``h`` [s] by its error over the tolerated one, and choose the next step."""
    if not converged:
        numbers[H] = 0.3 * h
        numbers[LIMIT], numbers[FAILED] = CONVERGENCE, 1.0
        return False
    power = 1.0 / (numbers[ORDER] + 1.0)
    error = max(error, 1e-10)
    limit = numbers[ITERATIONS]
    safety = 0.9 * (2.0 * limit + 1.0) / (2.0 * limit + iterations)
    factor = safety * error**-power
    if error > 1.0:
        numbers[H] = h * min(max(factor, 0.1), 0.9)
        numbers[LIMIT], numbers[FAILED] = ERROR, 1.0
        return False
    if numbers[LAST_ERROR] >= 0.0:
        before, error_before = numbers[LAST_H], numbers[LAST_ERROR]
        factor = min(factor, safety * (h / before) * (error_before / error) ** power * error**-power)
    factor = min(max(factor, 0.2), 1.0 if numbers[FAILED] != 0.0 else numbers[GROWTH])
    numbers[LAST_H], numbers[LAST_ERROR] = h, max(error, 1e-2)
    numbers[ACCEPTED] = numbers[LIMIT] if h >= 0.99 * numbers[H] else NEXT_CORNER
    numbers[FAILED] = 0.0
    if h < 0.99 * numbers[H]:
        # the step was cut to hit a corner: the one planned is still good unless this one says otherwise
        numbers[H] = max(numbers[H], h * factor) if error < 0.1 else h * factor
    elif not 1.0 <= factor <= numbers[KEEP]:
        numbers[H] = h * factor
    numbers[LIMIT] = ERROR
    if numbers[H] >= numbers[LARGEST]:
        numbers[H], numbers[LIMIT] = numbers[LARGEST], LARGEST_STEP
    return True


@loop
def next_end(numbers: Floats, t: float) -> float:
    """Do what :func:`end_of_step` does."""
    return end_of_step(numbers, t)


@loop
def choose_step(numbers: Floats, converged: bool, error: float, iterations: int, h: float) -> bool:
    """Do what :func:`accept_step` does."""
    return accept_step(numbers, converged, error, iterations, h)
