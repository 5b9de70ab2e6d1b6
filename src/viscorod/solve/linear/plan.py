"""Plans to factorise the matrices of one pattern, chosen once by estimated cost."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from viscorod.solve.linear.band import BLOCKED
from viscorod.solve.linear.elimination import Elimination
from viscorod.solve.linear.ordering import band_order, half_bandwidth, sparse_order
from viscorod.solve.linear.pattern import Pattern
from viscorod.typing import Integers

NARROW = 12
"""Bands that half_bandwidth no farther (in block rows) are never wider than worth it: no sparse LU is tried."""


@dataclass(frozen=True)
class Plan:
    """One way to factorise the matrices of a pattern.

    Attributes:
        pattern: all blocks.
        elimination: groups that are eliminated first, and the remaining matrix (``M`` block rows).
        order: the remaining block rows in the order of elimination ``(M,)``, numbers within what remains.
        banded: as a band; else as a sparse matrix.
        without: block rows whose unknowns are zero, which are left out with their columns.
        cost: estimated time of a real and a complex factorisation, which motions need in turn, in proportion to that
            of a real one [ns].
    """

    pattern: Pattern
    elimination: Elimination
    order: Integers
    banded: bool
    cost: float
    without: tuple[int, ...] = ()

    @classmethod
    def of(cls, pattern: Pattern, interiors: Iterable[Integers] = (), without: tuple[int, ...] = ()) -> Plan:
        """Choose the cheapest.

        Args:
            pattern: all blocks.
            interiors: groups of block rows that couple with no other group, as the inner nodes of elements do; one
                array ``(count, k)`` per size. Groups that do couple with others are left alone.
            without: block rows whose unknowns are zero. Nothing is solved there: right sides stay what they are.
        """
        return min(plans(pattern, interiors, without), key=lambda plan: plan.cost)

    @property
    def description(self) -> str:
        """The plan in words."""
        unknowns = 6 * len(self.order)
        rest = f"band of half width {self.width}" if self.banded else f"sparse LU of {unknowns} unknowns"
        return f"element interiors condensed, {rest}" if self.elimination.fronts else rest

    @cached_property
    def plain(self) -> Plan:
        """The cheapest plan without prior elimination; this one if it has none."""
        return Plan.of(self.pattern, (), self.without) if self.elimination.fronts else self

    @cached_property
    def width(self) -> int:
        """Half bandwidth of the remaining matrix, in unknowns."""
        return 6 * half_bandwidth(self.elimination.remaining, self.order) + 5

    @cached_property
    def ordered(self) -> Pattern:
        """The pattern of the remaining matrix, numbered in the order of elimination."""
        remaining = self.elimination.remaining
        place = np.argsort(self.order)
        return Pattern.of(
            remaining.size, [np.column_stack([place[remaining.rows], place[remaining.columns]])]
        )

    @cached_property
    def rows(self) -> Integers:
        """The remaining block rows in the order of elimination ``(M,)``."""
        return np.ascontiguousarray(self.elimination.rows[self.order])

    @cached_property
    def targets(self) -> Integers:
        """Positions of the remaining blocks in the values of the band or the sparse matrix ``(c, 2)``.

        Entry (i, j) of block s is at ``targets[s, 0] + j * targets[s, 1] + i``.
        """
        rows, columns, starts = self.ordered[:3]
        if self.banded:
            step = np.full(len(rows), 3 * self.width)
            return np.column_stack([6 * columns * (step + 1) + 2 * self.width + 6 * (rows - columns), step])
        step = 6 * np.diff(starts)[columns]
        first = starts[columns]
        return np.column_stack([36 * first + 6 * (np.arange(len(rows)) - first), step])

    @cached_property
    def kept(self) -> Integers:
        """Remaining blocks: their number in the pattern, and in that of the remaining matrix ``(c, 2)``."""
        place = self._place()
        rows, columns = place[self.pattern.rows], place[self.pattern.columns]
        slots = np.flatnonzero((rows >= 0) & (columns >= 0))
        return np.column_stack([slots, _find(self.ordered, rows[slots], columns[slots])])

    @cached_property
    def fronts(self) -> tuple[Integers, Integers, Integers]:
        """The groups that are eliminated, for compiled code.

        Returns:
            groups: ``(g, 3)``, numbers of block rows in the group and in all, and where its matrix begins.
            members: block rows ``(sum of all,)``; those that remain are numbered in the order of elimination.
            slots: blocks ``(sum of squares,)``, column by column: numbers in the pattern, -1 if it has none; between
                rows that remain, numbers in what remains.
        """
        place = self._place()
        groups, members, slots = [np.zeros((0, 2), int)], [np.zeros(0, int)], [np.zeros(0, int)]
        for interior, boundary in self.elimination.fronts:
            k, size = interior.shape[1], interior.shape[1] + boundary.shape[1]
            edge = place[boundary]
            every = np.column_stack([interior, boundary])
            found = _find(self.pattern, every[:, None, :], every[:, :, None])
            found[:, k:, k:] = _find(self.ordered, edge[:, None, :], edge[:, :, None])
            groups.append(np.tile([k, size], (len(interior), 1)))
            members.append(np.column_stack([interior, edge]).ravel())
            slots.append(found.ravel())
        sizes = np.concatenate(groups)
        begins = 2 + np.concatenate([[0], np.cumsum(36 * sizes[:, 1] ** 2)])[:-1]
        return np.column_stack([sizes, begins]), np.concatenate(members), np.concatenate(slots)

    @cached_property
    def sizes(self) -> tuple[int, int, int, int]:
        """Numbers of unknowns that remain, of values of all fronts, of unknowns in groups and in the largest front."""
        groups = self.fronts[0]
        values, most = np.sum(36 * groups[:, 1] ** 2), groups[:, 1].max(initial=0)
        return 6 * len(self.rows), int(values), 6 * int(groups[:, 0].sum()), 6 * int(most)

    def _place(self) -> Integers:
        place = np.full(self.pattern.size, -1)
        place[self.rows] = np.arange(len(self.rows))
        return place

    def unknown(self, row: int) -> int:
        """Return the unknown (of all) that is number ``row`` in the order of elimination of what remains."""
        return int(6 * self.rows[row // 6] + row % 6)


def plans(
    pattern: Pattern, interiors: Iterable[Integers] = (), without: tuple[int, ...] = ()
) -> Iterator[Plan]:
    """Yield all ways that might be good."""
    alone = Elimination.of(pattern, (), without)
    condensed = Elimination.of(pattern, interiors, without)
    for elimination in (alone, condensed) if condensed.fronts else (alone,):
        rest = elimination.remaining
        order = band_order(rest)
        far, n = half_bandwidth(rest, order), 6 * rest.size
        before = elimination.cost
        yield Plan(pattern, elimination, order, True, before + _band_cost(n, 6 * far + 5), without)
        if far > NARROW:
            order, flops = sparse_order(rest)
            yield Plan(pattern, elimination, order, False, before + 1.5e3 * n + flops / 4.0, without)


def _band_cost(n: int, width: int) -> float:
    """Return the cost of a band LU as measured."""
    if width < BLOCKED:
        return n * (26.0 + 0.39 * width**2)
    w = min(width, n)  # LAPACK: some per column, and more speed for wider bands
    return 75.0 * n + (2.0 * n * w**2 - 4.0 / 3.0 * w**3) / min(18.0, 9.0 + w / 40.0)


def _find(pattern: Pattern, rows: Integers, columns: Integers) -> Integers:
    """Return the numbers of blocks; -1 for those that are not in the pattern."""
    keys = pattern.columns * pattern.size + pattern.rows
    wanted = columns * pattern.size + rows
    found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    return np.where(keys[found] == wanted, found, -1)
