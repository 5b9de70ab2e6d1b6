"""Attachments: two places that are one rigid node."""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from viscorod.model.connections.place import PlaceField
from viscorod.model.fields.definition import Definition, RefusedError, show

__all__ = ["Attachment"]


class Attachment(Definition):
    """Two coinciding places joined rigidly, at whatever angle the rods meet; or a rod's place and a rigid body.

    Args:
        a: place, such as "column.end".
        b: place, such as "girder.start", or the name of a body, which reaches everywhere.
    """

    a: PlaceField = Field(description="place, such as 'column.end'")
    b: PlaceField = Field(description="place, such as 'girder.start'")

    @model_validator(mode="after")
    def _two_places(self) -> Self:
        if self.a == self.b:
            raise RefusedError(
                "a place cannot be attached to itself", "give two places", found=show(self.b), at=("b",)
            )
        return self
