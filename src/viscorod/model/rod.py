"""Rods: a centre line, sections along it, a material, and the division into elements."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from viscorod.errors import Fault, InputError
from viscorod.given_as import GivenAs, Words
from viscorod.model.along_curves import AlongCurves
from viscorod.model.cable import GYRATION, SLACK, with_direction
from viscorod.model.centrelines.centreline import Centreline, Twist
from viscorod.model.centrelines.line_shapes import Arc, Helix, Straight
from viscorod.model.centrelines.parametric_lines import ParametricCurve, ThroughPoints
from viscorod.model.centrelines.tilt import Tilt, tilts
from viscorod.model.centrelines.tilt import tilt as as_tilt
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import named_or, quantity
from viscorod.model.fields.metadata import Check, Key, accepts
from viscorod.model.fields.values import Flag, OptionalDirection, choose, number, whole_number
from viscorod.model.materials.material import Material
from viscorod.model.rod_checks import require_consistent
from viscorod.model.rod_turning import turning_along
from viscorod.model.sections.curved_section import curved_branches, curved_matrices, curved_parts
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.section_base import AnySection, Branches, Matrices
from viscorod.model.sections.section_kinks import SAMPLES as MANY_SAMPLES
from viscorod.model.sections.section_kinks import kinks
from viscorod.model.sections.section_laws import section_law
from viscorod.model.sections.section_profile import Piecewise, SectionProfile, section_profile
from viscorod.model.sections.section_stations import Stations
from viscorod.model.sections.taper import Taper
from viscorod.model.strain_constraints import constrained_strains, constraint_words
from viscorod.small_drawing import Drawing, on_paper
from viscorod.typing import Floats

__all__ = ["CENTRELINES", "Rod"]

CENTRELINES: dict[str, type[Definition]] = {
    "straight": Straight,
    "arc": Arc,
    "helix": Helix,
    "points": ThroughPoints,
    "curve": ParametricCurve,
}
"""The centre lines by their word in a case file; a new one is one class and one line here."""

MOST_ELEMENTS = 100_000
HIGHEST_ORDER = 12
DEFAULT_ORDER = 5
TURN_PER_NODE = 2.0 * math.pi / 15.0
"""Bending and twisting of the reference shape from node to node: an element of the default order, which turns by a
third of a circle then, follows it to 4e-7 of its length."""
NODES_PER_ROD = 10
DRAWN = 120
"""Points of a small drawing."""
END = 1e-9
"""How far from the end of a rod, as a part of its length, what is there counts as the end."""
FEW_SAMPLES = 32
"""Intervals in which kinks of sections are sought that need a mesh of their own at every station."""


@accepts(named_or("material"), "name of a material in quotes, or a table")
def _material(value: Any) -> Material | None:
    return value if value is None or isinstance(value, Material) else Material.model_validate(value)


@accepts(quantity(), "number", "or a function of the arc length")
def _twist(value: Any) -> Twist:
    return value if callable(value) else number(value)


def _whole_or_auto(high: int) -> Check[int | None]:
    check = whole_number(1, high)

    @accepts({"anyOf": [check.form, {"const": "auto"}]}, f'{check.words}, or `"auto"`')
    def parse(value: Any) -> int | None:
        if value is None or value == "auto":
            return None
        try:
            return check(value)
        except RefusedError as error:
            raise RefusedError(error.why, f"{error.instead}, or 'auto'") from None

    return parse


class Rod(AlongCurves, Definition):
    """A rod in its reference shape, where it is free of stress.

    What the section's axes are without `d1` is said in `Centreline.frames`.
    """

    centreline: Annotated[Centreline, choose("shape", CENTRELINES)] = Key(
        "the curve of the section's centres"
    )
    section: Annotated[SectionProfile, section_profile] = Key("a section, `Piecewise`, `Taper` or `Stations`")
    material: Annotated[Material | None, _material] = Key(
        "for sections given by their shape; stiffness and composite sections take none", default=None
    )
    elements: Annotated[int | None, _whole_or_auto(MOST_ELEMENTS)] = Key(
        "number of elements, 1 to 100 000; left out, the program chooses", default=None
    )
    order: Annotated[int | None, _whole_or_auto(HIGHEST_ORDER)] = Key(
        "of the elements' polynomials, 1 to 12; left out, the program chooses", default=None
    )
    d1: OptionalDirection = Key(
        "direction of the section's first axis at the start, global axes", default=None
    )
    twist: Annotated[Twist, _twist] = Key(
        "angle of the section about d3 relative to the rotation-minimising frame: the total, growing "
        "evenly from start to end; {}",
        "rad",
        default=0.0,
    )
    constraints: Annotated[GivenAs[tuple[str, ...], Words], constraint_words] = Key(
        'strains that keep their reference values at all times: "unshearable" (both shears), '
        '"inextensible" (the stretch), "kirchhoff" (all three), or a list of these and of the strain '
        "words shear_1, shear_2, stretch, bend_1, bend_2, twist",
        default=(),
    )
    law: Annotated[AnySectionLaw | None, section_law] = Key(
        "law of the section forces beside those of stiffness and damping", default=None
    )
    tilt: Annotated[Tilt, as_tilt] = Key(
        "rotation of the sections from the frame whose d3 is the tangent, for oblique ones: a rotation vector along "
        "d1, d2, d3; {}",
        "rad",
        default=(0.0, 0.0, 0.0),
    )
    curvature_correction: Flag = Key(
        "count that fibres inside a curved reference shape are shorter than outside (J0), in stretch, bending and "
        "inertia; for sections of a known shape",
        default=False,
    )

    @classmethod
    def _along(cls, kind: type[Centreline], curve: dict[str, Any], given: dict[str, Any]) -> Self:
        return cls(kind(**curve), **{name: given[name] for name in cls.model_fields if name != "centreline"})

    def _facts(self) -> Iterator[str]:
        yield f"{type(self.centreline).__name__} of {self.length:.6g} m"
        if isinstance(self.section, AnySection):
            yield repr(self.section)
        else:
            changing = type(self.section).__name__ if isinstance(self.section, Definition) else "a function"
            yield f"section that changes: {changing}"
        if self.material is not None:
            yield repr(self.material)
        if self.constraints:
            yield ", ".join(self.constraints)
        yield f"{self.elements} elements" if self.elements else "elements chosen by the program"

    def _drawing(self) -> str:
        points = self.frames(np.linspace(0.0, self.length, DRAWN))[0]
        drawing = Drawing()
        drawing.line(on_paper([points])[0])
        return drawing.svg()

    @property
    def length(self) -> float:
        """Arc length, m."""
        return self.centreline.length

    @property
    def mass(self) -> float:
        """Mass, kg: the integral of the sections' mass per length; by 16 Gauss points where a section varies."""
        if not self.has_inertia:
            raise InputError(
                Fault(
                    "mass",
                    "",
                    "a material was given without density, or a section without inertia",
                    "give the density (kg/m^3), or the section's inertia, mass per length first",
                )
            )
        if self.material is not None and self.material.pending:
            return self.replaced(material=self.material.with_damping(None)).mass
        if self.uniform:
            return self.length * float(self.matrices_at(0.0)[2][0, 0])
        points, weights = np.polynomial.legendre.leggauss(1 if isinstance(self.section, Piecewise) else 16)
        ends = np.array([0.0, *sorted({*self.section_breaks, *self.kinks}), self.length])
        middles, halves = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
        return float(
            sum(
                half * weight * self.matrices_at(middle + half * point)[2][0, 0]
                for middle, half in zip(middles, halves, strict=True)
                for point, weight in zip(points, weights, strict=True)
            )
        )

    @property
    def has_inertia(self) -> bool:
        """Whether the inertia of all its sections is known."""
        dense = self.material is None or self.material.has_density
        return dense and all(section.has_inertia for _, section in self.typical_sections())

    @property
    def constrained_strains(self) -> tuple[bool, ...]:
        """For shear 1, shear 2, stretch, bend 1, bend 2, twist: whether the strain keeps its reference value."""
        return constrained_strains(self.constraints)

    @property
    def viscous(self) -> bool:
        """Whether any section has dashpots of Kelvin and Voigt, or will have."""
        pending = self.material is not None and self.material.pending
        return pending or any(self.matrices_at(s)[1].any() for s, _ in self.typical_sections())

    @property
    def relaxing(self) -> bool:
        """Whether any section has Maxwell branches."""
        return any(len(self.branches_at(s)[0]) for s, _ in self.typical_sections())

    @property
    def section_breaks(self) -> tuple[float, ...]:
        """Interior stations where the section jumps, m."""
        if isinstance(self.section, Stations):
            return self.section.breaks
        if not isinstance(self.section, Piecewise):
            return ()
        return tuple(piece.until for piece in self.section.pieces[:-1])

    @cached_property
    def kinks(self) -> tuple[float, ...]:
        """Interior stations where the section or the twist has a kink, or a function of these jumps, m.

        A function that knows them says so by an attribute `stations` (m); others are sampled.
        """
        found: list[float] = []
        if isinstance(self.section, Stations):
            found += [station.at for station in self.section.given]
        elif callable(self.section):
            known = getattr(self.section, "stations", None)
            costly = not self.section_at(0.0).can_taper
            samples = FEW_SAMPLES if costly else MANY_SAMPLES
            found += kinks(self._section_values, self.length, samples) if known is None else list(known)
        twist = self.turn
        if callable(twist):
            known = getattr(twist, "stations", None)
            found += kinks(lambda s: np.array([twist(s)]), self.length) if known is None else list(known)
        inner = {s for s in found if 0.0 < s < self.length * (1.0 - END)} - {*self.section_breaks}
        return tuple(sorted(inner))

    @property
    def turn(self) -> Twist:
        """The twist, of the rod or of the stations of its section."""
        return (isinstance(self.section, Stations) and self.section.twist) or self.twist

    def _section_values(self, s: float) -> Floats:
        """Return stiffness and inertia of the section at the arc length `s` as one array (72,)."""
        section = self.section_at(s)
        material = self.material if section.needs_material else None
        if material is not None and material.pending:
            material = material.with_damping(None)
        stiffness, _, inertia = section.matrices(material)
        return np.concatenate([stiffness.ravel(), inertia.ravel()])

    def section_at(self, s: float) -> AnySection:
        """Return the section at the arc length `s`; where it jumps, the one that starts there."""
        if isinstance(self.section, Piecewise | Stations):
            return self.section.at(s)
        if isinstance(self.section, Taper):
            return self.section.at(min(max(s / self.length, 0.0), 1.0))
        if isinstance(self.section, AnySection):
            return self.section
        section = self.section(s)
        if not isinstance(section, AnySection):
            raise RefusedError(
                f"the function of the section returned no section at s = {s:.6g}",
                "return one",
                found=show(section),
            )
        return section

    def matrices_at(self, s: float) -> Matrices:
        """Return stiffness C, damping D and inertia M per length (6, 6) of the section at the arc length `s`."""
        if self.uniform:
            stiffness, damping, inertia = self._uniform_matrices
            return stiffness.copy(), damping.copy(), inertia.copy()
        return self._matrices_at(s)

    @cached_property
    def _uniform_matrices(self) -> Matrices:
        """What :meth:`matrices_at` returns anywhere on a uniform rod."""
        return self._matrices_at(0.0)

    def _matrices_at(self, s: float) -> Matrices:
        section = self.section_at(s)
        material = self.material if section.needs_material else None
        matrices = section.matrices(material)
        if self.curvature_correction:
            matrices = curved_matrices(matrices, section, material, self.curvature_at(s))
        stiffness, damping, inertia = matrices
        stiffness, inertia = with_direction(stiffness, inertia, self.length)
        return stiffness, damping, inertia

    def curvature_at(self, s: float) -> Floats:
        """Return bend_1 and bend_2 of the reference shape (2,) at the arc length `s`, 1/m."""
        k = self.centreline.curvature(np.array([s]))[0]
        frame = self.frames([s])[1][0]
        return np.array([-k @ frame[:, 1], k @ frame[:, 0]])

    @property
    def uniform(self) -> bool:
        """Whether all its sections have the same matrices."""
        return isinstance(self.section, AnySection) and not self.curvature_correction

    def heat_capacity_at(self, s: float) -> float | None:
        """Return the heat capacity per length at the arc length `s`, J/(m K); None where it is not known."""
        section = self.section_at(s)
        return section.heat_capacity(self.material if section.needs_material else None)

    @property
    def assumptions(self) -> list[str]:
        """What is assumed of its sections and material, one sentence each."""
        materials = [] if self.material is None else [self.material]
        for s in (0.0, *self.section_breaks):
            materials += self.section_at(s).materials
        found = list(dict.fromkeys(text for material in materials for text in material.assumptions))
        if self.law is not None:
            found.append(
                f"its sections have the law {type(self.law).__name__}, which times and moduli of the damping leave out"
            )
        if self.is_cable:
            found.append(
                f"a cable, which bends and twists at no cost: {SLACK:g} of its axial stiffness times length squared "
                f"gives its sections a direction, {GYRATION**2:g} one about its axis, and their radius of gyration is "
                f"{GYRATION:g} of its length"
            )
        return found

    @property
    def is_cable(self) -> bool:
        """Whether a section bends and twists at no cost."""
        return any(
            not section.matrices(self.material if section.needs_material else None)[0][3:].any()
            for _, section in self.typical_sections()
        )

    def branches_at(self, s: float) -> Branches:
        """Return Maxwell branches of the section at the arc length `s`: times (n,), s, and stiffnesses (n, 6, 6)."""
        section = self.section_at(s)
        material = self.material if section.needs_material else None
        branches = section.branch_matrices(material)
        if self.curvature_correction:
            return curved_branches(branches, section, material, self.curvature_at(s))
        return branches

    def materials_at(self, s: float) -> list[tuple[Material, Floats, Floats]]:
        """Return every material of the section at the arc length `s` with its C_E and C_G (6, 6).

        The stiffness is the sum of ``E C_E + G C_G``; nothing of a section that is given by numbers.
        """
        section = self.section_at(s)
        material = self.material if section.needs_material else None
        parts = section.by_material(material)
        if parts and self.curvature_correction:
            return curved_parts(parts, section, material, self.curvature_at(s))
        return parts

    def frames(self, s: Floats | Sequence[float]) -> tuple[Floats, Floats]:
        """Return positions (n, 3) and frames (n, 3, 3; columns d1, d2, d3) of the reference shape, global axes."""
        position, frames = self.centreline.frames(s, self.d1, self.turn)
        if self.tilted:
            frames = frames @ tilts(self.tilt, np.atleast_1d(np.asarray(s, dtype=float)))
        return position, frames

    @property
    def tilted(self) -> bool:
        """Whether sections are oblique: d3 is not the tangent, or they are turned about it."""
        return callable(self.tilt) or any(self.tilt)

    def chosen_elements(self, start: float, end: float, order: int | None = None) -> int:
        """Return the number of elements chosen from `start` to `end` [m]: by nodes along the rod, and by its turns.

        From node to node the reference shape turns by a fifteenth of a circle then, on average. Elements have the
        rod's order or, if it leaves that to the program, `order`.
        """
        order = self.order or order or DEFAULT_ORDER
        turning = float(np.diff(self.turned([start, end]))[0])
        nodes = NODES_PER_ROD * (end - start) / self.length
        return max(1, math.ceil(turning / (TURN_PER_NODE * order) - 1e-6), round(nodes / order))

    def turned(self, s: Floats | Sequence[float]) -> Floats:
        """Return angles (n,) by which the frame of the reference shape has turned from the start to `s`, rad.

        Bending and twist, whole turns included, all ways added up.
        """
        stations, angles = self._turning
        return np.asarray(np.interp(s, stations, angles))

    @cached_property
    def _turning(self) -> tuple[Floats, Floats]:
        """Stations, and the angles of the frame there."""
        return turning_along(self)

    def typical_sections(self) -> list[tuple[float, AnySection]]:
        """Return representative sections, with a station of each."""
        if isinstance(self.section, Piecewise):
            return [(piece.until - 1e-9 * self.length, piece.section) for piece in self.section.pieces]
        if isinstance(self.section, AnySection):
            return [(0.0, self.section)]
        if isinstance(self.section, Stations):
            return [(station.at, station.section) for station in self.section.given]
        return [(s, self.section_at(s)) for s in np.linspace(0.0, self.length, 5).tolist()]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        require_consistent(self)
        return self

    def to_dict(self) -> dict[str, Any]:
        """Return the rod as a table of the case file: the keys of the centre line beside the others."""
        plain = super().to_dict()
        curve: dict[str, Any] = plain.pop("centreline")
        section = plain.pop("section")
        if isinstance(self.section, Piecewise):
            plain["sections"] = section["pieces"]
        elif isinstance(self.section, Stations):
            plain["sections"] = section
        elif isinstance(self.section, Taper):
            plain["taper"] = section
        else:
            plain["section"] = section
        return curve | plain
