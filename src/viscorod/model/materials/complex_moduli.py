"""Damping from tables of storage and loss modulus over frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from viscorod.given_as import Amounts, GivenAs
from viscorod.limits import SMALLEST_NUMBER
from viscorod.model.fields.definition import Definition, RefusedError, show
from viscorod.model.fields.forms import listed, of_kind, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import (
    OptionalText,
    frequency_band,
    number,
    numbers,
    one_of,
    whole_number,
)
from viscorod.model.materials.column_units import FREQUENCY_UNITS, MODULUS_UNITS
from viscorod.model.materials.damping_model import (
    Behaviour,
    Damping,
    Elastic,
    bulk_time_of,
    maxwell_behaviour,
)
from viscorod.model.materials.dma_table import read_dma_table
from viscorod.model.materials.moduli_over_frequency import DmaTable, beside_slope, tidied
from viscorod.model.materials.nearest_kelvin_voigt import (
    FAR,
    Viscous,
    errors,
    far_branches,
    far_from,
    nearest_kelvin_voigt,
    nearest_maxwell,
)
from viscorod.model.materials.relaxation_modulus import Complexes, RelaxationModulus
from viscorod.quantity_text import per_cent
from viscorod.typing import Floats

__all__ = ["ComplexModuli", "ModulusTable"]

MOST_ROWS = 100_000
OCTAVE = 2.0
"""Ratio of the frequencies that make the low-frequency fit: the lowest and those up to twice as high."""


@accepts(listed(quantity(), 1), "list of numbers")
def _column(value: Any) -> tuple[float, ...]:
    items = numbers(value)
    if len(items) > MOST_ROWS:
        raise RefusedError(
            "too long for a measurement", f"give {MOST_ROWS} rows at most", found=f"{len(items)} rows"
        )
    return items


Column = Annotated[GivenAs[Sequence[float] | None, Amounts | None], optional(_column)]
Band = Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(frequency_band)]


class ModulusTable(Definition):
    """Storage and loss modulus over frequency: three lists, or a file."""

    frequency: Column = Key("", "Hz", default=None)
    storage: Column = Key("storage modulus at these frequencies", "Pa", default=None)
    loss: Column = Key("loss modulus", "Pa", default=None)
    tan_delta: Column = Key("in place of loss, loss over storage modulus", default=None)
    file: OptionalText = Key(
        "in place of the lists, a table exported by an instrument; its path from the case file on",
        default=None,
    )
    frequency_unit: Annotated[str | None, optional(one_of(*FREQUENCY_UNITS))] = Key(
        '"Hz", "kHz", "rad/s", "mHz" or "MHz", where the file does not say', default=None
    )
    modulus_unit: Annotated[str | None, optional(one_of(*MODULUS_UNITS))] = Key(
        '"Pa", "kPa", "MPa", "GPa", "N/mm2", "N/m2", "psi", "ksi", "bar" or "dyn/cm2", where the file does not say',
        default=None,
    )
    temperature: Annotated[float | None, optional(number)] = Key(
        "of the sweep, degrees C, where the file has sweeps at several", default=None
    )

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        lists = [
            name for name in ("frequency", "storage", "loss", "tan_delta") if getattr(self, name) is not None
        ]
        if (self.file is None) == (not lists):
            raise RefusedError(
                "a table comes from lists or from a file",
                "give frequency (Hz), storage and loss (Pa), or file",
                found="given: " + (", ".join([*lists, "file"]) if lists else "nothing"),
            )
        if self.file is None:
            for key, why in (
                ("frequency_unit", "lists are in Hz and Pa"),
                ("modulus_unit", "lists are in Hz and Pa"),
                ("temperature", "lists are one sweep"),
            ):
                if getattr(self, key) is not None:
                    raise RefusedError(why, "leave it out", found=show(getattr(self, key)), at=(key,))
            self._lists_fit(lists)
        _ = self.table
        return self

    def _lists_fit(self, lists: list[str]) -> None:
        if "frequency" not in lists or "storage" not in lists or ("loss" in lists) == ("tan_delta" in lists):
            raise RefusedError(
                "a table needs three columns",
                "give frequency (Hz), storage (Pa), and one of loss (Pa) and tan_delta",
                found=f"given: {', '.join(lists)}",
            )
        rows = len(self.frequency or ())
        for name in lists:
            column: Sequence[float] = getattr(self, name)
            if len(column) != rows:
                raise RefusedError(
                    "all columns need as many numbers",
                    f"give {rows}",
                    found=f"{len(column)} numbers",
                    at=(name,),
                )
            for index, value in enumerate(column):
                if value < SMALLEST_NUMBER and (value != 0.0 or name in ("frequency", "storage")):
                    allowed = "> 0" if name in ("frequency", "storage") else ">= 0"
                    raise RefusedError(
                        "outside what is allowed",
                        f"give numbers {allowed}",
                        found=show(value),
                        at=(name, index),
                    )

    @cached_property
    def table(self) -> DmaTable:
        """The table in rad/s and Pa, by frequency."""
        if self.file is not None:
            try:
                return read_dma_table(
                    self.file,
                    frequency_unit=self.frequency_unit,
                    modulus_unit=self.modulus_unit,
                    temperature=self.temperature,
                )
            except RefusedError as error:
                if error.at:
                    raise
                found = f"{self.file}: {error.found}" if error.found else self.file
                raise RefusedError(error.why, error.instead, found=show(found), at=("file",)) from None
        omega, storage = 2.0 * math.pi * np.array(self.frequency), np.array(self.storage)
        if self.loss is not None:
            loss = np.array(self.loss)
            return tidied(
                omega, storage, loss, notes=beside_slope(omega, storage, loss / storage, of_loss=True)
            )
        tangent = np.array(self.tan_delta)
        return tidied(omega, storage, tangent * storage, notes=beside_slope(omega, storage, tangent))


@accepts(of_kind("damping.other"), "table, see below")
def _modulus_table(value: Any) -> ModulusTable:
    return value if isinstance(value, ModulusTable) else ModulusTable.model_validate(value)


class ComplexModuli(ModulusTable, Damping):
    """Damping from storage and loss moduli measured over frequency (dynamic mechanical analysis).

    Young's modulus of the material may be left out; it then follows from the table, at rest or in the band.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["complex_moduli"] = Field(default="complex_moduli", kw_only=True, repr=False)
    of: Annotated[str, one_of("extension", "shear")] = Key(
        'what was measured, "extension" (or bending) or "shear" (or torsion)', default="extension"
    )
    other: Annotated[ModulusTable | None, optional(_modulus_table)] = Key(
        "the table of the other one; without it Poisson's ratio is taken as constant", default=None
    )
    band: Band = Key(
        "lowest and highest frequency that count, {}; left out, the whole table", "Hz", default=None
    )
    fit: Annotated[str | None, optional(one_of("best", "low_frequency"))] = Key(
        'of a Kelvin-Voigt material, "best" over the band or "low_frequency", from the rows up to '
        'twice the lowest frequency; left out, "best"',
        default=None,
    )
    law: Annotated[str, one_of("kelvin_voigt", "maxwell")] = Key(
        '"kelvin_voigt", or "maxwell" for Maxwell branches that follow the table over the band',
        default="kelvin_voigt",
    )
    per_decade: Annotated[int | None, optional(whole_number(1, 5))] = Key(
        "Maxwell branches per decade of frequency at most, 1 to 5; left out, 2", default=None
    )

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        maxwell = self.law == "maxwell"
        for key, senseless, why in (
            ("fit", maxwell and self.fit == "low_frequency", "Maxwell branches follow the whole band"),
            (
                "per_decade",
                not maxwell and self.per_decade is not None,
                "a Kelvin-Voigt material has no branches",
            ),
            (
                "band",
                self.fit == "low_frequency" and self.band is not None,
                "low_frequency takes the lowest rows",
            ),
        ):
            if senseless:
                raise RefusedError(why, "leave it out", found=show(getattr(self, key)), at=(key,))
        for strain, table in self.tables.items():
            if table.strain not in (None, strain):
                raise RefusedError(
                    f"the columns of the file are those of {table.strain}",
                    f"give of = '{table.strain}'" if self.other is None else "exchange the tables",
                    found=strain,
                    at=("of",),
                )
            self._rows(strain)
        return self

    @cached_property
    def tables(self) -> dict[str, DmaTable]:
        """The tables by strain, "extension" or "shear"."""
        tables = {self.of: self.table}
        if self.other is not None:
            tables["shear" if self.of == "extension" else "extension"] = self.other.table
        return tables

    def _rows(self, strain: str) -> tuple[Floats, Complexes]:
        """Return the angular frequencies and complex moduli within the band."""
        table = self.tables[strain]
        low, high = self.band or (0.0, math.inf)
        if self.fit == "low_frequency":
            high = OCTAVE * float(table.omega[0]) / (2.0 * math.pi)
        slack = 1e-9
        hertz = table.omega / (2.0 * math.pi)
        inside = (hertz >= low * (1.0 - slack)) & (hertz <= high * (1.0 + slack))
        least = 1 if self.fit == "low_frequency" else 2
        if np.count_nonzero(inside) < least:
            count = int(np.count_nonzero(inside))
            raise RefusedError(
                f"the table of {strain} has {count} row{'' if count == 1 else 's'} there",
                f"{least} at least are needed; its frequencies go from {hertz[0]:.6g} to {hertz[-1]:.6g} Hz",
                found=show(list(self.band)) if self.band else "",
                at=("band",) if self.band else (),
            )
        return table.omega[inside], table.storage[inside] + 1j * table.loss[inside]

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return times, or branches, of the nearest material; with one table at a constant Poisson's ratio."""
        if len(self.tables) == 2 and math.isnan(elastic.youngs_modulus) != math.isnan(elastic.poissons_ratio):
            raise RefusedError(
                "tables of extension and shear give Young's modulus and Poisson's ratio",
                "leave poissons_ratio out, or give youngs_modulus with it",
                found="given: poissons_ratio",
            )
        if len(self.tables) == 1 and math.isnan(elastic.poissons_ratio):
            raise RefusedError(
                "one table does not determine Poisson's ratio",
                "give poissons_ratio, or the other table",
                found="",
            )
        return self._branches(elastic) if self.law == "maxwell" else self._times(elastic)

    def _times(self, elastic: Elastic) -> Behaviour:
        fits = {strain: nearest_kelvin_voigt(*self._rows(strain)) for strain in self.tables}
        found = _constants(elastic, {strain: fit.modulus for strain, fit in fits.items()})
        sentences = [
            sentence for strain, fit in fits.items() for sentence in self._known(strain, fit, elastic, found)
        ]
        doubts = tuple(
            doubt
            for strain, fit in fits.items()
            for doubt in far_from(f"the table of {strain}", self._rows(strain)[0], *self._wrong(strain, fit))
        )
        if len(fits) == 1:
            (fit,) = fits.values()
            sentences.append(_CONSTANT)
            return Behaviour(*found, fit.time, fit.time, assumptions=tuple(sentences), doubts=doubts)
        shear = fits["shear"].time
        bulk = bulk_time_of(fits["extension"].time, shear, found.poissons_ratio, ("other",))
        sentences.append(f"the bulk time of {bulk:.4g} s follows from those in extension and shear (LLT 4)")
        return Behaviour(*found, shear, bulk, assumptions=tuple(sentences), doubts=doubts)

    def _wrong(self, strain: str, fit: Viscous | RelaxationModulus) -> tuple[float, float]:
        """Return the largest errors of storage and loss modulus of a fit, %."""
        omega, modulus = self._rows(strain)
        storage, loss = errors(modulus, fit.complex_modulus(omega))
        return 100.0 * float(np.max(np.abs(storage))), 100.0 * float(np.max(np.abs(loss)))

    def _branches(self, elastic: Elastic) -> Behaviour:
        known = {"extension": elastic.youngs_modulus, "shear": elastic.shear_modulus}
        fits: dict[str, RelaxationModulus] = {}
        for strain in self.tables:
            rest = None if math.isnan(known[strain]) else known[strain]
            fits[strain] = nearest_maxwell(*self._rows(strain), self.per_decade or 2, rest)
        found = _constants(elastic, {strain: fit.equilibrium for strain, fit in fits.items()})
        sentences = [
            sentence for strain, fit in fits.items() for sentence in self._known(strain, fit, elastic, found)
        ]
        factor = 2.0 * (1.0 + found.poissons_ratio)
        if len(fits) == 1:
            sentences.append(_CONSTANT)
        extension = fits["extension"] if "extension" in fits else fits["shear"].scaled(factor)
        shear = fits["shear"] if "shear" in fits else fits["extension"].scaled(1.0 / factor)
        doubts = tuple(
            doubt
            for strain, fit in fits.items()
            for omega, modulus in [self._rows(strain)]
            for doubt in far_branches(f"the table of {strain}", omega, modulus, fit.complex_modulus(omega))
        )
        return replace(maxwell_behaviour(found, extension, shear, tuple(sentences)), doubts=doubts)

    def _known(
        self, strain: str, fit: Viscous | RelaxationModulus, given: Elastic, found: Elastic
    ) -> list[str]:
        """Describe the fit of a strain, and its distance from the table."""
        omega, (storage, loss) = self._rows(strain)[0], self._wrong(strain, fit)
        name = f"{len(fit.times)} Maxwell branches" if isinstance(fit, RelaxationModulus) else "Kelvin-Voigt"
        rows = "" if len(omega) == 1 else f" to {omega[-1] / (2.0 * math.pi):.4g}"
        known = [
            f"{name} in {strain}, fitted from {omega[0] / (2.0 * math.pi):.4g}{rows} Hz: there the storage modulus is "
            f"wrong by {per_cent(storage)} at most and the loss modulus by {per_cent(loss)}"
        ]
        if isinstance(fit, Viscous) and max(storage, loss) > FAR:
            known[0] += '; law = "maxwell" follows the table'
        mine = found.youngs_modulus if strain == "extension" else found.shear_modulus
        word = "Young's modulus" if strain == "extension" else "the shear modulus"
        if isinstance(fit, Viscous) and not math.isnan(given.youngs_modulus):
            known.append(
                f"{word} is kept as given, {mine:.4g} Pa; the table would say {fit.modulus:.4g} Pa "
                f"({100.0 * (fit.modulus / mine - 1.0):+.2g} %), and only the time of {fit.time:.4g} s comes from it"
            )
        return [*known, *(f"the table of {strain}: {note}" for note in self.tables[strain].notes)]


_CONSTANT = "Poisson's ratio is taken as constant: the same loss factor in extension and shear"


def _constants(elastic: Elastic, moduli: dict[str, float]) -> Elastic:
    """Return Young's modulus and Poisson's ratio: those given, or those of the fits."""
    if not math.isnan(elastic.youngs_modulus):
        return elastic
    if len(moduli) == 1:
        nu = elastic.poissons_ratio
        return Elastic(moduli.get("extension", 2.0 * (1.0 + nu) * moduli.get("shear", math.nan)), nu)
    nu = moduli["extension"] / (2.0 * moduli["shear"]) - 1.0
    if not -1.0 < nu <= 0.5:
        raise RefusedError(
            f"the tables of extension and shear mean a Poisson's ratio of {nu:.4g}, outside (-1, 0.5]",
            "check the tables, or give youngs_modulus and poissons_ratio",
            found=f"E = {moduli['extension']:.4g} Pa and G = {moduli['shear']:.4g} Pa",
        )
    return Elastic(moduli["extension"], nu)
