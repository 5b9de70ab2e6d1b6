"""Time integrators by name. A new one implements ``Integrator`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable

from viscorod.solve.transient.integrators.contract import Integrator
from viscorod.solve.transient.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.transient.integrators.linear_motion import linear_midpoint, linear_radau
from viscorod.solve.transient.integrators.midpoint import Midpoint
from viscorod.solve.transient.integrators.radau import Radau

INTEGRATORS: dict[str, Callable[..., Integrator]] = {
    "radau": Radau,
    "generalized_alpha": GeneralizedAlpha,
    "midpoint": Midpoint,
}

LINEAR_INTEGRATORS: dict[str, Callable[..., Integrator]] = {
    "radau": linear_radau,
    "midpoint": linear_midpoint,
}
"""Those of linear dynamics."""

__all__ = ["INTEGRATORS", "LINEAR_INTEGRATORS", "GeneralizedAlpha", "Integrator", "Midpoint", "Radau"]
