"""One Newton iteration of a transient step as a multiple of LAPACK's band factorisation and solution alone.

    python bench/newton_iteration.py [--elements 10 100 1000] [--order 1]

An iteration is all of: poses from increments, assembly of residual and tangent (elastic, viscous, geometric, inertial,
supports), factorisation, solution, update of poses and section forces. LAPACK's part is dgbtrf + dgbtrs on the
very matrix of
that iteration. Both are timed in turn in one process, best of several rounds; the ratio is what counts. The second
table
shows the cost per element from 100 to 10 000 elements.
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
from viscorod.solve.discretise import discretise
from viscorod.solve.geometric_system import GeometricSystem
from viscorod.solve.integrators.generalized_alpha import GeneralizedAlpha, Relation
from viscorod.solve.support_state import SupportState
from viscorod.solve.system import State


def integrator_of(elements: int, order: int) -> GeneralizedAlpha:
    """The damped cantilever of Linn, Lang and Tuganov with many elements, on its way."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    model = vr.Model()
    section = vr.Rectangle(0.01, 0.01)
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.01, 0.005))
    problem = discretise(model)
    system = GeometricSystem(problem)
    integrator = GeneralizedAlpha(system, SupportState(problem))
    n = problem.size
    integrator.start(0.0, State(problem.positions.copy(), problem.quaternions.copy(), np.zeros((n, 6))))
    for k in range(1, 4):
        assert integrator.step(1e-3 * k, before=False).converged
    return integrator


def best_of(function: Callable[[], object], rounds: int, repeats: int) -> float:
    best = np.inf
    for _ in range(rounds):
        start = time.perf_counter()
        for _ in range(repeats):
            function()
        best = min(best, (time.perf_counter() - start) / repeats)
    return best


def measure(elements: int, order: int) -> tuple[float, float, int]:
    """Seconds of an iteration and of LAPACK's part, and the number of unknowns."""
    integrator = integrator_of(elements, order)
    system = integrator.system
    n = system.problem.size
    slope = 2e3
    relation = Relation(slope, np.zeros((n, 6)), np.zeros((n, 6)))
    loads = integrator.loads.at(integrator.t)
    new = integrator.state.copy()
    increment = 1e-6 * np.random.default_rng(0).normal(size=(n, 6))
    increment[0] = 0.0
    start = increment.copy()

    def iteration() -> None:
        increment[:] = start
        integrator.iterate(new, increment, relation, loads)

    band = system.band
    factorise, kept = band.factorise, np.empty_like(band.data)

    def spy() -> None:
        kept[:] = band.data
        factorise()

    band.factorise = spy  # type: ignore[method-assign]
    iteration()
    band.factorise = factorise  # type: ignore[method-assign]
    work, right = np.empty_like(kept), np.ones(6 * n)

    def copy() -> None:
        np.copyto(work, kept)

    def lapack() -> None:
        np.copyto(work, kept)
        _, pivots, _ = dgbtrf(work.T, band.width, band.width, overwrite_ab=1)
        dgbtrs(work.T, band.width, band.width, right, pivots, overwrite_b=1)

    repeats = max(2, 4000 // elements)
    ours = theirs = np.inf
    for _ in range(5):  # in turn: both see the same noise
        ours = min(ours, best_of(iteration, 2, repeats))
        theirs = min(theirs, best_of(lapack, 2, repeats) - best_of(copy, 2, repeats))
    return ours, theirs, 6 * n


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elements", type=int, nargs="+", default=[10, 100, 1000])
    parser.add_argument("--order", type=int, default=1)
    args = parser.parse_args()
    print(f"order {args.order}")
    print("elements  unknowns   iteration [us]  LAPACK [us]   ratio")
    for count in args.elements:
        ours, theirs, unknowns = measure(count, args.order)
        print(f"{count:8d}  {unknowns:8d}   {ours * 1e6:14.0f}  {theirs * 1e6:11.0f}   {ours / theirs:5.2f}")
    print("\nelements  iteration per element [us]  against 100 elements")
    reference = None
    for count in (100, 1000, 10_000):
        per_element = measure(count, args.order)[0] / count
        reference = reference or per_element
        print(f"{count:8d}  {per_element * 1e6:26.2f}  {per_element / reference:20.3f}")


if __name__ == "__main__":
    main()
