"""What viscosity dissipates between the ends of a step, from its powers at the stages."""

from __future__ import annotations

import numpy as np

from viscorod.typing import Floats

ROUND_OFF = 1e-9
"""Part of the largest viscous power of a step up to which a negative one is round-off."""


def drives(powers: Floats) -> bool:
    """Return whether viscous powers [W] are negative beyond round-off: the law of a damper feeds energy in."""
    return bool(powers.min(initial=0.0) < -ROUND_OFF * np.abs(powers).max(initial=0.0))


def loss_within(weights: Floats, powers: Floats, whole: float) -> Floats:
    """Return the viscous loss up to ``k`` parts of a step ``(k,)`` [J].

    Where nothing drives, it grows from part to part: interpolation gives no energy back.

    Args:
        weights: of the integrals of powers from the start of the step ``(k, s)`` [s], parts in ascending order.
        powers: at the stages ``(s,)`` [W]; whole: loss of the step [J].
    """
    loss = weights @ powers
    if drives(powers):
        return np.asarray(loss)
    return np.asarray(np.maximum.accumulate(np.clip(loss, 0.0, whole)))
