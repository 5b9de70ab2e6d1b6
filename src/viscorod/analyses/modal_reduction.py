"""Motions in modes: the reduced model of a motion, and what a result tells of it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.reduced.reduced_model import ReducedModel
from viscorod.solve.reduced.reduced_motion import ReducedMotion
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.transient.integrators import INTEGRATORS
from viscorod.solve.transient.integrators.contract import Integrator

__all__ = ["reduced_makers", "told_of_modes"]


def reduced_makers(
    discrete: DiscreteModel, settings: SimulateSettings, state: State
) -> tuple[Callable[..., Integrator], Callable[..., Integrator]]:
    """Return what makes the integrator of a motion in modes, and its twin that computes steps again.

    With the former goes the same motion in half as many modes.
    """
    assert settings.modes is not None
    linear = linearise(discrete.static, State.reference(discrete.problem), scale=0.0)
    undamped = undamped_modes(linear, settings.modes)
    linearised = settings.damping == "linearised"

    def reduced(count: int) -> ReducedModel:
        return ReducedModel.of(
            discrete.system, discrete.supports, undamped, state, count, linearised=linearised
        )

    make, model = INTEGRATORS[settings.integrator].make_reduced, reduced(settings.modes)
    assert make is not None
    fewer = reduced(settings.modes // 2) if settings.modes > 1 else None

    def main(**given: Any) -> Integrator:
        return make(model, **given, fewer=None if fewer is None else make(fewer, **given))

    return main, partial(make, model)


def told_of_modes(settings: SimulateSettings, integrator: ReducedMotion) -> dict[str, Any]:
    """Return the attributes of a result about its modes.

    ``modes_motion_gap`` is by how much the motion in half as many modes was elsewhere, over the largest displacement
    or rotation; None where that motion could not be followed.
    """
    basis = integrator.model.basis
    found: dict[str, Any] = {
        "modes": int(basis.modes),
        "modes_velocities": basis.velocity.shape[1],
        "modes_strains": len(basis.strain),
        "modes_rigid": basis.rigid,
        "modes_highest": float(basis.omega[basis.rigid + basis.modes - 1] / (2.0 * np.pi)),
        "modes_open": integrator.open,
    }
    if settings.modes is not None and settings.modes > 1 and np.isfinite(integrator.apart).all():
        found["modes_fewer"] = settings.modes // 2
        moved = np.where(integrator.moved > 0.0, integrator.moved, np.inf)
        found["modes_position_gap"], found["modes_rotation_gap"] = integrator.apart.tolist()
        found["modes_motion_gap"] = float((integrator.apart / moved)[0])
    return found
