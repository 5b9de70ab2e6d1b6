"""Direct solvers of block matrices: LAPACK's band, condensed element interiors, sparse LU.

    python bench/linear_solvers.py

Random matrices with the patterns of chains of elements, a frame in space and a lattice, real and complex, much as
stiffness matrices are: every element adds a positive definite matrix and a little that is not symmetric. Times are the
best of many; the plan that is chosen by estimated time is marked.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable

import numpy as np
from scipy.spatial import cKDTree

from viscorod.solve.linear.direct import DirectSolver
from viscorod.solve.linear.pattern import Pattern
from viscorod.solve.linear.plan import Plan, plans
from viscorod.typing import Floats, Integers

SECONDS = 0.3
"""For which an action is repeated."""
TOO_SLOW = 10.0
"""Plans estimated to take so many times the best one are left out."""


class Model:
    """Elements of one order between joints ``members (count, 2)``."""

    def __init__(self, joints: int, members: Integers, order: int) -> None:
        inner = joints + np.arange(len(members) * (order - 1)).reshape(len(members), order - 1)
        self.elements = np.concatenate([members[:, :1], inner, members[:, 1:]], axis=1)
        self.pattern = Pattern.of(joints + inner.size, [self.elements])
        self.interiors = [inner] if order > 1 else []

    def values(self, kind: type) -> Floats:
        """Random blocks ``(b, 6, 6)``."""
        rng = np.random.default_rng(0)
        count, nodes = self.elements.shape
        n = 6 * nodes
        factor = rng.normal(size=(count, n, 2 * n))
        full = (factor @ factor.swapaxes(1, 2) / (2 * n) + 0.02 * rng.normal(size=(count, n, n))).astype(kind)
        if kind is complex:
            full *= 1.0 + 0.5j
        blocks = np.zeros((len(self.pattern.rows), 6, 6), dtype=kind)
        blocks[self.pattern.diagonal] = 0.5 * np.eye(6)
        split = full.reshape(count, nodes, 6, nodes, 6).transpose(0, 1, 3, 4, 2)
        np.add.at(blocks, self.pattern.slots(self.elements), split)
        return blocks


def chain(count: int, order: int) -> Model:
    return Model(count + 1, np.column_stack([np.arange(count), np.arange(1, count + 1)]), order)


def frame(joints: int, members: int, order: int) -> Model:
    """Joints at random places, members between near ones."""
    rng = np.random.default_rng(1)
    places = rng.random((joints, 3))
    near = cKDTree(places).query(places, k=9)[1][:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(joints), 8), near.ravel()])
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    return Model(joints, pairs[rng.permutation(len(pairs))[:members]], order)


def lattice(n: int, order: int) -> Model:
    grid = np.arange(n**3).reshape(n, n, n)
    ends = [(grid[:-1], grid[1:]), (grid[:, :-1], grid[:, 1:]), (grid[:, :, :-1], grid[:, :, 1:])]
    return Model(n**3, np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in ends]), order)


MODELS: dict[str, Callable[[], Model]] = {
    "2 of order 5": lambda: chain(2, 5),
    "1 of order 8": lambda: chain(1, 8),
    "20 of order 5": lambda: chain(20, 5),
    "100 of order 1": lambda: chain(100, 1),
    "lattice 3x3x3, order 5": lambda: lattice(3, 5),
    "frame of 1000, order 5": lambda: frame(400, 1000, 5),
}


def best(action: Callable[[], object]) -> float:
    """Return the shortest time [us] of an action that is repeated for a while."""
    action()  # may compile
    found, end = np.inf, time.perf_counter() + SECONDS
    while True:
        begin = time.perf_counter()
        action()
        now = time.perf_counter()
        found = min(found, now - begin)
        if now > end:
            return 1e6 * found


def measure(plan: Plan, blocks: Floats, kind: type) -> tuple[float, float]:
    """Return the times of a factorisation and of a solution [us]."""
    solver = DirectSolver(plan, kind)
    b, x = np.ones(6 * plan.pattern.size, dtype=kind), np.empty(6 * plan.pattern.size, dtype=kind)

    def solve() -> None:
        x[:] = b
        solver.solve(x)

    factorise = best(lambda: solver.factorise(blocks))
    return factorise, best(solve)


def main() -> None:
    print(f"{'model':24}{'':58}{'real [us]':>20}{'complex [us]':>22}")
    print(f"{'':82}{'factorise':>11}{'solve':>9}{'factorise':>13}{'solve':>9}")
    for name, make in MODELS.items():
        model = make()
        ways = list(plans(model.pattern, model.interiors))
        chosen = min(ways, key=lambda plan: plan.cost)
        blocks = {kind: model.values(kind) for kind in (float, complex)}
        for plan in ways:
            if plan.cost < TOO_SLOW * chosen.cost:
                real, pair = (measure(plan, blocks[kind], kind) for kind in (float, complex))
                mark = "*" if plan is chosen else " "
                print(
                    f"{name:24}{mark} {plan.description:56}"
                    f"{real[0]:11.1f}{real[1]:9.2f}{pair[0]:13.1f}{pair[1]:9.2f}"
                )


if __name__ == "__main__":
    main()
