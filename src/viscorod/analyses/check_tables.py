"""The tables of a check, row by row: rods, sections, materials, bodies, joints and springs."""

from __future__ import annotations

import numpy as np

from viscorod.model.bodies.body_base import AnyBody
from viscorod.model.connections.joint_base import AnyJoint, ResolvedJoint
from viscorod.model.connections.spring import AnySpring, ResolvedSpring
from viscorod.model.connections.spring_laws import Laws
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import show
from viscorod.model.rod import Rod
from viscorod.results.reports.check_report import AXES_OF_RODS
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["body_row", "joint_row", "material_rows", "rod_row", "section_rows", "spring_row"]

SMALL = 1e-4
"""Couplings of a section smaller than this fraction of the root of their diagonal entries are not shown."""

COMPONENTS = ("shear 1", "shear 2", "stretch", "bend 1", "bend 2", "twist")


def material_rows(model: ModelDescription) -> list[dict[str, object]]:
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


def rod_row(problem: Problem, name: str, rod: Rod) -> dict[str, object]:
    """Describe a rod as it was divided."""
    index = problem.rods.index(name)
    part = next(s for s in problem.sets if (s.rod == index).any())
    elements = int(np.count_nonzero(part.rod == index))
    frame = rod.frames([0.0])[1][0]
    return {
        "rod": name,
        "length [m]": rod.length,
        "mass [kg]": rod.mass if rod.has_inertia else "not given",
        "elements": elements,
        "order": part.order,
        **{key: _numbers(np.round(frame[:, k], 9)) for k, key in enumerate(AXES_OF_RODS)},
    }


def body_row(name: str, body: AnyBody) -> dict[str, object]:
    """Describe a rigid body by its mass and principal inertia."""
    principal = np.linalg.eigvalsh(body.inertia_matrix())
    return {
        "body": name,
        "mass [kg]": body.total_mass(),
        **{f"inertia {k} [kg m2]": float(value) for k, value in enumerate(principal, 1)},
        **({"points": ", ".join(body.points)} if body.points else {}),
    }


def joint_row(joint: ResolvedJoint, given: AnyJoint) -> dict[str, object]:
    """Describe a joint where it is in the reference shape."""
    motions = [f"{word}(t)" if word in joint.motion else word for word in joint.free]
    return {
        "joint": given.name or "",
        "kind": joint.kind,
        "a - b": f"{given.a} - {given.b}",
        "free or driven": ", ".join(motions) or "none",
        "where [m]": _numbers(joint.at_a),
        "gap [m]": float(np.linalg.norm(joint.gap)),
    }


def spring_row(spring: ResolvedSpring, given: AnySpring) -> dict[str, object]:
    """Describe a spring by its stiffness and damping."""

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


def _numbers(vector: Floats) -> tuple[float, ...]:
    """Return the components of a vector, without negative zeros."""
    return tuple(float(value) + 0.0 for value in vector)


def section_rows(name: str, rod: Rod) -> list[dict[str, object]]:
    """Describe the sections of a rod at its start, where they jump, and at its end if they change towards it."""
    rows = []
    places = [0.0, *rod.section_breaks]
    if any(
        not np.array_equal(*ends)
        for ends in zip(*map(rod.matrices_at, (places[-1], rod.length)), strict=True)
    ):
        places.append(rod.length)
    for s in places:
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
