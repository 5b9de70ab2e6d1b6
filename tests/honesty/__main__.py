"""How honest results by default are: random models against refined solutions of the same.

    make honest                      # 1000 models, seeds 0 to 999
    python -m honesty --seeds 0 40   # from the folder of the tests: some of them

Prints a table in the form of the documentation's and writes the verdict on every seed beside this file.
"""

from __future__ import annotations

import argparse
import csv
import os
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, fields
from multiprocessing import get_context
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from rich.progress import track

from honesty.judge import WITHIN, Verdict, verdict
from honesty.random_models import ANALYSES

OUTCOMES = Path(__file__).with_name("outcomes.csv")


def table(verdicts: Iterable[Verdict]) -> str:
    """Return a table in Markdown: what became of the trials of every analysis."""
    all_of_them = list(verdicts)
    lines = [
        "| Analysis | Trials | Solved | Refused | Failed | Not judged | Error above 1 %, untold | Estimates judged "
        "| within a factor of ten | below a third of the error |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name in (*ANALYSES, "all"):
        mine = [v for v in all_of_them if name in (v.analysis, "all")]
        counts = [
            sum(v.outcome == word for v in mine) for word in ("solved", "refused", "failed", "unjudged")
        ]
        judged = [v for v in mine if v.estimated]
        within = sum(v.within for v in judged)
        low = sum(v.estimate < v.true_mesh / 3.0 for v in judged)
        untold = sum(v.untold for v in mine)
        share = f"{100.0 * within / len(judged):.1f} %" if judged else ""
        below = f"{100.0 * low / len(judged):.1f} %" if judged else ""
        cells = [
            f"`{name}`" if name != "all" else name,
            len(mine),
            *counts,
            untold,
            len(judged),
            share,
            below,
        ]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines)


STEPS = {
    "positions": ("true_steps", "steps"),
    "rotations": ("true_turns", "turns"),
    "section forces": ("true_forces", "forces"),
    "section moments": ("true_moments", "moments"),
}


def table_of_steps(verdicts: Iterable[Verdict]) -> str:
    """Return a table in Markdown: how near estimated errors by the steps of motions are to the true ones."""
    lines = [
        "| Error by the steps, of | Judged | within a factor of ten | below a third of the error | ratio |",
        "|---|---|---|---|---|",
    ]
    solved = [v for v in verdicts if v.outcome == "solved"]
    for name, (true, said) in STEPS.items():
        ratios = [getattr(v, said) / getattr(v, true) for v in solved if getattr(v, true) > 0.0]
        if ratios:
            within = sum(1.0 / WITHIN <= ratio <= WITHIN for ratio in ratios)
            low = sum(ratio < 1.0 / 3.0 for ratio in ratios)
            share, below = (f"{100.0 * count / len(ratios):.1f} %" for count in (within, low))
            span = f"{min(ratios):.2g} to {max(ratios):.2g}"
            lines.append(f"| {name} | {len(ratios)} | {share} | {below} | {span} |")
    return "\n".join(lines)


def write(verdicts: Iterable[Verdict], path: Path = OUTCOMES) -> None:
    """Write one row per seed."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Verdict)], lineterminator="\n")
        writer.writeheader()
        for row in map(asdict, verdicts):
            writer.writerow({key: f"{x:.3g}" if isinstance(x, float) else x for key, x in row.items()})


def main() -> None:
    """Judge the trials of some seeds."""
    parser = argparse.ArgumentParser(description="Random models by default against refined solutions.")
    parser.add_argument("--seeds", nargs=2, type=int, default=(0, 1000), metavar=("FIRST", "END"))
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--output", type=Path, default=OUTCOMES, help="table of all verdicts")
    given = parser.parse_args()
    seeds = range(*given.seeds)
    with ProcessPoolExecutor(given.workers, mp_context=get_context("spawn")) as pool:
        found = list(track(pool.map(verdict, seeds), total=len(seeds), description="trials"))
    write(found, given.output)
    print(table(found), table_of_steps(found), sep="\n\n")
    for v in found:
        if v.untold:
            print(f"untold: seed {v.seed}, {v.analysis} of a {v.structure}: error {v.error:.2g} {v.words}")


if __name__ == "__main__":
    main()
