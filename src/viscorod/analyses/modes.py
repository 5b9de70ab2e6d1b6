"""Small damped vibrations about an equilibrium or the reference shape."""

from __future__ import annotations

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near, find_initial_equilibrium
from viscorod.errors import SolveError
from viscorod.solve.constraints.rigid_motions import many_parts
from viscorod.solve.formulations.system import State
from viscorod.solve.modes import vibrations
from viscorod.solve.modes.vibrations import Modes
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.start import Start

__all__ = ["modes"]


def modes(discrete: DiscreteModel, settings: ModesSettings) -> Modes:
    """Find small vibrations, the slowest or those near a frequency; see ``Model.modes``."""
    discrete.require_independent()
    discrete.announce_modes()
    if isinstance(settings.about, Start):
        state, _ = equilibrium_near(discrete, settings.about)
        linear = vibrations.linearise(discrete.static, state)
    else:
        state = State.reference(discrete.problem)
        before, loaded = settings.about != "released", settings.about != "reference"
        if loaded:
            find_initial_equilibrium(discrete, state, before=before)
        linear = vibrations.linearise(discrete.static, state, before=before, scale=1.0 if loaded else 0.0)
    try:
        return vibrations.complex_modes(
            discrete.static,
            state,
            linear,
            settings.count,
            near=settings.near,
            oscillating=settings.oscillating,
        )
    except SolveError:
        joined = many_parts(discrete.problem)
        if not joined:
            raise
        raise SolveError(
            f"Small vibrations cannot be computed: joints or springs join {joined} parts, and motions of some of them "
            "meet no stiffness, as the twist of a rod between ball joints does; with so many parts these are not found "
            "one by one. Hold them (joints of kind universal or revolute, springs), or look at the equilibrium that "
            "loads keep (about = 'equilibrium')"
        ) from None
