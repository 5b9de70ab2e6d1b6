"""Settings of small vibrations."""

from __future__ import annotations

from typing import Annotated, Any

from viscorod.given_as import GivenAs
from viscorod.model.fields.forms import of_kind
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    Flag,
    OptionalPositive,
    one_of,
    whole_number,
)
from viscorod.solve.settings.mesh import Meshed
from viscorod.solve.start import Start, as_start

__all__ = ["AboutField", "ModesSettings"]


ABOUT = ("equilibrium", "released", "reference")


@accepts(
    {"anyOf": [{"enum": list(ABOUT)}, of_kind("start")]},
    '`"equilibrium"`, `"released"` or `"reference"`, or a table, see `start`',
    "a result, or one with a time: `(run, 1.5)`",
)
def _about(value: Any) -> str | Start:
    if isinstance(value, str) and (value in ABOUT or not value.endswith(".nc")):
        return one_of(*ABOUT)(value)
    found = as_start(value)
    assert found is not None
    return found


AboutField = Annotated[GivenAs[str | Start, Any], _about]


class ModesSettings(Meshed):
    """Which small vibrations are sought."""

    count: Annotated[int, whole_number(1, 100_000)] = Key("number of modes, 1 to 100 000", default=6)
    about: AboutField = Key(
        '"equilibrium" under the loads at t = 0- (just before t = 0), the equilibrium once "released", under those '
        'just after t = 0, or the "reference" shape (as if free of load); a state of an earlier result: about the '
        "equilibrium under the loads at t = 0- that is found from there, of a motion that moves there with "
        "`at_rest = true` only",
        default="equilibrium",
    )
    near: OptionalPositive = Key(
        "those whose natural frequencies are nearest to this one, in place of the slowest", "Hz", default=None
    )
    oscillating: Flag = Key("leave out rigid motions and overdamped modes", default=False)
