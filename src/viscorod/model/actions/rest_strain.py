"""Strains at which rods are free of stress: along the rods, and in time."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, Self

import numpy as np
from pydantic import model_validator

from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.initial_strain import six_strains, strain_field
from viscorod.model.actions.time_function import Constant, TimeFunction
from viscorod.model.actions.time_function_kinds import TimeField, time_function
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import listed, quantity, row
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import Name, OptionalNumber, numbers, sequence
from viscorod.model.rod import Rod
from viscorod.model.sections.section_base import AnySection
from viscorod.typing import Floats

__all__ = ["RestStrain"]

INSTANT = 1e-8
"""Interval over which a Python function of time is differentiated, s, or as a part of the time."""


@accepts(listed(quantity(), 2), "list of 2 numbers or more")
def _stations(value: Any) -> tuple[float, ...]:
    return numbers(value, at_least=2)


@accepts(row([quantity(), quantity()]), "2 numbers")
def _two(value: Any) -> tuple[float, ...]:
    return numbers(value, count=2)


@accepts(listed(row([quantity(unit=k // 3) for k in range(6)]), 2), "list of lists of 6 numbers")
def _rows(value: Any) -> tuple[tuple[float, ...], ...]:
    return tuple(six_strains(item) for item in sequence(value))


class RestStrain(Definition):
    """The strain at which a rod is free of stress: a heated side, a muscle, growth, swelling, a prestress.

    Section forces follow from the strain less this one, viscous ones from the rate of this difference. Without supports
    that resist it the rod takes it without any force. A load factor multiplies it like a load. Rest strains of one rod
    add up. `value` is constant along the rod, or a Python function of the arc length, or of arc length and time (s, t);
    `stations` with `values` are a table along the rod, linear between stations; a station that is given twice is a
    jump. In their place `temperature` is a rise of the temperature, with a `gradient` across the section: the strain
    follows from the thermal expansion of the materials. `time` scales what is given.
    """

    rod: Name = Key("name of the rod")
    value: Annotated[Any, optional(strain_field)] = Key(
        "shear 1, shear 2, stretch ({}), bend 1, bend 2, twist ({})", "1", "1/m", default=None
    )
    time: TimeField = Key("function of time that scales it", default=None)
    stations: Annotated[Sequence[float] | None, optional(_stations)] = Key(
        "in place of value, arc lengths of a table along the rod, not decreasing",
        "m",
        default=None,
        kw_only=True,
    )
    values: Annotated[Sequence[Sequence[float]] | None, optional(_rows)] = Key(
        "strains there: shear 1, shear 2, stretch ({}), bend 1, bend 2, twist ({})",
        "1",
        "1/m",
        default=None,
        kw_only=True,
    )
    temperature: OptionalNumber = Key(
        "in place of value, rise of the temperature of the centre line", "K", default=None, kw_only=True
    )
    gradient: Annotated[Sequence[float] | None, optional(_two)] = Key(
        "its slopes along d1 and d2", "K/m", default=None, kw_only=True
    )

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        table = self.stations is not None or self.values is not None
        heat = self.temperature is not None or self.gradient is not None
        if (self.value is not None) + table + heat != 1:
            raise RefusedError(
                "the strain is given by value, by a table along the rod, or by a temperature",
                "give one of value, stations with values, and temperature",
                found="several of them" if table + heat else "missing",
                at=("value",),
            )
        if table:
            self._fitting(self.stations, self.values)
        if self.sees_time and self.time is not None:
            raise RefusedError(
                "the function of arc length and time has the time in it already",
                "leave time out, or give a function of the arc length alone",
                found=show(self.time),
                at=("time",),
            )
        return self

    @staticmethod
    def _fitting(stations: Sequence[float] | None, values: Sequence[Sequence[float]] | None) -> None:
        """Refuse a table that is none."""
        for name, other, given in (("stations", "values", stations), ("values", "stations", values)):
            if given is None:
                raise RefusedError(
                    f"{other} are those of a table", f"give {name} too", found="missing", at=(name,)
                )
        assert stations is not None
        assert values is not None
        if len(stations) != len(values):
            raise RefusedError(
                "there must be as many values as stations",
                f"give {len(stations)} lists",
                found=f"{len(values)} lists for {len(stations)} stations",
                at=("values",),
            )
        for index, (before, after) in enumerate(pairwise(stations)):
            if after < before or (index > 0 and stations[index - 1] == after):
                raise RefusedError(
                    "stations must not decrease, nor be the same three times",
                    f"give an arc length after {show(before)}, or the same once more for a jump",
                    found=show(after),
                    at=("stations", index + 1),
                )

    @cached_property
    def sees_time(self) -> bool:
        """Whether `value` is a function of arc length and time."""
        if not callable(self.value):
            return False
        try:
            wanted = [
                p
                for p in inspect.signature(self.value).parameters.values()
                if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) and p.default is p.empty
            ]
        except ValueError:  # built in
            return False
        return len(wanted) == 2

    @property
    def changes(self) -> bool:
        """Whether it changes with time."""
        return self.sees_time or not (self.time is None or isinstance(self.time, Constant))

    def at(self, s: float, t: float = 0.0) -> Floats:
        """Return the strains (6,) at the arc length `s` [m] with the factor 1, at the time `t` [s] if they see it."""
        if self.stations is not None and self.values is not None:
            return self._interpolated(s)
        assert self.value is not None, "a temperature is one of a rod: see on"
        if not callable(self.value):
            return np.array(self.value, dtype=float)
        given: Callable[..., Any] = self.value
        when = f", t = {t:.9g} s" if self.sees_time else ""
        strains = returned(
            given,
            *((s, t) if self.sees_time else (s,)),
            check=six_strains,
            name=f"the function of the rest strain of {self.rod!r}",
            where=f"at s = {s:.6g} m{when}",
            instead="return six numbers",
            at=("value",),
        )
        return np.array(strains)

    def on(self, rod: Rod) -> RestStrain:
        """Return it as strains of this rod: itself, unless a temperature gives them.

        Raises:
            RefusedError: the thermal expansion of a material is not known.
        """
        if self.temperature is None and self.gradient is None:
            return self
        along_d1, along_d2 = self.gradient or (0.0, 0.0)
        rise = np.array([0.0, 0.0, self.temperature or 0.0, along_d2, -along_d1, 0.0])

        def strain(s: float) -> Sequence[float]:
            section = rod.section_at(s)
            material = rod.material if section.needs_material else None
            found: list[float] = section.thermal_strain(rise, material).tolist()
            return found

        constant = isinstance(rod.section, AnySection)
        return RestStrain(self.rod, strain(0.0) if constant else strain, self.time)

    def figures(self, rod: Rod) -> dict[str, float | str]:
        """Return what ``viscorod check`` prints: the strains at the start of its rod, with the factor 1, and when."""
        strains = self.on(rod).at(0.0)
        when = "its function" if self.sees_time else "constant"
        if self.time is not None:
            when = str(type(self.time).model_fields["kind"].default)
        return {
            "shear 1": float(strains[0]),
            "shear 2": float(strains[1]),
            "stretch": float(strains[2]),
            "bend 1 [1/m]": float(strains[3]),
            "bend 2 [1/m]": float(strains[4]),
            "twist [1/m]": float(strains[5]),
            "in time": when,
        }

    def _interpolated(self, s: float) -> Floats:
        """Return the strains of the table; at a jump those after it, beyond its ends those at the ends."""
        stations, values = np.asarray(self.stations), np.asarray(self.values)
        after = int(np.searchsorted(stations, s, side="right"))
        if after in (0, len(stations)):
            return np.array(values[min(after, len(stations) - 1)])
        part = (s - stations[after - 1]) / (stations[after] - stations[after - 1])
        return np.asarray((1.0 - part) * values[after - 1] + part * values[after])

    def factor(self, t: float, before: bool = False) -> float:
        """Return what scales the strains at the time `t` [s] (the limit from the left if `before`)."""
        return 1.0 if self.time is None else self._named_time.value(t, before)

    @cached_property
    def _named_time(self) -> TimeFunction:
        """The function of time with what it belongs to, for its messages."""
        assert self.time is not None
        return time_function(self.time).of(f"the time of the rest strain of {self.rod!r}")

    def factor_rate(self, t: float, before: bool = False) -> float:
        """Return the rate of the factor [1/s]; of a Python function without one, by a difference."""
        if self.time is None:
            return 0.0
        if isinstance(self.time, FunctionOfTime) and self.time.rate_function is None:
            step = -instant(t) if before else instant(t)
            return (self._named_time.value(t + step) - self._named_time.value(t, before)) / step
        return self._named_time.rate(t, before)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """Times at which the factor, its rate or its acceleration is not smooth, increasing, s."""
        return () if self.time is None else self.time.breakpoints

    @property
    def jumps(self) -> tuple[float, ...]:
        """Times at which the factor jumps, increasing, s."""
        times = () if self.time is None else self.time.jumps
        return tuple(t for t in times if self.factor(t) != self.factor(t, before=True))

    def misfits(self, rod: Rod) -> Iterator[RefusedError]:
        """Yield what is wrong with it on its rod."""
        length = rod.length
        try:
            self.on(rod)
        except RefusedError as error:
            yield error
        if (
            self.stations is not None
            and not -1e-9 * length <= self.stations[0] <= self.stations[-1] <= (1.0 + 1e-9) * length
        ):
            outside = self.stations[0] if self.stations[0] < 0.0 else self.stations[-1]
            yield RefusedError(
                f"the rod ends at {length:.12g} m",
                "give arc lengths on the rod",
                found=show(outside),
                at=("stations",),
            )


def instant(t: float) -> float:
    """Return the interval [s] over which functions of time are differentiated at `t`."""
    return INSTANT * max(1.0, abs(t))
