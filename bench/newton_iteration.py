"""One Newton iteration of a transient step as a multiple of LAPACK's band factorisation and solution alone.

    python bench/newton_iteration.py [--elements 10 100 1000] [--order 1]

An iteration is all of: poses from increments, assembly of residual and tangent (elastic, viscous, geometric, inertial,
supports), factorisation, solution, update of poses and section forces. LAPACK's part is dgbtrf + dgbtrs on the very
matrix of that iteration. Both are timed in turn in one process, best of many short rounds; the ratio is what counts.
The second table shows cost and memory per element from 50 to 10 000 elements, in one rod and in 1000 rods.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.linear.plan import plans
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha


def integrator_of(elements: int, order: int, rods: int = 1) -> GeneralizedAlpha:
    """The damped cantilever of Linn, Lang and Tuganov with many elements, on its way; or many of them side by side."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    for k in range(rods):
        y = 0.05 * k
        rod = vr.Rod.straight(
            (0, y, 0), (0.3, y, 0), section=section, material=material, elements=elements // rods, order=order
        )
        model.add(f"beam{k}", rod)
        model.clamp(f"beam{k}.start")
        model.force(f"beam{k}.end", (0, 0.01, 0.005))
    problem = discretise(model)
    system = GeometricSystem(problem)
    integrator = GeneralizedAlpha(
        system, SupportState(problem), **INTEGRATORS["generalized_alpha"].parameters
    )
    integrator.start(0.0, State.reference(problem))
    for k in range(1, 4):
        assert integrator.attempt(1e-3 * k, before=False).converged
        integrator.accept()
    return integrator


def best_of(function: Callable[[], object], rounds: int, repeats: int) -> float:
    best = np.inf
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(repeats):
            function()
        best = min(best, (time.perf_counter() - start) / repeats)
    return best


def bytes_of(*owners: object) -> int:
    """Bytes of all distinct arrays that objects of this package hold, directly or through each other."""
    found: dict[int, np.ndarray] = {}
    seen: set[int] = set()
    waiting = list(owners)
    while waiting:
        item = waiting.pop()
        if id(item) in seen:
            continue
        seen.add(id(item))
        if isinstance(item, np.ndarray):
            base = item if item.base is None else item.base
            if isinstance(base, np.ndarray):
                found[id(base)] = base
        elif isinstance(item, (list, tuple)):
            waiting.extend(item)
        elif type(item).__module__.startswith("viscorod"):
            held = [getattr(item, name, None) for name in getattr(type(item), "__slots__", ())]
            waiting.extend([*held, *getattr(item, "__dict__", {}).values()])
    return sum(array.nbytes for array in found.values())


def band_of(matrix: Matrix) -> np.ndarray:
    """The matrix as it was factorised, in LAPACK's storage."""
    plan = next(plans(matrix.pattern))  # nothing is condensed
    blocks, places = plan.kept.T
    first, step = plan.targets[places].T
    within = np.arange(6)
    band = np.zeros((6 * matrix.pattern.size, 3 * plan.width + 1))
    where = first[:, None, None] + step[:, None, None] * within[:, None] + within
    band.reshape(-1)[where] = matrix.blocks[blocks]
    return band


def measure(elements: int, order: int, rods: int = 1) -> tuple[float, float, int, int]:
    """Seconds of an iteration and of LAPACK's part, the number of unknowns, and bytes of problem and system."""
    integrator = integrator_of(elements, order, rods)
    system = integrator.system
    n = system.problem.size
    slope = 2e3
    relation = slope, np.zeros((n, 6)), np.zeros((n, 6))
    loads = integrator.loads.at(integrator.t)
    new = integrator.state.copy()
    increment = 1e-6 * np.random.default_rng(0).normal(size=(n, 6))
    increment[integrator.supports.set.nodes] = 0.0
    start = increment.copy()
    newton = integrator.newton
    newton.begin(integrator.state, new, increment, relation, loads)

    def iteration() -> None:
        increment[:] = start
        newton.run(0.0, 1)

    iteration()
    kept = band_of(system.matrix)
    width = (kept.shape[1] - 1) // 3
    work, right = np.empty_like(kept), np.ones(6 * n)

    def copy() -> None:
        np.copyto(work, kept)

    def lapack() -> None:
        np.copyto(work, kept)
        _, pivots, _ = dgbtrf(work.T, width, width, overwrite_ab=1)
        dgbtrs(work.T, width, width, right, pivots, overwrite_b=1)

    repeats = max(1, 400 // elements)
    ours = theirs = copied = np.inf
    for _ in range(max(10, min(50, 20_000 // elements))):  # in turn: all see the same noise
        ours = min(ours, best_of(iteration, 2, repeats))
        theirs = min(theirs, best_of(lapack, 2, repeats))
        copied = min(copied, best_of(copy, 2, repeats))
    return ours, theirs - copied, 6 * n, bytes_of(system.problem, system)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, nargs="+")
    parser.add_argument("--order", type=int, default=1)
    args = parser.parse_args()
    if args.elements:
        cases = [(count, args.order) for count in args.elements]
    else:
        cases = [(10, 1), (50, 1), (100, 1), (1000, 1), (4, 3), (33, 3), (333, 3)]
    print("order  elements  unknowns   iteration [us]  LAPACK [us]   ratio")
    for count, order in cases:
        ours, theirs, unknowns, _ = measure(count, order)
        print(
            f"{order:5d}  {count:8d}  {unknowns:8d}   {ours * 1e6:14.0f}  {theirs * 1e6:11.0f}   {ours / theirs:5.2f}"
        )
    if args.elements:
        return
    print("\n rods  elements  iteration per element [us]  against 100 elements  memory per element [bytes]")
    reference = measure(100, 1)[0] / 100
    for rods, count in ((1, 50), (1, 100), (1, 300), (1, 1000), (1, 3000), (1, 10_000), (1000, 10_000)):
        ours, _, _, memory = measure(count, 1, rods)
        per_element = ours / count
        print(
            f"{rods:5d}  {count:8d}  {per_element * 1e6:26.2f}  {per_element / reference:20.3f}  {memory / count:26.0f}"
        )


if __name__ == "__main__":
    main()
