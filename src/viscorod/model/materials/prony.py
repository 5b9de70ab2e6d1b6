"""Prony series of a material, as finite-element programs and material data sheets give them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.limits import SMALLEST_NUMBER
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, POSITIVE, Form, listed, quantity
from viscorod.model.fields.metadata import Check, Key, accepts, optional
from viscorod.model.fields.values import frequency_band, numbers, one_of
from viscorod.model.materials.damping_model import Behaviour, Damping, Elastic, maxwell_branches
from viscorod.model.materials.nearest_kelvin_voigt import (
    Viscous,
    band_of,
    errors,
    far_from,
    nearest_kelvin_voigt,
)
from viscorod.model.materials.relaxation_modulus import RelaxationModulus, extension_of
from viscorod.quantity_text import per_cent

__all__ = ["Prony"]

MOST_BRANCHES = 200
STRAINS = ("shear", "bulk", "extension")

Series = Sequence[float]


def _numbers(allowed: str, low: float, bounds: Form) -> Check[tuple[float, ...]]:
    @accepts(listed(quantity(bounds=bounds)), f"list of numbers {allowed}")
    def check(value: Any) -> tuple[float, ...]:
        items = numbers(value)
        if len(items) > MOST_BRANCHES:
            raise RefusedError(
                "more branches than can be meant",
                f"give {MOST_BRANCHES} at most",
                found=f"{len(items)} numbers",
            )
        for index, item in enumerate(items):
            if not (item >= SMALLEST_NUMBER or item == low):
                raise RefusedError(
                    "outside what is allowed", f"give numbers {allowed}", found=show(item), at=(index,)
                )
        return items

    return check


_moduli = _numbers(">= 0", 0.0, NOT_NEGATIVE)
_times = _numbers("> 0", SMALLEST_NUMBER, POSITIVE)

Moduli = Annotated[GivenAs[Series | None, Amounts | None], optional(_moduli)]
Times = Annotated[GivenAs[Series | None, Amounts | None], optional(_times)]
REFERENCES = ("equilibrium", "instantaneous")


class Prony(Damping):
    """Relaxation of the moduli as Prony series, with a Maxwell branch for every term.

    G(t) = G_inf + sum G_j exp(-t/tau_j), and the same for the bulk modulus K or for Young's modulus. A modulus of a
    term is given as such or as its ratio to the whole modulus. Abaqus and Ansys give ratios to the *instantaneous*
    modulus (g_i of G_0 = G_inf + sum G_j: Abaqus Analysis User's Guide, "Time domain viscoelasticity"; Ansys,
    "TB,PRONY"), whatever the elastic constants beside them are; that is ``ratios_of = "instantaneous"``.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["prony"] = Field(default="prony", kw_only=True, repr=False)
    shear_moduli: Moduli = Key("G_j", "Pa", default=None)
    shear_times: Times = Key("relaxation times of the terms of the shear modulus", "s", default=None)
    bulk_moduli: Moduli = Key("K_j", "Pa", default=None)
    bulk_times: Times = Key("relaxation times of the terms of the bulk modulus", "s", default=None)
    shear_ratios: Moduli = Key("in place of shear_moduli, fractions of the shear modulus", default=None)
    bulk_ratios: Moduli = Key("in place of bulk_moduli, fractions of the bulk modulus", default=None)
    extension_moduli: Moduli = Key(
        "E_j, {}; in place of shear and bulk, with a constant Poisson's ratio", "Pa", default=None
    )
    extension_times: Times = Key("relaxation times of the terms of Young's modulus", "s", default=None)
    extension_ratios: Moduli = Key("in place of extension_moduli, fractions of Young's modulus", default=None)
    constant: Annotated[str | None, optional(one_of("poissons_ratio", "bulk_modulus", "shear_modulus"))] = (
        Key(
            'what does not relax if only one modulus is given: "poissons_ratio", "bulk_modulus" or "shear_modulus"',
            default=None,
        )
    )
    moduli: Annotated[str, one_of(*REFERENCES)] = Key(
        'what the elastic constants of the material are: "equilibrium" (after a long time) or "instantaneous"',
        default="equilibrium",
    )
    ratios_of: Annotated[str | None, optional(one_of(*REFERENCES))] = Key(
        'the modulus of which ratios are fractions, "equilibrium" or "instantaneous"; left out, that of moduli',
        default=None,
    )
    law: Annotated[str, one_of("maxwell", "kelvin_voigt")] = Key(
        '"maxwell" keeps every branch; "kelvin_voigt" replaces them by one viscosity, that of slow motion',
        default="maxwell",
    )
    band: Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(frequency_band)] = Key(
        'lowest and highest frequency of the motion, {}: with the law "kelvin_voigt", moduli and viscosities are then '
        "those nearest to the Prony series over this band, not those of slow motion",
        "Hz",
        default=None,
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        strains = [strain for strain in STRAINS if self._terms(strain)]
        if not strains:
            raise RefusedError(
                "a Prony series has at least one term",
                "give shear_moduli (Pa) or shear_ratios with shear_times (s), or the same of bulk or extension",
                found="",
            )
        if "extension" in strains and len(strains) > 1:
            raise RefusedError(
                "of extension, shear and volume change two at most are independent, and here those are shear and bulk",
                "give shear and bulk, or extension alone",
                found=f"given: {', '.join(strains)}",
            )
        if self.ratios_of is not None and not any(getattr(self, f"{strain}_ratios") for strain in strains):
            raise RefusedError("there are no ratios", "leave it out", at=("ratios_of",), found=self.ratios_of)
        if self.band is not None and self.law == "maxwell":
            raise RefusedError(
                "Maxwell branches hold at every frequency",
                "leave it out, or give law = 'kelvin_voigt'",
                found=show(list(self.band)),
                at=("band",),
            )
        self._constant_fits(strains)
        return self

    def _terms(self, strain: str) -> bool:
        """Return whether there are terms for a strain; they must be complete."""
        moduli, ratios, times = (getattr(self, f"{strain}_{word}") for word in ("moduli", "ratios", "times"))
        if moduli is None and ratios is None and times is None:
            return False
        if (moduli is None) == (ratios is None) or times is None:
            given = [w for w in ("moduli", "ratios", "times") if getattr(self, f"{strain}_{w}") is not None]
            raise RefusedError(
                f"the terms of {strain} need a modulus or a ratio, and a time each",
                f"give {strain}_moduli (Pa) or {strain}_ratios, and {strain}_times (s)",
                found="given: " + ", ".join(f"{strain}_{word}" for word in given),
            )
        amount = moduli if moduli is not None else ratios
        if len(amount) != len(times):
            raise RefusedError(
                f"the terms of {strain} need as many times as moduli or ratios",
                f"give {len(amount)} times",
                found=f"{len(times)} times for {len(amount)}",
                at=(f"{strain}_times",),
            )
        return True

    def _constant_fits(self, strains: list[str]) -> None:
        allowed: dict[tuple[str, ...], tuple[str | None, ...]] = {
            ("shear",): ("poissons_ratio", "bulk_modulus"),
            ("bulk",): ("poissons_ratio", "shear_modulus"),
            ("shear", "bulk"): (None,),
            ("extension",): (None, "poissons_ratio"),
        }
        words = allowed[tuple(strains)]
        if self.constant in words:
            return
        known = " or ".join(repr(word) for word in words if word)
        if self.constant is None:
            raise RefusedError(
                f"with terms of {strains[0]} alone, what stays constant must be said",
                f"add constant = {known}",
                found="",
                at=("constant",),
            )
        raise RefusedError(
            f"with terms of {' and '.join(strains)} this is not constant",
            f"give {known}" if known else "leave it out",
            found=show(self.constant),
            at=("constant",),
        )

    def behaviour_at(self, elastic: Elastic, shift: float) -> Behaviour:
        """Return the behaviour at another temperature; the band of the motion remains what it is."""
        times = {
            f"{strain}_times": tuple(time * shift for time in getattr(self, f"{strain}_times") or ()) or None
            for strain in STRAINS
        }
        return self.model_copy(update=times).behaviour(elastic)

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return branches of extension and shear: E* = 9 K* G*/(3 K* + G*) by the correspondence principle."""
        extension, shear, bulk, nu = self._relaxations(elastic)
        given = "instantaneous moduli" if self.moduli == "instantaneous" else "equilibrium moduli"
        assumptions = [f"the elastic constants of the material are its {given}"]
        if self.constant is not None or self.extension_times is not None:
            word = (self.constant or "poissons_ratio").replace("_", " ").replace("poissons", "Poisson's")
            assumptions.append(f"the {word} does not relax")
        rest = Elastic(extension.equilibrium, nu)
        times = shear.retardation_time, (bulk if math.isfinite(bulk.equilibrium) else shear).retardation_time
        if self.law == "maxwell":
            found = Behaviour(*rest, *times, branches=maxwell_branches(extension, shear))
        elif self.band is None:
            found = Behaviour(*rest, *times)
            assumptions.append("one viscosity replaces the Prony series: it is right in slow motion only")
        else:
            found = _nearest(shear, bulk, self.band)
            viscous = Viscous(found.youngs_modulus, _extensional_viscosity(found))
            omega = band_of(self.band)
            exact = extension.complex_modulus(omega)
            wrong = [100.0 * float(np.abs(e).max()) for e in errors(exact, viscous.complex_modulus(omega))]
            assumptions.append(
                f"moduli and viscosities are those nearest to the Prony series from {self.band[0]:.4g} to "
                f"{self.band[1]:.4g} Hz: there Young's storage modulus is wrong by {per_cent(wrong[0])} at most and "
                f"its loss modulus by {per_cent(wrong[1])}; at rest Young's modulus would be "
                f"{rest.youngs_modulus:.4g} Pa"
            )
            found = replace(found, doubts=far_from("the Prony series", omega, *wrong))
        return replace(found, extension=extension, shear=shear, assumptions=tuple(assumptions))

    def _relaxations(
        self, elastic: Elastic
    ) -> tuple[RelaxationModulus, RelaxationModulus, RelaxationModulus, float]:
        """Return the relaxation of Young's, the shear and the bulk modulus, and Poisson's ratio at rest."""
        nu = elastic.poissons_ratio
        if self.extension_times is not None:
            extension = self._series("extension", elastic.youngs_modulus)
            shear = extension.scaled(0.5 / (1.0 + nu))
            return extension, shear, _bulk(shear, nu), nu
        if self.bulk_times is not None and nu == 0.5:
            raise RefusedError(
                "an incompressible material (nu = 0.5) has no volume change that could relax",
                "leave out the terms of bulk, or give a Poisson's ratio below 0.5",
                found="",
                at=("bulk_times",),
            )
        if self.constant == "poissons_ratio":
            if self.shear_times is not None:
                shear = self._series("shear", elastic.shear_modulus)
            else:
                bulk = self._series("bulk", elastic.bulk_modulus)
                shear = bulk.scaled(elastic.shear_modulus / elastic.bulk_modulus)
            return shear.scaled(2.0 * (1.0 + nu)), shear, _bulk(shear, nu), nu
        shear, bulk = RelaxationModulus(elastic.shear_modulus), RelaxationModulus(elastic.bulk_modulus)
        if self.shear_times is not None:
            shear = self._series("shear", elastic.shear_modulus)
        if self.bulk_times is not None:
            bulk = self._series("bulk", elastic.bulk_modulus)
        extension = extension_of(shear, bulk)
        if self.moduli == "equilibrium":
            kept = RelaxationModulus(elastic.youngs_modulus, extension.moduli, extension.times)
            return kept, shear, bulk, nu
        G, K = shear.equilibrium, bulk.equilibrium
        ratio = 0.5 if math.isinf(K) else (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G)
        return extension, shear, bulk, ratio

    def _series(self, strain: str, modulus: float) -> RelaxationModulus:
        """Return the relaxation modulus of a strain from its terms and the given modulus."""
        times: Series = getattr(self, f"{strain}_times")
        moduli: Series | None = getattr(self, f"{strain}_moduli")
        ratios: Series = getattr(self, f"{strain}_ratios") or ()
        key = f"{strain}_moduli" if moduli is not None else f"{strain}_ratios"
        total = math.fsum(ratios)
        instantaneous_ratios = (self.ratios_of or self.moduli) == "instantaneous"
        if moduli is None:
            if instantaneous_ratios and not total < 1.0:
                raise RefusedError(
                    "the ratios to the instantaneous modulus must leave a modulus in equilibrium",
                    "give ratios with a sum below 1",
                    found=f"sum {total:.6g}",
                    at=(key,),
                )
            whole = modulus
            if instantaneous_ratios != (self.moduli == "instantaneous"):
                whole = modulus / (1.0 - total) if instantaneous_ratios else modulus / (1.0 + total)
            moduli = [ratio * whole for ratio in ratios]
        remaining = modulus - math.fsum(moduli) if self.moduli == "instantaneous" else modulus
        if not remaining > 0.0:
            raise RefusedError(
                f"the terms together reach the instantaneous modulus of {modulus:.6g} Pa; "
                "nothing is left in equilibrium",
                "give moduli with a smaller sum, or moduli = 'equilibrium'",
                found=f"sum {math.fsum(moduli):.6g} Pa",
                at=(key,),
            )
        return RelaxationModulus(remaining, tuple(moduli), tuple(times))


def _bulk(shear: RelaxationModulus, nu: float) -> RelaxationModulus:
    """Return the bulk modulus that belongs to a shear modulus at a constant Poisson's ratio."""
    if nu == 0.5:
        return RelaxationModulus(math.inf)
    return shear.scaled(2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)))


def _nearest(shear: RelaxationModulus, bulk: RelaxationModulus, band: tuple[float, float]) -> Behaviour:
    """Return the Kelvin-Voigt material whose shear and bulk moduli are nearest over a band."""
    omega = band_of(band)
    fit = nearest_kelvin_voigt(omega, shear.complex_modulus(omega))
    if math.isinf(bulk.equilibrium):
        return Behaviour(3.0 * fit.modulus, 0.5, fit.time, fit.time)
    volume = nearest_kelvin_voigt(omega, bulk.complex_modulus(omega))
    G, K = fit.modulus, volume.modulus
    return Behaviour(
        9.0 * K * G / (3.0 * K + G), (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G), fit.time, volume.time
    )


def _extensional_viscosity(found: Behaviour) -> float:
    """Return the viscosity in extension, Pa s (LLT 4)."""
    nu = found.poissons_ratio
    return (
        found.youngs_modulus
        * ((1.0 - 2.0 * nu) * found.bulk_time + 2.0 * (1.0 + nu) * found.shear_time)
        / 3.0
    )
