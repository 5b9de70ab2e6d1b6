"""Polynomials of elements read in their halves: matrices over all rods of a mesh, made once for all meshes alike.

They are full where they are small: a call of SciPy takes longer than such a product.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeAlias

import numpy as np
from scipy import sparse

from viscorod.mechanics.elements.basis import gauss, lagrange, lobatto
from viscorod.typing import Floats, Integers

__all__ = ["HalfElements", "Halves", "half_elements", "halves", "read"]

FULL = 10_000
"""Entries up to which a matrix is full."""

Reading: TypeAlias = Floats | sparse.csr_array
"""What makes a field at other places from one at some."""


@dataclass(frozen=True)
class Halves:
    """Polynomials of an element of one order, read in its halves.

    Attributes:
        nodes: from its nodes to those of both halves ``(2 p + 1, p + 1)``.
        points: from its Gauss points to those of both halves ``(2 p, p)``.
        places: where section forces are compared, in ``[-1, 1]`` ``(k,)``: ends, middle and Gauss points.
        whole: from its Gauss points to these places ``(k, p)``; divided: from those of the halves ``(k, 2 p)``.
        inside: from the nodes of both halves to what the inner ones differ from a line through both ends
            ``(2 p - 1, 2 p + 1)``.
    """

    nodes: Floats
    points: Floats
    places: Floats
    whole: Floats
    divided: Floats
    inside: Floats


@lru_cache
def halves(order: int) -> Halves:
    """Return the interpolation from an element to its halves."""
    inner = 0.5 * (lobatto(order)[0] + 1.0)
    nodes = lagrange(order, np.concatenate([inner - 1.0, inner[1:]]))[0]
    x = gauss(order)[0]
    points = _through(x, np.concatenate([0.5 * (x - 1.0), 0.5 * (x + 1.0)]))
    places = np.concatenate([[-1.0], x, [0.0, 1.0]])
    first = places <= 0.0
    divided = np.zeros((len(places), 2 * order))
    divided[first, :order] = _through(x, 2.0 * places[first] + 1.0)
    divided[~first, order:] = _through(x, 2.0 * places[~first] - 1.0)
    part = np.arange(1, 2 * order) / (2 * order)
    inside = np.eye(2 * order + 1)[1:-1]
    inside[:, 0], inside[:, -1] = part - 1.0, -part
    return Halves(nodes, points, places, _through(x, places), divided, inside)


def _through(points: Floats, at: Floats) -> Floats:
    """Return the values ``(k, p)`` at places of the Lagrange polynomials through ``points (p,)``."""
    values = np.ones((len(at), len(points)))
    for j, point in enumerate(points):
        for other in np.delete(points, j):
            values[:, j] *= (at - other) / (point - other)
    return values


@dataclass(frozen=True)
class HalfElements:
    """The same for all elements of a mesh, rod by rod, as matrices.

    Attributes:
        stations: from the stations of the rods to those of the finer mesh; points: likewise of Gauss points.
        whole: from Gauss points to places where section forces are compared; divided: from those of the finer mesh.
        places: the first of these places of every element ``(e,)``.
        inside: from stations of the finer mesh to what inner ones of the coarse elements differ from a line through
            the ends; inner: the first of these of every element ``(e,)``.
        ends: stations of the finer mesh at both ends of every coarse element ``(e, 2)``.
        rod_stations: the first station of every rod ``(rods,)``; finer_stations: on the finer mesh.
        elements: the first element of every rod, and how many there are in all ``(rods + 1,)``.
    """

    stations: Reading
    points: Reading
    whole: Reading
    divided: Reading
    places: Integers
    inside: Reading
    inner: Integers
    ends: Integers
    rod_stations: Integers
    finer_stations: Integers
    elements: Integers


@lru_cache(maxsize=16)
def half_elements(sizes: tuple[tuple[int, int], ...]) -> HalfElements:
    """Return the matrices of a mesh by ``sizes``: order and number of the elements of every rod."""
    order = np.array([p for p, n in sizes for _ in range(n)])
    elements = np.cumsum([0, *(n for _, n in sizes)])
    stations = np.cumsum([0, *(p * n + 1 for p, n in sizes)])
    finer = np.cumsum([0, *(2 * p * n + 1 for p, n in sizes)])
    rod = np.repeat(np.arange(len(sizes)), [n for _, n in sizes])
    number = np.arange(len(order)) - elements[rod]
    begins, finer_begins = stations[rod] + number * order, finer[rod] + 2 * number * order
    points = np.cumsum([0, *order])
    known = [halves(p) for p in order.tolist()]
    places = np.cumsum([0, *(len(one.places) for one in known)])
    inner = np.cumsum([0, *(2 * order - 1)])
    of_stations = _placed(
        # the last station of an element is the first of the next one, or that of the rod
        [(finer_begins, begins, [one.nodes[:-1] for one in known]), (finer[1:] - 1, stations[1:] - 1, ONE)],
        (int(finer[-1]), int(stations[-1])),
    )
    count = int(points[-1])
    return HalfElements(
        stations=of_stations,
        points=_placed([(2 * points, points, [one.points for one in known])], (2 * count, count)),
        whole=_placed([(places, points, [one.whole for one in known])], (int(places[-1]), count)),
        divided=_placed([(places, 2 * points, [one.divided for one in known])], (int(places[-1]), 2 * count)),
        places=places[:-1],
        inside=_placed(
            [(inner, finer_begins, [one.inside for one in known])], (int(inner[-1]), int(finer[-1]))
        ),
        inner=inner[:-1],
        ends=np.column_stack([finer_begins, finer_begins + 2 * order]),
        rod_stations=stations[:-1],
        finer_stations=finer[:-1],
        elements=elements,
    )


ONE: Sequence[Floats] = ()
"""Blocks that are all the number one."""


def _placed(parts: Sequence[tuple[Integers, Integers, Sequence[Floats]]], shape: tuple[int, int]) -> Reading:
    """Return a matrix with dense blocks at their first rows and columns; rows are complete in one block."""
    rows, columns, values = [], [], []
    for first, across, given in parts:
        blocks = given or [np.ones((1, 1))] * len(first)
        for row, column, block in zip(first, across, blocks, strict=False):
            at = np.indices(block.shape)
            rows.append((row + at[0]).ravel())
            columns.append((column + at[1]).ravel())
            values.append(block.ravel())
    where = np.concatenate(rows), np.concatenate(columns)
    found = sparse.csr_array((np.concatenate(values), where), shape=shape)
    return found.toarray() if shape[0] * shape[1] <= FULL else found


def read(matrix: Reading, field: Floats) -> Floats:
    """Return what a matrix makes of fields ``(..., n, c)`` along their places, ``(..., k, c)``."""
    if isinstance(matrix, np.ndarray):
        return np.asarray(matrix @ field)
    *several, n, c = field.shape
    columns = np.moveaxis(field.reshape(-1, n, c), 1, 0).reshape(n, -1)
    found = np.asarray(matrix @ columns).reshape(matrix.shape[0], -1, c)
    return np.ascontiguousarray(np.moveaxis(found, 0, 1)).reshape(*several, -1, c)
