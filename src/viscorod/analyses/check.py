"""Describe a model before it is solved: sizes, stiffness and damping, first modes, doubts about validity."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from viscorod.analyses.discrete import DiscreteModel, named
from viscorod.analyses.doubtful_numbers import doubtful_numbers
from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.connections.joint_base import AnyJoint, ResolvedJoint
from viscorod.model.connections.spring import AnySpring, ResolvedSpring
from viscorod.model.connections.spring_laws import Laws
from viscorod.model.description.consistency import require_inertia
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import show, some_of
from viscorod.model.rod import Rod
from viscorod.results.damping_validity import QUICK
from viscorod.results.reports.check_report import CheckReport
from viscorod.results.validity import SLENDER, SMALL_STRAIN, Condition, Validity, unknown_width
from viscorod.solve.constraints.rigid_motions import free_motions, many_parts
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.vibrations import complex_modes, linearise, natural_frequencies
from viscorod.solve.problem.problem import Problem
from viscorod.solve.settings.analysis import AnySettings
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.checks import require_fit
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings
from viscorod.solve.steady.steady_checks import require_steady
from viscorod.typing import Floats

MODES = 6
SMALL = 1e-4
"""Couplings of a section smaller than this fraction of the root of their diagonal entries are not shown."""

STATIC_ONLY = (
    "a material was given without density, or a section without inertia: there are equilibria, paths and critical "
    "loads, and no motions"
)

COMPONENTS = ("shear 1", "shear 2", "stretch", "bend 1", "bend 2", "twist")


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
        rods=[_rod_row(problem, name, rod) for name, rod in model.rods.items()],
        sections=[row for name, rod in model.rods.items() for row in _section_rows(name, rod)],
        frequencies=frequencies,
        damping_ratios=first.damping_ratios,
        mode_names=first.names,
        rigid_motions=first.rigid,
        warnings=_doubts(model, problem, frequencies, settled=True) + first.warnings,
        nodes=n,
        unknowns=6 * n - int(problem.supports.fixed.sum()),
        bodies=[_body_row(name, body) for name, body in model.bodies.items()],
        joints=[
            _joint_row(joint, given)
            for joint, given in zip(model.resolved_joints(), model.joints, strict=True)
        ],
        springs=[
            _spring_row(spring, given)
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
        materials=_material_rows(model),
        assumptions=_assumptions(model),
        validity=_validity(model, frequencies),
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
        modes.frequencies[k:], modes.damping_ratios[k:], modes.names[k:], modes.names[:k], warnings
    )


def doubts(discrete: DiscreteModel, settings: AnySettings) -> list[str]:
    """Return the warnings of :func:`check` without the rest, quickly.

    Motions that nothing holds are among them if the analysis looks for a static equilibrium.
    """
    frequencies = np.zeros(0)
    if not many_parts(discrete.problem):
        linear = linearise(discrete.static, State.reference(discrete.problem), scale=0.0)
        frequencies = natural_frequencies(linear, 2 * MODES) / (2.0 * np.pi)
    flies = isinstance(settings, SimulateSettings) and (
        settings.initial == "reference" or settings.start is not None
    )
    unloaded = isinstance(settings, ModesSettings | ResponseSettings) and settings.about == "reference"
    settled = not (flies or unloaded or isinstance(settings, SteadySettings | CampbellSettings))
    slowest = frequencies[frequencies > 0.0][:1]
    return _doubts(discrete.model, discrete.problem, slowest, settled=settled)


def _doubts(model: ModelDescription, problem: Problem, frequencies: Floats, *, settled: bool) -> list[str]:
    """Return doubts about the rods, and about motions of the given frequencies [Hz, increasing]."""
    warnings = [text for name, rod in model.rods.items() for text in _rod_warnings(name, rod)]
    warnings += doubtful_numbers(model)
    joined = many_parts(problem)
    if joined:
        warnings.append(
            f"{joined} parts are joined by joints or springs: motions that nothing holds are not listed, and "
            "frequencies about the reference shape are not computed (modes about the equilibrium may be)"
        )
    free = free_motions(problem) if settled and not joined else []
    if free:
        warnings.append(
            f"nothing holds the model against {named(free)}: loads may hold it, such as the weight of a pendulum, in "
            "another position than the reference shape"
        )
    return warnings + _speed_warnings(model, frequencies) + _band_warnings(model, frequencies)


def _material_rows(model: ModelDescription) -> list[dict[str, object]]:
    """Describe the materials of the rods; times are those of slow motion."""
    return [
        {
            "material of rod": name,
            "Young's modulus [Pa]": rod.material.youngs_modulus,
            "Poisson's ratio": rod.material.poissons_ratio,
            "extensional time [s]": rod.material.extensional_time,
            "shear time [s]": rod.material.shear_time,
            "bulk time [s]": rod.material.bulk_time,
            "Maxwell branches": len(rod.material.branches),
        }
        for name, rod in model.rods.items()
        if rod.material is not None
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


def _rod_row(problem: Problem, name: str, rod: Rod) -> dict[str, object]:
    index = problem.rods.index(name)
    part = next(s for s in problem.sets if (s.rod == index).any())
    elements = int(np.count_nonzero(part.rod == index))
    return {
        "rod": name,
        "length [m]": rod.length,
        "mass [kg]": rod.mass if rod.has_inertia else "not given",
        "elements": elements,
        "order": part.order,
    }


def _body_row(name: str, body: AnyBody) -> dict[str, object]:
    principal = np.linalg.eigvalsh(body.inertia_matrix())
    return {
        "body": name,
        "mass [kg]": body.total_mass(),
        **{f"inertia {k} [kg m2]": float(value) for k, value in enumerate(principal, 1)},
        "points": ", ".join(body.points),
    }


def _joint_row(joint: ResolvedJoint, given: AnyJoint) -> dict[str, object]:
    motions = [f"{word}(t)" if word in joint.motion else word for word in joint.free]
    return {
        "joint": given.name or "",
        "kind": joint.kind,
        "a - b": f"{given.a} - {given.b}",
        "free or driven": ", ".join(motions) or "none",
        "where [m]": _point(joint.at_a),
        "gap [m]": float(np.linalg.norm(joint.gap)),
    }


def _spring_row(spring: ResolvedSpring, given: AnySpring) -> dict[str, object]:
    # the motion word of a line only says that it acts along itself
    def text(laws: Laws) -> str:
        shown = [(word, "function" if callable(law) else f"{law:.6g}") for word, law in laws.items()]
        return ", ".join(value if spring.kind == "line" else f"{word} {value}" for word, value in shown)

    return {
        "spring": given.name or "",
        "kind": spring.kind,
        "places": " - ".join(given.ends),
        "stiffness [N/m, N m/rad]": text(spring.stiffness),
        "damping [N s/m, N m s/rad]": text(spring.damping),
    }


def _point(position: Floats) -> str:
    return f"({', '.join(f'{value + 0.0:.4g}' for value in position)})"


def _section_rows(name: str, rod: Rod) -> list[dict[str, object]]:
    rows = []
    for s in (0.0, *rod.section_breaks):
        C, D, M = rod.matrices_at(s)
        mass: float | str = float(M[0, 0]) if rod.has_inertia else "not given"
        row: dict[str, object] = {"section": f"{name}@{s:.6g}", "mass per length [kg/m]": mass}
        held = rod.constrained_strains
        for i, component in enumerate(COMPONENTS):
            row[f"{component} stiffness [{'N' if i < 3 else 'N m2'}]"] = "held" if held[i] else float(C[i, i])
        branches = rod.branches_at(s)[1]
        if len(branches):  # what is in motion much faster than all relaxation times
            fast = C + branches.sum(axis=0)
            for i, component in enumerate(COMPONENTS):
                unit = "N" if i < 3 else "N m2"
                row[f"{component} stiffness in fast motion [{unit}]"] = "" if held[i] else float(fast[i, i])
        if D.any() or not len(branches):
            for i, component in enumerate(COMPONENTS):
                row[f"{component} time [s]"] = "" if held[i] else float(D[i, i] / C[i, i])
        if rod.law is not None:
            row["law beside these"] = show(rod.law.to_dict())
        row |= _couplings("coupling", "", C, held) | _couplings("viscous coupling", " s", D, held)
        offset = np.array([M[1, 5], -M[0, 5]]) / M[0, 0]
        if np.hypot(*offset) > SMALL * np.sqrt(M[5, 5] / M[0, 0]):
            x, y = np.where(np.abs(offset) > 1e-9 * np.abs(offset).max(), offset, 0.0)
            row["mass centre [m]"] = f"({x:.4g}, {y:.4g})"
        rows.append(row)
    return rows


def _couplings(word: str, per: str, matrix: Floats, held: tuple[bool, ...]) -> dict[str, object]:
    """Return the entries beside the diagonal that are not small against those on it, of strains that are free."""
    found: dict[str, object] = {}
    for i, first in enumerate(COMPONENTS):
        for j in range(i + 1, 6):
            size = np.sqrt(matrix[i, i]) * np.sqrt(matrix[j, j])
            if not (held[i] or held[j]) and abs(matrix[i, j]) > SMALL * size:
                unit = ("N", "N m", "N m2")[(i > 2) + (j > 2)]
                found[f"{first} & {COMPONENTS[j]} {word} [{unit}{per}]"] = float(matrix[i, j])
    return found


class _Shape(NamedTuple):
    """Half width [m] of a rod at its start times reference curvature and twist, and over its length."""

    curvature: float
    twist: float
    slenderness: float


def _shape(rod: Rod) -> _Shape | None:
    """Return how slender the reference shape of a rod is (LLT 2.2); None where its half width is not known."""
    half = rod.section_at(0.0).half_width
    if half is None:
        return None
    s = np.linspace(0.0, rod.length, 201)
    curvature = float(np.linalg.norm(rod.centreline.curvature(s), axis=1).max())
    twist = float(np.abs(np.gradient(rod.centreline.twisted(s, rod.turn), s)).max())
    return _Shape(half * curvature, half * twist, half / rod.length)


def _rod_warnings(name: str, rod: Rod) -> list[str]:
    """Judge the slenderness of the reference shape: half width times curvature (LLT 2.2)."""
    warnings = []
    shape = _shape(rod)
    if shape is not None:
        for what, size in (("curvature", shape.curvature), ("twist", shape.twist)):
            if size > SLENDER:
                warnings.append(
                    f"rod {name}: half width times {what} of the reference shape is {size:.2g}; "
                    "a rod model is meant for values much smaller than 1"
                )
        if shape.slenderness > SLENDER:
            warnings.append(
                f"rod {name}: its half width is {shape.slenderness:.2g} of its length; "
                "a rod model is meant for slender bodies"
            )
    warnings.extend(f"rod {name}: {remark}" for remark in rod.section_at(0.0).remarks())
    return warnings


def _validity(model: ModelDescription, frequencies: Floats) -> Validity:
    """Return the conditions of a rod model that are known before a solution, with the names that results give them."""
    known = {name: shape for name, rod in model.rods.items() if (shape := _shape(rod)) is not None}
    names = ("|J0 - 1|: half width x curvature", "half width x reference twist")
    conditions = []
    for k, name in enumerate((*names, "half width / length")):
        if known:
            worst = max(known, key=lambda rod: known[rod][k])
            conditions.append(Condition(name, "LLT 2.2", known[worst][k], SLENDER, worst))
        else:
            conditions.append(unknown_width(name, "LLT 2.2", SLENDER))
    for name in ("shear and stretch", "half width x bending, twist"):
        conditions.append(Condition(name, "LLT 2.2", math.nan, SMALL_STRAIN, "known of a solution"))
    times = {name: _longest_time(rod) for name, rod in model.rods.items()}
    slowest = max(times, key=lambda rod: times[rod], default="")
    if slowest and times[slowest] > 0.0:
        omega = 2 * np.pi * float(frequencies[0]) if len(frequencies) else math.nan
        where = f"{slowest}, first mode" if len(frequencies) else "no mode is known"
        name = "angular frequency x time"
        conditions.append(Condition(name, "LLT 2.6", omega * times[slowest], QUICK, where))
    return Validity(tuple(conditions))


def _longest_time(rod: Rod) -> float:
    """Return the longest Kelvin-Voigt retardation time of a rod at its start [s]."""
    C, D, _ = rod.matrices_at(0.0)
    free = ~np.array(rod.constrained_strains)
    return float(np.max((np.diag(D) / np.diag(C))[free], initial=0.0))


def _speed_warnings(model: ModelDescription, frequencies: Floats) -> list[str]:
    """Compare retardation times with the slowest motion (LLT 2.6)."""
    if not len(frequencies):
        return []
    omega = 2 * np.pi * float(frequencies[0])
    warnings = []
    for name, rod in model.rods.items():
        time = _longest_time(rod)
        if omega * time > QUICK:
            warnings.append(
                f"rod {name}: first angular frequency times longest retardation time is {omega * time:.2g}; "
                "Kelvin-Voigt damping is meant for motions much slower than the material's relaxation"
            )
    return warnings


def _band_warnings(model: ModelDescription, frequencies: Floats) -> list[str]:
    """Compare the bands of loss factors with the frequencies [Hz] of the first motions."""
    warnings = []
    for name, rod in model.rods.items():
        band = None if rod.material is None else rod.material.loss_band
        if band is None or rod.material is None:
            continue
        outside = frequencies[(frequencies < band[0]) | (frequencies > band[1])]
        modulus = rod.material.relaxation("extension")
        if outside.size and modulus is not None:
            found = modulus.complex_modulus(2.0 * np.pi * outside)
            where, losses = (
                ", ".join(f"{value:.3g}" for value in values) for values in (outside, found.imag / found.real)
            )
            warnings.append(
                f"rod {name}: its loss factor holds from {band[0]:.4g} to {band[1]:.4g} Hz, and of the first "
                f"frequencies of the model {where} Hz {'are' if outside.size > 1 else 'is'} outside: there it is "
                f"{losses} in extension"
            )
    return warnings
