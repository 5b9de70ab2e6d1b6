"""Comb resonators on folded and on straight flexures: lumped formulas, and exact frequencies of the same structures.

A folded suspension has two rigid trusses; each is carried by two flexures from the anchors and carries the shuttle by
two more: eight in all, of length L, width w in the plane, thickness t. No truss and no shuttle turns, so each flexure
is guided: 12 E I/L^3, I = t w^3/12. Four in parallel, twice in series: k = 24 E I/L^3 = 2 E t (w/L)^3.

Effective mass (Rayleigh, static shapes; shuttle at speed 1): the trusses move at 1/2, which gives Mtruss/4 for both
together. With f = 3 q^2 - 2 q^3, whose integral is 1/2 and that of f^2 13/35, the outer flexures move at f/2, the inner
at (1 + f)/2. Each set has half the mass of all flexures: (Mbeams/2)/4 (13/35 + 1 + 1 + 13/35) = (12/35) Mbeams.

The formulas are well known from Tang, Nguyen and Howe's lateral resonators (1989). A model page of Comsol's
("Residual stress in a thin-film resonator", parameters in its public file) has four straight flexures of 200 um, or
four folded ones of 170 and 146 um joined by 10 um, under a plate of 250 x 120 um, E = 155 GPa, 2330 kg/m3, t = 2.25 um,
w = 2 um. Its 14.989 and 14.966 kHz are no computed frequencies: they are 4 E t w^3/(m L^3), massless flexures, and
L^3 = L1^3 + L3^3 + L2 t^2/4 for the folded ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from .galerkin import Array

UM = 1e-6


@dataclass(frozen=True)
class Resonator:
    """Geometry and material in SI units; ``trusses`` is the mass of both together."""

    length: float = 146 * UM
    width: float = 2 * UM
    thickness: float = 2.25 * UM
    young: float = 155e9
    density: float = 2330.0
    plate: tuple[float, float] = (250 * UM, 120 * UM)
    trusses: float = 0.0

    @property
    def EI(self) -> float:
        """Bending stiffness in the plane."""
        return self.young * self.thickness * self.width**3 / 12

    @property
    def line_mass(self) -> float:
        """Mass per length of a flexure."""
        return self.density * self.width * self.thickness

    @property
    def plate_mass(self) -> float:
        """Mass of the shuttle's plate."""
        return self.density * self.plate[0] * self.plate[1] * self.thickness

    def folded_lumped(self, *, flexures: bool = True) -> float:
        """Frequency in Hz by the formula, eight flexures; without the mass of the flexures if so asked."""
        k = 24 * self.EI / self.length**3
        mass = self.plate_mass + self.trusses / 4
        if flexures:
            mass += 12 / 35 * 8 * self.length * self.line_mass
        return float(np.sqrt(k / mass) / (2 * np.pi))

    def folded_exact(self) -> float:
        """Frequency in Hz of guided Euler-Bernoulli flexures with rigid trusses: exact dynamic stiffness."""
        guess = 2 * np.pi * self.folded_lumped()

        def determinant(w: float) -> float:
            near, far = self._guided(w)
            shuttle = 4 * near - w * w * self.plate_mass
            trusses = 8 * near - w * w * self.trusses
            return (shuttle * trusses - (4 * far) ** 2) / near**2

        return float(brentq(determinant, 0.9 * guess, 1.05 * guess, rtol=1e-14)) / (2 * np.pi)

    def straight_lumped(self, *, flexures: bool = True) -> float:
        """Frequency in Hz of the plate on four straight guided flexures: k = 48 EI/L^3, 13/35 of their mass."""
        k = 48 * self.EI / self.length**3
        mass = self.plate_mass + (13 / 35 * 4 * self.length * self.line_mass if flexures else 0.0)
        return float(np.sqrt(k / mass) / (2 * np.pi))

    def straight_exact(self) -> float:
        """The same by the exact dynamic stiffness."""
        guess = 2 * np.pi * self.straight_lumped()
        root = brentq(
            lambda w: 4 * self._guided(w)[0] - w * w * self.plate_mass, 0.9 * guess, 1.05 * guess, rtol=1e-14
        )
        return float(root) / (2 * np.pi)

    def hairpins(self, first: float, link: float, last: float, *, elements: int = 10) -> float:
        """Frequency in Hz of the plate on four separate hairpins: planar frame elements, axial stiffness included.

        Each goes `first` away from the plate, `link` across, and `last` back to its anchor; corners are rigid and
        without extra mass, the plate does not turn.
        """
        corners = [(0.0, 0.0), (0.0, first), (link, first), (link, first - last)]
        # lengths in units of `first`, forces and masses in those of EI and of the flexure: well conditioned
        corners = [(x / first, y / first) for x, y in corners]
        stretch = self.young * self.width * self.thickness * first**2 / self.EI
        K, M, points = _frame_matrices(corners, stretch, 1.0, 1.0, elements)
        M[0, 0] += self.plate_mass / (4 * self.line_mass * first)
        # the plate neither turns nor leaves its line: the mirror images of the hairpin hold it
        free = np.setdiff1d(np.arange(3 * points), [1, 2, *range(3 * points - 3, 3 * points)])
        # the largest eigenvalue of the inverse problem does not suffer from the stiff short elements
        last_one = [free.size - 1, free.size - 1]
        K, M = K[np.ix_(free, free)], M[np.ix_(free, free)]
        inverse = eigh(M, K, eigvals_only=True, subset_by_index=last_one)[0]
        return float(np.sqrt(self.EI / (inverse * self.line_mass * first**4)) / (2 * np.pi))

    def _guided(self, w: float) -> tuple[float, float]:
        """Forces at the near and the far end of a flexure with guided ends, for a unit motion of the near end."""
        k = (self.line_mass * w * w / self.EI) ** 0.25
        z = k * self.length
        c, s, C, S = np.cos(z), np.sin(z), np.cosh(z), np.sinh(z)
        d = 1 - c * C
        return self.EI * k**3 * (c * S + s * C) / d, -self.EI * k**3 * (s + S) / d


def _frame_matrices(
    corners: list[tuple[float, float]], EA: float, EI: float, mass: float, elements: int
) -> tuple[Array, Array, int]:
    """Stiffness and consistent mass of a polyline of frame elements; unknowns x, y, angle at each point."""
    points = [np.array(corners[0])]
    for a, b in pairwise(corners):
        points += [np.array(a) + (np.array(b) - a) * i / elements for i in range(1, elements + 1)]
    n = len(points)
    K, M = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 3 * n))
    for i, (a, b) in enumerate(pairwise(points)):
        h = float(np.linalg.norm(b - a))
        c, s = (b - a) / h
        k, m = np.zeros((6, 6)), np.zeros((6, 6))
        k[np.ix_([0, 3], [0, 3])] = EA / h * np.array([[1, -1], [-1, 1]])
        m[np.ix_([0, 3], [0, 3])] = mass * h / 6 * np.array([[2, 1], [1, 2]])
        across = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
        k[across] = (
            EI
            / h**3
            * np.array(
                [
                    [12, 6 * h, -12, 6 * h],
                    [6 * h, 4 * h**2, -6 * h, 2 * h**2],
                    [-12, -6 * h, 12, -6 * h],
                    [6 * h, 2 * h**2, -6 * h, 4 * h**2],
                ]
            )
        )
        m[across] = (
            mass
            * h
            / 420
            * np.array(
                [
                    [156, 22 * h, 54, -13 * h],
                    [22 * h, 4 * h**2, 13 * h, -3 * h**2],
                    [54, 13 * h, 156, -22 * h],
                    [-13 * h, -3 * h**2, -22 * h, 4 * h**2],
                ]
            )
        )
        turn = np.zeros((6, 6))
        turn[:3, :3] = turn[3:, 3:] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        span = slice(3 * i, 3 * i + 6)
        K[span, span] += turn.T @ k @ turn
        M[span, span] += turn.T @ m @ turn
    return K, M, n
