"""Attachments: two places that are one rigid node."""

from __future__ import annotations

from typing import Self

from pydantic import model_validator

from viscorod.model.connections.place import PlaceField
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.metadata import Key

__all__ = ["Attachment"]


class Attachment(Definition):
    """Two coinciding places joined rigidly, at whatever angle the rods meet; or a rod's place and a rigid body."""

    a: PlaceField = Key('place, such as "column.end"')
    b: PlaceField = Key('place, such as "girder.start", or the name of a body, which reaches everywhere')

    @model_validator(mode="after")
    def _two_places(self) -> Self:
        if self.a == self.b:
            raise RefusedError(
                "a place cannot be attached to itself", "give two places", found=show(self.b), at=("b",)
            )
        return self
