"""Convert section matrices to times and back: six times, the symmetric damping matrix, the times of a material.

The order of strains is (shear_1, shear_2, stretch, bend_1, bend_2, twist).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from viscorod.argument_names import known_arguments, telling
from viscorod.checks import checked_with, matrix, number, numbers
from viscorod.errors import Fault, InputError
from viscorod.model.sections.stiffness_section import STRAINS
from viscorod.typing import Floats

__all__ = ["MaterialFit", "component_times", "fit_material", "six_times", "symmetric_damping"]

IN_SHEAR = np.array([True, True, False, False, False, True])
"""Strains whose time is tau_S in a section of one isotropic material; the others have tau_E (LLT 4)."""


def six_times(values: Sequence[float] | Floats, name: str = "times") -> Floats:
    """Return six finite, non-negative numbers as an array (6,).

    Raises:
        InputError: there are not six, or one is negative or not finite; the message names its strain.
    """
    array = np.asarray(numbers(name, values), dtype=np.float64)
    if array.shape != (6,):
        raise InputError(
            Fault(name, f"{array.size} numbers", "six are needed", f"give one each for {', '.join(STRAINS)}")
        )
    wrong = np.flatnonzero(~(np.isfinite(array) & (array >= 0.0)))
    if wrong.size:
        raise InputError(
            Fault(
                f"{name}[{wrong[0]}]",
                f"{array[wrong[0]]:g}",
                "a retardation time must not be negative",
                "give a number >= 0, s",
            )
        )
    return array


def _places(left_out: Sequence[int]) -> list[int]:
    """Return numbers of strains, each from 0 to 5."""
    found = np.atleast_1d(np.asarray(numbers("left_out", left_out), dtype=np.float64))
    for place in found.tolist():
        if place not in range(6):
            raise InputError(
                Fault("left_out", f"{place:g}", "no strain has this number", "give whole numbers from 0 to 5")
            )
    return [int(place) for place in found]


@checked_with(stiffness=matrix, damping=matrix)
def component_times(stiffness: Floats, damping: Floats) -> Floats:
    """Return six times tau_i = D_ii/C_ii (6,), s, of two section matrices (6, 6)."""
    return np.asarray(np.diag(damping) / np.diag(stiffness))


@checked_with(stiffness=matrix)
def symmetric_damping(stiffness: Floats, times: Sequence[float] | Floats) -> Floats:
    """Return D = T C T with T = diag(sqrt(tau_i)), (6, 6), which is symmetric and never creates energy.

    It is the product tau C where C has no couplings or the coupled strains have the same time. A congruence
    keeps the signs of the eigenvalues (Sylvester), so D is positive semi-definite like C.
    """
    root = np.sqrt(six_times(times))
    return np.asarray(root[:, None] * stiffness * root[None, :])


@known_arguments
@dataclass(frozen=True)
class MaterialFit:
    """The two times of an isotropic material that come closest to six given ones.

    Attributes:
        shear_time: tau_S, s.
        bulk_time: tau_B, s; equal to the shear time where it has no effect (nu = 0.5).
        extensional_time: tau_E of the two, s.
        times: the six given times, s, (6,).
        deviations: fitted over given time, less one, (6,); 0 where both are zero, inf where only the given is.
    """

    shear_time: float
    bulk_time: float
    extensional_time: float
    times: Floats
    deviations: Floats

    @property
    def largest_deviation(self) -> float:
        """Largest of the deviations in size."""
        return float(np.abs(self.deviations).max())


@telling
def fit_material(
    times: Sequence[float] | Floats, poissons_ratio: float, *, left_out: Sequence[int] = ()
) -> MaterialFit:
    """Fit (tau_S, tau_B), not negative, to six times (6,), s, for a given Poisson's ratio.

    Least squares of the relative deviations, with tau_S for shear and twist and
    tau_E = [(1-2 nu) tau_B + 2 (1+nu) tau_S]/3 for stretch and bending (LLT 4). The times at the places
    `left_out` do not count, and have the deviation 0.

    Raises:
        InputError: Poisson's ratio is outside (-1, 0.5], or the times are not six numbers >= 0.
    """
    given = six_times(times)
    nu = number("poissons_ratio", poissons_ratio)
    apart = _places(left_out)
    if not -1.0 < nu <= 0.5:
        raise InputError(
            Fault("poissons_ratio", f"{nu:g}", "outside what is allowed", "give a number > -1 and <= 0.5")
        )
    largest = float(given.max())
    if largest == 0.0:
        return MaterialFit(0.0, 0.0, 0.0, given, np.zeros(6))
    extension = np.array([2.0 * (1.0 + nu) / 3.0, (1.0 - 2.0 * nu) / 3.0])
    model = np.where(IN_SHEAR[:, None], np.array([1.0, 0.0]), extension)
    weight = 1.0 / np.where(given > 0.0, given, largest)
    weight[apart] = 0.0
    # the times in parts of the largest, so that the solver sees numbers of size one
    found, _ = nnls(model * weight[:, None] * largest, given * weight)
    shear, bulk = (largest * found).tolist()
    if nu == 0.5:
        bulk = shear
    fitted = model @ np.array([shear, bulk])
    with np.errstate(divide="ignore", invalid="ignore"):
        deviations = np.where(given > 0.0, fitted / given - 1.0, np.where(fitted > 0.0, np.inf, 0.0))
    deviations[apart] = 0.0
    return MaterialFit(shear, bulk, float(extension @ [shear, bulk]), given, deviations)
