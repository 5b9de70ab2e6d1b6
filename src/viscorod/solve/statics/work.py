"""The work of small motions: a symmetric form that need not be a matrix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from viscorod.typing import Floats

__all__ = ["Work", "matrix_form", "precise_form"]

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


def matrix_form(matrix: sparse.csr_array, motions: Floats) -> tuple[Floats, Floats]:
    """Return ``v.K v`` of motions as :attr:`Work.form` does, by a matrix ``K``."""
    work = np.asarray(motions.T @ (matrix @ motions))
    size = np.einsum("ik,ik->k", np.abs(motions), np.asarray(abs(matrix) @ np.abs(motions)))
    return 0.5 * (work + work.T), size


def precise_form(matrix: sparse.csr_array, work: Work | None, motions: Floats) -> Floats:
    """Return ``v.K v`` of motions ``(k, k)`` by a matrix, and by their ``work`` where its rounding spoils some."""
    form = np.asarray(motions.T @ (matrix @ motions))
    if work is None:
        return form
    _, size = matrix_form(matrix, motions)
    poor = EPS * size > PRECISE * np.abs(form.diagonal())
    if poor.any():
        form[np.ix_(poor, poor)] = work.form(motions[:, poor])[0]
    return form
