"""Effects of a load: the wrenches that it puts on the model, and the arrows that are drawn of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from viscorod.model.connections.place import AnyPlace
from viscorod.typing import Floats

__all__ = ["Arrows", "CompiledLaw", "MotionLaw", "Placing", "PythonLaw", "TimeFactor"]

TimeFactor: TypeAlias = Callable[[float, bool], float]
"""A function of the time t, s, and of whether its limit from the left is meant."""


@dataclass(frozen=True)
class CompiledLaw:
    """A law of a load that sees motion which ``mechanics.nodes.motion_loads`` knows.

    Attributes:
        word: of `LAWS` there; numbers: that it takes.
        axis: a direction (3,) in space that it depends on; zero if it depends on none.
        at_rest: whether it acts on what is at rest.
    """

    word: str
    numbers: tuple[float, ...]
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)
    at_rest: bool = True


def _nothing(r: Floats, R: Floats, twist: Floats) -> float:
    del r, R, twist
    return 0.0


@dataclass(frozen=True)
class PythonLaw:
    """A law of a load that sees motion, as Python functions of position (3,), rotation matrix (3, 3) and twist (6,).

    The twist has velocity (m/s) and angular velocity (rad/s) along d1, d2, d3.

    Attributes:
        wrench: force and moment (6,) along d1, d2, d3; per length (N/m, N) of what lies along a rod.
        dissipated: power that it turns into heat outside of the model, likewise; none unless given.
        at_rest: whether it acts on what is at rest.
        by_pose: derivatives of a wrench that does not depend on the twist by an increment of the pose along d1, d2, d3
            (displacement, rotation), (6, 6); without it all derivatives are taken by differences.
    """

    wrench: Callable[[Floats, Floats, Floats], Floats]
    dissipated: Callable[[Floats, Floats, Floats], float] = _nothing
    at_rest: bool = True
    by_pose: Callable[[Floats, Floats, Floats], Floats] | None = None


MotionLaw: TypeAlias = CompiledLaw | PythonLaw


class Placing(Protocol):
    """Takes the wrenches of a load; the solver hands it to :meth:`AnyLoad.place`.

    A wrench (6,) is a force (N) and a moment (N m): global components, or along d1, d2, d3 if it follows.
    """

    def at(self, place: str, wrench: Floats, factor: TimeFactor, *, following: bool = False) -> None:
        """Put a wrench on a place, such as "beam.end"."""

    def along(
        self,
        rod: str,
        density: Callable[[float], Floats],
        factor: TimeFactor,
        *,
        start: float = 0.0,
        end: float | None = None,
        following: bool = False,
    ) -> None:
        """Spread wrenches per length, a function of the arc length, over a rod from `start` to `end`, m."""

    def travelling(
        self, rod: str, position: TimeFactor, wrench: Floats, factor: TimeFactor, *, following: bool = False
    ) -> None:
        """Let a wrench travel along a rod; its arc length, m, is a function of time. Beside the rod it does not act."""

    def seeing_motion(
        self,
        rod: str,
        law: MotionLaw,
        factor: TimeFactor,
        *,
        start: float = 0.0,
        end: float | None = None,
    ) -> None:
        """Let a law that sees the motion of the sections act per length on a rod from `start` to `end`, m."""

    def seeing_motion_at(self, place: str, law: MotionLaw, factor: TimeFactor) -> None:
        """Let a law that sees the motion of a place act there; what it says is not per length then."""

    def everywhere(self, acceleration: Floats, factor: TimeFactor) -> None:
        """Let everything have weight; the acceleration (3,) in m/s^2, global axes."""


@dataclass(frozen=True, eq=False)
class Arrows:
    """The arrows of a load at one time, at its full size (without its factor).

    Attributes:
        label: the load in words, such as "force at beam.end".
        unit: of the values: "N", "N m", "N/m", "N m/m", or "m/s²" where there are no feet.
        feet: places where it acts, (n,); none if it acts on everything.
        values: what acts there (n, 3), or (1, 3) without feet; global components, along d1, d2, d3 if it follows.
        following: whether it turns with the sections.
        turning: whether it is a moment.
        acting: whether it acts at this time; a load that travels does not when it is beside its rod.
    """

    label: str
    unit: str
    feet: tuple[AnyPlace, ...]
    values: Floats
    following: bool = False
    turning: bool = False
    acting: bool = True
