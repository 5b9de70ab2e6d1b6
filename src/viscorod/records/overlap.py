"""Sweeps at several temperatures laid over each other: shifts and one smooth curve by robust least squares.

With x = ln omega the logarithms of both moduli of sweep i are f(x + ln a_i) + ln b_i: relaxation times a_i, moduli b_i
times those of the reference. The two curves f are cubic splines with a weak penalty on their third differences, fitted
together with all shifts; storage and loss each have their own scatter, and points far off count less (Huber 1964).
Shifts are expected to change steadily from sweep to sweep (`TURN`, `LIFT`), which decides only where the moduli do not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

from viscorod.model.materials.moduli_over_frequency import DmaTable
from viscorod.records.shift_noise import points_left, shift_covariance
from viscorod.typing import Floats

__all__ = ["Overlap", "overlapped"]

DECADE = float(np.log(10.0))
KNOTS = 2.0
"""Per decade of reduced frequency."""
BEND = 0.05
"""Third differences of the curves from knot to knot that are usual; a peak of the loss modulus has twice that."""
TURN = DECADE
"""Usual change of the step of ln a from sweep to sweep."""
UNKNOWN, UNSURE = 0.3, 0.02
"""Parts of their weight with which such steps, and the points, of a sweep that shares no moduli with a neighbour count:
where the curve goes on between them nobody knows, and it must not bend that of the others."""
LIFT = 0.02
"""The same of ln b, which follows density and temperature."""
ROUGH, LIFTED = 0.03, 0.1
"""Differences of logarithms of moduli, and lifts, between neighbours that are usual."""
APART = 10.0
"""Square of these from which on two sweeps share no moduli."""
CAREFUL = 0.1
"""First steps of ln a."""
HUBER = 2.0
"""Scatters from which on a point counts less."""
MEDIAN_TO_DEVIATION = 1.4826
"""Median of the sizes of normal noise times this is its standard deviation."""
CLIPPED = 0.92054
"""Mean square of normal noise of size one, cut off at `HUBER` (Huber's proposal 2 for the scatter, 1964)."""
ROUNDS = 12
SETTLED = 1e-4
QUANTILE = 1.96
"""Standard deviations of half a 95 % interval."""
FINEST = 1e-5
"""Relative scatter below which points are not weighed higher."""


@dataclass(frozen=True, eq=False)
class Overlap:
    """Sweeps laid over each other.

    Attributes:
        log_a, log_b: natural logarithms of the shifts of the sweeps (n,), 0 of the reference.
        covariance: of log_a, then log_b (2 n, 2 n); zero of what is held.
        freedom: degrees of freedom of the scatter that each of these rests on (2 n,).
        scatter: standard deviations of the logarithms of storage and loss modulus about the curves.
        knots: of the splines; curves: their coefficients (2, m).
        bridged: whether each sweep's moduli reach into those of a neighbour (n,).
    """

    log_a: Floats
    log_b: Floats
    covariance: Floats
    freedom: Floats
    scatter: tuple[float, float]
    knots: Floats
    curves: Floats
    bridged: np.ndarray

    def at(self, log_omega: Floats) -> tuple[Floats, Floats]:
        """Return storage and loss modulus of the reference at ln of reduced angular frequencies, Pa."""
        storage, loss = (np.exp(BSpline(self.knots, one, 3)(log_omega)) for one in self.curves)
        return storage, loss


def overlapped(tables: Sequence[DmaTable], celsius: Floats, reference: int, vertical: bool) -> Overlap:
    """Lay sweeps over each other.

    Args:
        tables: by increasing temperature (n,); celsius: their temperatures (n,).
        reference: which of them stays where it is.
        vertical: whether moduli are shifted too.
    """
    count = len(tables)
    sweep = np.repeat(np.arange(count), [len(one.omega) for one in tables])
    x = np.log(np.concatenate([one.omega for one in tables]))
    y = np.log(
        np.maximum(
            np.stack(
                [np.concatenate([getattr(one, name) for one in tables]) for name in ("storage", "loss")]
            ),
            1e-300,
        )
    )
    known = y > -600.0
    start, touching = _neighbours(tables)
    bridged = np.append(touching, False) | np.insert(touching, 0, False)
    log_a = start - start[reference]
    free = np.delete(np.arange(count), reference)
    layout = _Layout(
        x, sweep, np.where(known, y, 0.0), _knots(x + log_a[sweep]), free, vertical, celsius, bridged
    )
    first = np.array([0.005, 0.01])  # small, so that the curves may follow all that the points say
    scatter = first.copy()
    trust = np.where(bridged[sweep], 1.0, UNSURE) * known
    weights, updated = trust.copy(), first.copy()
    for _ in range(ROUNDS):
        before = log_a.copy()
        log_a[free] = layout.settled(log_a, weights / scatter[:, None])
        solution, residual = layout.solved(log_a, weights / scatter[:, None])
        seen = known & (bridged[sweep] | ~bridged.any())
        left = points_left(layout.whole(log_a, solution, weights / scatter[:, None]), weights, seen)
        for k in (0, 1):
            if np.array_equal(scatter, first):
                found = MEDIAN_TO_DEVIATION * float(np.median(np.abs(residual[k][seen[k]])))
                found *= np.sqrt(np.count_nonzero(seen[k]) / left[k])
            else:
                off = np.abs(residual[k][seen[k]])
                found = float(np.sqrt(np.sum(np.minimum(off, HUBER * scatter[k]) ** 2) / (CLIPPED * left[k])))
            updated[k] = max(found, FINEST)
        scatter = updated.copy()
        off = np.abs(residual) / scatter[:, None]
        weights = trust * np.sqrt(np.minimum(1.0, HUBER / np.maximum(off, 1e-12)))
        if np.abs(log_a - before).max() < SETTLED:
            break
    weighted = layout.whole(log_a, solution, weights / scatter[:, None])
    covariance, freedom = shift_covariance(
        weighted, residual / scatter[:, None], weights, sweep, layout.size, free, count, left
    )
    covariance[:count, :count] += _across_gaps(log_a, touching, reference)
    log_b = np.zeros(count)
    if vertical:
        log_b[free] = solution[2 * layout.size :]
    return Overlap(
        log_a=log_a,
        log_b=log_b,
        covariance=covariance,
        freedom=freedom,
        scatter=(float(scatter[0]), float(scatter[1])),
        knots=layout.knots,
        curves=solution[: 2 * layout.size].reshape(2, -1),
        bridged=bridged,
    )


def _neighbours(tables: Sequence[DmaTable]) -> tuple[Floats, np.ndarray]:
    """Return ln a of every sweep from the moduli that it shares with the next warmer one, the warmest being 0.

    A sweep that shares none lies beyond the range of its warmer neighbour, and goes on as the steps before do.

    Returns:
        ln a (n,), and whether each sweep shares moduli with the next warmer one (n - 1,).
    """
    count = len(tables)
    steps, touching = np.zeros(count - 1), np.zeros(count - 1, dtype=bool)
    for k in range(count - 2, -1, -1):
        step, misfit = _step(tables[k], tables[k + 1])
        touching[k] = misfit < APART
        if touching[k]:
            steps[k] = step
            continue
        grown = steps[k + 1 : k + 3] if k < count - 2 else np.zeros(0)
        onward = float(grown[0] + max(grown[0] - grown[-1], 0.0)) if len(grown) else 0.0
        steps[k] = max(onward, float(np.ptp(np.log(tables[k].omega))))
    log_a = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
    return log_a, touching


def _across_gaps(log_a: Floats, touching: np.ndarray, reference: int) -> Floats:
    """Return the covariance of ln a by steps over which no moduli are shared: as uncertain as they are large."""
    count = len(log_a)
    found = np.zeros((count, count))
    for k in np.flatnonzero(~touching):
        beyond = np.arange(count) <= k if reference > k else np.arange(count) > k
        found[np.ix_(beyond, beyond)] += ((log_a[k] - log_a[k + 1]) / QUANTILE) ** 2
    return found


def _step(cold: DmaTable, warm: DmaTable) -> tuple[float, float]:
    """Return the change of ln a from a sweep to the next colder one, and how badly the two then agree.

    The logarithms of both moduli may differ by one small number, the change of ln b.
    """
    x, y = (np.log(one.omega) for one in (cold, warm))
    cold_y, warm_y = (np.log(np.maximum([one.storage, one.loss], 1e-9 * one.storage)) for one in (cold, warm))
    best = (0.0, np.inf)
    reach = min(float(np.ptp(x)), float(np.ptp(y)))
    for step in np.linspace(0.0, 0.8 * reach, 81):
        # a point of the colder sweep stands at x + step on the axis of the warmer one
        inside = (x + step >= y[0]) & (x + step <= y[-1])
        if np.count_nonzero(inside) < 2:
            continue
        off = np.stack([np.interp(x[inside] + step, y, one) for one in warm_y]) - cold_y[:, inside]
        weight = np.array([[1.0], [0.25]])
        lift = float(np.sum(weight * off) / np.sum(weight * np.ones_like(off)))
        score = float(np.mean(weight * (off - lift) ** 2)) / ROUGH**2 + (lift / LIFTED) ** 2
        if score < best[1]:
            best = (float(step), score)
    return best


def _knots(x: Floats) -> Floats:
    low, high = float(x.min()) - DECADE, float(x.max()) + DECADE
    count = max(int(np.ceil((high - low) / DECADE * KNOTS)), 4)
    step = (high - low) / count
    return np.asarray(low + step * np.arange(-3.0, count + 4.0))


class _Layout:
    """The linear equations of both curves and of ln b at given ln a: points of storage, of loss, then the penalty."""

    def __init__(
        self,
        x: Floats,
        sweep: np.ndarray,
        y: Floats,
        knots: Floats,
        free: np.ndarray,
        vertical: bool,
        celsius: Floats,
        bridged: np.ndarray,
    ) -> None:
        self.x, self.sweep, self.y, self.knots, self.free = x, sweep, y, knots, free
        self.size = len(knots) - 4
        self.indicator = (sweep[:, None] == free).astype(float)
        self.lifted = self.indicator if vertical else np.zeros((len(x), 0))
        third = np.diff(np.eye(self.size), 3, axis=0) / BEND
        none = np.zeros_like(third)
        bends = _second_differences(celsius)[:, free]
        sure = np.array([bridged[k : k + 3].all() for k in range(len(bends))], dtype=bool)
        self.turns = bends / TURN * np.where(sure, 1.0, UNKNOWN)[:, None]
        curves = np.block([[third, none], [none, third]])
        lifts = np.zeros((0, 0)) if not vertical else bends / LIFT
        self.penalty = np.block(
            [
                [curves, np.zeros((len(curves), lifts.shape[1]))],
                [np.zeros((len(lifts), curves.shape[1])), lifts],
            ]
        )
        self.right = np.concatenate([y[0], y[1], np.zeros(len(self.penalty))])

    def reduced(self, log_a: Floats) -> Floats:
        found: Floats = np.clip(self.x + log_a[self.sweep], self.knots[3], self.knots[-4])
        return found

    def linear(self, log_a: Floats) -> Floats:
        basis = BSpline.design_matrix(self.reduced(log_a), self.knots, 3).toarray()
        none = np.zeros_like(basis)
        return np.vstack(
            [np.hstack([basis, none, self.lifted]), np.hstack([none, basis, self.lifted]), self.penalty]
        )

    def slopes(self, log_a: Floats, solution: Floats) -> Floats:
        """Return the derivatives of all equations by the free ln a."""
        at = self.reduced(log_a)
        parts = [
            BSpline(self.knots, one, 3)(at, 1)[:, None] * self.indicator
            for one in solution[: 2 * self.size].reshape(2, -1)
        ]
        return np.vstack([*parts, np.zeros((len(self.penalty), len(self.free)))])

    def rows(self, weights: Floats) -> Floats:
        return np.concatenate([weights.ravel(), np.ones(len(self.penalty))])

    def solved(self, log_a: Floats, weights: Floats) -> tuple[Floats, Floats]:
        """Return what is linear, and the residuals of the points (2, points)."""
        matrix, rows = self.linear(log_a), self.rows(weights)
        solution = np.asarray(
            np.linalg.lstsq(matrix * rows[:, None], self.right * rows, rcond=None)[0], dtype=float
        )
        residual = (matrix @ solution - self.right)[: 2 * len(self.x)].reshape(2, -1)
        return solution, residual

    def settled(self, log_a: Floats, weights: Floats) -> Floats:
        """Return the free ln a that leave least over, with what is linear eliminated (Kaufman 1975)."""
        rows = self.rows(weights)

        def at(change: Floats) -> Floats:
            whole = log_a.copy()
            whole[self.free] += change
            return whole

        def misfit(free: Floats) -> Floats:
            matrix = self.linear(at(free)) * rows[:, None]
            right = self.right * rows
            off = matrix @ np.linalg.lstsq(matrix, right, rcond=None)[0] - right
            return np.concatenate([off, self.turns @ at(free)[self.free]])

        def jacobian(free: Floats) -> Floats:
            matrix = self.linear(at(free)) * rows[:, None]
            solution = np.linalg.lstsq(matrix, self.right * rows, rcond=None)[0]
            slope = self.slopes(at(free), np.asarray(solution, dtype=float)) * rows[:, None]
            u, size, _ = np.linalg.svd(matrix, full_matrices=False)
            u = u[:, size > 1e-12 * size[0]]
            return np.vstack([slope - u @ (u.T @ slope), self.turns])

        # changes from zero, so that the first steps are small: there are far minima in which sweeps lie on each other
        start = np.zeros(len(self.free))
        found = least_squares(
            misfit, start, jac=jacobian, x_scale=CAREFUL, xtol=1e-9, ftol=1e-10, max_nfev=60
        )
        return np.asarray(log_a[self.free] + found.x)

    def whole(self, log_a: Floats, solution: Floats, weights: Floats) -> Floats:
        """Return the weighted derivatives of all equations by everything: curves, ln a, ln b."""
        matrix = self.linear(log_a)
        parts = [matrix[:, : 2 * self.size], self.slopes(log_a, solution), matrix[:, 2 * self.size :]]
        points = np.hstack(parts) * self.rows(weights)[:, None]
        turns = np.zeros((len(self.turns), points.shape[1]))
        turns[:, 2 * self.size : 2 * self.size + len(self.free)] = self.turns
        return np.vstack([points, turns])


def _second_differences(celsius: Floats) -> Floats:
    """Return the changes of slope from sweep to sweep, of a quantity of the sweeps, per usual step (n - 2, n)."""
    count = len(celsius)
    step = np.maximum(np.diff(celsius), 1e-3)
    usual = float(np.median(step)) if count > 1 else 1.0
    found = np.zeros((max(count - 2, 0), count))
    for k in range(count - 2):
        found[k, k : k + 3] = usual / step[k], -usual / step[k] - usual / step[k + 1], usual / step[k + 1]
    return found
