"""The noise of sweeps that are laid over each other, and the covariance of their shifts."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

__all__ = ["points_left", "shift_covariance"]

CHANCE = 2.0
"""Standard deviations of the correlation of white noise up to which it counts as none."""


def points_left(weighted: Floats, weights: Floats, seen: np.ndarray) -> Floats:
    """Return the points of either modulus that are seen, less the numbers that they determine (2,).

    Args:
        weighted: derivatives of all equations by everything; weights: of the points (2, points); seen: which count.
    """
    inverse = np.linalg.pinv(weighted.T @ weighted, rcond=1e-13, hermitian=True)
    points = weighted[: weights.size]
    used = np.sum((points @ inverse) * points, axis=1).reshape(2, -1)
    count = np.count_nonzero(seen, axis=1)
    return np.asarray(np.maximum(count - np.sum(used * seen, axis=1), np.maximum(0.3 * count, 1.0)))


def shift_covariance(
    weighted: Floats,
    residual: Floats,
    weights: Floats,
    sweep: np.ndarray,
    size: int,
    free: np.ndarray,
    count: int,
    left: Floats,
) -> tuple[Floats, Floats]:
    """Return the covariance of ln a and ln b of robust least squares, and the degrees of freedom that it rests on.

    That of Huber's estimate (Street, Carroll and Ruppert 1988): the mean square of what the weights leave of the
    residuals over the square of the part of them that has its full weight; times what neighbours in a sweep have in
    common. Degrees of freedom are Satterthwaite's, of the scatters of both moduli.
    """
    inverse = np.linalg.pinv(weighted.T @ weighted, rcond=1e-13, hermitian=True)
    points = weighted[: residual.size]
    hat = points @ inverse
    used = float(np.sum(hat * points))  # numbers that the points determine; the penalties hold the rest
    known = weights > 0.0
    freedom = max(np.count_nonzero(known) - used, 1.0)
    kept = weights**2 * residual
    full = float(np.mean(weights[known] == weights.max()))
    variance = float(np.sum(kept**2)) / freedom * float(np.mean(weights[known] ** 2)) / max(full, 0.5) ** 2
    rho = _neighbourly(weights * residual, hat, points, sweep)
    places = np.concatenate([free, count + free])[: len(inverse) - 2 * size]
    part = inverse[2 * size :, 2 * size :]
    found, degrees = np.zeros((2 * count, 2 * count)), np.full(2 * count, float(left.sum()))
    found[np.ix_(places, places)] = part * variance * (1.0 + rho) / (1.0 - rho)
    of_each = np.stack([np.sum(one[:, 2 * size :] ** 2, axis=0) for one in np.split(hat, 2)])
    shares = of_each / np.maximum(np.diag(part), 1e-300)
    degrees[places] = 1.0 / np.maximum(np.sum(shares**2 / left[:, None], axis=0), 1.0 / left.sum())
    return found, degrees


def _neighbourly(residual: Floats, hat: Floats, points: Floats, sweep: np.ndarray) -> float:
    """Return the correlation of the noise of neighbours in a sweep, 0 if it is not more than chance makes.

    Residuals are less alike than the noise was, by what the curves follow: the hat matrix says by how much.
    """
    count = residual.shape[1]
    same = np.flatnonzero(sweep[1:] == sweep[:-1])
    alike = spread = 0.0
    for k, one in enumerate(residual):
        first, second = k * count + same, k * count + same + 1
        alike += float(np.sum(one[same] * one[same + 1]) + np.sum(hat[first] * points[second]))
        spread += float(np.sum(one[same] ** 2) + np.sum(hat[first] * points[first]))
    rho = alike / max(spread, 1e-300)
    return float(np.clip(rho, 0.0, 0.9)) if rho > CHANCE / np.sqrt(max(2 * len(same), 1)) else 0.0
