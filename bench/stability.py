"""Equilibrium and slowest modes of a cantilever, shearable and Kirchhoff, over the number of its elements.

    python bench/stability.py [--rounds 5]

An equilibrium counts its negative eigenvalues; conditions of held strains are beside it. One process, best of some
rounds after a call that loads the kernels; ratios are those of one run.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from functools import partial

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import viscorod as vr

ELEMENTS = (4, 30, 60, 200, 600)


def cantilever(elements: int, constraints: str | tuple[str, ...]) -> vr.Model:
    """Of length and bending stiffness 1, with an end force across it."""
    section = vr.StiffnessSection([1e6] * 3 + [1.0] * 3, [1, 1, 1, 1e-3, 1e-3, 2e-3])
    rod = vr.Rod.straight(
        (0, 0, 0), (1, 0, 0), section=section, constraints=constraints, elements=elements, order=5
    )
    model = vr.Model()
    model.add("beam", rod)
    model.clamp("beam.start")
    model.force("beam.end", (0, 1.0, 0))
    return model


def best(function: Callable[[], object], rounds: int) -> float:
    """Least time of a call [ms]."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return 1e3 * min(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    rounds = parser.parse_args().rounds
    for constraints in ((), "kirchhoff"):
        model = cantilever(2, constraints)
        model.equilibrium()
        model.modes(6)
    print(f"{'':14s}{'equilibrium [ms]':^36s}{'six modes [ms]':^36s}")
    print(f"{'elements':14s}" + 2 * f"{'shearable':>12s}{'Kirchhoff':>12s}{'ratio':>12s}")
    for elements in ELEMENTS:
        row = f"{elements:<14d}"
        for compute in (vr.Model.equilibrium, lambda model: model.modes(6)):
            free, held = (
                best(partial(compute, cantilever(elements, constraints)), rounds)
                for constraints in ((), "kirchhoff")
            )
            row += f"{free:12.1f}{held:12.1f}{held / free:12.1f}"
        print(row, flush=True)


if __name__ == "__main__":
    main()
