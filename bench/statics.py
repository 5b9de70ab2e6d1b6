"""The 45-degree bend of Bathe and Bolourchi from the model to the answer, and what each part takes.

    python bench/statics.py [--rounds 200]

One process, after a first call that loads the kernels. The whole call is ``model.equilibrium()``; the data set is
built when something is first read from the result.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import viscorod as vr
from viscorod.analyses.case_run import as_model
from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.problem.discretise import discretise
from viscorod.solve.statics.tangent import negative_eigenvalues

CASE = Path(__file__).parents[1] / "examples" / "bend_45.toml"


def timed(function: Callable[[], object], rounds: int) -> tuple[float, float]:
    """Best and median time of a call [ms]."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        function()
        times.append(1e3 * (time.perf_counter() - start))
    return min(times), median(times)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=200)
    rounds = parser.parse_args().rounds
    model = as_model(vr.load_case(CASE).description)
    model.equilibrium()

    work = DiscreteModel.of(model)
    state = State.reference(work.problem)
    work.static.solve(state)
    tangent = work.static.tangent(state)

    def solve() -> None:
        work.system.assemble(
            State.reference(work.problem), work.static.loads.at(0.0), None, tangent=False, moving=False
        )
        work.system.reset_stress()  # as in a fresh system
        work.static.solve(State.reference(work.problem))

    rows = {
        "model.equilibrium()": model.equilibrium,
        "  discretise": lambda: discretise(model),
        "  discretise and set up": lambda: DiscreteModel.of(model),
        "  find the equilibrium": solve,
        "  tangent there": lambda: work.static.tangent(state),
        "  count its negative eigenvalues": lambda: negative_eigenvalues(tangent),
        "with its data set": lambda: model.equilibrium().data,
        "with its report": lambda: model.equilibrium().report(),
    }
    print(f"{'':34s}{'best [ms]':>10s}{'median [ms]':>12s}")
    for name, function in rows.items():
        best, middle = timed(function, rounds)
        print(f"{name:34s}{best:10.2f}{middle:12.2f}")


if __name__ == "__main__":
    main()
