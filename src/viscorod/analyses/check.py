"""Describe a model before it is solved: sizes, stiffness and damping, first modes, doubts about validity."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.analyses.check_tables import (
    body_row,
    joint_row,
    material_rows,
    rod_row,
    section_rows,
    spring_row,
)
from viscorod.analyses.discrete import DiscreteModel, named
from viscorod.analyses.model_doubts import model_doubts
from viscorod.analyses.rod_doubts import band_warnings, known_validity, shape_warnings, speed_warnings
from viscorod.model.description.consistency import require_inertia
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.results.reports.check_report import CheckReport
from viscorod.solve.constraints.parts import many_parts
from viscorod.solve.constraints.rigid_motions import free_motions
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import complex_modes, linearise, natural_frequencies
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.analysis import AnySettings
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.checks import require_fit
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.steady.steady_checks import require_steady
from viscorod.typing import Floats

MODES = 6
STATIC_ONLY = (
    "a material was given without density, or a section without inertia: there are equilibria, paths and critical "
    "loads, and no motions"
)


def check(discrete: DiscreteModel, settings: AnySettings | None = None) -> CheckReport:
    """Describe a model, and refuse settings of an analysis that it does not allow.

    Frequencies and damping ratios are those of the geometric formulation, for which the model has to be discretised.

    Raises:
        InputError: the analysis cannot be made of it.
    """
    model, problem, solver = discrete.model, discrete.problem, discrete.static
    if settings is not None and not isinstance(
        settings, EquilibriumSettings | PathSettings | BucklingSettings
    ):
        require_inertia(model)
    if isinstance(settings, SimulateSettings):
        require_fit(model, settings)
    if isinstance(settings, SteadySettings):
        require_steady(model, problem, settings)
    n = problem.size
    first = _first_modes(discrete)
    frequencies = first.frequencies
    return CheckReport(
        rods=[rod_row(problem, name, rod) for name, rod in model.rods.items()],
        sections=[row for name, rod in model.rods.items() for row in section_rows(name, rod)],
        frequencies=frequencies,
        damping_ratios=first.damping_ratios,
        mode_names=first.names,
        rigid_motions=first.rigid,
        warnings=_doubts(model, problem, frequencies) + _unheld(problem) + first.warnings,
        nodes=n,
        unknowns=6 * n - int(problem.supports.fixed.sum()),
        bodies=[body_row(name, body) for name, body in model.bodies.items()],
        joints=[
            joint_row(joint, given)
            for joint, given in zip(model.resolved_joints(), model.joints, strict=True)
        ],
        springs=[
            spring_row(spring, given)
            for spring, given in zip(model.resolved_springs(), model.springs, strict=True)
        ],
        media=[
            {"load": load.name or load.word, "rod": getattr(load, "rod", ""), **load.figures()}
            for load in model.loads
            if load.sees_motion
        ],
        rest_strains=[
            {"rod": strain.rod, **strain.figures(model.rods[strain.rod])} for strain in model.rest_strains
        ],
        conditions=solver.system.constraints.rows,
        linear_solver=problem.plan.description,
        materials=material_rows(model),
        assumptions=_assumptions(model),
        validity=known_validity(model, frequencies),
    )


class _FirstModes(NamedTuple):
    """The first modes of the reference shape: frequencies [Hz], damping ratios, names; rigid motions; doubts."""

    frequencies: Floats
    damping_ratios: Floats
    names: tuple[str, ...]
    rigid: tuple[str, ...]
    warnings: list[str]


def _first_modes(discrete: DiscreteModel) -> _FirstModes:
    """Return them; none where very many parts are joined: each may have motions of its own without any stiffness."""
    solver, state = discrete.static, State.reference(discrete.problem)
    if many_parts(discrete.problem):
        return _FirstModes(np.zeros(0), np.zeros(0), (), (), [])
    if not all(rod.has_inertia for rod in discrete.model.rods.values()):
        return _FirstModes(np.zeros(0), np.zeros(0), (), (), [STATIC_ONLY])
    discrete.announce_modes()
    linear = linearise(solver, state, scale=0.0)
    modes = complex_modes(solver, state, linear, MODES + linear.rigid)
    k, warnings = modes.rigid, []
    if k > linear.rigid:
        warnings.append(
            "slow motions of the reference shape are free of stiffness, or lost in round-off: nothing resists them, as "
            "in cables without loads, or stretch is so much stiffer than bending over the whole length that double "
            "precision keeps no digit of it; look at modes about the equilibrium, where loads stretch the rods, or use "
            "fewer elements"
        )
    return _FirstModes(
        modes.frequencies[k:],
        modes.damping_ratios[k:],
        modes.shown.names[k:],
        modes.shown.names[:k],
        warnings,
    )


def doubts(discrete: DiscreteModel) -> list[str]:
    """Return the warnings of :func:`check` that a result is to keep, quickly.

    Motions that nothing holds are not among them: an equilibrium tells whether the model has turned.
    """
    frequencies = np.zeros(0)
    if not many_parts(discrete.problem):
        linear = linearise(discrete.static, State.reference(discrete.problem), scale=0.0)
        frequencies = natural_frequencies(linear, 2 * MODES) / (2.0 * np.pi)
    slowest = frequencies[frequencies > 0.0][:1]
    return _doubts(discrete.model, discrete.problem, slowest)


def _doubts(model: ModelDescription, problem: Problem, frequencies: Floats) -> list[str]:
    """Return doubts about the rods, and about motions of the given frequencies [Hz, increasing]."""
    warnings = [text for name, rod in model.rods.items() for text in shape_warnings(name, rod)]
    warnings += model_doubts(model, problem)
    joined = many_parts(problem)
    if joined:
        warnings.append(
            f"{joined} parts are joined by joints or springs: motions that nothing holds are not listed, and "
            "frequencies about the reference shape are not computed (modes about the equilibrium may be)"
        )
    return warnings + speed_warnings(model, frequencies) + band_warnings(model, frequencies)


def _unheld(problem: Problem) -> list[str]:
    """Return a warning of motions that supports leave free, where few parts are joined."""
    free = [] if many_parts(problem) else free_motions(problem)
    return [
        f"nothing holds the model against {named(free)}: loads may hold it, such as the weight of a pendulum, in "
        "another position than the reference shape"
        for _ in free[:1]
    ]


def _assumptions(model: ModelDescription) -> list[str]:
    """Return what was assumed of the damping; the same of several rods once."""
    rods: dict[str, list[str]] = {}
    for name, rod in model.rods.items():
        for text in rod.assumptions:
            rods.setdefault(text, []).append(name)
    return [
        f"{'rod' if len(names) == 1 else 'rods'} {some_of(names)}: {text}" for text, names in rods.items()
    ]
