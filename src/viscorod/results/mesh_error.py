"""The error of the mesh as a result tells it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from viscorod.results.recorded_states import RecordedStates

__all__ = ["mesh_errors"]


def mesh_errors(result: RecordedStates) -> dict[str, float]:
    """Return the estimated error of positions by the mesh, as a part of the length of each rod.

    It is the difference from the solution on elements half as long (``solve.refinement.mesh_estimate``), the largest
    over the states that were compared. Of motions it contains how far vibrations run ahead on this mesh, those too that
    larger steps damp away: the error that is left with steps a third as long. Of motions whose errors of
    steps a second run tells, it is 1.5 times the difference from a third one on elements half as long
    (``analyses.finer_run``).

    Returns:
        Rod -> estimated error of positions, anywhere on it, over its length; empty if it was not estimated.
    """
    return {
        str(rod): float(error)
        for rod, error in json.loads(result.stored.attrs.get("mesh_errors", "{}")).items()
    }
