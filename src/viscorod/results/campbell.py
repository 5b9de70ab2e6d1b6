"""The result of a Campbell diagram: modes over the speed of a rotation, critical speeds, limits of stability."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from viscorod.argument_names import known_arguments
from viscorod.checks import checked
from viscorod.results.followed_modes import FollowedModes, error_text
from viscorod.results.stateless_result import Variables
from viscorod.results.text_numbers import number, scaled
from viscorod.results.text_table import table
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Campbell", "CriticalSpeed"]


@known_arguments
@dataclass(frozen=True)
class CriticalSpeed:
    """A speed at which a frequency is a multiple of it.

    Attributes:
        speed: [rad/s]; mode: name of the mode; number: from 1; order: the multiple.
        frequency: of the mode in the frame of the diagram [Hz]; damping_ratio: there.
        mesh_error: estimated error of the speed by the mesh, in parts of it.
    """

    speed: float
    mode: str
    number: int
    order: float
    frequency: float
    damping_ratio: float
    mesh_error: float


class Campbell(FollowedModes):
    """Modes over the speed of a steady rotation, each followed through crossings and veerings.

    ``data`` is an ``xarray.Dataset`` by ``speed`` [rad/s] and ``mode``: roots, frequencies [Hz], damping ratios, whirl;
    critical speeds, limits of stability, and where frequencies cross and veer.
    """

    kind: ClassVar[str] = "campbell"
    picture: ClassVar[str] = "campbell"
    what: ClassVar[str] = "Campbell diagram"
    along: ClassVar[str] = "speed"
    unit: ClassVar[str] = "rad/s"
    more: ClassVar[Variables] = {
        "whirl": (
            ("speed", "mode"),
            "1",
            "part across the axis that goes with the spin in space, less that against",
        ),
        "engine_order": (("engine_order",), "1", "multiples of the speed at which something excites"),
        "critical_speed": (("critical",), "rad/s", "at which a frequency is a multiple of the speed"),
        "critical_mode": (("critical",), "", "number of the mode from 0"),
        "critical_order": (("critical",), "1", "the multiple"),
        "critical_frequency": (("critical",), "Hz", "of the mode in the frame of the diagram"),
        "critical_damping_ratio": (("critical",), "1", "of the mode"),
        "critical_error": (("critical",), "1", "estimated error by the mesh, in parts of the speed"),
    }

    @property
    def speeds(self) -> Floats:
        """Angular speeds [rad/s] ``(n,)``."""
        return self.values

    @property
    def frame(self) -> str:
        """In which frequencies are seen, "turning" or "space"."""
        return str(self.data.attrs.get("frame", "turning"))

    @property
    def engine_orders(self) -> Floats:
        """Multiples of the speed at which something excites ``(k,)``."""
        return np.asarray(self.data["engine_order"].values, dtype=float)

    @property
    def whirl(self) -> Floats:
        """Part of the motion across the axis that goes round with the spin in space, less that against it.

        1 is forward whirl, -1 backward whirl, 0 a motion in a plane, along the axis or about it; ``(n, modes)``.
        """
        return np.asarray(self.data["whirl"].values, dtype=float)

    @property
    def critical_speeds(self) -> list[CriticalSpeed]:
        """Critical speeds in order."""
        data, names = self.data, self.modes
        return [
            CriticalSpeed(
                float(data["critical_speed"].values[k]),
                names[int(data["critical_mode"].values[k])],
                int(data["critical_mode"].values[k]) + 1,
                float(data["critical_order"].values[k]),
                float(data["critical_frequency"].values[k]),
                float(data["critical_damping_ratio"].values[k]),
                float(data["critical_error"].values[k]),
            )
            for k in range(data.sizes["critical"])
        ]

    def _blocks(self) -> list[str]:
        return [self._heading(), self._modes(), self._critical(), self._limits()]

    def _heading(self) -> str:
        speeds = self.speeds
        seen = "as seen on the model that turns" if self.frame == "turning" else "as seen from space"
        title = f"{self.title}\n" if self.title else ""
        return (
            f"{title}Campbell diagram, {len(self.modes)} modes at {len(speeds)} speeds from {speeds[0]:.6g} to "
            f"{speeds[-1]:.6g} rad/s, frequencies {seen}"
        )

    def _critical(self) -> str:
        orders = ", ".join(f"{order:g}" for order in self.engine_orders) or "none"
        if not self.critical_speeds:
            unsure = "" if self.outcome == "completed" else "; not all of it was sought"
            return f"No critical speed (engine orders: {orders}{unsure})"
        factor, hertz = scaled("Hz", [one.frequency for one in self.critical_speeds])
        rows = [
            [
                one.mode,
                f"{one.order:g}",
                f"{one.speed:.10g}",
                f"{one.speed * 60.0 / (2.0 * np.pi):.8g}",
                f"{factor * one.frequency:.6g}",
                number(one.damping_ratio, 4, size=1.0),
                error_text(one.mesh_error),
            ]
            for one in self.critical_speeds
        ]
        header = ["mode", "engine order", "[rad/s]", "[rpm]", f"[{hertz}]", "damping ratio", "mesh error"]
        return table("Critical speeds", header, rows)

    @checked
    def plot(self, path: str | Path | None = None, *, ax: Axes | None = None) -> Figure:
        """Draw frequencies and damping ratios over the speed, with engine orders, critical speeds and limits.

        Args:
            path: picture to write; the suffix gives the format (.png, .pdf, .svg). Without it nothing is written.
            ax: axes of yours to draw into: the frequencies alone.

        Returns:
            The figure; a notebook shows it.

        Raises:
            InputError: the picture cannot be written.
        """
        from viscorod.pictures.picture import delivered
        from viscorod.pictures.plots.plot_campbell import draw_campbell

        return delivered(draw_campbell(self, ax), path)
