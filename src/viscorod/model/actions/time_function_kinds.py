"""All kinds of functions of time by their words, and the parser of what may stand for one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from viscorod.model.actions.function_of_time import FunctionOfTime
from viscorod.model.actions.time_function import Constant, Ramp, Sine, SmoothRamp, SpinUp, TimeFunction, Until
from viscorod.model.actions.time_table import TimeTable
from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.forms import of_kind, quantity
from viscorod.model.fields.metadata import accepts, optional
from viscorod.model.fields.quantities import waits
from viscorod.model.fields.values import choose, number

__all__ = ["TIME_FUNCTIONS", "TimeField", "time_function"]

TIME_FUNCTIONS: dict[str, type[Definition]] = {
    "constant": Constant,
    "until": Until,
    "ramp": Ramp,
    "smooth_ramp": SmoothRamp,
    "sine": Sine,
    "table": TimeTable,
    "spin_up": SpinUp,
}
"""The functions of time by their word in a case file; a new one is one class and one line here."""

_from_table = choose("kind", TIME_FUNCTIONS)


@accepts(quantity(of_kind("time")), "number, or table with `kind`, see Functions of time")
def time_function(value: Any) -> TimeFunction:
    """Return `value` as a function of time: one of the kinds, a plain number (constant) or a Python function."""
    if isinstance(value, TimeFunction):
        return value
    if isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool):
        return Constant(number(value))
    if isinstance(value, Mapping):
        parsed = _from_table(value)
        if waits(parsed):
            raise RefusedError(
                "the unit in this table is that of what the function of time describes, which is not known here",
                "give an object, such as vr.Ramp, or plain numbers in SI",
            )
        assert isinstance(parsed, TimeFunction)
        return parsed
    if callable(value) and not isinstance(value, Definition | type):
        return FunctionOfTime(value)
    raise RefusedError(
        "a function of time is needed here",
        f"give a number or a table with kind = one of {', '.join(TIME_FUNCTIONS)}",
    )


TimeField = Annotated[TimeFunction | None, optional(time_function)]
