"""Small damped vibrations about an equilibrium or the reference shape."""

from __future__ import annotations

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near, find_initial_equilibrium
from viscorod.solve.formulations.system import State
from viscorod.solve.modes import vibrations
from viscorod.solve.modes.vibrations import Modes
from viscorod.solve.settings import ModesSettings
from viscorod.solve.start import Start

__all__ = ["modes"]


def modes(discrete: DiscreteModel, settings: ModesSettings) -> Modes:
    """Find small vibrations, the slowest or those near a frequency; see ``Model.modes``."""
    discrete.require_independent()
    if isinstance(settings.about, Start):
        state, _ = equilibrium_near(discrete, settings.about)
        linear = vibrations.linearise(discrete.static, state)
    else:
        state = State.reference(discrete.problem)
        before, loaded = settings.about != "released", settings.about != "reference"
        if loaded:
            find_initial_equilibrium(discrete, state, before=before)
        linear = vibrations.linearise(discrete.static, state, before=before, scale=1.0 if loaded else 0.0)
    return vibrations.complex_modes(
        discrete.static,
        state,
        linear,
        settings.count,
        near=settings.near,
        oscillating=settings.oscillating,
    )
