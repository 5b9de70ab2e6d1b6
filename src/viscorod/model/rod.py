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
from viscorod.model.cable import with_direction
from viscorod.model.centrelines.centreline import Centreline, Twist
from viscorod.model.centrelines.line_shapes import Arc, Helix, Straight
from viscorod.model.centrelines.parametric_lines import ParametricCurve, ThroughPoints
from viscorod.model.centrelines.tilt import Tilt, tilts
from viscorod.model.centrelines.tilt import tilt as as_tilt
from viscorod.model.fields.definition import Definition
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import Flag, OptionalDirection, choose
from viscorod.model.materials.material import Material
from viscorod.model.rod_checks import material_value, require_consistent, twist_value, whole_or_auto
from viscorod.model.rod_sections import assumptions_of, kinks_of, mass_of
from viscorod.model.rod_turning import turning_along
from viscorod.model.sections.curved_section import curved_branches, curved_matrices, curved_parts
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.section_base import AnySection, Branches, Matrices
from viscorod.model.sections.section_laws import section_law
from viscorod.model.sections.section_profile import (
    Piecewise,
    SectionProfile,
    one_of_sections,
    section_profile,
)
from viscorod.model.sections.section_stations import Stations
from viscorod.model.sections.taper import Taper
from viscorod.model.strain_constraints import constrained_strains, constraint_words
from viscorod.quantity_text import quantity
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


class Rod(AlongCurves, Definition):
    """A rod in its reference shape, where it is free of stress.

    What the section's axes are without `d1` is said in `Centreline.frames`.
    """

    centreline: Annotated[Centreline, choose("shape", CENTRELINES)] = Key(
        "the curve of the section's centres"
    )
    section: Annotated[SectionProfile, section_profile] = Key("a section, `Piecewise`, `Taper` or `Stations`")
    material: Annotated[Material | None, material_value] = Key(
        "for sections given by their shape; stiffness and composite sections take none", default=None
    )
    elements: Annotated[int | None, whole_or_auto(MOST_ELEMENTS)] = Key(
        "number of elements, 1 to 100 000; left out, the program chooses", default=None
    )
    order: Annotated[int | None, whole_or_auto(HIGHEST_ORDER)] = Key(
        "of the elements' polynomials, 1 to 12; left out, the program chooses", default=None
    )
    d1: OptionalDirection = Key(
        "direction of the section's first axis at the start, global axes", default=None
    )
    twist: Annotated[Twist, twist_value] = Key(
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
        yield f"{type(self.centreline).__name__} of {quantity(self.length, 'm')}"
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
        return mass_of(self)

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
        return kinks_of(self)

    @property
    def turn(self) -> Twist:
        """The twist, of the rod or of the stations of its section."""
        return (isinstance(self.section, Stations) and self.section.twist) or self.twist

    def section_at(self, s: float) -> AnySection:
        """Return the section at the arc length `s`; where it jumps, the one that starts there."""
        if isinstance(self.section, Piecewise | Stations):
            return self.section.at(s)
        if isinstance(self.section, Taper):
            return self.section.at(min(max(s / self.length, 0.0), 1.0))
        if isinstance(self.section, AnySection):
            return self.section
        return returned(
            self.section,
            s,
            check=one_of_sections,
            name="the function of the section",
            where=f"at s = {s:.6g} m",
            instead="make it return a section, such as Rectangle(0.02, 0.01), everywhere on the rod",
            at=("section",),
        )

    def _made_of(self, s: float) -> tuple[AnySection, Material | None]:
        """Return the section at the arc length `s`, and the material if it needs one."""
        section = self.section_at(s)
        return section, self.material if section.needs_material else None

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
        section, material = self._made_of(s)
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
        section, material = self._made_of(s)
        return section.heat_capacity(material)

    @property
    def assumptions(self) -> list[str]:
        """What is assumed of its sections and material, one sentence each."""
        return assumptions_of(self)

    @property
    def is_cable(self) -> bool:
        """Whether a section bends and twists at no cost."""
        return any(
            not section.matrices(self.material if section.needs_material else None)[0][3:].any()
            for _, section in self.typical_sections()
        )

    def branches_at(self, s: float) -> Branches:
        """Return Maxwell branches of the section at the arc length `s`: times (n,), s, and stiffnesses (n, 6, 6)."""
        section, material = self._made_of(s)
        branches = section.branch_matrices(material)
        if self.curvature_correction:
            return curved_branches(branches, section, material, self.curvature_at(s))
        return branches

    def materials_at(self, s: float) -> list[tuple[Material, Floats, Floats]]:
        """Return every material of the section at the arc length `s` with its C_E and C_G (6, 6).

        The stiffness is the sum of ``E C_E + G C_G``; nothing of a section that is given by numbers.
        """
        section, material = self._made_of(s)
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
