"""Settings of one of the analyses that a case file may ask for."""

from __future__ import annotations

from typing import TypeAlias

from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.stability import StabilitySettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings

__all__ = ["AnySettings"]


AnySettings: TypeAlias = (
    SimulateSettings
    | EquilibriumSettings
    | PathSettings
    | SteadySettings
    | ModesSettings
    | ResponseSettings
    | BucklingSettings
    | CampbellSettings
    | StabilitySettings
    | PeriodicSettings
)
"""Settings of one of the analyses."""
