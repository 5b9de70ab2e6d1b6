"""What a run keeps, as plain data and back through a checkpoint file."""

from __future__ import annotations

import numpy as np

from viscorod.results.files.journal import Journal, checkpoint
from viscorod.solve.transient.saved_state import restore, saved


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
