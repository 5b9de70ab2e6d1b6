"""Accuracy of meshes and integrators on the swinging cantilever of Linn, Lang and Tuganov, beside the time they take.

    python bench/mesh_accuracy.py

Tip deviation over length, largest over 10 s, against 4 elements of order 8 at a tolerance of 1e-9. The meshes are
integrated at a tolerance of 1e-6, so that what is left is their own error; integrators run on 2 elements of order 5.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import viscorod as vr

LENGTH, DURATION = 0.3, 10.0
MESHES = ((16, 1), (32, 1), (8, 2), (2, 3), (3, 3), (4, 3), (2, 5), (1, 8))
METHODS: tuple[dict[str, float | str], ...] = (
    *({"integrator": "radau", "tolerance": tolerance} for tolerance in (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)),
    *({"integrator": "generalized_alpha", "time_step": step} for step in (0.02, 0.01, 0.005, 0.0025)),
    *({"integrator": "generalized_alpha", "tolerance": tolerance} for tolerance in (1e-2, 1e-3)),
    *({"integrator": "midpoint", "time_step": step} for step in (0.02, 0.01, 0.005)),
)


def swing(elements: int, order: int, **given: float | str) -> tuple[np.ndarray, float, int]:
    """Tip positions at every 0.02 s, seconds of the time loop, steps."""
    rubber = vr.Material(1e6, poissons_ratio=0.3, density=1000.0, damping=vr.KelvinVoigt(0.02, 0.02))
    section = vr.Rectangle(0.01, 0.01)
    model = vr.Model()
    rod = vr.Rod.straight(
        (0, 0, 0), (LENGTH, 0, 0), section=section, material=rubber, elements=elements, order=order
    )
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 0.035, 0), until=0.0)
    run = model.simulate(DURATION, output_interval=0.02, **given)
    return run.history("beam.end").values, float(run.data.attrs["loop_time_s"]), int(run.data.attrs["steps"])


def main() -> None:
    """Print both tables."""
    for method in METHODS:
        swing(2, 5, **method)  # kernels compiled and loaded
    exact, _, _ = swing(4, 8, tolerance=1e-9)

    def line(label: str, tip: np.ndarray, seconds: float, steps: int) -> None:
        print(f"| {label} | {np.abs(tip - exact).max() / LENGTH:.1e} | {steps} | {1e3 * seconds:.0f} ms |")

    print("| mesh | nodes | error / L | steps | time loop |\n|---|---|---|---|---|")
    for elements, order in MESHES:
        line(f"{elements} x order {order} | {elements * order + 1}", *swing(elements, order, tolerance=1e-6))
    print("\n| integrator | error / L | steps | time loop |\n|---|---|---|---|")
    for method in METHODS:
        line(", ".join(f"{name} {value}" for name, value in method.items()), *swing(2, 5, **method))


if __name__ == "__main__":
    main()
