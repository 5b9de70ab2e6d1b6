"""Draw the figures of docs/howto/measurements.md and print its table of ways to read a decay.

python docs/figures/free_decay.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.signal import hilbert

import viscorod as vr
from viscorod.model.materials.moduli_over_frequency import DmaTable
from viscorod.records.damped_sines import fit_sines, pencil_poles
from viscorod.typing import Floats

IMAGES = Path(__file__).parents[1] / "images"
FREQUENCY, RATIO = 2.0, 0.03
TIMES = np.arange(400) * 0.02
STUDENT = 1.966  # half a 95 % interval over its deviation, for the number of samples
SETS = 300


def pole(frequency: float = FREQUENCY, ratio: float = RATIO) -> complex:
    omega = 2.0 * np.pi * frequency
    return complex(-ratio * omega, omega * np.sqrt(1.0 - ratio**2))


def ratio_of(s: complex) -> float:
    return -s.real / abs(s)


def by_envelope(times: Floats, values: Floats) -> complex:
    """The slope of the logarithm of the envelope by Hilbert's transform, its ends left out."""
    turned = hilbert(values - values[-len(values) // 4 :].mean())
    inside = slice(len(times) // 20, -len(times) // 10)
    size = np.abs(turned)[inside]
    slopes = [
        np.polyfit(times[inside], one[inside], 1, w=size)[0]
        for one in (np.log(np.abs(turned)), np.unwrap(np.angle(turned)))
    ]
    return complex(slopes[0], slopes[1])


def by_maxima(times: Floats, values: Floats) -> complex:
    """The mean logarithmic decrement of successive maxima, as long as they fall."""
    rest = values[-len(values) // 4 :].mean()
    period = round(1.0 / FREQUENCY / (times[1] - times[0]))
    tops = [float((values[k : k + period] - rest).max()) for k in range(0, len(values) - period, period)]
    count = next((k for k in range(1, len(tops)) if tops[k] >= tops[k - 1]), len(tops))
    delta = np.log(tops[0] / tops[count - 1]) / max(count - 1, 1)
    return complex(-delta * FREQUENCY, 2.0 * np.pi * FREQUENCY)


def compare() -> None:
    """Print the scatter of the ratio over its true value, by way and noise, and the bound of Cramer and Rao."""
    rng = np.random.default_rng(0)
    print(
        f"{'noise':>8s} {'maxima':>8s} {'envelope':>9s} {'pencil':>8s} {'squares':>8s} {'bound':>8s} {'covered':>8s}"
    )
    for noise in (0.001, 0.01, 0.05):
        off: dict[str, list[float]] = {name: [] for name in ("maxima", "envelope", "pencil", "squares")}
        covered, bounds = [], []
        for _ in range(SETS):
            clean = np.real(np.exp(pole() * TIMES + 0.4j)) + 0.1
            values = clean + noise * rng.normal(size=len(TIMES))
            start = pencil_poles(TIMES, values, 1)
            fit = fit_sines(TIMES, values, start)
            assert fit is not None
            for name, s in (
                ("maxima", by_maxima(TIMES, values)),
                ("envelope", by_envelope(TIMES, values)),
                ("pencil", complex(start[0])),
                ("squares", complex(fit.poles[0])),
            ):
                off[name].append(ratio_of(s) / RATIO - 1.0)
            width = float(fit.half_widths(0.95)[1][0])
            covered.append(abs(off["squares"][-1]) * RATIO < width)
            bounds.append(width / STUDENT * noise / fit.noise / RATIO)
        spread = [100.0 * float(np.sqrt(np.mean(np.square(one)))) for one in off.values()]
        row = " ".join(f"{one:8.3f}" for one in (*spread, 100.0 * float(np.mean(bounds))))
        print(f"{noise:8.3f} {row} {100.0 * float(np.mean(covered)):8.1f}")


def decay() -> None:
    """Draw a decay whose ratio grows with the amplitude and whose rest creeps."""
    times = np.arange(700) * 0.01
    omega, low = 2.0 * np.pi * 3.1, 0.015 * 2.0 * np.pi * 3.1
    amplitude = 4e-3 / (2.0 * np.exp(low * times) - 1.0)
    rest = 0.012 + 4e-4 * np.exp(-times / 1.5)
    noise = np.random.default_rng(1).normal(0.0, 3e-5, len(times))
    record = vr.Record(
        times,
        rest + amplitude * np.cos(omega * times) + noise,
        place="beam.end",
        quantity="position",
        direction="y",
        name="a rubber strip",
    )
    found = vr.decay(record, start=0.0)
    print(found)
    found.plot(IMAGES / "free_decay.png")


def master() -> None:
    """Draw the master curve of a Prony series whose times follow a law of WLF."""
    times = 10.0 ** np.arange(-12.0, 7.0, 0.4)
    moduli = 1.2e8 * np.exp(-0.5 * ((np.log10(times) + 1.0) / 2.5) ** 2)
    truth = vr.RelaxationModulus(3e6, tuple(moduli), tuple(times))
    law = vr.WLF(12.0, 70.0, reference=60.0)
    rng = np.random.default_rng(2)
    omega = 2.0 * np.pi * np.geomspace(0.1, 30.0, 10)
    sweeps = []
    for celsius in np.arange(39.0, 96.0, 7.0):
        modulus = truth.shifted(law.factor(celsius)).complex_modulus(omega) * (celsius + 273.15) / 333.15
        scatter = [np.exp(part * rng.normal(size=len(omega))) for part in (0.01, 0.02)]
        sweeps.append((float(celsius), DmaTable(omega, modulus.real * scatter[0], modulus.imag * scatter[1])))
    found = vr.master_curve(sweeps, reference=60.0, title="A polymer of known shift, with noise")
    print(found)
    found.plot(IMAGES / "master_curve.png")


if __name__ == "__main__":
    compare()
    decay()
    master()
