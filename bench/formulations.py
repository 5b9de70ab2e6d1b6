"""The intrinsic formulation beside the geometric one: cost of a Newton iteration, and whole runs at equal tolerance.

    python bench/formulations.py

A full Newton iteration of the midpoint rule is: forces of all elements, Jacobian, factorisation, solution, update of
poses, stresses and strains. It is compared with LAPACK's band factorisation and solution for a matrix of that band,
best of many short rounds in one process. Radau's step keeps its Jacobian: its iteration is the forces of three stages
and the solutions. Errors of whole runs are distances of the tip from a run at a tolerance of 1e-9 on a finer mesh.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from scipy.linalg.lapack import dgbtrf, dgbtrs

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.registry import FORMULATIONS
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.plan import plans
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators.collocation import Collocation
from viscorod.solve.transient.integrators.loop_data import OF_START
from viscorod.solve.transient.integrators.midpoint import Midpoint
from viscorod.solve.transient.integrators.radau import Radau

NAMES = ("geometric", "intrinsic")
MESHES = ((1, 5), (4, 5), (33, 3), (100, 1))
"""Elements and order of the cantilevers whose iterations are timed."""
ROUNDS, REPEATS = 300, 5
"""Of iterations, and of whole runs, of which the best counts."""
RUNS = ((1, 5, 1e-4), (1, 7, 1e-5), (2, 6, 1e-6), (4, 6, 1e-7))
"""Elements, order and tolerance of whole runs."""


def cantilever(elements: int, order: int) -> vr.Model:
    """The released cantilever of Linn, Lang and Tuganov."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (0.3, 0, 0), section=section, material=material, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    return model


def hinged(elements: int, order: int) -> vr.Model:
    """AWP V.B, eta = 0.001 s."""
    stiffness = np.diag([5e3, 5e3, 1e5, 1.0, 2.0, 1.0])
    section = vr.StiffnessSection(stiffness, np.diag([1, 1, 1, 2e-4, 2e-4, 4e-4]), 1e-3 * stiffness)
    model = vr.Model()
    model.add("beam", vr.Rod.straight((0, 0, 0), (1, 0, 0), section=section, elements=elements, order=order))
    model.support("beam.start", ("ux", "uy", "uz"))
    model.moment("beam.end", (0.5, 0.5, 0), following=True, time=vr.Sine(2.0), until=0.5)
    return model


MOTIONS = {
    "cantilever": (cantilever, 0.3, 10.0, {}),
    "hinged": (hinged, 1.0, 2.0, {"initial": "reference"}),
}
"""The models of whole runs, their lengths [m], durations [s] and settings."""


def moving(method: type[Collocation], formulation: str, elements: int, order: int) -> Collocation:
    """An integrator that has made a few steps with the cantilever."""
    problem = discretise(cantilever(elements, order))
    system = FORMULATIONS[formulation, "full"].make(problem)
    given = {"tolerance": 1e-4} if method is Radau else {}
    integrator = method(system, SupportState(problem), **given)
    state = State.reference(problem)
    state.twist[:, 1] = 0.01 * problem.positions[:, 0]
    integrator.start(0.0, state)
    for k in range(1, 4):
        assert integrator.attempt(1e-3 * k, before=False).converged
        integrator.accept()
    return integrator


def best_in_turn(functions: list[Callable[[], object]]) -> list[float]:
    """Best seconds of each function, all called in turn, so that slow moments of the machine meet all of them."""
    best = [np.inf] * len(functions)
    for _ in range(ROUNDS):
        for k, function in enumerate(functions):
            start = time.perf_counter()
            function()
            best[k] = min(best[k], time.perf_counter() - start)
    return best


def step_of(integrator: Collocation, limit: int) -> Callable[[], int]:
    """A step of 1 ms that iterates ``limit`` times at most with a frozen Jacobian; it returns how often."""
    h = 1e-3
    integrator.renew_jacobian(h, at_start=True)
    integrator._factorise(h)
    integrator.newton_tolerance = 0.0  # goes on as long as it may and gets nearer

    def step() -> int:
        integrator.iterations = limit
        integrator._have_jacobian, integrator._fresh_jacobian = True, OF_START
        integrator._factor_step = h
        return integrator.attempt(integrator.t + h, before=False).iterations

    return step


def lapack_of(integrator: Collocation) -> list[Callable[[], object]]:
    """Copying a matrix of the integrator's band, and copying, factorising and solving with it."""
    pattern = integrator.system.problem.pattern
    width = next(plans(pattern)).width
    matrix = np.random.default_rng(0).normal(size=(6 * pattern.size, 3 * width + 1))
    matrix[:, 2 * width] += 100.0
    work, right = np.empty_like(matrix), np.ones(len(matrix))

    def solve() -> None:
        np.copyto(work, matrix)
        _, pivots, _ = dgbtrf(work.T, width, width, overwrite_ab=1)
        dgbtrs(work.T, width, width, right, pivots)

    return [lambda: np.copyto(work, matrix), solve]


def newton_table() -> None:
    """Print what iterations cost."""
    print("Newton iteration: milliseconds, and the full one over LAPACK's factorisation and solution")
    print("mesh            formulation  iteration  Jacobian  factors    full  / LAPACK   radau's iteration")
    for elements, order in MESHES:
        functions: list[Callable[[], object]] = []
        counts = []
        for name in NAMES:
            middle, radau = (moving(method, name, elements, order) for method in (Midpoint, Radau))
            steps = [step_of(integrator, limit) for integrator in (middle, radau) for limit in (1, 2)]
            counts.append([step() for step in steps])
            functions += [
                *steps,
                partial(middle.renew_jacobian, 1e-3, at_start=True),
                partial(middle._factorise, 1e-3),
            ]
        copy, solve = best_in_turn(lapack_of(middle))
        seconds = np.array(best_in_turn(functions)).reshape(2, -1)
        for name, count, best in zip(NAMES, counts, seconds, strict=True):
            each = (best[1] - best[0]) / (count[1] - count[0])
            radau_each = (best[3] - best[2]) / (count[3] - count[2])
            full = each + best[4] + best[5]
            print(
                f"{elements:4d} x order {order}  {name:>11}  {1e3 * each:9.3f}  {1e3 * best[4]:8.3f}  "
                f"{1e3 * best[5]:7.3f} {1e3 * full:7.3f}  {full / (solve - copy):8.2f}  {1e3 * radau_each:12.3f}"
            )


def run_table() -> None:
    """Print accuracy and time of whole runs."""
    print("\nWhole runs: error of the tip over the length")
    print("case        mesh         tolerance  formulation   steps  iterations      error  loop [ms]")
    for case, (make, length, duration, given) in MOTIONS.items():
        interval = {"output_interval": duration / 200}
        fine = make(6, 6).simulate(duration, tolerance=1e-9, **given, **interval)
        reference = fine.data["position"].values[:, -1]
        for elements, order, tolerance in RUNS:
            for name in NAMES:
                best = np.inf
                for _ in range(REPEATS):
                    model = make(elements, order)
                    run = model.simulate(duration, tolerance=tolerance, formulation=name, **given, **interval)
                    best = min(best, run.data.attrs["loop_time_s"])
                attrs, tip = run.data.attrs, run.data["position"].values[:, -1]
                error = np.linalg.norm(tip - reference, axis=1).max() / length
                print(
                    f"{case:10}  {elements} x order {order}  {tolerance:9g}  {name:>11}  {attrs['steps']:6d}  "
                    f"{attrs['iterations']:10d}  {error:9.2e}  {1e3 * best:9.1f}"
                )


if __name__ == "__main__":
    began = time.perf_counter()
    newton_table()
    run_table()
    print(f"\n{time.perf_counter() - began:.0f} s")
