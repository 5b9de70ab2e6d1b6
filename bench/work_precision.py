"""Time of the time loop against the error of the tip: viscorod beside Exudyn, MuJoCo and PyElastica, in one run.

    python bench/work_precision.py [--case llt frame string] [--figure docs/images/work_precision.png]

The cases and how each program models them are in ``bench/peers``; programs that are not installed are left out
(``pip install viscorod[bench]``). Time loops are compared with time loops, each the best of several runs, one
thread; start-up, compilation and building of models are not in them. viscorod's loop stores 200 states with all their
strains and section forces, and takes some steps again in halves to tell its errors (not in runs of the *motion alone*);
the others store the tip. Meshes and tolerances are chosen for the error on both sides, but for the runs of viscorod on
*its mesh*, which it chooses for section forces as well. The reference is viscorod's radau at a tolerance of 1e-9 on a
fine mesh; what another mesh and another integrator make of it is printed first.
"""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
from peers.cases import CASES, INSTALL, Case
from peers.suite import MODULES, SUITE, available

from viscorod.analyses.warmup import compile_loop

LADDERS: dict[str, tuple[tuple[int, int, float], ...]] = {
    "llt": (
        (1, 4, 1e-2),
        (1, 4, 2e-3),
        (1, 5, 1e-3),
        (1, 5, 3e-4),
        (1, 6, 2e-4),
        (1, 6, 1e-4),
        (1, 6, 3e-5),
        (1, 7, 1e-5),
        (1, 7, 3e-6),
        (1, 8, 2e-6),
    ),
    "frame": (
        (1, 4, 5e-3),
        (1, 5, 1e-3),
        (1, 6, 3e-4),
        (1, 7, 2e-4),
        (2, 5, 1e-4),
        (2, 6, 3e-5),
        (4, 4, 1e-5),
        (3, 6, 1e-5),
        (3, 6, 5e-6),
    ),
    "string": (
        (1, 5, 1e-2),
        (1, 5, 2e-3),
        (1, 5, 5e-4),
        (1, 5, 2e-4),
        (1, 5, 1e-4),
        (1, 6, 3e-5),
        (2, 4, 2e-5),
        (2, 5, 7e-6),
        (3, 4, 3e-6),
        (3, 6, 1e-6),
    ),
}
"""Elements per leg, order and tolerance of viscorod's runs, from coarse to fine."""

LEFT = (1e-2, 1e-3, 1e-4)
"""Tolerances of runs whose mesh is left to the program."""

OURS = "viscorod"
ALONE, CHOSEN = f"{OURS}, motion alone", f"{OURS}, its mesh"
"""Families of runs: errors are not estimated, as in other programs; the program chooses the mesh."""

REPEATS, PASSES = 7, 2
TARGETS = (1e-3, 1e-4)


@dataclass(frozen=True)
class Point:
    """One run: the family it belongs to, its label, the time of its loop [s], its error over the length."""

    family: str
    label: str
    seconds: float
    error: float
    damped: bool = True


def ours(case: Case) -> list[Point]:
    """Runs of viscorod: with estimates of their errors, without, and on meshes that it chooses."""
    runs: list[tuple[str, int | None, int | None, float]] = [
        (family, *given) for family in (OURS, ALONE) for given in LADDERS[case.name]
    ]
    runs += [(CHOSEN, None, None, tolerance) for tolerance in LEFT]
    points = []
    for family, elements, order, tolerance in runs:
        best = np.inf
        for _ in range(REPEATS):
            run = case.simulate(elements, order, tolerance, errors=family != ALONE)
            best = min(best, float(run.data.attrs["loop_time_s"]))
        error = case.error(run.time, run.history(case.tip, "position").values)
        mesh = "" if elements is None else f"{elements} x order {order}, "
        label = f"{family}: {mesh}tolerance {tolerance:g}, {run.data.attrs['steps']} steps"
        points.append(Point(family, label, best, error))
    return points


def theirs(case: Case) -> list[Point]:
    """The other programs' runs."""
    points = []
    for entry in SUITE:
        if entry.case != case.name or not available(entry.module):
            continue
        taken = case.undamped() if entry.undamped else case
        try:
            run = import_module(f"peers.{entry.module}").run(taken, entry.elements, **entry.settings)
        except RuntimeError as reason:
            print(f"{MODULES[entry.module]}: {reason}")
            continue
        kind = run.label.split()[0]
        family = run.program if run.program == "PyElastica" else f"{run.program} {kind}"
        error = taken.error(run.t, run.tip)
        points.append(
            Point(
                family,
                f"{run.program} {run.version}: {run.label}",
                run.loop_seconds,
                error,
                not entry.undamped,
            )
        )
    return points


def faster(first: list[Point], second: list[Point]) -> list[Point]:
    """The same runs with the shorter of two times each."""
    return [a if a.seconds <= b.seconds else b for a, b in zip(first, second, strict=True)]


def seconds_at(points: list[Point], error: float) -> float:
    """Least time [s] for an error: of a run that is at least as exact, or between two runs of one family (log-log)."""
    best = min((p.seconds for p in points if p.error <= error), default=np.inf)
    for family in {p.family for p in points}:
        mine = sorted((p for p in points if p.family == family), key=lambda p: p.error)
        for a, b in pairwise(mine):
            if a.error <= error <= b.error:
                part = np.log(error / a.error) / np.log(b.error / a.error)
                best = min(best, float(np.exp((1 - part) * np.log(a.seconds) + part * np.log(b.seconds))))
    return best


def report(case: Case) -> tuple[list[Point], list[Point]]:
    """Run everything for one case and print its table and ratios."""
    mesh, integrator = case.reference_doubt()
    print(
        f"\n{case.name}: the reference moves by {mesh:.1e} on another mesh, {integrator:.1e} with another integrator"
    )
    mine, others = ours(case), theirs(case)
    for _ in range(PASSES - 1):  # all of them again: slow moments of the machine last for seconds
        mine, others = faster(mine, ours(case)), faster(others, theirs(case))
    print("| program | time loop | error / L |\n|---|---|---|")
    for point in (*mine, *others):
        note = "" if point.damped else " (undamped motion)"
        print(f"| {point.label}{note} | {1e3 * point.seconds:.4g} ms | {point.error:.1e} |")
    comparable = [p for p in others if p.damped or case.name == "string"]
    for target in TARGETS if comparable else ():
        other = seconds_at(comparable, target)
        print(f"at {target:g} L: the fastest other {1e3 * other:.4g} ms")
        for family in (OURS, ALONE, CHOSEN):
            own = seconds_at(of_family(mine, family), target)
            print(f"    {family} {1e3 * own:.3g} ms, ratio {other / own:.3g}")
    for family in (OURS, ALONE):
        fine, rough = (seconds_at(of_family(mine, family), target) for target in (1e-6, 1e-4))
        print(f"1e-6 L takes {fine / rough:.2g} times as long as 1e-4 L ({family})")
    return mine, others


def of_family(points: list[Point], family: str) -> list[Point]:
    """Those of a family."""
    return [point for point in points if point.family == family]


def draw(results: dict[str, tuple[list[Point], list[Point]]], path: Path) -> None:
    """Time against error, one panel per case."""
    import matplotlib.pyplot as plt

    titles = {
        "llt": "soft damped cantilever, 10 s",
        "frame": "right-angle frame in 3-D, 5 s",
        "string": "steel string, 1 s",
    }
    families = sorted({p.family for _, others in results.values() for p in others})
    colours = dict(zip(families, plt.get_cmap("tab10").colors[1:], strict=False))
    figure, panels = plt.subplots(
        1, len(results), figsize=(4.6 * len(results), 4.6), squeeze=False, sharey=True
    )
    drawn: dict[str, object] = {}
    for panel, (name, (mine, others)) in zip(panels[0], results.items(), strict=True):
        for family in [OURS, *families]:
            points = sorted(of_family([*mine, *others], family), key=lambda p: p.error)
            if not points:
                continue
            own = family == OURS
            (line,) = panel.loglog(
                [p.error for p in points],
                [p.seconds for p in points],
                "o-" if points[0].damped else "s:",
                color="black" if own else colours[family],
                linewidth=2.2 if own else 1.2,
                markersize=5,
            )
            drawn.setdefault(family if points[0].damped else f"{family} (undamped motion)", line)
        panel.set_title(titles.get(name, name), fontsize=11)
        panel.set_xlabel("largest error of the tip / L")
        panel.invert_xaxis()
        panel.grid(True, which="major", alpha=0.4)
    panels[0, 0].set_ylabel("time loop [s]")
    figure.legend(
        list(drawn.values()),
        list(drawn),
        loc="lower center",
        ncols=min(4, len(drawn)),
        frameon=False,
        fontsize=9,
    )
    figure.tight_layout(rect=(0, 0.14, 1, 1))
    figure.savefig(path, dpi=130)


def main() -> None:
    """Run, print, draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--case", nargs="+", choices=sorted(CASES), default=list(CASES))
    parser.add_argument("--figure", type=Path)
    options = parser.parse_args()
    for module, package in MODULES.items():
        if not available(module):
            print(f"{package} is not installed and is left out: {INSTALL}")
    compile_loop()  # loaded, or compiled, before anything is timed
    results = {name: report(CASES[name]) for name in options.case}
    if options.figure:
        draw(results, options.figure)


if __name__ == "__main__":
    main()
