"""Settings of critical loads."""

from __future__ import annotations

from typing import Annotated, Any

from viscorod.given_as import GivenAs, Words
from viscorod.model.fields.forms import TEXT, listed
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import Flag, Number, different, whole_number, word
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.mesh import Meshed

__all__ = ["BucklingSettings", "ConstantNames"]


@accepts(listed(TEXT), "list of names")
def _names(value: Any) -> tuple[str, ...]:
    return different(value, word, "load")


ConstantNames = Annotated[GivenAs[tuple[str, ...], Words], _names]
"""What acts in full throughout."""


class BucklingSettings(Meshed):
    """Which critical loads are sought."""

    count: Annotated[int, whole_number(1, 100)] = Key(
        "number of critical load factors, 1 to 100, from the first one on", default=3
    )
    about: Number = Key(
        "load factor of the state about which the linear problem is solved; critical ones beyond it are sought",
        default=0.0,
    )
    constant: ConstantNames = Key(
        "what acts in full throughout, the prestress, by the names of stages: loads by their `name` or kind, "
        "prescribed motions by their places. All else grows with the load factor",
        default=(),
    )
    exact: Flag = Key(
        "follow the equilibria up to the critical points, and so take into account how the model deforms before; "
        "false keeps to the linear problem",
        default=True,
    )

    @property
    def course(self) -> Course:
        """See :class:`Meshed`; how far the load has to grow is what is sought."""
        return Course("load", "", self.about, None)
