"""Start-up: imports, a warm and a cold run of the demo, all kernels: processor time of whole processes and children.

    python bench/startup.py [--rounds 3]

Cold ones use an empty cache of compiled kernels. Nothing is compiled aside.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

CASE = Path(__file__).parents[1] / "examples" / "cantilever_swing.toml"


def seconds(command: list[str], **environment: str) -> float:
    """Return the processor time of a command [s], of user and system."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    alone = {"VISCOROD_COMPILES_ASIDE": "1"}
    subprocess.run(command, check=True, capture_output=True, env=os.environ | alone | environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    rounds = parser.parse_args().rounds
    bare = [sys.executable, "-c", "pass"]
    package = [sys.executable, "-c", "import viscorod"]
    imports = [sys.executable, "-c", "import viscorod as vr; vr.Model, vr.Rod, vr.Material"]
    used = "numba,scipy.linalg,scipy.sparse,scipy.optimize,scipy.interpolate,xarray,h5netcdf,pydantic,typer"
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
