"""Curvature and twist of the reference shape, from the orientations that a result keeps."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.mechanics.rotations.quaternion import conjugate, product
from viscorod.results.element_points import aligned
from viscorod.results.result_places import by_name
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["reference_curvature", "reference_curvatures"]


def reference_curvature(nodes: Floats, rotation: Floats, s: Floats) -> Floats:
    """Return bend 1, bend 2 and twist of the reference shape ``(..., n, 3)`` [1/m], of the element's interpolation.

    U0 = 2 vec(conj(q) q')/|q|^2 with q = sum N_k q_k.

    Args:
        nodes: arc lengths of the nodes of elements ``(..., p + 1)`` [m]; rotation: quaternions ``(..., p + 1, 4)``.
        s: arc lengths in each ``(..., n)`` [m].
    """
    q = aligned(rotation)
    middle, span = nodes.mean(axis=-1, keepdims=True), nodes[..., -1:] - nodes[..., :1]
    order = np.arange(nodes.shape[-1])
    # the polynomial through the nodes and its slope, about the middle of the element for round-off
    coefficients = np.linalg.solve(((nodes - middle) / span)[..., None] ** order, q)
    x = ((s - middle) / span)[..., None]
    value = x**order @ coefficients
    slope = (order[1:] * x ** order[:-1]) @ coefficients[..., 1:, :] / span[..., None]
    turned = 2.0 * product(conjugate(value), slope)[..., 1:]
    return np.asarray(turned / np.sum(value * value, axis=-1, keepdims=True))


def reference_curvatures(result: Result) -> Floats:
    """Return bend 1, bend 2 and twist of the reference shape at all Gauss points ``(m, 3)`` [1/m]."""
    data = result.stored
    point_s = np.asarray(data["point_s"].values, dtype=float)
    station_s = np.asarray(data["station_s"].values, dtype=float)
    rotation = np.asarray(data["reference_rotation"].values, dtype=float)
    found = np.zeros((len(point_s), 3))
    for rod, points in by_name(np.asarray(data["point_rod"].values, dtype=str)).items():
        stations = result.sites.stations(rod)
        p = int(data["station_order"].values[stations[0]])
        elements = np.arange((len(stations) - 1) // p)[:, None]
        nodes = stations[p * elements + np.arange(p + 1)]
        inside = points[p * elements + np.arange(p)]
        found[inside] = reference_curvature(station_s[nodes], rotation[nodes], point_s[inside])
    return found
