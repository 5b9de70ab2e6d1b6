"""The tables of a case file that ask for an analysis, and the settings of each."""

from __future__ import annotations

from viscorod.solve.settings.analysis import AnySettings
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.stability import StabilitySettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings

__all__ = ["ANALYSES", "analyses_in_words"]

ANALYSES: dict[str, type[AnySettings]] = {
    "simulate": SimulateSettings,
    "equilibrium": EquilibriumSettings,
    "path": PathSettings,
    "steady": SteadySettings,
    "modes": ModesSettings,
    "response": ResponseSettings,
    "buckling": BucklingSettings,
    "campbell": CampbellSettings,
    "stability": StabilitySettings,
    "periodic": PeriodicSettings,
}
"""The analyses by their table in a case file; exactly one of them stands in a file."""


def analyses_in_words() -> str:
    """Return the tables of all analyses, with what stands in them at least."""
    known = ((word, settings.needs) for word, settings in ANALYSES.items())
    *some, last = [f"[{word}] with {needs}" if needs else f"[{word}]" for word, needs in known]
    return f"{'; '.join(some)}; or {last}"
