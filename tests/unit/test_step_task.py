"""A collocation step is compiled once: its arrays have the same types whatever the model, and it needs few kernels."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from viscorod.analyses import warmup
from viscorod.analyses.discrete import DiscreteModel
from viscorod.mechanics.compilation.shared import kinds_of
from viscorod.solve.transient.integrators import stage_model, step_branches, step_ends, step_links
from viscorod.solve.transient.integrators.midpoint import Midpoint
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.integrators.step_addresses import needed_kernels
from viscorod.solve.transient.integrators.step_task import StepCalls

MODELS = {
    "soft": warmup.soft_model,
    "all loads": warmup.small_model,
    "joints and held strains": warmup.small_assembly,
    "branches": warmup.small_relaxing,
}
FORMULATIONS = ("geometric", "full"), ("intrinsic", "full"), ("intrinsic", "linearised")
METHODS = {"radau": functools.partial(Radau, tolerance=1e-4), "midpoint": Midpoint}
LINKS, BRANCHES, ENDS = (set(module.__all__) for module in (step_links, step_branches, step_ends))


@pytest.fixture(autouse=True)
def nothing_is_compiled(monkeypatch):
    monkeypatch.setattr(stage_model, "step_calls", lambda shared: StepCalls())


def task_of(name, formulation, method):
    work = DiscreteModel.of(MODELS[name](), formulation=formulation)
    return METHODS[method](work.system, work.supports).task


@functools.cache
def expected():
    return kinds_of(task_of("soft", FORMULATIONS[0], "radau"))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("formulation", FORMULATIONS, ids="-".join)
@pytest.mark.parametrize("name", MODELS)
def test_all_models_have_arrays_of_the_same_types(name, formulation, method):
    """Structure: another type of any array would compile the step, and all that it calls, once more."""
    assert kinds_of(task_of(name, formulation, method)) == expected()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("formulation", FORMULATIONS[:2], ids="-".join)
@pytest.mark.parametrize("name", MODELS)
def test_a_step_needs_no_kernels_of_what_its_model_lacks(name, formulation, method):
    """Structure: the kernels of links are those of models with links, and so on."""
    needed = set(needed_kernels(task_of(name, formulation, method)))
    assert needed >= {"impose", "substitute", "energies"}
    assert needed & LINKS == (LINKS if name == "joints and held strains" else set())
    at_ends = {"conserve", "branch_defect"}
    between, geometric = method == "midpoint", formulation[0] == "geometric"
    branches = BRANCHES if between and geometric else BRANCHES - at_ends
    assert needed & BRANCHES == (branches if name == "branches" else set())
    assert needed & ENDS == ((ENDS if geometric else ENDS - at_ends) if between else set())
    assert ("internal_forces" in needed) == geometric != ("strains" in needed)
    assert ("substitute_pair" in needed) != between
    loads = {"nodal_loads", "station_load", "motion_loads"}
    assert needed & loads == (loads if name == "all loads" else {"nodal_loads"})
    assert ("deduct_rest" in needed) == (geometric and name == "joints and held strains")
    assert ("support_powers" in needed) == (name == "all loads")


def test_what_steps_work_on_stays_where_it_is_until_an_array_is_another():
    work = DiscreteModel.of(warmup.soft_model())
    radau = Radau(work.system, work.supports, tolerance=1e-4)
    first = radau.step_arguments(1e-6)
    assert radau.step_arguments(2e-6)[0] is first[0]
    assert radau.task.numbers[0] == 2e-6
    assert np.shares_memory(radau.task.stages.X, radau.stages.X)
    radau.matrices = radau.matrices._replace(K=radau.matrices.K.copy())
    assert radau.step_arguments(1e-6)[0] is not first[0]
    assert radau.task.matrices.K is radau.matrices.K
