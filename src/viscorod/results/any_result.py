"""All kinds of results: a type for any of them, and the class of what a file says it holds."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import TypeAlias

    from viscorod.results.buckling import Buckling
    from viscorod.results.campbell import Campbell
    from viscorod.results.decay_result import Decay
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.frequency_response import FrequencyResponse
    from viscorod.results.identification import Identification
    from viscorod.results.master_curve_result import MasterCurve
    from viscorod.results.modal_fit_result import ModalFit
    from viscorod.results.modes_result import Modes
    from viscorod.results.periodic import Periodic
    from viscorod.results.run import Run
    from viscorod.results.stability_result import Stability
    from viscorod.results.steady_result import Steady

    AnyResult: TypeAlias = (
        Run
        | Equilibrium
        | Steady
        | Modes
        | Buckling
        | FrequencyResponse
        | Campbell
        | Stability
        | Periodic
        | Identification
        | Decay
        | MasterCurve
        | ModalFit
    )

__all__ = ["KINDS", "result_class"]

KINDS = {
    "simulate": ("run", "Run"),
    "equilibrium": ("equilibrium_result", "Equilibrium"),
    "steady": ("steady_result", "Steady"),
    "modes": ("modes_result", "Modes"),
    "buckling": ("buckling", "Buckling"),
    "response": ("frequency_response", "FrequencyResponse"),
    "campbell": ("campbell", "Campbell"),
    "stability": ("stability_result", "Stability"),
    "periodic": ("periodic", "Periodic"),
    "identification": ("identification", "Identification"),
    "decay": ("decay_result", "Decay"),
    "modal_fit": ("modal_fit_result", "ModalFit"),
    "master_curve": ("master_curve_result", "MasterCurve"),
}
"""Module and class of each kind; they are imported when the first of it is opened."""


def result_class(kind: str) -> Any | None:
    """Return the class of results of a kind; None if there is no such kind."""
    if kind not in KINDS:
        return None
    module, name = KINDS[kind]
    return getattr(import_module(f"viscorod.results.{module}"), name)
