"""Intervals of quantiles of Sobol' points: how often they hold the exact quantile, and how wide they are.

    python bench/sobol_intervals.py [--ensembles 200] [--points 64 256 1024]

Functions of independent normal numbers stand for cases. Every ensemble has a scrambling of its own; the exact quantiles
are those of 2^20 points. Widths are medians, beside the order statistics of independent members; "-" where most of
these have no bound.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from scipy.stats import norm, quantile_test

from viscorod.analyses.sweeps.points import uniform_points
from viscorod.results.block_errors import quantile_interval

LEVELS = (0.05, 0.5, 0.95)
FUNCTIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "sum": lambda z: z.sum(axis=1),
    "weighted sum": lambda z: z @ (1.0 / np.arange(1, z.shape[1] + 1)),
    "product": lambda z: np.exp(0.3 * z).prod(axis=1),
    "waves": lambda z: np.cos(2.0 * z).sum(axis=1) + z[:, 0] * z[:, -1],
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ensembles", type=int, default=200)
    parser.add_argument("--points", type=int, nargs="*", default=[64, 256, 1024])
    parser.add_argument("--dimensions", type=int, nargs="*", default=[1, 2, 4, 8])
    args = parser.parse_args()
    print(
        "of so many ensembles the interval holds the quantile [%], and its width over that of order statistics"
    )
    print("  d  function       points   5 %          50 %         95 %")
    for d in args.dimensions:
        for name, function in FUNCTIONS.items():
            exact = np.quantile(function(norm.ppf(uniform_points(1 << 20, d, 99))), LEVELS)
            for n in args.points:
                held = np.zeros(3)
                widths = np.empty((args.ensembles, 2, 3))
                for seed in range(args.ensembles):
                    values = function(norm.ppf(uniform_points(n, d, 1000 + seed)))
                    for k, level in enumerate(LEVELS):
                        low, high = quantile_interval(values[:, None], level, 0.95)
                        held[k] += low <= exact[k] <= high
                        wide = quantile_test(values, p=level).confidence_interval(0.95)
                        widths[seed, :, k] = high - low, wide.high - wide.low
                middle = np.median(np.where(np.isfinite(widths), widths, np.inf), axis=0)
                cells = [
                    f"{100.0 * held[k] / args.ensembles:5.1f} "
                    + (f"{middle[0, k] / middle[1, k]:5.2f}" if np.isfinite(middle[:, k]).all() else "    -")
                    for k in range(3)
                ]
                print(f"{d:3d}  {name:13s}  {n:6d}  {'  '.join(cells)}", flush=True)


if __name__ == "__main__":
    main()
