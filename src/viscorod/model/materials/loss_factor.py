"""Damping from loss factors: one that was measured at one frequency, or one that holds over a band."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from viscorod.given_as import Amount, Amounts, GivenAs
from viscorod.limits import SMALLEST_NUMBER
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.forms import NOT_NEGATIVE, POSITIVE, listed, quantity
from viscorod.model.fields.metadata import Key, accepts, optional
from viscorod.model.fields.values import OptionalNonNegative, frequency_band, non_negative, numbers, positive
from viscorod.model.materials.damping_model import (
    Behaviour,
    Damping,
    Elastic,
    bulk_time_of,
    maxwell_behaviour,
)
from viscorod.model.materials.loss_factor_fit import LossFit, fit_loss_factors
from viscorod.model.materials.nearest_kelvin_voigt import band_of
from viscorod.model.materials.relaxation_modulus import RelaxationModulus
from viscorod.quantity_text import per_cent
from viscorod.quantity_text import quantity as with_unit
from viscorod.typing import Floats

__all__ = ["WITHIN", "LossFactor"]

WITHIN = 0.02
"""Relative error of a loss factor over its band, unless another one is wanted."""
MOST_ROWS = 10_000

Numbers: TypeAlias = float | Sequence[float] | None


def _row(value: Any) -> tuple[float, ...]:
    items = numbers(value, at_least=2)
    if len(items) > MOST_ROWS:
        raise RefusedError(
            "too long for a measurement", f"give {MOST_ROWS} rows at most", found=f"{len(items)} rows"
        )
    for index, item in enumerate(items):
        if item < SMALLEST_NUMBER:
            raise RefusedError("outside what is allowed", "give numbers > 0", found=show(item), at=(index,))
    return items


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim > 0)


@accepts(quantity(listed(quantity(bounds=POSITIVE), 2), bounds=POSITIVE), "number > 0, or list of numbers")
def _frequency(value: Any) -> float | tuple[float, ...]:
    if not _is_list(value):
        return positive(value)
    items = _row(value)
    if not (np.diff(items) > 0.0).all():
        raise RefusedError("frequencies of a table increase", "sort the table, each frequency once")
    return items


@accepts(
    quantity(listed(quantity(bounds=POSITIVE), 2), bounds=NOT_NEGATIVE), "number >= 0, or list of numbers > 0"
)
def _loss(value: Any) -> float | tuple[float, ...]:
    return _row(value) if _is_list(value) else non_negative(value)


@accepts(quantity(bounds={"exclusiveMinimum": 0, "exclusiveMaximum": 1}), "number above 0 and below 1")
def _within(value: Any) -> float:
    error = positive(value)
    if not 1e-6 <= error < 1.0:
        raise RefusedError(
            "outside what is allowed", "give a relative error from 1e-6 to below 1, such as 0.02"
        )
    return error


Frequency = Annotated[GivenAs[Numbers, Amount | Amounts | None], optional(_frequency)]
Loss = Annotated[GivenAs[Numbers, Amount | Amounts | None], optional(_loss)]


class LossFactor(Damping):
    """Damping by loss factors (tan delta, loss over storage modulus), at one frequency or over a band.

    At one frequency the material is Kelvin-Voigt: its loss factor is omega tau, so that tau = loss factor/(2 pi
    frequency). Over a band, and of a table, it gets as few Maxwell branches as follow the loss factor within the wanted
    error. A loss factor of 0.01 from 1 to 1000 Hz needs six. Such a material is stiffer the faster it moves: the moduli
    given with it are the storage moduli in the middle of the band, or at another frequency.
    """

    tag: ClassVar[str | None] = "kind"

    kind: Literal["loss_factor"] = Field(default="loss_factor", kw_only=True, repr=False)
    frequency: Frequency = Key(
        "at which the loss factor was measured, {}; a list of a table; left out where the same loss factor holds over "
        "a band",
        "Hz",
        default=None,
    )
    extension: Loss = Key("loss factor in extension or bending; a list of a table", default=None)
    shear: Loss = Key("loss factor in shear or torsion; a list of a table", default=None)
    bulk: Loss = Key(
        "loss factor in volume change, with shear and in place of extension; a list of a table", default=None
    )
    band: Annotated[GivenAs[tuple[float, float] | None, Amounts | None], optional(frequency_band)] = Key(
        "lowest and highest frequency over which the loss factor holds, {}; of a table left out, the whole table",
        "Hz",
        default=None,
    )
    within: Annotated[float | None, optional(_within)] = Key(
        f"relative error of the loss factor over the band; left out, {WITHIN}", default=None
    )
    moduli_at: OptionalNonNegative = Key(
        "frequency at which the elastic constants of the material are its storage moduli, {}, 0 for at rest; left out, "
        "the geometric middle of the band",
        "Hz",
        default=None,
    )

    @model_validator(mode="after")
    def _complete(self) -> Self:
        given = [name for name in ("extension", "shear", "bulk") if getattr(self, name) is not None]
        if self.bulk is not None and given != ["shear", "bulk"]:
            raise RefusedError(
                "that in volume change goes with one in shear",
                "give shear and bulk, or extension, shear or both",
                found=f"given: {', '.join(given)}",
                at=("bulk",),
            )
        if not given:
            raise RefusedError("there is no loss factor", "give extension or shear, or both", found="")
        if self.frequency is None and self.band is None:
            raise RefusedError(
                "a loss factor holds at a frequency or over a band",
                "add frequency (Hz), or band = [lowest, highest] (Hz)",
                found="",
                at=("frequency",),
            )
        rows = len(self.frequency) if isinstance(self.frequency, Sequence) else 0
        tables = [name for name in given if isinstance(getattr(self, name), Sequence)]
        for name in tables:
            values: Sequence[float] = getattr(self, name)
            if not rows:
                raise RefusedError(
                    "a table of loss factors needs the frequencies of its rows",
                    f"give frequency as a list of {len(values)} numbers (Hz)",
                    found=f"{len(values)} numbers",
                    at=(name,),
                )
            if len(values) != rows:
                raise RefusedError(
                    "all columns need as many numbers",
                    f"give {rows}",
                    found=f"{len(values)} numbers",
                    at=(name,),
                )
        if rows and not tables:
            raise RefusedError(
                "a table has a loss factor for every frequency",
                f"give a list of {rows} loss factors, or band for one loss factor over a band",
                found=f"{rows} frequencies",
                at=("frequency",),
            )
        self._band_fits(rows)
        return self

    def _band_fits(self, rows: int) -> None:
        if not rows and self.band is None:
            for key in ("within", "moduli_at"):
                if getattr(self, key) is not None:
                    raise RefusedError(
                        "a loss factor at one frequency is that of a Kelvin-Voigt material, whose moduli do not depend "
                        "on frequency",
                        "leave it out, or give band = [lowest, highest] (Hz)",
                        found=show(getattr(self, key)),
                        at=(key,),
                    )
        elif not rows and self.frequency is not None:
            raise RefusedError(
                "one loss factor holds at one frequency or over a band",
                "leave frequency out, or band",
                found=show(self.frequency),
                at=("frequency",),
            )
        elif rows and self.band is not None:
            assert isinstance(self.frequency, Sequence)
            low, high = self.frequency[0], self.frequency[-1]
            if not (low <= self.band[0] * (1 + 1e-9) and self.band[1] <= high * (1 + 1e-9)):
                raise RefusedError(
                    f"the table goes from {low:.6g} to {high:.6g} Hz",
                    "give a band within it, or leave it out",
                    found=show(list(self.band)),
                    at=("band",),
                )

    @property
    def holds(self) -> tuple[float, float] | None:
        """The band over which the loss factor holds, Hz; None if it was given at one frequency."""
        if isinstance(self.frequency, Sequence) and self.band is None:
            return self.frequency[0], self.frequency[-1]
        return self.band

    def constant_moduli(self, elastic: Elastic) -> tuple[complex, complex] | None:
        """Return ``E (1 + i eta_E)`` and ``G (1 + i eta_G)`` of loss factors that are the same at all frequencies, Pa.

        None of a loss factor at one frequency, which grows with it, and of a table. The elastic constants are the
        storage moduli at every frequency.
        """
        given = [getattr(self, name) for name in ("extension", "shear", "bulk")]
        if self.holds is None or any(isinstance(value, Sequence) for value in given):
            return None
        extension, shear, bulk = given
        young, shearing = elastic.youngs_modulus, elastic.shear_modulus
        if bulk is not None:
            G, K = shearing * (1.0 + 1j * shear), elastic.bulk_modulus * (1.0 + 1j * bulk)
            return 9.0 * K * G / (3.0 * K + G), G
        in_extension, in_shear = (
            (shear if extension is None else extension),
            (extension if shear is None else shear),
        )
        return young * (1.0 + 1j * in_extension), shearing * (1.0 + 1j * in_shear)

    def behaviour(self, elastic: Elastic) -> Behaviour:
        """Return times of a loss factor at one frequency, or branches; a loss factor not given is taken equal."""
        return self._times(elastic) if self.holds is None else self._branches(elastic, self.holds)

    def _times(self, elastic: Elastic) -> Behaviour:
        assert isinstance(self.frequency, float)
        omega = 2.0 * math.pi * self.frequency
        at = with_unit(self.frequency, "Hz")
        known = f"the loss factor is that given at {at} only; it grows in proportion to frequency"
        extension, shear, bulk = (
            None if value is None else float(np.asarray(value))
            for value in (self.extension, self.shear, self.bulk)
        )
        if shear is not None and bulk is not None:
            _require_volume(elastic, "bulk")
            return Behaviour(*elastic, shear / omega, bulk / omega, assumptions=(known,))
        if extension is None or shear is None:
            time = (extension or shear or 0.0) / omega
            return Behaviour(*elastic, time, time, assumptions=(known, self._taken_equal))
        bulk = bulk_time_of(extension, shear, elastic.poissons_ratio, ("extension",), unit="")
        derived = f"the bulk time of {bulk / omega:.4g} s follows from the loss factors in extension and shear (LLT 4)"
        return Behaviour(*elastic, shear / omega, bulk / omega, assumptions=(known, derived))

    @property
    def _taken_equal(self) -> str:
        word, other = ("shear", "extension") if self.extension is None else ("extension", "shear")
        return f"the loss factor in {other} was not given and is taken equal to that in {word}"

    def _branches(self, elastic: Elastic, band: tuple[float, float]) -> Behaviour:
        """Return branches on common times: those of extension and shear, fitted together."""
        omega = band_of(band)
        given = {
            name: self._at(name, omega)
            for name in ("extension", "shear", "bulk")
            if getattr(self, name) is not None
        }
        words = list(given)
        if words == ["extension", "shear"]:
            _require_passive(given["extension"], given["shear"], elastic.poissons_ratio)
        elif words == ["shear", "bulk"]:
            _require_volume(elastic, "bulk")
            given["extension"] = _extension_loss(given["shear"], given["bulk"], elastic)
        names = [name for name in ("extension", "shear") if name in given]
        fit = fit_loss_factors(omega, tuple(given[name] for name in names), self.within or WITHIN)
        middle = math.sqrt(band[0] * band[1]) if self.moduli_at is None else self.moduli_at
        moduli = dict(zip(names, fit.moduli, strict=True))
        young = moduli.get("extension", fit.moduli[0])
        shearing = moduli.get("shear", fit.moduli[0])
        at = 2.0 * math.pi * middle
        extension = young.scaled(elastic.youngs_modulus / float(young.complex_modulus(at).real))
        shear = shearing.scaled(elastic.shear_modulus / float(shearing.complex_modulus(at).real))
        nu = (
            extension.equilibrium / (2.0 * shear.equilibrium) - 1.0
            if len(names) == 2
            else elastic.poissons_ratio
        )
        if not -1.0 < nu <= 0.5:
            raise RefusedError(
                f"at rest these loss factors mean a Poisson's ratio of {nu:.6g}, outside (-1, 0.5]",
                "give moduli_at = 0 and the moduli at rest, or loss factors that differ less",
                found="",
            )
        sentences = [
            *self._told(fit, band, middle, extension),
            *([] if len(names) == 2 else [self._taken_equal]),
        ]
        return maxwell_behaviour(Elastic(extension.equilibrium, nu), extension, shear, tuple(sentences))

    def _at(self, name: str, omega: Floats) -> Floats:
        """Return a loss factor at angular frequencies; that of a table lies on straight lines of the logarithms."""
        value = getattr(self, name)
        if not isinstance(value, Sequence):
            return np.full(len(omega), float(value))
        rows = np.log(2.0 * math.pi * np.asarray(self.frequency, dtype=float))
        found: Floats = np.exp(np.interp(np.log(omega), rows, np.log(np.asarray(value))))
        return found

    def _told(
        self, fit: LossFit, band: tuple[float, float], middle: float, extension: RelaxationModulus
    ) -> list[str]:
        """Say how closely the branches follow the loss factor, what they do outside of the band, and how E depends."""
        if not extension.times:
            return []
        low, high = band
        wanted = self.within or WITHIN
        missed = (
            ""
            if fit.error <= wanted
            else f" ({per_cent(100.0 * wanted, 3)} were wanted; this is the closest that Maxwell branches come)"
        )
        below, start, end, above = (
            extension.complex_modulus(2.0 * math.pi * f) for f in (0.1 * low, low, high, 10.0 * high)
        )
        where = "at rest" if middle == 0.0 else f"at {middle:.4g} Hz"
        return [
            f"{max(len(modulus.times) for modulus in fit.moduli)} Maxwell branches follow the loss factor from "
            f"{low:.4g} to {high:.4g} Hz: it is wrong by {per_cent(100.0 * fit.error)} of itself at most there{missed}",
            f"beyond the band the loss factor falls off: in extension it is {_factor(below):.3g} at {0.1 * low:.4g} Hz "
            f"and {_factor(above):.3g} at {10.0 * high:.4g} Hz",
            f"the elastic constants are the storage moduli {where}: Young's modulus is {extension.equilibrium:.5g} Pa "
            f"at rest and rises by {per_cent(100.0 * (float(end.real / start.real) - 1.0))} over the band",
        ]


def _factor(modulus: Any) -> float:
    return float(modulus.imag / modulus.real)


def _require_volume(elastic: Elastic, key: str) -> None:
    if elastic.poissons_ratio == 0.5:
        raise RefusedError(
            "an incompressible material (nu = 0.5) has no volume change that could lose energy",
            "leave it out, or give a Poisson's ratio below 0.5",
            found="",
            at=(key,),
        )


def _require_passive(extension: Floats, shear: Floats, nu: float) -> None:
    """Refuse loss factors that mean a negative one in volume change at some frequency."""
    worst = int(np.argmin(3.0 * extension - 2.0 * (1.0 + nu) * shear))
    if nu == 0.5:
        worst = int(np.argmax(np.abs(extension - shear)))
    bulk_time_of(float(extension[worst]), float(shear[worst]), nu, ("extension",), unit="")


def _extension_loss(shear: Floats, bulk: Floats, elastic: Elastic) -> Floats:
    """Return the loss factor of Young's modulus 9 K G/(3 K + G), whose storage moduli are as given."""
    G, K = elastic.shear_modulus * (1.0 + 1j * shear), elastic.bulk_modulus * (1.0 + 1j * bulk)
    young = 9.0 * K * G / (3.0 * K + G)
    found: Floats = young.imag / young.real
    return found
