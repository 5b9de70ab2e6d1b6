"""First guesses of steady rotations: the reference shape about an axis, or bent in its slowest elastic mode."""

from __future__ import annotations

import numpy as np

from viscorod.mechanics.elements.internal_force import Elements
from viscorod.solve.formulations.system import State
from viscorod.solve.modes.linearisation import linearise
from viscorod.solve.modes.undamped import undamped_modes
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.static_solver import StaticSolver
from viscorod.solve.steady.rigid_rotation import inertia_about
from viscorod.solve.steady.steady_poses import integrate_poses
from viscorod.solve.steady.strain_rates import StrainRates
from viscorod.typing import Floats

TRIED = 20
"""Modes among which the slowest one that bends is sought."""
DEFLECTION = 0.02
"""Largest displacement of the bent guess, in lengths of the model."""


def principal_axis(problem: Problem, state: State, centre: Floats) -> Floats:
    """Return the principal axis of the least inertia about ``centre``, global axes ``(3,)``."""
    _, vectors = np.linalg.eigh(inertia_about(problem.mass, state.r, state.q, centre))
    axis: Floats = vectors[:, 0]
    # towards the positive of its largest component
    return axis * float(np.sign(axis[np.argmax(np.abs(axis))]))


def bent_shape(
    solver: StaticSolver, problem: Problem, elements: Elements, root: int, way: float
) -> tuple[State, Floats, float, float]:
    """Return a rod bent in its slowest elastic bending mode.

    The strains of the mode are laid out from the node ``root`` on: displaced nodes would stretch the rod, which is
    stiff against that. ``way``, 1 or -1, is that of the bending.

    Returns:
        poses, strains ``(e, points, 6)``, frequency [rad/s] and elastic energy [J] of the mode.
    """
    state = State.reference(problem)
    linear = linearise(solver, state, scale=0.0)
    found = undamped_modes(linear, TRIED)
    for k in range(len(found.squares)):
        shape = (found.linear.basis @ found.shapes[:, k]).reshape(-1, 6)
        moved = np.abs(shape[:, :3]).max()
        if moved > 0.05 * problem.length * np.abs(shape[:, 3:]).max():  # not one of pure twisting
            break
    amplitude = way * DEFLECTION * problem.length / moved
    rates = StrainRates(elements, problem.size)
    strain = np.zeros_like(elements.reference)
    strain[rates.used] = amplitude * (rates.unstrained @ shape.ravel())
    r, q = integrate_poses(problem, elements, strain, root, state.r[root], state.q[root])
    bent = State(r, q, np.zeros((problem.size, 6)))
    return bent, strain, float(np.sqrt(found.squares[k])), float(0.5 * found.squares[k] * amplitude**2)
