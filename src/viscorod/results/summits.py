"""Largest values between computed ones: of samples of a cycle, of curves of periodic motions, of responses."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.typing import Floats

__all__ = ["Summit", "largest_in_cycle", "summit_of", "summit_of_response"]

AROUND = 3
"""Points of a curve to each side of the largest one through which a spline is laid."""
UNEVEN = 4.0
"""Longest of the steps between these over the shortest from which on no spline is laid."""
TINY = float(np.finfo(float).tiny)
GROWS = 1e-9
"""Part of a pole that its decay is of it, up to which nothing damps it but round-off."""
FINE = 1e-4
"""Part of the half width of a resonance to which the frequency of its top is sought."""
WIDE = 4.0
"""Half widths of a resonance to each side of its frequency between which its top is sought."""


class Summit(NamedTuple):
    """The top of a curve: number of the point next to it, frequency [Hz], amplitude or size."""

    point: int
    frequency: float
    amplitude: float


def largest_in_cycle(values: Floats) -> Floats:
    """Return the tops of the parabolas through the largest of samples of a cycle and its neighbours ``(points,)``.

    Args:
        values: equally spaced over whole cycles ``(points, instants)``.
    """
    rows, top = np.arange(len(values)), values.argmax(axis=1)
    before, here, after = (values[rows, (top + k) % values.shape[1]] for k in (-1, 0, 1))
    bend = 2.0 * here - before - after
    return np.asarray(
        here + np.divide((after - before) ** 2, 8.0 * bend, out=np.zeros(len(here)), where=bend > 0.0)
    )


def summit_of(frequencies: Floats, amplitudes: Floats) -> Summit:
    """Return the top of amplitudes over frequencies, both in their order along a curve that may turn back.

    Beside the largest point both are cubic splines of the number of the point, as steps along a curve are nearly even.
    Where they are not, and at the ends of the curve, the top is the largest point.
    """
    top = int(amplitudes.argmax())
    at_point = Summit(top, float(frequencies[top]), float(amplitudes[top]))
    first = max(0, top - AROUND)
    pairs = np.column_stack([frequencies, amplitudes])[first : top + AROUND + 1]
    here = top - first
    if not 0 < here < len(pairs) - 1:
        return at_point
    steps = np.linalg.norm(np.diff(pairs / np.maximum(np.ptp(pairs, axis=0), TINY), axis=0), axis=1)
    if steps.max() > UNEVEN * steps.min():
        return at_point
    from scipy.interpolate import CubicSpline

    number = np.arange(len(pairs))
    slope = CubicSpline(number, pairs[:, 1]).derivative()
    inside = [one for one in slope.roots(extrapolate=False) if here - 1 < one < here + 1]
    tops = CubicSpline(number, pairs)(inside).reshape(-1, 2)
    frequency, amplitude = max(tops.tolist(), key=lambda pair: float(pair[1]), default=(0.0, 0.0))
    return Summit(top, frequency, amplitude) if amplitude > at_point.amplitude else at_point


def summit_of_response(
    hertz: Floats, response: np.ndarray, poles: np.ndarray, residues: np.ndarray
) -> Summit:
    """Return the top of the size of a response.

    Between the frequencies it is the sum of what the poles have in it and of what they leave of the computed values,
    along straight lines; without the poles a narrow peak would be as high as the frequency that happens to be next to
    it. A pole without damping has no top, and counts as it does at the frequencies.

    Args:
        hertz: increasing frequencies ``(n,)``; response: there ``(n,)``.
        poles: ``s`` [1/s], Im s > 0; residues: of the parts ``residue/(i omega - s)``.
    """
    damped = poles.real < -GROWS * np.abs(poles)
    poles, residues = poles[damped], residues[damped]

    def of_poles(f: Floats) -> np.ndarray:
        at = 2j * np.pi * np.asarray(f)[..., None]
        parts = residues / (at - poles) + residues.conj() / (at - poles.conj())
        return np.asarray(parts.sum(axis=-1))

    left = response - of_poles(hertz)

    def size(f: float) -> float:
        rest = complex(np.interp(f, hertz, left.real), np.interp(f, hertz, left.imag))
        return float(abs(of_poles(np.array(f)) + rest))

    sizes = np.abs(response)
    top = int(sizes.argmax())
    best = Summit(top, float(hertz[top]), float(sizes[top]))
    from scipy.optimize import minimize_scalar

    for pole in poles:
        centre, half = pole.imag / (2.0 * np.pi), -pole.real / (2.0 * np.pi)
        low, high = max(centre - WIDE * half, float(hertz[0])), min(centre + WIDE * half, float(hertz[-1]))
        if low < high:
            found = minimize_scalar(
                lambda f: -size(f), bounds=(low, high), method="bounded", options={"xatol": FINE * half}
            )
            if -found.fun > best.amplitude:
                nearest = int(np.abs(hertz - found.x).argmin())
                best = Summit(nearest, float(found.x), float(-found.fun))
    return best
