"""Small drawings of lines as SVG text, for notebooks: no library is loaded for them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from viscorod.typing import Floats

__all__ = ["Drawing", "on_paper"]

WIDTH, HEIGHT, MARGIN = 260.0, 130.0, 8.0
MOST = 300
"""Points of a line that are drawn."""
MAIN = 'fill="none" stroke="#0072B2" stroke-width="1.6"'
FAINT = 'fill="none" stroke="currentColor" stroke-opacity="0.45" stroke-width="1" stroke-dasharray="4 3"'
AREA = 'fill="#56B4E9" fill-opacity="0.45" fill-rule="evenodd" stroke="#0072B2" stroke-width="1.2"'
FLAT = 1e-3
"""Extent across a plane, as a part of the largest, below which what is seen lies in it."""
AZIMUTH, ELEVATION = math.radians(-60.0), math.radians(25.0)


def on_paper(groups: Sequence[Floats]) -> list[Floats]:
    """Return groups of points in space ``(k, 3)`` as the eye sees them, ``(k, 2)``: in their plane, or from aside."""
    points = np.concatenate([np.zeros((0, 3)), *groups])
    extent = np.ptp(points, axis=0) if len(points) else np.ones(3)
    thin = int(np.argmin(extent))
    if extent[thin] <= FLAT * float(extent.max()):
        # what lies along one axis is seen from in front
        kept = [axis for axis in range(3) if axis != thin]
        return [group[:, kept] for group in groups]
    right = np.array([-math.sin(AZIMUTH), math.cos(AZIMUTH), 0.0])
    up = np.array(
        [
            -math.sin(ELEVATION) * math.cos(AZIMUTH),
            -math.sin(ELEVATION) * math.sin(AZIMUTH),
            math.cos(ELEVATION),
        ]
    )
    return [np.stack([group @ right, group @ up], axis=-1) for group in groups]


@dataclass
class Drawing:
    """Lines and dots on paper, each with its style.

    Attributes:
        equal: whether both directions have one scale, as of shapes.
    """

    equal: bool = True
    _lines: list[tuple[list[Floats], str]] = field(default_factory=list)
    _dots: list[tuple[Floats, str]] = field(default_factory=list)

    def line(self, points: Floats, *, faint: bool = False) -> None:
        """Add a line through points ``(k, 2)``."""
        self._lines.append(([thinned(points)], FAINT if faint else MAIN))

    def area(self, outlines: Iterable[Floats]) -> None:
        """Add what is inside of outlines ``(k, 2)`` and outside of their holes."""
        self._lines.append((list(outlines), AREA))

    def squares(self, points: Floats) -> None:
        """Add small squares at points ``(k, 2)``."""
        self._dots.append(
            (points, '<rect x="{x:.1f}" y="{y:.1f}" width="6" height="6" transform="translate(-3 -3)" ')
        )

    def dots(self, points: Floats) -> None:
        """Add dots at points ``(k, 2)``."""
        self._dots.append((points, '<circle cx="{x:.1f}" cy="{y:.1f}" r="2.6" '))

    def svg(self) -> str:
        """Return the drawing; empty where there is nothing to see."""
        groups = [line for lines, _ in self._lines for line in lines] + [points for points, _ in self._dots]
        points = np.concatenate([np.zeros((0, 2)), *groups])
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return ""
        low, extent = points.min(axis=0), np.ptp(points, axis=0)
        room = np.array([WIDTH - 2.0 * MARGIN, HEIGHT - 2.0 * MARGIN])
        with np.errstate(divide="ignore"):
            scale = np.where(extent > 0.0, room / np.where(extent > 0.0, extent, 1.0), np.inf)
        if self.equal:
            scale = np.full(2, float(scale.min()))
        scale = np.where(np.isfinite(scale), scale, 1.0)
        first = MARGIN + 0.5 * (room - scale * extent)

        def placed(group: Floats) -> Floats:
            found: Floats = first + scale * (group - low)
            found[:, 1] = HEIGHT - found[:, 1]
            return found

        parts = []
        for lines, style in self._lines:
            close = " Z" if style is AREA else ""
            path = " ".join(_path(placed(line)) + close for line in lines if len(line))
            parts.append(f'<path d="{path}" {style}/>')
        for dots, shape in self._dots:
            parts += [shape.format(x=x, y=y) + 'fill="currentColor"/>' for x, y in placed(dots).tolist()]
        size = f'width="{WIDTH:.0f}" height="{HEIGHT:.0f}" viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}"'
        return f'<svg xmlns="http://www.w3.org/2000/svg" style="flex-shrink:0" {size}>{"".join(parts)}</svg>'


def thinned(points: Floats) -> Floats:
    """Return as many points of a line ``(k, 2)`` as are drawn, its ends among them."""
    if len(points) <= MOST:
        return points
    chosen: Floats = points[np.linspace(0, len(points) - 1, MOST).round().astype(int)]
    return chosen


def _path(points: Floats) -> str:
    """Return the words of a path; gaps where a point is not finite."""
    words, move = [], True
    for x, y in points.tolist():
        if not (math.isfinite(x) and math.isfinite(y)):
            move = True
            continue
        words.append(f"{'M' if move else 'L'}{x:.1f} {y:.1f}")
        move = False
    return " ".join(words)
