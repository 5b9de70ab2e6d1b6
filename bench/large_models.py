"""Processor time and memory of every analysis and output, from 100 elements in one rod to 10 000, and for 1000 rods.

    python bench/large_models.py [FAMILY ...] [-a ANALYSIS ...] [-n SIZE ...]

Every line is a process of its own, forked from one that has compiled and loaded all kernels with a small model of the
same family: processor time is what the analysis takes there, memory by how much it grows at its peak. What takes more
than a limit of either is ended, and said to be. An output is made of an equilibrium of three load steps (a motion for
films, tables and ParaView), whose own cost is not in it.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import viscorod as vr
from viscorod.analyses.check import check
from viscorod.analyses.discrete import DiscreteModel
from viscorod.results.files import csv_text

SECONDS, BYTES = 120, 6e9
"""What one line may take."""
SIZES = (100, 300, 1000, 3000, 10_000)
RODS = (1, 10, 100, 1000)

STEEL = vr.Material(2e11, poissons_ratio=0.3, density=7850.0, damping=vr.KelvinVoigt(1e-4, 1e-4))


def straight(a: Any, b: Any, diameter: float, elements: int, order: int = 3) -> vr.Rod:
    """A steel wire."""
    return vr.Rod.straight(
        a, b, section=vr.Circle(0.5 * diameter), material=STEEL, elements=elements, order=order
    )


def hanging(elements: int) -> vr.Model:
    """A wire 500 m long and 1 cm thick, hung up at its upper end."""
    model = vr.Model()
    model.add("wire", straight((0, 0, 0), (0, 0, -500), 0.01, elements))
    model.clamp("wire.start")
    model.gravity((0.1, 0, -9.81))
    return model


def cable(elements: int) -> vr.Model:
    """The same between two pins 500 m apart."""
    model = vr.Model()
    model.add("wire", straight((0, 0, 0), (500, 0, 0), 0.01, elements))
    model.pin("wire.start")
    model.pin("wire.end")
    model.gravity((0, 0, -9.81))
    return model


def beam(elements: int) -> vr.Model:
    """A cantilever 1 m long and 5 cm thick."""
    model = vr.Model()
    model.add("beam", straight((0, 0, 0), (1, 0, 0), 0.05, elements))
    model.clamp("beam.start")
    model.gravity((0, 0, -9.81))
    return model


def separate(rods: int) -> vr.Model:
    """Cantilevers of 0.1 m side by side."""
    model = vr.Model()
    for k in range(rods):
        model.add(f"rod{k}", straight((0, 0.1 * k, 0), (0.1, 0.1 * k, 0), 0.01, 2))
        model.clamp(f"rod{k}.start")
    model.gravity((0, 0, -9.81))
    return model


def chain(rods: int) -> vr.Model:
    """Rods of 0.1 m, each rigidly attached to the end of the one before, held at both ends."""
    model = vr.Model()
    for k in range(rods):
        model.add(f"rod{k}", straight((0.1 * k, 0, 0), (0.1 * (k + 1), 0, 0), 0.01, 2))
        if k:
            model.attach(f"rod{k - 1}.end", f"rod{k}.start")
    model.clamp("rod0.start")
    model.clamp(f"rod{rods - 1}.end")
    model.gravity((0, 0, -9.81))
    return model


def balls(rods: int) -> vr.Model:
    """The same with a ball joint between two rods, hanging, hung up by a clamp."""
    model = vr.Model()
    for k in range(rods):
        model.add(f"rod{k}", straight((0, 0, -0.1 * k), (0, 0, -0.1 * (k + 1)), 0.01, 2))
        if k:
            model.joint("ball", f"rod{k - 1}.end", f"rod{k}.start")
    model.clamp("rod0.start")
    model.gravity((0, 0, -9.81))
    return model


def net(rods: int) -> vr.Model:
    """Squares of 0.1 m side by side and behind each other, rigidly attached, clamped along one side."""
    n = next(n for n in range(1, 100) if 2 * n * (n + 1) >= rods)
    model = vr.Model()
    ends: dict[tuple[int, int], str] = {}

    def add(a: tuple[int, int], b: tuple[int, int]) -> None:
        name = f"rod{len(model.rods)}"
        model.add(name, straight((0.1 * a[0], 0.1 * a[1], 0), (0.1 * b[0], 0.1 * b[1], 0), 0.01, 2))
        for place, end in ((a, f"{name}.start"), (b, f"{name}.end")):
            if place in ends:
                model.attach(ends[place], end)
            else:
                ends[place] = end

    for i in range(n + 1):
        for j in range(n + 1):
            if i < n:
                add((i, j), (i + 1, j))
            if j < n:
                add((i, j), (i, j + 1))
    for j in range(n + 1):
        model.clamp(ends[(0, j)])
    model.gravity((0, 0, -9.81))
    return model


FAMILIES: dict[str, tuple[Callable[[int], vr.Model], tuple[int, ...]]] = {
    "hanging": (hanging, SIZES),
    "cable": (cable, SIZES),
    "beam": (beam, SIZES),
    "separate": (separate, RODS),
    "chain": (chain, RODS),
    "balls": (balls, RODS),
    "net": (net, RODS),
}


def _still(model: vr.Model) -> Any:
    return model.equilibrium(load_steps=3)


def _moving(model: vr.Model) -> Any:
    return model.simulate(1e-2, time_step=1e-3, output_interval=1e-3, initial="reference")


def _prepared(make: Callable[[vr.Model], Any], use: Callable[[Any, Path], Any]) -> Any:
    def prepare(model: vr.Model, folder: Path) -> Callable[[], Any]:
        result = make(model)
        result.data  # noqa: B018
        return lambda: use(result, folder)

    return prepare


def _alone(use: Callable[[vr.Model, Path], Any]) -> Any:
    return lambda model, folder: lambda: use(model, folder)


def _probe(result: Any, _: Path) -> Any:
    rod = result.sites.rods[-1]
    return result.probe(rod, s=np.linspace(0.0, 0.1, 1000)), result.probe([f"{rod}.end", f"{rod}.start"])


def _csv(result: Any, folder: Path) -> Any:
    rods = result.sites.rods
    return csv_text.write(
        csv_text.history_columns(result, [f"{rods[0]}.end", f"{rods[-1]}.end"], ("position",)),
        folder / "run.csv",
    )


def _load(result: Any, folder: Path) -> Callable[[], Any]:
    result.save(folder / "run.nc")
    return lambda: vr.load(folder / "run.nc")


ANALYSES: dict[str, Callable[[vr.Model, Path], Callable[[], Any]]] = {
    "draw": _alone(lambda model, folder: model.draw(folder / "model.png")),
    "check": _alone(lambda model, _: check(DiscreteModel.of(model))),
    "equilibrium": _alone(lambda model, _: model.equilibrium()),
    "modes": _alone(lambda model, _: model.modes(6, about="reference")),
    "simulate": _alone(lambda model, _: _moving(model)),
    "report": _prepared(_still, lambda run, _: run.report()),
    "save": _prepared(_still, lambda run, folder: run.save(folder / "run.nc")),
    "load": lambda model, folder: _load(_still(model), folder),
    "probe": _prepared(_still, _probe),
    "plot": _prepared(_still, lambda run, folder: run.plot(folder / "motion.png")),
    "view": _prepared(_still, lambda run, folder: vr.view(run, folder / "view.html")),
    "csv": _prepared(_moving, _csv),
    "paraview": _prepared(_still, lambda run, folder: run.save_paraview(folder / "run.vtkhdf")),
}


def _memory() -> tuple[float, float]:
    """Present and largest memory of this process [bytes]."""
    text = Path("/proc/self/status").read_text()
    return tuple(1024.0 * float(text.split(f"{key}:")[1].split()[0]) for key in ("VmRSS", "VmHWM"))  # type: ignore[return-value]


def _measure(family: str, analysis: str, size: int, pipe: Any) -> None:
    """Send processor time [s] and growth of memory [bytes], or what went wrong."""
    sys.stderr = open(os.devnull, "w")  # noqa: SIM115
    resource.setrlimit(resource.RLIMIT_AS, (int(BYTES + 4e9), int(BYTES + 4e9)))
    with tempfile.TemporaryDirectory() as folder:
        model = FAMILIES[family][0](size)
        run = ANALYSES[analysis](model, Path(folder))
        Path("/proc/self/clear_refs").write_text("5")
        before, _ = _memory()
        pipe.send("ready")
        begin = time.process_time()
        try:
            found = run()
        except (vr.InputError, vr.SolveError, MemoryError) as error:
            pipe.send(
                (
                    time.process_time() - begin,
                    _memory()[1] - before,
                    0.0,
                    f"{type(error).__name__}: {str(error)[:60]}",
                )
            )
            return
        seconds = time.process_time() - begin
        written = sum(path.stat().st_size for path in Path(folder).rglob("*") if path.is_file())
        pipe.send((seconds, _memory()[1] - before, written, ""))
        del found


def measured(family: str, analysis: str, size: int) -> tuple[float, float, float, str]:
    """Return processor time [s], memory [bytes], bytes written, and why it was ended, of a process of its own."""
    context = multiprocessing.get_context("fork")
    mine, theirs = context.Pipe(duplex=False)
    worker = context.Process(target=_measure, args=(family, analysis, size, theirs))
    worker.start()
    theirs.close()
    try:
        if not mine.poll(3 * SECONDS):
            return np.nan, np.nan, 0.0, "preparation takes too long"
        mine.recv()
        if not mine.poll(2 * SECONDS):
            return np.nan, np.nan, 0.0, f"more than {SECONDS} s"
        return mine.recv()  # type: ignore[no-any-return]
    except EOFError:
        return np.nan, np.nan, 0.0, "the process died"
    finally:
        worker.kill()
        worker.join()


def main() -> None:
    """Print the tables."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("family", nargs="*", default=list(FAMILIES))
    words.add_argument("-a", "--analysis", nargs="*", default=list(ANALYSES))
    words.add_argument("-n", "--size", nargs="*", type=int)
    chosen = words.parse_args()
    for family in chosen.family:
        make, sizes = FAMILIES[family]
        for analysis in chosen.analysis:  # compiled and loaded before the fork
            with tempfile.TemporaryDirectory() as folder:
                ANALYSES[analysis](make(3), Path(folder))()
        print(f"\n{family}", flush=True)
        for analysis in chosen.analysis:
            for size in chosen.size or sizes:
                seconds, memory, written, why = measured(family, analysis, size)
                text = f"| {analysis} | {size} | {seconds:.3g} s | {memory / 1e6:.0f} MB | {written / 1e6:.2f} MB"
                print(f"{text} | {why}", flush=True)


if __name__ == "__main__":
    main()
