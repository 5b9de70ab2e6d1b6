"""Stability along a load: modes about the equilibria over the load factor, followed, with flutter and divergence."""

from __future__ import annotations

import json
from functools import partial

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import require_no_initial_strain
from viscorod.analyses.followed import (
    common_attributes,
    common_variables,
    doubts,
    errors_of,
    followed,
    limits_of,
    names_of,
    on_fine_mesh,
    whole,
)
from viscorod.analyses.growing_loads import begin_growing
from viscorod.errors import SolveError
from viscorod.results.stability_result import Stability
from viscorod.solve.settings.stability import StabilitySettings
from viscorod.solve.statics.loaded_equilibria import LoadedEquilibria
from viscorod.solve.statics.newton import interruption
from viscorod.solve.tracking.meetings import meetings

__all__ = ["stability"]


def stability(discrete: DiscreteModel, settings: StabilitySettings) -> Stability:
    """Follow the modes over the load factors on a mesh that is fine enough; see ``Model.stability``."""
    try:
        meshes = on_fine_mesh(
            discrete,
            lambda one: _equilibria(one, settings),
            settings.values[0],
            settings.modes,
            settings.accuracy,
        )
        return _followed(*meshes, settings)
    except KeyboardInterrupt as asked:
        raise SolveError(f"Stopped: {interruption(asked)}") from None


def _equilibria(discrete: DiscreteModel, settings: StabilitySettings) -> LoadedEquilibria:
    """Return the equilibria of a model over its load factor.

    Raises:
        InputError: nothing holds the model, or nothing grows.
    """
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    require_no_initial_strain(discrete)
    state = begin_growing(discrete, settings.constant, "no loads whose factor could grow")
    return LoadedEquilibria(discrete.static, state)


def _followed(discrete: DiscreteModel, finer: DiscreteModel | None, settings: StabilitySettings) -> Stability:
    """Follow the modes; ``finer`` is the same model with elements halved, for the error of the mesh."""
    import xarray as xr

    family = _equilibria(discrete, settings)
    tracker, factors = followed(discrete, family, settings.modes, settings.values)
    found = limits_of(discrete, tracker)
    met, samples = meetings(tracker.samples, family.mass), tracker.at(factors)
    better = None if finer is None else partial(_equilibria, finer, settings)
    errors = errors_of(discrete, better, tracker, samples, found)
    names = names_of(discrete, family.state(factors[0]), samples[0])
    variables, coordinates = common_variables("load_factor", samples, names, found, met, errors)
    notes = doubts("load_factor", samples, names, errors, tracker)
    constant = json.dumps(list(settings.constant))
    attrs = common_attributes(discrete, Stability.kind, tracker, family.iterations, notes, constant=constant)
    result = Stability(xr.Dataset(variables, coordinates | {"load_factor": np.array(factors)}, attrs))
    return whole(result, tracker)
