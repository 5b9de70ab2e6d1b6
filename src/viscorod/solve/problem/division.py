"""How a rod is divided into elements: chosen from what is known of it, given, or finer than before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.rod import DEFAULT_ORDER, NODES_PER_ROD, TURN_PER_NODE, Rod
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats, Integers

KINK_ERROR = 1e-4
"""Error of the compliance of a piece of rod between two kinks of its section that its Gauss points leave at most."""
LEAST_ORDER = 2
"""Order of elements at least if the program chooses it."""


@dataclass(frozen=True)
class Division:
    """The elements of one rod: their order, and the arc lengths at which they end ``(elements + 1,)`` [m]."""

    order: int
    ends: Floats

    @property
    def count(self) -> int:
        """Number of elements."""
        return len(self.ends) - 1

    def halved(self, marked: np.ndarray | None = None) -> Division:
        """Return the division with all elements halved, or those marked ``(elements,)``."""
        chosen = np.ones(self.count, dtype=bool) if marked is None else marked
        middles = 0.5 * (self.ends[:-1] + self.ends[1:])[chosen]
        return Division(self.order, np.sort(np.concatenate([self.ends, middles])))


Divisions: TypeAlias = Mapping[str, Division]
"""Rod -> its division."""


def divisions_of(problem: Problem) -> dict[str, Division]:
    """Return the divisions of all rods of a problem."""
    found = {}
    for number, name in enumerate(problem.rods):
        order = int(problem.rod_orders[number])
        elements = next(e for e in problem.sets if e.order == order)
        starts = np.sort(elements.start[elements.rod == number])
        found[name] = Division(order, np.append(starts, problem.rod_lengths[number]))
    return found


def divided(name: str, rod: Rod, breaks: list[float], wishes: list[float], turn: float = 0.0) -> Division:
    """Divide a rod into elements.

    Elements end at ``breaks`` (sections change, supports, attachments); if the program chooses their number, at
    ``wishes`` (point loads) and at the kinks of sections too. The chosen mesh turns by a fifteenth of a circle from
    node to node, on average, in the reference shape and when its ends are turned against each other by ``turn`` [rad].

    Raises:
        InputError: there are too few elements for the breaks.
    """
    length = rod.length
    if rod.elements is None:
        kinks = rod.kinks
        corners = _distinct([0.0, *breaks, *wishes, *kinks, length], length)
        order = rod.order or (_order_between_kinks(rod, corners) if kinks else DEFAULT_ORDER)
        counts = np.array([rod.chosen_elements(a, b, order) for a, b in pairwise(corners)])
        if len(counts) == 1:
            counts[0] = max(counts[0], 2)
        if turn > 0.0:
            turns = np.diff(rod.turned(corners)) + turn * np.diff(corners) / length
            counts = np.maximum(counts, np.ceil(turns / (order * TURN_PER_NODE)).astype(np.int64))
        return Division(order, _filled(corners, counts))
    corners = _distinct([0.0, *breaks, length], length)
    spans = np.diff(corners)
    if rod.elements < len(spans):
        raise InputError(
            Fault(
                f"rods.{name}.elements",
                str(rod.elements),
                "too few: elements must end where sections change, at supports, attachments and joints, and where drag "
                "begins and ends",
                f"give at least {len(spans)}, or leave it out",
            )
        )
    return Division(rod.order or DEFAULT_ORDER, _filled(corners, _distribute(spans, rod.elements)))


def _filled(corners: Floats, counts: Integers) -> Floats:
    """Return the ends of elements, ``counts`` of equal length between each two of the ``corners``."""
    pieces = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(corners[:-1], corners[1:], counts, strict=True)]
    return np.concatenate([[0.0], *pieces])


def _order_between_kinks(rod: Rod, corners: Floats) -> int:
    """Return the order of elements that end at the kinks of sections.

    The compliance of a piece whose stiffness is linear, with the ratio R of its ends, is integrated by p Gauss points
    with an error that falls like ``((sqrt R - 1)/(sqrt R + 1))^(2 p)`` (the ellipse of analyticity through the zero of
    the stiffness: Trefethen 2013, Approximation Theory and Approximation Practice, theorem 19.3).
    """
    least = max(LEAST_ORDER, math.ceil(NODES_PER_ROD / (len(corners) - 1)))
    ratio = 1.0
    for a, b in pairwise(corners):
        slack = 1e-9 * (b - a)  # a jump belongs to neither side
        first, last = (np.diag(rod.matrices_at(float(s))[0]) for s in (a + slack, b - slack))
        ratio = max(ratio, float(np.maximum(first / last, last / first).max()))
    decay = (math.sqrt(ratio) + 1.0) / max(math.sqrt(ratio) - 1.0, 1e-12)
    needed = math.ceil(-math.log(KINK_ERROR) / (2.0 * math.log(decay)))
    return min(max(least, needed), DEFAULT_ORDER)


def _distinct(stations: list[float], length: float) -> Floats:
    ordered = np.sort(np.clip(stations, 0.0, length))
    return np.asarray(ordered[np.concatenate([[True], np.diff(ordered) > 1e-9 * length])])


def _distribute(spans: Floats, total: int) -> Integers:
    """Share elements among spans by length, at least one each (largest remainders)."""
    counts = np.ones(len(spans), dtype=np.int64)
    for _ in range(total - len(spans)):
        counts[np.argmax(spans / counts)] += 1
    return counts
