"""What accompanies a computation without changing its numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["CallOptions", "Progress"]

Progress: TypeAlias = Callable[[float, float], None]
"""Called after every step with the time reached [s], or the load factor, and the step's size."""


@dataclass(frozen=True)
class CallOptions:
    """What accompanies a computation without changing its numbers.

    Attributes:
        title: kept with the result.
        progress: called with what has been reached and the size of the last step.
        stop: asked regularly; a reason that it returns ends the computation.
        folder: where the states of a motion go as they come; None keeps them in memory.
        resume: go on with the motion that was stopped in that folder.
        start: a result whose last state is the first guess of a steady rotation.
        attributes: more attributes of the result, such as the text of its case file.
    """

    title: str = ""
    progress: Progress | None = None
    stop: Callable[[], str] | None = None
    folder: Path | None = None
    resume: bool = False
    start: Result | None = None
    attributes: dict[str, str] = field(default_factory=dict)
