"""Time integrators by name. A new one implements ``Integrator`` and adds a line here."""

from __future__ import annotations

from collections.abc import Callable

from viscorod.solve.integrators.contract import Integrator
from viscorod.solve.integrators.generalized_alpha import GeneralizedAlpha
from viscorod.solve.integrators.midpoint import Midpoint
from viscorod.solve.integrators.radau import Radau

INTEGRATORS: dict[str, Callable[..., Integrator]] = {
    "radau": Radau,
    "generalized_alpha": GeneralizedAlpha,
    "midpoint": Midpoint,
}

__all__ = ["INTEGRATORS", "GeneralizedAlpha", "Integrator", "Midpoint", "Radau"]
