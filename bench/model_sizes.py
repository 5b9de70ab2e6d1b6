"""Cost per element and step from one element to 10 000, in one rod and in 1000 rods, with the default integrator.

    python bench/model_sizes.py

Damped cantilevers of elements of order 1 fall under their weight for 25 equal steps of Radau IIA; the time is that of
the loop over steps, best of three, and its Jacobians, factorisations and stored states are in it. Memory is what the
arrays of problem, system and integrator take.
"""

from __future__ import annotations

import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from newton_iteration import bytes_of

import viscorod as vr
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.geometric_system import GeometricSystem
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.transient.integrators.radau import Radau
from viscorod.solve.transient.step_control import FixedSteps
from viscorod.solve.transient.transient_solver import Transient

STEPS = 25
SIZES = ((1, 1), (1, 10), (1, 50), (1, 100), (1, 300), (1, 1000), (1, 3000), (1, 10_000), (1000, 10_000))
"""Rods and elements in all."""


def model_of(rods: int, elements: int) -> vr.Model:
    """Rubber cantilevers side by side, 0.3 m long."""
    material = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    for k in range(rods):
        y = 0.02 * k
        rod = vr.Rod.straight(
            (0, y, 0), (0.3, y, 0), section=section, material=material, elements=elements // rods, order=1
        )
        model.add(f"rod{k}", rod)
        model.clamp(f"rod{k}.start")
    model.gravity((0, 0, -9.81))
    return model


def measure(rods: int, elements: int) -> tuple[float, float, float]:
    """Seconds per step, iterations per step, bytes of all arrays."""
    problem = discretise(model_of(rods, elements))
    best, iterations, memory = np.inf, 0.0, 0
    for _ in range(3):
        system, supports = GeometricSystem(problem), SupportState(problem)
        state = State.reference(problem)
        integrator = Radau(system, supports, tolerance=1e-4)
        run = Transient(problem, integrator, FixedSteps(2e-3))
        begin = time.perf_counter()
        result = run.run(state, 2e-3 * STEPS, output_interval=2e-3 * STEPS)
        best = min(best, time.perf_counter() - begin)
        iterations = result.effort.iterations / result.effort.steps
        memory = bytes_of(problem, system, integrator)
    return best / STEPS, iterations, memory


def main() -> None:
    """Print the table."""
    measure(1, 2)
    rows = [(rods, elements, *measure(rods, elements)) for rods, elements in SIZES]
    reference = next(
        seconds / elements for rods, elements, seconds, *_ in rows if (rods, elements) == (1, 100)
    )
    print(
        "| rods | elements | per step | iterations | per element and step | against 100 elements | memory per element |"
    )
    print("|---|---|---|---|---|---|---|")
    for rods, elements, seconds, iterations, memory in rows:
        each = seconds / elements
        print(
            f"| {rods} | {elements} | {1e3 * seconds:.3g} ms | {iterations:.1f} | {1e6 * each:.3g} us "
            f"| {each / reference:.2f} | {memory / elements / 1e3:.3g} kB |"
        )


if __name__ == "__main__":
    main()
