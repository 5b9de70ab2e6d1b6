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
from viscorod.typing import Floats

__all__ = ["reduced_makers", "told_of_modes"]

COMPARED = 4
"""Modes from which on those in half as many tell something: one mode may be that of another direction."""
LEAST = 0.01
"""Part of the larger of section forces and moments that the smaller counts as at least."""


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
    fewer = reduced(settings.modes // 2) if settings.modes >= COMPARED else None

    def main(**given: Any) -> Integrator:
        beside = None if fewer is None else make(fewer, **given)
        return make(model, **given, fewer=beside)

    return main, partial(make, model)


def told_of_modes(settings: SimulateSettings, integrator: ReducedMotion) -> dict[str, Any]:
    """Return the attributes of a result about its modes.

    ``modes_position_gap`` [m] and the like are by how much the motion in half as many modes differed; they are missing
    where that motion could not be followed. Forces that are small beside the moments over the length count as a
    hundredth of these, and the other way round.
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
    if settings.modes is not None and settings.modes >= COMPARED and np.isfinite(integrator.apart).all():
        found["modes_fewer"] = settings.modes // 2
        found["modes_position_gap"], found["modes_rotation_gap"] = integrator.apart.tolist()
        found["modes_motion_gap"] = _part(integrator.apart[:1], integrator.moved[:1])
        lever = np.array([integrator.model.problem.length, 1.0])
        found["modes_force_gap"] = _part(integrator.forces_apart * lever, _beside(integrator.loaded * lever))
    return found


def _beside(sizes: Floats) -> Floats:
    return np.asarray(np.maximum(sizes, LEAST * sizes.max()))


def _part(gaps: Floats, sizes: Floats) -> float:
    """Return the largest of gaps over sizes, 0 where nothing is there."""
    return float((gaps / np.where(sizes > 0.0, sizes, np.inf)).max())
