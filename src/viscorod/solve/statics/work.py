"""The work of small motions: a symmetric form that need not be a matrix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.typing import Floats

__all__ = ["Work", "matrix_form", "precise_form", "precise_works", "term_sizes"]

EPS = float(np.finfo(float).eps)
PRECISE = 1e-9
"""Part of the work of a motion from which on the rounding of a matrix spoils it."""


@dataclass(frozen=True)
class Work:
    """The symmetric form ``v.K v`` of motions.

    Attributes:
        form: of motions ``(size, k)``: their matrix ``(k, k)``, and for each the sum of the sizes of its terms
            ``(k,)``, of which one part in 1e16 is round-off.
    """

    form: Callable[[Floats], tuple[Floats, Floats]]

    def plus(self, matrix: sparse.csr_array, factor: float = 1.0) -> Work:
        """Return the form of ``K + factor matrix``."""

        def form(motions: Floats) -> tuple[Floats, Floats]:
            work, size = self.form(motions)
            added, its_size = matrix_form(matrix, motions)
            return work + factor * added, size + abs(factor) * its_size

        return Work(form)

    def within(self, basis: sparse.csr_array | sparse.csc_array) -> Work:
        """Return the form in other motions, whose columns ``basis`` are made of these."""
        return Work(lambda motions: self.form(np.asarray(basis @ motions)))


def term_sizes(matrix: sparse.csr_array, motions: Floats) -> Floats:
    """Return the sums of the sizes of the terms of ``v.K v`` of motions ``(k,)``, as :attr:`Work.form` does."""
    size = np.abs(motions)
    return np.asarray(np.einsum("ik,ik->k", size, abs(matrix) @ size))


def matrix_form(matrix: sparse.csr_array, motions: Floats) -> tuple[Floats, Floats]:
    """Return ``v.K v`` of motions as :attr:`Work.form` does, by a matrix ``K``."""
    work = np.asarray(motions.T @ (matrix @ motions))
    return 0.5 * (work + work.T), term_sizes(matrix, motions)


def precise_form(matrix: sparse.csr_array, work: Work | None, motions: Floats) -> Floats:
    """Return ``v.K v`` of motions ``(k, k)`` by a matrix, and by their ``work`` where its rounding spoils some."""
    form = np.asarray(motions.T @ (matrix @ motions))
    poor = _poor(matrix, work, motions, form.diagonal())
    if work is not None and poor.any():
        form[np.ix_(poor, poor)] = work.form(motions[:, poor])[0]
    return form


def precise_works(matrix: sparse.csr_array, work: Work | None, motions: Floats) -> Floats:
    """Return the diagonal of :func:`precise_form` alone ``(k,)``, which takes a product for each motion."""
    form = np.asarray(np.einsum("ik,ik->k", motions, matrix @ motions))
    poor = _poor(matrix, work, motions, form)
    if work is not None and poor.any():
        form[poor] = work.form(motions[:, poor])[0].diagonal()
    return form


def _poor(matrix: sparse.csr_array, work: Work | None, motions: Floats, works: Floats) -> np.ndarray:
    """Return which works ``v.K v`` of motions rounding spoils; none where nothing else tells them."""
    if work is None:
        return np.zeros(len(works), dtype=bool)
    return EPS * term_sizes(matrix, motions) > PRECISE * np.abs(works)
