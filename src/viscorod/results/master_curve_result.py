"""The result of a master curve: shift factors, the points over reduced frequency, a smooth curve, laws of the shift."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from viscorod.checks import checked, checked_with, number, word
from viscorod.errors import AccuracyWarning, InputError
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.text_numbers import per_cent
from viscorod.results.text_table import listed, page, table
from viscorod.shown import counted
from viscorod.typing import Floats
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["MasterCurve"]

BEYOND = 2.0
"""Distance [K] from the temperatures of a law that is not told."""
TOLD_APART = 2.0
"""Difference of Akaike's criterion from which on one of two laws is called the better one."""
WIDTH = "half of the 95 % interval"
VARIABLES: Variables = {
    "temperature": (("sweep",), "degC", "temperature of the sample"),
    "log_shift": (("sweep",), "1", "decimal logarithm of a_T"),
    "log_shift_width": (("sweep",), "1", WIDTH),
    "lift": (("sweep",), "1", "b_T, moduli over those of the reference"),
    "lift_width": (("sweep",), "1", WIDTH),
    "in_laws": (("sweep",), "", "whether the laws were fitted to it"),
    "frequency": (("point",), "Hz", "reduced frequency"),
    "storage": (("point",), "Pa", "storage modulus over b_T"),
    "loss": (("point",), "Pa", "loss modulus over b_T"),
    "point_sweep": (("point",), "", "number of the sweep, from 0"),
    "curve_frequency": (("curve",), "Hz", "reduced frequency of the smooth curve"),
    "curve_storage": (("curve",), "Pa", "storage modulus of the smooth curve"),
    "curve_loss": (("curve",), "Pa", "loss modulus of the smooth curve"),
}
"""Name -> dimensions, unit and long name of every variable; all are always there."""


class MasterCurve(StatelessResult):
    """Sweeps at several temperatures as one curve over reduced frequency, with the shifts that make it one.

    ``data`` is an ``xarray.Dataset``; widths are half of 95 % intervals. Shifts are those to the reference temperature:
    relaxation times at T are a_T times, moduli b_T times those at the reference.
    """

    kind: ClassVar[str] = "master_curve"
    picture: ClassVar[str] = "master_curve"
    what: ClassVar[str] = "master curve"

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _column(self, name: str) -> Floats:
        return np.asarray(self.data[name].values, dtype=float)

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.temperatures), "sweep")
        yield f"at {self.reference:.4g} °C"
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        moduli = np.stack([self._column("curve_storage"), self._column("curve_loss")], axis=-1)
        return np.log10(self._column("curve_frequency")), np.log10(np.maximum(moduli, np.finfo(float).tiny))

    @property
    def reference(self) -> float:
        """Temperature of the curve, degrees C."""
        return float(self.data.attrs["reference"])

    @property
    def temperatures(self) -> Floats:
        """Temperatures of the sweeps, degrees C (n,)."""
        return self._column("temperature")

    @property
    def log_shifts(self) -> Floats:
        """Decimal logarithms of the shift factors a_T (n,)."""
        return self._column("log_shift")

    @property
    def lifts(self) -> Floats:
        """Factors b_T on the moduli (n,); 1 where they are not shifted."""
        return self._column("lift")

    @property
    def laws(self) -> dict[str, dict[str, Any]]:
        """What was fitted: "wlf" (c1, c2 [K]) and "arrhenius" (E_a [J/mol]): ``values``, ``low``, ``high``, ``off``.

        low and high are the ends of 95 % intervals, off is the root mean square of log10 a_T about the law. A law that
        does not fit at all is left out.
        """
        found = json.loads(self.data.attrs["laws"])
        return {name: law for name, law in found.items() if law is not None}

    @property
    def law(self) -> str:
        """The law that fits better by Akaike's criterion, "wlf" or "arrhenius"; "table" if neither does."""
        laws = self.laws
        return min(laws, key=lambda name: float(laws[name]["information"])) if laws else "table"

    def _told_apart(self) -> bool:
        """Return whether the better law is better by more than chance: two of Akaike's criterion."""
        values = sorted(float(law["information"]) for law in self.laws.values())
        return len(values) < 2 or values[1] - values[0] > TOLD_APART

    @checked_with(law=word)
    def shift(self, law: str | None = None) -> dict[str, Any]:
        """Return the shift for a `Material`, as the table of a case file: of `law`, or "table" for the factors.

        Raises:
            InputError: this law was not fitted, or the factors do not fall with temperature.
        """
        chosen = self.law if law is None else law
        laws = self.laws
        if chosen == "table":
            decades = self.log_shifts
            if not (np.diff(decades) < 0.0).all():
                raise InputError(
                    "the shift factors do not fall with temperature: take the law wlf or arrhenius"
                )
            return {
                "kind": "table",
                "temperatures": [float(one) for one in self.temperatures],
                "factors": [float(10.0**one) for one in decades],
            }
        if chosen not in laws:
            raise InputError(f"law = {chosen!r}: it was not fitted; there are {', '.join([*laws, 'table'])}")
        names = ("c1", "c2") if chosen == "wlf" else ("activation_energy",)
        values = dict(zip(names, map(float, laws[chosen]["values"]), strict=True))
        return {"kind": chosen, **values, "reference": self._law_reference(chosen)}

    def _law_reference(self, law: str) -> float:
        """Return the temperature that a law is referred to, degrees C."""
        return float(self.laws.get(law, {}).get("reference", self.reference))

    @checked
    def lift_at(self, temperature: float) -> float:
        """Return b_T at a temperature, degrees C, straight lines between the sweeps."""
        return float(np.interp(temperature, self.temperatures, self.lifts))

    @checked_with(law=word, density=number, poissons_ratio=number)
    def material(
        self,
        temperature: float,
        *,
        density: float,
        poissons_ratio: float,
        law: str | None = None,
        band: tuple[float, float] | None = None,
        per_decade: int = 2,
    ) -> dict[str, Any]:
        """Return the material at a temperature, as arguments of `Material` and the table of a case file.

        Maxwell branches follow the smooth curve, relaxation times are shifted by the law, moduli by b_T. Beyond the
        temperatures that the law was fitted to, an `AccuracyWarning` says so.

        Args:
            temperature: of the motion, degrees C.
            density: kg/m^3.
            poissons_ratio: taken as constant.
            law: "wlf", "arrhenius" or "table"; left out, the one that fits better, and among sweeps to which no law was
                fitted the table of shifts.
            band: reduced frequencies that count, Hz; left out, all.
            per_decade: Maxwell branches per decade at most.

        Raises:
            InputError: there is no such law.
        """
        chosen = self._law_at(temperature) if law is None else law
        self._tell_beyond(chosen, temperature)
        about = self._law_reference(chosen)
        shift = float(np.interp(about, self.temperatures, self.log_shifts))
        lift = self.lift_at(temperature)
        damping = {
            "kind": "complex_moduli",
            "frequency": (self._column("curve_frequency") * 10.0**-shift).tolist(),
            "storage": (lift * self._column("curve_storage")).tolist(),
            "loss": (lift * self._column("curve_loss")).tolist(),
            "of": self.data.attrs["strain"] or "extension",
            "law": "maxwell",
            "per_decade": per_decade,
            **({} if band is None else {"band": tuple(one * 10.0**-shift for one in band)}),
        }
        return {
            "density": density,
            "poissons_ratio": poissons_ratio,
            "damping": damping,
            "temperature": temperature,
            "shift": self.shift(chosen),
        }

    def _fitted(self, law: str) -> Floats:
        """Return the temperatures that a law was fitted to; none of a table."""
        if law not in self.laws:
            return np.zeros(0)
        return np.asarray(self.temperatures[self._column("in_laws") > 0.0])

    def _law_at(self, temperature: float) -> str:
        """Return the better law, or the table where only that reaches: shifts in a glass follow no law.

        Between sweeps that share no moduli with others nobody knows the shift, and a table is no better than a law.
        """
        fitted, measured = self._fitted(self.law), self.temperatures
        beyond = len(fitted) and not fitted.min() - BEYOND <= temperature <= fitted.max() + BEYOND
        inside = measured.min() <= temperature <= measured.max()
        falls = bool((np.diff(self.log_shifts) < 0.0).all())
        above = min(int(np.searchsorted(measured, temperature)), len(measured) - 1)
        apart = set(json.loads(self.data.attrs.get("apart", "[]")))
        shared = not apart & set(measured[max(above - 1, 0) : above + 1].tolist())
        return "table" if beyond and inside and falls and shared else self.law

    def _tell_beyond(self, law: str, temperature: float) -> None:
        fitted = self._fitted(law)
        if not len(fitted) or fitted.min() - BEYOND <= temperature <= fitted.max() + BEYOND:
            return
        nearest = float(self.temperatures[np.argmin(np.abs(self.temperatures - temperature))])
        warnings.warn(
            f"the law {law} was fitted from {fitted.min():.4g} to {fitted.max():.4g} C; at {temperature:.4g} C it is "
            "carried on, and relaxation times may be off by decades: within the measured frequencies take the sweep at "
            f"{nearest:.4g} C itself (a table with the key temperature)",
            AccuracyWarning,
            stacklevel=4,
        )

    def report(self) -> str:
        """Return a report: shifts with intervals, laws, doubts."""
        scatter = [100.0 * float(self.data.attrs[f"scatter_{name}"]) for name in ("storage", "loss")]
        hertz = self._column("frequency")
        lifted = bool(self.data.attrs["vertical"])
        blocks = [
            f"{self.title + chr(10) if self.title else ''}Master curve at {self.reference:.4g} C of "
            f"{len(self.temperatures)} sweeps, reduced frequencies from {hertz.min():.3g} to {hertz.max():.3g} Hz; "
            f"about it the storage moduli scatter by {per_cent(scatter[0])}, the loss moduli by {per_cent(scatter[1])}"
        ]
        header = ["temperature [C]", "log10 a_T", *(["b_T"] if lifted else [])]
        columns = (
            self._column(name)
            for name in ("temperature", "log_shift", "log_shift_width", "lift", "lift_width")
        )
        rows = [
            [f"{t:.4g}", f"{a:.3f} ± {da:.2g}", *([f"{b:.3f} ± {db:.2g}"] if lifted else [])]
            for t, a, da, b, db in zip(*columns, strict=True)
        ]
        blocks.append(table("Shifts (± 95 %)", header, rows))
        lines = ["Laws" if self.laws else "Laws: none fits"]
        for name, law in self.laws.items():
            ends = [
                f"{v:.4g} ({low:.4g} to {high:.4g})"
                for v, low, high in zip(law["values"], law["low"], law["high"], strict=True)
            ]
            numbers = (
                f"c1 = {ends[0]}, c2 = {ends[1]} K" if name == "wlf" else f"activation energy {ends[0]} J/mol"
            )
            if law.get("reference", self.reference) != self.reference:
                numbers += f" about {law['reference']:.4g} C"
            better = ""
            if name == self.law and len(self.laws) > 1:
                better = ", the better one" if self._told_apart() else ", hardly told from the other"
            lines.append(f"  {name}: {numbers}; off by {law['off']:.2g} decades{better}")
        blocks.append("\n".join(lines))
        if self.warnings:
            blocks.append(listed("Doubts", self.warnings))
        return page(blocks)

    @checked
    def write_table(self, path: str | Path) -> Path:
        """Write the smooth curve as a table that `ComplexModuli` reads: Hz, and Pa at the reference temperature.

        Args:
            path: of the .csv file.

        Returns:
            The path.
        """
        rows = np.column_stack([self._column(f"curve_{name}") for name in ("frequency", "storage", "loss")])
        text = "\n".join(",".join(f"{value:.8e}" for value in row) for row in rows)
        with replacing(Path(path)) as new:
            new.write_text(
                f"Frequency (Hz),Storage Modulus (Pa),Loss Modulus (Pa)\n{text}\n", encoding="utf-8"
            )
        return Path(path)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the moduli over reduced frequency and the shifts over temperature with their laws.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the moduli alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_master_curve import draw_master_curve

        return delivered(draw_master_curve(self, ax), path)
