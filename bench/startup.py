"""Start-up: imports, a warm and a cold run of the demo, all kernels: processor time of whole processes and children.

    python bench/startup.py [--rounds 3]
    python bench/startup.py --runs [--rounds 3] [--against ../earlier/src]

Cold ones use an empty cache of compiled kernels. Nothing is compiled aside. With ``--runs`` it tells what runs cost
beside their loops of steps, in processes that have computed them before: equilibrium, discretisation, small motions,
estimates of errors, data set. ``--against`` the sources of another version, in turns with this one.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

EXAMPLES = Path(__file__).parents[1] / "examples"
CASE = EXAMPLES / "cantilever_swing.toml"
SOURCES = Path(__file__).parents[1] / "src"
MEMBERS = 10
"""Of the sweep whose members are timed."""
REPEATS = 8


def seconds(command: list[str], **environment: str) -> float:
    """Return the processor time of a command [s], of user and system."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    alone = {"VISCOROD_COMPILES_ASIDE": "1"}
    subprocess.run(command, check=True, capture_output=True, env=os.environ | alone | environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def runs() -> dict[str, Callable[[], object]]:
    """What computes each of the runs that are timed."""
    import viscorod as vr
    from viscorod.analyses.case_run import run_case

    sys.path.insert(0, str(Path(__file__).parent))
    from peers.cases import CASES

    swing, comb = vr.load_case(CASE), vr.load_case(EXAMPLES / "comb_resonator.toml")
    members = {
        "materials.rubber.damping.shear_time": np.linspace(0.02, 0.03, MEMBERS),
        "simulate.duration": MEMBERS * [0.3],
    }
    quantities = {"tip": ("displacement", "beam.end", "z", "last")}
    return {
        "steel string, 2 x order 6, 1e-4": lambda: CASES["string"].simulate(2, 6, 1e-4),
        "cantilever_swing": lambda: run_case(swing),
        f"member of a sweep of {MEMBERS}, 0.3 s": lambda: vr.sweep(
            swing, members, workers=1, quantities=quantities, errors=0
        ),
        "comb_resonator": lambda: run_case(comb),
    }


def timed() -> dict[str, tuple[float, float]]:
    """Return the least processor time [s] of every run, and that beside its loop of steps."""
    from viscorod.solve.transient.transient_solver import Transient

    loop, integrate = 0.0, Transient.run

    def run(self: Transient, *given: object, **named: object) -> object:
        nonlocal loop
        began = time.process_time()
        try:
            return integrate(self, *given, **named)
        finally:
            loop += time.process_time() - began

    Transient.run = run
    found = {}
    for name, compute in runs().items():
        best = (np.inf, np.inf)
        for repeat in range(REPEATS + 3):
            began, loop = time.process_time(), 0.0
            compute()
            whole = time.process_time() - began
            if repeat >= 3:  # what is loaded or compiled at first is no part of it
                best = min(best[0], whole), min(best[1], whole - loop)
        count = MEMBERS if "member" in name else 1
        found[name] = best[0] / count, best[1] / count
    return found


def compare(rounds: int, others: list[Path]) -> None:
    """Print what runs cost, of this version and of others in turns."""
    best: dict[tuple[str, Path], np.ndarray] = {}
    for _ in range(rounds):
        for sources in (*others, SOURCES):
            paths = os.environ | {"PYTHONPATH": str(sources), "VISCOROD_COMPILES_ASIDE": "1"}
            command = [sys.executable, __file__, "--timed"]
            told = subprocess.run(command, check=True, capture_output=True, text=True, env=paths).stdout
            for name, times in json.loads(told.splitlines()[-1]).items():
                key = name, sources
                best[key] = np.minimum(best.get(key, np.inf), np.array(times))
    print(f"{'processor time [ms]':46s}{'whole':>9s}{'beside':>9s}")
    for (name, sources), times in sorted(best.items(), key=lambda item: item[0][0]):
        label = name if sources == SOURCES else f"{name} (against)"
        print(f"{label:46s}{1e3 * times[0]:9.1f}{1e3 * times[1]:9.1f}", end="")
        for other in others if sources == SOURCES else ():
            ratio = times / best[name, other]
            print(f"   ratios {ratio[0]:.2f}, {ratio[1]:.2f}", end="")
        print()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--runs", action="store_true")
    parser.add_argument("--against", type=Path, nargs="*", default=[])
    parser.add_argument("--timed", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.timed:
        print(json.dumps(timed()))
        return
    if args.runs:
        compare(args.rounds, [path.resolve() for path in args.against])
        return
    rounds = args.rounds
    bare = [sys.executable, "-c", "pass"]
    package = [sys.executable, "-c", "import viscorod"]
    imports = [sys.executable, "-c", "import viscorod as vr; vr.Model, vr.Rod, vr.Material"]
    used = "numba,scipy.linalg,scipy.sparse.csgraph,scipy.interpolate,h5netcdf,pydantic,typer"
    drawn = "matplotlib.figure,matplotlib.backends.backend_agg"
    # with as little garbage collection as the command has, and its end
    libraries = [
        sys.executable,
        "-c",
        f"import gc,os;gc.set_threshold(100_000);import {used},{drawn};os._exit(0)",
    ]
    with tempfile.TemporaryDirectory() as folder:
        run = [sys.executable, "-m", "viscorod", "run", str(CASE), "-o", folder]
        seconds(run)  # kernels are on disk from here on
        warmup = [sys.executable, "-m", "viscorod", "warmup"]
        rows = {
            "python alone": [seconds(bare) for _ in range(rounds)],
            "import viscorod": [seconds(package) for _ in range(rounds)],
            "import viscorod and its model": [seconds(imports) for _ in range(rounds)],
            "the libraries that a run needs": [seconds(libraries) for _ in range(rounds)],
            "warm run of the demo": [seconds(run) for _ in range(rounds)],
            "cold run of the demo": [seconds(run, NUMBA_CACHE_DIR=f"{folder}/numba")],
            "all kernels, cold": [seconds(warmup, NUMBA_CACHE_DIR=f"{folder}/all")],
            "all kernels, from disk": [
                seconds(warmup, NUMBA_CACHE_DIR=f"{folder}/all") for _ in range(rounds)
            ],
        }
    print(f"{'':32s}{'best [s]':>9s}{'worst [s]':>10s}")
    for name, values in rows.items():
        print(f"{name:32s}{min(values):9.2f}{max(values):10.2f}")


if __name__ == "__main__":
    main()
