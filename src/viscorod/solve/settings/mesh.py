"""What is wanted of a mesh, in the settings of every analysis."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.forms import POSITIVE, quantity
from viscorod.model.fields.metadata import Key, accepts
from viscorod.model.fields.values import (
    positive,
)
from viscorod.solve.settings.course import Course

__all__ = ["LARGEST_TOLERANCE", "Meshed"]


LARGEST_TOLERANCE, LEAST_ACCURACY = 0.1, 1e-8


@accepts(quantity(bounds=POSITIVE), "number from 1e-8 to 0.1")
def _accuracy(value: Any) -> float:
    wanted = positive(value)
    if not LEAST_ACCURACY <= wanted <= LARGEST_TOLERANCE:
        raise RefusedError("out of reach", f"give {LEAST_ACCURACY:g} to {LARGEST_TOLERANCE:g}")
    return wanted


class Meshed(Definition):
    """What is wanted of a mesh."""

    needs: ClassVar[str] = ""
    """What stands in the table of the analysis at least, in words."""

    accuracy: Annotated[float, _accuracy] = Key(
        "wanted accuracy of the mesh where a rod leaves out elements: estimated error of positions over the largest "
        "displacement, of section forces over the largest one, of each listed frequency over itself. The mesh is "
        "refined until it is reached. A motion whose tolerance is larger takes that unless accuracy is given",
        default=1e-4,
        kw_only=True,
    )

    @property
    def course(self) -> Course:
        """What grows while the analysis goes on: the load, in parts of it, unless it says otherwise."""
        return Course("load", "", 0.0, 1.0)
