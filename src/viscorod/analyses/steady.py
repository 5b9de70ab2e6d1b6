"""The analysis of steady rotations: from a model and settings to a result."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import require_no_initial_strain
from viscorod.analyses.start_state import StartState
from viscorod.errors import SolveError
from viscorod.results.state_arrays import Arranged, StateArrays
from viscorod.results.steady_result import Steady
from viscorod.shown import counted
from viscorod.solve.energy_account import EnergyAccount
from viscorod.solve.formulations.system import State
from viscorod.solve.history import History, Snapshot
from viscorod.solve.modes.damped import REAL
from viscorod.solve.modes.linearisation import nodal_motions, rigid_parts
from viscorod.solve.modes.mode_names import StrainEnergies, numbered
from viscorod.solve.modes.vibrations import station_shapes
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.statics.newton import interruption
from viscorod.solve.steady.rotation_search import Search
from viscorod.solve.steady.stability import FAR, SLOW, Stability
from viscorod.solve.steady.steady_checks import beside_the_axis, require_steady
from viscorod.solve.steady.steady_rotation import SteadyRotation

__all__ = ["steady_rotation"]


def steady_rotation(discrete: DiscreteModel, settings: SteadySettings, first: State | None = None) -> Steady:
    """Find a steady rotation, from a ``first`` state if that is known; see ``Model.steady``."""
    discrete.static.stop = discrete.options.stop
    discrete.require_independent()
    require_no_initial_strain(discrete)
    problem, start = discrete.problem, settings.start
    require_steady(discrete.model, problem, settings)
    if first is None and start is not None:
        first = StartState(discrete, start).state
    search = Search(discrete.static, settings, first)
    try:
        found = search.run()
    except KeyboardInterrupt as asked:
        text = f"Stopped after {search.effort.iterations} iterations: {interruption(asked)}"
        raise SolveError(text) from None
    return Steady.later(_arrays(discrete, settings, found))


def _doubts(stability: Stability) -> list[str]:
    """Return what is doubtful about a rotation and its small motions."""
    doubts = []
    if stability.unstable:
        grow = (
            f"{counted(stability.unstable, 'small motion')} {'grows' if stability.unstable == 1 else 'grow'}"
        )
        doubts.append(
            f"the rotation is unstable: {grow}, at up to {stability.growth:.3g} 1/s, so that it does not last; look "
            "for another one from a different state (start), or let simulate show where it goes"
        )
    if not stability.complete:
        doubts.append("it is not proved that none is missing among the small motions that are listed")
    if not stability.certified:
        doubts.append(
            f"small motions that grow were sought up to {FAR:g} times the angular speed, and it is not proved that all "
            "of them were found: under loads that have no potential faster ones may grow"
        )
    return doubts


def _arrays(
    discrete: DiscreteModel, settings: SteadySettings, found: SteadyRotation
) -> Callable[[], StateArrays]:
    """Return what makes one state along the dimension ``spin``, with what is special to a rotation."""
    history = History()
    snapshot = Snapshot(
        found.state,
        found.strain,
        np.zeros_like(found.strain),
        found.section_force,
        found.reaction,
        found.kinetic,
        found.elastic,
        found.joints,
    )
    account, speed = (
        EnergyAccount(kinetic=found.kinetic, elastic=found.elastic),
        float(np.linalg.norm(found.spin)),
    )
    history.record(speed, snapshot, account, 0.0, found.iterations)
    stability = found.stability
    attrs = {
        "outcome": "completed",
        "formulation": settings.formulation,
        "damping": settings.damping,
        "iterations": found.iterations,
        "residual": found.gap,
        "unstable": stability.unstable,
        "neutral": stability.neutral,
        "growth_rate": stability.growth,
        "warnings": json.dumps(
            json.loads(discrete.attributes.get("warnings", "[]"))
            + beside_the_axis(discrete.problem, settings)
            + _doubts(stability)
        ),
    }
    mesh = discrete.watch.once_asked(partial(discrete.watch.see_steady, snapshot, speed))
    states = discrete.arrays("steady", history, attrs, mesh)
    kept = stability.eigenvalues[: settings.modes]
    more: Arranged = {
        "spin_vector": ("axis", found.spin),
        "joint_spin": ("axis", found.body_spin),
        "centre": ("axis", found.centre),
        "momentum": ("axis", found.momentum),
        "eigenvalue": (("small_motion", "part"), np.column_stack([kept.real, kept.imag])),
    }
    more |= _of_motions(discrete, found, len(kept))
    return lambda: states().beside(more, {"part": ("real", "imaginary")})


def _of_motions(discrete: DiscreteModel, found: SteadyRotation, count: int) -> Arranged:
    """Return what tells of the ``count`` slowest small motions, made when it is asked for."""
    problem, stability = discrete.problem, found.stability

    @cache
    def increments() -> np.ndarray:
        return stability.increments(count)

    @cache
    def shapes() -> tuple[np.ndarray, np.ndarray]:
        return station_shapes(problem, found.state, increments())

    @cache
    def energies() -> StrainEnergies:
        rigid = rigid_parts(discrete.system, discrete.supports, found.state)
        return StrainEnergies(discrete.system, found.state, nodal_motions(problem), rigid)

    def names() -> np.ndarray:
        kept, kinds = stability.eigenvalues[:count], energies().kinds(increments())
        real = np.abs(kept.imag) <= REAL * np.abs(kept)
        still = np.abs(kept) <= SLOW * np.linalg.norm(found.spin)
        kinds = ["neutral" if rests else kind for kind, rests in zip(kinds, still, strict=True)]
        return np.array(numbered(kinds, real & ~still), dtype=str)

    def parts(which: int) -> np.ndarray:
        values = shapes()[which]
        return np.stack([values.real, values.imag], axis=1)

    motion = "small_motion"
    return {
        "mode_shape": ((motion, "part", "station", "axis"), partial(parts, 0)),
        "mode_rotation": ((motion, "part", "station", "axis"), partial(parts, 1)),
        "mode_name": (motion, names),
        "mode_share": ((motion, "component"), lambda: energies().shares(increments())),
        "mode_residual": (motion, lambda: stability.residuals(count)),
    }
