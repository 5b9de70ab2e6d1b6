"""Damping from a loss factor that was measured at one frequency."""

from __future__ import annotations

import math
from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.model.fields.definition import RefusedError
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import OptionalNonNegative, Positive
from viscorod.model.materials.damping_model import Behaviour, Damping, Elastic, bulk_time_of

__all__ = ["LossFactor"]


class LossFactor(Damping):
    """Kelvin-Voigt damping that has a given loss factor (tan delta, loss over storage modulus) at one frequency.

    The loss factor of a Kelvin-Voigt material is omega tau, so that tau = loss factor/(2 pi frequency).
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["loss_factor"] = Field(default="loss_factor", kw_only=True, repr=False)
    frequency: Positive = Key("at which the loss factor was measured", "Hz")
    extension: OptionalNonNegative = Key("loss factor in extension or bending", default=None)
    shear: OptionalNonNegative = Key("loss factor in shear or torsion", default=None)

    @model_validator(mode="after")
    def _one_at_least(self) -> Self:
        if self.extension is None and self.shear is None:
            raise RefusedError("there is no loss factor", "give extension or shear, or both", found="")
        return self

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return the two times; the one that is not given is taken equal."""
        omega = 2.0 * math.pi * self.frequency
        known = f"the loss factor is that given at {self.frequency:.6g} Hz only; it grows in proportion to frequency"
        if self.extension is None or self.shear is None:
            word, other = ("shear", "extension") if self.extension is None else ("extension", "shear")
            factor = self.shear if self.extension is None else self.extension
            time = (factor or 0.0) / omega
            equal = f"the loss factor in {other} was not given and is taken equal to that in {word}"
            return Behaviour(*elastic, time, time, assumptions=(known, equal))
        bulk = bulk_time_of(self.extension, self.shear, elastic.poissons_ratio, ("extension",), unit="")
        derived = f"the bulk time of {bulk / omega:.4g} s follows from the loss factors in extension and shear (LLT 4)"
        return Behaviour(*elastic, self.shear / omega, bulk / omega, assumptions=(known, derived))
