"""The response of small motions to harmonic inputs: the dynamic stiffness solved at every frequency."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from viscorod.solve.linear_systems.dynamic_stiffness import DynamicStiffness
from viscorod.solve.linear_systems.ports import Inputs
from viscorod.solve.linear_systems.readings import Readings
from viscorod.solve.linear_systems.small_motions import SmallMotions
from viscorod.typing import Floats

__all__ = ["HarmonicResponse"]

BESIDE = 1e-6
"""Distance from a pole, as a part of it, at which its residue is taken."""


@dataclass
class HarmonicResponse:
    """Transfer functions from inputs to outputs, at any frequency.

    Attributes:
        small: the motions; inputs, readings: what goes in and comes out.
        solved: number of systems that were solved so far.
    """

    small: SmallMotions
    inputs: Inputs
    readings: Readings
    solved: int = field(default=0)

    def __post_init__(self) -> None:
        small, inputs, readings = self.small, self.inputs, self.readings
        free, held = small.free, small.held
        parts = self._balance = [sparse.csr_array(rows @ free) for rows in small.balance]
        units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
        gradients = None if small.gradients is None else sparse.csr_array(small.gradients @ free)
        self._gradients = gradients
        self._solver = DynamicStiffness(parts, gradients, units)
        self._moving = bool(inputs.held.any() or inputs.targets.any())
        moved = np.asarray(held @ inputs.held)
        self._force = np.asarray(free.T @ inputs.force)
        self._pushed = [np.asarray(rows @ moved) for rows in small.balance]
        gaps = inputs.targets if small.gradients is None else inputs.targets - small.gradients @ moved
        self._gaps = np.asarray(gaps)
        self._read = [sparse.csr_array(rows @ free) for rows in readings.rows]
        self._carried = [np.asarray(rows @ moved) for rows in readings.rows]
        self._parts = [k for k, rows in enumerate(readings.rows) if rows.nnz]

    def at(self, hertz: float) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` at a frequency [Hz]; SI units of output over input.

        Raises:
            SolveError: an undamped resonance.
        """
        return self._at(2j * np.pi * hertz)

    def residues(self, poles: np.ndarray) -> np.ndarray:
        """Return ``R (poles, outputs, inputs)`` of the parts ``R/(s - pole)`` of the response [1/s times its unit].

        They are taken next to each pole, at a part of 1e-6 of it, where all else is small beside them.
        """
        found = []
        for pole in poles:
            step = BESIDE * abs(pole)
            found.append(step * self._at(complex(pole) + step))
        return np.array(found, dtype=complex).reshape(
            len(poles), len(self.readings.outputs), len(self.inputs.signals)
        )

    def _at(self, s: complex) -> np.ndarray:
        return self.read(s, self.motion(s))

    def motion(self, s: complex) -> np.ndarray:
        """Return free motions and multipliers ``(n + m, inputs)`` at ``s`` [1/s].

        Raises:
            SolveError: an undamped resonance.
        """
        found = self.solve(s, *self._driven(s))
        self.solved += 1
        return found

    def solve(self, s: complex, right: np.ndarray, gaps: np.ndarray) -> np.ndarray:
        """Return free motions and multipliers for forces ``(n, k)`` and gaps ``(m, k)``."""
        return self._solver.solve(self.small.at(s), right, gaps)

    def lacking(self, s: complex, found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what motions and multipliers leave of the balance ``(n, inputs)`` and of the gaps ``(m, inputs)``."""
        size = self._solver.size
        right, gaps = self._driven(s)
        for k, rows in zip(self.small.at(s), self._balance, strict=True):
            right = right - k * (rows @ found[:size])
        if self._gradients is not None:
            right = right - self._gradients.T @ found[size:]
            gaps = gaps - self._gradients @ found[:size]
        return right, gaps

    def read(self, s: complex, found: np.ndarray) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` of motions and multipliers."""
        c, size = self.small.at(s), self._solver.size
        x, multipliers = found[:size], found[size:]
        times = self._times(s)
        out = self.readings.direct + self.readings.multipliers @ multipliers
        for k in self._parts:
            out = out + c[k] * (self._read[k] @ x)
            if self._moving:
                out = out + (c[k] * times) * self._carried[k]
        return np.asarray(out)

    def _times(self, s: complex) -> np.ndarray:
        return self.inputs.motions_at(s) if self._moving else np.ones(self._force.shape[1])

    def _driven(self, s: complex) -> tuple[np.ndarray, np.ndarray]:
        """Return what drives the balance and the gaps."""
        right, gaps, times = self._force.astype(complex), self._gaps.astype(complex), self._times(s)
        if self._moving:
            gaps = gaps * times
            for k, pushed in zip(self.small.at(s), self._pushed, strict=True):
                right = right - (k * times) * pushed
        return right, gaps

    def over(self, hertz: Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)``."""
        return np.array([self.at(float(f)) for f in hertz]).reshape(
            len(hertz), len(self.readings.outputs), len(self.inputs.signals)
        )
