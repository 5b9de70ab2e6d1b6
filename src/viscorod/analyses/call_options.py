"""Options of a call of an analysis, which do not change its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

__all__ = ["CallOptions", "Progress"]

Progress: TypeAlias = Callable[[float, float], None]
"""Called after every step with the time reached [s], or the load factor, and the step's size."""


@dataclass(frozen=True)
class CallOptions:
    """Options of a call, which do not change its numbers.

    Attributes:
        title: kept with the result.
        progress: called with what has been reached and the size of the last step; from the start again where the
            computation is made again, on a finer mesh or with smaller steps.
        stop: asked regularly; a reason that it returns ends the computation.
        folder: where the states of a motion go as they come; None keeps them in memory.
        resume: go on with the motion that was stopped in that folder.
        anew: begin anew where a motion was stopped in that folder.
        attributes: of the result, beside those that all have, such as the text of its case file.
        derivatives: keys of the numbers of the model by which derivatives of the result are wanted.
        errors: estimate the errors of mesh and steps; where the program chooses the mesh it needs them.
        note_steps: note where the steps of a motion end; derivatives need it.
        step_ends: where they end [s], whatever they err by; none: steps are chosen.
        stop_folded: end a motion in which an element folds, as on too coarse a mesh.
    """

    title: str = ""
    progress: Progress | None = None
    stop: Callable[[], str] | None = None
    folder: Path | None = None
    resume: bool = False
    anew: bool = False
    attributes: dict[str, str] = field(default_factory=dict)
    derivatives: tuple[str, ...] = ()
    errors: bool = True
    note_steps: bool = False
    step_ends: tuple[float, ...] = ()
    stop_folded: bool = False
