"""Bounded nonlinear least squares with noise that is estimated on the way.

SciPy's trust-region reflective Gauss-Newton seeks the unknowns; what is left gives the size and the colour of the
noise; by these the values are weighted anew and the search goes on from where it was, until neither changes (feasible
generalised least squares).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from viscorod.errors import InputError, SolveError
from viscorod.solve.estimation.noise import Noise, Series, SeriesNoise, noise_of
from viscorod.solve.estimation.predictions import Predictions
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["Estimate", "Scaled", "estimate", "no_worse", "searched"]

ROUNDS = 4
"""Times that the noise is estimated at most."""
SETTLED = 0.05
"""Standard errors by which new weights may move the unknowns without another search."""
NEAR = 0.5
"""Standard errors by which they may move them by one step with the slopes that there are."""
STATISTICAL, NEARLY = 2e-2, 0.25
"""Change of the sum of squares, in units of the noise, that is not worth another iteration, and that which one more
step ends with: half a standard error."""
REGION = 0.5
"""Change of a logarithm, or of a number over its scale, by which the first step goes at most, or so."""
ROUNDING = 1e-6
"""Change of a coordinate that does not count, however little noise there is."""
HELD = 0.2
"""One over the change of these that is held back as much as one standard deviation of a value: it leaves where they are
those that the data do not tell, and moves others by nothing that matters."""
FAR, CLOSE = 0.5, 0.2
"""Change of a logarithm, or of a number over its scale, up to which steps of motions stay as they are in a search, and
up to which they count as those of its end."""
AGAIN = 4
"""Times that a search is made with steps chosen anew."""
SAME = 1e-3
"""Relative difference of sums of squares below which two starts have found the same minimum; they have too where their
numbers are apart by less than :data:`NEAR`."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Where the sum of squares is least.

    Attributes:
        unknowns: that were sought; z: their coordinates there ``(p,)``.
        predicted: values there ``(n,)``; measured: what they are compared with.
        slopes: derivatives of the predictions by z ``(n, p)``.
        noise: of the measured values.
        accuracy: relative error of the slopes.
        starts: that were tried; agreeing: how many of them ended in this minimum.
        evaluations: of the values.
        unsettled: standard errors by which another step would move the unknowns, 0 where the search came to rest.
    """

    unknowns: Unknowns
    z: Floats
    measured: Floats
    predicted: Floats
    slopes: Floats
    noise: Noise
    accuracy: float
    starts: int
    agreeing: int
    evaluations: int
    unsettled: float = 0.0

    @property
    def values(self) -> Floats:
        """The unknowns ``(p,)`` in their units."""
        return self.unknowns.values(self.z)

    @property
    def residuals(self) -> Floats:
        """Measured less predicted ``(n,)``."""
        return self.measured - self.predicted

    @property
    def whitened_slopes(self) -> Floats:
        """Derivatives by z in units of independent noise ``(n, p)``."""
        return self.noise.whitened(self.slopes)

    @property
    def square(self) -> float:
        """Sum of squares of the whitened residuals."""
        white = self.noise.whitened(self.residuals)
        return float(white @ white)


class Scaled:
    """Predictions by the coordinates z; the last ones are kept."""

    def __init__(self, predictions: Predictions, unknowns: Unknowns, held: Floats | None = None) -> None:
        self._predictions, self._unknowns, self._held = predictions, unknowns, held
        self._last: tuple[bytes, Floats] | None = None
        self.evaluations = 0

    def hold(self, z: Floats, within: float) -> bool:
        """Hold what the predictions choose for themselves as it is at z, unless it is that of a place so near.

        Returns:
            Whether it is held anew.

        Raises:
            SolveError: there is no solution at z.
        """
        if self._held is not None and np.abs(z - self._held).max(initial=0.0) <= within:
            return False
        self._predictions.hold(self._unknowns.values(z))
        self.evaluations += 1
        self._held, self._last = z.copy(), None
        return True

    def values(self, z: Floats) -> Floats:
        """Return the values at z ``(n,)``."""
        key = z.tobytes()
        if self._last is None or self._last[0] != key:
            self.evaluations += 1
            self._last = key, self._predictions.values(self._unknowns.values(z))
        return self._last[1]

    @property
    def accuracy(self) -> float:
        """Relative error of the derivatives."""
        return self._predictions.accuracy

    def jacobian(self, z: Floats, *, rough: bool = False) -> Floats:
        """Return the derivatives by z ``(n, p)``."""
        return self._predictions.jacobian(self._unknowns.values(z), rough=rough) * self._unknowns.slopes(z)


class EndedError(Exception):
    """A search has come to its end, at the steps that it carries."""

    def __init__(self, steps: Floats) -> None:
        super().__init__("the search has come to its end")
        self.steps = steps


def estimate(
    predictions: Predictions,
    measured: Floats,
    series: Sequence[Series],
    unknowns: Unknowns,
    *,
    starts: int = 1,
    robust: bool = False,
    coloured: bool = True,
    seed: int = 0,
    report: Callable[[str], None] | None = None,
    begin: Floats | None = None,
) -> Estimate:
    """Seek the unknowns by which predictions come nearest to what was measured.

    Args:
        predictions: by the unknowns.
        measured: values ``(n,)``; series: what they belong to.
        unknowns: that are sought.
        starts: number of starts; the further ones are spread between the bounds (Latin hypercube).
        robust: let large residuals count less (Huber).
        coloured: whether noise may be correlated in time.
        seed: of the further starts.
        report: called with a sentence after every search.
        begin: z of the first start, if it is not that of the unknowns ``(p,)``.

    Raises:
        SolveError: no start can be evaluated.
    """
    scaled = Scaled(predictions, unknowns)
    first = _first_noise(series)
    found: list[tuple[float, Floats]] = []
    failed: SolveError | None = None
    for number, start in enumerate(_starts(unknowns, starts, seed, begin)):
        try:
            z = searched(scaled, measured, first, unknowns.bounds, start, unknowns.start, robust=robust)
            white = first.whitened(measured - scaled.values(z))
        except SolveError as error:
            failed = error
            continue
        found.append((float(white @ white), z))
        if report is not None:
            report(f"start {number + 1} of {starts}: sum of squares {found[-1][0]:.6g}")
    if not found:
        assert failed is not None
        raise failed
    least, z = min(found, key=lambda pair: pair[0])
    best = _weighted(scaled, measured, series, unknowns, z, starts, robust, coloured)
    white = best.whitened_slopes
    agreeing = sum(
        square <= least * (1.0 + SAME) + 1e-12 or bool(np.linalg.norm(white @ (other - z)) < NEAR)
        for square, other in found
    )
    return replace(best, agreeing=agreeing)


def _weighted(
    scaled: Scaled,
    measured: Floats,
    series: Sequence[Series],
    unknowns: Unknowns,
    z: Floats,
    starts: int,
    robust: bool,
    coloured: bool,
) -> Estimate:
    """Estimate the noise and seek again from z, until both agree."""
    noise, far = _first_noise(series), (0.0, 0.0)
    predicted, slopes = scaled.values(z), scaled.jacobian(z)
    for _ in range(ROUNDS):
        noise = noise_of(
            series, measured - predicted, slopes, noise, predicted=predicted, coloured=coloured, robust=robust
        )
        white = noise.whitened(slopes)
        step = _bounded_step(unknowns, z, white, noise.whitened(measured - predicted))
        far = _size(white, step)
        if far[0] < SETTLED:
            break
        if far[0] < NEAR:
            z = z + step
            predicted = scaled.values(z)
            continue
        begin = z + step if no_worse(scaled, noise, measured, predicted, z + step) else z
        moved = searched(scaled, measured, noise, unknowns.bounds, begin, unknowns.start)
        if not np.array_equal(moved, z):
            z, predicted, slopes = moved, scaled.values(moved), scaled.jacobian(moved)
            white = noise.whitened(slopes)
            step = _bounded_step(unknowns, z, white, noise.whitened(measured - predicted))
            far = _size(white, step)
    return Estimate(
        unknowns,
        z,
        measured,
        predicted,
        slopes,
        noise,
        scaled.accuracy,
        starts,
        1,
        scaled.evaluations,
        far[0] if far[0] >= NEAR and far[1] > ROUNDING else 0.0,
    )


def _size(white: Floats, step: Floats) -> tuple[float, float]:
    """Return the size of a step in standard errors, and the largest change of a coordinate."""
    return float(np.linalg.norm(white @ step)), float(np.abs(step).max(initial=0.0))


def no_worse(scaled: Scaled, noise: Noise, measured: Floats, predicted: Floats, z: Floats) -> bool:
    """Return whether the sum of squares is no larger at z than that of values predicted elsewhere: steps may go far."""
    try:
        there = noise.whitened(measured - scaled.values(z))
    except (SolveError, InputError):
        return False
    here = noise.whitened(measured - predicted)
    return bool(there @ there <= here @ here)


def _bounded_step(unknowns: Unknowns, z: Floats, white: Floats, residual: Floats) -> Floats:
    """Return the Gauss-Newton step, kept within the bounds; what the data do not tell is held."""
    low, high = unknowns.bounds
    rows = np.concatenate([white, HELD * np.eye(len(z))])
    step = np.linalg.lstsq(rows, np.append(residual, HELD * (unknowns.start - z)), rcond=1e-14)[0]
    inside = 1e-9 * np.where(np.isfinite(high - low), high - low, 1.0)
    return np.asarray(np.clip(z + step, low + inside, high - inside) - z)


def searched(
    scaled: Scaled,
    measured: Floats,
    noise: Noise,
    bounds: tuple[Floats, Floats],
    start: Floats,
    held: Floats,
    *,
    robust: bool = False,
) -> Floats:
    """Search where the weighted sum of squares is least, from a start on.

    What predictions choose for themselves, as steps of motions, is held: the sum of squares is smooth then. Where the
    search has gone far it is held anew, and the search goes on from there.

    Args:
        scaled: predictions; measured: what they are compared with; noise: that weighs them.
        bounds: of the coordinates; start: of the search.
        held: where those coordinates stay that the data do not tell.
        robust: let large residuals count less.

    Raises:
        SolveError: there is no solution at the start.
    """
    if not len(start):
        return start
    low, high = bounds
    room = 1e-9 * np.where(np.isfinite(high - low), high - low, 1.0)
    z = np.clip(start, low + room, high - room)
    scaled.hold(z, CLOSE)
    for _ in range(AGAIN):
        z = _searched_once(scaled, measured, noise, bounds, z, held, robust=robust)
        try:
            if not scaled.hold(z, CLOSE):
                break
        except (SolveError, InputError):  # there is none without the steps that were held
            break
    return z


def _searched_once(
    scaled: Scaled,
    measured: Floats,
    noise: Noise,
    bounds: tuple[Floats, Floats],
    start: Floats,
    held: Floats,
    *,
    robust: bool,
) -> Floats:
    """Return where a search from a start ends; arguments as of :func:`searched`."""
    low, high = bounds
    origin = start - REGION  # SciPy's first trust region is the size of what it starts from
    first = noise.whitened(scaled.values(start) - measured)
    refused = 10.0 * (np.abs(first) + float(np.abs(first).max(initial=0.0)))
    enough, nearly = (float(np.clip(part / len(measured), 1e-10, 1e-3)) for part in (STATISTICAL, NEARLY))

    def residual(steps: Floats) -> Floats:
        try:
            white = noise.whitened(scaled.values(origin + steps) - measured)
        except (
            SolveError,
            InputError,
        ):  # there is no solution there: too far, the search takes a smaller step
            white = refused
        return np.append(white, HELD * (origin + steps - held))

    def slopes(steps: Floats) -> Floats:
        z = origin + steps
        with suppress(SolveError, InputError):  # what is held stays
            scaled.hold(z, FAR)
        found = np.concatenate([noise.whitened(scaled.jacobian(z, rough=True)), HELD * np.eye(len(steps))])
        now = residual(steps)
        step = -np.linalg.lstsq(found, now, rcond=1e-14)[0]
        gain = float(np.sum((found @ step) ** 2))
        inside = bool(np.all((low < z + step) & (z + step < high)))
        if inside and not robust and gain <= nearly * float(now @ now):
            raise EndedError(steps + step)
        return found

    try:
        found = least_squares(
            residual,
            np.full(len(start), REGION),
            slopes,
            bounds=(low - origin, high - origin),
            x_scale=1.0,
            ftol=enough,
            xtol=1e-8,
            gtol=1e-12,
            loss="soft_l1" if robust else "linear",
            f_scale=0.1 if robust else 1.0,
            max_nfev=60,
        )
    except EndedError as ended:
        return np.asarray(origin + ended.steps)
    return np.asarray(origin + found.x)


def _first_noise(series: Sequence[Series]) -> Noise:
    """Return the noise before anything is known of it: as it was told, or a part of the values' spread."""
    return Noise(tuple(series), tuple(SeriesNoise(1.0) for _ in series))


def _starts(unknowns: Unknowns, count: int, seed: int, begin: Floats | None) -> list[Floats]:
    """Return the given start and others between the bounds, or within a factor of ten of the start."""
    start = unknowns.start if begin is None else begin
    low, high = unknowns.bounds
    if count <= 1:
        return [start]
    near = np.array([np.log(10.0) if one.logarithmic else 1.0 for one in unknowns])
    low, high = np.maximum(low, start - near), np.minimum(high, start + near)
    spread = qmc.LatinHypercube(len(unknowns), seed=seed).random(count - 1)
    return [start, *(low + part * (high - low) for part in spread)]
