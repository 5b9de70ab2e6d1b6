"""The description of a model: rods by name, what holds them, what loads them, how they are joined."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Self, TypeAlias

from viscorod.errors import InputError, Problem
from viscorod.model import checks
from viscorod.model.any_support import AnySupport, ResolvedSupport
from viscorod.model.attachment import Attachment
from viscorod.model.body_velocity import BodyVelocity
from viscorod.model.described import RefusedError, plain_value, show
from viscorod.model.initial_strain import InitialStrain
from viscorod.model.load import (
    AnyLoad,
    DistributedForce,
    DistributedMoment,
    Force,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.model.place import Place, find_place
from viscorod.model.rod import Rod
from viscorod.model.support import Clamp, Guide, Pin, Roller, Support
from viscorod.model.time_function import TimeFunction
from viscorod.model.values import name_of_part
from viscorod.model.velocity import InitialVelocity

__all__ = ["ModelDescription"]

Time: TypeAlias = TimeFunction | Callable[[float], float] | float | None
"""What can be given as a function of time: one of the kinds, a Python function, a number."""
Motion: TypeAlias = Mapping[str, TimeFunction | Callable[[float], float] | float]
Vector: TypeAlias = Sequence[float]


class ModelDescription:
    """Rods with supports, loads, attachments and initial velocities; the same words as in a case file.

    Places are written ``"beam.start"``, ``"beam.end"``, ``"beam@0.15"`` (arc length in m). What a method is
    given is checked at once; how the parts fit together is checked by `validate`.

    Attributes:
        rods: by name, in the order in which they were added.
        supports: in order.
        loads: in order.
        attachments: pairs of places that are one rigid node.
        velocities, strains: at t = 0.
    """

    def __init__(self) -> None:
        self.rods: dict[str, Rod] = {}
        self.supports: list[AnySupport] = []
        self.loads: list[AnyLoad] = []
        self.attachments: list[Attachment] = []
        self.velocities: list[InitialVelocity] = []
        self.strains: list[InitialStrain] = []

    def add(self, name: str, rod: Rod) -> None:
        """Add a rod under a new name (letters, digits, _ and -).

        Raises:
            InputError: the name is taken or not usable, or `rod` is no rod.
        """
        path = f"rods.{name}"
        try:
            name_of_part(name)
        except RefusedError as error:
            raise InputError(Problem("rods", show(name), error.why, error.instead)) from None
        if not isinstance(rod, Rod):
            raise InputError(
                Problem(path, show(rod), "this is not a rod", "give a Rod, such as Rod.straight(...)")
            )
        if name in self.rods:
            raise InputError(
                Problem(path, show(name), "there is already a rod of this name", "give another name")
            )
        self.rods[name] = rod

    def support(
        self,
        at: str,
        fixed: Sequence[str] = (),
        *,
        frame: str = "global",
        axes: Sequence[Vector] | None = None,
        motion: Motion | None = None,
    ) -> None:
        """Fix any of the six motions, or prescribe them in time; see `Support`."""
        given: dict[str, Any] = {"fixed": fixed, "frame": frame, "axes": axes, "motion": motion or {}}
        self.supports.append(Support(at, **given))

    def clamp(self, at: str, motion: Motion | None = None) -> None:
        """Hold all six motions; see `Clamp`."""
        self.supports.append(Clamp(at, **_moving(motion)))

    def pin(self, at: str, motion: Motion | None = None) -> None:
        """Hold the three displacements; see `Pin`."""
        self.supports.append(Pin(at, **_moving(motion)))

    def guide(self, at: str, along: Vector | None = None, motion: Motion | None = None) -> None:
        """Let the place slide along one direction only; see `Guide`."""
        given: dict[str, Any] = {"along": along}
        self.supports.append(Guide(at, **given, **_moving(motion)))

    def roller(self, at: str, normal: Vector, motion: Motion | None = None) -> None:
        """Hold the displacement along one direction; see `Roller`."""
        given: dict[str, Any] = {"normal": normal}
        self.supports.append(Roller(at, **given, **_moving(motion)))

    def body_velocity(self, at: str, fixed: Sequence[str] = (), velocity: Motion | None = None) -> None:
        """Hold velocities along the axes of the moving section; see `BodyVelocity`."""
        given: dict[str, Any] = {"fixed": fixed, "velocity": velocity or {}}
        self.supports.append(BodyVelocity(at, **given))

    def attach(self, a: str, b: str) -> None:
        """Join two coinciding places into one rigid node; the angle between the rods stays as it is."""
        self.attachments.append(Attachment(a, b))

    def force(
        self, at: str, value: Vector, following: bool = False, time: Time = None, until: float | None = None
    ) -> None:
        """Load a place with a force, N; see `Force`."""
        self.loads.append(Force(**_given(at=at, value=value, following=following, time=time, until=until)))

    def moment(
        self, at: str, value: Vector, following: bool = False, time: Time = None, until: float | None = None
    ) -> None:
        """Load a place with a moment, N m; see `Moment`."""
        self.loads.append(Moment(**_given(at=at, value=value, following=following, time=time, until=until)))

    def distributed_force(
        self,
        rod: str,
        value: Vector | Callable[[float], Vector],
        following: bool = False,
        time: Time = None,
        until: float | None = None,
        *,
        from_s: float | None = None,
        to_s: float | None = None,
    ) -> None:
        """Load a rod with a force per length, N/m; see `DistributedForce`."""
        span = _given(
            rod=rod, value=value, following=following, time=time, until=until, from_s=from_s, to_s=to_s
        )
        self.loads.append(DistributedForce(**span))

    def distributed_moment(
        self,
        rod: str,
        value: Vector | Callable[[float], Vector],
        following: bool = False,
        time: Time = None,
        until: float | None = None,
        *,
        from_s: float | None = None,
        to_s: float | None = None,
    ) -> None:
        """Load a rod with a moment per length, N m/m; see `DistributedMoment`."""
        span = _given(
            rod=rod, value=value, following=following, time=time, until=until, from_s=from_s, to_s=to_s
        )
        self.loads.append(DistributedMoment(**span))

    def gravity(
        self, acceleration: Vector = (0.0, 0.0, -9.81), time: Time = None, until: float | None = None
    ) -> None:
        """Let all rods have weight; see `Gravity`."""
        self.loads.append(Gravity(**_given(acceleration=acceleration, time=time, until=until)))

    def moving_force(
        self,
        rod: str,
        value: Vector,
        *,
        speed: float | None = None,
        position: Time = None,
        start: float | None = None,
        following: bool = False,
        time: Time = None,
        until: float | None = None,
    ) -> None:
        """Load a rod with a force that travels along it; see `MovingForce`."""
        travel = _given(rod=rod, value=value, speed=speed, position=position, start=start)
        self.loads.append(MovingForce(**travel, **_given(following=following, time=time, until=until)))

    def velocity(
        self,
        rod: str,
        linear: Vector = (0.0, 0.0, 0.0),
        angular: Vector = (0.0, 0.0, 0.0),
        about: Vector = (0.0, 0.0, 0.0),
        *,
        field: Callable[[float], tuple[Vector, Vector]] | None = None,
    ) -> None:
        """Give a rod an initial velocity; see `InitialVelocity`."""
        given = _given(rod=rod, field=field)
        if field is None or any(any(vector) for vector in (linear, angular, about)):
            given |= {"linear": linear, "angular": angular, "about": about}
        self.velocities.append(InitialVelocity(**given))

    def strain(self, rod: str, value: Sequence[float] | Callable[[float], Sequence[float]]) -> None:
        """Give a rod an initial strain; see `InitialStrain`."""
        given: dict[str, Any] = {"value": value}
        self.strains.append(InitialStrain(rod, **given))

    def validate(self) -> None:
        """Check that the parts fit together.

        Raises:
            InputError: with everything that is wrong, each with its key path and what to give instead.
        """
        problems = list(checks.problems(self))
        if problems:
            raise InputError(problems)

    def place(self, text: str) -> Place:
        """The rod and arc length that `text` names.

        Raises:
            InputError: there is no such place.
        """
        return find_place(text, self.rods)

    def resolved_supports(self) -> list[ResolvedSupport]:
        """The supports with their stations and axes, in order."""
        return checks.resolved_supports(self)

    def nodes(self) -> list[tuple[Place, ...]]:
        """The groups of places that attachments join into one node each."""
        return checks.joined_places(self)

    def stations(self, rod: str) -> tuple[float, ...]:
        """Arc lengths at which an element must end (supports, loads, attachments, section jumps), m."""
        return checks.required_stations(self, rod)

    def to_dict(self) -> dict[str, Any]:
        """The model as a table of the case file; Python functions appear as a note."""
        plain: dict[str, Any] = {"rods": {name: rod.to_dict() for name, rod in self.rods.items()}}
        for key in ("supports", "loads", "attachments", "velocities", "strains"):
            if getattr(self, key):
                plain[key] = plain_value(getattr(self, key))
        return plain

    def parts(self) -> dict[str, Any]:
        """What :meth:`of` makes another of, such as one of a derived class."""
        return {
            "rods": self.rods,
            "supports": self.supports,
            "loads": self.loads,
            "attachments": self.attachments,
            "velocities": self.velocities,
            "strains": self.strains,
        }

    @classmethod
    def of(
        cls,
        rods: Mapping[str, Rod],
        supports: Iterable[AnySupport] = (),
        loads: Iterable[AnyLoad] = (),
        attachments: Iterable[Attachment] = (),
        velocities: Iterable[InitialVelocity] = (),
        strains: Iterable[InitialStrain] = (),
    ) -> Self:
        """A model from its parts."""
        model = cls()
        for name, rod in rods.items():
            model.add(name, rod)
        model.supports.extend(supports)
        model.loads.extend(loads)
        model.attachments.extend(attachments)
        model.velocities.extend(velocities)
        model.strains.extend(strains)
        return model


def _given(**arguments: Any) -> dict[str, Any]:
    """The arguments that are not None."""
    return {name: value for name, value in arguments.items() if value is not None}


def _moving(motion: Motion | None) -> dict[str, Any]:
    return {"motion": motion} if motion else {}
