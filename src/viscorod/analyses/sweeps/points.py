"""Points of an ensemble: values of uncertain numbers, from Sobol' sequences and their distributions.

Sources: A. B. Owen, "On dropping the first Sobol' point", MCQMC 2020 (scrambled sequences of 2^m points, as in
``scipy.stats.qmc``); A. Saltelli et al., "Variance based sensitivity analysis of model output", Comput. Phys. Commun.
181 (2010) 259-270 (the rows A, B and AB).
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show

if TYPE_CHECKING:
    from viscorod.typing import Floats

__all__ = ["MOST_POINTS", "distribution_text", "points_of", "require_distributions", "uniform_points"]

MOST_POINTS = 1 << 24
MOST_TOLD = 6
"""Values of a distribution of single ones that are told."""
_EDGE = 1e-15  # how near to 0 and 1 a point may come, where unbounded distributions have no value
_ADVICE = "give a frozen distribution of SciPy, such as scipy.stats.norm(1.0e6, 5.0e4)"


def require_distributions(distributions: Any) -> None:
    """Refuse what are no distributions of numbers.

    Raises:
        InputError: the first that is none.
    """
    if not isinstance(distributions, Mapping) or not distributions:
        why = "keys of the case file with their distributions are needed here"
        raise InputError(Fault("distributions", show(distributions), why, _ADVICE))
    for key, found in distributions.items():
        quantiles = _quantiles_of(found)
        if not isinstance(key, str) or quantiles is None:
            raise InputError(Fault(str(key), show(found), "this is no distribution", _ADVICE))
        if _without_parameters(found):
            why = "this is a kind of distribution; its parameters are not given"
            raise InputError(Fault(key, f"scipy.stats.{found.name}", why, _ADVICE))
        with np.errstate(all="ignore"), warnings.catch_warnings():  # what comes of it is looked at
            warnings.simplefilter("ignore", RuntimeWarning)
            middle = np.asarray(quantiles(np.array([1e-6, 0.5, 1.0 - 1e-6])), dtype=float)
        if _still(found):
            why = "a deviation of 0 leaves one value"
            raise InputError(Fault(key, distribution_text(found), why, "give it in constants, or vary it"))
        if middle.shape != (3,) or not np.isfinite(middle).all():
            why = "its parameters give no numbers, or several"
            advice = "give single numbers, the deviation above 0"
            raise InputError(Fault(key, distribution_text(found), why, advice))


def _without_parameters(distribution: Any) -> bool:
    """Return whether it is one of SciPy's that was not frozen: scipy.stats.norm would be normal about 0."""
    import scipy.stats as st

    return getattr(st, str(getattr(distribution, "name", "")), None) is distribution


def uniform_points(n: int, columns: int, seed: int) -> Floats:
    """Return ``n`` points of a scrambled Sobol' sequence ``(n, columns)``; the first ones are those of a smaller ``n``.

    Raises:
        InputError: ``n`` is no power of two, or the seed is no whole number.
    """
    from scipy.stats import qmc

    if isinstance(n, bool) or not isinstance(n, int | np.integer) or not 2 <= n <= MOST_POINTS or n & (n - 1):
        near = 1 << max(1, min(24, round(float(np.log2(n))))) if isinstance(n, int | float) and n > 0 else 128
        why = "Sobol' points are balanced in powers of two only"
        raise InputError(Fault("n", show(n), why, f"give {near}"))
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InputError(Fault("seed", show(seed), "a whole number from 0 on is needed here", "give 1"))
    found: Floats = qmc.Sobol(columns, scramble=True, seed=int(seed)).random_base2(int(n).bit_length() - 1)
    return np.clip(found, _EDGE, 1.0 - _EDGE)


def points_of(
    uniform: Floats, distributions: Mapping[str, Any], correlation: Any = None
) -> dict[str, Floats]:
    """Return values of every key ``(points,)`` from uniform points ``(points, keys)``, whole ones if these are counts.

    Args:
        uniform: in the unit cube.
        distributions: key -> frozen distribution.
        correlation: of the normal numbers that a Gaussian copula makes the distributions of ``(keys, keys)``.

    Raises:
        InputError: it is no matrix of correlations.
    """
    from scipy.special import ndtr, ndtri

    if correlation is not None:
        uniform = np.clip(
            ndtr(ndtri(uniform) @ _factor(correlation, len(distributions)).T), _EDGE, 1.0 - _EDGE
        )
    return {
        key: _values(found, column)
        for (key, found), column in zip(distributions.items(), uniform.T, strict=True)
    }


def _values(distribution: Any, uniform: Floats) -> np.ndarray:
    """Return the values at uniform numbers, as whole ones where a distribution has no others."""
    quantiles = _quantiles_of(distribution)
    assert quantiles is not None
    found = np.asarray(quantiles(uniform), dtype=float)
    counts = found.astype(int)
    return counts if _discrete(distribution) and (counts == found).all() else found


def _quantiles_of(distribution: Any) -> Callable[[Floats], Any] | None:
    """Return the quantile function of a distribution, which SciPy's newer ones call by another name."""
    found = getattr(distribution, "ppf", None) or getattr(distribution, "icdf", None)
    return found if callable(found) else None


def _discrete(distribution: Any) -> bool:
    """Return whether a distribution has single values only."""
    if hasattr(
        distribution, "icdf"
    ):  # of these, continuous ones have a probability of values too, which is 0
        return any(kind.__name__ == "DiscreteDistribution" for kind in type(distribution).__mro__)
    return hasattr(getattr(distribution, "dist", distribution), "pmf")


def _still(distribution: Any) -> bool:
    """Return whether it is one of SciPy's whose scale is 0, which has no values."""
    kind, given = getattr(distribution, "dist", None), getattr(distribution, "args", ())
    shapes = getattr(kind, "numargs", len(given))
    scale = getattr(distribution, "kwds", {}).get(
        "scale", given[shapes + 1] if len(given) > shapes + 1 else 1.0
    )
    return kind is not None and not _discrete(distribution) and np.ndim(scale) == 0 and scale == 0.0


def _factor(correlation: Any, size: int) -> Floats:
    advice = "give a symmetric matrix with ones on its diagonal, in the order of the distributions"
    try:
        matrix = np.asarray(correlation, dtype=float)
    except (TypeError, ValueError):
        matrix = np.zeros(0)
    fits = matrix.shape == (size, size) and np.isfinite(matrix).all()
    if not fits or not np.allclose(matrix, matrix.T) or not np.allclose(np.diag(matrix), 1.0):
        why = f"no matrix of the correlations of {size} numbers"
        raise InputError(Fault("correlation", show(correlation), why, advice))
    try:
        factor: Floats = np.linalg.cholesky(matrix)
    except np.linalg.LinAlgError:  # numbers that are one in others have a semidefinite matrix
        sizes, axes = np.linalg.eigh(matrix)
        if float(sizes.min()) < -1e-9:
            why = "no numbers are correlated like this: it is not positive definite"
            raise InputError(Fault("correlation", "", why, advice)) from None
        factor = axes * np.sqrt(np.maximum(sizes, 0.0))
    return factor


def distribution_text(distribution: Any) -> str:
    """Return a distribution in words, as SciPy calls it."""
    if hasattr(distribution, "xk") and hasattr(distribution, "pk"):
        pairs = list(zip(np.ravel(distribution.xk), np.ravel(distribution.pk), strict=False))
        told = [f"{value:g}: {part:g}" for value, part in pairs[:MOST_TOLD]]
        return f"one of {', '.join(told)}" + (", ..." if len(pairs) > MOST_TOLD else "")
    if type(distribution).__name__ == "rv_histogram":  # such as the draws of a fit
        low, high = (float(distribution.ppf(end)) for end in (0.0, 1.0))
        return f"histogram from {low:.6g} to {high:.6g}"
    if hasattr(distribution, "icdf"):
        return re.sub(r"np\.\w+\(([^()]*)\)", lambda found: f"{float(found[1]):g}", repr(distribution))
    name = getattr(getattr(distribution, "dist", None), "name", type(distribution).__name__)
    given = [f"{value:g}" for value in getattr(distribution, "args", ()) if np.ndim(value) == 0]
    more = getattr(distribution, "kwds", {})
    given += [f"{key}={value:g}" for key, value in more.items() if np.ndim(value) == 0]
    return f"{name}({', '.join(given)})"
