"""The response of small motions to harmonic inputs: the dynamic stiffness solved at every frequency."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

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
FEW = 10_000
"""Numbers of a matrix that is small."""
BESIDE = 1e-6
"""Distance from a pole, as a part of it, at which its residue is taken."""
COINCIDE = 1e-4
"""Singular value of the shares of poles in each other below which they are one pole."""


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
        self._balance = [sparse.csr_array(rows @ free) for rows in small.balance]
        gradients = None if small.gradients is None else sparse.csr_array(small.gradients @ free)
        self._gradients, self._size = gradients, int(free.shape[1])
        self._moving = bool(inputs.held.any() or inputs.targets.any())
        moved = np.asarray(held @ inputs.held)
        self._force = np.asarray(free.T @ inputs.force)
        self._pushed = [np.asarray(rows @ moved) for rows in small.balance]
        gaps = inputs.targets if small.gradients is None else inputs.targets - small.gradients @ moved
        self._gaps = np.asarray(gaps)
        self._read = [_of_few(sparse.csr_array(rows @ free)) for rows in readings.rows]
        self._carried = [np.asarray(rows @ moved) for rows in readings.rows]
        self._parts = [k for k, rows in enumerate(readings.rows) if rows.nnz]

    @cached_property
    def _solver(self) -> DynamicStiffness:
        small = self.small
        units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
        return DynamicStiffness(self._balance, self._gradients, units)

    def at(self, hertz: float) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` at a frequency [Hz]; SI units of output over input.

        Raises:
            SolveError: an undamped resonance.
        """
        return self._at(2j * np.pi * hertz)

    def residues(self, poles: np.ndarray) -> np.ndarray:
        """Return ``R (poles, outputs, inputs)`` of the parts ``R/(s - pole)`` of the response [1/s times its unit].

        They are taken next to each pole, at a part of 1e-6 of it, where all but poles as near is small beside it.
        What those have in it is taken off; of poles that coincide, as of a round rod, each has its share.
        """
        steps = BESIDE * np.abs(poles)
        beside = [step * self._at(complex(pole) + step) for pole, step in zip(poles, steps, strict=True)]
        shape = (len(poles), len(self.readings.outputs), len(self.inputs.signals))
        if not beside:
            return np.zeros(shape, dtype=complex)
        mixed = steps[:, None] / (steps[:, None] + poles[:, None] - poles[None, :])
        found, *_ = np.linalg.lstsq(mixed, np.array(beside).reshape(len(poles), -1), rcond=COINCIDE)
        return np.asarray(found, dtype=complex).reshape(shape)

    def silent(self, hertz: Floats) -> np.ndarray:
        """Return which outputs do not answer which inputs at these frequencies [Hz] ``(outputs, inputs)``.

        Their responses are round-off beside what as large motions of the nodes in other directions would make of them.
        """
        found = np.ones((len(self.readings.outputs), len(self.inputs.signals)), dtype=bool)
        for f in hertz:
            s = 2j * np.pi * float(f)
            c, solution, times = self.small.at(s), self.motion(s), self._times(s)
            x, multipliers = solution[: self._size], solution[self._size :]
            moved = self.small.free @ x + times * np.asarray(self.small.held @ self.inputs.held)
            size = np.linalg.norm(np.abs(moved).reshape(-1, 3, moved.shape[1]), axis=1, keepdims=True)
            spread = np.broadcast_to(size, (len(size), 3, moved.shape[1])).reshape(moved.shape)
            most = np.abs(self.readings.direct).astype(float)
            if len(multipliers):
                row = np.abs(self.readings.multipliers).sum(axis=1)[:, None]
                most = most + row * np.abs(multipliers).max(axis=0)
            for k in self._parts:
                most = most + abs(c[k]) * (abs(self.readings.rows[k]) @ spread)
            found &= np.abs(self.read(s, solution)) <= ROUND_OFF * most
        return found

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

    def lacking(self, s: Sequence[complex], found: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return what motions and multipliers leave of the balance and of the gaps.

        Args:
            s: where [1/s] ``(k,)``; found: motions and multipliers there ``(k, n + m, inputs)``.

        Returns:
            forces ``(k, n, inputs)`` and gaps ``(k, m, inputs)``.
        """
        driven = [self._driven(one) for one in s]
        right, gaps = (np.array([given[i] for given in driven]) for i in (0, 1))
        coefficients = np.array([self.small.at(one) for one in s])
        x, multipliers = found[:, : self._size], found[:, self._size :]
        for factors, rows in zip(coefficients.T, self._balance, strict=True):
            right -= factors[:, None, None] * _products(rows, x)
        if self._gradients is not None:
            right -= _products(sparse.csr_array(self._gradients.T), multipliers)
            gaps -= _products(self._gradients, x)
        return right, gaps

    def read(self, s: complex, found: np.ndarray) -> np.ndarray:
        """Return the responses ``(outputs, inputs)`` of motions and multipliers."""
        c, size = self.small.at(s), self._size
        x, multipliers = found[:size], found[size:]
        times = self._times(s)
        out: np.ndarray = self.readings.direct.astype(complex)
        if len(multipliers):
            out = out + self.readings.multipliers @ multipliers
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


def _of_few(matrix: sparse.csr_array) -> sparse.csr_array | np.ndarray:
    """Return a matrix that is small as an array, whose products take less time."""
    return matrix.toarray() if matrix.shape[0] * matrix.shape[1] <= FEW else matrix


def _products(matrix: sparse.csr_array, columns: np.ndarray) -> np.ndarray:
    """Return the products ``(k, m, j)`` of a matrix ``(m, n)`` with columns ``(k, n, j)``."""
    count, rows, each = columns.shape
    found = matrix @ columns.transpose(1, 0, 2).reshape(rows, count * each)
    return np.asarray(found.reshape(-1, count, each).transpose(1, 0, 2))
