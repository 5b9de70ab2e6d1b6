"""A collocation step in one compiled call: place, respond, hold, load, support, solve, move, estimate, account.

The stages of a step are coupled (see ``stage_kernels`` for their equations). An iteration places all nodes, lets the
material respond, holds joints, loads, and balances; the imbalance goes through the linear systems of the method
into changes of all stages, which move the nodes and carry the stresses along (simplified Newton iteration, Hairer and
Wanner 1996, IV.8; stresses as iterates of their own, see ``collocation``). The last evaluation, with the stresses that
belong to the poses, is the step.

Parts that a model may lack are None, and the compiled code has nothing of them then: ``ends`` of the midpoint rule,
``strains`` of the intrinsic formulation, ``links`` (joints, springs and held strains), ``branches`` (Maxwell).
"""

from __future__ import annotations

import math

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.mechanics.compilation.references import refer
from viscorod.mechanics.elements.internal_force import GaussStates
from viscorod.mechanics.elements.intrinsic_element import StrainMotion
from viscorod.mechanics.elements.maxwell_branches import MaxwellArrays, stretch_springs
from viscorod.solve.transient.integrators.constraint_arrays import ConstraintArrays
from viscorod.solve.transient.integrators.iteration_verdict import CONVERGED, GOING, SLOW, judge
from viscorod.solve.transient.integrators.stage_data import (
    Discretisation,
    Ends,
    IterationLimits,
    StageLoads,
    StepParts,
    StepStart,
    StepTask,
    SupportMotion,
)
from viscorod.solve.transient.integrators.stage_response import gaps_are_open, hold, load, place, respond
from viscorod.solve.transient.integrators.stage_solution import (
    freeze,
    move,
    release_held,
    solve_stages,
    support,
)
from viscorod.solve.transient.integrators.step_account import estimate, take_account
from viscorod.solve.transient.integrators.tableau import Tableau
from viscorod.typing import Floats

__all__ = ["largest_turn", "try_step"]


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
def try_step(
    body: Discretisation,
    method: Tableau,
    start: StepStart,
    h: float,
    motion: SupportMotion,
    loads: StageLoads,
    parts: StepParts,
    limits: IterationLimits,
    ends: Ends | None,
    strains: StrainMotion | None,
    links: ConstraintArrays | None,
    branches: MaxwellArrays | None,
) -> tuple[int, int, float, float, int, float, int]:
    """Iterate until the estimated error of the stage coordinates is small enough; evaluate the result.

    If that succeeds, estimate the error and take account of the energy.

    Args:
        h: step [s]; motion, loads: of supports and loads at its stages.
        parts: state of the stages, matrices and their factors, the account of the step, and scratch.

    Returns:
        code, iterations, size of the last change, convergence rate, unknown of the largest change, size and unknown
        of the largest error.
    """
    factors, matrices, stages, account, work = parts
    points = GaussStates(stages.strain, stages.strain_rate, stages.section_force, stages.stress)
    given = (body, method, start, h, motion, loads, factors, matrices, stages, points, account, work)
    step, end, path = refer(StepTask(*given)), refer(ends), refer(strains)
    joined, relaxing = refer(links), refer(branches)
    last = size = 0.0
    rate = limits.rate**0.8  # trusted less with every step that does not confirm it
    unknown = count = 0
    code = GOING
    while True:
        final = code == CONVERGED
        place(step, end)
        respond(step, end, path, joined, relaxing)
        hold(step, end, joined, final)
        load(step)
        if final and gaps_are_open(joined, count, limits):
            code, final = GOING, False
        support(step, end, joined, final)
        if not final:
            freeze(step, joined)
        release_held(step, end)
        if final or count == limits.iterations:
            break
        size, unknown = solve_stages(step)
        count += 1
        code, rate = judge(count, limits.iterations, size, last, rate, limits.tolerance)
        if code not in (CONVERGED, GOING):
            break
        move(step, joined, relaxing)
        last = size
    largest, worst = 0.0, 0
    if code == CONVERGED:
        if branches is not None:
            stretch_springs(body.elements, branches, stages.strain)
        largest, worst = estimate(step, relaxing)
        take_account(step, joined, relaxing)
    elif code == GOING:
        code = SLOW
    return code, count, size, rate, unknown, largest, worst
