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

ROUND_OFF = 1e-12
"""Part of what the motions of all nodes could make of an output below which it is round-off."""
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
        parts = [sparse.csr_array(rows @ free) for rows in small.balance]
        units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
        gradients = None if small.gradients is None else sparse.csr_array(small.gradients @ free)
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

    def silent(self, hertz: Floats) -> np.ndarray:
        """Return which outputs do not answer which inputs at these frequencies [Hz] ``(outputs, inputs)``.

        Their responses are round-off beside what as large motions of the nodes in other directions would make of them.
        """
        found = np.ones((len(self.readings.outputs), len(self.inputs.signals)), dtype=bool)
        for f in hertz:
            s = 2j * np.pi * float(f)
            c, x, multipliers, times = self._solved(s)
            moved = self.small.free @ x + times * np.asarray(self.small.held @ self.inputs.held)
            size = np.linalg.norm(np.abs(moved).reshape(-1, 3, moved.shape[1]), axis=1, keepdims=True)
            spread = np.broadcast_to(size, (len(size), 3, moved.shape[1])).reshape(moved.shape)
            most = np.abs(self.readings.direct).astype(float)
            if len(multipliers):
                row = np.abs(self.readings.multipliers).sum(axis=1)[:, None]
                most = most + row * np.abs(multipliers).max(axis=0)
            for k in self._parts:
                most = most + abs(c[k]) * (abs(self.readings.rows[k]) @ spread)
            found &= np.abs(self._out(c, x, multipliers, times)) <= ROUND_OFF * most
        return found

    def _at(self, s: complex) -> np.ndarray:
        return self._out(*self._solved(s))

    def _solved(self, s: complex) -> tuple[list[complex], np.ndarray, np.ndarray, np.ndarray]:
        """Return coefficients, free motions, multipliers and factors of prescribed motions at ``s`` [1/s]."""
        c = self.small.at(s)
        size = self._solver.size
        right, gaps = self._force.astype(complex), self._gaps.astype(complex)
        times = self.inputs.motions_at(s) if self._moving else np.ones(right.shape[1])
        if self._moving:
            gaps = gaps * times
            for k, pushed in zip(c, self._pushed, strict=True):
                right = right - (k * times) * pushed
        found = self._solver.solve(c, right, gaps)
        self.solved += 1
        return c, found[:size], found[size:], times

    def _out(self, c: list[complex], x: np.ndarray, multipliers: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Return what the outputs read."""
        out = self.readings.direct + self.readings.multipliers @ multipliers
        for k in self._parts:
            out = out + c[k] * (self._read[k] @ x)
            if self._moving:
                out = out + (c[k] * times) * self._carried[k]
        return np.asarray(out)

    def over(self, hertz: Floats) -> np.ndarray:
        """Return the responses ``(frequencies, outputs, inputs)``."""
        return np.array([self.at(float(f)) for f in hertz]).reshape(
            len(hertz), len(self.readings.outputs), len(self.inputs.signals)
        )
