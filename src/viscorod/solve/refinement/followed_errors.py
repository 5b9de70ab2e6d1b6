"""What the mesh makes wrong of modes that were followed: the same on elements half as long, at a few places.

An error of a special value is what the function whose root it is leaves there on the finer mesh, over its slope.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.solve.tracking.engine_orders import Critical
from viscorod.solve.tracking.mode_tracking import SWINGS, Family, Sample, Tracker
from viscorod.solve.tracking.special_values import COINCIDENT, Limit
from viscorod.typing import Floats

__all__ = ["FinerModes", "critical_errors"]

BEYOND = 1.3
"""How far beyond the roots of the modes others are sought."""
NEAR_ZERO = 1e-3
"""Part of the largest root below which others are near zero."""


class FinerModes:
    """The modes of the same model on elements half as long.

    Args:
        family: of the finer mesh; tracker: that followed the modes on the coarse one.
    """

    def __init__(self, family: Family, tracker: Tracker) -> None:
        self.coarse = tracker
        self.tracker = Tracker(family, tracker.count, tracker.check_interrupt)

    def roots(self, parameter: float, largest: float) -> np.ndarray:
        """Return the roots up to ``largest`` and somewhat beyond [1/s]."""
        return self.tracker.spectrum(parameter, BEYOND * largest).roots

    def errors(self, samples: list[Sample]) -> Floats:
        """Return the estimated errors of all roots, in parts of them ``(modes,)``, the larger at both ends.

        Roots that oscillate are compared in their order, so that a missing or an invented one shows. Those near zero
        may be the rounding of motions that nothing resists, which oscillates or not: the order of the others
        is taken with them and without.
        """
        worst = np.zeros(len(samples[0].roots))
        for sample in (samples[0], samples[-1]):
            mine = sample.roots
            largest = float(np.abs(mine).max())
            swinging = _frequencies(sample.spectrum.roots)
            finer = self.roots(sample.parameter, largest)
            theirs = _frequencies(finer)
            near_zero = NEAR_ZERO * largest
            low = int((theirs <= near_zero).sum() - (swinging <= near_zero).sum())
            for k, s in enumerate(mine):
                if abs(s.imag) <= SWINGS * abs(s) or not (len(theirs) and len(swinging)):
                    gap = float(np.abs(finer - s).min())
                    worst[k] = max(worst[k], gap / max(abs(s), 1e-9 * largest))
                    continue
                rank = int(np.argmin(np.abs(swinging - abs(s.imag))))
                ranks = [min(max(rank + shift, 0), len(theirs) - 1) for shift in (0, low)]
                # beside a frequency near zero, as of a shaft at its critical speed, others count
                size = max(abs(s), near_zero)
                worst[k] = max(worst[k], float(np.abs(theirs[ranks] - abs(s.imag)).min()) / size)
        return worst

    def limit_error(self, limit: Limit) -> float:
        """Return the estimated error of a limit of stability, in parts of it."""
        family = self.tracker.family
        if limit.function == "stiffness":
            pencil = family.pencil(limit.parameter)
            start = np.random.default_rng(1).standard_normal(pencil.basis.shape[0]).astype(complex)
            left = pencil.stiffness_near_zero(start)
        else:
            size = abs(limit.root)
            roots = self.roots(limit.parameter, 2.0 * size)
            order = np.argsort(np.abs(roots - 1j * abs(limit.root.imag)), kind="stable")
            if limit.function == "pair":
                one, other = roots[order[:2]]
                left = float(((one - other) ** 2).real)
                if limit.slope == 0.0 and abs(left) <= (COINCIDENT * size) ** 2:
                    return 0.0  # one root on both meshes: it is so at this very value
            else:
                left = float(roots[order[0]].real)
        return _over(left, limit.slope, limit.parameter)

    def critical_error(self, one: Critical, wave: int) -> float:
        """Return the estimated error of a critical speed, in parts of it."""
        largest = max(abs(one.root), one.speed)
        roots = self.roots(one.speed, largest)
        roots = np.concatenate([roots, roots.conj()])
        s = roots[np.argmin(np.abs(roots - one.root))]
        left = one.sign * (s.imag + wave * one.speed) - one.order * one.speed
        return _over(float(left), one.slope, one.speed)


def critical_errors(finer: FinerModes | None, critical: Sequence[Critical], waves: Sequence[int]) -> Floats:
    """Return the estimated errors of all critical speeds; zeros where there is no finer mesh."""
    if finer is None:
        return np.zeros(len(critical))
    return np.array([finer.critical_error(one, waves[one.mode]) for one in critical], dtype=float)


def _frequencies(roots: np.ndarray) -> Floats:
    """Return the imaginary parts of roots that oscillate, in order."""
    return np.asarray(np.sort(roots.imag[roots.imag > SWINGS * np.abs(roots)]))


def _over(left: float, slope: float, value: float) -> float:
    """Return an error in parts of a value; all of it where nothing tells."""
    return abs(left / slope / value) if slope != 0.0 and value != 0.0 else 1.0
