"""Kelvin-Voigt and Maxwell materials nearest to a complex modulus that is known at some frequencies.

Of Kelvin-Voigt materials nearest means the least mean square of |M* - fit|/|M*| over the logarithm of the frequency.
Storage and loss of M + i omega eta then separate: M is the mean of the storage modulus and eta the slope of the loss
modulus over omega, both weighted with 1/|M*|^2, whether M is free or not.

Of Maxwell branches storage and loss count by their own sizes (M. Baumgaertel and H. H. Winter, Rheol. Acta 28, 1989,
511-519). Measured moduli never are exactly those of one causal law, and beside |M*| the loss of a glass, a fiftieth of
it, would be given up for half a per cent of the storage.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.model.fields.definition import RefusedError
from viscorod.model.materials.relaxation_modulus import Complexes, RelaxationModulus
from viscorod.quantity_text import per_cent
from viscorod.typing import Floats

__all__ = [
    "FAR",
    "Viscous",
    "band_of",
    "errors",
    "far_branches",
    "far_from",
    "log_weights",
    "nearest_kelvin_voigt",
    "nearest_maxwell",
]

PER_DECADE = 60
"""Frequencies per decade at which a Prony series is compared."""
FAR = 20.0
"""Errors of moduli beyond which one retardation time is too little, %."""
ASIDE = 10.0
"""Errors of moduli over a decade beyond which Maxwell branches do not follow a table, %."""
RESOLVED = 1e-3
"""Part of the modulus below which a loss is none: a phase of a milliradian is about what instruments resolve."""
ABOUT = 0.5 * math.log(10.0)
"""Half a decade to either side of a frequency, over which means are taken so that the noise of one point is none."""


class Viscous(NamedTuple):
    """A Kelvin-Voigt solid of one strain.

    Attributes:
        modulus: Pa.
        viscosity: Pa s.
    """

    modulus: float
    viscosity: float

    @property
    def time(self) -> float:
        """Retardation time, viscosity over modulus, s."""
        return self.viscosity / self.modulus

    def complex_modulus(self, omega: Floats) -> Complexes:
        """Return storage and loss modulus at angular frequencies [rad/s], Pa."""
        total: Complexes = self.modulus + 1j * self.viscosity * np.asarray(omega, dtype=float)
        return total


def band_of(band: tuple[float, float]) -> Floats:
    """Return angular frequencies [rad/s] over a band [Hz], evenly spaced in their logarithm, ends included."""
    low, high = band
    count = max(2, 1 + math.ceil(PER_DECADE * math.log10(high / low)))
    return 2.0 * math.pi * np.geomspace(low, high, count)


def log_weights(omega: Floats) -> Floats:
    """Return weights of increasing frequencies in a mean over their logarithm (trapezoidal rule), with the sum 1."""
    if len(omega) == 1:
        return np.ones(1)
    steps = np.diff(np.log(omega))
    weights = np.zeros(len(omega))
    weights[:-1] += steps
    weights[1:] += steps
    total: Floats = weights / weights.sum()
    return total


def nearest_kelvin_voigt(omega: Floats, modulus: Complexes) -> Viscous:
    """Return the Kelvin-Voigt solid nearest to a complex modulus.

    Args:
        omega: increasing angular frequencies (n,), rad/s.
        modulus: complex modulus at them (n,), Pa.
    """
    weights = log_weights(omega) / np.abs(modulus) ** 2
    storage = float(np.sum(weights * modulus.real) / np.sum(weights))
    viscosity = float(np.sum(weights * omega * modulus.imag) / np.sum(weights * omega**2))
    return Viscous(storage, viscosity)


def nearest_maxwell(
    omega: Floats, modulus: Complexes, per_decade: int, equilibrium: float | None = None
) -> RelaxationModulus:
    """Return the generalised Maxwell solid nearest to a complex modulus: non-negative least squares over fixed times.

    Storage and loss are each compared beside their mean over a decade; see above. The relaxation times go from the
    inverse of the highest frequency to that of the lowest, half a decade beyond both.

    Args:
        omega: increasing angular frequencies (n,), rad/s.
        modulus: complex modulus at them (n,), Pa.
        per_decade: relaxation times per decade.
        equilibrium: the modulus in equilibrium if it is known, Pa.

    Raises:
        RefusedError: the data do not give a modulus in equilibrium.
    """
    from scipy.optimize import nnls

    margin = math.sqrt(10.0)
    low, high = 1.0 / (margin * float(omega[-1])), margin / float(omega[0])
    times = np.geomspace(low, high, max(2, 1 + round(per_decade * math.log10(high / low))))
    product = omega[:, None] * times
    columns = product / (1.0 + product**2) * (product + 1j)
    target = modulus
    if equilibrium is None:
        columns = np.column_stack([np.ones(len(omega)), columns])
    else:
        target = modulus - equilibrium
    unit = float(np.abs(modulus).max())
    scale = np.sqrt(log_weights(omega)) / _sizes(omega, modulus)
    rows = np.concatenate([scale[0, :, None] * columns.real, scale[1, :, None] * columns.imag]) * unit
    sides = np.concatenate([scale[0] * target.real, scale[1] * target.imag])
    found = nnls(rows, sides)[0] * unit
    if equilibrium is None:
        equilibrium, found = float(found[0]), found[1:]
        if equilibrium <= 1e-9 * unit:
            raise RefusedError(
                "the storage modulus still falls at the lowest frequencies; it does not give a modulus in equilibrium",
                "give youngs_modulus, the modulus after a long time (Pa)",
                found="",
            )
    kept = found > 1e-12 * unit
    return RelaxationModulus(equilibrium, tuple(found[kept].tolist()), tuple(times[kept].tolist()))


def _mean_about(omega: Floats, values: Floats) -> Floats:
    """Return the mean of values (..., n) over half a decade to either side of each frequency (n,)."""
    weights, place = log_weights(omega), np.log(omega)
    first = np.searchsorted(place, place - ABOUT - 1e-9)
    end = np.searchsorted(place, place + ABOUT + 1e-9)
    zero = np.zeros((*np.shape(values)[:-1], 1))
    sums = np.concatenate([zero, np.cumsum(weights * values, axis=-1)], axis=-1)
    whole = np.insert(np.cumsum(weights), 0, 0.0)
    found: Floats = (sums[..., end] - sums[..., first]) / (whole[end] - whole[first])
    return found


def _sizes(omega: Floats, modulus: Complexes) -> Floats:
    """Return the sizes of storage and loss modulus about each frequency (2, n)."""
    of_both = _mean_about(omega, np.stack([modulus.real, modulus.imag]))
    return np.maximum(of_both, RESOLVED * np.abs(modulus))


def errors(modulus: Complexes, fit: Complexes) -> tuple[Floats, Floats]:
    """Return relative errors of the storage and the loss modulus of a fit (n,), (n,).

    That of the loss modulus is over the size of the whole modulus where there is no loss.
    """
    loss = np.where(modulus.imag > 0.0, modulus.imag, np.abs(modulus))
    return fit.real / modulus.real - 1.0, (fit.imag - modulus.imag) / loss


def far_from(data: str, omega: Floats, storage: float, loss: float) -> tuple[str, ...]:
    """Return what a result tells of a Kelvin-Voigt material whose moduli are wrong by more than `FAR`, else nothing.

    Args:
        data: what it was fitted to; omega: where [rad/s]; storage, loss: the largest errors there, %.
    """
    if max(storage, loss) <= FAR:
        return ()
    low, high = (value / (2.0 * math.pi) for value in (omega[0], omega[-1]))
    return (
        f"one Kelvin-Voigt time does not follow {data}: from {low:.4g} to {high:.4g} Hz the storage modulus is wrong "
        f'by {per_cent(storage)} at most and the loss modulus by {per_cent(loss)}; give law = "maxwell", or a '
        "narrower band about the frequencies of the motion",
    )


def far_branches(data: str, omega: Floats, modulus: Complexes, fit: Complexes) -> tuple[str, ...]:
    """Return what a result tells of Maxwell branches whose moduli are wrong by more than `ASIDE` over a decade.

    Args:
        data: what they were fitted to; omega: where [rad/s] (n,); modulus, fit: of the data and of the branches (n,).
    """
    off = np.abs(_mean_about(omega, np.stack([(fit - modulus).real, (fit - modulus).imag])))
    off *= 100.0 / _sizes(omega, modulus)
    if off.max() <= ASIDE:
        return ()
    which, worst = np.unravel_index(int(np.argmax(off)), off.shape)
    return (
        f"no Maxwell branches follow {data}: about {omega[worst] / (2.0 * math.pi):.4g} Hz the "
        f"{('storage', 'loss')[which]} modulus is wrong by {per_cent(float(off[which, worst]))}; storage and loss "
        "contradict each other, or a given youngs_modulus does: give band about the frequencies of the motion, or more "
        "per_decade",
    )
