"""Saint-Venant's shear stresses in circles, tubes, ellipses and rectangles, in closed form.

Under a unit shear force along d1 the shear stress t = (s31, s32) of a prismatic bar obeys

    div t = -x/I2,    d1 t2 - d2 t1 = -nu/(1 + nu) y/I2,    t.n = 0 on the outline

with I2 = <x^2>, under a unit torque div t = 0 and d1 t2 - d2 t1 = 2/J. Sources: A. E. H. Love, A treatise on the
mathematical theory of elasticity, chapter XV; S. Timoshenko and J. N. Goodier, Theory of elasticity, chapters 10, 11.
Their series for the rectangle, whose terms fall with 1/n^2 at its sides, are summed here by the dilogarithm.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from viscorod.model.fields.definition import RefusedError, show
from viscorod.model.sections.stress_field import SectionPatch, SectionSamples
from viscorod.typing import Floats, Integers

__all__ = [
    "Flow",
    "ShapeGrid",
    "box_grid",
    "elliptic_flow",
    "rectangular_flow",
    "refuse_outside",
    "ring_grid",
    "tube_flow",
]

Flow: TypeAlias = Callable[[Floats], Floats]
"""From points (n, 2) to the shear stresses of unit forces (n, 2, 3)."""

SLACK = 1e-9
"""Part of the size of a section by which a point may lie outside."""
IMAGES = 14
"""Reflections of the rectangle at most: each is smaller by e^-pi or more."""
NOTHING = 37.0
"""Exponent of what is lost in round-off."""
SMALL, TERMS = 0.1, 14
"""Size up to which so many terms of the dilogarithm's series are enough."""


class ShapeGrid:
    """Quadrature and triangles of a shape that a grid covers.

    Args:
        points: of the quadrature ``(q, 2)`` [m]; weight: their areas ``(q,)`` [m^2].
        corners: of a grid ``(rows, columns, 2)`` [m] over all of it.
        inside: how far out a point is, 1 on the outline; where a hole is, below 0 in it ``(n, 2) -> (n,)``.
    """

    def __init__(
        self, points: Floats, weight: Floats, corners: Floats, inside: Callable[[Floats], np.ndarray]
    ) -> None:
        self.points, self.weight, self.inside = points, weight, inside
        rows, columns, _ = corners.shape
        self.corners = corners.reshape(-1, 2)
        first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
        near, far = first + columns, first + columns + 1
        self.triangles: Integers = np.concatenate(
            [np.stack([first, first + 1, far], axis=-1), np.stack([first, far, near], axis=-1)]
        )

    def samples(self, points: Floats, flow: Flow) -> SectionSamples:
        """Return samples at points that lie inside.

        Raises:
            RefusedError: one does not.
        """
        refuse_outside(points, self.inside(points))
        return SectionSamples(points, np.zeros(len(points), dtype=np.int64), flow(points))

    def patch(self, flow: Flow) -> SectionPatch:
        """Return the triangles with their samples."""
        region = np.zeros(len(self.corners), dtype=np.int64)
        return SectionPatch(SectionSamples(self.corners, region, flow(self.corners)), self.triangles)


def refuse_outside(points: Floats, inside: np.ndarray) -> None:
    """Refuse points ``(n, 2)`` that are not ``inside (n,)`` of a section.

    Raises:
        RefusedError: the first of them.
    """
    if not inside.all():
        number = int(np.argmin(inside))
        raise RefusedError(
            "the point lies outside the section",
            "give points [along d1, along d2] of the section about the centre line, in m",
            found=show([float(value) for value in points[number]]),
            at=("points", number),
        )


def ring_grid(halves: tuple[float, float], hole: float) -> ShapeGrid:
    """Return the grid of an ellipse.

    Args:
        halves: half width and half height [m]; hole: of a tube, the inner radius over the outer one, else 0.
    """
    scale = np.array(halves)
    u, w = np.polynomial.legendre.leggauss(20)
    if hole > 0.0:  # powers of the radius become exponentials
        span = -math.log(hole)
        r = hole * np.exp(0.5 * span * (1.0 + u))
        w = 0.5 * span * w * r**2
    else:
        r = 0.5 * (1.0 + u)
        w = 0.5 * w * r
    turn = 2.0 * math.pi * (np.arange(64) + 0.5) / 64
    around = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    points = (r[:, None, None] * around * scale).reshape(-1, 2)
    weight = np.repeat(w, 64) * (2.0 * math.pi / 64) * scale[0] * scale[1]
    angle = np.linspace(0.0, 2.0 * math.pi, 97)
    rings = np.linspace(hole, 1.0, 17)[:, None, None]
    corners = rings * np.stack([np.cos(angle), np.sin(angle)], axis=-1) * scale

    def inside(at: Floats) -> np.ndarray:
        out = np.linalg.norm(at / scale, axis=1)
        return np.asarray((out <= 1.0 + SLACK) & (out >= hole - SLACK))

    return ShapeGrid(points, weight, corners, inside)


def box_grid(a: float, b: float) -> ShapeGrid:
    """Return the grid of a rectangle with the half width ``a`` and the half height ``b`` [m]."""
    thin = min(a, b)
    u, w = np.polynomial.legendre.leggauss(10)
    lines, weights = [], []
    for half in (a, b):
        # the ends of a long side, where the stress changes over a distance like the short one, have their own pieces
        cuts = [half - thin * part for part in (0.0, 0.25, 1.0, 3.0, 8.0) if thin * part < half]
        ends = np.unique([*cuts, *(-cut for cut in cuts), 0.0])
        middle, part = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
        lines.append((middle[:, None] + part[:, None] * u).ravel())
        weights.append((part[:, None] * w).ravel())
    x, y = np.meshgrid(*lines, indexing="ij")
    points = np.stack([x.ravel(), y.ravel()], axis=-1)
    counts = [int(np.clip(round(32 * half / math.sqrt(a * b)), 16, 128)) for half in (a, b)]
    across, up = (np.linspace(-half, half, 2 * (n // 2) + 1) for half, n in zip((a, b), counts, strict=True))
    corners = np.stack(np.meshgrid(across, up, indexing="ij"), axis=-1)

    def inside(at: Floats) -> np.ndarray:
        return np.asarray((np.abs(at) <= np.array([a, b]) * (1.0 + SLACK)).all(axis=1))

    return ShapeGrid(points, np.outer(*weights).ravel(), corners, inside)


def tube_flow(points: Floats, outer: float, inner: float, nu: float) -> Floats:
    """Return the flow in a circle or circular tube with the radii ``outer`` and ``inner`` [m], 0 without a hole.

    Under a unit force along x, t = (alpha x^2 + beta y^2, gamma x y) + grad h with the harmonic function
    h = -alpha [(a^2 + b^2) x + a^2 b^2 x/r^2], which frees both circles of traction.
    """
    second = math.pi * (outer**4 - inner**4) / 4.0
    gamma = -(1.0 + nu / (1.0 + nu)) / (4.0 * second)
    alpha = -(1.0 / second + gamma) / 2.0
    beta = alpha - gamma
    even, hole = outer**2 + inner**2, outer**2 * inner**2

    def along(x: Floats, y: Floats) -> tuple[Floats, Floats]:
        if not hole:
            return alpha * (x**2 - even) + beta * y**2, gamma * x * y
        r2 = x**2 + y**2
        first = alpha * (x**2 - even) + beta * y**2 - alpha * hole * (y**2 - x**2) / r2**2
        return first, gamma * x * y + 2.0 * alpha * hole * x * y / r2**2

    x, y = points.T
    (first, across), (second_own, second_across) = along(x, y), along(y, x)
    polar = 2.0 * second
    return np.stack(
        [np.stack([first, second_across, -y / polar], -1), np.stack([across, second_own, x / polar], -1)],
        axis=1,
    )


def elliptic_flow(points: Floats, a: float, b: float, nu: float) -> Floats:
    """Return the flow in an ellipse with half axes ``a`` along d1 and ``b`` along d2 [m] (Love, article 231)."""

    def along(x: Floats, y: Floats, a: float, b: float) -> tuple[Floats, Floats]:
        second, common = math.pi * a**3 * b / 4.0, (1.0 + nu) * (3.0 * a**2 + b**2)
        whole = 2.0 * (1.0 + nu) * a**2 + b**2
        own = (whole * (a**2 - x**2) - (1.0 - 2.0 * nu) * a**2 * y**2) / (2.0 * common * second)
        return own, -((1.0 + nu) * a**2 + nu * b**2) / common * x * y / second

    x, y = points.T
    (first, across), (second, second_across) = along(x, y, a, b), along(y, x, b, a)
    torsion = np.stack([-2.0 * y / (math.pi * a * b**3), 2.0 * x / (math.pi * a**3 * b)], axis=-1)
    flexure = np.stack(
        [np.stack([first, second_across], axis=-1), np.stack([across, second], axis=-1)], axis=1
    )
    return np.concatenate([flexure, torsion[..., None]], axis=-1)


def rectangular_flow(points: Floats, a: float, b: float, nu: float) -> Floats:
    """Return the flow in a rectangle with the half width ``a`` along d1 and the half height ``b`` along d2 [m]."""
    x, y = points.T
    first = _flexure(x, y, a, b, nu)
    second = _flexure(y, x, b, a, nu)
    if b >= a:
        torsion = _torsion(x, y, a, b)
    else:  # turned by a right angle: (x, y) -> (y, -x)
        along, across = _torsion(y, -x, b, a)
        torsion = -across, along
    columns = [np.stack(first, axis=-1), np.stack(second[::-1], axis=-1), np.stack(torsion, axis=-1)]
    return np.stack(columns, axis=-1)


def _torsion(x: Floats, y: Floats, a: float, b: float) -> tuple[Floats, Floats]:
    """Return the shear stress of a unit of G times twist for b >= a (Timoshenko-Goodier, article 109)."""
    k = math.pi / (2.0 * a)
    size = 16.0 * a / math.pi**2
    odd = _reflected(_odd, k * y, k * b, k * x, alternating=True, even=False).real
    even = _reflected(_odd, k * y, k * b, k * x, alternating=True, even=True).imag
    return -size * odd, 2.0 * x - size * even


def _flexure(x: Floats, y: Floats, a: float, b: float, nu: float) -> tuple[Floats, Floats]:
    """Return t along the force and across under a unit force along x.

    With t = ((a^2 - x^2)/2 I2, 0) + curl of nu/(1 + nu)/I2 psi: the Laplacian of psi is y, and psi vanishes on all
    sides. The series is that whose terms decay along the longer side.
    """
    second = 4.0 * a**3 * b / 3.0
    if a >= b:
        k, size = math.pi / b, -2.0 * b**2 / math.pi**2
        by_y = (3.0 * y**2 - b**2) / 6.0 + size * _reflected(
            _all, k * x, k * a, k * y, alternating=True, even=True
        ).real
        by_x = size * _reflected(_all, k * x, k * a, k * y, alternating=True, even=False).imag
    else:
        k, size = math.pi / (2.0 * a), 8.0 * a * b / math.pi**2
        by_y = (x**2 - a**2) / 2.0 + size * _reflected(
            _odd, k * y, k * b, k * x, alternating=False, even=True
        ).real
        by_x = x * y - size * _reflected(_odd, k * y, k * b, k * x, alternating=False, even=False).imag
    factor = nu / ((1.0 + nu) * second)
    return (a**2 - x**2) / (2.0 * second) + factor * by_y, -factor * by_x


def _reflected(
    kernel: Callable[[Floats, Floats], np.ndarray],
    p: Floats,
    q: float,
    angle: Floats,
    *,
    alternating: bool,
    even: bool,
) -> np.ndarray:
    """Return sum_n c_n/n^2 e^(i n angle) times a quotient of hyperbolic functions of n p over n q.

    It is cosh or (not ``even``) sinh over cosh or (not ``alternating``) sinh, as a series of exponentials.
    """
    total = np.zeros(np.shape(p), dtype=complex)
    for j in range(IMAGES):
        if 2.0 * j * q > NOTHING:
            break
        sign = -1.0 if alternating and j % 2 else 1.0
        near, far = (kernel((2 * j + 1) * q + side * p, angle) for side in (-1.0, 1.0))
        total += sign * (near + (1.0 if even else -1.0) * far)
    return total


def _all(decay: Floats, angle: Floats) -> np.ndarray:
    """Return sum over n >= 1 of (-1)^n/n^2 z^n with z = e^(-decay + i angle)."""
    return _dilogarithm(-np.exp(-decay + 1j * angle))


def _odd(decay: Floats, angle: Floats) -> np.ndarray:
    """Return sum over odd n of (-1)^((n-1)/2)/n^2 z^n with z = e^(-decay + i angle)."""
    z = 1j * np.exp(-decay + 1j * angle)
    return np.asarray(-0.5j * (_dilogarithm(z) - _dilogarithm(-z)))


def _dilogarithm(z: np.ndarray) -> np.ndarray:
    """Return Li2(z) = sum z^n/n^2 for z within the unit circle, by a few terms where z is small."""
    from scipy.special import spence

    found = np.zeros_like(z)
    for n in range(TERMS, 0, -1):
        found = (found + 1.0 / n**2) * z
    large = np.abs(z) > SMALL
    found[large] = spence(1.0 - z[large])
    return found
