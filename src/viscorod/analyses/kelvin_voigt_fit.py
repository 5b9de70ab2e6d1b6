"""Fit Kelvin-Voigt materials to Prony series and measured moduli, and compare the two over a band of frequencies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.attributes import WellNamed
from viscorod.checks import checked
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.fields.values import numbers
from viscorod.model.materials.complex_moduli import ComplexModuli
from viscorod.model.materials.material import Material
from viscorod.model.materials.nearest_kelvin_voigt import Viscous, band_of, errors, nearest_kelvin_voigt
from viscorod.model.materials.relaxation_modulus import Complexes, RelaxationModulus
from viscorod.results.text_numbers import per_cent
from viscorod.shown import Shown, span
from viscorod.small_drawing import Drawing
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["KelvinVoigtFit", "kelvin_voigt_fit"]

OUTSIDE = 100.0
"""How far beyond the relaxation times a comparison goes if no band is given."""


@known_arguments
@dataclass(frozen=True, eq=False, repr=False)
class KelvinVoigtFit(WellNamed, Shown):
    """A Kelvin-Voigt solid beside the complex modulus that it stands for.

    Attributes:
        strain: "extension" or "shear".
        method: "best" over the band, or "low_frequency".
        modulus: of the Kelvin-Voigt solid, Pa.
        viscosity: Pa s.
        frequency: at which the two are compared (n,), Hz.
        exact: complex modulus at these frequencies (n,), Pa.
    """

    strain: str
    method: str
    modulus: float
    viscosity: float
    frequency: Floats
    exact: Complexes

    def _facts(self) -> Iterator[str]:
        yield f"{self.strain}, {self.method.replace('_', ' ')} fit"
        yield f"modulus {self.modulus:.4g} Pa"
        yield f"retardation time {self.time:.4g} s"
        yield span(*self.band, "Hz")

    def _drawing(self) -> str:
        drawing, along = Drawing(equal=False), np.log10(self.frequency)
        for modulus, faint in ((self.exact, False), (self.fitted, True)):
            for part in (modulus.real, modulus.imag):
                size = np.log10(np.maximum(part, 1e-3 * float(np.abs(self.exact).min())))
                drawing.line(np.stack([along, size], axis=-1), faint=faint)
        return drawing.svg()

    @property
    def time(self) -> float:
        """Retardation time, viscosity over modulus, s."""
        return self.viscosity / self.modulus

    @property
    def band(self) -> tuple[float, float]:
        """Lowest and highest frequency of the comparison, Hz."""
        return float(self.frequency[0]), float(self.frequency[-1])

    @property
    def fitted(self) -> Complexes:
        """Complex modulus of the Kelvin-Voigt solid (n,), Pa."""
        return np.asarray(self.modulus + 2j * np.pi * self.frequency * self.viscosity, dtype=np.complex128)

    @property
    def storage_error(self) -> Floats:
        """Relative error of the storage modulus (n,)."""
        return errors(self.exact, self.fitted)[0]

    @property
    def loss_error(self) -> Floats:
        """Relative error of the loss modulus (n,); over the whole modulus where there is no loss."""
        return errors(self.exact, self.fitted)[1]

    @property
    def error(self) -> Floats:
        """Relative error of the complex modulus, ``|fit - exact|/|exact|`` (n,)."""
        return np.asarray(np.abs(self.fitted - self.exact) / np.abs(self.exact))

    def band_within(self, tolerance: float) -> tuple[float, float] | None:
        """Return the band, Hz, from the lowest frequency with an `error` below `tolerance` to the first above it.

        None if there is no such frequency.
        """
        good = self.error <= tolerance
        if not good.any():
            return None
        first = int(np.argmax(good))
        bad = np.flatnonzero(~good[first:])
        last = first + int(bad[0]) - 1 if bad.size else len(good) - 1
        return float(self.frequency[first]), float(self.frequency[last])

    def __str__(self) -> str:
        low, high = self.band
        storage, loss = (100.0 * float(np.abs(e).max()) for e in (self.storage_error, self.loss_error))
        return (
            f"Kelvin-Voigt in {self.strain}: modulus {self.modulus:.4g} Pa, retardation time {self.time:.4g} s "
            f"({self.method.replace('_', ' ')} fit). From {low:.4g} to {high:.4g} Hz the storage modulus is wrong by "
            f"{per_cent(storage)} at most, the loss modulus by {per_cent(loss)}."
        )

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw storage and loss modulus of both over frequency, and the relative errors.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the moduli alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_kelvin_voigt_fit import draw_fit

        return delivered(draw_fit(self, ax), path)


@checked
def kelvin_voigt_fit(
    material: Material | RelaxationModulus,
    band: Sequence[float] | None = None,
    *,
    strain: str = "extension",
    fit: str = "best",
    keep_modulus: bool = False,
) -> KelvinVoigtFit:
    """Fit a Kelvin-Voigt solid to a material and compare the two over a band.

    "low_frequency" is the limit of slow motion, M = M_inf and eta = sum M_j tau_j (Linn, Lang and Tuganov 2013,
    section 2.6), of a table its rows up to twice the lowest frequency. "best" has the least mean square of
    ``|M* - fit|/|M*|`` over the logarithm of the frequency: M is the mean of the storage modulus, eta the slope of the
    loss modulus, both weighted with ``1/|M*|^2``.

    Args:
        material: with a Prony series or a table of complex moduli; or a relaxation modulus.
        band: lowest and highest frequency, Hz. Left out, all rows of a table; of a Prony series, from a hundredth of
            the slowest to a hundred times the fastest relaxation.
        strain: "extension" or "shear".
        fit: "best" or "low_frequency".
        keep_modulus: keep the modulus in equilibrium, and fit the viscosity alone.

    Raises:
        InputError: the material has no Prony series or table, or a word or the band is wrong.
    """
    for key, word, words in (
        ("strain", strain, ("extension", "shear")),
        ("fit", fit, ("best", "low_frequency")),
    ):
        if word not in words:
            raise InputError(
                Fault(key, show(word), "no such word", f"give one of {', '.join(map(repr, words))}")
            )
    source = _source(material, strain)
    if isinstance(source, RelaxationModulus):
        omega = band_of(_checked(band) or _around(source))
        modulus = source.complex_modulus(omega)
        slow = Viscous(source.equilibrium, source.viscosity)
    else:
        omega, modulus = source
        lowest = omega <= 2.0 * omega[0]
        slow = nearest_kelvin_voigt(omega[lowest], modulus[lowest])
        if (given := _checked(band)) is not None:
            inside = (omega >= 2.0 * math.pi * given[0] * (1 - 1e-9)) & (
                omega <= 2.0 * math.pi * given[1] * (1 + 1e-9)
            )
            if np.count_nonzero(inside) < 2:
                found = f"{np.count_nonzero(inside)} rows of the table are there"
                raise InputError(Fault("band", show(list(given)), found, "give a wider band"))
            omega, modulus = omega[inside], modulus[inside]
    found_fit = slow if fit == "low_frequency" else nearest_kelvin_voigt(omega, modulus)
    if keep_modulus:
        found_fit = Viscous(_equilibrium(material, strain, slow), found_fit.viscosity)
    return KelvinVoigtFit(
        strain, fit, found_fit.modulus, found_fit.viscosity, omega / (2.0 * math.pi), modulus
    )


def _source(material: Any, strain: str) -> RelaxationModulus | tuple[Floats, Complexes]:
    """Return what is known of the modulus in a strain: a relaxation modulus, or rows of a table."""
    if isinstance(material, RelaxationModulus):
        return material
    if not isinstance(material, Material):
        raise InputError(
            Fault(
                "material", show(material), "this is not a material", "give a Material or a RelaxationModulus"
            )
        )
    damping = material.damping
    if isinstance(damping, ComplexModuli):
        if strain not in damping.tables:
            (known,) = damping.tables
            raise InputError(
                Fault(
                    "strain", show(strain), f"the table of this material is one of {known}", f"give {known!r}"
                )
            )
        table = damping.tables[strain]
        return table.omega / material.shift_factor, table.storage + 1j * table.loss
    found = material.relaxation(strain)
    if found is None or not found.times:
        raise InputError(
            Fault(
                "material",
                type(damping).__name__ if damping is not None else "no damping",
                "this material is Kelvin-Voigt or elastic already; there is nothing to compare it with",
                "give a material with a Prony series or a table of complex moduli",
            )
        )
    return found


def _equilibrium(material: Material | RelaxationModulus, strain: str, slow: Viscous) -> float:
    if isinstance(material, RelaxationModulus):
        return slow.modulus
    return material.youngs_modulus if strain == "extension" else material.shear_modulus


def _around(relaxation: RelaxationModulus) -> tuple[float, float]:
    if not relaxation.times:
        raise InputError(Fault("material", "", "nothing relaxes", "give a RelaxationModulus with terms"))
    slowest, fastest = relaxation.times[-1], relaxation.times[0]
    return 1.0 / (2.0 * math.pi * OUTSIDE * slowest), OUTSIDE / (2.0 * math.pi * fastest)


def _checked(band: Sequence[float] | None) -> tuple[float, float] | None:
    if band is None:
        return None
    try:
        low, high = numbers(band, count=2)
    except RefusedError as error:
        raise InputError(Fault("band", show(band), error.why, error.instead)) from None
    if not 0.0 < low < high:
        raise InputError(
            Fault(
                "band",
                show(band),
                "a band goes from a lower to a higher frequency",
                "give (low, high) in Hz, > 0",
            )
        )
    return low, high
