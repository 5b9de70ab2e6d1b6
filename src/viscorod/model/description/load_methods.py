"""Methods of a model that add loads."""

from __future__ import annotations

from collections.abc import Callable

from viscorod.argument_names import known_arguments
from viscorod.given_as import Amount
from viscorod.model.actions.load import (
    AnyLoad,
    DistributedForce,
    DistributedForceTowards,
    DistributedMoment,
    Drag,
    Force,
    ForceOnLine,
    ForceTowards,
    Gravity,
    Moment,
    MovingForce,
)
from viscorod.model.description.given_places import placed
from viscorod.model.fields.arguments import Time, Vector, given

__all__ = ["Loaded"]


@known_arguments
class Loaded:
    """Methods that add loads; a part of `ModelDescription`."""

    loads: list[AnyLoad]

    def force(
        self,
        at: str,
        value: Vector,
        following: bool = False,
        time: Time = None,
        until: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Load a place with a force, N; see `Force`."""
        self.loads.append(
            placed(
                self,
                Force(**given(at=at, value=value, following=following, time=time, until=until, name=name)),
            )
        )

    def moment(
        self,
        at: str,
        value: Vector,
        following: bool = False,
        time: Time = None,
        until: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Load a place with a moment, N m; see `Moment`."""
        self.loads.append(
            placed(
                self,
                Moment(**given(at=at, value=value, following=following, time=time, until=until, name=name)),
            )
        )

    def distributed_force(
        self,
        rod: str,
        value: Vector | Callable[[float], Vector],
        following: bool = False,
        time: Time = None,
        until: Amount | None = None,
        *,
        from_s: Amount | None = None,
        to_s: Amount | None = None,
        name: str | None = None,
    ) -> None:
        """Load a rod with a force per length, N/m; see `DistributedForce`."""
        span = given(
            rod=rod,
            value=value,
            following=following,
            time=time,
            until=until,
            from_s=from_s,
            to_s=to_s,
            name=name,
        )
        self.loads.append(placed(self, DistributedForce(**span)))

    def distributed_moment(
        self,
        rod: str,
        value: Vector | Callable[[float], Vector],
        following: bool = False,
        time: Time = None,
        until: Amount | None = None,
        *,
        from_s: Amount | None = None,
        to_s: Amount | None = None,
        name: str | None = None,
    ) -> None:
        """Load a rod with a moment per length, N m/m; see `DistributedMoment`."""
        span = given(
            rod=rod,
            value=value,
            following=following,
            time=time,
            until=until,
            from_s=from_s,
            to_s=to_s,
            name=name,
        )
        self.loads.append(placed(self, DistributedMoment(**span)))

    def gravity(
        self,
        acceleration: Vector = (0.0, 0.0, -9.81),
        time: Time = None,
        until: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Add the weight of all rods and bodies; see `Gravity`."""
        self.loads.append(
            placed(self, Gravity(**given(acceleration=acceleration, time=time, until=until, name=name)))
        )

    def moving_force(
        self,
        rod: str,
        value: Vector,
        *,
        speed: Amount | None = None,
        position: Time = None,
        start: Amount | None = None,
        following: bool = False,
        time: Time = None,
        until: Amount | None = None,
        name: str | None = None,
    ) -> None:
        """Load a rod with a force that travels along it; see `MovingForce`."""
        travel = given(rod=rod, value=value, speed=speed, position=position, start=start)
        self.loads.append(
            placed(
                self, MovingForce(**travel, **given(following=following, time=time, until=until, name=name))
            )
        )

    def force_towards(
        self,
        at: str,
        size: Amount,
        point: Vector,
        time: Time = None,
        until: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Load a place with a force towards a point of space; see `ForceTowards`."""
        given_keys = given(at=at, size=size, point=point, time=time, until=until, name=name)
        self.loads.append(placed(self, ForceTowards(**given_keys)))

    def distributed_force_towards(
        self,
        rod: str,
        size: Amount,
        point: Vector,
        time: Time = None,
        until: Amount | None = None,
        *,
        from_s: Amount | None = None,
        to_s: Amount | None = None,
        name: str | None = None,
    ) -> None:
        """Load a rod with a force per length towards a point of space; see `DistributedForceTowards`."""
        span = given(rod=rod, time=time, until=until, from_s=from_s, to_s=to_s, name=name)
        self.loads.append(placed(self, DistributedForceTowards(**span, **given(size=size, point=point))))

    def force_on_line(
        self,
        at: str,
        value: Vector,
        point: Vector,
        time: Time = None,
        until: Amount | None = None,
        *,
        name: str | None = None,
    ) -> None:
        """Load a place with a force that stays on its line of space, through a point; see `ForceOnLine`."""
        given_keys = given(at=at, value=value, point=point, time=time, until=until, name=name)
        self.loads.append(placed(self, ForceOnLine(**given_keys)))

    def drag(
        self,
        rod: str,
        *,
        linear_across: Amount = 0.0,
        linear_along: Amount = 0.0,
        linear_about: Amount = 0.0,
        coefficient_across: Amount | None = None,
        coefficient_along: Amount | None = None,
        density: Amount | None = None,
        width: Amount | None = None,
        velocity: Vector = (0.0, 0.0, 0.0),
        time: Time = None,
        until: Amount | None = None,
        from_s: Amount | None = None,
        to_s: Amount | None = None,
        name: str | None = None,
    ) -> None:
        """Let the medium around a rod resist its motion, or flow past it; see `Drag`."""
        linear = given(linear_across=linear_across, linear_along=linear_along, linear_about=linear_about)
        quadratic = given(coefficient_across=coefficient_across, coefficient_along=coefficient_along)
        medium = given(density=density, width=width, velocity=velocity)
        span = given(rod=rod, time=time, until=until, from_s=from_s, to_s=to_s, name=name)
        self.loads.append(placed(self, Drag(**span, **linear, **quadratic, **medium)))
