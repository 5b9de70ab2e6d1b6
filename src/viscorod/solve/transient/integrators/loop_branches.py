"""Maxwell branches in the compiled loop of steps, which calls their kernels where a model has any."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.solve.transient.integrators.kernel_results import NOTHING
from viscorod.solve.transient.integrators.loop_data import STEPS, StepLoop

__all__ = ["add_losses", "begin", "combine", "keep", "read", "within"]

_do = returning(NOTHING)


@exact_part
def combine(run: StepLoop, h: float) -> None:
    """Put the systems of a step of ``h`` [s] together with the branches at each eigenvalue."""
    task, systems, calls = run.model.task, run.systems, run.calls
    body, method, factors, frozen = task.body, task.method, task.factors, task.matrices
    real, pair = run.model.branches.real, run.model.branches.pair
    held = (body.elements, task.branches, body.supports, frozen.directions, body.pattern)
    where = (body.supports, frozen.directions, body.pattern, factors.scales)
    given, mu = (frozen.K, frozen.operators.strain), method.real / h
    _do(calls.stiffen_real, (mu, *given, *held, real))
    with_real = (*where, factors.real_rows, systems.real)
    _do(calls.combine_real, (real.blocks, frozen.C, frozen.mass, mu, *with_real))
    for m in range(method.pairs.shape[0]):
        eigenvalue = method.pairs[m] / h
        _do(calls.stiffen_pair, (eigenvalue, *given, *held, pair))
        with_pair = (*where, factors.pair_rows[m], systems.pairs[m])
        _do(calls.combine_pair, (pair.blocks, frozen.C, frozen.mass, eigenvalue, *with_pair))


@exact_part
def begin(run: StepLoop, h: float) -> None:
    """Prepare a step of ``h`` [s]."""
    task, elements = run.model.task, run.model.task.body.elements
    given = (h, task.method.matrix, elements.order, elements.section)
    _do(run.calls.begin_branches, (*given, task.branches, run.model.branches.memory))


@exact_part
def keep(run: StepLoop) -> None:
    """Take the end of a step."""
    task = run.model.task
    given = (task.method.weights, task.stages.strain)
    _do(run.calls.keep_branches, (*given, task.branches, run.model.branches.memory))


@exact_part
def add_losses(run: StepLoop) -> None:
    """Add what the branches lose in a step to what they have lost, before it is counted."""
    lost, loss, steps = run.batch.lost, run.model.branches.memory.loss, run.numbers[STEPS]
    for j in range(loss.shape[0]):
        lost[steps + 1, j] = lost[steps, j] + loss[j]


@exact_part
def read(run: StepLoop, row: int) -> None:
    """Write the branches in the present state into a row."""
    task, memory = run.model.task, run.model.branches.memory
    where = (task.body.elements.section, run.model.reading.places)
    _do(run.calls.read_branches, (row, task.branches, memory, *where, run.batch.branches))


@exact_part
def within(run: StepLoop, first: int, size: int) -> None:
    """Write the branches at ``size`` places within the last step into the rows of the same numbers, from ``first``."""
    task, memory, parts = run.model.task, run.model.branches.memory, run.batch.places[first : first + size]
    given = (parts, first, task.method.values, task.method.integrals, task.branches, memory)
    where = (task.body.elements.section, run.model.reading.places)
    _do(run.calls.read_within, (*given, *where, run.batch.branches))
