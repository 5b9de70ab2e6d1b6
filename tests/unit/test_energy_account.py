"""The energy account of a motion."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from viscorod.solve.energy_account import EnergyAccount


def test_a_copy_has_every_entry_and_goes_its_own_way():
    """Each field, whatever there are, has a value of its own."""
    account = EnergyAccount()
    for number, entry in enumerate(fields(account)):
        setattr(account, entry.name, np.array([1.0, 2.0]) if entry.name == "branches" else 1.0 + number)
    copied = account.copy()
    assert vars(copied).keys() == vars(account).keys() == {entry.name for entry in fields(account)}
    for name, value in vars(account).items():
        np.testing.assert_array_equal(getattr(copied, name), value)
    account.external += 1.0
    assert copied.external == account.external - 1.0
