"""Find where a damping law creates energy: products of six times with a stiffness that has couplings.

Several programs multiply the section stiffness S by a diagonal of six times mu, as mu S or S mu. The power that
such a law takes from the motion is ``eps_t . sym(mu S) eps_t`` for either order, since one is the transpose of
the other. With a coupling c between two strains of different times it can be negative: the 2x2 block of
sym(mu S) is indefinite when ``|c| > 2 sqrt(mu_i mu_j)/(mu_i + mu_j) sqrt(S_ii S_jj)``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from viscorod.argument_names import known_arguments, telling
from viscorod.checks import checked_with, matrix
from viscorod.model.sections.stiffness_section import STRAINS
from viscorod.programs.matrices import by_sizes, symmetric_part
from viscorod.programs.times import six_times
from viscorod.typing import Floats

__all__ = ["CouplingLimit", "EnergyCheck", "check_product", "creates_energy", "least_power"]

ROUND_OFF = 1e-12
"""Relative size below which an eigenvalue of a matrix scaled to a unit diagonal counts as zero."""


@known_arguments
@dataclass(frozen=True)
class CouplingLimit:
    """One coupling of a section stiffness, as a correlation S_ij/sqrt(S_ii S_jj) between -1 and 1.

    Attributes:
        strains: the two strains, in words.
        correlation: of the given stiffness.
        limit: smallest size of the correlation at which this pair alone creates energy, 2 sqrt(mu_i mu_j)/(mu_i
            + mu_j); 1 for equal times.
    """

    strains: tuple[str, str]
    correlation: float
    limit: float


@known_arguments
@dataclass(frozen=True)
class EnergyCheck:
    """The effect on energy of the product of six times with a stiffness.

    Attributes:
        couplings: of the stiffness, the one nearest to (or farthest beyond) its limit first.
        factor: the smallest factor on all couplings together at which energy is created; inf if there is none,
            less than 1 if the given stiffness is beyond it already.
        strain_rate: the strain rate (6,) that is fed with energy first, its largest scaled entry one; zeros if none.
    """

    couplings: tuple[CouplingLimit, ...]
    factor: float
    strain_rate: Floats

    @property
    def creates_energy(self) -> bool:
        """Whether the given stiffness and times create energy in some motion."""
        return self.factor < 1.0 - ROUND_OFF

    def text(self) -> str:
        """Return a sentence: whether, where and from which coupling on energy is created."""
        if not np.isfinite(self.factor):
            return "the product of the times with the stiffness never creates energy here"
        first = self.couplings[0]
        start = (
            "the product of these times with this stiffness creates energy in some motions:"
            if self.creates_energy
            else "the product of these times with a stiffness can create energy, but not with this one:"
        )
        return (
            f"{start} the coupling of {first.strains[0]} and {first.strains[1]} is {abs(first.correlation):.4g} of "
            f"sqrt(S_ii S_jj), and this pair alone creates energy above {first.limit:.4g}; all couplings together do "
            f"above {self.factor:.4g} times the given ones"
        )


@checked_with(stiffness=matrix)
def check_product(stiffness: Floats, times: Sequence[float] | Floats) -> EnergyCheck:
    """Check the law mu S (or S mu) of a positive definite stiffness (6, 6) and six times (6,), s.

    The smallest factor is exact: with the diagonal part A of sym(mu S) and the rest B, A + f B stops being
    positive semi-definite at f = -1/(lowest eigenvalue of A^(-1/2) B A^(-1/2)).
    """
    mu = six_times(times)
    correlation = by_sizes(stiffness, np.diag(stiffness))
    couplings = []
    for i, j in combinations(range(6), 2):
        if correlation[i, j] != 0.0:
            total = mu[i] + mu[j]
            limit = 2.0 * np.sqrt(mu[i] * mu[j]) / total if total > 0.0 else 1.0
            couplings.append(
                CouplingLimit((STRAINS[i], STRAINS[j]), float(correlation[i, j]), min(float(limit), 1.0))
            )
    couplings.sort(key=lambda c: c.limit / abs(c.correlation))
    factor, direction = _smallest_factor(correlation, mu)
    return EnergyCheck(tuple(couplings), factor, direction / np.sqrt(np.diag(stiffness)))


def _smallest_factor(correlation: Floats, mu: Floats) -> tuple[float, Floats]:
    """Return the factor on the couplings at which energy is created, and the strain rate scaled by the sizes."""
    mean = (mu[:, None] + mu[None, :]) / 2.0
    couplings = mean * correlation
    np.fill_diagonal(couplings, 0.0)
    active = mu > 0.0
    undamped = np.argwhere(couplings[~active] != 0.0)
    if undamped.size:  # a strain without damping that is coupled to one with: any coupling is too much
        direction = np.zeros(6)
        i = int(np.flatnonzero(~active)[undamped[0][0]])
        j = int(undamped[0][1])
        direction[i], direction[j] = 1.0, -correlation[i, j] / 2.0
        return 0.0, direction
    if not active.any():
        return np.inf, np.zeros(6)
    values, vectors = np.linalg.eigh(by_sizes(couplings[np.ix_(active, active)], mu[active]))
    # equal times: the factor at which the stiffness itself stops being definite, not a fault of the product
    own = np.linalg.eigvalsh(np.where(np.eye(6, dtype=bool), 0.0, correlation)[np.ix_(active, active)])[0]
    if values[0] >= own - ROUND_OFF:
        return np.inf, np.zeros(6)
    direction = np.zeros(6)
    direction[active] = vectors[:, 0] / np.sqrt(mu[active])
    return float(-1.0 / values[0]), direction / np.abs(direction).max()


@checked_with(law=matrix, stiffness=matrix)
def least_power(law: Floats, stiffness: Floats) -> float:
    """Return the least power that a damping law (6, 6) takes, per unit of the scaled strain rate and of its largest.

    Strain rates are scaled by sqrt(C_ii); the result is in parts of the largest eigenvalue in size, so it lies
    between -1 and 1 and is negative where the law creates energy. 0 for a law without damping.
    """
    values = np.linalg.eigvalsh(by_sizes(symmetric_part(law), np.diag(stiffness)))
    largest = float(np.abs(values).max())
    return float(values[0]) / largest if largest > 0.0 else 0.0


@telling
def creates_energy(law: Floats, stiffness: Floats) -> bool:
    """Return whether a damping law S_visc = P eps_t, P (6, 6) of any symmetry, creates energy in some motion."""
    return least_power(law, stiffness) < -ROUND_OFF
