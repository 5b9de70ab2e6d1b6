"""Whether the steps of motions err by more than the data leave open: numbers at a tenth of their tolerance.

Steps may err by a part of the size of the model, which is a large part of a small motion, and always the same way: they
damp. What a tenth of the tolerance changes in the predictions moves the numbers by one Gauss-Newton step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.identification.members import Member, members_of
from viscorod.casefile.case import Case
from viscorod.errors import InputError, SolveError
from viscorod.solve.settings.motion import LEAST_TOLERANCE, SimulateSettings

if TYPE_CHECKING:
    from viscorod.analyses.identification.search import Fitted

__all__ = ["finer", "moved_by", "on_meshes_of", "steps_told"]

Pairs = Sequence[tuple[Case, Any]]
FINER = 0.1
MOVED = 0.25
"""Standard errors by which a number may move."""


def finer(pairs: Pairs, found: Fitted, *, given: bool) -> list[tuple[Case, Any]] | None:
    """Return the pairs with a tenth of the tolerance of their motions; None where there is no such motion.

    Args:
        pairs: that were fitted; found: the fit.
        given: motions whose case gives a tolerance, or those whose tolerance the fit chose.
    """
    used = {id(member.case.content): member.case.settings for member in found.members}
    made: dict[int, Case] = {}
    for case, _ in pairs:
        settings = used.get(id(case.content))
        if not isinstance(settings, SimulateSettings) or settings.tolerance is None:
            continue
        least = FINER * settings.tolerance
        if (
            id(case) in made
            or least < LEAST_TOLERANCE
            or ("tolerance" in case.content["simulate"]) is not given
        ):
            continue
        made[id(case)] = replace(case, settings=case.settings.model_copy(update={"tolerance": least}))
    return [(made.get(id(case), case), record) for case, record in pairs] if made else None


def moved_by(found: Fitted, pairs: Pairs) -> list[tuple[str, float]]:
    """Return the numbers of the model that other cases move by more than `MOVED` standard errors, and by how many."""
    best, known = found.estimate, found.known
    members = on_meshes_of(found, pairs)
    there = [member.predicted(record, found.named) for member in members for record in member.records]
    change = np.zeros(len(best.measured))
    values = np.concatenate(there)
    change[: len(values)] = values - best.predicted[: len(values)]
    white = best.noise.whitened(best.slopes)
    steps = np.abs(known.matrix @ (white.T @ best.noise.whitened(change)))
    return [
        (one.name, float(step / size))
        for one, axis, step, size in zip(
            found.unknowns, np.eye(len(steps)), steps, known.deviations, strict=True
        )
        if not one.nuisance and known.told(axis) and step > MOVED * size
    ]


def steps_told(found: Fitted, pairs: Pairs) -> list[str]:
    """Return in words which numbers rest on a tolerance that a case gives."""
    refined = finer(pairs, found, given=True)
    try:
        moved = [] if refined is None else moved_by(found, refined)
    except (SolveError, InputError):
        moved = []
    if not moved:
        return []
    texts = [f"{name} by {size:.2g} standard errors" for name, size in moved]
    return [
        f"A tenth of the tolerance of the motion moves {' and '.join(texts)}: the steps damp as well. Give a smaller "
        "tolerance, or leave it out, and the fit chooses it."
    ]


def on_meshes_of(found: Fitted, pairs: Pairs) -> list[Member]:
    """Return the cases with their records, with the meshes of a fit."""
    members = members_of(pairs)
    for one, known in zip(members, found.members, strict=True):
        one.divisions = known.divisions
    return members
