"""Kelvin-Voigt damping by times or viscosities (Linn, Lang and Tuganov 2013, called LLT, equations 3-4)."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import Field, model_validator

from viscorod.model.fields.definition import RefusedError
from viscorod.model.fields.metadata import Key
from viscorod.model.fields.values import OptionalNonNegative
from viscorod.model.materials.damping_model import Behaviour, Damping, Elastic, bulk_time_of

__all__ = ["KelvinVoigt"]


class KelvinVoigt(Damping):
    """Kelvin-Voigt viscosity of a material: one pair of times or one pair of viscosities."""

    tag: ClassVar[str | None] = "kind"

    hints: ClassVar[dict[str, str]] = dict.fromkeys(
        ("ratio", "damping_ratio", "zeta", "logarithmic_decrement"),
        "a measured damping ratio of a mode is damping of kind 'modal' (MeasuredDamping), with the keys ratio or "
        "logarithmic_decrement, and mode",
    )

    kind: Literal["kelvin_voigt"] = Field(default="kelvin_voigt", kw_only=True, repr=False)
    shear_time: OptionalNonNegative = Key(
        "retardation time in shear, viscosity over shear modulus", "s", default=None
    )
    bulk_time: OptionalNonNegative = Key(
        "retardation time in volume change, viscosity over bulk modulus", "s", default=None
    )
    shear_viscosity: OptionalNonNegative = Key("", "Pa s", default=None)
    bulk_viscosity: OptionalNonNegative = Key("", "Pa s", default=None)
    extensional_time: OptionalNonNegative = Key(
        "retardation time in extension, with shear_time and in place of bulk_time", "s", default=None
    )

    @model_validator(mode="after")
    def _one_pair(self) -> Self:
        pairs = (
            (self.shear_time, self.bulk_time),
            (self.shear_viscosity, self.bulk_viscosity),
            (self.shear_time, self.extensional_time),
        )
        given = [
            name for name in type(self).model_fields if name != "kind" and getattr(self, name) is not None
        ]
        complete = [pair for pair in pairs if None not in pair]
        if len(given) != 2 or len(complete) != 1:
            raise RefusedError(
                "the viscosity needs one complete pair",
                "give shear_time and bulk_time (s), shear_viscosity and bulk_viscosity (Pa s), or "
                "shear_time and extensional_time (s)",
                found=f"given: {', '.join(given) or 'nothing'}",
            )
        return self

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return the two times; a bulk time follows from that in extension by LLT (4)."""
        young, nu = elastic
        assumptions: tuple[str, ...] = ()
        if self.shear_viscosity is not None:
            assert self.bulk_viscosity is not None
            shear = self.shear_viscosity / elastic.shear_modulus
            bulk = self.bulk_viscosity / elastic.bulk_modulus
        elif self.extensional_time is not None:
            shear = self.shear_time or 0.0
            bulk = bulk_time_of(self.extensional_time, shear, nu, ("extensional_time",))
            text = f"the bulk time of {bulk:.4g} s follows from the times in extension and shear (LLT 4)"
            assumptions = (text,)
        else:
            shear, bulk = self.shear_time or 0.0, self.bulk_time or 0.0
        return Behaviour(
            young,
            nu,
            shear,
            bulk,
            self.bulk_viscosity,
            assumptions=assumptions,
            doubts=self._doubts(nu, shear),
        )

    def _doubts(self, nu: float, shear: float) -> tuple[str, ...]:
        """Return that the viscosity against changes of volume is without effect where there are none (LLT 3)."""
        key = "bulk_time" if self.bulk_viscosity is None else "bulk_viscosity"
        given = getattr(self, key)
        if nu != 0.5 or not given or (key == "bulk_time" and given == shear):
            return ()
        return (
            f"damping.{key} = {given:.4g} has no effect: with a Poisson's ratio of 0.5 volume does not change, and the "
            "shear alone damps; give a Poisson's ratio below 0.5 if it is to matter",
        )
