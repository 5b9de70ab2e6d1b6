"""A sweep of the tutorial's cantilever over retardation times, in one process and in several.

    python bench/sweep.py [--members 8] [--workers 2] [--duration 60]

Times are those of the whole call, which starts processes (a second or two each); processor time tells what a busy
machine hides.
"""

from __future__ import annotations

import argparse
import os
import time
from pathlib import Path

import numpy as np

import viscorod as vr

CASE = Path(__file__).parents[1] / "examples" / "cantilever_swing.toml"


def processor_time() -> float:
    """Seconds that this process and those that it started and that have ended have computed."""
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--duration", type=float, default=60.0)
    args = parser.parse_args()
    case = vr.load_case(CASE)
    values = {
        "materials.rubber.damping.shear_time": np.linspace(0.01, 0.05, args.members),
        "simulate.duration": args.members * [args.duration],
    }
    first = {key: column[:1] for key, column in values.items()}
    vr.sweep(case, first, workers=1)  # kernels are in memory from here on
    print(f"{args.members} members of {args.duration:g} s\nprocesses   time [s]  processor time [s]")
    for workers in (1, args.workers):
        begin, used = time.perf_counter(), processor_time()
        vr.sweep(case, values, workers=workers)
        print(f"{workers:9d}  {time.perf_counter() - begin:9.1f}  {processor_time() - used:18.1f}")


if __name__ == "__main__":
    main()
