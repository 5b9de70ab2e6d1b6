"""Speeds at which a frequency is a multiple of the speed: where something excites a mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from viscorod.solve.tracking.mode_tracking import Tracker
from viscorod.solve.tracking.special_values import ModeBetween, resting, solved

__all__ = ["Critical", "critical_speeds"]

FAINT = 1e-8
"""Distance of a frequency from a multiple of the speed, as a part of it, that is round-off."""


@dataclass(frozen=True)
class Critical:
    """A critical speed.

    Attributes:
        speed: [rad/s]; mode: number; order: the multiple of the speed; root: of the mode there, on the model [1/s].
        sign: of its frequency in the frame of the diagram; slope: of the frequency less the multiple, by the speed.
    """

    speed: float
    mode: int
    order: float
    root: complex
    sign: float
    slope: float


def critical_speeds(tracker: Tracker, orders: Sequence[float], waves: Sequence[int]) -> list[Critical]:
    """Return all critical speeds among the samples, in their order.

    Args:
        tracker: has followed the modes; orders: multiples of the speed.
        waves: by how many speeds the frequency of every mode in the frame of the diagram is more than on the model.
    """
    found, still = [], resting(tracker.samples)
    for mode, wave in enumerate(waves):
        for k, ends in enumerate(pairwise(tracker.samples)):
            speeds = np.array([end.parameter for end in ends])
            if still[k : k + 2, mode].any():
                continue  # at no speed every multiple of it is there
            seen = np.array([end.roots[mode].imag for end in ends]) + wave * speeds
            for order in orders:
                for sign in (1.0, -1.0):
                    apart = sign * seen - order * speeds
                    along = (np.abs(apart) <= FAINT * order * speeds).all()  # round-off decides nothing
                    if (apart[0] > 0.0) != (apart[1] > 0.0) and not along:
                        found.append(_critical(ModeBetween(tracker, mode, ends), order, sign, wave))
    return sorted(found, key=lambda one: one.speed)


def _critical(branch: ModeBetween, order: float, sign: float, wave: int) -> Critical:
    def distance(speed: float) -> float:
        return sign * (branch.root(speed).imag + wave * speed) - order * speed

    low, high = (end.parameter for end in branch.ends)
    speed, slope = solved(distance, low, high)
    return Critical(speed, branch.mode, order, branch.root(speed), sign, slope)
