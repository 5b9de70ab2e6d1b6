"""Do intervals of free decays hold in coloured noise? Many noisy decays of one and two modes, short and long.

``python bench/decays.py`` takes 1000 decays of each kind apart by `viscorod.decay`, which chooses the number of modes
and the rest itself, and prints how many intervals of 95 % hold the truth, how wide they are over Cramer and Rao's bound
under this noise, and how often other modes were found than there are.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
from scipy.linalg import cholesky, solve_triangular, toeplitz
from scipy.signal import lfilter

import viscorod as vr

MODES = ((2.0, 0.03, 1.0, 0.4), (7.3, 0.012, 0.4, -0.9))
"""Frequency [Hz], damping ratio, amplitude, phase."""
LENGTHS = {"short": (160, 0.025), "long": (1600, 0.0125)}
"""Samples, and seconds between them."""
NOISE = 0.05
COLOURS = (0.0, 0.5, 0.9)


def wave(times, frequency, ratio, amplitude, phase):
    omega = 2.0 * np.pi * frequency
    return (
        amplitude * np.exp(-ratio * omega * times) * np.cos(omega * np.sqrt(1.0 - ratio**2) * times + phase)
    )


def bound(times, modes, colour):
    """Deviations of frequency and ratio of every mode by Cramer and Rao, beside a constant rest."""
    columns = [np.ones_like(times)]
    for one in modes:
        for k, number in enumerate(one):
            step = 1e-5 * abs(number)
            above, below = list(one), list(one)
            above[k], below[k] = number + step, number - step
            columns.append((wave(times, *above) - wave(times, *below)) / (2.0 * step))
    noise = cholesky(NOISE**2 * toeplitz(colour ** np.arange(len(times))), lower=True)
    white = solve_triangular(noise, np.column_stack(columns), lower=True)
    deviations = np.sqrt(np.diag(np.linalg.inv(white.T @ white)))[1:].reshape(-1, 4)
    return deviations[:, :2]


def run(length, count, colour, sets, seed=0):
    samples, step = LENGTHS[length]
    times = np.arange(samples) * step
    modes = MODES[:count]
    clean = sum(wave(times, *one) for one in modes) + 0.2
    least = bound(times, modes, colour)
    rng = np.random.default_rng(seed)
    held, widths, others = [], [], 0
    began = time.process_time()
    for _ in range(sets):
        kicks = rng.normal(0.0, NOISE, samples + 200) * np.sqrt(1.0 - colour**2)
        noise = lfilter([1.0], [1.0, -colour], kicks)[200:]
        found = vr.decay(times, clean + noise, start=0.0)
        others += len(found.frequencies) != count
        for k, (frequency, ratio, *_) in enumerate(modes):
            near = int(np.argmin(np.abs(found.frequencies - frequency)))
            off = [abs(found.frequencies[near] - frequency), abs(found.damping_ratios[near] - ratio)]
            half = [found.data.frequency_width.values[near], found.data.damping_ratio_width.values[near]]
            held.append((k, np.array(off) < half))
            widths.append((k, np.array(half) / 1.96 / least[k]))
    each = (time.process_time() - began) / sets
    print(
        f"{length}, {count} mode(s), AR({colour:g}): {1e3 * each:.0f} ms each, other modes in {others / sets:.1%}"
    )
    for k, one in enumerate(modes):
        part = np.mean([row for mode, row in held if mode == k], axis=0)
        wide = np.median([row for mode, row in widths if mode == k], axis=0)
        print(
            f"  {one[0]:g} Hz: frequency {part[0]:.1%}, ratio {part[1]:.1%}; "
            f"width over bound {wide[0]:.3f}, {wide[1]:.3f}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("lengths", nargs="*", choices=[*LENGTHS, []], default=[])
    parser.add_argument("--sets", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    for name in given.lengths or LENGTHS:
        for number in (1, 2):
            for memory in COLOURS:
                run(name, number, memory, given.sets, given.seed)


if __name__ == "__main__":
    main()
