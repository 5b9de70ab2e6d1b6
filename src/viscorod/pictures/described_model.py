"""The model that a result was computed from, as far as its file has it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.model.description.model_description import ModelDescription
    from viscorod.results.result import Result

__all__ = ["described", "weight_of"]


def described(result: Result) -> ModelDescription | None:
    """Return the model that a result was computed from, None where the file does not have all of it."""
    from viscorod.casefile.case import case_from_dict

    try:
        content = json.loads(result.stored.attrs.get("case", "{}"))
        return case_from_dict({**content, "title": "", "equilibrium": {}}).description
    except (InputError, ValueError, TypeError, AttributeError):
        return None  # functions of Python are in no file, and other versions have other words


def weight_of(result: Result) -> Floats | None:
    """Return the acceleration of gravity (3,) [m/s^2]; None without, and where it changes with time or is not known."""
    try:
        loads = json.loads(result.stored.attrs.get("case", "{}")).get("loads", [])
        kinds = [load.get("kind") for load in loads]
    except (ValueError, TypeError, AttributeError):
        return None
    if "gravity" not in kinds:
        return None
    model = described(result)
    if model is None:
        return None
    from viscorod.pictures.drawing.load_arrows import gravity

    steady = all(
        load.get("time") is None and load.get("until") is None
        for load in loads
        if load.get("kind") == "gravity"
    )
    pull = gravity(model)
    return pull if steady and np.any(pull) else None
