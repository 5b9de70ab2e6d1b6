"""Compare the results of all shipped cases between two states of the source.

Compile first (viscorod warmup): kernels that are compiled in the same process round differently from cached ones.

    python shipped_results.py write FOLDER    run every case of examples/ with the package that is imported
    python shipped_results.py compare A B     largest difference of every variable over its size
"""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import xarray as xr


def write(folder: Path) -> None:
    examples = Path(os.environ.get("EXAMPLES", "examples"))
    for case in sorted(examples.glob("*.toml")):
        out = folder / case.stem
        if (out / "run.nc").exists():
            continue
        out.mkdir(parents=True, exist_ok=True)
        for command in (["check", str(case)], ["run", str(case), "-o", str(out)]):
            done = subprocess.run(
                [sys.executable, "-m", "viscorod", *command], capture_output=True, text=True
            )
            (out / f"{command[0]}.txt").write_text(done.stdout + done.stderr)
        print(case.stem, done.returncode, flush=True)


def compare(a: Path, b: Path) -> int:
    worst = 0.0
    for first in sorted(a.glob("*/run.nc")):
        one, two = (xr.open_dataset(p / first.parent.name / "run.nc", engine="h5netcdf") for p in (a, b))
        if sorted(one.variables) != sorted(two.variables):
            print(first.parent.name, "variables differ", set(one.variables) ^ set(two.variables))
            worst = np.inf
        largest = 0.0
        for name in one.variables:
            if name not in two.variables:
                continue
            x, y = one[name].values, two[name].values
            if x.shape != y.shape:
                print(first.parent.name, name, "shapes", x.shape, y.shape)
                largest = np.inf
            elif x.dtype.kind not in "fiu":
                if not np.array_equal(x, y):
                    print(first.parent.name, name, "differs")
                    largest = np.inf
            else:
                size = float(np.nanmax(np.abs(x), initial=0.0))
                if name == "position":
                    size = max(size, 1e-300)
                d = float(np.nanmax(np.abs(x.astype(float) - y.astype(float)), initial=0.0))
                if d:
                    print(" ", first.parent.name, name, d, size)
                if size:
                    largest = max(largest, d / size)
        skip = ("wall", "loop", "version", "created", "platform", "processor", "case_text")
        keys = [k for k in sorted(set(one.attrs) | set(two.attrs)) if not any(s in k for s in skip)]
        for k in keys:
            if str(one.attrs.get(k)) != str(two.attrs.get(k)):
                print(
                    "  attr",
                    first.parent.name,
                    k,
                    str(one.attrs.get(k))[:100],
                    "|",
                    str(two.attrs.get(k))[:100],
                )
        checks = [(p / first.parent.name / "check.txt").read_text() for p in (a, b)]
        print(
            f"{first.parent.name:24s} {largest:.1e}  check {'same' if checks[0] == checks[1] else 'DIFFERS'}"
        )
        worst = max(worst, largest)
    print("worst", worst)
    return int(worst > 1e-12)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]))
    else:
        sys.exit(compare(Path(sys.argv[2]), Path(sys.argv[3])))
