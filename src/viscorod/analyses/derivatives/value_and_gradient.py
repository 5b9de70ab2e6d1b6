"""A function of numbers of the case with its gradient, as optimisers and samplers call it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.derivatives.case_numbers import CaseNumber, with_values
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import show
from viscorod.one_thread import one_blas_thread
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
        adjoint: the function returns a number, and its derivatives by what is stored.

    Attributes:
        way: how the last gradient was found, in words.

    Raises:
        InputError: keys are no list of different keys, or there is no such number.
    """

    def __init__(
        self,
        model: Model,
        keys: Sequence[str],
        function: Callable[[Any], Any],
        analysis: str,
        settings: dict[str, Any],
        *,
        adjoint: bool = False,
    ) -> None:
        if isinstance(keys, str) or not keys or len(set(keys)) < len(keys):
            why = "a list of keys is needed, one or more, each once"
            raise InputError(Fault("keys", show(keys), why, 'write ["materials.rubber.youngs_modulus"]'))
        self.model, self.keys = model, tuple(keys)
        self._last: tuple[Floats, Any, Floats] | None = None
        self.way, self._adjoint, self._refused = "", adjoint, ""
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

    @property
    def sizes(self) -> Floats:
        """How large numbers of their kind are in the model ``(keys,)``, SI units; 1 where all of them are zero.

        That is their own size, or that of the vector that they are components of.
        """
        return np.array([number.size or 1.0 for number in self.numbers])

    def relative(self, parts: Any) -> tuple[Any, Floats]:
        """Return the same of numbers as parts of their :attr:`sizes`, with the derivatives by these parts.

        Optimisers take all unknowns for of one size, and end at once where a gradient is that by a modulus in Pa.

        Args:
            parts: of the numbers ``(keys,)``; those of the model are ``f.values / f.sizes``.

        Raises:
            InputError: see :meth:`__call__`.
        """
        value, gradient = self(self._array(parts) * self.sizes)
        return value, gradient * self.sizes

    def __call__(self, values: Any) -> tuple[Any, Floats]:
        """Return the value, and its derivatives with the numbers along the last axis ``(..., keys)``.

        What was asked for last is remembered: asking for it again costs nothing.

        Args:
            values: of the numbers ``(keys,)``, SI units.

        Raises:
            InputError: they are not as many numbers, or one is refused. SolveError: there is no such result.
        """
        numbers = self._array(values)
        if self._last is None or not np.array_equal(numbers, self._last[0]):
            model = with_values(self.model, dict(zip(self.keys, map(float, numbers), strict=True)))
            found = self._by_adjoint(model) if self._adjoint else self._by_derivatives(model)
            self._last = numbers, *found
        _, value, gradient = self._last
        return (value.copy() if isinstance(value, np.ndarray) else value), gradient.copy()

    def _array(self, values: Any) -> Floats:
        """Return numbers ``(keys,)``.

        Raises:
            InputError: they are none, or not as many.
        """
        why = f"{len(self.keys)} of them are needed, one for each key"
        instead = f"give those of {', '.join(self.keys)}"
        try:
            numbers = np.array(values, dtype=float)
        except (TypeError, ValueError):
            raise InputError(Fault("values", show(values), why, instead)) from None
        if numbers.shape != (len(self.keys),):
            raise InputError(Fault("values", f"an array {numbers.shape}", why, instead))
        return numbers

    def _by_derivatives(self, model: Model) -> tuple[Any, Floats]:
        """Return the value and its derivatives by those of the result."""
        self.way = "derivatives of the result"
        result = getattr(model, self._analysis)(**self._settings, derivatives=self.keys)
        found = self._function(result)
        try:
            value = np.asarray(found, dtype=float)
        except (TypeError, ValueError):
            why = "it returns a number, or an array of numbers, made of the result"
            raise InputError(
                Fault("function", type(found).__name__, why, 'such as found.position("beam.end")')
            ) from None
        slopes = [np.asarray(result.derivatives[key].of(self._function)) for key in self.keys]
        return (value if value.ndim else float(value)), np.stack(slopes, axis=-1)

    def _by_adjoint(self, model: Model) -> tuple[float, Floats]:
        """Return the value of a motion and its gradient, by the adjoint where it is known."""
        from viscorod.analyses.call_arguments import SimulateArguments
        from viscorod.analyses.derivatives.adjoint import UnknownAdjointError, motion_gradient, weights_of

        if self._refused:
            return self._by_neighbours(model)
        ends: list[float] = []
        asked = self._settings.get("progress")

        def progress(end: float, h: float) -> None:
            ends.append(end)
            if callable(asked):
                asked(end, h)

        given = {name: value for name, value in self._settings.items() if name != "progress"}
        run = model.simulate(**given, progress=progress)
        value, by_stored = _pair(self._function(run))
        weights = weights_of(run, by_stored)
        try:
            with one_blas_thread():
                gradient = motion_gradient(model, SimulateArguments(**given), run, ends, self.keys, weights)
        except UnknownAdjointError as error:
            self._refused = str(error)
            return self._by_neighbours(model)
        self.way = "adjoint"
        return value, gradient

    def _by_neighbours(self, model: Model) -> tuple[float, Floats]:
        """Return the same from the derivatives of the whole motion."""
        from viscorod.analyses.derivatives.adjoint import weights_of

        self.way = f"neighbours of the model, as many as numbers ask for: {self._refused}"
        run = model.simulate(**self._settings, derivatives=self.keys)
        value, by_stored = _pair(self._function(run))
        weights = weights_of(run, by_stored)
        every = [run.derivatives[key].data for key in self.keys]
        found = [sum(float(np.vdot(by, data[name].values)) for name, by in weights.items()) for data in every]
        return value, np.array(found)


def _pair(found: Any) -> tuple[float, Mapping[str, Any]]:
    """Return the value and the derivatives that a function returned.

    Raises:
        InputError: it is something else.
    """
    if isinstance(found, tuple) and len(found) == 2 and isinstance(found[1], Mapping):
        value = np.asarray(found[0], dtype=float)
        if value.ndim == 0:
            return float(value), found[1]
    raise InputError(
        Fault(
            "function",
            type(found).__name__,
            "with adjoint=True it returns one number and its derivatives by what is stored",
            'return value, {"position": an array like run.data["position"]}',
        )
    )
