"""Names of modes by what stores their energy: ``bend_1 1`` is the slowest of those that mostly bend about d1."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise

import numpy as np
import scipy.linalg

from viscorod.model.sections.stiffness_section import STRAINS
from viscorod.solve.constraints.parts import many_parts
from viscorod.solve.constraints.rigid_motions import RigidParts, rigid_share
from viscorod.solve.formulations.system import State, System
from viscorod.solve.modes.damped import CLOSE
from viscorod.solve.modes.linearisation import Linearisation
from viscorod.solve.modes.maxwell_modes import strain_operators
from viscorod.typing import Floats

SPRING, SWING, DAMPER = "spring", "swing", "damper"
"""Kinds of modes that rods are hardly strained by: on springs, by loads that turn them back, against dampers alone."""
RIGIDLY = 0.98
"""Part of the kinetic energy in rigid motions of parts from which on rods are hardly strained."""
TOGETHER = 16
"""Shapes whose strains are in memory at once."""


class StrainEnergies:
    """Energies of strains in small motions about a state.

    Args:
        system: whose rods and springs they are; state: about which it moves; linear: its small motions.
        rigid: motions of rigid parts that supports and joints allow there, where ``linear`` does not have them apart.
    """

    def __init__(
        self, system: System, state: State, linear: Linearisation, rigid: RigidParts | None = None
    ) -> None:
        elements = system.elements()
        self._nodes, self._B = elements.nodes, strain_operators(system, state).strain
        self._stiffness = elements.stiffness[elements.section]
        inside = np.arange(self._stiffness.shape[1]) < elements.order[:, None]
        self._weights = np.where(
            inside, elements.weights[elements.order] * elements.half_lengths[:, None], 0.0
        )
        self.rods = system.problem.rods
        self._rod = np.concatenate([e.rod for e in system.problem.sets])
        constraints = system.constraints
        gradients = constraints.measure(state)[2].reshape(-1, 2, 6)
        self._springs = np.where(constraints.is_held, 0.0, np.abs(constraints.slopes[0]))
        self._gradients, self._joined = gradients, constraints.arrays.nodes
        self.linear, self._rigid = linear, rigid
        problem = system.problem
        self._many = (problem, state.r, state.q) if many_parts(problem) else None

    def _strains(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return strains and forces of ``shapes`` at the Gauss points ``(e, g, 6, m)``."""
        moved = np.asarray(self.linear.basis @ shapes)
        count, many = len(self._nodes), moved.shape[1]
        own = moved.reshape(-1, 6, many)[self._nodes].reshape(count, self._B.shape[2], many)
        strains = np.matmul(self._B, own).reshape(count, self._stiffness.shape[1], 6, many)
        return strains, np.matmul(self._stiffness, strains)

    def forms(self, shapes: np.ndarray, rod: str | None = None) -> np.ndarray:
        """Return twice the energies of all strains as forms ``(6, m, m)`` of ``shapes``, of one rod or of all."""
        strains, forces = self._strains(shapes)
        weights = (
            self._weights if rod is None else self._weights * (self._rod == self.rods.index(rod))[:, None]
        )
        half = np.einsum("eg,egim,egin->imn", weights, strains.conj(), forces, optimize=True)
        return np.asarray(0.5 * (half + np.swapaxes(half.conj(), 1, 2)))

    def energies(self, shapes: np.ndarray) -> Floats:
        """Return twice the energies of all strains in each of the shapes ``(m, 6)``, of all rods."""
        found = np.empty((shapes.shape[1], 6))
        for first in range(0, len(found), TOGETHER):
            some = slice(first, first + TOGETHER)
            strains, forces = self._strains(shapes[:, some])
            found[some] = np.einsum("eg,egim->mi", self._weights, (strains.conj() * forces).real)
        return found

    def of_springs(self, shapes: np.ndarray) -> Floats:
        """Return twice the energies of all springs in each of the shapes ``(m,)``."""
        moved = np.asarray(self.linear.basis @ shapes).reshape(-1, 6, shapes.shape[1])
        value = np.zeros((len(self._springs), shapes.shape[1]), dtype=moved.dtype)
        for side in range(2):
            there = self._joined[:, side] >= 0
            value[there] += np.einsum(
                "ci,cim->cm", self._gradients[there, side], moved[self._joined[there, side]]
            )
        return np.asarray(self._springs @ np.abs(value) ** 2)

    def principal(self, shapes: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """Return shapes that, within one frequency, have their energy in few strains each: any combination is a mode.

        Args:
            shapes: of modes ``(size, m)``; rates: their eigenvalues, those that are equal side by side.
        """
        turned = np.array(shapes)
        edges = np.flatnonzero(np.abs(np.diff(rates)) > CLOSE * np.abs(rates[1:])) + 1
        for first, last in pairwise([0, *edges.tolist(), len(rates)]):
            if last - first < 2:
                continue
            forms = self.forms(shapes[:, first:last])
            whole = forms.sum(axis=0)
            if np.linalg.cond(whole) > 1e8:
                continue
            weighted = np.einsum("i,imn->mn", np.arange(1.0, 7.0), forms)
            _, turn = scipy.linalg.eigh(weighted, whole)
            found = shapes[:, first:last] @ turn
            turned[:, first:last] = found / np.sqrt(self.inertia(found))
        return turned

    def inertia(self, shapes: np.ndarray) -> Floats:
        """Return ``x.M x`` of every shape ``(m,)``."""
        return np.asarray(np.einsum("ik,ik->k", shapes.conj(), self.linear.mass @ shapes).real)

    def shares(self, shapes: np.ndarray) -> Floats:
        """Return the parts of the elastic energy of the rods that all strains have ``(m, 6)``; zeros without any."""
        energies = self.energies(shapes)
        total = energies.sum(axis=1, keepdims=True)
        return np.asarray(np.divide(energies, total, out=np.zeros_like(energies), where=total > 0.0))

    def kinds(self, shapes: np.ndarray) -> list[str]:
        """Return what stores most of the energy of every shape, in words."""
        if not shapes.shape[1]:
            return []
        energies = self.energies(shapes)
        springs, rigidly = self.of_springs(shapes), self._rigid_part(shapes)
        found = []
        for k, energy in enumerate(energies):
            if springs[k] > energy.sum():
                found.append(SPRING)
            elif rigidly[k] > RIGIDLY:
                found.append(SWING)
            else:
                found.append(STRAINS[int(np.argmax(energy))])
        return found

    def _rigid_part(self, shapes: np.ndarray) -> Floats:
        """Return the part of the kinetic energy of every shape in rigid motions of parts ``(m,)``."""
        linear, k = self.linear, self.linear.parts
        if self._many:
            return rigid_share(*self._many, np.asarray(linear.basis @ shapes))
        momenta = np.asarray(linear.mass @ shapes)
        if k:
            inertia, pushed = linear.mass[:k, :k].toarray(), momenta[:k]
        elif self._rigid is not None and self._rigid.found:
            motions = self._rigid.increments
            inertia, pushed = motions.T @ (linear.mass @ motions), motions.T @ momenta
        else:
            return np.zeros(shapes.shape[1])
        moving = np.linalg.pinv(inertia, rcond=1e-12, hermitian=True) @ pushed
        part = np.einsum("km,km->m", pushed.conj(), moving).real
        return np.asarray(part / np.einsum("km,km->m", shapes.conj(), momenta).real)


def numbered(kinds: list[str], real: np.ndarray, *, from_first: bool = True) -> list[str]:
    """Return kinds with the number of each among its kind; both ``real`` roots of an overdamped mode have one number.

    Args:
        kinds: in order of frequency; real: which of them are real roots.
        from_first: whether they begin with the slowest mode; kinds alone are returned if not.
    """
    if not from_first:
        return kinds
    count: Counter[str] = Counter()
    waiting: dict[str, int] = {}
    found = []
    for kind, alone in zip(kinds, real, strict=True):
        if alone and kind in waiting:
            found.append(f"{kind} {waiting.pop(kind)}")
            continue
        count[kind] += 1
        if alone and kind != DAMPER:
            waiting[kind] = count[kind]
        found.append(f"{kind} {count[kind]}")
    return found
