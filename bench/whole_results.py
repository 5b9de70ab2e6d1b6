"""What whole results of members cost: kept in memory and in a folder, read, saved as a store, read from that.

    python bench/whole_results.py [--members 64] [--repeats 1] [--duration 2.0] [--workers 2]

Members are swings of the tutorial's cantilever, stored at 200 times; times are processor time of each, in this process.
The store is written once more by workers, of which the wall time is told beside it.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import viscorod as vr
from viscorod.analyses.sweeps.executors import engine

CASE = Path(__file__).parents[1] / "examples" / "cantilever_swing.toml"
TIME = "materials.rubber.damping.shear_time"
TIP = {"tip": ("displacement", "beam.end", "y", "last")}

T = TypeVar("T")


def files(folder: Path) -> list[int]:
    """Sizes of all files in a folder."""
    return [file.stat().st_size for file in folder.rglob("*") if file.is_file()]


def ends(sweep: vr.Sweep) -> list[float]:
    """What is read of every member: its last position at the tip."""
    return [
        float(member.result.data["position"].values[-1, -1, 1]) for member in sweep.members if member.result
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--duration", type=float, default=2.0)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    case = vr.load_case(CASE)
    constants = {"simulate.tolerance": 1e-4, "simulate.duration": args.duration}
    given: dict[str, Any] = {"constants": constants, "workers": 1, "errors": 0}
    vr.sweep(case, {TIME: [0.01, 0.02, 0.03]}, **given)  # kernels are in memory from here on
    values = {TIME: np.linspace(0.01, 0.05, args.members)}

    def timed(what: str, call: Callable[[], T]) -> T:
        used, began = time.process_time(), time.perf_counter()
        found = call()
        used, taken = time.process_time() - used, time.perf_counter() - began
        print(
            f"{what:36s}{1e3 * used / args.members:9.2f} ms, wall {1e3 * taken / args.members:9.2f}",
            flush=True,
        )
        return found

    for _ in range(args.repeats):
        with tempfile.TemporaryDirectory() as name:
            folder, store = Path(name) / "folder", Path(name) / "sweep.zarr"
            timed("a number only", lambda: vr.sweep(case, values, quantities=TIP, **given))
            timed("whole results in memory", lambda: vr.sweep(case, values, fields=True, **given))
            kept = timed(
                "whole results in a folder",
                lambda folder=folder: vr.sweep(case, values, fields=True, folder=folder, **given),
            )
            expected = timed("read from the folder", lambda folder=folder: ends(vr.load(folder, vr.Sweep)))
            timed("a report", lambda kept=kept: kept.report())
            timed("saved as a store", lambda kept=kept, store=store: kept.save(store))
            with engine(None, args.workers) as pool:
                if pool is not None:  # its processes have loaded what they need
                    kept.save(store, executor=pool)
                timed(
                    f"saved by {args.workers} processes",
                    lambda kept=kept, store=store, pool=pool: kept.save(store, executor=pool),
                )
            found = timed("read from the store", lambda store=store: ends(vr.load(store, vr.Sweep)))
            assert found == expected
            for what, place in (("folder", folder), ("store", store)):
                sizes = files(place)
                print(f"{what}: {sum(sizes) / args.members / 1e3:.0f} kB each, {len(sizes)} files")


if __name__ == "__main__":
    main()
