"""Numbers of a model that are allowed, but more likely given in another unit than in the one they are read in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from viscorod.model.centrelines.line_shapes import Arc
from viscorod.model.description.model_description import ModelDescription
from viscorod.model.fields.definition import some_of
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.loss_factor import LossFactor
from viscorod.model.materials.material import Material

__all__ = ["doubtful_numbers"]

FASTEST = 2.0e4
"""Speed [m/s] of waves of stretch that no solid reaches: in diamond it is 1.8e4."""
THINNEST = 1e-3
"""Density [kg/m3] that no solid has, but steel has it in t/mm3."""
GRAMS = "a density in g/cm3 is to be multiplied by 1000"
SOFT = ((100.0, 1e3), (3000.0, 1e7))
"""Densities [kg/m3], and Young's moduli [Pa] below which no solid of at least this density is: gels begin at 1e3 Pa
with the density of water, and what is heavier than stone is a metal or a rubber full of one."""
LOSSY = 3.0
"""Loss factor that no material has: the best dampers reach 2 in the middle of their glass transition."""

KELVIN = 273.15
"""0 degrees C in K."""
WARM = 200.0
"""Temperature from which on, if it is a whole number of degrees C beside the digits of 273.15 K, it is one in K."""
FAR_FROM_TABLE = 10.0
"""Times by which a modulus that is given may be outside of its own table of moduli: glass over rubber is more."""


def doubtful_numbers(model: ModelDescription) -> list[str]:
    """Return what looks as if it were given in another unit: elastic constants, loss factors, temperatures, angles."""
    users: dict[str, list[str]] = {}
    for name, rod in model.rods.items():
        texts = [] if rod.material is None else list(_of_material(rod.material))
        for text in (*texts, *_of_line(rod.centreline)):
            users.setdefault(text, []).append(name)
    return [
        f"{'rod' if len(names) == 1 else 'rods'} {some_of(names)}: {text}" for text, names in users.items()
    ]


def _of_material(material: Material) -> Iterator[str]:
    density, modulus = material.density, material.youngs_modulus
    if material.has_density:
        speed = float(np.sqrt(modulus / density))
        given = f"Young's modulus {modulus:.4g} Pa and density {density:.4g} kg/m3"
        if speed > FASTEST:
            advice = (
                "1 t/mm3 is 1e12 kg/m3, 1 MPa is 1e6 Pa and 1 mm is 1e-3 m" if density < THINNEST else GRAMS
            )
            yield (
                f"{given} make waves of stretch of {speed / 1e3:.3g} km/s, faster than in any solid (18 km/s in "
                f"diamond); {advice}"
            )
        elif any(density >= heavy and modulus < soft for heavy, soft in SOFT):
            yield f"{given} are those of no solid, which is much stiffer; 1 MPa is 1e6 Pa and 1 GPa is 1e9 Pa"
    damping = material.damping
    yield from _in_kelvin(material)
    if isinstance(damping, ComplexModuli):
        for strain, table in damping.tables.items():
            word, mine = (
                ("Young's modulus", modulus)
                if strain == "extension"
                else ("shear modulus", material.shear_modulus)
            )
            low, high = float(table.storage.min()), float(table.storage.max())
            if not low / FAR_FROM_TABLE <= mine <= high * FAR_FROM_TABLE:
                yield (
                    f"its {word}, {mine:.4g} Pa, is far from its own table of {strain}, {low:.4g} to {high:.4g} Pa; "
                    "1 MPa is 1e6 Pa, and without youngs_modulus the table gives it"
                )
    if isinstance(damping, LossFactor):
        for name in ("extension", "shear", "bulk"):
            largest = max(_numbers(getattr(damping, name)), default=0.0)
            if largest > LOSSY:
                yield f"a loss factor of {largest:.4g} in {name} is that of no material; 1 % is 0.01"


def _in_kelvin(material: Material) -> Iterator[str]:
    """Yield which temperatures look as if they were given in K."""
    given = {
        "temperature": material.temperature,
        "shift.reference": getattr(material.shift, "reference", None),
        "damping.temperature": getattr(material.damping, "temperature", None),
    }
    for key, value in given.items():
        if isinstance(value, float) and value > WARM:
            celsius = value - KELVIN
            if abs(celsius - round(celsius)) < 1e-6:
                yield (
                    f"{key} = {value:.6g} is read in degrees C; if it is {value:.6g} K, give {round(celsius)} degrees C"
                )


def _numbers(value: float | Sequence[float] | None) -> Iterable[float]:
    if value is None:
        return ()
    return value if isinstance(value, Sequence) else (value,)


def _of_line(line: object) -> Iterator[str]:
    if isinstance(line, Arc) and line.angle > 2.0 * np.pi * (1.0 + 1e-9):
        yield (
            f"its arc of {line.angle:.6g} rad goes round {line.angle / (2.0 * np.pi):.3g} times upon itself; "
            f"{line.angle:.6g} degrees are {np.radians(line.angle):.4g} rad, and a coil is a helix"
        )
