"""Base classes of rigid bodies."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self, TypeAlias

import numpy as np
from pydantic import model_validator

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    TRIPLE,
    OptionalPositive,
    Triple,
    Vector,
    entries,
    name_of_part,
    vector,
)
from viscorod.typing import Floats

__all__ = ["AnyBody", "Shaped"]

Points: TypeAlias = Mapping[str, Triple]


@accepts({"type": "object", "additionalProperties": TRIPLE}, "table from names to 3 numbers each")
def named_points(value: Any) -> dict[str, Triple]:
    """Check a table from names to positions."""
    if not isinstance(value, Mapping):
        raise RefusedError(
            "a table of named points is needed here", "give a table such as { corner = [0.1, 0.0, 0.0] }"
        )
    return entries(value, name_of_part, vector)


AXES = "of the body: directions x and y, perpendicular, global components (z = x cross y)"


class AnyBody(Definition):
    """A rigid body: mass, inertia about the mass centre, and named points for joints and attachments."""

    tag: ClassVar[str | None] = "shape"

    centre: Vector = Key(
        "position of the mass centre in the reference shape", "m", default=(0.0, 0.0, 0.0), kw_only=True
    )
    points: Annotated[Points, named_points] = Key(
        "names and positions of further points in the reference shape", "m", default={}, kw_only=True
    )

    @abstractmethod
    def total_mass(self) -> float:
        """Return the mass, kg."""

    @abstractmethod
    def inertia_matrix(self) -> Floats:
        """Return the inertia (3, 3) about the mass centre along the body's axes, kg m^2."""

    def frame(self) -> Floats:
        """Return the body's axes (3, 3) in the reference shape, columns, global components."""
        return np.eye(3)

    def mass_matrix(self) -> Floats:
        """Return [[m 1, 0], [0, J]] (6, 6) for velocities (m/s, rad/s) along the body's axes; kg, kg m^2."""
        matrix = np.zeros((6, 6))
        matrix[:3, :3] = self.total_mass() * np.eye(3)
        matrix[3:, 3:] = self.inertia_matrix()
        return matrix

    def position(self, point: str | None = None) -> Floats:
        """Return the position (3,) of a named point, or of the mass centre, in the reference shape, m."""
        return np.array(self.centre if point is None else self.points[point])


class Shaped(AnyBody):
    """A body of a shape, with a mass or a density."""

    density: OptionalPositive = Key("{}; this or the mass", "kg/m^3", default=None, kw_only=True)
    mass: OptionalPositive = Key("", "kg", default=None, kw_only=True)

    @abstractmethod
    def volume(self) -> float:
        """Return the volume, m^3."""

    @abstractmethod
    def gyration(self) -> Triple:
        """Return the inertia about the three axes per mass, m^2."""

    def total_mass(self) -> float:
        """Return the given mass, or density times volume, kg."""
        if self.mass is not None:
            return self.mass
        return (self.density or 0.0) * self.volume()

    def inertia_matrix(self) -> Floats:
        """Evaluate the formula of the solid (3, 3), kg m^2, along its own axes."""
        return np.diag(self.gyration()) * self.total_mass()

    @model_validator(mode="after")
    def _one_mass(self) -> Self:
        if (self.mass is None) == (self.density is None):
            raise RefusedError(
                "a body of a shape has either a density or a mass",
                "give density (kg/m^3) or mass (kg)",
                found="" if self.mass is None else "both",
                at=("density",),
            )
        values = np.diag(self.mass_matrix())
        if not (np.isfinite(values) & (values > 0.0)).all():
            raise RefusedError(
                "its mass or inertia is not a positive number in double precision",
                "give dimensions, density and mass in SI units",
                found=f"{values.min():.6g}",
            )
        return self
