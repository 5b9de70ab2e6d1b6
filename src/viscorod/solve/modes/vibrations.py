"""Small vibrations about an equilibrium: natural frequencies, damping ratios, shapes and names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from viscorod.solve.formulations.system import State
from viscorod.solve.history import StationReader
from viscorod.solve.modes.damped import REAL, DampedModes, damped_modes
from viscorod.solve.modes.linearisation import Linearisation, linearise
from viscorod.solve.modes.maxwell_modes import Pencil
from viscorod.solve.modes.mode_names import DAMPER, StrainEnergies, numbered
from viscorod.solve.modes.undamped import Undamped, resolved_modes, undamped_modes
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.statics.tangent import ALIKE
from viscorod.typing import Floats

__all__ = [
    "Linearisation",
    "ModesFound",
    "ModesShown",
    "Vibrations",
    "complex_modes",
    "linearise",
    "natural_frequencies",
    "station_shapes",
]

NUMBERED = 100
"""Modes below those near a frequency up to which they are all computed, to be numbered by kind."""
MOST_TRIED = 400
"""Modes among which as many oscillating ones are sought as are asked for."""
TWISTING = 1e-4
"""Displacement over rotation and length of the model below which a shape is one of rotations."""
RESIDUAL = 1e-5
"""Largest residual of a mode that counts as exact."""


@dataclass(frozen=True)
class Vibrations:
    """Modes in order of natural frequency, rigid motions first.

    Each rigid motion (and mechanism) is listed once, with the frequency and the damping ratio 0; geometry tells how
    many there are. An overdamped mode gives two real eigenvalues, listed beside each other at the natural frequency
    that it has without damping, so that creeping motions whose rates crowd near one over the retardation time of the
    material do not come before slow vibrations. The real roots by which Maxwell branches creep are left out.

    Attributes:
        eigenvalues: s in ``exp(s t)`` [1/s], one of each conjugate pair (Im >= 0); overdamped modes give two real ones.
        frequencies: ``|s|/2 pi`` [Hz] (for an underdamped mode the undamped natural frequency).
        damping_ratios: ``-Re s/|s|``; 0 of rigid motions.
        shapes: displacement of every station ``(modes, stations, 3)``, global axes, complex, largest component 1 (of
            the rotations where they are pure twist).
        rotations: rotation of every station (body axes), same scaling.
        positions: of the stations about which they swing ``(stations, 3)`` [m].
        residuals: the forces that an eigenvalue and its shape leave unbalanced, over the largest of the elastic,
            viscous and inertial forces, all measured by the displacements (or accelerations) that they would cause;
            without damping a bound of the relative error of the squared frequency of this mesh.
        names: ``"bend_1 2"`` is the second mode whose elastic energy is mostly that of bending about d1; the words are
            those of the strains, ``"spring"`` for springs, ``"swing"`` for parts that move like rigid ones under loads
            that turn them back, ``"damper"`` for what dampers alone resist; rigid motions are described. Modes near a
            frequency have no number where there are too many below them to be counted by kind.
        shares: parts of the elastic energy of the rods in shear_1, shear_2, stretch, bend_1, bend_2 and twist
            ``(modes, 6)``; zeros of rigid motions.
        rigid: number of rigid motions in the list.
        certified: True if it is proven that none is missing up to the highest one (or between the lowest and the
            highest of those near a frequency), but for others with just its frequency where there are more than 30 of
            them, as in many equal rods: by an inertia count of the undamped modes (Sylvester), each of which is one of
            the damped ones here, or because these are all modes. False where damping couples the modes of a large
            model, or where following loads make its stiffness unsymmetric: residuals hold, but nothing proves that
            there are no others.
        frequency_errors: estimated errors of the frequencies by the mesh, in parts of them; none where not estimated.
    """

    eigenvalues: np.ndarray
    frequencies: Floats
    damping_ratios: Floats
    shapes: np.ndarray
    rotations: np.ndarray
    positions: Floats
    residuals: Floats
    names: tuple[str, ...]
    shares: Floats
    rigid: int
    certified: bool
    frequency_errors: Floats = field(default_factory=lambda: np.zeros(0))


class ModesShown(NamedTuple):
    """What modes look like; see the attributes of :class:`Vibrations` of the same names."""

    shapes: np.ndarray
    rotations: np.ndarray
    positions: Floats
    names: tuple[str, ...]
    shares: Floats


@dataclass(frozen=True)
class ModesFound:
    """Modes whose frequencies alone are computed at once; see the attributes of :class:`Vibrations` of the same names.

    Attributes:
        show: makes the rest, which takes a fifth of a small search.
    """

    eigenvalues: np.ndarray
    frequencies: Floats
    damping_ratios: Floats
    residuals: Floats
    rigid: int
    certified: bool
    show: Callable[[], ModesShown]

    @cached_property
    def shown(self) -> ModesShown:
        """Shapes, names and shares of the energy, made when they are first asked for."""
        return self.show()


def natural_frequencies(linear: Linearisation, count: int) -> Floats:
    """Return the ``count`` lowest undamped angular frequencies [rad/s]; rigid and unstable motions count as 0."""
    resolved = resolved_modes(linear) if count == 1 else None
    if resolved is not None:
        return np.sqrt(1.0 / resolved[0][-1:])
    found = undamped_modes(linear, min(count, linear.motions))
    squares = np.concatenate([np.zeros(found.rigid.shape[1]), np.sort(np.maximum(found.squares, 0.0))])
    return np.asarray(np.sqrt(squares[:count]))


def complex_modes(
    solver: StaticSolver,
    state: State,
    linear: Linearisation,
    count: int,
    *,
    near: float | None = None,
    oscillating: bool = False,
) -> ModesFound:
    """Return the ``count`` slowest damped modes about ``state``, rigid motions first; or those ``near`` a frequency.

    Args:
        solver, state: of the linearisation ``linear``.
        count: number of modes.
        near: frequency [Hz] to which they are nearest, without rigid motions.
        oscillating: leave out rigid motions and overdamped ones.
    """
    target = None if near is None else 2.0 * np.pi * near
    listed = linear.rigid if near is None and not oscillating else 0
    wanted = max(count - listed, 1)
    while True:
        undamped = undamped_modes(linear, wanted, target)
        if 0 < undamped.first <= NUMBERED:  # few enough below: then they can be numbered
            undamped = undamped_modes(linear, undamped.first + len(undamped.squares))
        linear = undamped.linear
        energies = StrainEnergies(solver.system, state, linear)
        undamped = replace(undamped, shapes=energies.principal(undamped.shapes, undamped.squares))
        found = damped_modes(Pencil.of(solver.system, state, linear), undamped, wanted, target)
        real = np.abs(found.roots.imag) <= REAL * np.abs(found.roots)
        enough = not oscillating or np.count_nonzero(~real) >= count
        if enough or undamped.complete or wanted >= MOST_TRIED:
            break
        wanted *= 2
    # rigid motions first, as geometry has them
    rest = undamped.rigid.shape[1] if near is None and not oscillating else 0
    rigid = np.eye(len(undamped.rigid), linear.rigid)
    rigid = np.hstack([rigid, undamped.rigid[:, linear.rigid :]])[:, : min(rest, count)]
    chosen = np.flatnonzero(~real) if oscillating else np.arange(len(real))
    if target is not None:
        chosen = chosen[np.argsort(np.abs(found.natural[chosen] - target), kind="stable")]
    chosen = np.sort(chosen[: count - rigid.shape[1]])
    s = np.concatenate([np.zeros(rigid.shape[1], dtype=complex), found.roots[chosen]])
    size = np.abs(s)
    residuals = np.concatenate([np.zeros(rigid.shape[1]), found.residuals(chosen)])
    return ModesFound(
        eigenvalues=s,
        frequencies=size / (2.0 * np.pi),
        damping_ratios=np.divide(-s.real, size, out=np.zeros(len(s)), where=size > 0.0) + 0.0,
        residuals=residuals,
        rigid=rigid.shape[1],
        certified=undamped.certified and found.traced and bool((residuals < RESIDUAL).all()),
        show=partial(_shown, energies, solver.system.problem, state.copy(), undamped, found, rigid, chosen),
    )


def _shown(
    energies: StrainEnergies,
    problem: Problem,
    state: State,
    undamped: Undamped,
    found: DampedModes,
    rigid: Floats,
    chosen: np.ndarray,
) -> ModesShown:
    """Return what rigid motions ``(size, k)`` and the ``chosen`` ones of the damped modes look like."""
    linear = undamped.linear
    vectors = energies.principal(found.vectors, found.roots)
    kinds = energies.kinds(vectors)
    momenta = undamped.rigid.T @ (linear.mass @ vectors)
    creeping = np.linalg.norm(momenta, axis=0) ** 2 > 0.5 * energies.inertia(vectors)
    kinds = [DAMPER if slow else kind for kind, slow in zip(kinds, creeping, strict=True)]
    real = np.abs(found.roots.imag) <= REAL * np.abs(found.roots)
    names = numbered(kinds, real, from_first=undamped.first == 0)
    texts = [*linear.texts, *["free of stiffness"] * len(undamped.rigid.T)][: rigid.shape[1]]
    picked = vectors[:, chosen]
    every = np.hstack([rigid, picked])
    shapes, rotations = station_shapes(problem, state, linear.basis @ every)
    return ModesShown(
        shapes,
        rotations,
        StationReader(problem).read(state.r, state.q, np.zeros_like(state.twist))[0],
        (*texts, *(names[k] for k in chosen)),
        np.vstack([np.zeros((rigid.shape[1], 6)), energies.shares(picked)]),
    )


def station_shapes(problem: Problem, state: State, increments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return displacements (global axes) and rotations (body axes) of the stations, the largest component 1.

    Args:
        problem: whose stations they are; state: about which it moves.
        increments: body increments of the nodes ``(6 n, modes)``.
    """
    shapes, rotations = station_motions(problem, state, increments)
    for k, (shape, turn) in enumerate(zip(shapes, rotations, strict=True)):
        peak = _peak(shape)
        if np.abs(peak) < TWISTING * problem.length * np.abs(turn).max():
            peak = _peak(turn)
        if peak == 0.0:  # only bodies move
            peak = 1.0
        shapes[k], rotations[k] = shape / peak, turn / peak
    return shapes, rotations


def _peak(values: np.ndarray) -> complex:
    """Return the largest of some components, the first one of those that are alike: round-off says which is larger."""
    flat = values.ravel()
    size = np.abs(flat)
    return complex(flat[np.argmax(size >= (1.0 - ALIKE) * size.max())])


def station_motions(problem: Problem, state: State, increments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what :func:`station_shapes` does, not scaled."""
    reader = StationReader(problem)
    shapes = np.zeros((increments.shape[1], len(reader.nodes), 3), dtype=complex)
    rotations = np.zeros_like(shapes)
    for k, vector in enumerate(increments.T):
        parts = []
        for part in (vector.real, vector.imag):
            parts.append(reader.read(state.r, state.q, np.ascontiguousarray(part).reshape(-1, 6))[2:])
        shapes[k] = parts[0][0] + 1j * parts[1][0]
        rotations[k] = parts[0][1] + 1j * parts[1][1]
    return shapes, rotations
