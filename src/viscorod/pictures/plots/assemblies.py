"""Drawing what is between and beside rods: rigid bodies, joints and springs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.rotations.quaternion import matrices
from viscorod.pictures.plots.projection_view import View
from viscorod.pictures.style import INK, label_once
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from viscorod.results.result import Result

TEETH = 6
"""Of a spring's zigzag."""
WIDTH = 0.01
"""Height of the teeth as a part of the drawn size."""


@dataclass(frozen=True)
class DrawnBody:
    """Station of a mass centre, and those of what is fixed to the body: its points and rod ends."""

    name: str
    centre: int
    fixed: Integers


class Assembly:
    """Bodies, joints and springs of a result, in whatever state."""

    def __init__(self, result: Result) -> None:
        data, sites = result.stored, result.sites
        member = np.asarray(data["station_body"].values, dtype=str) if "station_body" in data else None
        self.bodies = []
        for place in sites.bodies:
            if "." in place or member is None:
                continue
            centre = int(sites.stations(place)[0])
            fixed = np.flatnonzero(member == place)
            self.bodies.append(DrawnBody(place, centre, fixed[fixed != centre]))
        empty = "connection_kind" not in data
        kind = np.zeros(0, dtype=str) if empty else np.asarray(data["connection_kind"].values, dtype=str)
        self._station = np.zeros((0, 2), dtype=int) if empty else data["connection_station"].values
        self._arm = np.zeros((0, 2, 3)) if empty else data["connection_arm"].values
        self._joint = kind == "joint"

    @property
    def empty(self) -> bool:
        """Whether there is nothing but rods."""
        return not self.bodies and not len(self._joint)

    def ends(self, positions: Floats, rotations: Floats) -> Floats:
        """Return where all joints and springs sit on both sides ``(count, 2, 3)`` [m].

        Args:
            positions, rotations: of all stations, ``(stations, 3)`` [m] and ``(stations, 4)``.
        """
        ground = self._station < 0
        k = np.where(ground, 0, self._station)
        turned = matrices(rotations[k].reshape(-1, 4)).reshape(*k.shape, 3, 3)
        moved: Floats = positions[k] + np.einsum("csij,csj->csi", turned, self._arm)
        return np.where(ground[..., None], self._arm, moved)

    def draw(
        self,
        axes: Axes,
        view: View,
        positions: Floats,
        rotations: Floats,
        colour: str | tuple[float, ...] = INK,
    ) -> None:
        """Draw bodies and joints in one state; see :meth:`draw_springs` for the rest."""
        for body in self.bodies:
            centre = positions[body.centre]
            for other in positions[body.fixed]:
                axes.plot(*view.on_paper(np.array([centre, other])), color=colour, linewidth=1.0, zorder=3)
        if self.bodies:
            points = positions[[body.centre for body in self.bodies]]
            name = label_once(axes, "body" if len(self.bodies) == 1 else "bodies")
            axes.plot(
                *view.on_paper(points),
                "D",
                markersize=6,
                color=colour,
                markeredgecolor="white",
                markeredgewidth=0.6,
                zorder=4,
                label=name,
            )
        ends = self.ends(positions, rotations)[self._joint]
        if not len(ends):
            return
        for side in ends:
            axes.plot(*view.on_paper(side), ":", color=colour, linewidth=1.0, zorder=3)
        name = label_once(axes, "joint" if len(ends) == 1 else "joints")
        axes.plot(
            *view.on_paper(ends[:, 1]),
            "o",
            markersize=5.5,
            markerfacecolor="white",
            markeredgecolor=colour,
            markeredgewidth=1.3,
            zorder=6,
            label=name,
        )

    def draw_springs(
        self,
        axes: Axes,
        view: View,
        positions: Floats,
        rotations: Floats,
        colour: str | tuple[float, ...] = INK,
    ) -> None:
        """Draw the springs in one state."""
        springs = self.ends(positions, rotations)[~self._joint]
        size = view.scale * float(np.ptp(positions @ view.projection.T, axis=0).max())
        for side in springs:
            name = label_once(axes, "spring" if len(springs) == 1 else "springs")
            line = zigzag(view.on_paper(side), WIDTH * size)
            axes.plot(*line, color=colour, linewidth=0.7, zorder=1.5, label=name)


def zigzag(ends: Floats, width: float) -> Floats:
    """Return a spring between two points on paper ``(2, 2)``, columns, as a line ``(2, n)``."""
    a, b = ends.T
    along = b - a
    length = float(np.linalg.norm(along))
    if length == 0.0:
        return ends
    across = np.array([-along[1], along[0]]) / length
    part = np.concatenate([[0.0], np.linspace(0.2, 0.8, 2 * TEETH + 1), [1.0]])
    height = np.zeros(part.size)
    height[2:-2:2], height[3:-2:2] = 1.0, -1.0
    height[1] = height[-2] = 0.0
    line: Floats = a[:, None] + along[:, None] * part + min(width, 0.3 * length) * across[:, None] * height
    return line
