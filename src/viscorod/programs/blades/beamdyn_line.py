"""The reference line of a BeamDyn blade: key points and initial twist, as a centre line with frames.

OpenFAST/openfast, modules/beamdyn/src/BeamDyn_Subs.f90 (BD_ComputeIniNodalCrv): the section's x axis is the unit
vector across the tangent without a y component, turned about the tangent by minus the initial twist.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Self, TypeAlias

import numpy as np
from scipy.interpolate import CubicSpline

from viscorod.argument_names import known_arguments
from viscorod.checks import checked, checked_with, numbers, of_class
from viscorod.errors import Fault, InputError
from viscorod.model.centrelines.centreline import Centreline
from viscorod.model.centrelines.line_shapes import Straight
from viscorod.model.centrelines.parametric_lines import ThroughPoints
from viscorod.model.rod import Rod
from viscorod.programs.blades.blade_text import Lines
from viscorod.programs.own_laws import refuse_tilt
from viscorod.typing import Floats

__all__ = ["BladeTwist", "LineLike", "ReferenceLine", "beamdyn_axis", "key_points", "reference_line"]

_STRAIGHT = 1e-12


@known_arguments
@dataclass(frozen=True, eq=False)
class ReferenceLine:
    """Key points of a blade in its root axes X, Y, Z, and the twist there.

    Attributes:
        points: (n, 3), m.
        initial_twist: (n,), degrees about the negative tangent, as BeamDyn counts it.
    """

    points: Floats
    initial_twist: Floats

    @classmethod
    @checked
    def read(cls, path: str | Path) -> Self:
        """Read a BeamDyn primary input file with one member.

        Raises:
            InputError: the file cannot be read, has several members, or its key points are incomplete.
        """
        lines = Lines(path)
        lines.find("member_total")
        members = lines.whole("member_total", 1)
        if members > 1:
            raise lines.problem(
                f"{members} members",
                "the spline of each member ends at its last key point; only one member is read",
                "give the key points of one member as an array",
            )
        count = lines.whole("kp_total", 2)
        lines.skip(3)
        rows = np.array([lines.numbers(4, f"key point {k + 1}") for k in range(count)])
        return cls(rows[:, :3], rows[:, 3])

    def centreline(self) -> Centreline:
        """Return a straight line or a cubic spline through the points; both agree with BeamDyn's at the key points."""
        chord = self.points[-1] - self.points[0]
        length = float(np.linalg.norm(chord))
        away = np.cross(self.points - self.points[0], chord / length if length > 0.0 else chord)
        if float(np.abs(away).max()) <= _STRAIGHT * length:
            return Straight(tuple(self.points[0].tolist()), tuple(self.points[-1].tolist()))
        return ThroughPoints(tuple(map(tuple, self.points.tolist())))

    def arc_lengths(self) -> Floats:
        """Return the arc lengths of the key points (n,), m."""
        chords = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        if isinstance(self.centreline(), Straight):
            return np.concatenate([[0.0], np.cumsum(chords)])
        knots = np.concatenate([[0.0], np.cumsum(chords / chords.mean())])
        slope = CubicSpline(knots, self.points).derivative()
        x, weight = np.polynomial.legendre.leggauss(20)
        half = np.diff(knots)[:, None] / 2.0
        speed = np.linalg.norm(slope(knots[:-1, None] + half * (x + 1.0)), axis=2)
        return np.concatenate([[0.0], np.cumsum((half * weight * speed).sum(axis=1))])


LineLike: TypeAlias = ReferenceLine | str | Path | Sequence[Sequence[float]] | Floats


def reference_line(line: LineLike) -> ReferenceLine:
    """Return a reference line from key points (n, 3), key points with twist (n, 4; m and degrees), or a primary file.

    Raises:
        InputError: there are not at least two points of three or four numbers, or the file cannot be read.
    """
    if isinstance(line, ReferenceLine):
        return line
    if isinstance(line, str | Path):
        return ReferenceLine.read(line)
    try:
        array = np.array(line, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    if array.ndim != 2 or array.shape[1] not in (3, 4) or len(array) < 2 or not np.isfinite(array).all():
        raise InputError(
            Fault(
                "centreline",
                f"an array of the shape {array.shape}",
                "the reference line needs key points",
                "give at least two rows [x, y, z] in m, or [x, y, z, initial_twist] with degrees",
            )
        )
    return ReferenceLine(array[:, :3], array[:, 3] if array.shape[1] == 4 else np.zeros(len(array)))


_ALONG = 1e-6
"""The least component along +Z of a tangent of a blade."""


def beamdyn_axis(tangent: Floats, angle: float) -> Floats:
    """Return BeamDyn's x axis of a section (3,) for the unit tangent (3,) and the angle about it, rad.

    Raises:
        InputError: the tangent does not point along +Z, in which BeamDyn's blades run.
    """
    if tangent[2] < _ALONG:
        x, y, z = tangent.tolist()
        raise InputError(
            Fault(
                "centreline",
                f"a tangent along ({x:.3g}, {y:.3g}, {z:.3g})",
                "BeamDyn's blades run along +Z from root to tip",
                "give a rod that nowhere turns back; one that starts in another direction is turned",
            )
        )
    first = np.array([tangent[2], 0.0, -tangent[0]]) / np.hypot(tangent[0], tangent[2])
    return np.asarray(np.cos(angle) * first + np.sin(angle) * np.cross(tangent, first))


class BladeTwist:
    """The angle of BeamDyn's section axes about d3, relative to the rotation-minimising frame, by arc length.

    Args:
        line: with its twist, which a cubic spline over the arc length continues between key points.
        centreline: of the line.
        d1: section axis at the root, from which the rotation-minimising frame starts.
    """

    def __init__(self, line: ReferenceLine, centreline: Centreline, d1: Floats) -> None:
        arcs, angles = line.arc_lengths(), -np.deg2rad(line.initial_twist)
        self._angle = CubicSpline(arcs, angles) if len(arcs) > 2 else None
        self._ends = arcs[[0, -1]], angles[[0, -1]]
        self._centreline, self._d1 = centreline, tuple(d1.tolist())

    def angle(self, s: float) -> float:
        """Return minus the initial twist at the arc length `s` (m), rad."""
        return float(np.interp(s, *self._ends) if self._angle is None else self._angle(s))

    def __call__(self, s: float) -> float:
        """Return the angle at the arc length `s` (m), rad."""
        _, frames = self._centreline.frames([s], self._d1)
        natural = frames[0]
        axis = beamdyn_axis(natural[:, 2], self.angle(s))
        return float(np.arctan2(axis @ natural[:, 1], axis @ natural[:, 0]))


def starts_along_z(rod: Rod) -> bool:
    """Return whether a rod leaves its root towards +Z, as BeamDyn's blades do."""
    return bool(rod.frames([0.0])[1][0, 2, 2] >= _ALONG)


@checked_with(rod=of_class(Rod), stations=numbers)
def key_points(rod: Rod, stations: Sequence[float] | Floats) -> Floats:
    """Return key points and initial twist (n, 4), m and degrees, of a rod at fractions of its length.

    They are the rows kp_xr, kp_yr, kp_zr, initial_twist of a primary file. BeamDyn's blades run along +Z: the key
    points of a rod that does not start so (`starts_along_z`) are those of the rod moved until d1, d2 and d3 at its
    root are X, Y and Z, and its root the origin.

    Raises:
        InputError: the rod turns back on its way.
    """
    refuse_tilt(rod)
    fractions = np.atleast_1d(np.asarray(stations, dtype=np.float64))
    if not fractions.size:
        raise InputError(
            Fault("stations", "none", "there has to be one at least", "give fractions of the length")
        )
    positions, frames = rod.frames(fractions * rod.length)
    if not starts_along_z(rod):
        root, axes = (values[0] for values in rod.frames([0.0]))
        positions, frames = (positions - root) @ axes, axes.T @ frames
    rows = []
    for position, frame in zip(positions, frames, strict=True):
        first = beamdyn_axis(frame[:, 2], 0.0)
        second = np.cross(frame[:, 2], first)
        rows.append([*position, np.arctan2(frame[:, 0] @ second, frame[:, 0] @ first)])
    table = np.array(rows)
    table[:, 3] = -np.rad2deg(np.unwrap(table[:, 3]))
    return table
