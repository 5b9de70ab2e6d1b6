"""How the laws of sections respond at many Gauss points at once."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.section_laws import PARAMETERS, SectionLaws, law_values
from viscorod.typing import Floats, Integers

__all__ = ["law_responses"]


def law_responses(laws: SectionLaws, section: Integers, strain: Floats, rate: Floats) -> Floats:
    """Return what laws give, in the order of ``section_laws``, at Gauss points ``(..., PARAMETERS)``; 0 without one.

    Args:
        section: of every point ``(...)``; strain, rate: ``(..., 6)``.
    """
    values = np.zeros((*section.shape, PARAMETERS))
    if laws.present:
        law_values(
            laws, section.ravel(), strain.reshape(-1, 6), rate.reshape(-1, 6), values.reshape(-1, PARAMETERS)
        )
    return values
