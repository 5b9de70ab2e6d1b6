"""What a run keeps, as plain data and back through a checkpoint file."""

from __future__ import annotations

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.warmup import SPAN, soft_model
from viscorod.results.files.journal import Journal
from viscorod.results.files.stored_journal import checkpoint
from viscorod.solve.formulations.system import State
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.saved_state import hand_over, restore, saved


class Keeper:
    """Keeps dicts as an integrator might: of arrays, numbers and dicts, by words and numbers."""

    def __init__(self, size):
        self.values = np.full(3, size)
        self.by_step = {0.25: np.full(2, size), (1, "end"): size}
        self.nested = {"deep": {3: [size, size]}}
        self.changing = {"kept": size}


def test_dicts_come_back(tmp_path):
    """Keys of every kind, arrays in place, and no key that came later."""
    old, new = Keeper(1.5), Keeper(0.0)
    old.changing["added"] = 2
    new.changing["later"] = 3
    journal = Journal(tmp_path / "run.partial")
    journal.checkpoint(saved(old), {})
    tree, *_ = checkpoint(journal.folder)
    journal._file.close()
    array, table = new.by_step[0.25], new.by_step
    restore(new, tree)
    assert new.by_step is table
    assert new.by_step[0.25] is array
    np.testing.assert_array_equal(array, [1.5, 1.5])
    assert new.by_step[1, "end"] == 1.5
    assert new.nested == {"deep": {3: [1.5, 1.5]}}
    assert new.changing == {"kept": 1.5, "added": 2}


def test_what_is_made_again_is_left_out_with_its_dict():
    """As of lists: a dict with a function, say, is not saved, and stays what it is."""
    keeper = Keeper(1.0)
    keeper.changing["made"] = print
    tree = saved(keeper)
    keeper.changing["kept"] = 2.0
    restore(keeper, tree)
    assert keeper.changing == {"kept": 2.0, "made": print}


def _same(one, other):
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(_same, one, other))
    return one == other


def test_a_state_handed_over_is_the_one_that_is_saved_and_restored():
    """Of dicts and of an integrator after a step, bit for bit, arrays in place."""
    old, first, second = Keeper(1.5), Keeper(0.0), Keeper(0.0)
    array = second.values
    restore(first, saved(old))
    hand_over(old, second)
    assert _same(saved(first), saved(second))
    assert second.values is array
    assert not _same(saved(first), saved(Keeper(1.0)))

    def integrator():
        work = DiscreteModel.of(soft_model())
        made = Radau(work.system, work.supports, tolerance=1e-4)
        made.start(0.0, State.reference(work.problem))
        return made

    moved, taken = integrator(), integrator()
    for step in (1, 2):
        assert moved.attempt(step * SPAN, before=False).converged
        moved.accept()
    stages = taken.stages.X
    assert not _same(saved(moved), saved(taken))
    hand_over(moved, taken)
    for each in (moved, taken):
        each.resume()
    assert _same(saved(moved), saved(taken))
    assert taken.stages.X is stages
    assert taken.state.r is not moved.state.r
