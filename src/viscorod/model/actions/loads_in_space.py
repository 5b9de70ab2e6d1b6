"""Loads that know where they act: forces towards a point of space, and forces on a line of space.

Ropes over pulleys, pressure towards a centre and jets on plates (Reut) keep neither their direction nor their place in
the section: they are loads that see motion, with the derivatives that their formulas have.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, TypeAlias

import numpy as np
from pydantic import Field

from viscorod.model.actions.load_base import AlongRod, AnyLoad
from viscorod.model.actions.load_effects import Arrows, Placing, PythonLaw
from viscorod.model.connections.place import Place, PlaceField
from viscorod.model.connections.resolved_places import position_of
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Number, Vector
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription

__all__ = ["DistributedForceTowards", "ForceOnLine", "ForceTowards"]

InSpace: TypeAlias = Callable[[Floats], tuple[Floats, Floats]]
"""Force and moment (6,) at a position (3,), global axes, and their derivatives by the position (6, 3)."""

APART = 1e-9
"""Least distance of a place from the point that a force points to, m, and as a part of that from the origin."""


def _law(in_space: InSpace) -> PythonLaw:
    """Return a wrench of space as a law, which takes it along the axes of its place.

    An increment (u, theta) of the pose moves the place by R u and turns R by theta, so that f = R^T F changes by
    ``R^T F' R u + f x theta``; so do moments.
    """

    def wrench(r: Floats, R: Floats, _twist: Floats) -> Floats:
        return (in_space(r)[0].reshape(2, 3) @ R).ravel()

    def by_pose(r: Floats, R: Floats, _twist: Floats) -> Floats:
        values, slopes = in_space(r)
        found = np.zeros((6, 6))
        for rows in (slice(0, 3), slice(3, 6)):
            found[rows, :3] = R.T @ slopes[rows] @ R
            found[rows, 3:] = _cross(values[rows] @ R)
        return found

    return PythonLaw(wrench, by_pose=by_pose)


def _cross(a: Floats) -> Floats:
    """Return the matrix of ``a x``."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _towards(point: Floats, size: float) -> InSpace:
    """Return a force of a size towards a point; none at the point itself."""

    def in_space(r: Floats) -> tuple[Floats, Floats]:
        values, slopes = np.zeros(6), np.zeros((6, 3))
        distance = float(np.linalg.norm(point - r))
        if distance > 0.0:
            along = (point - r) / distance
            values[:3] = size * along
            slopes[:3] = size / distance * (np.outer(along, along) - np.eye(3))
        return values, slopes

    return in_space


def _on_line(point: Floats, force: Floats) -> InSpace:
    """Return a force on the line through a point, taken to the place by a rigid arm: moment (point - r) x force."""
    slopes = np.concatenate([np.zeros((3, 3)), _cross(force)])

    def in_space(r: Floats) -> tuple[Floats, Floats]:
        return np.concatenate([force, np.cross(point - r, force)]), slopes

    return in_space


def _directed(point: Sequence[float], positions: Floats) -> Iterator[RefusedError]:
    """Yield why a force from one of the positions ``(n, 3)`` cannot point to a point."""
    distances = np.linalg.norm(np.array(point) - positions, axis=1)
    least = APART * max(1.0, float(np.abs(positions).max()))
    if distances.min() < least:
        yield RefusedError(
            f"the load acts {distances.min():.3g} m from this point, too near for the change of its direction",
            f"give a point at least {least:.3g} m away",
            found=show(list(point)),
            at=("point",),
        )


class _AtPlace(AnyLoad):
    sees_motion: ClassVar[bool] = True
    at: PlaceField = Key("place")

    @abstractmethod
    def _in_space(self) -> InSpace:
        """Return force and moment over the position."""

    def places(self) -> dict[str, str]:
        return {"at": self.at}

    def place(self, model: ModelDescription, placing: Placing) -> None:
        del model
        placing.seeing_motion_at(self.at, _law(self._in_space()), self.factor)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        del t
        feet = (model.place(self.at),)
        values = self._in_space()(position_of(model, feet[0])[0])[0]
        return Arrows(f"{self.word} at {self.at}", "N", feet, values[None, :3])


class ForceTowards(_AtPlace):
    """A force of constant size from a place towards a point of space, such as that of a rope over a pulley there.

    It has the potential ``size`` times the distance. A column whose load points to its foot buckles at pi^2 EI/L^2,
    four times Euler's load of a dead one (S. P. Timoshenko and J. M. Gere, Theory of elastic stability).
    """

    kind: Literal["force_towards"] = Field(default="force_towards", kw_only=True, repr=False)
    size: Number = Key("of the force, towards the point; negative: away from it", "N")
    point: Vector = Key("that it points to, global axes", "m")

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield why there is no such place, or the point is too near."""
        faults = list(super().misfits(model))
        yield from faults
        if not faults:
            yield from _directed(self.point, position_of(model, model.place(self.at))[0][None])

    def figures(self) -> dict[str, float | str]:
        """Return its size and point."""
        return {"towards [N]": self.size, "point [m]": show(list(self.point))}

    def _in_space(self) -> InSpace:
        return _towards(np.array(self.point), self.size)


class ForceOnLine(_AtPlace):
    """A force that stays on its line of space, whichever way its place moves, as of a jet on a plate.

    The plate is rigid and fixed to the place: at the place act the force and its moment (point - r) x value. It has no
    potential; a column that it presses, Reut's, flutters at 20.05 EI/L^2 as Beck's does (V. V. Bolotin, Nonconservative
    problems of the theory of elastic stability, 1963).
    """

    kind: Literal["force_on_line"] = Field(default="force_on_line", kw_only=True, repr=False)
    value: Vector = Key("{}, global components", "N")
    point: Vector = Key("through which its line goes, global axes", "m")

    def figures(self) -> dict[str, float | str]:
        """Return the force, and the point of its line."""
        return {"on a line [N]": show(list(self.value)), "point [m]": show(list(self.point))}

    def _in_space(self) -> InSpace:
        return _on_line(np.array(self.point), np.array(self.value))


class DistributedForceTowards(AlongRod):
    """A force per reference length of constant size towards a point of space, such as pressure towards a centre.

    It acts at the nodes, each for its part of the length. A ring that it presses towards its centre buckles at
    4.5 EI/R^3, which is 3 EI/R^3 under the pressure of a fluid, a following load, and 4 EI/R^3 under a dead one
    (S. P. Timoshenko and J. M. Gere, Theory of elastic stability; G. J. Simitses and D. H. Hodges, Fundamentals of
    structural stability, 2006).
    """

    sees_motion: ClassVar[bool] = True
    kind: Literal["distributed_force_towards"] = Field(
        default="distributed_force_towards", kw_only=True, repr=False
    )
    size: Number = Key("of the force per length, towards the point; negative: away from it", "N/m")
    point: Vector = Key("that it points to, global axes", "m")

    def misfits(self, model: ModelDescription) -> Iterator[RefusedError]:
        """Yield why there is no such rod, no such part of it, or the point is too near."""
        faults = list(super().misfits(model))
        yield from faults
        if not faults:
            yield from _directed(self.point, self._positions(model))

    def _positions(self, model: ModelDescription) -> Floats:
        return np.asarray(model.rods[self.rod].frames(self.feet(model))[0])

    def figures(self) -> dict[str, float | str]:
        """Return its size and point."""
        return {"towards [N/m]": self.size, "point [m]": show(list(self.point))}

    def place(self, model: ModelDescription, placing: Placing) -> None:
        """Let it act on the nodes."""
        del model
        law = _law(_towards(np.array(self.point), self.size))
        placing.seeing_motion(self.rod, law, self.factor, start=self.from_s or 0.0, end=self.to_s)

    def arrows(self, model: ModelDescription, t: float) -> Arrows:
        """Return what acts on the reference shape."""
        del t
        in_space = _towards(np.array(self.point), self.size)
        values = np.array([in_space(r)[0][:3] for r in self._positions(model)])
        feet = tuple(Place(self.rod, s) for s in self.feet(model))
        return Arrows(f"{self.word} along {self.rod}", "N/m", feet, values)
