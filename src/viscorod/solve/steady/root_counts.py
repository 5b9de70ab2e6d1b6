"""How many roots of ``det Q(s)`` lie in a region, by the argument principle.

The phase of ``det Q``, over the roots that are known and over the determinant of another system without roots there,
does not wind around zero on the way around the region if none is missing.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.steady.growth_limits import GrowthLimits
from viscorod.solve.steady.quadratic_pencil import QuadraticPencil
from viscorod.typing import Floats

__all__ = ["growing", "missing"]

STEPS, FINEST = 4, 9
"""Parts of a half circle at first, and how often one is halved at most."""
EVALUATIONS = 150
"""Points of a circle that are looked at, at most."""
NEAR_AXIS = 1e-6
"""Distance from the imaginary axis, in the angular speed, beyond which motions are counted as growing ones."""
NEUTRAL = 2e-4
"""Distance from zero, in the angular speed, within which motions are neutral."""
TURN, ALIKE = 1.5, 0.7
"""Changes of phase [rad] in the halves of a part of a circle, and difference of both, beyond which these are looked at
themselves."""


def missing(
    pencil: QuadraticPencil, roots: np.ndarray, shift: float, reach: float, limits: GrowthLimits
) -> int | None:
    """Return how many roots within ``reach`` of the shift are not known, by the argument principle; None if unknown.

    The determinant is divided by the known ones and by that of a much stiffer system, ``K + B M``, which has as fast
    motions and no slow ones: ``|s^2 + s (d + i g) + k + B| > 0`` for ``|s| < r`` if ``B > r^2 + r G + N`` and
    overdamped motions creep faster than r. So the phase on the circle changes little. It is that of a real function:
    the upper half of the circle tells.
    """
    r = abs(shift) + reach
    if not (np.isfinite(limits.softening) and r < pencil.creep):
        return None
    stiffness = 4.0 * (r**2 + r * limits.gyroscopic) + limits.softening
    other = QuadraticPencil(
        pencil.M, pencil.C, sparse.csr_array(pencil.K + stiffness * pencil.M), pencil.A, pencil.Z[:, :0]
    )
    known = roots[np.abs(roots - shift) < 1.5 * reach]

    def phase(angle: float) -> complex:
        s = complex(shift + reach * np.exp(1j * angle))
        turned = pencil.determinant(s) - other.determinant(s)
        return complex(np.exp(1j * (turned - float(np.angle(s - known).sum()))))

    return _winding(phase, np.linspace(0.0, np.pi, STEPS + 1))


def growing(pencil: QuadraticPencil, roots: np.ndarray, radius: float, limits: GrowthLimits) -> int | None:
    """Return how many roots with Re s > 0 and ``|s| < radius`` are not among those that are known; None if unknown.

    It is the winding of ``det Q`` over that of a system with more damping and stiffness and without gyroscopic forces,
    which has no such roots (Kelvin and Tait; Chetaev) and is as overdamped.
    """
    softening, rate = limits.softening, limits.spin
    if not np.isfinite(softening):
        return None
    damping = sparse.csr_array(0.5 * (pencil.C + pencil.C.T) + 4.0 * rate * pencil.M)
    stiffness = sparse.csr_array(0.5 * (pencil.K + pencil.K.T) + (softening + rate**2) * pencil.M)
    other = QuadraticPencil(pencil.M, damping, stiffness, pencil.A, pencil.Z[:, :0])
    known = roots[roots.real > -0.2 * radius]  # the others make no difference beside the other system
    moved = known - np.abs(known.real) - 0.5 * radius
    outer, inner, least = 1.05 * radius, NEUTRAL * rate, NEAR_AXIS * rate

    def place(part: float) -> complex:
        """Go along an arc from the real axis, down beside the imaginary one, and around zero."""
        if part <= 1.0:
            return complex(outer * np.exp(0.5j * np.pi * part) + least)
        if part <= 2.0:
            return complex(least, outer + (part - 1.0) * (inner - outer))
        return complex(inner * np.exp(0.5j * np.pi * (3.0 - part)) + least)

    def phase(part: float) -> complex:
        s = place(part)
        turned = pencil.determinant(s) - other.determinant(s)
        return complex(np.exp(1j * (turned - float((np.angle(s - known) - np.angle(s - moved)).sum()))))

    return _winding(phase, np.linspace(0.0, 3.0, 3 * STEPS + 1))


def _winding(phase: Callable[[float], complex], ends: Floats) -> int | None:
    """Return how often a function that is real at both ends of a way winds around zero on it and its mirror image."""
    values: dict[float, complex] = {}

    def change(a: float, b: float) -> float:
        for place in (a, b):
            if place not in values:
                values[place] = phase(place)
        return float(np.angle(values[b] / values[a]))

    pending = [(float(a), float(b), 0) for a, b in pairwise(ends)]
    total = 0.0
    try:
        while pending:
            a, b, depth = pending.pop()
            middle = 0.5 * (a + b)
            halves = change(a, middle), change(middle, b)
            if max(abs(part) for part in halves) < TURN and abs(halves[1] - halves[0]) < ALIKE:
                total += sum(halves)
            elif depth == FINEST or len(values) > EVALUATIONS:
                return None
            else:
                pending += [(a, middle, depth + 1), (middle, b, depth + 1)]
    except SolveError:
        return None
    return round(total / np.pi)
