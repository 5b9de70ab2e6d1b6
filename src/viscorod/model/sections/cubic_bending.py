"""A rod that stiffens as it is bent, with a loss of its own."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import NonNegative, Positive
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.typing import Floats

__all__ = ["CubicBending"]


class CubicBending(AnySectionLaw):
    """Bending that stiffens with the square of the curvature: M = EI kappa (1 + cubic kappa^2) about each axis.

    With q = sqrt(EI_1) kappa_1^2 + sqrt(EI_2) kappa_2^2 it stores W = cubic q^2/4 beside the energy of the section's
    stiffness, so that a round section is equally stiff in every direction. Its moments M_c = dW/dkappa come with
    viscous ones, time dM_c/dt (Kelvin and Voigt), which dissipate time kappa_t . (d2W/dkappa2) kappa_t >= 0.
    """

    kind: Literal["cubic_bending"] = Field(default="cubic_bending", kw_only=True, repr=False)
    cubic: Positive = Key("square of the length at whose curvature 1/length the stiffness is doubled", "m^2")
    time: NonNegative = Key("retardation time of the cubic moments", "s", default=0.0)

    def parameters(self, stiffness: Floats) -> Floats:
        """Return sqrt(EI_1), sqrt(EI_2) (N^(1/2) m), `cubic` and `time`."""
        return np.array([*np.sqrt(np.diag(stiffness)[3:5]), self.cubic, self.time])

    @staticmethod
    def respond(
        parameters: Floats, strain: Floats, rate: Floats, force: Floats, by_strain: Floats, by_rate: Floats
    ) -> tuple[float, float]:
        """Evaluate moments, tangents, energy and loss; see `AnySectionLaw.respond`."""
        cubic, time = parameters[2], parameters[3]
        q = p = 0.0  # p = q_t/2
        for i in range(2):
            q += parameters[i] * strain[3 + i] ** 2
            p += parameters[i] * strain[3 + i] * rate[3 + i]
        power = 0.0
        for i in range(2):
            a, k, k_t = parameters[i], strain[3 + i], rate[3 + i]
            resisting = time * cubic * a * (q * k_t + 2.0 * p * k)
            force[3 + i] = cubic * q * a * k + resisting
            power += resisting * k_t
            by_strain[3 + i, 3 + i] += cubic * a * (q + 2.0 * time * p)
            by_rate[3 + i, 3 + i] += time * cubic * a * q
            for j in range(2):
                b, other, other_t = parameters[j], strain[3 + j], rate[3 + j]
                by_strain[3 + i, 3 + j] += (
                    2.0 * cubic * a * b * (k * other + time * (k_t * other + k * other_t))
                )
                by_rate[3 + i, 3 + j] += 2.0 * time * cubic * a * b * k * other
        return 0.25 * cubic * q * q, power
