"""What may be unknown of how a history was measured, with start and bounds."""

from __future__ import annotations

import numpy as np

from viscorod.records.read_off import BODY_AXES, WITHOUT_LEVER
from viscorod.typing import Floats

__all__ = ["unknowns_of_a_history"]

QUARTER_TURN = 0.5 * np.pi


def unknowns_of_a_history(
    times: Floats, values: Floats, quantity: str, direction: Floats | str
) -> dict[str, tuple[float, float, float]]:
    """Return start, low and high of the unknowns that a history may have, by their words.

    Args:
        times: s (n,); values: SI (n,).
        quantity, direction: as of a `Record`.
    """
    span = float(times[-1] - times[0])
    reach = float(np.ptp(values)) or float(np.abs(values).max()) or 1.0
    first, largest = float(times[0]), float(np.abs(values).max())
    known = {
        "release_time": (first, first - 0.5 * span, first + 0.5 * span),
        "offset": (0.0, -1e3 * reach - largest, 1e3 * reach + largest),
        "drift": (0.0, -10.0 * reach / span, 10.0 * reach / span),
        "gain": (1.0, 0.1, 10.0),
    }
    if not isinstance(direction, str) or direction in BODY_AXES:
        known |= {f"orientation_{axis}": (0.0, -QUARTER_TURN, QUARTER_TURN) for axis in "xyz"}
    if quantity not in WITHOUT_LEVER:
        known |= {f"marker_{k}": (0.0, -np.inf, np.inf) for k in (1, 2, 3)}
    return known
