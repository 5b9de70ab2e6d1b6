"""Equations of first order as full matrices, with the words of their inputs and outputs."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.linalg

from viscorod.alike import Alike
from viscorod.argument_names import known_arguments
from viscorod.errors import InputError
from viscorod.shown import Shown, counted
from viscorod.typing import Floats

if TYPE_CHECKING:
    from scipy.signal import StateSpace

__all__ = ["StateMatrices"]


@known_arguments
@dataclass(frozen=True, repr=False, eq=False)
class StateMatrices(Shown, Alike):
    """Equations of first order, ``z' = A z + B u``, ``y = C z + D u``.

    Attributes:
        A, B, C, D: dense matrices; inputs, outputs: their words.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def _facts(self) -> Iterator[str]:
        yield counted(len(self.A), "state")
        yield f"inputs {', '.join(self.inputs)}"
        yield f"outputs {', '.join(self.outputs)}"

    def state_space(self) -> StateSpace:
        """Return them for ``scipy.signal``."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)

    def control(self) -> Any:
        """Return them for python-control, with the words of inputs and outputs.

        Raises:
            InputError: python-control is not installed.
        """
        try:
            control = importlib.import_module("control")
        except ImportError:
            raise InputError(
                "python-control is not installed; install it with: pip install control, or take state_space()"
            ) from None
        return control.ss(
            self.A, self.B, self.C, self.D, inputs=list(self.inputs), outputs=list(self.outputs)
        )

    def response(self, frequencies: Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)`` at frequencies [Hz]."""
        A, (scale, _) = scipy.linalg.matrix_balance(self.A, permute=False, separate=True)
        B, C, unit = self.B / scale[:, None], self.C * scale, np.eye(len(A))
        return np.array(
            [C @ np.linalg.solve(2j * np.pi * f * unit - A, B) + self.D for f in np.atleast_1d(frequencies)]
        )

    @cached_property
    def poles(self) -> np.ndarray:
        """All poles ``s`` [1/s] ``(n,)``, slowest first."""
        s = np.linalg.eigvals(self.A)
        return np.asarray(s[np.argsort(np.abs(s), kind="stable")])
