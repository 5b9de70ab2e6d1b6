"""Free motions in which the reference shape is near no equilibrium: what loads do not keep in place."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.free_motion import FreeMotion
from viscorod.solve.constraints.null_space import unit_rows
from viscorod.solve.constraints.parts import Parts, held_motions
from viscorod.solve.linear.sparse_lu import SparseLU
from viscorod.solve.problem.problem import Problem
from viscorod.solve.statics.tangent import Tangent, negative_eigenvalues
from viscorod.typing import Floats

__all__ = ["undetermined", "undetermined_of_many"]

RESISTED = 1e-6
"""Stiffness against a motion, as a part of all forces over the length, from which on loads resist it."""
ROUND_OFF = 1e-8
"""The same for one translation, as a part of what adds up to it, that is no more than rounding."""


def undetermined(
    problem: Problem, external: Floats, stiffness: sparse.csc_array, motions: list[FreeMotion]
) -> list[FreeMotion]:
    """Return the free motions to be named because no equilibrium is near the reference shape; none if there is one.

    Loads keep a motion in place if they do no work on it and their tangent resists it: a pendulum that hangs. If they
    drive one motion, all free ones are named.

    Args:
        problem: of the motions.
        external: external forces in the reference shape, body components ``(n, 6)``.
        stiffness: tangent there, loads included, before supports ``(6 n, 6 n)``.
        motions: from :func:`free_motions`.
    """
    if any(load.law.at_rest for load in problem.motion_loads):  # such as a foundation
        motions = [m for m in motions if not (m.translation and _resisted(m, stiffness))]
    if not motions:
        return []
    force = _whole(problem, external)
    driven = [
        m for m in motions if m.translation or abs(np.sum(m.increments * external)) > 1e-9 * force * m.size
    ]
    if driven or force == 0.0:
        return motions
    basis = np.array([m.increments.ravel() / m.size for m in motions]).T
    values, vectors = np.linalg.eigh(basis.T @ (stiffness + stiffness.T) @ basis / 2.0)
    loose = values < RESISTED * force / problem.length
    share = np.abs(vectors[:, loose]).max(axis=1, initial=0.0)
    return [m for m, part in zip(motions, share, strict=True) if part > 0.1]


def undetermined_of_many(
    problem: Problem, external: Floats, stiffness: sparse.csc_array
) -> list[FreeMotion] | None:
    """Return what :func:`undetermined` does without finding single motions: for models of very many joined parts.

    Loads keep them in place if they do no work on motions that supports and joints allow, and their tangent resists
    all of these. Springs count as no conditions here; they are in the stiffness. The work is that of the part of the
    forces on parts that conditions do not balance, and by Sylvester's law ``[[K - k 1, A'], [A, 0]]`` has as many
    negative pivots as conditions ``A`` where every motion allowed is stiffer than ``k``.

    Args:
        problem, external, stiffness: see :func:`undetermined`.

    Returns:
        none if loads keep all in place; one that stands for all, where some are left and none is a translation; None
        where that is not known.
    """
    r, q = problem.positions, problem.quaternions
    parts, joints = Parts.of(problem, r, q), problem.joints
    gradients = joints.measure(r, q, np.zeros((problem.size, 6)))[2]
    A = parts.condition_matrix(
        parts.conditions(held_motions(problem, parts.R), gradients, joints.arrays.place >= 0)
    )
    force, first, size = _whole(problem, external), A.shape[0], A.shape[1]
    if force == 0.0 or not first:
        return None
    still = sparse.csr_array(A[:, np.flatnonzero(np.arange(size) % 6 < 3)])
    moved = sparse.csr_array(still.T @ still - 1e-12 * sparse.eye_array(size // 2))
    if negative_eigenvalues(Tangent(moved, sparse.csc_array(moved), None)):
        return None  # a translation is free
    text = f"motions of {parts.count} joined parts against each other, which are too many to be listed"
    loose = [FreeMotion(text, False, np.zeros((problem.size, 6)))]
    T = parts.moves()
    pushed = np.asarray(T.T @ external.ravel())
    K = sparse.csr_array(0.5 * (T.T @ (stiffness + stiffness.T) @ T))
    try:
        balance = SparseLU(sparse.block_array([[sparse.eye_array(size), A.T], [A, None]]))
    except RuntimeError:
        return loose
    left = balance.solve(np.concatenate([pushed, np.zeros(first)]))[:size]
    if not np.abs(left).max() <= 1e-9 * force:
        return loose
    least = RESISTED * force / problem.length
    tangent = Tangent(
        sparse.csr_array(K - least * sparse.eye_array(size)),
        sparse.csc_array(T),
        unit_rows(A),
    )
    return loose if negative_eigenvalues(tangent) else []


def _whole(problem: Problem, external: Floats) -> float:
    """Return the sum of all forces, and of all moments over the length of the model [N]."""
    return float(np.abs(external[:, :3]).sum()) + float(np.abs(external[:, 3:]).sum()) / problem.length


def _resisted(motion: FreeMotion, stiffness: sparse.csc_array) -> bool:
    """Return whether a stiffness resists a motion by more than round-off."""
    x = motion.increments.ravel()
    return bool(x @ (stiffness @ x) > ROUND_OFF * (np.abs(x) @ (abs(stiffness) @ np.abs(x))))
