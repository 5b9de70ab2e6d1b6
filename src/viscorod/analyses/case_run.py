"""Run the analysis of a case file."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.analyses.buckling import buckling
from viscorod.analyses.call_arguments import CallOptions, Progress
from viscorod.analyses.campbell import campbell
from viscorod.analyses.discrete import DiscreteModel
from viscorod.analyses.equilibrium import equilibrium
from viscorod.analyses.frequency_response import frequency_response, with_inputs
from viscorod.analyses.model import Model
from viscorod.analyses.modes import modes
from viscorod.analyses.motion import motion
from viscorod.analyses.one_thread import one_blas_thread
from viscorod.analyses.path import equilibrium_path
from viscorod.analyses.periodic import periodic
from viscorod.analyses.refinement import (
    refined,
    refined_buckling,
    refined_modes,
    refined_motion,
    refined_periodic,
    refined_response,
)
from viscorod.analyses.stability import stability
from viscorod.analyses.steady import steady_rotation
from viscorod.casefile.case import Case
from viscorod.model.description.model_description import ModelDescription
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
    from viscorod.results.buckling import Buckling
    from viscorod.results.campbell import Campbell
    from viscorod.results.frequency_response import FrequencyResponse
    from viscorod.results.modes_result import Modes
    from viscorod.results.periodic import Periodic
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.stability_result import Stability
    from viscorod.results.steady_result import Steady

__all__ = ["as_model", "discretised_case", "run_case"]

ANALYSES: dict[type, Callable[[DiscreteModel, Any], Run | Equilibrium | Steady]] = {
    EquilibriumSettings: equilibrium,
    PathSettings: equilibrium_path,
    SteadySettings: steady_rotation,
}
"""The analysis of each kind of settings, beside that of motions."""


def discretised_case(case: Case) -> DiscreteModel:
    """Discretise the model of a case for its analysis; it was validated when the file was read.

    Raises:
        InputError: the model does not allow the analysis, or its mesh cannot satisfy it.
    """
    about = {"case_text": case.text}
    if case.source is not None:
        about["case_file"] = str(case.source)
    options = CallOptions(title=case.title, attributes=about)
    described = with_inputs(case.description, case.settings)
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
) -> Run | Equilibrium | Steady | Modes | Buckling | FrequencyResponse | Campbell | Periodic | Stability:
    """Run the analysis of a case file.

    Args:
        case: the content of the file.
        discrete: its discretised model, if it is there already.
        progress: see ``Model.simulate``.
        folder, resume, anew: of a motion, see there.
        doubts: warnings that the result is to keep.
        stop: called after every step of a motion, in every iteration of other analyses; a reason that it returns ends
            it.
    """
    discrete = discrete or discretised_case(case)
    options = replace(
        discrete.options,
        progress=progress,
        folder=None if folder is None else Path(folder),
        resume=resume,
        anew=anew,
        stop=stop,
    )
    discrete = discrete.renewed(options, {"doubts": json.dumps(list(doubts))})
    settings = case.settings
    with one_blas_thread():
        if isinstance(settings, SimulateSettings):
            return refined_motion(motion, discrete, settings)
        if isinstance(settings, ModesSettings):
            return refined_modes(modes, discrete, settings)
        if isinstance(settings, ResponseSettings):
            return refined_response(frequency_response, discrete, settings)
        if isinstance(settings, BucklingSettings):
            return refined_buckling(buckling, discrete, settings)
        if isinstance(settings, CampbellSettings):
            return campbell(discrete, settings)
        if isinstance(settings, StabilitySettings):
            return stability(discrete, settings)
        if isinstance(settings, PeriodicSettings):
            return refined_periodic(periodic, discrete, settings)
        return refined(ANALYSES[type(settings)], discrete, settings)


def as_model(description: ModelDescription) -> Model:
    """Give a description its analyses."""
    return Model.of(**description.parts())
