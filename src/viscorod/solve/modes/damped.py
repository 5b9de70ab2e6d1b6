"""Damped modes from the undamped ones: a small quadratic eigenvalue problem whose solutions are refined.

Shapes of damped modes are combinations of undamped ones and of displacements under the viscous, following and branch
forces that these leave unbalanced (Ritz vectors). Where damping does not couple undamped modes each becomes a pair of
roots in closed form. Every pair is judged by its residual in the whole model, and refined where it is too large.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from viscorod.solve.modes.linearisation import EPS, unresisted
from viscorod.solve.modes.maxwell_modes import Pencil
from viscorod.solve.modes.undamped import Undamped
from viscorod.solve.statics.work import precise_form, precise_works, term_sizes
from viscorod.typing import Floats

CLASSICAL = 1e-8
"""Coupling of two undamped modes by damping, as a part of their own, that is round-off."""
GOOD, NOISE, ENOUGH = 1e-9, 5.0, 1e-4
"""Residuals that need no refinement, by themselves and over those of undamped modes, which are round-off; and those
that it can start from."""
MOST, EXTRA = 600, 4
"""Unknowns of the small problem, and undamped modes in it beside those that are asked for."""
ROUNDS = 4
"""How often Ritz vectors are added."""
CLOSE = 1e-6
"""Relative distance of frequencies below which modes are taken as one space, such as bending of a square section."""
BLOCK = 200_000
"""Numbers of the vectors that are looked at together."""
WEAK = 1e-8
"""Rate at which a rigid motion dies away, as a part of the slowest frequency, below which vibrations do not move it."""
REAL = 1e-9
"""Imaginary part, as a part of ``|s|``, below which a root is real."""
SLOW = 0.7
"""Part of the frequency of its shape without damping that ``|s|`` of a root that oscillates has at least: it is all of
it with symmetric matrices, and more with Maxwell branches. Round-off gives real roots that crowd an imaginary part."""


@dataclass(frozen=True)
class DampedModes:
    """Roots ``s`` [1/s] (Im >= 0) with their vectors ``(size, m)``, in order of natural frequency.

    Attributes:
        natural: angular frequencies [rad/s] by which they are ordered: ``|s|`` of those that oscillate, and of the
            others that of their shape without damping.
        strained: the parts of the vectors that have stiffness; the rest are rigid motions.
        unbalanced: :meth:`_Reduction.residuals`.
        traced: each is a pair of one undamped mode, or they are all that there are.
    """

    roots: np.ndarray
    vectors: np.ndarray
    natural: Floats
    strained: np.ndarray
    unbalanced: Callable[[np.ndarray, np.ndarray, np.ndarray], Floats]
    traced: bool

    def residuals(self, places: np.ndarray) -> Floats:
        """Return what some of them leave unbalanced: of all it takes longer than to find them."""
        return self.unbalanced(self.roots[places], self.vectors[:, places], self.strained[:, places])


def damped_modes(pencil: Pencil, undamped: Undamped, count: int, near: float | None = None) -> DampedModes:
    """Return the damped modes that belong to the undamped ones, without rigid motions.

    Args:
        pencil: the small motions; undamped: some of their modes without damping.
        count: how many are to be exact: the slowest, or those nearest to ``near`` [rad/s]. There may be more.
        near: angular frequency [rad/s].
    """
    reduction = _Reduction(pencil, undamped, count, near)
    for _ in range(ROUNDS):
        found = reduction.solve()
        wanted = _nearest(found, count, near)
        residuals = found.residuals(wanted)
        poor = residuals > reduction.good
        close = not poor.any() or residuals[poor].max() < ENOUGH
        if close or reduction.complete or not reduction.extend(found, wanted[poor]):
            break
    return _refined(reduction, found, wanted, residuals)


def _nearest(found: DampedModes, count: int, near: float | None) -> np.ndarray:
    """Return the places of the modes that are sought, nearest first."""
    if near is None:
        return np.arange(min(count, len(found.natural)))
    return np.argsort(np.abs(found.natural - near), kind="stable")[:count]


def _refined(reduction: _Reduction, found: DampedModes, wanted: np.ndarray, residuals: Floats) -> DampedModes:
    """Return the same with better roots of the modes that are sought where their residuals are not good."""
    if not (residuals > reduction.good).any():
        return found
    roots, vectors = found.roots.astype(complex), found.vectors.astype(complex)
    strained, improved = found.strained.astype(complex), False
    for k, residual in zip(wanted, residuals, strict=True):
        if not reduction.good < residual:
            continue
        better = reduction.pencil.refined(complex(roots[k]), vectors[:, k])
        if better is None:
            continue
        s, x = better
        others = np.delete(np.arange(len(roots)), k)
        # not one of the others, unless they were as near before
        if np.any(np.abs(roots[others] - s) < 0.1 * np.abs(roots[others] - roots[k])):
            continue
        if reduction.residuals(np.array([s]), x[:, None], x[:, None])[0] < residual:
            roots[k], vectors[:, k], strained[:, k], improved = s, x, x, True
    return _ordered(reduction, roots, vectors, strained) if improved else found


def _ordered(
    reduction: _Reduction,
    roots: np.ndarray,
    vectors: np.ndarray,
    strained: np.ndarray,
    own: Floats | None = None,
) -> DampedModes:
    """Return modes in their order; ``own`` are the frequencies of their shapes without damping, if they are known."""
    swinging = reduction.swinging(roots, vectors, own)
    roots = np.where(swinging, roots, roots.real)
    natural = np.abs(roots)
    natural[~swinging] = reduction.frequencies(vectors[:, ~swinging]) if own is None else own[~swinging]
    # round-off must not decide the order of equal ones, of which the slower root of an overdamped mode comes first
    order = np.lexsort((np.arange(len(roots)), _ranks(np.abs(roots)), _ranks(natural)))
    traced = reduction.single or reduction.complete
    ordered = vectors[:, order]
    resisting = ordered if strained is vectors else strained[:, order]
    return DampedModes(roots[order], ordered, natural[order], resisting, reduction.residuals, traced)


def _ranks(values: Floats) -> Floats:
    """Return the places of values in their order; those that are equal but for round-off have one place."""
    order = np.argsort(values, kind="stable")
    steps = np.diff(values[order]) > CLOSE * values[order][1:]
    ranks = np.zeros(len(values))
    ranks[order[1:]] = np.cumsum(steps)
    return ranks


class _Reduction:
    """The problem in a few undamped modes ``W`` (``W.M W = 1``, ``W.K W`` diagonal) and the rigid motions ``R``.

    Rigid motions are free of stiffness, so that only their velocities count; those that nothing damps take no part.
    """

    def __init__(self, pencil: Pencil, undamped: Undamped, count: int, near: float | None) -> None:
        self.pencil, self.undamped = pencil, undamped
        linear = pencil.linear
        self.K, self.D, self.M = linear.stiffness, linear.damping, linear.mass
        R = undamped.rigid
        if R.shape[1] and self.D.nnz:
            resting = unresisted(self.D, R)
            around, _ = scipy.linalg.qr(resting) if resting.shape[1] else (np.eye(R.shape[1]), None)
            self.R = self._damped(R @ around[:, resting.shape[1] :])
        else:
            self.R = R[:, :0]
        states = 2 + len(pencil.branches)
        most = max(MOST // states, count + EXTRA)
        natural = np.sqrt(np.abs(undamped.squares))
        kept = np.sort(np.argsort(natural if near is None else np.abs(natural - near), kind="stable")[:most])
        self.single = False
        self.complete = undamped.complete and len(kept) == len(natural)
        self.W, self.squares = undamped.shapes[:, kept], undamped.squares[kept]

    def _damped(self, motions: Floats) -> Floats:
        """Return those of rigid motions whose loss is more than the rounding of entries of the damping matrix.

        Neutral motions are found as vibrations are, to some digits: their strains are small but not zero. A damper on a
        lever of round-off has the square of that as a part of the fastest rate.
        """
        loss = precise_form(self.D, self.pencil.linear.loss, motions)
        inertia = self.M.diagonal()
        fastest = (self.D.diagonal()[inertia > 0.0] / inertia[inertia > 0.0]).max(initial=0.0)
        noise = EPS * term_sizes(self.D, motions) + (10.0 * EPS) ** 2 * fastest
        noise = np.sqrt(noise[:, None] * noise)
        parts = np.divide(loss, noise, out=np.zeros_like(loss), where=noise > 0.0)
        values, turn = np.linalg.eigh(0.5 * (parts + parts.T))
        return np.asarray(motions @ turn[:, values > 1.0])

    @cached_property
    def good(self) -> float:
        """Largest residual that needs no refinement."""
        W, squares = self.W, self.squares
        left = 0.5 * (self.K + self.K.T) @ W - squares * (self.M @ W)
        moved = self.undamped.flexibility(left)
        left_over = np.sqrt(np.maximum(np.einsum("ik,ik->k", moved, self.M @ moved), 0.0))
        return max(GOOD, NOISE * float(left_over.max(initial=0.0)))

    def _blocks(self, vectors: np.ndarray) -> list[slice]:
        """Return parts of many vectors that are small in memory."""
        size, count = vectors.shape
        most = max(1, BLOCK // size)
        return [slice(k, k + most) for k in range(0, count, most)]

    def residuals(self, roots: np.ndarray, vectors: np.ndarray, strained: np.ndarray) -> Floats:
        """Return what roots and their vectors leave unbalanced as a part of the largest of the forces that balance.

        The part ``strained`` of vectors has stiffness, the rest are rigid motions, whose stiffness is round-off.

        Forces are measured by the displacements (by their kinetic energy) that they would cause, or, where all modes
        are known and that is less, by the accelerations. Without damping it is a bound of the relative error of
        ``w^2``.
        """
        M, found = self.M, np.full(len(roots), np.inf)
        measures = [self.undamped.flexibility]
        if self.undamped.complete:
            measures.append(self.undamped.accelerations)
        for block in self._blocks(vectors):
            s, x = roots[block], vectors[:, block]
            elastic = self.K @ strained[:, block]
            left = self.pencil.applied(s, x) - self.K @ (x - strained[:, block])
            parts = np.hstack([left, s**2 * (M @ x), s * (self.D @ x) + 0.0 * x, elastic])
            for measure in measures:
                moved = measure(parts)
                squares = np.einsum("ik,ik->k", moved.conj(), M @ moved).real
                sizes = np.sqrt(np.maximum(squares, 0.0)).reshape(4, -1)
                largest = sizes[1:].max(axis=0)
                part = np.divide(sizes[0], largest, out=np.zeros_like(largest), where=largest > 0.0)
                found[block] = np.minimum(found[block], part)
        return found

    def frequencies(self, vectors: np.ndarray) -> Floats:
        """Return the angular frequencies [rad/s] of shapes without damping (Rayleigh quotients)."""
        found = np.empty(vectors.shape[1])
        for block in self._blocks(vectors):
            x = vectors[:, block]
            parts = np.hstack([x.real, x.imag]) if x.imag.any() else x.real
            energies = (
                precise_works(self.K, self.pencil.linear.work, parts).reshape(-1, x.shape[1]).sum(axis=0)
            )
            found[block] = np.sqrt(np.abs(energies) / np.einsum("ik,ik->k", x.conj(), self.M @ x).real)
        return found

    def swinging(self, roots: np.ndarray, vectors: np.ndarray, own: Floats | None = None) -> np.ndarray:
        """Return which roots oscillate, by an imaginary part that is not round-off; ``own`` as in `_ordered`."""
        found: np.ndarray = np.abs(roots.imag) > REAL * np.abs(roots)
        some = np.flatnonzero(found)
        of_shapes = self.frequencies(vectors[:, some]) if own is None else own[some]
        found[some] = np.abs(roots[some]) >= SLOW * of_shapes
        return found

    def solve(self) -> DampedModes:
        """Return all roots of the small problem with their residuals in the whole one."""
        W, R = self.W, self.R
        V, p = np.hstack([R, W]), R.shape[1]
        D = precise_form(self.D, self.pencil.linear.loss, V)
        own = np.sqrt(np.abs(self.squares))
        K = V.T @ (self.K @ W)
        K[p:] -= np.diag(self.squares)  # what is not symmetric
        noise = np.einsum("ik,ik->k", np.abs(V), abs(self.K) @ np.abs(V))
        noise = 1e2 * EPS * np.sqrt(noise[:, None] * noise[p:])
        noise[p:] += CLASSICAL * own[:, None] * own
        K[np.abs(K) <= noise] = 0.0
        self.single = p == 0 and not self.pencil.branches and not K.any() and _diagonal(D)
        if self.single:
            roots, each = _single_roots(np.diag(D), self.squares)
            vectors = W[:, each].astype(complex)
            return _ordered(self, roots, vectors, vectors, own[each])
        K[p:] += np.diag(self.squares)
        if self.pencil.branches:
            roots, states = self._branch_roots(D, K, own)
            swings = self.swinging(roots, V @ np.vstack([states[:p] / roots, states[p:]]))
            roots, states = roots[swings], states[:, swings]
        else:
            roots, states = _inverse_roots(D, K, own) if D.any() else _undamped_roots(K, own)
        displacements = np.vstack([states[:p] / roots, states[p:]])
        vectors = V @ displacements
        return _ordered(self, roots, vectors, W @ displacements[p:] if p else vectors)

    def _branch_roots(self, D: Floats, K: Floats, own: Floats) -> tuple[np.ndarray, np.ndarray]:
        """Return the roots that oscillate with the strains of the springs of all branches as further unknowns.

        With ``w_j``, the displacement less that of the dashpots, ``w_j' = v - w_j/tau_j``; branches exert ``K_j w_j``.
        """
        m, p = len(own), len(D) - len(own)
        n, times, W = p + m, self.pencil.times, self.W
        A = np.zeros((n + m * (1 + len(times)),) * 2)
        A[:n, :n] = -D
        A[:n, n : n + m] = -K / own
        A[n : n + m, p:n] = np.diag(own)
        for j, (branch, tau) in enumerate(zip(self.pencil.branches, times, strict=True), 1):
            mine = slice(n + m * j, n + m * (j + 1))
            A[p:n, mine] = -(W.T @ (branch @ W)) / own
            A[mine, p:n] = np.diag(own)
            A[mine, mine] = -np.eye(m) / tau
        s, z = np.linalg.eig(A)
        swinging = s.imag > REAL * np.abs(s)
        return s[swinging], np.vstack([z[:p], z[n : n + m] / own[:, None]])[:, swinging]

    def extend(self, found: DampedModes, poor: np.ndarray) -> bool:
        """Add the displacements under the forces that some roots leave unbalanced; return False if there are none."""
        left = np.array([self.pencil.applied(found.roots[k], found.vectors[:, k]) for k in poor]).T
        moved = self.undamped.flexibility(left)
        parts = np.hstack([moved.real, moved.imag])
        for _ in range(2):
            parts = parts - self.W @ (self.W.T @ (self.M @ parts))
            size = np.sqrt(np.maximum(np.einsum("ik,ik->k", parts, self.M @ parts), 0.0))
            parts = parts[:, size > 0.0] / size[size > 0.0]
        if not parts.shape[1]:
            return False
        values, turn = np.linalg.eigh(parts.T @ (self.M @ parts))
        kept = values > 1e-6 * values[-1]
        W = np.hstack([self.W, parts @ (turn[:, kept] / np.sqrt(values[kept]))])
        K, M = W.T @ (self.K @ W), W.T @ (self.M @ W)
        self.squares, turn = scipy.linalg.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
        self.W = W @ turn
        return True


def _diagonal(D: Floats) -> bool:
    """Return whether damping does not couple undamped modes."""
    size = np.sqrt(np.abs(np.diag(D)))
    return bool(np.all(np.abs(D - np.diag(np.diag(D))) <= CLASSICAL * size[:, None] * size))


def _single_roots(damping: Floats, squares: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return the roots of ``s^2 + d s + w^2`` of every mode, one of a pair, and the number of the mode of each."""
    half = 0.5 * damping
    inside = half**2 - squares
    swinging = inside < 0.0
    roots = -half[swinging] + 1j * np.sqrt(-inside[swinging])
    fast = half[~swinging] + np.sqrt(inside[~swinging])
    found = np.concatenate([roots, -squares[~swinging] / fast, -fast])
    return found, np.concatenate([np.flatnonzero(swinging), *[np.flatnonzero(~swinging)] * 2])


def _inverse_roots(D: Floats, K: Floats, own: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return one root of each pair and its state ``(velocities of rigid motions, displacements of the others)``.

    Eigenvalues ``1/s`` of the inverse of ``z' = A z`` for the velocities and displacements times ``w``, so that slow
    roots are accurate beside fast ones.

    Args:
        D: of rigid motions and the others; K: forces on both by displacements of the others; own: ``w`` of these.
    """
    m, p = len(own), len(D) - len(own)
    slow, turn = np.linalg.eigh(D[:p, :p])
    weak = slow < WEAK * own.min(initial=np.inf)
    if weak.any():  # they move by themselves; 1/s of the others would be lost beside theirs
        around = scipy.linalg.block_diag(turn[:, ~weak], np.eye(m))
        s, states = _inverse_roots(around.T @ D @ around, around.T @ K, own)
        alone = np.vstack([turn[:, weak], np.zeros((m, int(weak.sum())))])
        return np.append(s, -slow[weak]), np.hstack([around @ states, alone])
    n = p + m
    rows = np.concatenate([np.ones(p), 1.0 / own])[:, None]
    left = np.hstack([rows * D[:, :p], rows * K / own])
    inverse = np.zeros((n + m, n + m))
    inverse[p:n, n:] = np.diag(1.0 / own)
    right = -rows * np.hstack([np.eye(n), D[:, p:] / own])
    found = np.linalg.solve(left, right)
    inverse[:p], inverse[n:] = found[:p], found[p:]
    theta, z = np.linalg.eig(inverse)
    kept = (np.abs(theta) > 1e-15 * np.abs(theta).max()) & (theta.imag <= REAL * np.abs(theta))
    s, z = 1.0 / theta[kept], z[:, kept]
    s = np.where(np.abs(s.imag) <= REAL * np.abs(s), s.real, s)
    return s, np.vstack([z[:p], z[n:] / own[:, None]])


def _undamped_roots(K: Floats, own: Floats) -> tuple[np.ndarray, np.ndarray]:
    """Return the roots of ``s^2 + K`` with their displacements: exactly imaginary, real or in pairs that flutter."""
    inverse, y = np.linalg.eig(np.linalg.inv(K / own / own[:, None]) / own / own[:, None])
    squares = 1.0 / inverse
    real = np.abs(squares.imag) <= CLASSICAL * np.abs(squares)
    root = np.sqrt(-np.where(real, squares.real, squares).astype(complex))
    root = np.where(root.imag < 0.0, -root, root)
    # the other sign of real ones, and the mirror image of those that flutter, of which one of two squares is taken
    other = (np.abs(root.imag) == 0.0) | ~real
    mirrored = np.where(real, -root, -root.conj())[other & (real | (squares.imag > 0.0))]
    kept = real | (squares.imag > 0.0)
    vectors = np.hstack([y[:, kept], y.conj()[:, other & kept]])
    return np.concatenate([root[kept], mirrored]), vectors
