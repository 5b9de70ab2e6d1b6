"""Meshes of sections that stay while numbers of a model vary a little: their triangles are moved, not made anew.

A mesher takes other triangles for an outline that differs by a millionth, and torsion and shear then differ by what
meshes leave, 0.2 %: derivatives of two such meshes would be noise. So corners of the outlines move, nodes along their
edges with these, and nodes inside by a harmonic map of the triangles, which keeps what is linear.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from viscorod.model.fields.definition import RefusedError
from viscorod.model.sections.polygons import Polygon
from viscorod.model.sections.section_mesh import SectionMesh, joined, triangulate
from viscorod.typing import Floats, Integers

__all__ = ["KeptMesh", "kept_mesh", "kept_meshes", "mesh_of"]

NEAR = 0.05
"""Part of the size of a section by which corners may have moved, at most."""
ALONG = 1e-6
"""The same by which a node is beside an edge, at most."""


class KeptMesh(NamedTuple):
    """The mesh of a section: what it was made of.

    Attributes:
        polygons: of the regions, m; side: of its largest triangle, m.
    """

    polygons: tuple[Polygon, ...]
    side: float

    def to_list(self) -> list[Any]:
        """Return plain data."""
        return [self.polygons, self.side]

    @classmethod
    def of_list(cls, plain: Sequence[Any]) -> KeptMesh:
        """Return it from plain data."""
        polygons, side = plain
        return cls(tuple((_ring(outline), tuple(map(_ring, holes))) for outline, holes in polygons), side)


_KEPT: ContextVar[tuple[KeptMesh, ...]] = ContextVar("kept meshes", default=())


@contextmanager
def kept_meshes(kept: Sequence[KeptMesh]) -> Iterator[None]:
    """Let sections take the mesh of the one of these that they differ from by their numbers alone."""
    before = _KEPT.set(tuple(kept))
    try:
        yield
    finally:
        _KEPT.reset(before)


def kept_mesh(polygons: tuple[Polygon, ...]) -> KeptMesh | None:
    """Return the mesh that a section is to take; None where it makes one of its own.

    Raises:
        RefusedError: its regions meet otherwise than those of the mesh that is next to it.
    """
    if not _KEPT.get():
        return None
    here = _corners(polygons)
    apart = [_apart(here, _corners(kept.polygons)) for kept in _KEPT.get()]
    nearest = int(np.argmin(apart))
    kept = _KEPT.get()[nearest]
    if apart[nearest] > NEAR:
        return None
    if kept.polygons != polygons:
        mine, its = joined(polygons), joined(kept.polygons)
        if (mine.rings, mine.edges) != (its.rings, its.edges):
            raise RefusedError(
                "corners of its regions that lie on each other would part, or meet, and the mesh would be another one",
                "name a number that keeps together what meets",
                found="",
            )
    return kept


def mesh_of(polygons: tuple[Polygon, ...], side: float, kept: KeptMesh | None) -> SectionMesh:
    """Return the mesh of regions: with triangles of this side, m, or one that is kept."""
    if kept is None:
        return triangulate(polygons, side)
    mesh = _made(kept)
    return mesh if kept.polygons == polygons else _moved(mesh, kept.polygons, polygons)


@lru_cache(maxsize=8)
def _made(kept: KeptMesh) -> SectionMesh:
    return triangulate(kept.polygons, kept.side)


def _moved(mesh: SectionMesh, before: tuple[Polygon, ...], after: tuple[Polygon, ...]) -> SectionMesh:
    """Return a mesh with its nodes moved as the corners of its regions move."""
    from scipy import sparse
    from scipy.sparse.linalg import splu

    old, new = joined(before), joined(after)
    start, end = (one.corners * one.size + one.middle for one in (old, new))
    vertices = np.unique(mesh.triangles[:, :3])
    number = np.full(len(mesh.points), -1)
    number[vertices] = np.arange(len(vertices))
    triangles = number[mesh.triangles[:, :3]]
    points = mesh.points[vertices]
    shift, known = _along_edges(points, start, end - start, sorted(old.edges), old.size)
    matrix = _laplacian(points, triangles)
    free, held = np.flatnonzero(~known), np.flatnonzero(known)
    if len(free):
        rows = matrix[free]
        shift[free] = splu(sparse.csc_array(rows[:, free])).solve(-(rows[:, held] @ shift[held]))
    moved = mesh.points.copy()
    moved[vertices] += shift
    for middle, (one, other) in zip((3, 4, 5), ((0, 1), (1, 2), (2, 0)), strict=True):
        ends = moved[mesh.triangles[:, one]], moved[mesh.triangles[:, other]]
        moved[mesh.triangles[:, middle]] = 0.5 * (ends[0] + ends[1])
    return SectionMesh(moved, mesh.triangles, mesh.region)


def _laplacian(points: Floats, triangles: Integers) -> Any:
    """Return the matrix of the Laplacian on linear triangles, sparse ``(n, n)``."""
    from scipy import sparse

    corners = points[triangles]
    edges = np.roll(corners, 1, axis=1) - np.roll(corners, -1, axis=1)  # opposite to each corner
    first, last = edges[:, 0], edges[:, 1]
    area = 0.5 * np.abs(first[:, 0] * last[:, 1] - first[:, 1] * last[:, 0])
    values = np.einsum("mid,mjd->mij", edges, edges) / (4.0 * area[:, None, None])
    rows, columns = np.repeat(triangles, 3, axis=1), np.tile(triangles, 3)
    found = sparse.coo_array((values.ravel(), (rows.ravel(), columns.ravel())), shape=(len(points),) * 2)
    return sparse.csr_array(found)


def _along_edges(
    points: Floats, corners: Floats, shifts: Floats, edges: Sequence[tuple[int, int]], size: float
) -> tuple[Floats, Integers]:
    """Return the shifts of the points that lie on edges ``(n, 2)``, and which these are ``(n,)``."""
    found, known = np.zeros_like(points), np.zeros(len(points), dtype=bool)
    for i, j in edges:
        edge = corners[j] - corners[i]
        length = float(np.hypot(*edge))
        offset = points - corners[i]
        along = offset @ edge / length**2
        beside = np.abs(offset @ np.array([-edge[1], edge[0]])) / length
        on = (beside < ALONG * size) & (along > -ALONG) & (along < 1.0 + ALONG)
        part = np.clip(along[on], 0.0, 1.0)[:, None]
        found[on] = (1.0 - part) * shifts[i] + part * shifts[j]
        known |= on
    return found, known


def _corners(polygons: tuple[Polygon, ...]) -> tuple[Floats, ...]:
    """Return the corners of every ring."""
    return tuple(np.array(ring) for outline, holes in polygons for ring in (outline, *holes))


def _apart(one: tuple[Floats, ...], other: tuple[Floats, ...]) -> float:
    """Return how far corners are apart at most, over the size of the section; infinite if they are not as many."""
    if [len(ring) for ring in one] != [len(ring) for ring in other]:
        return np.inf
    size = float(max(np.ptp(ring, axis=0).max() for ring in other))
    return max(float(np.abs(a - b).max()) for a, b in zip(one, other, strict=True)) / size


def _ring(corners: Sequence[Sequence[float]]) -> tuple[tuple[float, float], ...]:
    return tuple((float(x), float(y)) for x, y in corners)
