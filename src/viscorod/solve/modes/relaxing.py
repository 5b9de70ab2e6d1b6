"""Small vibrations of rods that relax: their stiffness is that of the branches at their own frequency.

In a vibration of angular frequency ``w`` a Maxwell branch has the storage ``x^2/(1 + x^2)`` of its stiffness and the
loss ``x/(1 + x^2)``, ``x = w tau`` (Ferry 1980, section 3.D). A material that has crept for long may be a hundred times
softer than in the vibrations about where it crept to.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.mechanics.elements.maxwell_branches import add_section_stiffness
from viscorod.solve.formulations.system import State, System
from viscorod.solve.linear.matrix import Matrix
from viscorod.solve.modes.linearisation import Linearisation
from viscorod.solve.modes.maxwell_modes import strain_operators
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.problem.element_arrays import all_branches
from viscorod.typing import Floats

__all__ = ["Relaxing", "vibrating"]

ITERATIONS = 4
CLOSE = 0.02
"""Relative change of the slowest frequency that does not matter."""
NEWTON = 60


class Relaxing:
    """What Maxwell branches add to the stiffness of small motions about a state in which they are relaxed.

    Args:
        system: of the problem, whose branches may be left out of it.
        state: at rest; linear: small motions about it, without the branches.

    Attributes:
        times: of relaxation ``(n,)`` [s].
    """

    def __init__(self, system: System, state: State, linear: Linearisation) -> None:
        self.linear, self._system = linear, system
        self.times, self._branches = system.problem.relaxation_times, all_branches(system.problem)
        self._strain = strain_operators(system, state).strain

    @classmethod
    def of(cls, system: System, state: State, linear: Linearisation) -> Relaxing | None:
        """Return it, None if nothing relaxes."""
        return cls(system, state, linear) if system.problem.relaxing else None

    @property
    def vibrating(self) -> Linearisation:
        """The small motions with the stiffness that branches have in the slowest vibration."""
        return self._slowest[1]

    @cached_property
    def _slowest(self) -> tuple[float, Linearisation]:
        """The angular frequency of the slowest vibration [rad/s], and the small motions with the stiffness there."""
        omega = np.inf
        for _ in range(ITERATIONS):
            stiff = self._stiffened(omega)
            try:
                found = undamped_modes(stiff, 1)
            except SolveError:
                break
            swinging = np.flatnonzero(found.squares > 0.0)
            if not len(swinging):
                break
            first = swinging[:1]
            shape = np.asarray(found.linear.basis @ found.shapes[:, first])
            new = float(np.sqrt(self._squares(found.squares[first], shape, omega)[0][0]))
            done = abs(new - omega) <= CLOSE * new
            omega = new
            if done:
                break
        return omega, self._stiffened(omega)

    def apart(self, squares: Floats, shapes: Floats) -> tuple[Floats, Floats]:
        """Return the squared frequencies of vibrations and what branches add to their decay, each at its own frequency.

        Args:
            squares, shapes: of modes of :attr:`vibrating`, body increments ``(6 n, k)``, orthonormal by the mass.
        """
        return self._squares(squares, shapes, self._slowest[0])

    def _squares(self, squares: Floats, shapes: Floats, omega: float) -> tuple[Floats, Floats]:
        """Return squares and decays as Rayleigh's quotient has them, of modes of the stiffness at ``omega``."""
        parts = self._quotients(shapes)
        relaxed = squares - self._storage(omega) @ parts
        tau = self.times[:, None]
        x = np.maximum(relaxed + parts.sum(axis=0), np.finfo(float).tiny)
        # the right side is concave in the square: Newton's method comes down to the largest root
        for _ in range(NEWTON):
            over = 1.0 + x * tau**2
            gap = x - relaxed - (parts * (x * tau**2 / over)).sum(axis=0)
            slope = 1.0 - (parts * (tau / over) ** 2).sum(axis=0)
            down = np.where((gap > 0.0) & (slope > 0.0), gap / np.where(slope > 0.0, slope, 1.0), 0.0)
            last, x = x, np.maximum(x - down, 1e-12 * x)
            if np.array_equal(x, last):
                break
        return x, 0.5 * (parts * (tau / (1.0 + x * tau**2))).sum(axis=0)

    def _storage(self, omega: float) -> Floats:
        """Return the storage of every branch over its stiffness ``(n,)``."""
        with np.errstate(divide="ignore"):
            return np.asarray(1.0 / (1.0 + (1.0 / (omega * self.times)) ** 2))

    def _quotients(self, shapes: Floats) -> Floats:
        """Return twice the energies of the springs of all branches in shapes ``(n, k)``."""
        elements = self._system.elements()
        moved = shapes.T.reshape(shapes.shape[1], -1, 6)[:, elements.nodes]
        k, count, nodes, _ = moved.shape
        strain = np.einsum("erc,kec->ker", self._strain, moved.reshape(k, count, 6 * nodes))
        strain = strain.reshape(k, *elements.reference.shape)
        inside = np.arange(strain.shape[2]) < elements.order[:, None]
        weights = np.where(inside, elements.weights[elements.order] * elements.half_lengths[:, None], 0.0)
        found = np.empty((len(self.times), k))
        for branch, one in zip(found, np.moveaxis(self._branches, 1, 0), strict=True):
            force = (one[elements.section] @ strain[..., None])[..., 0]
            branch[:] = np.einsum("eg,kega,kega->k", weights, strain, force)
        return found

    def _stiffened(self, omega: float) -> Linearisation:
        """Return the small motions with the stiffness that branches have at ``omega`` [rad/s]."""
        linear, problem = self.linear, self._system.problem
        matrix, size = Matrix(problem.pattern), 6 * problem.size
        matrix.clear()
        modulus = np.einsum("j,sjab->sab", self._storage(omega), self._branches)
        add_section_stiffness(self._system.elements(), modulus, self._strain, matrix.blocks)
        added = sparse.csr_array(linear.basis.T @ matrix.sparse()[:size, :size] @ linear.basis)
        if linear.parts:  # rigid motions of parts strain nothing
            own = sparse.diags_array((np.arange(added.shape[0]) >= linear.parts).astype(float))
            added = sparse.csr_array(own @ added @ own)
        work = None if linear.work is None else linear.work.plus(added, 1.0)
        return replace(linear, stiffness=sparse.csr_array(linear.stiffness + added), work=work)


def vibrating(linear: Linearisation, relaxing: Relaxing | None) -> Linearisation:
    """Return small motions as stiff as the slowest vibration sees them."""
    return linear if relaxing is None else relaxing.vibrating
