"""Damped sines through samples: poles to start from by the matrix pencil, then least squares with intervals.

    y(t) = sum_k Re(A_k exp(s_k t)) + r(t),        s_k = -sigma_k + i omega_k

The matrix pencil (Hua and Sarkar, IEEE Trans. ASSP 38, 1990) gives poles without iteration; least squares with the
linear coefficients eliminated (Golub and Pereyra 1973, derivatives of Kaufman 1975) makes them the likeliest under
white noise, whose covariance attains the bound of Cramer and Rao. Coloured noise is in the intervals
(`viscorod.records.sine_noise`), and in the criterion by which numbers of modes are compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import qr, solve_triangular
from scipy.optimize import least_squares

from viscorod.records.sine_noise import FitNoise, colour_gain
from viscorod.solve.estimation.noise import SeriesNoise, ljung_box
from viscorod.typing import Floats

__all__ = ["SineFit", "fit_sines", "pencil_poles", "residual_peak", "taken_off"]

MOST_SAMPLES = 3000
"""Samples that the matrix pencil sees."""
PENCIL = 150
"""Columns of its Hankel matrix at most."""
POWERS = {"sloping": 1, "curved": 3}
"""Highest powers of time of a rest that drifts."""
SLOW, QUICK = (0.5, 2.0, 6.0, 20.0), (6.0, 20.0, 60.0, 200.0)
"""Decay rates over the span of the samples that are tried for the peak of a spectrum, and those of falling windows."""
LEVEL = 1e-3
"""Probability with which white noise is called correlated."""


@dataclass(frozen=True, eq=False)
class SineFit:
    """Damped sines fitted to samples.

    Attributes:
        poles: s_k, 1/s (k,), Im > 0.
        amplitudes: complex A_k at the first time (k,).
        rest: what it swings about, at the samples (n,).
        times: of the samples, from the first on (n,), s.
        model: at the samples (n,); residual: samples less model (n,).
        slopes: derivatives of the model by all numbers (n, m).
        mixing: change of sigma_1, omega_1, sigma_2, ... over that of the samples (n, 2 k).
        freedom: samples less fitted numbers.
        noise: standard deviation of the residual.
        resting: "constant", "sloping", "relaxing" or "curved".
        weighed: decay rate that an exponential window added to all, 1/s; frequencies and ratios are without it.
    """

    poles: np.ndarray
    amplitudes: np.ndarray
    rest: Floats
    times: Floats
    model: Floats
    residual: Floats
    slopes: Floats
    mixing: Floats
    freedom: int
    noise: float
    resting: str
    weighed: float = 0.0

    @property
    def own_poles(self) -> np.ndarray:
        """The poles without what a window added (k,)."""
        return self.poles + self.weighed

    @cached_property
    def information(self) -> float:
        """Bayes' criterion: n ln(mean square of what the residual's past does not foretell) + numbers ln n."""
        count = len(self.times)
        used = count - self.freedom
        left, terms = colour_gain(self.residual)
        square = max(float(np.mean(self.residual**2)), 1e-300)
        return float(count * (np.log(square) + left) + (used + terms) * np.log(count))

    @cached_property
    def is_white(self) -> bool:
        """Whether the residual is not correlated, by the test of Ljung and Box (1978)."""
        return not self.residual.any() or ljung_box(self.residual)[1] > LEVEL

    @cached_property
    def told(self) -> FitNoise:
        """The noise, and what it does to the poles."""
        return FitNoise.of(self.residual, self.slopes, self.mixing)

    def mode(self, k: int) -> Floats:
        """Return one damped sine at the samples (n,)."""
        found: Floats = np.real(self.amplitudes[k] * np.exp(self.poles[k] * self.times))
        return found

    @property
    def frequencies(self) -> Floats:
        """Natural frequencies, Hz (k,)."""
        return np.asarray(np.abs(self.own_poles) / (2.0 * np.pi))

    @property
    def ratios(self) -> Floats:
        """Damping ratios (k,)."""
        return np.asarray(-self.own_poles.real / np.abs(self.own_poles))

    def half_widths(self, level: float, alike: SeriesNoise | None = None) -> tuple[Floats, Floats]:
        """Return half the widths of intervals of natural frequencies [Hz] and of damping ratios, (k,) each.

        Args:
            level: probability of an interval.
            alike: noise whose colour is taken where there are too few samples for an own one.
        """
        known = self.told if alike is None else FitNoise.of(self.residual, self.slopes, self.mixing, alike)
        poles = self.own_poles
        size, sigma, omega = np.abs(poles), -poles.real, poles.imag
        count = len(size)
        frequency, ratio = np.zeros((count, 2 * count)), np.zeros((count, 2 * count))
        at = np.arange(count)
        frequency[at, 2 * at], frequency[at, 2 * at + 1] = sigma / size, omega / size
        ratio[at, 2 * at], ratio[at, 2 * at + 1] = omega**2 / size**3, -sigma * omega / size**3
        widths = known.half_widths(np.concatenate([frequency / (2.0 * np.pi), ratio]), level)
        return widths[:count], widths[count:]


def fit_sines(times: Floats, values: Floats, poles: np.ndarray, rest: str = "constant") -> SineFit | None:
    """Fit damped sines and a rest; None where the fit does not settle on poles that swing.

    Args:
        times: s (n,), increasing; values: (n,).
        poles: to start from, 1/s (k,), Im > 0.
        rest: "constant", "sloping" (a straight line), "relaxing" (a constant and a decaying exponential) or "curved" (a
            polynomial of the third degree).
    """
    t = times - times[0]
    waves = _Waves(t, len(poles), rest)
    if len(t) <= waves.numbers:
        return None
    scale = float(np.std(values)) or 1.0

    last: dict[bytes, tuple[Floats, Floats, Floats]] = {}

    def solved(theta: Floats) -> tuple[Floats, Floats, Floats]:
        where = theta.tobytes()
        if where not in last:  # slopes are asked for where the misfit was, which costs as much
            full = waves.basis(theta)
            if not np.isfinite(full).all():
                raise FloatingPointError("the sines grow beyond all numbers")
            coefficients = np.asarray(np.linalg.lstsq(full, values, rcond=None)[0], dtype=float)
            last.clear()
            last[where] = full, coefficients, full @ coefficients - values
        return last[where]

    def jacobian(theta: Floats) -> Floats:
        full, coefficients, _ = solved(theta)
        q = np.linalg.qr(full)[0]
        slope = waves.slopes(theta, full, coefficients)
        found: Floats = (slope - q @ (q.T @ slope)) / scale
        return found

    with np.errstate(over="raise", invalid="raise"):
        try:
            starts = waves.starts(poles)
            misfits = [float(np.sum(solved(theta)[2] ** 2)) for theta in starts]
            start = starts[int(np.argmin(misfits))]
            best = least_squares(
                lambda theta: solved(theta)[2] / scale,
                start,
                jac=jacobian,
                method="lm",
                xtol=1e-12,
                ftol=1e-14,
                max_nfev=60 * (1 + len(poles)),
            )
            theta = best.x
            if not (theta[1 : 2 * len(poles) : 2] > 0.1).all() or waves.rest_is_fast(theta):
                return None
            full, coefficients, misfit = solved(theta)
            return _with_slopes(waves, theta, full, coefficients, -misfit)
        except (FloatingPointError, np.linalg.LinAlgError, ValueError):
            return None


class _Waves:
    """Columns that damped sines and a rest are made of; times and numbers are over the span of the samples."""

    def __init__(self, t: Floats, count: int, rest: str) -> None:
        self.t, self.count, self.rest = t, count, rest
        self.span = float(t[-1])
        self.part = t / self.span
        self.resting = 2 if rest == "relaxing" else 1 + POWERS.get(rest, 0)
        self.numbers = self.resting + 4 * count + (1 if rest == "relaxing" else 0)

    def starts(self, poles: np.ndarray) -> list[Floats]:
        theta = np.column_stack([-poles.real, poles.imag]).ravel() * self.span
        if self.rest != "relaxing":
            return [theta]
        return [np.append(theta, np.log(rate)) for rate in (1.0, 3.0, 10.0, 30.0)]

    def rest_is_fast(self, theta: Floats) -> bool:
        """Return whether the rest relaxes within a period: that is no creep, but what the sines leave over."""
        return self.rest == "relaxing" and bool(
            theta[-1] > np.log(theta[1 : 2 * self.count : 2].min() / (2.0 * np.pi))
        )

    def basis(self, theta: Floats) -> Floats:
        shapes: list[Floats] = []
        if self.rest == "relaxing":
            shapes = [np.exp(-self.part * np.exp(theta[-1]))]
        elif self.rest in POWERS:
            shapes = [self.part**power for power in range(1, POWERS[self.rest] + 1)]
        pairs = [np.exp(self.part * complex(-theta[2 * k], theta[2 * k + 1])) for k in range(self.count)]
        columns = [np.ones_like(self.part), *shapes]
        for wave in pairs:
            columns += [wave.real, wave.imag]
        return np.column_stack(columns)

    def slopes(self, theta: Floats, full: Floats, coefficients: Floats) -> Floats:
        """Return the derivatives of the sum by the numbers that are not linear."""
        found = np.empty((len(self.t), len(theta)))
        for k in range(self.count):
            at = self.resting + 2 * k
            cosine, sine, (a, b) = full[:, at], full[:, at + 1], coefficients[at : at + 2]
            found[:, 2 * k] = -self.part * (a * cosine + b * sine)
            found[:, 2 * k + 1] = self.part * (b * cosine - a * sine)
        if self.rest == "relaxing":
            found[:, -1] = -self.part * np.exp(theta[-1]) * full[:, 1] * coefficients[1]
        return found


def _with_slopes(
    waves: _Waves, theta: Floats, full: Floats, coefficients: Floats, residual: Floats
) -> SineFit | None:
    every = np.concatenate([full, waves.slopes(theta, full, coefficients)], axis=1)
    freedom = len(residual) - every.shape[1]
    size = np.linalg.norm(every, axis=0)
    if not (size > 0.0).all():
        return None
    q, r = qr(every / size, mode="economic")
    if np.abs(np.diag(r)).min() < 1e-13 * np.abs(np.diag(r)).max():
        return None
    inverse = solve_triangular(r, np.eye(len(r))) / size[:, None]
    first, last = full.shape[1], full.shape[1] + 2 * waves.count
    resting = waves.resting
    return SineFit(
        poles=(-theta[0 : 2 * waves.count : 2] + 1j * theta[1 : 2 * waves.count : 2]) / waves.span,
        amplitudes=coefficients[resting::2] - 1j * coefficients[resting + 1 :: 2],
        rest=full[:, :resting] @ coefficients[:resting],
        times=waves.t,
        model=full @ coefficients,
        residual=residual,
        slopes=every,
        mixing=q @ inverse[first:last].T / waves.span,
        freedom=freedom,
        noise=float(np.sqrt(residual @ residual / freedom)),
        resting=waves.rest,
    )


def pencil_poles(times: Floats, values: Floats, count: int) -> np.ndarray:
    """Return poles that swing, the largest first (up to `count`,), 1/s, of evenly spaced samples (matrix pencil).

    The rest is one of the poles that do not swing, and takes part.
    """
    every = max(-(-len(values) // MOST_SAMPLES), 1)
    usable = len(values) // every * every
    y = values[:usable].reshape(-1, every).mean(axis=1)
    step = float(times[-1] - times[0]) / (len(times) - 1) * every
    columns = min(len(y) // 3, PENCIL)
    if columns < 2 * count + 2:
        return np.empty(0, dtype=complex)
    hankel = np.lib.stride_tricks.sliding_window_view(y, columns + 1)
    _, size, right = np.linalg.svd(hankel - 0.0, full_matrices=False)
    order = min(2 * count + 1, int(np.count_nonzero(size > 1e-13 * size[0])))
    subspace = right[:order].T
    steps = np.linalg.eigvals(np.linalg.lstsq(subspace[:-1], subspace[1:], rcond=None)[0])
    s: np.ndarray = np.log(steps[np.abs(steps) > 0.0].astype(complex)) / step
    s = s[s.imag > 1e-6 / step]
    s = s[np.abs(s.real) * step * len(y) < 100.0]
    if not len(s):
        return s
    t = np.arange(len(y)) * step
    waves = np.exp(np.outer(t, s))
    amplitude = np.linalg.lstsq(np.column_stack([waves.real, waves.imag, np.ones_like(t)]), y, rcond=None)[0]
    energy = np.hypot(amplitude[: len(s)], amplitude[len(s) : 2 * len(s)]) * np.linalg.norm(waves, axis=0)
    return np.asarray(s[np.argsort(-energy)[:count]])


def residual_peak(times: Floats, residual: Floats) -> complex:
    """Return the pole of the damped sine that takes most off a residual, of the peaks of a few spectra.

    Windows that fall from the start on see what dies out early, which one that begins at zero does not.
    """
    t = times - times[0]
    span = float(t[-1])
    part = np.linspace(0.0, 1.0, len(t))
    even = np.interp(part * span, t, residual)
    hertz = np.fft.rfftfreq(4 * len(t), span / (len(t) - 1))
    best, most = 1j, -1.0
    for window, rates in [(np.hanning(len(t)), SLOW), *((np.exp(-rate * part), (rate,)) for rate in QUICK)]:
        spectrum = np.abs(np.fft.rfft(even * window, 4 * len(t)))
        spectrum[:5] = 0.0
        omega = 2.0 * np.pi * float(hertz[int(np.argmax(spectrum))])
        for rate in rates:
            pole = complex(-rate / span, omega)
            taken = taken_off(pole, t, residual)
            if taken > most:
                best, most = pole, taken
    return best


def taken_off(pole: complex, t: Floats, residual: Floats) -> float:
    """Return the squares that a damped sine takes off a residual, t from its first sample on."""
    wave = np.exp(pole * t)
    pair = np.linalg.qr(np.column_stack([wave.real, wave.imag]))[0]
    return float(np.sum((pair.T @ residual) ** 2))
