"""Means over blocks of samples of a long record, in which modes are looked for.

The mean of exp(s t) over blocks of k samples is a constant times exp(s t) at their middles: damped sines keep their
poles, and constants, straight lines, cubics and exponentials remain such. White noise stays white, and no number of a
mode of less than a quarter of the blocks' rate loses more than some per cent of its accuracy. Faster ones would appear
as slower ones; so peaks of the spectrum of all samples say how long blocks may be, and what a fit to all samples leaves
is looked at once more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from viscorod.records.damped_sines import SineFit, residual_peak, taken_off
from viscorod.typing import Floats

__all__ = ["Coarse"]

ENOUGH, LONG = 3000, 6000
"""Blocks that are enough, and samples of a record from which on there are blocks."""
PER_CYCLE = 4.0
"""Blocks per cycle that the fastest mode has at least."""
BINS = 256
"""Neighbouring bins of the spectrum among which a peak is looked for."""
STANDS_OUT = 25.0
"""Power of a peak over the median about it; among 30 000 bins of noise one of a thousand spectra has one by chance."""
GAIN = 4.0
"""Squares that one more mode takes off, in units of the noise and ln n, below which no criterion prefers it."""


@dataclass(frozen=True, eq=False)
class Coarse:
    """Means over blocks.

    Attributes:
        times: middles of the blocks, s (m,); values: means (m,).
        length: samples of a block.
    """

    times: Floats
    values: Floats
    length: int

    @classmethod
    def of(cls, times: Floats, values: Floats, most: int | None = None) -> Coarse | None:
        """Return the means over blocks as long as the modes allow; None where samples are few, fast or have gaps.

        Args:
            times: s (n,), evenly spaced but for some that are left out; values: (n,).
            most: samples of a block at most.
        """
        length = -(-len(times) // ENOUGH) if most is None else most
        step = float(times[-1] - times[0]) / (len(times) - 1)
        if len(times) < LONG or float(np.diff(times).max()) > length * step:
            return None
        even = np.linspace(times[0], times[-1], len(times))
        filled = np.interp(even, times, values)
        if most is None:
            length = min(length, int(1.0 / (PER_CYCLE * step * _fastest(filled, step))))
        if length < 2:
            return None
        whole = len(times) // length * length
        blocks = filled[:whole].reshape(-1, length).mean(axis=1)
        return cls(even[:whole].reshape(-1, length).mean(axis=1), blocks, length)

    def for_what_is_left(self, fit: SineFit) -> Coarse | None:
        """Return the blocks in which what a fit of all samples shows can be found: these if that is not too fast.

        None where they would be single samples.
        """
        step = float(fit.times[-1]) / (len(fit.times) - 1)
        if self._longest(float(fit.poles.imag.max()), step) < self.length:
            return self._shorter(fit, self.length // 2)
        pole = residual_peak(fit.times, fit.residual)
        gain = taken_off(pole, fit.times, fit.residual)
        fits = self._longest(float(pole.imag), step)
        if fits >= self.length or gain <= GAIN * np.log(len(fit.times)) * fit.noise**2:
            return self
        return self._shorter(fit, fits)

    @staticmethod
    def _longest(omega: float, step: float) -> int:
        return int(2.0 * np.pi / (PER_CYCLE * step * omega))

    @staticmethod
    def _shorter(fit: SineFit, length: int) -> Coarse | None:
        return Coarse.of(fit.times, fit.model + fit.residual, length) if length >= 2 else None


def _fastest(values: Floats, step: float) -> float:
    """Return the highest frequency at which the spectrum of samples has a peak, Hz; the lowest one if there is none."""
    count = len(values)
    power = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(2 * count)[count:])) ** 2
    bands = power[1 : 1 + (len(power) - 1) // BINS * BINS].reshape(-1, BINS)
    peaks = bands > STANDS_OUT * np.median(bands, axis=1)[:, None]
    return (int(np.flatnonzero(peaks.ravel()).max(initial=0)) + 1) / (count * step)
