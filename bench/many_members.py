"""What many members of a sweep cost beside their computation: processor time, disk and memory of the client.

    python bench/many_members.py [--members 100 1000 10000] [--kept 1000 10000 100000]

Members are equilibria of a cantilever of one element, each of some milliseconds, computed in this process into a
folder; then the same call again finds all of them. With ``--kept``, records of members are written and read as workers
and clients do it, without computing any: that shows the store and the client alone.
"""

from __future__ import annotations

import argparse
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np

import viscorod as vr
from viscorod.analyses.sweeps.member_names import member_names
from viscorod.analyses.sweeps.rows import rows_of
from viscorod.casefile.case import case_from_dict
from viscorod.results.files.sweep_folder import SweepFolder
from viscorod.results.quantities import quantities_of

TEXT = """
[materials.rubber]
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0

[sections.square]
shape = "rectangle"
width = 0.01
height = 0.01

[rods.beam]
shape = "straight"
start = [0.0, 0.0, 0.0]
end = [0.3, 0.0, 0.0]
section = "square"
material = "rubber"
elements = 1
order = 3

[[supports]]
kind = "clamp"
at = "beam.start"

[[loads]]
kind = "force"
at = "beam.end"
value = [0.0, 0.001, 0.0]

[equilibrium]
"""
MODULUS = "materials.rubber.youngs_modulus"
FORCE = "loads[0].value[1]"
FIRST = 200
"""Members before any are timed."""
TIP = {"tip": ("displacement", "beam.end", "y", "last")}


def memory() -> float:
    """Memory of this process [MB], as the system sees it."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096 / 1e6


def columns(count: int) -> dict[str, np.ndarray]:
    """Values of so many members, all of them different."""
    return {MODULUS: np.linspace(1e6, 2e6, count), FORCE: np.linspace(1e-3, 2e-3, count)}


def size(folder: Path) -> int:
    """Bytes in a folder."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--members", type=int, nargs="*", default=[100, 1000, 10000])
    parser.add_argument("--kept", type=int, nargs="*", default=[1000, 10000, 100000])
    args = parser.parse_args()
    case = case_from_dict(tomllib.loads(TEXT))
    given = {"quantities": TIP, "workers": 1, "errors": 0}
    vr.sweep(case, columns(FIRST), **given)  # kernels are in memory, and so is what the first members leave
    print(
        "computed, in one process\nmembers   each [ms]   again, each [ms]   on disk, each [B]   memory [MB]"
    )
    for count in args.members:
        with tempfile.TemporaryDirectory() as name:
            used = time.process_time()
            vr.sweep(case, columns(count), folder=name, **given)
            first, used = time.process_time() - used, time.process_time()
            found = vr.sweep(case, columns(count), folder=name, **given)
            again = time.process_time() - used
            print(
                f"{count:7d}  {1e3 * first / count:10.2f}  {1e3 * again / count:17.3f}  "
                f"{size(Path(name)) / count:18.0f}  {memory():12.0f}",
                flush=True,
            )
            del found
    print(
        "kept, not computed\nmembers   write, each [us]   open, each [us]   on disk, each [B]   memory [MB]"
    )
    for count in args.kept:
        with tempfile.TemporaryDirectory() as name:
            folder = SweepFolder(Path(name))
            rows = rows_of(columns(count))
            names = member_names(case, rows, quantities_of(TIP, case.kind, {}), False)
            folder.begin("", rows, names, [], list(TIP))
            record = {"message": "", "outcome": "completed", "measured": {"steps": 1.0, "wall_time_s": 0.01}}
            used = time.process_time()
            for k, one in enumerate(names):
                folder.add(one, record | {"quantities": {"tip": 0.1 + 1e-7 * k}}, None)
            written, used = time.process_time() - used, time.process_time()
            found = vr.load(name)
            table = found.table()
            opened = time.process_time() - used
            assert len(table) == count
            print(
                f"{count:7d}  {1e6 * written / count:17.1f}  {1e6 * opened / count:16.1f}  "
                f"{size(Path(name)) / count:18.0f}  {memory():12.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
