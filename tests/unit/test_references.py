"""Bundles by reference within compiled code: what is read through them is what they are made of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit, types

from viscorod.mechanics.compilation.by_address import address_of, returning
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.references import refer, row_of
from viscorod.typing import Floats, Integers

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")


class Inner(NamedTuple):
    """Arrays of several kinds, and nothing."""

    waves: np.ndarray
    flags: Integers
    none: tuple[()]


class Outer(NamedTuple):
    """A bundle in a bundle, numbers, a switch, and rows."""

    inner: Inner
    factor: float
    turn: complex
    on: bool
    rows: tuple[Floats, ...]


@njit
def size_of(inner, factor, turn, on, rows):
    """Weigh everything, so that no two parts can be mistaken for each other."""
    total = factor * inner.waves[1, 0].real + 100.0 * inner.flags[2] + turn.imag
    return total + rows[1][0] if on else -total


_size = returning(types.float64)


@njit
def far_size(outer, address):
    """Call it by its address: one bundle by reference, others made of references."""
    run = refer(outer)
    inner = Inner(run.inner.waves, run.inner.flags, run.inner.none)
    first = _size(address, (run.inner, run.factor, run.turn, run.on, run.rows))
    return first, _size(address, (inner, run.factor, run.turn, not run.on, run.rows))


@njit
def sum_of_rows(outer):
    """Read rows one after the other, and write to the first."""
    rows, total = refer(outer).rows, 0.0
    for k in range(3):
        row = row_of(rows, k)
        for i in range(row.shape[0]):
            total += (k + 1) * row[i]
    row_of(rows, 0)[0] = -1.0
    return total


@pytest.fixture
def outer():
    waves = np.arange(6).reshape(2, 3) * (2.0 + 1.0j)
    rows = (np.array([1.0, 2.0]), np.array([10.0]), np.array([100.0, 200.0, 300.0]))
    return Outer(Inner(waves, np.array([1, 2, 3]), ()), 0.5, 7.0j, True, rows)


def test_a_kernel_called_by_address_is_handed_what_references_stand_for(outer):
    address = address_of(KnownTypes(size_of), types.float64, lambda: tuple(outer))
    expected = size_of(*outer), size_of(*outer._replace(on=False))
    assert far_size(outer, address) == expected == (0.5 * 6.0 + 300.0 + 7.0 + 10.0, -310.0)


def test_rows_are_those_of_the_bundle(outer):
    assert sum_of_rows(outer) == 3.0 + 2.0 * 10.0 + 3.0 * 600.0
    assert outer.rows[0][0] == -1.0


def test_fields_that_there_are_not_are_refused(outer):
    @njit
    def lost(bundle):
        return refer(bundle).absent

    with pytest.raises(Exception, match="absent"):
        lost(outer)
