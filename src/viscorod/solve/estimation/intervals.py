"""How far unknowns may be from their estimates: covariance, intervals, and what the data cannot tell.

The singular values of the whitened derivatives say which directions of the unknowns the data see. An unknown with
a part in a direction that they do not see has an infinite interval. The others have Laplace's interval (the
estimate and its standard error by the quantile of Student), checked by the sum of squares at its ends; where that
is not what a parabola has there, the interval is that of the profile likelihood: all values for which the least
sum of squares over the others exceeds the least of all by the squared quantile.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from viscorod.errors import InputError, SolveError
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.solve.estimation.noise import LEAST_OWN, Noise, SeriesNoise, leverage
from viscorod.typing import Floats

__all__ = ["Covariance", "Interval", "covariance", "intervals", "profile_end"]

ERRORS = 3.0
"""Times the error of the derivatives: directions along which the whitened values change less are not seen.

Every column errs by a part of itself, whatever the units of its unknown.
"""
TOO_WIDE = 2.0
"""Standard error of a logarithm, or of a number over its scale, from which on a direction is not told by the data."""
PART = 0.05
"""Part of a unit vector that an unknown may have in a direction that is not seen and still be told."""
CERTAIN = 1e6
"""Degrees of freedom of noise that was told."""
ALONE = float(np.sqrt(1.0 - PART**2))
"""Part of a direction that is not seen along one unknown from which on it is only that unknown."""
STRAIGHT = 0.005
"""Relative standard error below which the sum of squares is taken for a parabola."""
FARTHER, FAR = float(np.log(3.0)), 12
"""Steps in which the end of the interval of such an unknown is sought, and how many."""
VERY_FAR = float(np.log(1e6))
"""Change of a logarithm, or of a number over its scale, at which a profile that has not risen never will."""
LEAST_FREEDOM = 2.0
"""Degrees of freedom below which derivatives of a standard error say nothing of it."""
COLOUR_STEP = 1e-3
"""Change of coordinates of autocorrelations by which differences are taken."""
SKEWED = 0.1
"""Relative difference of the sum of squares from a parabola's from which on the profile is taken."""


@dataclass(frozen=True, eq=False)
class Covariance:
    """What is known of the unknowns, in their coordinates z.

    Attributes:
        matrix: covariance ``(p, p)`` along the directions that the data see.
        unseen: orthonormal directions that they do not see ``(k, p)``.
        freedom: degrees of freedom of the noise that each unknown's standard error rests on ``(p,)``.
        contributions: parts of the matrix that rest on one noise level each, with their degrees of freedom.
        colours: derivatives of the matrix by the coordinates of autocorrelations ``(m, p, p)``, with the covariance of
            these, of every series that has some.
    """

    matrix: Floats
    unseen: Floats
    freedom: Floats
    contributions: tuple[tuple[Floats, float], ...]
    colours: tuple[tuple[Floats, Floats], ...] = ()

    @property
    def deviations(self) -> Floats:
        """Standard errors ``(p,)`` along what is seen."""
        return np.asarray(np.sqrt(np.diag(self.matrix)))

    def told(self, gradient: Floats) -> bool:
        """Return whether the data tell a combination with this gradient by z."""
        if not len(self.unseen):
            return True
        size = float(np.linalg.norm(gradient))
        return size > 0.0 and float(np.linalg.norm(self.unseen @ gradient)) <= PART * size

    def alone(self, k: int) -> bool:
        """Return whether an unknown that is not told is so by itself, and not beside others."""
        return any(abs(direction[k]) > ALONE for direction in self.unseen)

    def deviation(self, gradient: Floats) -> float:
        """Return the standard error of a combination, along what is seen."""
        return float(np.sqrt(max(float(gradient @ self.matrix @ gradient), 0.0)))

    def freedom_of(self, gradient: Floats) -> float:
        """Return the degrees of freedom of a combination's standard error.

        Twice its square over the variance of its square, by the doubts of noise levels and of autocorrelations: F. E.
        Satterthwaite, Biometrics 2 (1946) 110-114; M. G. Kenward and J. H. Roger, Biometrics 53 (1997) 983-997.
        """
        whole = float(gradient @ self.matrix @ gradient)
        if whole <= 0.0:
            return np.inf
        below = sum(
            (float(gradient @ part @ gradient) / whole) ** 2 / free for part, free in self.contributions
        )
        for slopes, doubt in self.colours:
            part = np.einsum("i,kij,j->k", gradient, slopes, gradient) / whole
            below += 0.5 * float(part @ doubt @ part)
        return max(float(1.0 / below), LEAST_FREEDOM) if below > 0.0 else np.inf


@dataclass(frozen=True)
class Interval:
    """Where a number lies with some probability; infinite ends where the data cannot tell."""

    low: float
    high: float
    how: str

    @property
    def told(self) -> bool:
        """Whether both ends are finite."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high))


def covariance(found: Estimate) -> Covariance:
    """Return the covariance of an estimate and the directions that the data do not see."""
    white = found.whitened_slopes
    count = white.shape[1]
    size = np.linalg.norm(white, axis=0)
    _, values, directions = np.linalg.svd(white, full_matrices=False)
    doubt = ERRORS * found.accuracy * np.linalg.norm(directions * size, axis=1)
    seen = (values > doubt) & (values > 1.0 / TOO_WIDE)
    inverse = (directions[seen].T / values[seen] ** 2) @ directions[seen]
    used = leverage(white)
    contributions = []
    groups: dict[tuple[str, int], tuple[Floats, float]] = {}
    for number, (series, noise) in enumerate(zip(found.noise.series, found.noise.found, strict=True)):
        part = white[series.rows]
        own = series.count - float(used[series.rows].sum())
        key = ("", number) if series.count >= LEAST_OWN else (f"{series.group}{series.told}", -1)
        if series.certain or (series.told and series.count < LEAST_OWN and noise.factor == 1.0):
            own = CERTAIN
        before = groups.get(key, (np.zeros((count, count)), 0.0))
        groups[key] = before[0] + part.T @ part, before[1] + own
    for information, free in groups.values():
        contributions.append((inverse @ information @ inverse, max(free, 1.0)))
    result = Covariance(
        inverse, directions[~seen], np.zeros(count), tuple(contributions), _colours(found, inverse)
    )
    return replace(result, freedom=np.array([result.freedom_of(row) for row in np.eye(count)]))


def _colours(found: Estimate, inverse: Floats) -> tuple[tuple[Floats, Floats], ...]:
    """Return the derivatives of a covariance by the autocorrelations of every series, with the covariance of these."""
    out = []
    for number, noise in enumerate(found.noise.found):
        slopes = []
        for k in range(len(noise.partials)):
            above, below = (
                _information(found, number, noise.moved(k, sign * COLOUR_STEP)) for sign in (1.0, -1.0)
            )
            slopes.append(inverse @ (below - above) @ inverse / (2.0 * COLOUR_STEP))
        if slopes:
            out.append((np.stack(slopes), noise.doubt))
    return tuple(out)


def _information(found: Estimate, number: int, noise: SeriesNoise) -> Floats:
    """Return what a series tells of the unknowns with this noise ``(p, p)``."""
    series = found.noise.series[number]
    alone = replace(series, rows=slice(0, series.count))
    white = Noise((alone,), (noise,)).whitened(found.slopes[series.rows])
    return np.asarray(white.T @ white)


def intervals(
    found: Estimate,
    known: Covariance,
    level: float,
    square: Callable[[Floats], float] | None = None,
    profile: Callable[[int, float, Floats], tuple[float, Floats]] | None = None,
) -> list[Interval]:
    """Return the intervals of the unknowns, in their units.

    Args:
        found: the estimate; known: its covariance.
        level: probability of an interval.
        square: sum of squares of whitened residuals at z; without it Laplace's intervals are not checked.
        profile: least sum of squares for a value of one coordinate, from a start on, and where.
    """
    out = []
    low, high = found.unknowns.bounds
    for k in range(len(found.z)):
        axis = np.eye(len(found.z))[k]
        reach = float(stats.t.ppf(0.5 + level / 2.0, known.freedom[k] or 1.0))
        if not known.told(axis):
            ends = [-np.inf, np.inf]
            if profile is not None and known.alone(k):
                ends = [_far_end(profile, found, k, reach, bound) for bound in (low[k], high[k])]
            out.append(Interval(*_in_units(found, k, ends), "not told by the data"))
            continue
        way = known.matrix[:, k] / known.deviations[k]
        ends, how = [], "Laplace"
        straight = found.unknowns[k].logarithmic and known.deviations[k] < STRAIGHT
        for sign, bound in ((-1.0, low[k]), (1.0, high[k])):
            end = float(found.z[k] + sign * reach * known.deviations[k])
            if square is not None and not straight and _skewed(square, found, way, sign * reach, (low, high)):
                assert profile is not None
                end, how = profile_end(profile, found, k, end, reach, bound), "profile"
            beyond = end <= bound if sign < 0.0 else end >= bound
            ends.append(float(bound) if beyond else end)
        out.append(Interval(*_in_units(found, k, ends), how))
    return out


def _in_units(found: Estimate, k: int, ends: Sequence[float]) -> tuple[float, float]:
    """Return ends of an interval of z as values; those of logarithms that are open are 0 and infinity."""
    low, high = (
        float(found.unknowns.values(np.where(np.arange(len(found.z)) == k, end, found.z))[k])
        if np.isfinite(end)
        else (0.0 if found.unknowns[k].logarithmic and end < 0.0 else end)
        for end in ends
    )
    return low, high


def _far_end(
    profile: Callable[[int, float, Floats], tuple[float, Floats]],
    found: Estimate,
    k: int,
    reach: float,
    bound: float,
) -> float:
    """Return the end of the interval of an unknown that hardly shows, infinite if nothing limits it up to its bound."""
    sign = float(np.sign(bound - found.z[k]))
    inside, z = float(found.z[k]), found.z
    for _ in range(FAR):
        place = inside + sign * FARTHER
        if sign * (place - bound) >= 0.0:
            return sign * np.inf
        try:
            square, z = profile(k, place, z)
        except (SolveError, InputError):
            return sign * np.inf
        if square - found.square > reach**2:
            break
        inside = place
    else:
        return sign * np.inf
    outside = inside + sign * FARTHER
    for _ in range(6):
        middle = 0.5 * (inside + outside)
        if profile(k, middle, z)[0] - found.square > reach**2:
            outside = middle
        else:
            inside = middle
    return 0.5 * (inside + outside)


def _skewed(
    square: Callable[[Floats], float],
    found: Estimate,
    way: Floats,
    reach: float,
    bounds: tuple[Floats, Floats],
) -> bool:
    z = np.clip(found.z + reach * way, *bounds)
    try:
        rise = square(z) - found.square
    except (SolveError, InputError):
        return True
    return abs(rise / reach**2 - 1.0) > 2.0 * SKEWED


def profile_end(
    profile: Callable[[int, float, Floats], tuple[float, Floats]],
    found: Estimate,
    k: int,
    guess: float,
    reach: float,
    bound: float,
) -> float:
    """Return where the profile of a coordinate has risen by the squared quantile, by secants of its root.

    The root of the rise is nearly linear in the coordinate. Where the profile flattens the end is infinite.
    """
    centre, least, start = float(found.z[k]), found.square, found.z
    far = max(VERY_FAR, 3.0 * abs(guess - centre))
    side = (max(min(bound, centre), centre - far), min(max(bound, centre), centre + far))
    place = np.clip(guess, *side)
    last, height = centre, 0.0
    for _ in range(8):
        try:
            square, start = profile(k, float(place), start)  # from where the last place had the others
            rise = float(np.sqrt(max(square - least, 0.0)))
        except (SolveError, InputError):
            place = 0.5 * (place + last)
            continue
        if abs(rise - reach) < 0.01 * reach:
            break
        if rise < reach and abs(place - centre) > 0.999 * far:  # nothing limits the number on this side
            return float(np.sign(place - centre)) * np.inf
        slope = (rise - height) / (place - last)
        last, height = float(place), rise
        if slope * np.sign(place - centre) <= 0.0:
            place = centre + 2.0 * (place - centre)
        else:
            place = place + (reach - rise) / slope
        place = np.clip(place, *side)
        if place == last:
            break
    return float(place)
