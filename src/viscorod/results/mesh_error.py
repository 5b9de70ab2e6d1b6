"""Error of positions by the mesh, estimated from the strains at the Gauss points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from viscorod.results.array_pieces import blocks
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["mesh_errors"]


def mesh_errors(result: Result) -> dict[str, float]:
    """Estimate the error of positions that comes from the elements, as a part of the length of each rod.

    The ``p`` Gauss points of an element resolve its strains up to the Legendre polynomial of degree ``p - 1``. What is
    missing is about as large as the last term, and since positions of nodes converge with twice the order of the
    element, its square counts: ``(h |a_(p-1)|/(2 p))^2``, of displacements and rotations over the length ``h``, over
    the turning of the whole rod if that is below 1. Besides, an element that turns by ``phi`` has the error of Gauss
    collocation, ``p!^2/((2p)! (2p + 1)!) phi^(2p + 1)``, over the turning of the rod if that is above 1. Neither is a
    bound: it is a number to distinguish a fine mesh from a coarse one.

    Returns:
        Rod -> estimated error of positions over its length, the largest over all states.
    """
    data = result.data
    if not {"strain", "point_rod", "point_weight", "station_order"} <= set(data.variables):
        return {}
    names, weight = data["point_rod"].values, np.asarray(data["point_weight"].values, dtype=float)
    order = dict(zip(data["station_rod"].values.tolist(), data["station_order"].values.tolist(), strict=True))
    rods = {str(rod): np.flatnonzero(names == rod) for rod in dict.fromkeys(names.tolist()) if rod in order}
    found = dict.fromkeys(rods, 0.0)
    for block in blocks(result, "strain"):
        for rod, points in rods.items():
            error = _largest(block[:, points], weight[points], int(order[rod]))
            found[rod] = max(found[rod], error)
    return found


def _largest(strain: Floats, weight: Floats, p: int) -> float:
    """Return the largest estimate over the states ``(states, points, 6)`` of one rod with elements of order ``p``."""
    strain = strain * np.repeat([1.0 / weight.sum(), 1.0], 3)  # displacements over the length, rotations
    strain = strain.reshape(len(strain), -1, p, 6)
    weight = weight.reshape(-1, p)
    length = weight.sum(axis=1)
    points = np.polynomial.legendre.leggauss(p)[0]
    highest = np.polynomial.legendre.legvander(points, p - 1)[:, -1] * (2 * p - 1)
    # of each element: what the last term and the whole strain amount to over its length
    last = np.linalg.norm(np.einsum("eg,tegc->tec", weight * highest, strain), axis=-1) / (2 * p)
    turned = np.linalg.norm(np.einsum("eg,tegc->tec", weight, strain), axis=-1)
    whole = np.sqrt(length * np.einsum("eg,tegc->te", weight, strain**2)).sum(axis=1)
    collocation = math.factorial(p) ** 2 / (math.factorial(2 * p) * math.factorial(2 * p + 1))
    truncated = last.max(axis=1) ** 2 / np.maximum(np.minimum(whole, 1.0), np.finfo(float).tiny)
    curved = (collocation * turned ** (2 * p + 1)).sum(axis=1) / np.maximum(whole, 1.0)
    return float((truncated + curved).max())
