"""A collocation step in one compiled call: place, respond, hold, load, support, solve, move, estimate, account.

The stages of a step are coupled (see ``stage_kernels`` for their equations). An iteration places all nodes, lets the
material respond, holds joints, loads, and balances; the imbalance goes through the linear systems of the method
into changes of all stages, which move the nodes and carry the stresses along (simplified Newton iteration, Hairer and
Wanner 1996, IV.8; stresses as iterates of their own, see ``collocation``). The last evaluation, with the stresses that
belong to the poses, is the step.

It is compiled once, for all methods, formulations and models (see ``step_task``).
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.solve.transient.integrators.constraint_arrays import GAP
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED, GOING, SLOW, judge
from viscorod.solve.transient.integrators.stage_response import load, place, respond
from viscorod.solve.transient.integrators.stage_solution import (
    freeze,
    move,
    release_held,
    solve_stages,
    support,
)
from viscorod.solve.transient.integrators.step_account import estimate, take_account
from viscorod.solve.transient.integrators.step_task import FINAL, ITERATIONS, RATE, TOLERANCE, StepTask
from viscorod.typing import Floats

__all__ = ["largest_turn", "place_predicted", "try_step"]


@kernel
def largest_turn(X: Floats) -> tuple[float, int]:
    """Return the largest rotation [rad] of coordinates ``(n, 6)``, and its node."""
    largest, node = 0.0, 0
    for k in range(X.shape[0]):
        square = X[k, 3] * X[k, 3] + X[k, 4] * X[k, 4] + X[k, 5] * X[k, 5]
        if square > largest:
            largest, node = square, k
    return math.sqrt(largest), node


@kernel
def place_predicted(step: StepTask) -> None:
    """Put all nodes where the stages are predicted, before the first iteration."""
    place(step)


@kernel
def try_step(step: StepTask) -> tuple[int, int, float, float, int, float, int]:
    """Iterate until the estimated error of the stage coordinates is small enough; evaluate the result.

    If that succeeds, estimate the error and take account of the energy.

    Returns:
        code, iterations, size of the last change, convergence rate, unknown of the largest change, size and unknown
        of the largest error.
    """
    numbers, worst, links = step.numbers, step.links.worst, step.calls.hold_links
    tolerance, most = numbers[TOLERANCE], int(numbers[ITERATIONS])
    last = size = 0.0
    rate = numbers[RATE] ** 0.8  # trusted less with every step that does not confirm it
    unknown = count = 0
    code = GOING
    while True:
        final = code == CONVERGED
        numbers[FINAL] = 1.0 if final else 0.0
        place(step)
        respond(step)
        load(step)
        if final and links != 0 and count < most and worst[0] > GAP:
            code, final = GOING, False
        support(step, final)
        if not final:
            freeze(step)
        release_held(step)
        if final or count == most:
            break
        size, unknown = solve_stages(step)
        count += 1
        code, rate = judge(count, most, size, last, rate, tolerance)
        if code not in (CONVERGED, GOING):
            break
        move(step)
        last = size
    largest, worst_unknown = 0.0, 0
    if code == CONVERGED:
        largest, worst_unknown = estimate(step)
        take_account(step)
    elif code == GOING:
        code = SLOW
    return code, count, size, rate, unknown, largest, worst_unknown
