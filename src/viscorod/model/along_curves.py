"""Rods along centre lines of every kind, each by a word of its own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Self, TypeAlias

from viscorod.argument_names import known_arguments
from viscorod.given_as import Amount, Amounts
from viscorod.model.centrelines.centreline import Centreline, Twist
from viscorod.model.centrelines.line_shapes import Arc, Helix, Straight
from viscorod.model.centrelines.parametric_lines import ParametricCurve, ThroughPoints
from viscorod.model.centrelines.tilt import Tilt
from viscorod.model.materials.material import Material
from viscorod.model.sections.law_base import AnySectionLaw
from viscorod.model.sections.section_profile import SectionProfile
from viscorod.typing import Floats

__all__ = ["AlongCurves"]

Point: TypeAlias = Amounts


@known_arguments
class AlongCurves(ABC):
    """Methods that make rods; a part of `Rod`."""

    @classmethod
    def straight(
        cls,
        start: Point,
        end: Point,
        *,
        section: SectionProfile,
        material: Material | None = None,
        elements: int | None = None,
        order: int | None = None,
        d1: Point | None = None,
        twist: Twist = 0.0,
        constraints: str | Sequence[str] = (),
        law: AnySectionLaw | None = None,
        tilt: Tilt = (0.0, 0.0, 0.0),
        curvature_correction: bool = False,
    ) -> Self:
        """Make a straight rod; see `Straight`."""
        return cls._along(Straight, {"start": start, "end": end}, locals())

    @classmethod
    def arc(
        cls,
        start: Point,
        tangent: Point,
        normal: Point,
        radius: Amount,
        angle: Amount,
        *,
        section: SectionProfile,
        material: Material | None = None,
        elements: int | None = None,
        order: int | None = None,
        d1: Point | None = None,
        twist: Twist = 0.0,
        constraints: str | Sequence[str] = (),
        law: AnySectionLaw | None = None,
        tilt: Tilt = (0.0, 0.0, 0.0),
        curvature_correction: bool = False,
    ) -> Self:
        """Make a rod along a circular arc; see `Arc`."""
        given = {"start": start, "tangent": tangent, "normal": normal, "radius": radius, "angle": angle}
        return cls._along(Arc, given, locals())

    @classmethod
    def helix(
        cls,
        radius: Amount,
        pitch: Amount,
        turns: Amount,
        centre: Point = (0.0, 0.0, 0.0),
        axis: Point = (0.0, 0.0, 1.0),
        phase: float = 0.0,
        handedness: str = "right",
        *,
        section: SectionProfile,
        material: Material | None = None,
        elements: int | None = None,
        order: int | None = None,
        d1: Point | None = None,
        twist: Twist = 0.0,
        constraints: str | Sequence[str] = (),
        law: AnySectionLaw | None = None,
        tilt: Tilt = (0.0, 0.0, 0.0),
        curvature_correction: bool = False,
    ) -> Self:
        """Make a rod along a helix; see `Helix`."""
        given = {"radius": radius, "pitch": pitch, "turns": turns, "centre": centre, "axis": axis}
        return cls._along(Helix, {**given, "phase": phase, "handedness": handedness}, locals())

    @classmethod
    def through(
        cls,
        points: Sequence[Point] | None = None,
        *,
        file: str | None = None,
        columns: Sequence[str | int] = (1, 2, 3),
        unit: str | None = None,
        section: SectionProfile,
        material: Material | None = None,
        elements: int | None = None,
        order: int | None = None,
        d1: Point | None = None,
        twist: Twist = 0.0,
        constraints: str | Sequence[str] = (),
        law: AnySectionLaw | None = None,
        tilt: Tilt = (0.0, 0.0, 0.0),
        curvature_correction: bool = False,
    ) -> Self:
        """Make a rod along a smooth curve through points, or those of a file; see `ThroughPoints`."""
        source = {"points": points} if file is None else {"file": file, "columns": columns, "unit": unit}
        given = {"points": points, **source} if points is not None else source
        return cls._along(ThroughPoints, given, locals())

    @classmethod
    def curve(
        cls,
        function: Callable[[float], Sequence[float] | Floats],
        *,
        section: SectionProfile,
        material: Material | None = None,
        elements: int | None = None,
        order: int | None = None,
        d1: Point | None = None,
        twist: Twist = 0.0,
        constraints: str | Sequence[str] = (),
        law: AnySectionLaw | None = None,
        tilt: Tilt = (0.0, 0.0, 0.0),
        curvature_correction: bool = False,
    ) -> Self:
        """Make a rod along a curve given by a function; see `ParametricCurve`."""
        return cls._along(ParametricCurve, {"function": function}, locals())

    @classmethod
    @abstractmethod
    def _along(cls, kind: type[Centreline], curve: dict[str, Any], given: dict[str, Any]) -> Self:
        """Make a rod along a centre line of a kind, with what else is given of a rod."""
