"""Swings of the tutorial's cantilever over retardation times: in one process, in several, in threads.

    python bench/sweep.py [--members 1000] [--workers 2] [--tolerance 1e-4]

Times are those of the whole call. The first sweep in several processes starts the one that they are copies of; a second
sweep of the same script finds it there. Members are the same to the last bit whatever computes them.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np

import viscorod as vr

CASE = Path(__file__).parents[1] / "examples" / "cantilever_swing.toml"
TIME = "materials.rubber.damping.shear_time"
TIP = {"tip": ("displacement", "beam.end", "y", "last")}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, default=1000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--tolerance", type=float, default=1e-4)
    parser.add_argument("--threads", action="store_true", help="measure threads of this process too")
    args = parser.parse_args()
    case = vr.load_case(CASE)
    given: dict[str, Any] = {
        "quantities": TIP,
        "errors": 0,
        "constants": {"simulate.tolerance": args.tolerance},
    }
    values = {TIME: np.linspace(0.01, 0.05, args.members)}
    vr.sweep(case, {TIME: [0.01, 0.02]}, workers=1, **given)  # kernels are in memory from here on
    ways = [
        ("one process", {"workers": 1}),
        (f"{args.workers} processes, first", {"workers": args.workers}),
        (f"{args.workers} processes, again", {"workers": args.workers}),
    ]
    if args.threads:
        ways.append((f"{args.workers} threads", {"executor": f"threads:{args.workers}"}))
    print(f"{args.members} swings, tolerance {args.tolerance:g}")
    print(f"{'':22s}  time [s]  each [ms]  times as fast  this process computed [s]")
    alone, tips = 0.0, None
    for name, how in ways:
        begin, used = time.perf_counter(), time.process_time()
        table = vr.sweep(case, values, **how, **given).table()
        taken, used = time.perf_counter() - begin, time.process_time() - used
        alone, tips = alone or taken, table["tip"].tolist() if tips is None else tips
        assert table["tip"].tolist() == tips
        print(
            f"{name:22s}  {taken:8.1f}  {1e3 * taken / args.members:9.1f}  {alone / taken:13.2f}  {used:25.1f}"
        )


if __name__ == "__main__":
    main()
