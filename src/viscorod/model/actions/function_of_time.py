"""Functions of time that are Python functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Annotated, Any, Literal, Self

from pydantic import Field

from viscorod.model.actions.time_function import TimeFunction
from viscorod.model.fields.definition import RefusedError, base_init
from viscorod.model.fields.metadata import accepts, optional
from viscorod.model.fields.users_functions import returned
from viscorod.model.fields.values import function, number, numbers

__all__ = ["FunctionOfTime"]


@accepts(None)
def _times(value: Any) -> tuple[float, ...]:
    return tuple(sorted(set(numbers(value, at_least=0))))


OptionalFunction = Annotated[Callable[[float], float] | None, optional(function)]


class FunctionOfTime(TimeFunction):
    """A Python function of the time (not in case files).

    Args:
        function: t -> value.
        rate: t -> first derivative; needed for prescribed motions.
        acceleration: t -> second derivative; needed for prescribed motions.
        breakpoints: times at which one of the three is not smooth, s; the function gives there the value
            after.
    """

    kind: Literal["function"] = Field(default="function", kw_only=True, repr=False)
    value_function: Annotated[Callable[[float], float], function]
    rate_function: OptionalFunction = None
    acceleration_function: OptionalFunction = None
    break_times: Annotated[Sequence[float], _times] = ()
    _of: str = ""

    @base_init
    def __init__(
        self,
        function: Callable[[float], float],
        rate: Callable[[float], float] | None = None,
        acceleration: Callable[[float], float] | None = None,
        breakpoints: Sequence[float] = (),
    ) -> None:
        given: dict[str, Any] = {
            "value_function": function,
            "rate_function": rate,
            "acceleration_function": acceleration,
            "break_times": breakpoints,
        }
        super().__init__(**given)

    @property
    def breakpoints(self) -> tuple[float, ...]:
        """The given times."""
        return tuple(self.break_times)

    @property
    def jumps(self) -> tuple[float, ...]:
        """The given times at which the value before differs from the value after."""
        return tuple(
            t
            for t in self.break_times
            if not math.isclose(self.value(t), self.value(t, before=True), rel_tol=1e-9)
        )

    def value(self, t: float, before: bool = False) -> float:
        """Call the function."""
        return self._call(self.value_function, t, before)

    def rate(self, t: float, before: bool = False) -> float:
        """Call the function `rate`."""
        self.require_derivatives()
        return self._call(self.rate_function, t, before)

    def acceleration(self, t: float, before: bool = False) -> float:
        """Call the function `acceleration`."""
        self.require_derivatives()
        return self._call(self.acceleration_function, t, before)

    def require_derivatives(self) -> None:
        """Refuse missing derivatives."""
        if self.rate_function is None or self.acceleration_function is None:
            raise RefusedError(
                "a prescribed motion needs its velocity and acceleration",
                "give FunctionOfTime(function, rate, acceleration) with both derivatives",
                found="a function of time without rate and acceleration",
            )

    def of(self, owner: str) -> Self:
        """Return the function with what it belongs to, for messages."""
        named = self.model_copy()
        named._of = f"{owner}: "
        return named

    def _call(self, function: Callable[[float], float] | None, t: float, before: bool) -> float:
        assert function is not None
        at = math.nextafter(t, -math.inf) if before and t in self.break_times else t
        return returned(
            function,
            at,
            check=number,
            name=f"{self._of}the function of time",
            where=f"at t = {t:.9g} s",
            instead="make it return a finite number at all times",
        )
