"""Checks of a rod: values of its fields, sections with their material, its end, what double precision can hold."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.limits import LARGEST_NUMBER, SMALLEST_NUMBER
from viscorod.model.cable import with_direction
from viscorod.model.centrelines.centreline import Twist
from viscorod.model.centrelines.line_shapes import Straight
from viscorod.model.fields.forms import named_or, quantity
from viscorod.model.fields.metadata import Check, accepts
from viscorod.model.fields.values import number, whole_number
from viscorod.model.materials.material import Material
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_profile import Piecewise
from viscorod.model.sections.section_stations import Stations
from viscorod.wording import RefusedError, show

if TYPE_CHECKING:
    from viscorod.model.rod import Rod

__all__ = ["material_value", "reaching_centre", "require_consistent", "twist_value", "whole_or_auto"]

LOOKED_AT = 65
"""Stations at which the curvature of a reference shape is compared with its section."""
ROUNDED = 1e-3
"""How far the last station may be from the end of its rod, as a part of the length: tables are rounded."""


@accepts(named_or("material"), "name of a material in quotes, or a table")
def material_value(value: Any) -> Material | None:
    """Return `value` as a material."""
    return value if value is None or isinstance(value, Material) else Material.model_validate(value)


@accepts(quantity(), "number", "or a function of the arc length")
def twist_value(value: Any) -> Twist:
    """Return `value` as a twist: a number, or a function of the arc length."""
    return value if callable(value) else number(value)


def whole_or_auto(high: int) -> Check[int | None]:
    """Return a check for whole numbers from 1 to `high`, or "auto", which is None."""
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


def require_consistent(rod: Rod) -> None:
    """Refuse a rod whose parts do not fit together.

    Raises:
        RefusedError: a section without its material, or one that cannot be used.
    """
    _finite(rod)
    if isinstance(rod.section, Piecewise):
        _pieces_cover_length(rod, rod.section)
    if isinstance(rod.section, Stations):
        _stations_cover_length(rod, rod.section)
    sections = rod.typical_sections()
    reasons = [section.no_material for _, section in sections]
    if rod.material is not None and None not in reasons:
        raise RefusedError(
            reasons[0] or "",
            "leave material out",
            found="",
            at=("material",),
        )
    if rod.material is None and None in reasons:
        raise RefusedError(
            "a section given by its shape needs a material for its stiffness and mass",
            "add material",
            found="",
            at=("material",),
        )
    for s, section in sections:
        _usable(rod, s, section)
        if rod.curvature_correction and not section.outline:
            raise RefusedError(
                f"the curvature of {type(section).__name__} cannot be counted: its points are not known",
                "describe the section by its shape, or leave curvature_correction out",
                at=("curvature_correction",),
            )
    if rod.curvature_correction and rod.tilted:
        raise RefusedError(
            "the curvature of a rod with oblique sections cannot be counted",
            "leave tilt or curvature_correction out",
            found="true",
            at=("curvature_correction",),
        )
    if rod.curvature_correction:
        _inside_the_curve(rod)


def reaching_centre(rod: Rod) -> tuple[float, float] | None:
    """Return where the section of a rod first reaches to the centre of curvature, and how far away that is, in m.

    None where it does nowhere, or the points of the section are not known.
    """
    if isinstance(rod.centreline, Straight):
        return None
    stations = np.linspace(0.0, rod.length, LOOKED_AT)
    bent = np.linalg.norm(rod.centreline.curvature(stations), axis=1)
    for s in stations[bent * _half_width(rod) >= 1.0].tolist():
        outline = rod.section_at(s).outline
        corners = np.array([corner for outer, _ in outline for corner in outer]).reshape(-1, 2)
        about = rod.curvature_at(s)
        if not (1.0 + corners[:, 1] * about[0] - corners[:, 0] * about[1] > 0.0).all():
            return s, float(1.0 / np.linalg.norm(about))
    return None


def _half_width(rod: Rod) -> float:
    """Return the largest half width of the sections, m, as far as they are known."""
    return max(section.half_width or 0.0 for _, section in rod.typical_sections())


def _inside_the_curve(rod: Rod) -> None:
    """Refuse sections that reach to the centre of curvature."""
    found = reaching_centre(rod)
    if found is not None:
        s, radius = found
        raise RefusedError(
            f"its section reaches to the centre of curvature at s = {s:.6g} m",
            "make the section thinner or the radius larger",
            at=("section",),
            found=f"radius {radius:.6g} m",
        )


def _finite(rod: Rod) -> None:
    with np.errstate(all="ignore"):
        shape = np.concatenate([array.ravel() for array in rod.frames([0.0, rod.length])])
    if not (SMALLEST_NUMBER <= rod.length <= LARGEST_NUMBER and np.isfinite(shape).all()):
        raise RefusedError(
            f"the rod has the length {rod.length:g} m and no usable shape in double precision",
            "give lengths of a usual size in m",
            found="",
        )


def _pieces_cover_length(rod: Rod, section: Piecewise) -> None:
    last = section.pieces[-1].until
    if abs(last - rod.length) > 1e-9 * rod.length:
        raise RefusedError(
            f"the last piece must end at the end of the rod, {rod.length:.12g} m",
            f"give until = {rod.length:.12g} in the last piece",
            found=show(last),
            at=("section", "pieces", len(section.pieces) - 1, "until"),
        )


def _stations_cover_length(rod: Rod, section: Stations) -> None:
    last = section.given[-1].at
    if abs(last - rod.length) > ROUNDED * rod.length:
        raise RefusedError(
            f"the last station must be the end of the rod, {rod.length:.12g} m",
            f"let the stations end at {rod.length:.12g} m, or give the rod a length of {last:.12g} m",
            found=f"{last:.12g} m",
            at=("section", "stations", len(section.given) - 1, "at")
            if section.file is None
            else ("section", "file"),
        )
    if section.twist is not None and rod.twist != 0.0:
        raise RefusedError(
            "the twist is given twice, by the stations and for the rod",
            "give it once",
            found="a function" if callable(rod.twist) else show(rod.twist),
            at=("twist",),
        )


def _usable(rod: Rod, s: float, section: AnySection) -> None:
    """Refuse sections whose stiffness or mass is not a positive number in double precision."""
    material = rod.material if section.needs_material else None
    try:
        with np.errstate(all="ignore"):
            if material is not None and material.pending:
                stiffness, damping, inertia = section.matrices(material.with_damping(None))
            elif rod.uniform:  # which keeps them
                stiffness, damping, inertia = rod.matrices_at(s)
            else:
                stiffness, damping, inertia = section.matrices(material)
    except (OverflowError, ZeroDivisionError):
        stiffness = damping = inertia = np.full((6, 6), math.nan)
    except InputError as error:
        raise RefusedError(str(error)) from None
    stiffness, inertia = with_direction(stiffness, inertia, rod.length)
    diagonal = np.concatenate([np.diag(stiffness), np.diag(inertia)])
    usual = (diagonal >= SMALLEST_NUMBER) & (diagonal <= LARGEST_NUMBER)
    if not np.isfinite(damping).all() or not usual.all():
        entry = int(np.argmin(np.where(np.isfinite(diagonal), diagonal, -math.inf)))
        raise RefusedError(
            f"its stiffness or mass per length is not a positive number at s = {s:.6g} m, "
            f"or beyond any quantity in SI units",
            "give dimensions and moduli in SI units; for a very flat ellipse also shear_factor_1 and _2",
            found=f"{diagonal[entry]:.6g} for {type(section).__name__}",
            at=("section",),
        )
