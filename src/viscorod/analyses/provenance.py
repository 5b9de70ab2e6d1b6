"""Where a result comes from: its model, its case file, the versions, its materials and their damping laws."""

from __future__ import annotations

import hashlib
import json
import platform
from functools import cache, partial
from typing import Any

import numpy as np

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.materials.material import Material
from viscorod.model.materials.relaxation_modulus import RelaxationModulus
from viscorod.model.rod import Rod
from viscorod.model.sections.section_base import AnySection
from viscorod.results.late_attributes import LateAttributes, Later
from viscorod.solve.formulations.system import GaussPositions

__all__ = ["material_record", "provenance", "section_record"]

CAPACITIES = 65
"""Stations at which the heat capacity of a rod is taken."""


def provenance(
    model: ModelDescription, known: ModelDescription, title: str, more: dict[str, str]
) -> LateAttributes:
    """Return the attributes that every result has: the model as a case, versions, laws, and ``more`` that is given.

    What has to be made of the model is made when it is asked for, so it must not change; but at once where sections are
    functions of the arc length, which may return others later.

    Args:
        model: that was given; known: the same with the times of all its materials.
    """
    from viscorod import __version__

    def case() -> dict[str, str]:
        written = json.dumps(model.to_dict())
        text = (more.get("case_text") or written) + more.get("case_changes", "")
        return {"case": written, "case_hash": hashlib.sha256(text.encode()).hexdigest()}

    there = {"title": title, "version": __version__, "platform": _platform(), **more}
    if any(callable(rod.section) and not isinstance(rod.section, AnySection) for rod in model.rods.values()):
        return LateAttributes(there | case() | material_record(known))
    return LateAttributes(
        there,
        Later(("case", "case_hash"), cache(case)),
        Later(
            ("damping_assumptions", "damping_laws", "heat_capacities"), cache(partial(material_record, known))
        ),
    )


@cache
def _platform() -> str:
    return f"Python {platform.python_version()}, NumPy {np.__version__}, {platform.platform()}"


def material_record(model: ModelDescription) -> dict[str, str]:
    """Return the attributes about materials whose times are known, as JSON by rod.

    ``damping_assumptions`` are sentences. ``damping_laws`` have ``times``, the retardation times [s] of the six strains
    at the start of the rod (None where it holds them or a Maxwell branch damps them); and, if it is known what a
    Kelvin-Voigt material stands for, ``extension`` and ``shear`` with ``modulus`` [Pa], ``viscosity`` [Pa s] and the
    Prony series: ``equilibrium`` [Pa], ``moduli`` [Pa], ``times`` [s]. ``heat_capacities`` [J/(m K)] are there of rods
    whose specific heat is known; ``loss_band`` [Hz] is where Maxwell branches follow a loss factor.
    """
    sentences = {name: list(rod.assumptions) for name, rod in model.rods.items() if rod.assumptions}
    laws = {name: _law(rod) for name, rod in model.rods.items()}
    record = {"damping_assumptions": json.dumps(sentences), "damping_laws": json.dumps(laws)}
    capacities = {name: known for name, rod in model.rods.items() if (known := _heat_capacity(rod))}
    return record | ({"heat_capacities": json.dumps(capacities)} if capacities else {})


def _heat_capacity(rod: Rod) -> dict[str, list[float]]:
    """Return the heat capacity per length over the arc length; empty where a specific heat is not known."""
    if rod.heat_capacity_at(0.0) is None:
        return {}
    edge = 1e-9 * rod.length
    ends = [0.0, rod.length, *(b + side for b in rod.section_breaks for side in (-edge, edge))]
    stations = np.unique([*np.linspace(0.0, rod.length, CAPACITIES), *ends]).tolist()
    found = [rod.heat_capacity_at(s) for s in stations]
    if None in found:
        return {}
    values = [float(value or 0.0) for value in found]
    if max(values) - min(values) <= 1e-12 * max(values):
        return {"s": [0.0], "capacity": values[:1]}
    return {"s": stations, "capacity": values}


def section_record(model: ModelDescription, gauss: GaussPositions) -> dict[str, str]:
    """Return the attribute ``sections``, JSON by rod: what of its sections the attribute ``case`` does not hold.

    That are materials whose damping followed from a mode, and at the Gauss points, ``stations`` [m]: sections that are
    a function of the arc length, ``sampled``, and the reference curvatures of rods that count them, ``bent`` [1/m].
    """
    found: dict[str, dict[str, Any]] = {}
    for number, (name, rod) in enumerate(model.rods.items()):
        if rod.material is not None and rod.material.assumptions:
            found[name] = {"material": rod.material.to_dict()}
        sampled: dict[str, Any] = {}
        by_function = callable(rod.section) and not isinstance(rod.section, AnySection)
        if not (by_function or rod.curvature_correction):
            continue
        stations = gauss.s[gauss.rod == number].tolist()
        if by_function:
            sampled["sampled"] = [rod.section_at(s).to_dict() for s in stations]
        if rod.curvature_correction:
            sampled["bent"] = [rod.curvature_at(s).tolist() for s in stations]
        found[name] = found.get(name, {}) | {"stations": stations} | sampled
    return {"sections": json.dumps(found)} if found else {}


def _law(rod: Rod) -> dict[str, Any]:
    C, D, _ = rod.matrices_at(0.0)
    relaxing = len(rod.branches_at(0.0)[0]) > 0
    times = [
        None if held or relaxing else float(time)
        for held, time in zip(rod.constrained_strains, np.diag(D) / np.diag(C), strict=True)
    ]
    law: dict[str, Any] = {"times": times, "maxwell": relaxing}
    if rod.material is not None and not relaxing:
        law |= _series(rod.material)
    if rod.material is not None and rod.material.loss_band is not None:
        law["loss_band"] = list(rod.material.loss_band)
    return law


def _series(material: Material) -> dict[str, Any]:
    found = {}
    for strain, modulus, viscosity in (
        ("extension", material.youngs_modulus, material.extensional_viscosity),
        ("shear", material.shear_modulus, material.shear_viscosity),
    ):
        relaxation = material.relaxation(strain)
        if isinstance(relaxation, RelaxationModulus):
            found[strain] = {
                "modulus": modulus,
                "viscosity": viscosity,
                "equilibrium": relaxation.equilibrium,
                "moduli": list(relaxation.moduli),
                "times": list(relaxation.times),
            }
    return found
