"""Rigid bodies: given by mass and inertia, or by a shape."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from viscorod.model.bodies.body_base import AXES, AnyBody
from viscorod.model.bodies.body_shapes import Box, Cylinder, Sphere
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.directions import OptionalAxes, columns
from viscorod.model.fields.forms import NOT_NEGATIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.symmetry import skew_entry
from viscorod.model.fields.values import TRIPLE, Positive, Triple, choose, each, numbers, sequence, vector
from viscorod.typing import Floats

__all__ = ["BODIES", "Body", "one_body"]

Inertia: TypeAlias = Triple | tuple[Triple, Triple, Triple]
Point: TypeAlias = Sequence[float]
Named: TypeAlias = Mapping[str, Point]

SLACK = 1e-9
"""Part of the largest principal inertia that passes for round-off."""


@accepts(
    {"anyOf": [listed(quantity(bounds=NOT_NEGATIVE), 3, 3), listed(TRIPLE, 3, 3)]},
    "3 numbers >= 0, or 3 rows of 3",
)
def _inertia(value: Any) -> Inertia:
    rows = sequence(value)
    if len(rows) != 3:
        raise RefusedError(
            f"three principal inertias or a 3x3 matrix are needed here, {len(rows)} items were given",
            "give three numbers or three rows of three, kg m^2",
        )
    if not any(isinstance(row, list | tuple | np.ndarray) for row in rows):
        i1, i2, i3 = numbers(rows, count=3)
        return i1, i2, i3
    full = each(rows, vector)
    matrix = np.array(full)
    if (skew := skew_entry(matrix)) is not None:
        i, j = skew
        raise RefusedError(
            "the matrix must be symmetric",
            f"give the same number in row {i + 1}, column {j + 1} and in row {j + 1}, column {i + 1}",
            found=f"{show(full[i][j])} against {show(full[j][i])}",
        )
    first, second, third = (tuple(row) for row in (matrix / 2.0 + matrix.T / 2.0).tolist())
    return first, second, third


class Body(AnyBody):
    """A rigid body given by its mass and its inertia; zeros make it a point mass, one zero a thin rod.

    The turning of a point mass needs an inertia from elsewhere: a rod, or another body, that it is attached to.
    """

    shape: Literal["mass"] = Field(default="mass", kw_only=True, repr=False)
    mass: Positive = Key("", "kg")
    inertia: Annotated[Inertia, _inertia] = Key(
        "about the mass centre along the body's axes: three principal values (0, 0, 0 for a point mass), or three rows "
        "of a symmetric matrix; {}",
        "kg m^2",
    )
    axes: OptionalAxes = Key(AXES, default=None, kw_only=True)

    @classmethod
    def box(
        cls,
        centre: Point,
        sides: Point,
        density: float | None = None,
        *,
        mass: float | None = None,
        axes: Sequence[Point] | None = None,
        points: Named | None = None,
    ) -> Box:
        """Make a homogeneous box; see `Box`.

        Args:
            centre: its middle [m], global axes in the reference shape; sides: along its axes [m].
            density: [kg/m^3]; mass: [kg] instead.
            axes: directions of its first two sides; the global ones by default.
            points: name -> position [m], global axes, to which supports, joints and loads may be attached.
        """
        given = _given(centre=centre, sides=sides, density=density, mass=mass, axes=axes, points=points)
        return Box(**given)

    @classmethod
    def sphere(
        cls,
        centre: Point,
        radius: float,
        density: float | None = None,
        *,
        mass: float | None = None,
        axes: Sequence[Point] | None = None,
        points: Named | None = None,
    ) -> Sphere:
        """Make a homogeneous sphere; see `Sphere`.

        Args:
            centre: [m], global axes in the reference shape; radius: [m].
            density: [kg/m^3]; mass: [kg] instead; axes: of its rotations, the global ones by default.
            points: name -> position [m], global axes, to which supports, joints and loads may be attached.
        """
        given = _given(centre=centre, radius=radius, density=density, mass=mass, axes=axes, points=points)
        return Sphere(**given)

    @classmethod
    def cylinder(
        cls,
        centre: Point,
        axis: Point,
        radius: float,
        length: float,
        density: float | None = None,
        *,
        mass: float | None = None,
        points: Named | None = None,
    ) -> Cylinder:
        """Make a homogeneous cylinder; see `Cylinder`.

        Args:
            centre: its middle [m], global axes in the reference shape; axis: direction; radius, length: [m].
            density: [kg/m^3]; mass: [kg] instead.
            points: name -> position [m], global axes, to which supports, joints and loads may be attached.
        """
        given = _given(centre=centre, axis=axis, radius=radius, length=length, density=density, mass=mass)
        return Cylinder(**given, **_given(points=points))

    def total_mass(self) -> float:
        """Return the mass [kg], as given."""
        return self.mass

    def inertia_matrix(self) -> Floats:
        """Return the inertia [kg m^2] ``(3, 3)`` about the mass centre in the axes of the body, as given."""
        given = np.array(self.inertia)
        return np.diag(given) if given.ndim == 1 else given

    def frame(self) -> Floats:
        """Return the given axes."""
        return columns(self.axes)

    @model_validator(mode="after")
    def _possible(self) -> Self:
        matrix = self.inertia_matrix()
        scale = np.abs(matrix).max() or 1.0
        principal = (np.sort(np.diag(matrix) / scale) if np.ndim(self.inertia) == 1 else
                     np.linalg.eigvalsh(matrix / scale)) * scale  # fmt: skip
        i1, i2, i3 = principal.tolist()
        if i1 < -SLACK * scale:
            raise RefusedError(
                "principal inertias are not negative",
                "give three numbers >= 0 (all zero for a point mass), or a positive semi-definite matrix",
                found=f"the principal inertia {i1:.6g} kg m^2",
                at=("inertia",),
            )
        if i1 + i2 < i3 * (1.0 - SLACK):
            raise RefusedError(
                "no body has a principal inertia larger than the sum of the other two",
                f"make {i3:.6g} smaller, or the others larger; a flat body has the sum",
                found=f"{i3:.6g} > {i1:.6g} + {i2:.6g} kg m^2",
                at=("inertia",),
            )
        return self


BODIES: dict[str, type[Definition]] = {"mass": Body, "box": Box, "sphere": Sphere, "cylinder": Cylinder}
"""The rigid bodies by their word in a case file; a new one is one class and one line here."""

one_body = choose("shape", BODIES, default="mass")
"""A rigid body from a table or as it is."""


def _given(**arguments: Any) -> dict[str, Any]:
    """Return the arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}
