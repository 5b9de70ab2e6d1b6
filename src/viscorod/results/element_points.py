"""Places on rods in the element's own interpolation: positions, frames, strains between the stored stations.

An element of order p has p + 1 Gauss-Lobatto nodes, which are stations, and p Gauss points. With the Lagrange basis N
of the nodes, ``r = sum N_k r_k`` and ``q~ = sum N_k q_k`` in one hemisphere, ``q = q~/|q~|`` (Lang, Linn and Arnold
2011 for order 1). Strains, section forces and dissipation are the polynomial of degree p - 1 through the Gauss points.

That polynomial is the strain the element stores energy with: p Gauss points integrate as if strains were of degree
p - 1 (Malkus and Hughes 1978, the equivalence of reduced integration and mixed elements). Derivatives of the
interpolated poses agree with it at the Gauss points only; between them their shear and stretch are off by as much as
the shear itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.results.result_places import by_name, lagrange_weights
from viscorod.typing import Floats, Integers

if TYPE_CHECKING:
    from viscorod.results.result_places import ResultPlace, ResultPlaces
    from viscorod.results.state_arrays import Stored


@dataclass(frozen=True)
class Poses:
    """Fields at some stations.

    Attributes:
        position: ``(..., stations, 3)`` [m]; rotation: unit quaternions ``(..., stations, 4)``.
    """

    position: Floats
    rotation: Floats


@dataclass(frozen=True)
class ElementPoints:
    """Places in elements of one order p.

    Attributes:
        places: numbers of these places among all requested ones ``(n,)``.
        element: number of the element of each ``(n,)``.
        nodes: stations of every element ``(elements, p + 1)``, numbers among those that are read.
        gauss: Gauss points of every element ``(elements, p)``, likewise.
        values: of the basis of the nodes ``(n, p + 1)``.
        weights: of the polynomials through the Gauss points ``(n, p)``.
    """

    places: Integers
    element: Integers
    nodes: Integers
    gauss: Integers
    values: Floats
    weights: Floats

    def positions(self, position: Floats) -> Floats:
        """Return positions at the places, of those of the stations ``(..., stations, 3)``."""
        r = position[..., self.nodes, :]
        result: Floats = np.einsum("nk,...nkc->...nc", self.values, r[..., self.element, :, :])
        return result

    def poses(self, poses: Poses) -> Poses:
        """Return positions and unit quaternions at the places."""
        q = aligned(poses.rotation[..., self.nodes, :])
        position = self.positions(poses.position)
        rotation = np.einsum("nk,...nkc->...nc", self.values, q[..., self.element, :, :])
        return Poses(position, rotation / np.linalg.norm(rotation, axis=-1, keepdims=True))

    def rates(self, poses: Poses, velocity: Floats, spin: Floats) -> tuple[Floats, Floats]:
        """Return velocities [m/s], global axes, and angular velocities [rad/s], body axes, of the places.

        They are the rates of what :meth:`poses` gives where the stations move so.

        Args:
            poses: of the stations; velocity: global axes; spin: angular velocity, body axes; ``(..., stations, 3)``.
        """
        v = np.einsum("nk,...nkc->...nc", self.values, velocity[..., self.nodes, :][..., self.element, :, :])
        q = aligned(poses.rotation[..., self.nodes, :])
        half = 0.5 * np.concatenate([np.zeros((*spin.shape[:-1], 1)), spin], axis=-1)
        rate = product(q, half[..., self.nodes, :])[..., self.element, :, :]
        q, rate = (np.einsum("nk,...nkc->...nc", self.values, f) for f in (q[..., self.element, :, :], rate))
        w = 2.0 * product(conjugate(q), rate)[..., 1:] / np.sum(q * q, axis=-1, keepdims=True)
        return v, w

    def through_gauss_points(self, field: Floats) -> Floats:
        """Return the value at the places of a field ``(..., elements, p, components)`` at the Gauss points."""
        result: Floats = np.einsum("ng,...ngc->...nc", self.weights, field[..., self.element, :, :])
        return result


@dataclass(frozen=True)
class Stencil:
    """All requested places, and what has to be read for them.

    Attributes:
        sites: the places; stations, points: numbers of what is read, ascending.
        groups: the places on rods, by order of the elements.
    """

    sites: tuple[ResultPlace, ...]
    stations: Integers
    points: Integers
    groups: tuple[ElementPoints, ...]

    @classmethod
    def of(cls, data: Stored, sites: ResultPlaces, chosen: Sequence[ResultPlace]) -> Stencil:
        """Find the elements of places on rods; where two elements meet it is the one that begins there."""
        points_of = (
            by_name(np.asarray(data["point_rod"].values, dtype=str)) if "point_rod" in data.coords else {}
        )
        rods = {
            rod: _Elements.of(data, sites, rod, points_of)
            for rod in dict.fromkeys(site.rod for site in chosen)
        }
        placed = [rods[site.rod].at(site.s) for site in chosen]
        stations = np.unique(np.concatenate([one.nodes for one in placed]))
        points = np.unique(np.concatenate([one.gauss for one in placed]))
        sizes = list(dict.fromkeys((one.nodes.size, one.gauss.size) for one in placed))
        groups = []
        for size in sizes:
            mine = [k for k, one in enumerate(placed) if (one.nodes.size, one.gauss.size) == size]
            elements = {int(placed[k].nodes[0]): placed[k] for k in mine}
            number = {first: k for k, first in enumerate(elements)}
            groups.append(
                ElementPoints(
                    np.array(mine),
                    np.array([number[int(placed[k].nodes[0])] for k in mine]),
                    np.searchsorted(stations, np.array([one.nodes for one in elements.values()])),
                    np.searchsorted(points, np.array([one.gauss for one in elements.values()])),
                    np.array([placed[k].values for k in mine]),
                    np.array([placed[k].weights for k in mine]),
                )
            )
        return cls(tuple(chosen), stations, points, tuple(groups))


@dataclass(frozen=True)
class _Placed:
    """One place: stations and Gauss points of its element, and the values of their polynomials there."""

    nodes: Integers
    gauss: Integers
    values: Floats
    weights: Floats


@dataclass(frozen=True)
class _Elements:
    """The elements of one rod: stations and Gauss points by increasing arc length [m]."""

    order: int
    stations: Integers
    points: Integers
    s: Floats
    point_s: Floats

    @classmethod
    def of(cls, data: Stored, sites: ResultPlaces, rod: str, points_of: Mapping[str, Integers]) -> _Elements:
        stations = sites.stations(rod)
        order = int(data["station_order"].values[stations[0]])
        s = np.asarray(data["station_s"].values, dtype=float)[stations]
        if "point_rod" not in data.coords:
            return cls(order, stations, np.zeros(0, dtype=np.int64), s, np.zeros(0))
        points = points_of[rod]
        point_s = np.asarray(data["point_s"].values, dtype=float)[points]
        ascending = np.argsort(point_s, kind="stable")
        return cls(order, stations, points[ascending], s, point_s[ascending])

    def at(self, s: float) -> _Placed:
        p = self.order
        ends = self.s[::p]
        slack = 1e-9 * (ends[-1] - ends[0])
        e = int(np.clip(np.searchsorted(ends, s + slack, side="right") - 1, 0, ends.size - 2))
        nodes, inside = slice(p * e, p * (e + 1) + 1), slice(p * e, p * (e + 1))
        return _Placed(
            self.stations[nodes],
            self.points[inside],
            lagrange_weights(self.s[nodes], s),
            lagrange_weights(self.point_s[inside], s),
        )


def aligned(q: Floats) -> Floats:
    """Return quaternions ``(..., k, 4)``, each in the hemisphere of its neighbour, so that they can be mixed."""
    flips = np.sum(q[..., 1:, :] * q[..., :-1, :], axis=-1) < 0.0
    signs = np.ones(q.shape[:-1])
    signs[..., 1:] = np.where(np.cumsum(flips, axis=-1) % 2 == 1, -1.0, 1.0)
    result: Floats = signs[..., None] * q
    return result
