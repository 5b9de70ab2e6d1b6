"""Functions of time for loads and prescribed motions.

Every function has the methods `value(t)`, `rate(t)` and `acceleration(t)`; ``before=True`` gives the limit from the
left. `breakpoints` are the times at which value, rate or acceleration is not smooth, `jumps` those at which
the value jumps.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import Number, Positive

__all__ = ["Constant", "Ramp", "Sine", "SmoothRamp", "SpinUp", "TimeFunction", "Until"]


class TimeFunction(Definition):
    """A scalar function of the time in seconds."""

    tag: ClassVar[str | None] = "kind"
    of_anything: ClassVar[bool] = True
    """Whether its numbers may wait for what they measure, see `viscorod.units.Measured`."""

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which value, rate or acceleration is not smooth, increasing, s."""
        return ()

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which the value jumps, increasing, s."""
        return ()

    @abstractmethod
    def value(self, t: float, before: bool = False) -> float:
        """Return the value at time `t` (the limit from the left if `before`)."""

    @abstractmethod
    def rate(self, t: float, before: bool = False) -> float:
        """Return the first derivative at time `t`, 1/s."""

    @abstractmethod
    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the second derivative at time `t`, 1/s^2."""

    def of(self, owner: str) -> Self:
        """Return the function with what it belongs to, for the messages of functions that can fail."""
        del owner
        return self

    def require_derivatives(self) -> None:
        """Refuse, by an `InputError`, a function without the derivatives that a motion needs."""


class Constant(TimeFunction):
    """The same value at all times."""

    kind: Literal["constant"] = Field(default="constant", kw_only=True, repr=False)
    level: Number = Key("the value", "*", default=1.0)

    def value(self, t: float, before: bool = False) -> float:
        """Return the level."""
        del t, before
        return self.level

    def rate(self, t: float, before: bool = False) -> float:
        """Return zero."""
        del t, before
        return 0.0

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return zero."""
        del t, before
        return 0.0


class Until(TimeFunction):
    """A level before a time, zero from then on."""

    kind: Literal["until"] = Field(default="until", kw_only=True, repr=False)
    time: Number = Key("at which the value drops to zero", "s")
    level: Number = Key("the value before", "*", default=1.0)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The time of the drop."""
        return (self.time,)

    @property
    def jumps(self) -> tuple[float, ...]:
        """The time of the drop."""
        return (self.time,)

    def value(self, t: float, before: bool = False) -> float:
        """Return the level before the time, zero from then on."""
        return self.level if t < self.time or (before and t == self.time) else 0.0

    def rate(self, t: float, before: bool = False) -> float:
        """Return zero, also on both sides of the drop."""
        del t, before
        return 0.0

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return zero, also on both sides of the drop."""
        del t, before
        return 0.0


class _Rise(TimeFunction):
    """Zero before `start`, and `level` from `end` on."""

    kind: str = Field(default="", kw_only=True, repr=False)
    start: Number = Key("", "s")
    end: Number = Key("later than the start", "s")
    level: Number = Key("the value reached", "*", default=1.0)

    @model_validator(mode="after")
    def _forward(self) -> Self:
        if self.end <= self.start:
            raise RefusedError(
                "a ramp must end after its start",
                f"give a time after {show(self.start)}",
                found=show(self.end),
                at=("end",),
            )
        return self

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Start and end."""
        return (self.start, self.end)

    def _elapsed(self, t: float) -> float:
        """Return the elapsed part of the time of the ramp, 0 to 1."""
        return min(max((t - self.start) / (self.end - self.start), 0.0), 1.0)


class Ramp(_Rise):
    """Zero before `start`, then growing evenly to `level` at `end`, constant after."""

    kind: Literal["ramp"] = Field(default="ramp", kw_only=True, repr=False)

    def value(self, t: float, before: bool = False) -> float:
        """Return the level times the elapsed fraction of the ramp."""
        del before
        return self.level * self._elapsed(t)

    def rate(self, t: float, before: bool = False) -> float:
        """Return the slope on the ramp, zero elsewhere."""
        inside = self.start < t <= self.end if before else self.start <= t < self.end
        return self.level / (self.end - self.start) if inside else 0.0

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return zero, also on both sides of the corners."""
        del t, before
        return 0.0


class SmoothRamp(_Rise):
    """Zero before `start`, then growing smoothly to `level` at `end`, constant after: for angles and displacements.

    value = level (x - sin(2 pi x)/2pi) with x from 0 to 1 (a cycloid), so that speed and acceleration are continuous
    and zero at both ends: a body that is moved so feels no blow.
    """

    kind: Literal["smooth_ramp"] = Field(default="smooth_ramp", kw_only=True, repr=False)

    def value(self, t: float, before: bool = False) -> float:
        """Return the level times the elapsed part of the way."""
        del before
        x = self._elapsed(t)
        return self.level * (x - math.sin(2.0 * math.pi * x) / (2.0 * math.pi))

    def rate(self, t: float, before: bool = False) -> float:
        """Return the first derivative."""
        del before
        x = self._elapsed(t)
        return self.level / (self.end - self.start) * (1.0 - math.cos(2.0 * math.pi * x))

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the second derivative."""
        del before
        x = self._elapsed(t)
        return 2.0 * math.pi * self.level / (self.end - self.start) ** 2 * math.sin(2.0 * math.pi * x)


class Sine(TimeFunction):
    """A harmonic function, offset + amplitude sin(2 pi frequency t + phase)."""

    kind: Literal["sine"] = Field(default="sine", kw_only=True, repr=False)
    frequency: Positive = Key("", "Hz")
    amplitude: Number = Key("of the oscillation", "*", default=1.0)
    phase: Number = Key("", "rad", default=0.0)
    offset: Number = Key("mean value", "*", default=0.0)

    def value(self, t: float, before: bool = False) -> float:
        """Evaluate the formula of the class."""
        del before
        return self.offset + self.amplitude * math.sin(self._omega * t + self.phase)

    def rate(self, t: float, before: bool = False) -> float:
        """Return the first derivative."""
        del before
        return self.amplitude * self._omega * math.cos(self._omega * t + self.phase)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the second derivative."""
        del before
        return -self.amplitude * self._omega**2 * math.sin(self._omega * t + self.phase)

    @property
    def _omega(self) -> float:
        return 2.0 * math.pi * self.frequency


class SpinUp(TimeFunction):
    """The angle of a smooth start of a rotation, as in the manoeuvre of Kane, Ryan and Banerjee (1987).

    The speed w grows from zero to `speed` as w(t) = speed [t/T - sin(2 pi t/T)/2pi] with T = `duration`, so
    that value = speed/T [t^2/2 + (T/2pi)^2 (cos(2 pi t/T) - 1)] until T and speed (t - T/2) after; zero
    before t = 0.
    """

    kind: Literal["spin_up"] = Field(default="spin_up", kw_only=True, repr=False)
    speed: Number = Key("reached after the start, rad/s or m/s, of a rotation or a displacement", "*/s")
    duration: Positive = Key("of the start", "s")

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Start and end of the acceleration (the third derivative jumps there)."""
        return (0.0, self.duration)

    def value(self, t: float, before: bool = False) -> float:
        """Return the angle, rad."""
        del before
        x = t / self.duration
        if x <= 0.0:
            return 0.0
        if x >= 1.0:
            return self.speed * (t - self.duration / 2.0)
        wave = (math.cos(2.0 * math.pi * x) - 1.0) / (4.0 * math.pi**2)
        return self.speed * self.duration * (x * x / 2.0 + wave)

    def rate(self, t: float, before: bool = False) -> float:
        """Return the speed, rad/s."""
        del before
        x = min(max(t / self.duration, 0.0), 1.0)
        return self.speed * (x - math.sin(2.0 * math.pi * x) / (2.0 * math.pi))

    def acceleration(self, t: float, before: bool = False) -> float:
        """Return the angular acceleration, rad/s^2."""
        del before
        x = min(max(t / self.duration, 0.0), 1.0)
        return self.speed / self.duration * (1.0 - math.cos(2.0 * math.pi * x))
