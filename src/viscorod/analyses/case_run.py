"""Run the analysis of a case file."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from viscorod.analyses.call_options import CallOptions, Progress
from viscorod.analyses.discrete import DiscreteModel
from viscorod.casefile.case import Case
from viscorod.model.description.model_description import ModelDescription
from viscorod.one_thread import one_blas_thread
from viscorod.solve.settings.buckling import BucklingSettings
from viscorod.solve.settings.campbell import CampbellSettings
from viscorod.solve.settings.modes import ModesSettings
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.solve.settings.periodic import PeriodicSettings
from viscorod.solve.settings.response import ResponseSettings
from viscorod.solve.settings.stability import StabilitySettings
from viscorod.solve.settings.statics import EquilibriumSettings, PathSettings
from viscorod.solve.settings.steady import SteadySettings

if TYPE_CHECKING:
    from viscorod.analyses.model import Model
    from viscorod.results.any_result import AnyResult

__all__ = ["as_model", "discretised_case", "run_case"]


_ANALYSES: dict[type, tuple[str, str]] = {
    SimulateSettings: ("refinement:refined_motion", "motion:motion"),
    EquilibriumSettings: ("refinement:refined", "equilibrium:equilibrium"),
    PathSettings: ("refinement:refined", "path:equilibrium_path"),
    SteadySettings: ("refinement:refined", "steady:steady_rotation"),
    ModesSettings: ("refined_frequencies:refined_modes", "modes:modes"),
    BucklingSettings: ("refined_frequencies:refined_buckling", "buckling:buckling"),
    ResponseSettings: ("refined_frequencies:refined_response", "frequency_response:frequency_response"),
    PeriodicSettings: ("refined_frequencies:refined_periodic", "periodic:periodic"),
    CampbellSettings: ("", "campbell:campbell"),
    StabilitySettings: ("", "stability:stability"),
}
"""Where is what refines the mesh of an analysis, empty for none, and the analysis, by its settings."""


@cache
def _analysis(kind: type) -> Callable[[DiscreteModel, Any], AnyResult]:
    """Return the analysis of a kind of settings, on a mesh that is fine enough for it.

    It is imported when it is asked for: a run starts sooner without the others.
    """
    refine, place = _ANALYSES[kind]
    analysis: Callable[[DiscreteModel, Any], AnyResult] = resolve_name(f"{__package__}.{place}")
    return partial(resolve_name(f"{__package__}.{refine}"), analysis) if refine else analysis


def discretised_case(case: Case, options: CallOptions | None = None) -> DiscreteModel:
    """Discretise the model of a case for its analysis; it was validated when the file was read.

    Args:
        case: the content of the file.
        options: of the call, but for what the case says of itself.

    Raises:
        InputError: the model does not allow the analysis, or its mesh cannot satisfy it.
    """
    about = {"case_text": case.text}
    if case.changes:
        about["case_changes"] = case.changes
    if case.source is not None:
        about["case_file"] = str(case.source)
    options = replace(options or CallOptions(), title=case.title, attributes=about)
    described = case.description
    if isinstance(case.settings, ResponseSettings | PeriodicSettings):
        from viscorod.analyses.frequency_response import with_inputs

        described = with_inputs(described, case.settings)
    return DiscreteModel.of(described, case.settings, options, validated=described is case.description)


def run_case(
    case: Case,
    discrete: DiscreteModel | None = None,
    *,
    progress: Progress | None = None,
    folder: str | Path | None = None,
    doubts: Sequence[str] = (),
    resume: bool = False,
    anew: bool = False,
    stop: Callable[[], str] | None = None,
    errors: bool = True,
) -> AnyResult:
    """Run the analysis of a case file.

    Args:
        case: the content of the file.
        discrete: its discretised model, if it is there already.
        progress: see ``Model.simulate``.
        folder, resume, anew: of a motion, see there.
        doubts: warnings that the result is to keep.
        errors: estimate the errors of mesh and steps; where the program chooses the mesh, it does.
        stop: called after every step of a motion, in every iteration of other analyses; a reason that it returns ends
            it.
    """
    given: dict[str, Any] = {
        "progress": progress,
        "folder": None if folder is None else Path(folder),
        "resume": resume,
        "anew": anew,
        "stop": stop,
        "errors": errors,
    }
    begun = discrete or discretised_case(case, CallOptions(**given))
    known = json.loads(begun.attributes["doubts"])
    told = {"doubts": json.dumps(list(dict.fromkeys([*doubts, *known])))}
    if discrete is None:
        begun.attributes.update(told)
    else:
        begun = discrete.renewed(replace(discrete.options, **given), told)
    settings = case.settings
    with one_blas_thread():
        return _analysis(type(settings))(begun, settings)


def as_model(description: ModelDescription) -> Model:
    """Give a description its analyses."""
    from viscorod.analyses.model import Model

    return Model.of(**description.parts())
