"""Draws from the posterior of unknowns: Markov chains whose proposals come from the derivatives at the estimate.

The density is that of the least squares with the noise that was found, its common size integrated out (with Jeffreys'
prior), and flat in the coordinates z between their bounds, beside what was believed of single unknowns:
p(z) ~ (1 + (S(z) - S_min)/nu)^-(nu + p)/2, which is the normal density where the noise was told.

The package emcee (D. Foreman-Mackey et al., PASP 125 (2013) 306) runs the chains. Most proposals do not depend on where
a chain is: Student's distribution of few degrees of freedom about the estimate, with the covariance that the exact or
differenced derivatives give there (J. Geweke, Econometrica 57 (1989) 1317). Where the posterior is nearly normal most
of them are accepted, and each costs one evaluation; the others stretch (Goodman and Weare 2010) and find what is far
from normal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from viscorod.errors import Fault, InputError, SolveError
from viscorod.solve.estimation.intervals import CERTAIN, Covariance
from viscorod.solve.estimation.least_squares import Estimate
from viscorod.typing import Floats

__all__ = ["Draws", "drawn"]

HEAVY = 5.0
"""Degrees of freedom of the proposals: heavier tails than the posterior has."""
STRETCHES = 0.25
"""Part of the steps that stretch."""
BURNT = 0.2
"""Part of the steps that are thrown away at the beginning."""
INSTALL = "install it: pip install 'viscorod[posterior]'"


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of the posterior.

    Attributes:
        z: coordinates of the unknowns (chains, draws, p).
        density: logarithm of the density there, up to a constant (chains, draws).
        accepted: part of the proposals that was accepted.
    """

    z: Floats
    density: Floats
    accepted: float


def drawn(
    found: Estimate,
    known: Covariance,
    square: Callable[[Floats], float],
    count: int,
    seed: int = 0,
) -> Draws:
    """Return draws from the posterior of an estimate.

    Args:
        found: the estimate; known: its covariance.
        square: sum of squares of whitened residuals at z.
        count: draws of all chains together, at least.
        seed: of the chains.

    Raises:
        InputError: emcee is not there, or the data do not tell some unknowns, whose posterior has no end.
    """
    if len(known.unseen):
        names = [
            found.unknowns.names[k] for k in range(len(found.z)) if not known.told(np.eye(len(found.z))[k])
        ]
        raise InputError(
            Fault(
                "draws",
                ", ".join(names),
                "the data do not tell them: their posterior has no end",
                "give a belief (Unknown with a deviation), or seek fewer numbers",
            )
        )
    try:
        emcee = import_module("emcee")
    except ImportError:
        raise InputError(Fault("draws", "", "chains are run by the package emcee", INSTALL)) from None
    size = len(found.z)
    chains = 2 * (size + 1)
    least, (low, high) = found.square, found.unknowns.bounds
    freedom = float(known.freedom.min())
    factor = np.linalg.cholesky(known.matrix)

    def density(z: Floats) -> float:
        if not ((z > low) & (z < high)).all():
            return -np.inf
        try:
            rise = square(z) - least
        except (SolveError, InputError):  # there is no solution: nothing like it was measured
            return -np.inf
        if freedom >= CERTAIN:
            return -0.5 * rise
        return float(-0.5 * (freedom + size) * np.log1p(max(rise / freedom, -0.999)))

    def away(z: Floats) -> Floats:
        """Return the logarithm of the density of proposals, up to a constant (k,)."""
        standard = np.linalg.solve(factor, (z - found.z).T)
        return np.asarray(-0.5 * (HEAVY + size) * np.log1p(np.sum(standard**2, axis=0) / HEAVY))

    def proposed(z: Floats, random: Any) -> tuple[Floats, Floats]:
        normal = random.normal(size=z.shape)
        wide = np.sqrt(HEAVY / random.chisquare(HEAVY, size=len(z)))
        new = found.z + wide[:, None] * (normal @ factor.T)
        return new, away(z) - away(new)

    moves = [(emcee.moves.MHMove(proposed), 1.0 - STRETCHES), (emcee.moves.StretchMove(), STRETCHES)]
    sampler = emcee.EnsembleSampler(chains, size, density, moves=moves)
    random = np.random.RandomState(seed)  # what emcee keeps as its state
    start = np.clip(found.z + random.normal(size=(chains, size)) @ factor.T, low + 1e-9, high - 1e-9)
    steps = int(np.ceil(count / chains))
    burnt = max(int(np.ceil(BURNT * steps)), 5)
    state = emcee.State(start, random_state=random.get_state())
    sampler.run_mcmc(state, burnt + steps, skip_initial_state_check=True)
    return Draws(
        np.swapaxes(sampler.get_chain(discard=burnt), 0, 1).copy(),
        sampler.get_log_prob(discard=burnt).T.copy(),
        float(np.mean(sampler.acceptance_fraction)),
    )
