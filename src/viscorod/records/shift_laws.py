"""The laws of Williams, Landel and Ferry and of Arrhenius through shift factors, with intervals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from viscorod.typing import Floats

__all__ = ["LawFit", "fit_arrhenius", "fit_wlf"]

GAS_CONSTANT = 8.314462618
ZERO = -273.15
CONFIDENCE = 0.95


@dataclass(frozen=True)
class LawFit:
    """A law of shift factors.

    Attributes:
        values: its numbers: c1 and c2 [K], or the activation energy [J/mol].
        low, high: ends of their 95 % intervals, infinite or zero where the factors do not say.
        off: root mean square of decimal logarithms of the factors about the law.
        information: Akaike's criterion with the law's own scatter, smaller is better.
        deviations: of log10 a_T about the law (n,).
    """

    values: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    off: float
    information: float
    deviations: Floats


def fit_wlf(celsius: Floats, decades: Floats, covariance: Floats, reference: float) -> LawFit | None:
    """Fit log10 a_T = -c1 (T - T_ref)/(c2 + T - T_ref); None where no such law fits.

    Args:
        celsius: temperatures (n,); decades: log10 a_T (n,), 0 at the reference.
        covariance: of the decades (n, n); reference: T_ref, degrees C.
    """
    above = celsius - reference
    least = max(-float(above.min()), 0.0)

    def law(p: Floats) -> Floats:
        c2 = least + np.exp(p[1])
        return np.asarray(-np.exp(p[0]) * above / (c2 + above))

    starts = [(np.log(c1), np.log(rest)) for c1 in (5.0, 15.0, 40.0) for rest in (5.0, 50.0, 300.0)]
    found = _fitted(law, decades, covariance, starts)
    if found is None:
        return None
    p, deviation, quantile, off, criterion, residual = found
    if p[1] > np.log(1e5) or p[0] > np.log(1e5):
        return None
    low = np.exp(p - quantile * deviation)
    high = np.exp(np.minimum(p + quantile * deviation, 700.0))
    shifted = np.array([0.0, least])
    return LawFit(
        tuple(np.exp(p) + shifted), tuple(low + shifted), tuple(high + shifted), off, criterion, residual
    )


def fit_arrhenius(celsius: Floats, decades: Floats, covariance: Floats, reference: float) -> LawFit | None:
    """Fit ln a_T = E_a/R (1/T - 1/T_ref); None where the factors do not fall with temperature."""
    inverse = 1.0 / (celsius - ZERO) - 1.0 / (reference - ZERO)

    def law(p: Floats) -> Floats:
        return np.asarray(np.exp(p[0]) / GAS_CONSTANT * inverse / np.log(10.0))

    found = _fitted(law, decades, covariance, [(np.log(1e5),)])
    if found is None:
        return None
    p, deviation, quantile, off, criterion, residual = found
    ends = [np.exp(p + side * quantile * deviation) for side in (-1.0, 1.0)]
    return LawFit(tuple(np.exp(p)), tuple(ends[0]), tuple(ends[1]), off, criterion, residual)


def _fitted(
    law: Callable[[Floats], Floats], decades: Floats, covariance: Floats, starts: Sequence[tuple[Any, ...]]
) -> tuple[Floats, Floats, float, float, float, Floats] | None:
    """Return numbers, standard deviations, quantile, misfit, criterion and deviations of the best of several starts.

    Each factor weighs by its own interval and by what the law itself is off (estimated together with it).
    """
    count, numbers = len(decades), len(starts[0])
    if count <= numbers + 1:
        return None
    spread = np.diag(covariance).copy()
    off = max(float(np.sqrt(np.median(spread[spread > 0.0]))) if (spread > 0.0).any() else 0.0, 1e-3)
    best = None
    for _ in range(6):
        scale = np.sqrt(spread + off**2)
        fits = []
        for start in starts if best is None else [tuple(best.x)]:
            try:
                fits.append(
                    least_squares(lambda p, s=scale: (law(p) - decades) / s, start, x_scale=1.0, max_nfev=400)
                )
            except (ValueError, np.linalg.LinAlgError):
                continue
        fits = [fit for fit in fits if np.isfinite(fit.cost)]
        if not fits:
            return None
        best = min(fits, key=lambda fit: fit.cost)
        square = (law(best.x) - decades) ** 2 - spread
        off = float(np.sqrt(max(np.sum(square) / (count - numbers), 1e-10)))
    assert best is not None
    inverse = np.linalg.pinv(best.jac.T @ best.jac)
    middle = best.jac.T @ (_whole(covariance, off) / np.outer(scale, scale)) @ best.jac
    deviation = np.sqrt(np.maximum(np.diag(inverse @ middle @ inverse), 0.0))
    residual = np.asarray(law(best.x) - decades)
    misfit = float(np.sqrt(np.mean(residual**2)))
    variance = spread + max(off, 1e-6) ** 2
    criterion = float(np.sum(residual**2 / variance + np.log(variance))) + 2.0 * (numbers + 1)
    return (
        best.x,
        deviation,
        float(student.ppf(0.5 + 0.5 * CONFIDENCE, count - numbers)),
        misfit,
        criterion,
        residual,
    )


def _whole(covariance: Floats, off: float) -> Floats:
    """Return the covariance of factors about a law that is itself off at random."""
    return np.asarray(covariance + off**2 * np.eye(len(covariance)))
