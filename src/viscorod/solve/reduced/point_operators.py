"""Velocities and strain rates at the Gauss points as sparse operators on the twists of all nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.solve.formulations.system import System
from viscorod.typing import Floats

__all__ = ["PointOperators", "curved", "momentum_flux", "products"]


def curved(x: Floats, strain: Floats) -> Floats:
    """Return ``L1(x)^T eps = (kappa x v + gamma x w, kappa x w)`` of AWP (7), ``(..., 6)``."""
    v, w, gamma, kappa = x[..., :3], x[..., 3:], strain[..., :3], strain[..., 3:]
    return np.concatenate([np.cross(kappa, v) + np.cross(gamma, w), np.cross(kappa, w)], axis=-1)


def momentum_flux(x: Floats, momentum: Floats) -> Floats:
    """Return ``L1(x) M x = (w x p, v x p + w x h)`` of AWP (7), momenta ``(p, h)`` given ``(..., 6)``."""
    v, w, p, h = x[..., :3], x[..., 3:], momentum[..., :3], momentum[..., 3:]
    return np.concatenate([np.cross(w, p), np.cross(v, p) + np.cross(w, h)], axis=-1)


def products(a: Floats, b: Floats) -> Floats:
    """Return the sums of products of fields ``(k, m, 6)`` and ``(l, m, 6)``, ``(k, l)``."""
    return np.asarray(a.reshape(len(a), a.shape[1] * 6) @ b.reshape(len(b), b.shape[1] * 6).T)


@dataclass(frozen=True)
class PointOperators:
    """What the intrinsic element makes of nodal body twists, at Gauss points in the order of results.

    Attributes:
        twist: body twists at the points ``(6 m, 6 n)``; rate: ``b = x1' - E^T x1``, likewise.
        stiffness, damping: section matrices ``(m, 6, 6)`` times the quadrature length.
    """

    twist: sparse.csr_array
    rate: sparse.csr_array
    stiffness: Floats
    damping: Floats

    @classmethod
    def of(cls, system: System) -> PointOperators:
        """Make the operators of the unstressed shape of a system."""
        elements, positions = system.elements(), system.gauss_positions()
        width = elements.reference.shape[1]
        number = np.full(elements.reference[..., 0].size, -1)
        number[system.gauss_indices()] = np.arange(len(positions.s))
        maps = np.array(
            [_link(k, elements.link_positions, elements.link_quaternions) for k in _links(elements.links)]
        )
        rows, columns, twist, rate = [], [], [], []
        for e, order in enumerate(elements.order):
            points = number[e * width + np.arange(order)]
            nodes, links = elements.nodes[e, : order + 1], elements.links[e, : order + 1]
            shapes = elements.shapes[order, :order, : order + 1]
            slopes = elements.slopes[order, :order, : order + 1] / elements.half_lengths[e]
            own = _curvature(elements.reference[e, :order])
            at = np.tile(np.eye(6), (order + 1, 1, 1))
            at[links >= 0] = maps[links[links >= 0]] if len(maps) else at[links >= 0]
            x = shapes[:, :, None, None] * at
            b = slopes[:, :, None, None] * at + np.einsum("gij,gmjk->gmik", own, x)
            row = 6 * points[:, None, None, None] + np.arange(6)[:, None]
            column = 6 * nodes[None, :, None, None] + np.arange(6)
            rows.append(np.broadcast_to(row, x.shape).ravel())
            columns.append(np.broadcast_to(column, x.shape).ravel())
            twist.append(x.ravel())
            rate.append(b.ravel())
        size = 6 * len(positions.s), 6 * system.problem.size
        where = np.concatenate(rows), np.concatenate(columns)
        length = positions.length[:, None, None]
        return cls(
            sparse.csr_array((np.concatenate(twist), where), shape=size),
            sparse.csr_array((np.concatenate(rate), where), shape=size),
            length * positions.stiffness,
            length * positions.damping,
        )

    @property
    def points(self) -> int:
        """Number of Gauss points."""
        return len(self.stiffness)

    def twists(self, shapes: Floats) -> Floats:
        """Return the body twists ``(k, m, 6)`` of nodal ones ``(6 n, k)``."""
        return np.asarray(self.twist @ shapes).T.reshape(shapes.shape[1], self.points, 6)

    def rates(self, shapes: Floats) -> Floats:
        """Return the strain rates ``(k, m, 6)`` of the unstrained rod under nodal twists ``(6 n, k)``."""
        return np.asarray(self.rate @ shapes).T.reshape(shapes.shape[1], self.points, 6)

    def stresses(self, strains: Floats) -> Floats:
        """Return section forces times quadrature lengths ``(k, m, 6)`` of elastic strains, likewise."""
        return np.asarray(np.einsum("gij,kgj->kgi", self.stiffness, strains))

    def forces(self, stresses: Floats) -> Floats:
        """Return the nodal forces ``(6 n, k)`` of section forces times quadrature lengths ``(k, m, 6)``."""
        return np.asarray(self.rate.T @ stresses.reshape(len(stresses), 6 * self.points).T)


def _links(links: np.ndarray) -> range:
    return range(int(links.max(initial=-1)) + 1)


def _link(k: int, positions: Floats, quaternions: Floats) -> Floats:
    X = np.zeros((6, 6))
    link_map(positions[k], quaternions[k], X)
    return X


def _curvature(reference: Floats) -> Floats:
    """Return ``-E^T`` of AWP (6): ``[[U0~, V0~], [0, U0~]]`` at points ``(g, 6, 6)``."""
    out = np.zeros((len(reference), 6, 6))
    V, U = (_crossing(reference[:, 3 * k : 3 * k + 3]) for k in (0, 1))
    out[:, :3, :3], out[:, :3, 3:], out[:, 3:, 3:] = U, V, U
    return out


def _crossing(a: Floats) -> Floats:
    """Return the matrices of ``a x`` ``(g, 3, 3)``."""
    return -np.cross(np.eye(3), a[:, None, :]).transpose(0, 2, 1)
