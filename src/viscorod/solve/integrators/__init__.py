"""Time integrators by name. A new one implements ``Integrator`` and adds a line here."""

from __future__ import annotations

from viscorod.solve.integrators.contract import Integrator
from viscorod.solve.integrators.generalized_alpha import GeneralizedAlpha

INTEGRATORS = {"generalized_alpha": GeneralizedAlpha}

__all__ = ["INTEGRATORS", "GeneralizedAlpha", "Integrator"]
