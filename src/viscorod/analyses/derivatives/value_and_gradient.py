"""A function of numbers of the case with its gradient, as optimisers and samplers call it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.derivatives.case_numbers import CaseNumber, with_values
from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.analyses.model import Model

__all__ = ["ValueAndGradient"]


class ValueAndGradient:
    """What a function makes of a result, and its derivatives by numbers of the model; see ``Model.value_and_gradient``.

    Args:
        model: whose numbers vary; keys: of these.
        function: of the result: a number, or an array of any shape.
        analysis: name of the model's method; settings: its arguments.
    """

    def __init__(
        self,
        model: Model,
        keys: Sequence[str],
        function: Callable[[Any], Any],
        analysis: str,
        settings: dict[str, Any],
    ) -> None:
        self.model, self.keys = model, tuple(keys)
        self._function, self._analysis, self._settings = function, analysis, settings
        self.numbers = [CaseNumber.of(model, key) for key in self.keys]

    @property
    def values(self) -> Floats:
        """The numbers as they are in the model ``(keys,)``, SI units."""
        return np.array([number.value for number in self.numbers])

    @property
    def units(self) -> list[str]:
        """Their units; empty where not known."""
        return [number.unit for number in self.numbers]

    def __call__(self, values: Any) -> tuple[Any, Floats]:
        """Return the value, and its derivatives with the numbers along the last axis ``(..., keys)``.

        Args:
            values: of the numbers ``(keys,)``, SI units.

        Raises:
            InputError: they are not as many numbers, or one is refused. SolveError: there is no such result.
        """
        numbers = np.asarray(values, dtype=float)
        if numbers.shape != (len(self.keys),):
            found = f"an array {numbers.shape}"
            why = f"{len(self.keys)} numbers are needed, one for each key"
            raise InputError(Fault("values", found, why, f"give those of {', '.join(self.keys)}"))
        model = with_values(self.model, dict(zip(self.keys, map(float, numbers), strict=True)))
        result = getattr(model, self._analysis)(**self._settings, derivatives=self.keys)
        value = np.asarray(self._function(result), dtype=float)
        slopes = [np.asarray(result.derivatives[key].of(self._function)) for key in self.keys]
        return (value if value.ndim else float(value)), np.stack(slopes, axis=-1)
