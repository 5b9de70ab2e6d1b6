"""Small damped vibrations about an equilibrium or the reference shape."""

from __future__ import annotations

import json

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium_near, find_initial_equilibrium
from viscorod.analyses.start_state import StartState, require_still
from viscorod.analyses.thin_twist import thin_twist_of_modes
from viscorod.errors import Fault, InputError, SolveError
from viscorod.one_thread import one_blas_thread
from viscorod.results.modes_result import Modes
from viscorod.results.state_arrays import Arranged
from viscorod.solve.constraints.parts import many_parts
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.modes import vibrations
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.start import Start
from viscorod.solve.statics.stability import Stability

__all__ = ["modes"]


TWISTING = 0.1
"""Part of the elastic energy that twist has in modes to which the torsional stiffness matters."""
_WORDS = {
    "equilibrium": "the equilibrium just before t = 0",
    "released": "the equilibrium just after t = 0",
    "reference": "the reference shape, as if free of load",
}


def modes(discrete: DiscreteModel, settings: ModesSettings) -> Modes:
    """Find small vibrations, the slowest or those near a frequency; see ``Model.modes``."""
    discrete.require_independent()
    discrete.announce_modes()
    before, scale, about = True, 1.0, "the equilibrium near an earlier state"
    stability: Stability | None = None
    if isinstance(settings.about, Start):
        start = StartState(discrete, settings.about)
        if start.result.kind == "steady":
            raise InputError(
                Fault(
                    "about",
                    "a steady rotation",
                    "these modes are about what rests",
                    "its own small motions are in Steady.modes; linear and frequency_response go about it",
                )
            )
        require_still(start)
        state, _, stability = equilibrium_near(discrete, settings.about)
        linear = vibrations.linearise(discrete.static, state)
    else:
        state = State.reference(discrete.problem)
        before, loaded = settings.about != "released", settings.about != "reference"
        if loaded:
            search = find_initial_equilibrium(discrete, state, before=before)
            stability = None if search is None else search.stability
        scale, about = float(loaded), _WORDS[settings.about]
        linear = vibrations.linearise(discrete.static, state, before=before, scale=scale)
    try:
        found = vibrations.complex_modes(
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
    discrete.static.restore(state, 0.0, before=before, scale=scale)
    growing = [] if stability is None or not stability.unstable else [_growing(stability.unstable)]
    return _result(discrete, state, found, about, scale, growing)


def _growing(count: int) -> str:
    """Return a warning that small motions grow from an equilibrium: Maxwell branches let some creep, unlisted."""
    return (
        f"the equilibrium is unstable: {'a small motion grows' if count == 1 else f'{count} small motions grow'} from "
        "it, of which those that creep, as a material with relaxation lets them, are not listed; model.equilibrium() "
        "seeks a stable one"
    )


def _result(
    discrete: DiscreteModel,
    state: State,
    found: vibrations.ModesFound,
    about: str,
    scale: float,
    told: list[str],
) -> Modes:
    """Return modes with the state that they are about, whose forces the static solver holds, and what is told."""
    history = History()
    snapshot = Snapshot.of(state, discrete.system, discrete.supports)
    history.record(scale, snapshot, EnergyAccount(elastic=snapshot.elastic), 0.0, 0)
    attributes = {
        "outcome": "completed",
        "mode_rigid": found.rigid,
        "mode_certified": int(found.certified),
        "mode_about": about,
    }

    def shown() -> vibrations.ModesShown:
        with one_blas_thread():
            return found.shown

    points = discrete.system.gauss_positions()
    thin = list(thin_twist_of_modes(discrete.problem, discrete.model.rods, points, snapshot.strain))
    if thin and (shown().shares[:, 5] > TWISTING).any():
        told = told + thin
    if told:
        attributes["warnings"] = json.dumps([*json.loads(discrete.attributes.get("warnings", "[]")), *told])
    states = discrete.arrays(Modes.kind, history, attributes)
    moving = ("small_motion", "part", "station", "axis")

    def parts(values: np.ndarray) -> np.ndarray:
        return np.stack([values.real, values.imag], axis=1)

    more: Arranged = {
        "mode_shape": (moving, lambda: parts(shown().shapes)),
        "mode_rotation": (moving, lambda: parts(shown().rotations)),
        "mode_name": ("small_motion", lambda: np.array(shown().names, dtype=str)),
        "mode_share": (("small_motion", "component"), lambda: shown().shares),
        "mode_residual": ("small_motion", found.residuals),
        "eigenvalue": (("small_motion", "part"), parts(found.eigenvalues)),
    }
    return Modes.later(lambda: states().beside(more, {"part": ("real", "imaginary")}))
