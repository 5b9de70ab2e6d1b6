"""Drawing rods in space: smooth centre lines, in the plane of the motion or in three dimensions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.results.schema import AXES
from viscorod.results.style import GREY, INK, SMALL, TEXT, clean, heading, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from matplotlib.gridspec import SubplotSpec

    from viscorod.results.result import Result

_FLAT = 1e-3  # a motion whose extent across a plane is below this part of the largest is drawn in that plane
_FINE = 12  # drawn points between neighbouring stations


@dataclass(frozen=True)
class View:
    """The global axes that a picture shows: two for a planar motion, three otherwise."""

    axes: tuple[int, ...]
    scale: float
    unit: str

    @classmethod
    def of(cls, position: Floats) -> View:
        """Choose the view of positions ``(state, station, axis)`` [m]."""
        extent = np.ptp(position.reshape(-1, 3), axis=0)
        thin = int(np.argmin(extent))
        largest = float(np.max(extent))
        planar = extent[thin] <= _FLAT * largest
        scale, unit = scaled("m", largest)
        return cls(tuple(axis for axis in range(3) if not (planar and axis == thin)), scale, unit)

    @property
    def name(self) -> str:
        """The plane or space in words: "xy plane", "xyz"."""
        letters = "".join(AXES[axis] for axis in self.axes)
        return f"{letters} plane" if len(self.axes) == 2 else letters

    def add_axes(self, picture: Figure | SubFigure, spec: SubplotSpec, title: str) -> Axes:
        """Add labelled axes of equal scales for this view."""
        names = [f"{AXES[axis]} [{self.unit}]" for axis in self.axes]
        if len(self.axes) == 2:
            axes = picture.add_subplot(spec)
            clean(axes, names[0], names[1])
            axes.set_aspect("equal", adjustable="datalim")
        else:
            space: Any = picture.add_subplot(spec, projection="3d")
            space.set_xlabel(names[0], fontsize=TEXT, labelpad=6)
            space.set_ylabel(names[1], fontsize=TEXT, labelpad=6)
            space.set_zlabel(names[2], fontsize=TEXT, labelpad=6)
            space.tick_params(labelsize=SMALL - 1.0, pad=1)
            axes = space
        heading(axes, title)
        return axes

    def project(self, points: Floats) -> tuple[Floats, ...]:
        """Return the coordinates of points ``(n, 3)`` [m] along the shown axes, in the shown unit."""
        return tuple(points[:, axis] * self.scale for axis in self.axes)

    def finish(self, axes: Axes, positions: Floats) -> None:
        """Give a three-dimensional axes equal scales around all positions ``(..., 3)`` [m]."""
        if len(self.axes) == 2:
            return
        space: Any = axes
        points = positions.reshape(-1, 3) * self.scale
        low, high = points.min(axis=0), points.max(axis=0)
        room = np.maximum(high - low, 0.25 * float(np.max(high - low)))
        centre = 0.5 * (low + high)
        for set_limits, middle, span in zip(
            (space.set_xlim, space.set_ylim, space.set_zlim), centre, room, strict=True
        ):
            set_limits(middle - 0.55 * span, middle + 0.55 * span)
        space.set_box_aspect(room, zoom=1.0)
        for axis, span in zip((space.xaxis, space.yaxis, space.zaxis), room / np.max(room), strict=True):
            axis.set_major_locator(_ticks(span))


class Curves:
    """Smooth centre lines through the stations of every rod."""

    def __init__(self, result: Result) -> None:
        self._matrices = []
        sites = result.sites
        count = int(result.data.sizes["station"])
        arc = np.asarray(result.data["station_s"].values, dtype=float)
        for rod in sites.rods:
            known = arc[sites.stations(rod)]
            u = np.linspace(0.0, known.size - 1.0, _FINE * (known.size - 1) + 1)
            matrix = np.zeros((u.size, count))
            for row, s in enumerate(np.interp(u, np.arange(known.size), known)):
                site = sites.along(rod, float(s))
                matrix[row, site.stations] = site.weights
            self._matrices.append(matrix)

    def draw(self, axes: Axes, view: View, positions: Floats, **line: Any) -> None:
        """Draw all rods at station positions ``(station, 3)`` [m], with matplotlib's line properties."""
        for matrix in self._matrices:
            axes.plot(*view.project(matrix @ positions), **line)
            line.pop("label", None)


def mark_supports(axes: Axes, view: View, result: Result, positions: Floats) -> None:
    """Mark the supported places on station positions ``(station, 3)`` [m]."""
    points = []
    for name in result.data["support"].values if "support" in result.data.coords else ():
        place = str(name).rsplit(" at ")[-1]  # "clamp at beam.start"
        try:
            points.append(result.sites.at(place).of(positions))
        except InputError:  # a support may bear a name of its own that is no place
            continue
    if points:
        look: dict[str, Any] = {
            "linestyle": "none",
            "marker": "s",
            "markersize": 7,
            "color": INK,
            "zorder": 5,
        }
        axes.plot(
            *view.project(np.array(points)), label="support" if len(points) == 1 else "supports", **look
        )


def draw_reference(axes: Axes, view: View, curves: Curves, result: Result) -> None:
    """Draw the reference shape as a dashed grey line."""
    reference = np.asarray(result.data["reference_position"].values, dtype=float)
    curves.draw(axes, view, reference, color=GREY, linestyle=(0, (4, 3)), linewidth=1.2, label="reference")


def _ticks(span: float) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(nbins=max(2, round(5 * float(span))))
