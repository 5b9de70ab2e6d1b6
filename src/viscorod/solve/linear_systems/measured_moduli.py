"""Complex moduli measured over frequency, used as they are: parts of the sections with a factor of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.material import Material
from viscorod.model.materials.sweeps import DmaTable
from viscorod.model.rod import Rod
from viscorod.model.sections.isotropic_section import MaterialSection
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = ["MeasuredPart", "TableModulus", "measured_parts", "without_measured"]

SLACK = 1e-9
"""Part of a frequency by which it may lie outside a table."""


class TableModulus:
    """The complex modulus of a table at any frequency within it.

    The logarithms of storage and loss modulus are interpolated over that of frequency by cubics that keep every rise
    and fall (Fritsch and Carlson 1980); where a loss modulus is 0 the moduli are interpolated themselves.

    Args:
        table: as it was measured; shift: relaxation times over those in the measurement (a_T), at another temperature.
    """

    def __init__(self, table: DmaTable, shift: float = 1.0) -> None:
        self.omega = table.omega / shift
        self._storage = self._interpolated(table.storage)
        self._loss = self._interpolated(table.loss)

    def _interpolated(self, values: Floats) -> tuple[bool, PchipInterpolator | float]:
        logarithmic = bool((values > 0.0).all())
        given = np.log(values) if logarithmic else values
        if len(values) == 1:
            return logarithmic, float(given[0])
        return logarithmic, PchipInterpolator(np.log(self.omega), given, extrapolate=True)

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency of the table [Hz]."""
        return float(self.omega[0]) / (2.0 * np.pi), float(self.omega[-1]) / (2.0 * np.pi)

    def at(self, omega: float) -> complex:
        """Return the modulus [Pa] at an angular frequency [rad/s] within the table."""
        x = np.log(min(max(omega, float(self.omega[0])), float(self.omega[-1])))
        parts = []
        for logarithmic, found in (self._storage, self._loss):
            value = found if isinstance(found, float) else float(found(x))
            parts.append(np.exp(value) if logarithmic else value)
        return complex(*parts)


@dataclass(frozen=True)
class MeasuredPart:
    """What a measured modulus has in the sections at the Gauss points, order of results.

    Attributes:
        rods: names of the rods of this material.
        section: stiffness at rest of this part ``(points, 6, 6)``.
        law: the points at which the law of the material gives way to it ``(points,)``.
        rest: modulus at rest [Pa] that the stiffness has; modulus: over frequency.
    """

    rods: tuple[str, ...]
    section: Floats
    law: np.ndarray
    rest: float
    modulus: TableModulus

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency that were measured [Hz]."""
        return self.modulus.band

    def factor(self, s: complex) -> complex:
        """Return the modulus over that at rest, in harmonic motion ``s = i omega`` [1/s]."""
        return self.modulus.at(abs(s.imag)) / self.rest


def measured_parts(
    model: ModelDescription, problem: Problem, places: GaussPositions
) -> tuple[list[MeasuredPart], list[str]]:
    """Return the parts of rods whose material was measured over frequency, and rods whose tables are not used as such.

    With one table Poisson's ratio is constant. Regions of composite sections keep the law that was fitted to theirs.
    """
    groups: dict[int, list[str]] = {}
    materials: dict[int, Material] = {}
    for name, rod in model.rods.items():
        material = rod.material
        if material is not None and isinstance(material.damping, ComplexModuli):
            groups.setdefault(id(material), []).append(name)
            materials[id(material)] = material
    fitted = [name for name, rod in model.rods.items() if rod.material is None and _has_tables(rod)]
    found = []
    for key, names in groups.items():
        found += _parts(model, names, materials[key], problem, places)
    return found, fitted


def _has_tables(rod: Rod) -> bool:
    """Return whether a composite section has materials with tables."""
    for s in (0.0, *rod.section_breaks):
        regions = getattr(rod.section_at(s), "regions", ())
        if any(isinstance(getattr(r.material, "damping", None), ComplexModuli) for r in regions):
            return True
    return False


def _parts(
    model: ModelDescription, names: list[str], material: Material, problem: Problem, places: GaussPositions
) -> list[MeasuredPart]:
    damping = material.damping
    assert isinstance(damping, ComplexModuli)
    count = len(places.s)
    shapes = np.zeros((2, count, 6, 6))
    numbers = [problem.rods.index(name) for name in names]
    law = np.isin(places.rod, numbers)
    for k in np.flatnonzero(law):
        rod = model.rods[problem.rods[places.rod[k]]]
        section = rod.section_at(float(places.s[k]))
        assert isinstance(section, MaterialSection)  # others take no material
        free = 1.0 - np.array(rod.constrained_strains, dtype=float)
        extensional, shearing, _ = section.geometry(material.poissons_ratio)
        shapes[:, k] = np.outer(free, free) * np.array([extensional, shearing])
    tables = {strain: TableModulus(table, material.shift_factor) for strain, table in damping.tables.items()}
    young, shear = material.youngs_modulus, material.shear_modulus
    if len(tables) == 1 or material.poissons_ratio == 0.5:  # incompressible: both moduli go together
        modulus = tables[damping.of]
        rest = young if damping.of == "extension" else shear
        return [MeasuredPart(tuple(names), young * shapes[0] + shear * shapes[1], law, rest, modulus)]
    return [
        MeasuredPart(tuple(names), young * shapes[0], law, young, tables["extension"]),
        MeasuredPart(tuple(names), shear * shapes[1], np.zeros_like(law), shear, tables["shear"]),
    ]


def without_measured(
    parts: Sequence[MeasuredPart], section: Sequence[Floats], damping: Floats
) -> list[Floats]:
    """Return what to add to the matrices of the sections ``(points, 6, 6)`` so that measured parts are no more in them.

    Args:
        section: those of every coefficient: stiffness, viscosity, inertia (none) and branches.
        damping: viscosity without that of laws of sections.
    """
    law = np.any([part.law for part in parts], axis=0)[:, None, None]
    changes = [np.where(law, -matrices, 0.0) for matrices in section]
    changes[0] = -np.sum([part.section for part in parts], axis=0)
    changes[1] = np.where(law, -damping, 0.0)
    return changes
