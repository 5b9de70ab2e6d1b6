"""The result of a free decay: modes with intervals, pieces by amplitude, and the samples with what was fitted."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.checks import checked
from viscorod.results.material_share import AtMost, material_at_most
from viscorod.results.stateless_result import StatelessResult, Variables
from viscorod.results.text_table import listed, table
from viscorod.shown import counted
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Decay"]

WIDTH = "half of the 95 % interval"
VARIABLES: Variables = {
    "time": (("time",), "s", "time"),
    "value": (("time",), "", "what was measured"),
    "model": (("time",), "", "damped sines about the rest"),
    "rest": (("time",), "", "what it swings about"),
    "frequency": (("mode",), "Hz", "natural frequency |s|/2 pi"),
    "frequency_width": (("mode",), "Hz", WIDTH),
    "damping_ratio": (("mode",), "1", "-Re s/|s|"),
    "damping_ratio_width": (("mode",), "1", WIDTH),
    "amplitude": (("mode",), "", "of the mode at the first time"),
    "piece_time": (("piece",), "s", "middle of a piece of some cycles of the first mode"),
    "piece_amplitude": (("piece",), "", "amplitude in the middle"),
    "piece_frequency": (("piece",), "Hz", "natural frequency"),
    "piece_frequency_width": (("piece",), "Hz", WIDTH),
    "piece_ratio": (("piece",), "1", "damping ratio"),
    "piece_ratio_width": (("piece",), "1", WIDTH),
}
"""Name -> dimensions, unit and long name of every variable; all are always there."""


class Decay(StatelessResult):
    """A free decay taken apart: modes by energy, and the first of them by amplitude.

    ``data`` is an ``xarray.Dataset`` with the samples, what was fitted to them, and the modes; widths are half of 95 %
    intervals. ``warnings`` says what is doubtful about the record.
    """

    kind: ClassVar[str] = "decay"
    picture: ClassVar[str] = "decay"
    what: ClassVar[str] = "free decay"

    @classmethod
    def variables(cls) -> Variables:
        """See :class:`StatelessResult`."""
        return VARIABLES

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.frequencies), "mode")
        yield f"{self.frequencies[0]:.4g} Hz, damping ratio {self.damping_ratios[0]:.3g}"
        yield from super()._facts()

    def _curves(self) -> tuple[Floats, Floats]:
        return self._column("time"), np.stack([self._column("model"), self._column("rest")], axis=-1)

    def _column(self, name: str) -> Floats:
        return np.asarray(self.data[name].values, dtype=float)

    @property
    def frequencies(self) -> Floats:
        """Natural frequencies ``|s|/2 pi`` [Hz] of the modes, that with the most energy first (k,)."""
        return self._column("frequency")

    @property
    def damping_ratios(self) -> Floats:
        """Damping ratios ``-Re s/|s|`` of the modes (k,)."""
        return self._column("damping_ratio")

    @property
    def frequency_intervals(self) -> Floats:
        """95 % intervals of the frequencies [Hz] (k, 2)."""
        return self.frequencies[:, None] + np.outer(self._column("frequency_width"), [-1.0, 1.0])

    @property
    def damping_ratio_intervals(self) -> Floats:
        """95 % intervals of the damping ratios (k, 2)."""
        return self.damping_ratios[:, None] + np.outer(self._column("damping_ratio_width"), [-1.0, 1.0])

    @property
    def material_at_most(self) -> list[AtMost]:
        """The most that a flat loss factor and a Kelvin-Voigt time of the material can be; the rest damps outside."""
        return material_at_most(self.frequencies, self.damping_ratios, self._column("damping_ratio_width"))

    @property
    def noise(self) -> float:
        """Standard deviation of what the fit leaves over, in the unit of the record."""
        return float(self.data.attrs["noise"])

    @property
    def unit(self) -> str:
        """SI unit of the record, empty where it is not known."""
        return str(self.data.attrs["unit"])

    def report(self) -> str:
        """Return a report: modes with intervals, the first by amplitude, doubts."""
        time, unit = self._column("time"), self.unit
        about = f" [{unit}]" if unit else ""
        blocks = [
            f"Free decay{f' of {self.title}' if self.title else ''}, {len(time)} samples from {time[0]:.6g} to "
            f"{time[-1]:.6g} s, {(time[-1] - time[0]) * self.frequencies[0]:.3g} cycles; left over: {self.noise:.3g}"
            f"{f' {unit}' if unit else ''}"
        ]
        rows = [
            [
                str(k + 1),
                f"{f:.6g} ± {df:.2g}",
                f"{z:.5g} ± {dz:.2g}",
                f"{a:.4g}",
            ]
            for k, (f, df, z, dz, a) in enumerate(
                zip(
                    self.frequencies,
                    self._column("frequency_width"),
                    self.damping_ratios,
                    self._column("damping_ratio_width"),
                    self._column("amplitude"),
                    strict=True,
                )
            )
        ]
        blocks.append(
            table("Modes (± 95 %)", ["", "frequency [Hz]", "damping ratio", f"first amplitude{about}"], rows)
        )
        names = ("time", "amplitude", "frequency", "frequency_width", "ratio", "ratio_width")
        pieces = zip(*(self._column(f"piece_{name}") for name in names), strict=True)
        rows = [
            [f"{t:.5g}", f"{a:.4g}", f"{f:.6g} ± {df:.2g}", f"{z:.5g} ± {dz:.2g}"]
            for t, a, f, df, z, dz in pieces
        ]
        if rows:
            header = ["about [s]", f"amplitude{about}", "frequency [Hz]", "damping ratio"]
            blocks.append(table("Mode 1 by amplitude (± 95 %)", header, rows))
        if self.warnings:
            blocks.append(listed("Doubts", self.warnings))
        return "\n\n".join(blocks)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw the samples with what was fitted, what is left over, and the damping ratio over the amplitude.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the samples and what was fitted alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_decay import draw_decay

        return delivered(draw_decay(self, ax), path)
