"""A section whose dimensions change linearly along a rod."""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from pydantic import model_validator

from viscorod.model.fields.definition import Definition, RefusedError
from viscorod.model.fields.metadata import Key
from viscorod.model.sections.section_base import AnySection
from viscorod.model.sections.section_kinds import SectionField

__all__ = ["Taper"]


class Taper(Definition):
    """A section whose every dimension changes linearly along the rod."""

    start: SectionField = Key("section at s = 0")
    end: SectionField = Key("section at the end, of the same shape")

    @model_validator(mode="after")
    def _same_shape(self) -> Self:
        if type(self.start) is not type(self.end):
            raise RefusedError(
                "a taper joins two sections of the same shape",
                "give start and end the same shape",
                found=f"{type(self.start).__name__} and {type(self.end).__name__}",
            )
        if not self.start.can_taper:
            raise RefusedError(
                "such a section would need a mesh of its own at every station",
                "give pieces, each with its section",
                found=type(self.start).__name__,
                at=("start",),
            )
        for name in type(self.start).model_fields:
            if (getattr(self.start, name) is None) != (getattr(self.end, name) is None):
                raise RefusedError(
                    f"{name} is given at one end only",
                    f"give {name} at both ends or at none",
                    found="",
                    at=(name,),
                )
        return self

    def at(self, fraction: float) -> AnySection:
        """Return the section at a fraction (0 to 1) of the length."""
        mixed: dict[str, Any] = {}
        for name in type(self.start).model_fields:
            first, last = getattr(self.start, name), getattr(self.end, name)
            if name == self.start.tag or first is None:
                mixed[name] = first
            else:
                mixed[name] = ((1.0 - fraction) * np.asarray(first) + fraction * np.asarray(last)).tolist()
        return type(self.start)(**mixed)
