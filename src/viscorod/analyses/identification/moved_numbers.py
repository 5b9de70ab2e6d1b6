"""Numbers of a model that two estimates put apart: a model that held would have the same ones in both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from viscorod.analyses.identification.told import value_text
from viscorod.solve.estimation.intervals import Covariance
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["moved_numbers"]

APART = 3.0
"""Standard errors by which the numbers of one law may differ with and without the colour of the noise."""


def moved_numbers(
    unknowns: Unknowns,
    last: tuple[Floats, Covariance],
    before: tuple[Floats, Covariance],
    units: Sequence[str],
) -> list[str]:
    """Return the numbers of a model, with both values, that two estimates put farther apart than both are known.

    Args:
        unknowns: that were sought.
        last, before: their coordinates ``(p,)`` in each estimate, and what is known of them.
        units: of the unknowns, SI.
    """
    found = []
    values = [unknowns.values(z) for z, _ in (last, before)]
    for k, (one, axis) in enumerate(zip(unknowns, np.eye(len(unknowns)), strict=True)):
        if one.nuisance or not all(known.told(axis) for _, known in (last, before)):
            continue
        size = float(np.hypot(*(known.deviations[k] for _, known in (last, before))))
        if abs(last[0][k] - before[0][k]) > APART * size:
            texts = [value_text(float(f"{value[k]:.5g}"), units[k]) for value in values]
            found.append(f"{one.name} ({' and '.join(texts)})")
    return found
