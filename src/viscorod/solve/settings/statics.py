"""Settings of equilibria and of paths of them."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    Flag,
    Number,
    OptionalNumber,
    OptionalPositive,
    OptionalText,
    numbers,
    one_of,
    whole_number,
)
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.settings.stages import Stages
from viscorod.solve.start import OptionalStart

__all__ = ["EquilibriumSettings", "PathSettings"]


@accepts(listed(quantity()), "list of numbers")
def _factors(value: Any) -> tuple[float, ...]:
    return numbers(value, at_least=0)


class EquilibriumSettings(Meshed):
    """How a static equilibrium is computed."""

    load_steps: Annotated[int | None, optional(whole_number(1, 10_000))] = Key(
        "number of equal load steps, 1 to 10 000, each of which is stored, and nothing between; smaller steps are "
        "taken where needed. Left out, all steps are stored; the first is the whole load, or a third of a turn of a "
        "prescribed rotation",
        default=None,
    )
    load_factor: Number = Key("multiple of all loads and prescribed motions", default=1.0)
    search: Flag = Key(
        "whether the search goes on to a stable equilibrium where load steps fail or end at an unstable one; false "
        "keeps to the equilibrium that load steps lead to, such as that of a straight strut. Left out, it does so "
        "unless rotations of more than a full turn are prescribed, which rods without contact might undo",
        default=True,
    )
    start: OptionalStart = Key(
        "state of an earlier result from which the search begins instead of the reference shape; loads act in full "
        "from there on, prescribed motions grow from what they are in it",
        default=None,
    )
    stages: Stages = Key(
        "stages, each from the equilibrium at the end of the one before: which loads and motions grow in it",
        default=(),
    )
    load_factors: Annotated[GivenAs[tuple[float, ...], Amounts], _factors] = Key(
        "multiples of all loads and prescribed motions that are wanted, in this order, in place of load_factor and "
        "load_steps; exactly these are stored",
        default=(),
    )

    @property
    def stops(self) -> tuple[float, ...]:
        """The load factors that are wanted, in their order; the last one is the end."""
        if self.load_factors:
            return self.load_factors
        steps = self.load_steps or 1
        return (*(self.load_factor * (k / steps) for k in range(1, steps)), self.load_factor)

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.load_factors and (self.stages or self.start is not None):
            raise RefusedError(
                f"loads of {'stages' if self.stages else 'a start'} go from what they are to their full size",
                "leave it out, or give load_steps",
                found=show(list(self.load_factors)),
                at=("load_factors",),
            )
        if self.load_factors and (self.load_steps is not None or self.load_factor != 1.0):
            other = "load_steps" if self.load_steps is not None else "load_factor"
            raise RefusedError(
                f"load_factors says which states are wanted, so does {other}",
                f"leave {other} or load_factors out",
                found=show(list(self.load_factors)),
                at=("load_factors",),
            )
        return self


@accepts({"type": "integer", "minimum": -1000, "maximum": 1000}, "whole number from -1000 to 1000, not 0")
def _branch(value: Any) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value == 0 or abs(value) > 1000:
        raise RefusedError(
            "the number of a bifurcation is needed here", "give 1 for the first, -1 for its other side"
        )
    return value


class PathSettings(Meshed):
    """How a path of equilibria is followed."""

    renamed: ClassVar[dict[str, str]] = {"turns": "limit_point"}

    load_factor: OptionalNumber = Key(
        "multiple of the loads towards which the path begins and where it ends. 1 if neither "
        "displacement nor limit_point is given",
        default=None,
    )
    place: OptionalText = Key('the place whose displacement ends the path, such as "arch@0.5"', default=None)
    axis: Annotated[Literal["x", "y", "z"] | None, optional(one_of("x", "y", "z"))] = Key(
        'global axis of this displacement, "x", "y" or "z"', default=None
    )
    displacement: OptionalNumber = Key("from the reference shape at which the path ends", "m", default=None)
    limit_point: Annotated[int | None, optional(whole_number(1, 1000))] = Key(
        "number of limit points at the last of which the path ends, 1 to 1000", default=None
    )
    load_factors: Annotated[GivenAs[tuple[float, ...], Amounts], _factors] = Key(
        "load factors at which a point is wanted, each time the path passes one", default=()
    )
    branch: Annotated[int | None, optional(_branch)] = Key(
        "number of the bifurcation at which the path goes over to the branch that crosses it there, 1 for the first; "
        "-1 goes to its other side",
        default=None,
    )
    points: Annotated[int, whole_number(2, 100_000)] = Key(
        "number of points at most, 2 to 100 000", default=200
    )
    arc_length: OptionalPositive = Key(
        "largest distance between two points, in which a displacement by the model's length, a rotation by 1 rad and a "
        "change of the load factor by its unit count alike. The unit is load_factor, or what moves the reference shape "
        "by its length if that is less. Left out, 0.1, or a hundredth of prescribed motions if that is more",
        default=None,
    )
    start: OptionalStart = Key(
        "state of an earlier result near which the path begins, at its load factor (1 for a motion), instead of the "
        "reference shape without loads",
        default=None,
    )

    @property
    def target(self) -> float | None:
        """The load factor at which the path ends, None if it may have any."""
        if self.load_factor is None and self.displacement is None and self.limit_point is None:
            return self.load_factors[-1] if self.load_factors else 1.0
        return self.load_factor

    @property
    def course(self) -> Course:
        """See :class:`Meshed`: the displacement that ends the path, or the load factor, whose end may be unknown."""
        if self.displacement is not None:
            return Course("displacement", " m", 0.0, self.displacement)
        return Course("load factor", "", 0.0, self.target)

    @model_validator(mode="after")
    def _whole(self) -> Self:
        given = [name for name in ("place", "axis", "displacement") if getattr(self, name) is not None]
        if given and len(given) < 3:
            missing = next(name for name in ("place", "axis", "displacement") if name not in given)
            raise RefusedError(
                "place, axis and displacement belong together",
                f"add {missing}, or leave out {' and '.join(given)}",
                found="missing",
                at=(missing,),
            )
        return self
