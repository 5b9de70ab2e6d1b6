"""Linear buckling: load factors at which the stiffness vanishes if it changed as it does at one state.

With the tangent ``K`` at an equilibrium and its derivative ``K'`` by the load factor, critical factors ``f`` and shapes
solve ``(K + (f - f_0) K') x = 0``. The derivative is that of the classical theory: what the section forces of the
linear solution, those of joints and springs and the turning of loads make in the shape of the equilibrium. The
displacements of that solution are left out: to first order they turn stiff directions towards weak ones, which takes
stiffness that the second order gives back. A twisted shaft or a bent strip would seem to buckle at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
from scipy import sparse

from viscorod.mechanics.rotations.rotation import retract
from viscorod.solve.formulations.system import State
from viscorod.solve.linear.singular import SingularMatrixError
from viscorod.solve.linear.sparse_lu import solver_within
from viscorod.solve.statics.arc_length import ArcLength
from viscorod.solve.statics.tangent import Tangent
from viscorod.typing import Floats, Integers

__all__ = ["critical_factors"]

MOVED = 1e-3
"""Displacement (over the model's length) or rotation [rad] by which the tangent is differenced, to both sides."""
CRUSHED = -0.5
"""Strain of stretch beyond which a linear solution means nothing."""
FULL = 400
"""Motions up to which all factors are computed."""
REAL = 1e-6
"""Imaginary part of a factor, as a part of its size, that is round-off."""


def critical_factors(path: ArcLength, state: State, factor: float, count: int) -> tuple[Floats, Floats]:
    """Return critical load factors beyond ``factor``, the nearest first, and their shapes.

    Args:
        path: the equations of equilibrium, with the unit of the load factor.
        state: the equilibrium at ``factor``.
        count: of factors at most.

    Returns:
        factors ``(k,)``; body increments of the nodes ``(6 n, k)``.

    Raises:
        SingularMatrixError: the state is critical itself.
    """
    tangent = path.static.tangent(state, path.t, before=path.before, scale=factor)
    size = int(tangent.stiffness.shape[0])
    try:
        solve = solver_within(tangent.stiffness, tangent.gradients)
    except RuntimeError as error:
        raise SingularMatrixError(0) from error
    slope, per_factor = _slope(path, state, factor)

    def apply(x: Floats) -> Floats:
        return -solve(np.asarray(slope @ x))

    values, motions = _largest(apply, size, 2 * count + 4)
    # values are 1/(f - f_0): complex ones belong to loads that may only bring about flutter
    real = (np.abs(values.imag) <= REAL * np.abs(values)) & (values.real > 0.0)
    above = np.flatnonzero(real & (values.real > 1e-12 * np.abs(values).max(initial=0.0)))
    order = above[np.argsort(-values[above].real, kind="stable")][:count]
    beyond = [float(value) for value in 1.0 / values[order].real]
    order = order[[not _crushes(path, state, distance * per_factor) for distance in beyond]]
    return factor + 1.0 / values[order].real, np.asarray(tangent.basis @ motions[:, order].real)


def _crushes(path: ArcLength, state: State, gone: Floats) -> bool:
    """Return whether increments press rods together so much that no law of elasticity is meant for it."""
    system, there = path.static.system, state.copy()
    retract(there.r, there.q, gone, there.r, there.q)
    path.static.restore(there, path.t, before=path.before, scale=0.0)
    return bool(system.gauss_points().strain[:, 2].min() < CRUSHED)


def _slope(path: ArcLength, state: State, factor: float) -> tuple[sparse.csr_array, Floats]:
    """Return the derivative of the tangent stiffness by the load factor, in the same shape; and the linear solution.

    Forces of springs that are Python functions stay as they are.
    """
    static, system = path.static, path.static.system
    _, per_factor = path.solve(state, factor)
    multiplier = system.multiplier_change(per_factor)  # in units of this assembly
    moved = np.sqrt(path.shape(per_factor[: system.problem.size]))
    change = min(path.unit, MOVED / max(moved, 1e-300))

    gradients = system.constraints.measure(state)[2]
    lengthened = nodal_products(system.constraints.arrays.nodes, gradients, per_factor[: system.problem.size])
    rest = system.constraints.arrays.rest
    as_given = rest.copy()

    def tangent_at(distance: float) -> Tangent:
        # with the rest strains of there: what heat or a muscle makes in a shape that does not move
        static.restore(state, path.t, before=path.before, scale=factor + distance)
        there = state.copy()
        system.carry_stress(distance * per_factor)
        there.multiplier += distance * multiplier
        rest[:] = as_given - distance * lengthened
        try:
            return static.tangent_here(there, path.t, before=path.before, scale=factor + distance)
        finally:
            rest[:] = as_given

    after, before = tangent_at(change), tangent_at(-change)
    return sparse.csr_array((after.stiffness - before.stiffness) / (2.0 * change)), per_factor


def nodal_products(nodes: Integers, gradients: Floats, increments: Floats) -> Floats:
    """Return the changes of coordinates ``(c,)`` with ``gradients (c, 12)`` by increments ``(n, 6)`` of the nodes."""
    reached = np.where((nodes >= 0)[:, :, None], increments[nodes], 0.0)
    return np.asarray(np.einsum("ck,ck->c", gradients, reached.reshape(len(nodes), 12)))


def _largest(apply: Callable[[Floats], Floats], size: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest eigenvalues of an operator and their vectors."""
    import scipy.sparse.linalg as spla

    if size <= FULL or count >= size - 2:
        values, motions = scipy.linalg.eig(apply(np.eye(size)))
        return np.asarray(values), np.asarray(motions)
    operator = spla.LinearOperator((size, size), matvec=apply, dtype=float)
    start = apply(np.random.default_rng(1).standard_normal(size))
    try:
        values, motions = spla.eigs(operator, count, v0=start, tol=1e-10)
    except spla.ArpackNoConvergence as error:
        values, motions = error.eigenvalues, error.eigenvectors
    return np.asarray(values), np.asarray(motions)
