"""Complex moduli measured over frequency, used as they are: parts of the sections with a factor of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy  # its parts are imported when they are asked for

from viscorod.model.description.model_description import ModelDescription
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.loss_factor import LossFactor
from viscorod.model.materials.material import Material
from viscorod.model.materials.moduli_over_frequency import DmaTable
from viscorod.solve.formulations.system import GaussPositions
from viscorod.solve.problem.problem import Problem
from viscorod.typing import Floats

__all__ = [
    "ConstantModulus",
    "MeasuredPart",
    "MeasuredParts",
    "TableModulus",
    "measured_parts",
    "of_law_in_place",
    "without_measured",
]

ROUND_OFF = 1e-12
"""Part of a section's stiffness that is round-off of the others."""


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

    def _interpolated(self, values: Floats) -> tuple[bool, Any]:
        logarithmic = bool((values > 0.0).all())
        given = np.log(values) if logarithmic else values
        if len(values) == 1:
            return logarithmic, float(given[0])
        return logarithmic, scipy.interpolate.PchipInterpolator(np.log(self.omega), given, extrapolate=True)

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


class ConstantModulus:
    """The complex modulus of a loss factor that is the same at all frequencies, ``E (1 + i eta)``.

    Args:
        modulus: E (1 + i eta), Pa.
    """

    band = None

    def __init__(self, modulus: complex) -> None:
        self._modulus = modulus

    def at(self, omega: float) -> complex:
        """Return the modulus [Pa] at any angular frequency [rad/s] above 0."""
        del omega
        return self._modulus


@dataclass(frozen=True)
class MeasuredPart:
    """What a modulus that is known over frequency has in the sections at the Gauss points, order of results.

    Attributes:
        section: stiffness at rest of this part ``(points, 6, 6)``.
        replaced: stiffness, viscosity, inertia (none) and branches that the fitted law has in its place, each
            ``(points, 6, 6)`` or 0.
        rest: modulus at rest [Pa] that the stiffness has; modulus: over frequency.
    """

    section: Floats
    replaced: tuple[Floats | float, ...]
    rest: float
    modulus: TableModulus | ConstantModulus

    @property
    def band(self) -> tuple[float, float] | None:
        """Lowest and highest frequency that were measured [Hz]; None if it holds at any."""
        return self.modulus.band

    def factor(self, s: complex) -> complex:
        """Return the modulus over that at rest, in harmonic motion ``s = i omega`` [1/s]; 1 at rest."""
        omega = abs(s.imag)
        return self.modulus.at(omega) / self.rest if omega > 0.0 else 1.0


@dataclass(frozen=True)
class MeasuredParts:
    """All parts of a model whose moduli are known over frequency.

    Attributes:
        parts: two for each material at most.
        told: where moduli come from, in sentences; notes: what is uncertain about them.
        holds: frequencies [Hz] between which all constant loss factors were said to hold; None without any.
    """

    parts: tuple[MeasuredPart, ...] = ()
    told: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    holds: tuple[float, float] | None = None


def measured_parts(model: ModelDescription, problem: Problem, places: GaussPositions) -> MeasuredParts:
    """Return the parts of the sections whose material was measured over frequency, or has a constant loss factor.

    With one table Poisson's ratio is constant. Regions of composite sections take part with the warping that the
    section has at its moduli at rest, as they do in the fitted law.
    """
    count = len(places.s)
    found: dict[int, tuple[Material, Floats, list[str]]] = {}
    composite = False
    for k in range(count):
        name = problem.rods[places.rod[k]]
        rod = model.rods[name]
        free = 1.0 - np.array(rod.constrained_strains, dtype=float)
        contents = rod.materials_at(float(places.s[k]))
        for material, extensional, shearing in contents:
            if not _over_frequency(material):
                continue
            _, shapes, names = found.setdefault(id(material), (material, np.zeros((2, count, 6, 6)), []))
            shapes[:, k] += np.outer(free, free) * np.array([extensional, shearing])
            composite = composite or len(contents) > 1
            if name not in names:
                names.append(name)
    parts: list[MeasuredPart] = []
    told, bands = [], []
    for material, shapes, names in found.values():
        parts += _parts(material, shapes, problem.relaxation_times)
        told.append(_told(material, names))
        if isinstance(material.damping, LossFactor):
            bands.append(material.loss_band or (0.0, np.inf))
    notes = [_COMPOSITE] if composite else []
    holds = (max(b[0] for b in bands), min(b[1] for b in bands)) if bands else None
    return MeasuredParts(tuple(parts), tuple(told), tuple(notes), holds)


_COMPOSITE = (
    "sections of several materials have the complex moduli of their regions, and the warping that the section has with "
    "their moduli at rest: shear and torsion of strongly damped layers are of first order in their loss factor"
)


def _over_frequency(material: Material) -> bool:
    """Return whether the complex modulus of a material is known without a fit."""
    damping = material.damping
    if isinstance(damping, LossFactor):
        return damping.constant_moduli(material.given_moduli) is not None
    return isinstance(damping, ComplexModuli)


def _told(material: Material, names: Sequence[str]) -> str:
    """Say where the modulus of a material comes from."""
    rods, damping = ", ".join(names), material.damping
    if isinstance(damping, ComplexModuli):
        return f"{rods}: moduli of the table as measured, interpolated between its frequencies, without a fit"
    assert isinstance(damping, LossFactor)
    moduli = damping.constant_moduli(material.given_moduli)
    assert moduli is not None
    young, shear = moduli
    text = f"E = {young.real:.6g} (1 + {young.imag / young.real:.4g} i) Pa"
    if abs(shear.imag / shear.real - young.imag / young.real) > 1e-12:
        text += f", G = {shear.real:.6g} (1 + {shear.imag / shear.real:.4g} i) Pa"
    return f"{rods}: {text} at every frequency, without the Maxwell branches that motions are computed with"


def _parts(material: Material, shapes: Floats, times: Floats) -> list[MeasuredPart]:
    """Return the parts of one material with its C_E and C_G at all points ``(2, points, 6, 6)``."""
    damping = material.damping
    young, shear = material.youngs_modulus, material.shear_modulus
    none = 0.0 if material.branches else 1.0
    viscous = none * (material.extensional_viscosity * shapes[0] + material.shear_viscosity * shapes[1])
    branches: list[Floats | float] = [0.0] * len(times)
    for b in material.branches:
        branches[int(np.argmin(np.abs(times - b.time)))] += (
            b.youngs_modulus * shapes[0] + b.shear_modulus * shapes[1]
        )
    law = (young * shapes[0] + shear * shapes[1], viscous, 0.0, *branches)
    if isinstance(damping, LossFactor):
        moduli = damping.constant_moduli(material.given_moduli)
        assert moduli is not None
        extension, shearing = map(ConstantModulus, moduli)
        return [
            MeasuredPart(young * shapes[0], law, young, extension),
            MeasuredPart(shear * shapes[1], (), shear, shearing),
        ]
    assert isinstance(damping, ComplexModuli)
    tables = {strain: TableModulus(table, material.shift_factor) for strain, table in damping.tables.items()}
    if len(tables) == 1 or material.poissons_ratio == 0.5:  # incompressible: both moduli go together
        rest = young if damping.of == "extension" else shear
        return [MeasuredPart(law[0], law, rest, tables[damping.of])]
    return [
        MeasuredPart(young * shapes[0], law, young, tables["extension"]),
        MeasuredPart(shear * shapes[1], (), shear, tables["shear"]),
    ]


def without_measured(parts: Sequence[MeasuredPart], section: Sequence[Floats]) -> list[Floats]:
    """Return what to add to the matrices of the sections ``(points, 6, 6)`` so that measured parts are no more in them.

    Args:
        section: those of every coefficient: stiffness, viscosity, inertia (none) and branches.
    """
    changes = []
    for k, matrices in enumerate(section):
        replaced = np.zeros_like(matrices)
        for part in parts:
            if part.replaced:
                replaced += part.replaced[k]
        # what is left of nothing else is round-off
        alone = np.abs(matrices - replaced) <= ROUND_OFF * np.abs(replaced)
        changes.append(np.where(alone, -matrices, -replaced))
    return changes


def of_law_in_place(model: ModelDescription, low: float, high: float) -> list[str]:
    """Say of which materials a law stands in place of what was measured, and by how much it differs.

    Args:
        model: with the materials; low, high: frequencies [Hz] between which they are compared, within the table.
    """
    found: dict[int, tuple[Material, list[str]]] = {}
    for name, rod in model.rods.items():
        for s in np.linspace(0.0, rod.length, 9):
            for material, _, _ in rod.materials_at(float(s)):
                if (
                    _over_frequency(material)
                    and name not in found.setdefault(id(material), (material, []))[1]
                ):
                    found[id(material)][1].append(name)
    sentences = []
    for material, names in found.values():
        table = isinstance(material.damping, ComplexModuli)
        apart = _law_apart(material, low, high)
        compared = (
            "was not compared, no frequency of these motions is in the table"
            if apart is None
            else f"differs by up to {apart:.2g} of it from {low:.5g} to {high:.5g} Hz"
        )
        fitted, itself = ("table", "the table itself") if table else ("loss factor", "it as it is")
        sentences.append(
            f"{', '.join(names)}: motions take the law that was fitted to the {fitted}, whose complex modulus "
            f"{compared}; frequency responses take {itself}"
        )
    return sentences


def _law_apart(material: Material, low: float, high: float) -> float | None:
    """Return the largest difference of the law's complex modulus from the measured one, as a part of it."""
    damping = material.damping
    known: dict[str, TableModulus | ConstantModulus]
    if isinstance(damping, ComplexModuli):
        known = {
            strain: TableModulus(table, material.shift_factor) for strain, table in damping.tables.items()
        }
    else:
        assert isinstance(damping, LossFactor)
        moduli = damping.constant_moduli(material.given_moduli)
        assert moduli is not None
        known = dict(zip(("extension", "shear"), map(ConstantModulus, moduli), strict=True))
    worst: list[float] = []
    for strain, modulus in known.items():
        first, last = modulus.band or (low, high)
        if max(low, first) > min(high, last):
            continue
        for hertz in np.geomspace(max(low, first), min(high, last), 9):
            omega = 2.0 * np.pi * float(hertz)
            measured = modulus.at(omega)
            worst.append(abs(_by_law(material, strain, omega) - measured) / abs(measured))
    return max(worst) if worst else None


def _by_law(material: Material, strain: str, omega: float) -> complex:
    """Return the complex modulus [Pa] of the law with which motions are computed."""
    extends = strain == "extension"
    rest = material.youngs_modulus if extends else material.shear_modulus
    if not material.branches:
        return complex(
            rest, omega * (material.extensional_viscosity if extends else material.shear_viscosity)
        )
    found = complex(rest)
    for b in material.branches:
        swing = 1j * omega * b.time
        found += (b.youngs_modulus if extends else b.shear_modulus) * swing / (1.0 + swing)
    return found
