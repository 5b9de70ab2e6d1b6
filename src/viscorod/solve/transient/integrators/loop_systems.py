"""The linear systems of a step in the compiled loop: put together, and factorised."""

from __future__ import annotations

from viscorod.mechanics.compilation.by_address import returning
from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.solve.transient.integrators import loop_branches
from viscorod.solve.transient.integrators.kernel_results import NOTHING, NUMBER
from viscorod.solve.transient.integrators.loop_data import StepLoop

__all__ = ["factorise"]

_do, _factorise = returning(NOTHING), returning(NUMBER)


@exact_part
def combine(run: StepLoop, h: float) -> None:
    """Put the systems for a step of ``h`` [s] together."""
    task, systems, calls = run.model.task, run.systems, run.calls
    body, method, factors, frozen = task.body, task.method, task.factors, task.matrices
    matrices = (frozen.K, frozen.C, frozen.mass)
    where = (body.supports, frozen.directions, body.pattern, factors.scales)
    _do(calls.combine_real, (*matrices, method.real / h, *where, factors.real_rows, systems.real))
    for m in range(method.pairs.shape[0]):
        with_pair = (*where, factors.pair_rows[m], systems.pairs[m])
        _do(calls.combine_pair, (*matrices, method.pairs[m] / h, *with_pair))


@exact_part
def factorise(run: StepLoop, h: float) -> bool:
    """Factorise the systems for a step of ``h`` [s]; return whether all went well."""
    task, systems, calls = run.model.task, run.systems, run.calls
    method, real, pairs = task.method, task.factors.real, task.factors.pairs
    if calls.stiffen_real != 0:
        loop_branches.combine(run, h)
    else:
        combine(run, h)
    places = (systems.slots, systems.kept, systems.targets)
    given = (real.values, real.fronts, real.integers, real.groups, real.rest)
    if _factorise(calls.reduce_real, (systems.real, *places, *given)) != 0:
        return False
    for m in range(method.pairs.shape[0]):
        one = (pairs.values[m], pairs.fronts[m], pairs.integers[m], pairs.groups, pairs.rest[m])
        if _factorise(calls.reduce_pair, (systems.pairs[m], *places, *one)) != 0:
            return False
    return True
