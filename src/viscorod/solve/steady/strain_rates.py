"""Strain rates and forces of the intrinsic element as matrices, equal to those of its kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.mechanics.elements.section_laws import (
    BY_RATE,
    BY_STRAIN,
    ENERGY,
    FORCE,
)
from viscorod.mechanics.nodes.attached_poses import link_map
from viscorod.mechanics.rotations.adjoint_maps import skew
from viscorod.solve.problem.law_responses import law_responses
from viscorod.typing import Floats


class SectionResponse(NamedTuple):
    """Section forces ``(m, 6)``, stored energies per length ``(m,)`` [J/m], derivatives C and D ``(m, 6, 6)``."""

    force: Floats
    energy: Floats
    C: Floats
    D: Floats


class StrainRates:
    """The strain rates of all elements as matrices on the nodal twists, ``eps_t = (B0 + B1(eps)) x1``.

    Rows belong to the Gauss points in use, six each.

    Attributes:
        unstrained: ``B0 (6 m, 6 n)``; shapes: interpolation ``(6 m, 6 n)`` of the twists; weights ``(m,)`` [m];
        C, D: section matrices ``(m, 6, 6)``; section: its number ``(m,)``; laws: of the sections;
        used: mask ``(e, points)`` of the points in use.
    """

    def __init__(self, elements: Elements, n: int) -> None:
        e = elements
        self.used = np.arange(e.reference.shape[1])[None, :] < e.order[:, None]
        points = int(self.used.sum())
        self.shapes, slopes = np.zeros((2, points, 6, 6 * n))
        self.weights = np.concatenate(
            [e.weights[p, :p] * half for p, half in zip(e.order, e.half_lengths, strict=True)]
        )
        self.section, self.laws = e.section[self.used], e.laws
        self.C, self.D = e.stiffness[self.section], e.damping[self.section]
        self.reference = e.reference[self.used]
        first = 0
        X = np.zeros((6, 6))
        for a, p in enumerate(e.order):
            rows = slice(first, first + p)
            for k in range(p + 1):
                map_ = np.eye(6)
                if e.links[a, k] >= 0:
                    link_map(e.link_positions[e.links[a, k]], e.link_quaternions[e.links[a, k]], X)
                    map_ = X.copy()
                columns = slice(6 * e.nodes[a, k], 6 * e.nodes[a, k] + 6)
                self.shapes[rows, :, columns] += e.shapes[p, :p, k, None, None] * map_
                slopes[rows, :, columns] += e.slopes[p, :p, k, None, None] / e.half_lengths[a] * map_
            first += p
        self.unstrained = slopes + strain_map(self.reference) @ self.shapes

    def response(self, strain: Floats) -> SectionResponse:
        """Return how the sections respond to strains ``(m, 6)`` that do not change."""
        force = np.einsum("gij,gj->gi", self.C, strain)
        energy = 0.5 * np.einsum("gi,gi->g", force, strain)
        if not self.laws.present:
            return SectionResponse(force, energy, self.C, self.D)
        values = law_responses(self.laws, self.section, strain, np.zeros_like(strain))
        return SectionResponse(
            force + values[:, FORCE:BY_STRAIN],
            energy + values[:, ENERGY],
            self.C + values[:, BY_STRAIN:BY_RATE].reshape(-1, 6, 6),
            self.D + values[:, BY_RATE:ENERGY].reshape(-1, 6, 6),
        )

    def at(self, strain: Floats) -> Floats:
        """Return ``B(eps) (m, 6, 6 n)`` at strains ``(m, 6)``."""
        return self.unstrained + strain_map(strain) @ self.shapes


def strain_map(strain: Floats) -> Floats:
    """Return ``[[U~, V~], [0, U~]]`` of strains ``(m, 6)``: how they turn twists into strain rates."""
    out = np.zeros((len(strain), 6, 6))
    out[:, :3, :3] = out[:, 3:, 3:] = skew(strain[:, 3:])
    out[:, :3, 3:] = skew(strain[:, :3])
    return out


def force_map(stress: Floats) -> Floats:
    """Return ``L2(S) = [[0, N~], [N~, M~]]`` of section forces ``(m, 6)``: how they work through strains."""
    out = np.zeros((len(stress), 6, 6))
    out[:, :3, 3:] = out[:, 3:, :3] = skew(stress[:, :3])
    out[:, 3:, 3:] = skew(stress[:, 3:])
    return out
