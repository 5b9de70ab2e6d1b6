"""Drawing rods in space: smooth centre lines, in the plane of the motion or in a parallel projection."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import InputError
from viscorod.pictures.plots.line_of_sight import projection
from viscorod.pictures.style import (
    GREY,
    INK,
    LIGHT,
    SMALL,
    clean,
    heading,
    label_once,
)
from viscorod.results.data_schema import AXES
from viscorod.results.text_numbers import quantity, scaled
from viscorod.typing import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from viscorod.results.result import Result

_FLAT = 1e-3  # a motion whose extent across a plane is below this part of the largest is drawn in that plane
_SLIGHT = 0.06  # a motion in a plane that is flatter is drawn larger across
_STRAIGHT = 1e-9  # and one that is flatter than this does not leave its line
_FINE, _MOST = (
    12,
    50_000,
)  # drawn points between neighbouring stations, and of all rods unless they have more stations
_COILED = 2.5  # a rod longer than this multiple of its extent hides what is drawn over it
_CORNER = (0.09, 0.05)  # of the axes, where its directions are shown
_REACH, _LETTER = 34.0, 10.0  # of their arrows and of the letters there [pixels at 72 per inch]
_TRIES = 5  # to make room for them
_GAP = 1.25  # from picture to picture in a strip, as a multiple of their width


@dataclass(frozen=True)
class View:
    """The projection of space onto a picture.

    Attributes:
        projection: from global components to those on paper, right and up, shape (2, 3).
        plane: the two global axes of a planar motion, None for a view in space.
        floor: height of the floor that bears the shadows of a view in space [m].
        scale: from m to the shown unit.
        unit: the shown unit.
        origin: what is in the middle of the paper's coordinates, (3,) [m].
        across: of a plane view whose axes have scales of their own, the one that is drawn larger with its scale and
            unit, 0 to the right or 1 up.
    """

    projection: Floats
    plane: tuple[int, int] | None
    floor: float
    scale: float
    unit: str
    origin: Floats = field(default_factory=lambda: np.zeros(3))
    across: tuple[int, float, str] | None = None

    @classmethod
    def of(
        cls,
        positions: Floats,
        *,
        enlarged: bool = False,
        swept: Floats | None = None,
        lines: Floats | None = None,
    ) -> View:
        """Choose the view of positions ``(..., 3)`` [m].

        Args:
            positions: of everything that is drawn; enlarged: whether what hardly leaves a line is drawn larger.
            swept: normals ``(..., 3)`` of what moving lines sweep over, long where they move far: where a view in
                space looks across them, the motion is along the line of sight, or along the line, and is not seen.
            lines: points ``(k, 3)`` [m] along the lines of one state, which are not to hide each other.
        """
        points = positions.reshape(-1, 3)
        extent = np.ptp(points, axis=0)
        thin = int(np.argmin(extent))
        largest = float(np.max(extent))
        scale, unit = scaled("m", largest)
        if extent[thin] <= _FLAT * largest:
            first, second = (axis for axis in range(3) if axis != thin)
            slight = int(extent[second] <= extent[first])
            low = float(extent[[first, second][slight]])
            across = None
            if enlarged and _STRAIGHT * largest < low < _SLIGHT * largest:
                across = (slight, *scaled("m", low))
            return cls(np.eye(3)[[first, second]], (first, second), 0.0, scale, unit, across=across)
        floor = float(points[:, 2].min()) - 0.1 * largest
        return cls(projection(points, swept, lines), None, floor, scale, unit)

    def strip(self, positions: Floats) -> Floats:
        """Return shifts ``(count, 3)`` [m] that set states ``(count, station, 3)`` side by side on paper."""
        right = self.projection[0]
        shift: Floats = _GAP * float(np.ptp(positions @ right)) * np.arange(len(positions))[:, None] * right
        return shift

    def shifted(self, shift: Floats) -> View:
        """Return this view of everything moved by ``shift (3,)`` [m]."""
        return replace(self, origin=self.origin - shift)

    @property
    def name(self) -> str:
        """Where the picture is, in words: "in the xy plane" or "in space"."""
        if self.plane is None:
            return "in space"
        plane = f"in the {''.join(AXES[k] for k in self.plane)} plane"
        return f"{plane}, {self.enlarged} enlarged" if self.enlarged else plane

    @property
    def enlarged(self) -> str:
        """The axis that is drawn larger than the other, if one is."""
        return AXES[self.plane[self.across[0]]] if self.plane and self.across else ""

    def on_paper(self, points: Floats) -> Floats:
        """Return points ``(n, 3)`` [m] on paper, ``(2, n)`` in the shown unit."""
        paper: Floats = self.scale * self.projection @ (points - self.origin).T
        if self.across is not None:
            axis, scale, _ = self.across
            paper[axis] *= scale / self.scale
        return paper

    def prepare(self, axes: Axes, title: str) -> None:
        """Give an axes equal scales, a heading and, in a plane, labels."""
        if self.across is None:
            axes.set_aspect("equal", adjustable="datalim")
        else:
            axes.margins(0.05)
        heading(axes, title)
        if self.plane is None:
            axes.set_axis_off()
        else:
            units = [self.unit, self.unit]
            if self.across is not None:
                units[self.across[0]] = self.across[2]
            first, second = (f"{AXES[axis]} [{unit}]" for axis, unit in zip(self.plane, units, strict=True))
            clean(axes, first, second)

    def finish(self, axes: Axes) -> None:
        """Add the directions of the axes and a scale to a view in space, once everything is drawn."""
        if self.plane is not None:
            return
        for axis, direction in enumerate(self.projection.T):
            axes.annotate(
                AXES[axis],
                _CORNER,
                xycoords="axes fraction",
                xytext=tuple(_REACH * direction),
                textcoords="offset points",
                ha="center",
                va="center",
                fontsize=SMALL,
                arrowprops={"arrowstyle": "<-", "color": INK, "shrinkA": 2.0, "shrinkB": 0.0},
            )
        (left, bottom), (right, _) = axes.dataLim.get_points()
        length = _round_length(0.3 * (right - left))
        gap = 0.06 * axes.dataLim.height
        axes.plot([right - length, right], [bottom - gap, bottom - gap], color=INK, linewidth=2.0)
        text = quantity(length / self.scale, "m", 1)
        axes.annotate(
            text,
            (right - 0.5 * length, bottom - gap),
            (0, -4),
            textcoords="offset points",
            ha="center",
            va="top",
            fontsize=SMALL,
        )
        axes.update_datalim([(right, bottom - 4.5 * gap)])  # room for the text
        axes.autoscale_view()
        self._clear_corner(axes)

    def _clear_corner(self, axes: Axes) -> None:
        """Make room below what is drawn, as far as it is in the way of the directions of the axes."""
        figure = axes.get_figure(root=True)
        assert figure is not None
        dot = figure.dpi / 72.0
        drawn = np.concatenate([line.get_xydata() for line in axes.lines])
        drawn = drawn[np.isfinite(drawn).all(axis=1)]
        for _ in range(_TRIES):
            axes.apply_aspect()
            box, pixels = axes.bbox, axes.transData.transform(drawn)
            middle = np.array([box.x0, box.y0]) + np.array(_CORNER) * [box.width, box.height]
            room = dot * (_REACH + _LETTER)
            inside = pixels[np.abs(pixels[:, 0] - middle[0]) < room]
            inside = inside[(inside[:, 1] > box.y0 - dot) & (inside[:, 1] < middle[1] + room)]
            if not inside.size:
                return
            lacking = (middle[1] + room - float(inside[:, 1].min())) / box.height
            (low, high) = axes.get_ylim()
            axes.update_datalim([(float(np.mean(axes.get_xlim())), low - lacking * (high - low))])
            axes.autoscale_view()


class Curves:
    """Smooth centre lines through the stations of every rod, all of them one line with gaps."""

    def __init__(self, result: Result) -> None:
        self._shadow = "shadow"
        sites = result.sites
        arc = np.asarray(result.stored["station_s"].values, dtype=float)
        known = {rod: arc[sites.stations(rod)] for rod in sites.rods}
        pieces = int(np.clip(_MOST // max(sum(s.size for s in known.values()), 1), 1, _FINE))
        self._taken, self._ends, first = [], [], 0
        for rod, s in known.items():
            u = np.linspace(0.0, s.size - 1.0, pieces * (s.size - 1) + 1)
            self._taken.append(sites.weights(rod, np.interp(u, np.arange(s.size), s)))
            first += u.size
            self._ends.append(first)

    def _rods(self, positions: Floats) -> Iterator[Floats]:
        """Yield the drawn points of every rod ``(k, 3)`` [m]."""
        for stations, weights in self._taken:
            yield np.einsum("kw,kwc->kc", weights, positions[stations])

    def points(self, positions: Floats) -> Floats:
        """Return the drawn points of all rods at station positions ``(station, 3)`` [m], ``(k, 3)``."""
        return np.concatenate(list(self._rods(positions))) if self._taken else np.zeros((0, 3))

    def draw(self, axes: Axes, view: View, positions: Floats, **line: Any) -> None:
        """Draw all rods at station positions ``(station, 3)`` [m], with matplotlib's line properties."""
        if not self._taken:
            return
        points = np.insert(self.points(positions), self._ends[:-1], np.nan, axis=0)
        if view.plane is None:
            shadow = points.copy()
            shadow[:, 2] = view.floor
            axes.plot(*view.on_paper(shadow), color=LIGHT, linewidth=1.0, zorder=1, label=self._shadow)
            self._shadow = "_"
        axes.plot(*view.on_paper(points), **line)

    def coiled(self, positions: Floats) -> bool:
        """Return whether some rod is so coiled at station positions ``(station, 3)`` that states hide each other."""
        for curve in self._rods(positions):
            length = float(np.sum(np.linalg.norm(np.diff(curve, axis=0), axis=1)))
            if length > _COILED * float(np.linalg.norm(np.ptp(curve, axis=0))):
                return True
        return False


def mark_supports(axes: Axes, view: View, result: Result, positions: Floats) -> None:
    """Mark the supported places on station positions ``(station, 3)`` [m]."""
    points = []
    for name in result.stored["support"].values if "support" in result.stored.coords else ():
        place = str(name).rsplit(" at ")[-1]  # "clamp at beam.start"
        try:
            points.append(result.sites.at(place).of(positions))
        except InputError:  # a support may bear a name of its own that is not a place
            continue
    if points:
        name = label_once(axes, "support" if len(points) == 1 else "supports")
        axes.plot(*view.on_paper(np.array(points)), "s", markersize=7, color=INK, zorder=5, label=name)


def draw_reference(axes: Axes, view: View, curves: Curves, result: Result) -> None:
    """Draw the reference shape as a dashed grey line."""
    reference = np.asarray(result.stored["reference_position"].values, dtype=float)
    curves.draw(axes, view, reference, color=GREY, linestyle=(0, (4, 3)), linewidth=1.2, label="reference")


def _round_length(length: float) -> float:
    """Return the largest of 1, 2 and 5 times a power of ten that is not above ``length``."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= length * (1.0 + 1e-9))
