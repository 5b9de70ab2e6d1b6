"""Numbers that follow from a case, by names that a mechanician knows: bending stiffness, extensional time, loss factor.

Where the data cannot tell two unknowns apart they may still tell one of these well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from viscorod.analyses.identification.case_numbers import case_with, number_at
from viscorod.casefile.case import Case
from viscorod.casefile.known_parts import KnownParts
from viscorod.model.materials.material import Material
from viscorod.solve.estimation.intervals import Covariance
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["Combination", "combinations", "numbers_of_case"]

STEP = 1e-4
"""Step of differences by the coordinates of unknowns."""
ALONE = 0.999
"""Part of a gradient along one unknown from which on a number is only that unknown in other words."""
SAME = 1e-3
"""Difference of directions below which two numbers are told by the same combination."""

Named = dict[str, tuple[float, str]]


@dataclass(frozen=True)
class Combination:
    """A number that follows from several unknowns: its value, unit, and interval."""

    name: str
    unit: str
    value: float
    low: float
    high: float
    powers: tuple[float, ...]


def numbers_of_case(case: Case, frequencies: Sequence[float]) -> Named:
    """Return positive numbers of every rod by name, with their units.

    Args:
        case: whose rods they are.
        frequencies: at which the material moved, Hz: its loss factor there.
    """
    found: Named = {}
    for name, rod in case.description.rods.items():
        if isinstance(
            rod.material, Material
        ):  # the simplest words first: others of the same direction are left out
            found |= _of_material(rod.material, name, frequencies)
        stiffness, damping, inertia = rod.matrices_at(0.0)
        mass = float(inertia[0, 0])
        for word, k, unit in (
            ("stretching stiffness EA", 2, "N"),
            ("bending stiffness about d1", 3, "N m^2"),
            ("bending stiffness about d2", 4, "N m^2"),
            ("torsional stiffness", 5, "N m^2"),
        ):
            found[f"{word} of {name}"] = (float(stiffness[k, k]), unit)
        found[f"mass per length of {name}"] = (mass, "kg/m")
        for word, k in (
            ("bending stiffness about d1", 3),
            ("bending stiffness about d2", 4),
            ("torsional stiffness", 5),
        ):
            found[f"{word} over mass per length of {name}"] = (float(stiffness[k, k]) / mass, "m^4/s^2")
        if not isinstance(rod.material, Material) and np.any(damping):
            found[f"bending time of {name}"] = (float(damping[3, 3] / stiffness[3, 3]), "s")
            found[f"torsional time of {name}"] = (float(damping[5, 5] / stiffness[5, 5]), "s")
    return {name: pair for name, pair in found.items() if np.isfinite(pair[0]) and pair[0] > 0.0}


def _of_material(material: Material, name: str, frequencies: Sequence[float]) -> Named:
    found: Named = {
        "speed of sound in " + name: (float(np.sqrt(material.youngs_modulus / material.density)), "m/s")
    }
    if not material.branches:
        found |= {
            f"extensional time of {name}": (material.extensional_time, "s"),
            f"shear time of {name}": (material.shear_time, "s"),
        }
    for hertz in frequencies:
        modulus = complex_modulus(material, hertz)
        found[f"loss factor of {name} in bending at {hertz:.4g} Hz"] = (modulus.imag / modulus.real, "1")
        found[f"dynamic Young's modulus of {name} at {hertz:.4g} Hz"] = (abs(modulus), "Pa")
    return found


def complex_modulus(material: Material, hertz: float) -> complex:
    """Return the complex Young's modulus of a material, Pa."""
    omega = 2.0 * np.pi * hertz
    law = material.relaxation("extension")
    if law is not None:
        return complex(np.asarray(law.complex_modulus(np.array([omega])))[0])
    return material.youngs_modulus * (1.0 + 1j * omega * material.extensional_time)


def combinations(
    case: Case,
    unknowns: Unknowns,
    z: Floats,
    known: Covariance,
    frequencies: Sequence[float],
    level: float,
) -> list[Combination]:
    """Return the numbers of a case that the data tell, where they are more than one unknown in other words."""
    mine = [k for k, one in enumerate(unknowns) if number_at(case, one.name) is not None]
    if not mine:
        return []

    parts = KnownParts()

    def numbers(at: Floats) -> Named:
        values = unknowns.values(at)
        changed = case_with(case, {unknowns[k].name: float(values[k]) for k in mine}, parts)
        return numbers_of_case(changed, frequencies)

    centre = numbers(z)
    slopes = {name: np.zeros(len(z)) for name in centre}
    for k in mine:
        step = STEP * np.eye(len(z))[k]
        above, below = numbers(z + step), numbers(z - step)
        for name in centre:
            if name in above and name in below:
                slopes[name][k] = np.log(above[name][0] / below[name][0]) / (2.0 * STEP)
    return _told(centre, slopes, known, level)


def _told(centre: Named, slopes: Mapping[str, Floats], known: Covariance, level: float) -> list[Combination]:
    out: list[Combination] = []
    directions: list[Floats] = []
    for name, gradient in slopes.items():
        size = float(np.linalg.norm(gradient))
        if size < 1e-6 or not known.told(gradient):
            continue
        direction = gradient / size
        k = int(np.argmax(np.abs(direction)))
        if abs(direction[k]) > ALONE and known.told(np.eye(len(gradient))[k]):
            continue
        if any(
            min(np.abs(direction - other).max(), np.abs(direction + other).max()) < SAME
            for other in directions
        ):
            continue
        directions.append(direction)
        reach = float(stats.t.ppf(0.5 + level / 2.0, known.freedom_of(gradient))) * known.deviation(gradient)
        value, unit = centre[name]
        ends = (value * float(np.exp(-reach)), value * float(np.exp(reach)))
        out.append(Combination(name, unit, value, *ends, tuple(gradient.tolist())))
    return out
