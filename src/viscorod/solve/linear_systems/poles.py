"""Poles of small motions: roots ``s`` of the dynamic stiffness, measured moduli taken at the frequency of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.errors import SolveError
from viscorod.solve.formulations.system import State
from viscorod.solve.linear_systems.dynamic_stiffness import DynamicStiffness
from viscorod.solve.linear_systems.small_motions import SmallMotions
from viscorod.solve.modes.damped import REAL
from viscorod.solve.modes.linearisation import Linearisation, nodal_motions
from viscorod.solve.modes.mode_names import StrainEnergies, numbered
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.modes.vibrations import complex_modes
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.geometric_steady import GeometricSteady
from viscorod.solve.steady.stability import SLOW, stability

__all__ = ["Poles", "poles_about_rotation", "poles_below"]

FIRST, MOST = 12, 200
"""Modes sought at first, and at most."""
ROUNDS, CONVERGED = 40, 1e-10
FURTHER = 2.0
"""Frequencies, as multiples of the highest, up to which undamped modes are followed to their poles."""


@dataclass(frozen=True)
class Poles:
    """Poles that oscillate, by frequency.

    Attributes:
        roots: ``s`` [1/s], Im > 0; names: of their motions; complete: none is missing up to the frequency asked for.
    """

    roots: np.ndarray
    names: tuple[str, ...]
    complete: bool


def poles_below(
    solver: StaticSolver, state: State, linear: Linearisation, small: SmallMotions, hertz: float
) -> Poles:
    """Return the poles with natural frequencies up to ``hertz``, and the next one.

    Args:
        solver, state: of the motions; linear: with the fitted laws; small: with what is used.
    """
    count, most = FIRST, min(MOST, linear.motions)
    while True:
        asked = min(count, most)
        try:
            found = (
                _measured(solver, state, linear, small, (asked, hertz))
                if small.measured
                else _of_modes(solver, state, linear, asked)
            )
        except SolveError:
            return Poles(np.zeros(0, dtype=complex), (), False)
        roots, names = found
        above = np.abs(roots) > 2.0 * np.pi * hertz
        if above.any() or asked == most:
            last = int(np.argmax(above)) + 1 if above.any() else len(roots)
            return Poles(roots[:last], names[:last], bool(above.any()) or most == linear.motions)
        count *= 2


def poles_about_rotation(
    solver: StaticSolver, equations: GeometricSteady, small: SmallMotions, hertz: float
) -> Poles:
    """Return the poles of small motions about a steady rotation, as :func:`poles_below` does about an equilibrium."""
    rate, system, limit = abs(equations.rate), equations.small_motions(), 2.0 * np.pi * hertz
    count, most = FIRST, min(MOST, small.free.shape[1])
    reach = FURTHER * limit if small.measured else limit
    while True:
        found = stability(system, rate, min(count, most))
        s = found.eigenvalues
        kept = np.flatnonzero((s.imag > SLOW * rate) & (s.imag > REAL * np.abs(s)))
        enough = bool((np.abs(s[kept]) > reach).any())
        if enough or count >= most or len(s) > count:
            break
        count *= 2
    kept = kept[: int(np.searchsorted(np.abs(s[kept]), reach)) + 1]
    shapes = np.array([found.system.increments(complex(s[k]), found.vectors[:, k]) for k in kept])
    nodal = shapes.reshape(len(kept), -1).T
    energies = StrainEnergies(solver.system, equations.state(), nodal_motions(small.problem))
    names = numbered(energies.kinds(nodal), np.zeros(len(kept), dtype=bool))
    roots = s[kept]
    if small.measured and len(kept):
        refine = _Refinement(small)
        roots = np.array([refine.root(complex(one), d) for one, d in zip(roots, shapes, strict=True)])
    order = np.argsort(np.abs(roots), kind="stable")
    order = order[: int(np.searchsorted(np.abs(roots[order]), limit)) + 1]
    return Poles(roots[order], tuple(names[k] for k in order), found.complete and (enough or count >= most))


def _of_modes(
    solver: StaticSolver, state: State, linear: Linearisation, count: int
) -> tuple[np.ndarray, tuple[str, ...]]:
    modes = complex_modes(solver, state, linear, count)
    kept = np.flatnonzero(modes.eigenvalues.imag > 0.0)
    return modes.eigenvalues[kept], tuple(modes.shown.names[k] for k in kept)


def _measured(
    solver: StaticSolver,
    state: State,
    linear: Linearisation,
    small: SmallMotions,
    wanted: tuple[int, float],
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return poles by inverse iteration from the undamped modes: ``wanted`` are their number and frequency [Hz]."""
    undamped = undamped_modes(linear, wanted[0])
    energies = StrainEnergies(solver.system, state, undamped.linear)
    shapes = energies.principal(undamped.shapes, undamped.squares)
    kept = np.flatnonzero(undamped.squares > 0.0)
    kept = kept[np.argsort(undamped.squares[kept], kind="stable")]
    # a complex modulus may be less than that at rest: modes somewhat faster take part too
    reach = (FURTHER * 2.0 * np.pi * wanted[1]) ** 2
    kept = kept[: int(np.searchsorted(undamped.squares[kept], reach)) + 2]
    nodal = np.asarray(undamped.linear.basis @ shapes[:, kept])
    names = numbered(energies.kinds(shapes[:, kept]), np.zeros(len(kept), dtype=bool))
    refine = _Refinement(small)
    roots = np.array(
        [refine.root(1j * float(np.sqrt(undamped.squares[k])), d) for k, d in zip(kept, nodal.T, strict=True)]
    )
    order = np.argsort(np.abs(roots), kind="stable")
    return roots[order], tuple(names[k] for k in order)


class _Refinement:
    """Inverse iteration (Newton's method) with the moduli frozen at the frequency reached."""

    def __init__(self, small: SmallMotions) -> None:
        self.small = small
        free = small.free
        self.parts = [sparse.csr_array(rows @ free) for rows in small.balance]
        units = np.where(small.free_places % 6 < 3, small.problem.length, 1.0)
        gradients = None if small.gradients is None else sparse.csr_array(small.gradients @ free)
        self.solver = DynamicStiffness(self.parts, gradients, units)
        gram = sparse.csc_array(free.T @ free)
        self.project = sparse.linalg.splu(gram)

    def root(self, s: complex, nodal: np.ndarray) -> complex:
        """Return the pole next to one of another law, with its nodal increments."""
        moved = np.asarray(self.small.free.T @ nodal)
        x = self.project.solve(np.ascontiguousarray(moved.real)) + 1j * self.project.solve(
            np.ascontiguousarray(moved.imag)
        )
        against = x.conj() / np.vdot(x, x).real
        conditions = np.zeros((self.solver.conditions, 1))
        for _ in range(ROUNDS):
            slope = self._slope(s, x)
            try:
                found = self.solver.solve(self.small.at(s), slope[:, None], conditions)[: len(x), 0]
            except SolveError:
                return s
            scale = against @ found
            change = -(against @ x) / scale
            x, s = found / scale, s + change
            if abs(change) <= CONVERGED * abs(s):
                break
        return complex(s)

    def _slope(self, s: complex, x: np.ndarray) -> np.ndarray:
        small = self.small
        out = self.parts[1] @ x + 2.0 * s * (self.parts[2] @ x)
        for part, tau in zip(self.parts[3:], small.times, strict=False):
            out = out + tau / (1.0 + s * tau) ** 2 * (part @ x)
        return np.asarray(out)
