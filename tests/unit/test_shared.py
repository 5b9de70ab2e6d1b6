"""Bundles that Python hands over by their address: compiled code reads what they are made of."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numba import njit, types

from viscorod.mechanics.compilation.by_address import address_of, returning
from viscorod.mechanics.compilation.compiled import PURE_PYTHON
from viscorod.mechanics.compilation.known_types import KnownTypes
from viscorod.mechanics.compilation.shared import Shared, kinds_of
from viscorod.typing import Floats, Integers

pytestmark = pytest.mark.skipif(PURE_PYTHON, reason="nothing is compiled")


class Switches(NamedTuple):
    """Nothing but switches, which take a byte each."""

    first: bool
    second: bool
    third: bool


class Inner(NamedTuple):
    """Arrays of several kinds, one without entries, between switches."""

    on: bool
    waves: np.ndarray
    empty: Floats
    switches: Switches
    flags: Integers
    off: np.bool_


class Outer(NamedTuple):
    """A bundle in a bundle, numbers of all kinds, and rows."""

    inner: Inner
    factor: float
    count: int
    turn: complex
    rows: tuple[Floats, ...]
    last: np.float64


@njit
def entries(run, out):
    """Write everything that a bundle has, one by one."""
    inner, switches = run.inner, run.inner.switches
    out[0], out[1], out[2] = inner.on, inner.waves[1, 2].real, inner.waves[0, 1].imag
    out[3], out[4], out[5] = inner.empty.shape[0], inner.empty.shape[1], inner.flags[2]
    out[6], out[7], out[8], out[9] = switches.first, switches.second, switches.third, inner.off
    out[10], out[11], out[12], out[13] = run.factor, run.count, run.turn.imag, run.last
    inner.flags[0] = 7
    return run.turn.real


class Pair(NamedTuple):
    """A bundle with a shared one in it."""

    weight: float
    part: Shared[Outer]


@njit
def weighted(run, out):
    """Read a bundle within a bundle."""
    return run.weight * entries(run.part, out)


@njit
def far_entries(run, address, out):
    """Hand the reference on by address."""
    return _entries(address, (run, out))


_entries = returning(types.float64, whole=False)


@pytest.fixture
def outer():
    waves = np.arange(6).reshape(2, 3) * (2.0 + 1.0j)
    rows = (np.array([1.0, 2.0]), np.array([10.0]))
    inner = Inner(True, waves, np.zeros((0, 4)), Switches(False, True, False), np.array([1, 2, 3]), np.True_)
    return Outer(inner, 0.5, -3, 7.0 - 2.0j, rows, np.float64(0.25))


EXPECTED = [1.0, 10.0, 1.0, 0.0, 4.0, 3.0, 0.0, 1.0, 0.0, 1.0, 0.5, -3.0, -2.0, 0.25]


def test_kernels_read_and_write_what_stands_in_memory(outer):
    shared, out = Shared(outer), np.zeros(14)
    assert entries(shared, out) == 7.0
    assert out.tolist() == EXPECTED
    assert outer.inner.flags[0] == 7


def test_references_go_on_by_address(outer):
    shared, out = Shared(outer), np.zeros(14)
    address = address_of(KnownTypes(entries), types.float64, lambda: (shared, out))
    assert far_entries(shared, address, out) == 7.0
    assert out.tolist() == EXPECTED


def test_shared_bundles_within_others_are_references(outer):
    within, out = Shared(Pair(2.0, Shared(outer))), np.zeros(14)
    assert weighted(within, out) == 14.0
    assert out.tolist() == EXPECTED


class Rows(NamedTuple):
    """Tuples without names, whose lengths belong to their types."""

    first: tuple[Floats, ...]
    second: tuple[Floats, ...]


def test_tuples_of_other_lengths_are_other_bundles_also_if_they_have_as_many_arrays():
    one, two, three = (np.array([value]) for value in (1.0, 2.0, 3.0))
    long, short = Shared(Rows((one, two), (three,))), Shared(Rows((one,), (two, three)))
    assert kinds_of(long) != kinds_of(short)
    assert kinds_of(Shared(Rows((two, one), (three,)))) == kinds_of(long)


def test_bundles_like_an_earlier_one_are_read_where_their_own_arrays_are(outer):
    more = outer._replace(rows=(*outer.rows, np.array([3.0])))  # what stands behind them is elsewhere
    other = outer._replace(factor=1.5, count=4, turn=1.0 + 2.0j, last=np.float64(8.0))
    for given, last in (
        (outer, [0.5, -3.0, -2.0, 0.25]),
        (more, [0.5, -3.0, -2.0, 0.25]),
        (other, [1.5, 4.0, 2.0, 8.0]),
    ):
        out = np.zeros(14)
        entries(Shared(given), out)
        assert out[10:].tolist() == last


def test_layout_of_arrays_decides_about_types_but_not_that_of_few_entries(outer):
    one, turned = np.zeros((1, 3)), np.zeros((2, 3)).T
    assert kinds_of(one) == kinds_of(np.zeros((2, 3))) != kinds_of(turned)
    assert kinds_of(Shared(outer)) == kinds_of(Shared(outer)) != kinds_of(Shared(Pair(2.0, Shared(outer))))


def others(outer, rows, **given):
    """A bundle like another one with other numbers, entries and shapes."""
    waves = np.arange(8).reshape(2, 4) * (2.0 + 1.0j)
    inner = outer.inner._replace(waves=waves, empty=np.zeros((3, 0)), flags=np.array([1, 2, 5]))
    return outer._replace(inner=inner, factor=0.75, count=4, turn=6.0 + 1.0j, rows=rows, **given)


def test_bundles_like_earlier_ones_are_laid_out_as_these(outer):
    """Other shapes and numbers; of the same type unless an array is a view, read only, or of another type."""
    first, out = Shared(outer), np.zeros(14)
    alike = Shared(others(outer, (np.zeros(3), np.zeros(2))))
    assert alike.number == first.number
    assert entries(alike, out) == 6.0
    assert out.tolist() == [1.0, 12.0, 1.0, 3.0, 0.0, 5.0, 0.0, 1.0, 0.0, 1.0, 0.75, 4.0, 1.0, 0.25]
    view = Shared(others(outer, (np.zeros(6)[::2], np.zeros(3))))
    assert view.number != first.number
    fixed = np.zeros(3)
    fixed.flags.writeable = False
    assert Shared(others(outer, (fixed, np.zeros(3)))).number not in {first.number, view.number}
    assert Shared(others(outer, (np.zeros(3, dtype=np.int64), np.zeros(3)))).number != first.number
    assert Shared(others(outer, (np.zeros(3),))).number != first.number


def test_switches_are_those_of_each_bundle(outer):
    out = np.zeros(14)
    for switches in (Switches(True, False, True), Switches(False, True, True), outer.inner.switches):
        inner = outer.inner._replace(on=False, switches=switches)
        entries(Shared(outer._replace(inner=inner)), out)
        assert out[[0, 6, 7, 8]].tolist() == [0.0, *map(float, switches)]


class Calls(NamedTuple):
    """Numbers that are known later."""

    first: int
    second: int


class Last(NamedTuple):
    """A bundle with such numbers."""

    weight: float
    calls: Calls


@njit
def both(run):
    """Read numbers."""
    return run.weight * (run.calls.first + 10 * run.calls.second)


def test_numbers_are_put_into_a_bundle():
    shared = Shared(Last(2.0, Calls(0, 0)))
    shared.put("calls", Calls(3, 4))
    assert both(shared) == 86.0
    assert shared.bundle == Last(2.0, Calls(3, 4))
    assert both(Shared(Last(0.5, Calls(1, 2)))) == 10.5


class Counts(NamedTuple):
    """Integers, as a rule."""

    first: int
    second: float


def test_bundles_of_one_class_with_other_things_in_them_are_told_apart(outer):
    """Each is laid out as Numba sees it, however they follow each other."""
    inner = outer.inner
    whole = [Pair(2.0, outer), Pair(2.0, Shared(outer)), Pair(2.0, inner), Pair(2.0, Counts(1, 2))]
    whole += [Pair(2.0, Counts(1, 2.5)), Pair(2.0, ()), Pair(2.0, (inner.flags,)), Pair(2.0, (1.0, inner))]
    first = [Shared(pair) for pair in whole]
    assert len({shared.number for shared in first}) == len(whole)
    for pair, known in zip(reversed(whole), reversed(first), strict=True):
        again = Shared(pair)
        assert again.number == known.number
        np.testing.assert_array_equal(again._words, known._words)
