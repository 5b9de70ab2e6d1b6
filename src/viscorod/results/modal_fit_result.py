"""The result of a modal fit: modes of measured frequency responses with intervals."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.results.material_share import AtMost, material_at_most, material_text
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.text_table import listed, table
from viscorod.shown import counted, span
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["ModalFit"]

WIDTH = "half of the 95 % interval"
VARIABLES: Variables = {
    "response": (("record", "line", "part"), "", "real and imaginary part of what was measured"),
    "line_frequency": (("line",), "Hz", "frequency of the lines"),
    "record_name": (("record",), "", "name of the record"),
    "frequency": (("mode",), "Hz", "natural frequency |s|/2 pi"),
    "frequency_width": (("mode",), "Hz", WIDTH),
    "damping_ratio": (("mode",), "1", "-Re s/|s|"),
    "damping_ratio_width": (("mode",), "1", WIDTH),
}
"""Name -> dimensions, unit and long name of every variable; all are always there."""


class ModalFit(StatelessResult):
    """Modes of measured frequency responses: natural frequencies and damping ratios with 95 % intervals."""

    kind: ClassVar[str] = "modal_fit"
    picture: ClassVar[str] = "modal_fit"
    what: ClassVar[str] = "modal fit"

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.frequencies), "mode")
        if len(self.frequencies):
            yield span(float(self.frequencies[0]), float(self.frequencies[-1]), "Hz")
        yield counted(len(self.data["record_name"]), "record")
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        size = np.hypot(*np.moveaxis(self.data["response"].values[0], -1, 0))
        return self._column("line_frequency"), np.log10(np.maximum(size, np.finfo(float).tiny))[:, None]

    def _column(self, name: str) -> Floats:
        return np.asarray(self.data[name].values, dtype=float)

    @property
    def frequencies(self) -> Floats:
        """Natural frequencies ``|s|/2 pi`` [Hz], increasing (k,)."""
        return self._column("frequency")

    @property
    def damping_ratios(self) -> Floats:
        """Damping ratios ``-Re s/|s|`` (k,)."""
        return self._column("damping_ratio")

    @property
    def half_power(self) -> list[float | None]:
        """Damping ratios read off the half-power widths; None where these have less than two bins, or are not alone."""
        return list(json.loads(self.data.attrs["half_power"]))

    @property
    def material_at_most(self) -> list[AtMost]:
        """The most that a flat loss factor and a Kelvin-Voigt time of the material can be; the rest damps outside."""
        return material_at_most(self.frequencies, self.damping_ratios, self._column("damping_ratio_width"))

    def report(self) -> str:
        """Return a report: modes with intervals, doubts."""
        hertz = self._column("line_frequency")
        names = ", ".join(str(one) for one in self.data["record_name"].values)
        heading = (
            f"{self.title + chr(10) if self.title else ''}Modes of {names}, lines of {hertz[1] - hertz[0]:.4g} Hz from "
            f"{hertz[0]:.6g} to {hertz[-1]:.6g} Hz"
        )
        columns = (
            self._column(f"{name}{end}") for name in ("frequency", "damping_ratio") for end in ("", "_width")
        )
        rows = [
            [
                str(k),
                f"{f:.6g} ± {df:.2g}",
                f"{z:.4g} ± {dz:.2g}",
                "refused" if half is None else f"{half:.4g}",
            ]
            for k, (f, df, z, dz, half) in enumerate(zip(*columns, self.half_power, strict=True), 1)
        ]
        header = ["", "frequency [Hz]", "damping ratio", "half power"]
        blocks = [heading, table("Modes (± 95 %)", header, rows), material_text(self.material_at_most)]
        if self.warnings:
            blocks.append(listed("Doubts", self.warnings))
        return "\n\n".join(blocks)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the size of the responses with the modes, and the damping ratios over the frequency.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the responses alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_modal_fit import draw_modal_fit

        return delivered(draw_modal_fit(self, ax), path)
