"""What a case file asks for, done."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from viscorod.analyses.model import Model, Progress
from viscorod.model.description.model_description import ModelDescription
from viscorod.solve.settings import AnySettings, EquilibriumSettings, PathSettings, SteadySettings

if TYPE_CHECKING:
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady

__all__ = ["Case", "as_model", "run_case"]


class Case(Protocol):
    """What a case file holds: a described model, the settings of one analysis, a title."""

    @property
    def description(self) -> ModelDescription:
        """The described model."""

    @property
    def settings(self) -> AnySettings:
        """The settings of the analysis that the file asks for."""

    @property
    def title(self) -> str:
        """The title, or empty."""

    @property
    def source(self) -> Path | None:
        """The file."""

    @property
    def text(self) -> str:
        """Of the file."""


def run_case(
    case: Case,
    *,
    progress: Progress | None = None,
    folder: str | Path | None = None,
    doubts: Sequence[str] = (),
    resume: bool = False,
    stop: Callable[[], str] | None = None,
) -> Run | Equilibrium | Steady:
    """Do what a case file asks for.

    Args:
        case: of the file; progress: see ``Model.simulate``.
        folder, resume: of a motion, see there; doubts: go to its warnings.
        stop: called after every step of a motion, in every iteration of other analyses; a reason that it returns ends
            it.
    """
    model = as_model(case.description)
    model.about = {"case_text": case.text, "doubts": json.dumps(list(doubts))}
    if case.source is not None:
        model.about["case_file"] = str(case.source)
    given = {name: getattr(case.settings, name) for name in case.settings.model_fields_set}
    if isinstance(case.settings, EquilibriumSettings):
        return model.equilibrium(**given, progress=progress, title=case.title, stop=stop)
    if isinstance(case.settings, PathSettings):
        return model.path(**given, progress=progress, title=case.title, stop=stop)
    if isinstance(case.settings, SteadySettings):
        return model.steady(**given, title=case.title, stop=stop)
    return model.simulate(
        **given, progress=progress, title=case.title, folder=folder, resume=resume, stop=stop
    )


def as_model(description: ModelDescription) -> Model:
    """Give a description its analyses."""
    return Model.of(**description.parts())
