"""Accuracy of meshes on the swinging cantilever of Linn, Lang and Tuganov, beside the time they take.

    python bench/mesh_accuracy.py

Tip deviation over length, largest over 10 s, against 4 elements of order 8 with the same time step. A second table
shows the error of the time step on the default mesh, against a step eight times smaller than the smallest.
"""

from __future__ import annotations

import os
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import viscorod as vr

LENGTH, DURATION, STEP = 0.3, 10.0, 0.005
MESHES = ((16, 1), (32, 1), (8, 2), (2, 3), (3, 3), (4, 3), (2, 5), (1, 8))


def swing(elements: int, order: int, step: float) -> tuple[np.ndarray, float]:
    """Tip positions at every 0.02 s and the seconds of the simulation."""
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (LENGTH, 0, 0), section=section, material=rubber, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    start = time.perf_counter()
    run = model.simulate(DURATION, time_step=step, output_interval=0.02)
    return run.history("beam.end").values, time.perf_counter() - start


def main() -> None:
    swing(2, 5, 0.02)  # kernels compiled and loaded
    exact, _ = swing(4, 8, STEP)
    print("mesh           nodes   error / L   time [s]")
    for elements, order in MESHES:
        tip, seconds = swing(elements, order, STEP)
        error = np.abs(tip - exact).max() / LENGTH
        print(f"{elements:3d} x order {order:2d}  {elements * order + 1:5d}   {error:9.1e}   {seconds:8.2f}")
    steps = (0.02, 0.01, 0.005, 0.0025)
    exact, _ = swing(2, 5, steps[-1] / 8)
    print("\ntime step [s]   error / L   time [s]")
    for step in steps:
        tip, seconds = swing(2, 5, step)
        print(f"{step:13g}   {np.abs(tip - exact).max() / LENGTH:9.1e}   {seconds:8.2f}")


if __name__ == "__main__":
    main()
