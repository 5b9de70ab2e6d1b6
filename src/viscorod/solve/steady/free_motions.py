"""Small motions that supports, joints and held strains leave free, as a basis with a left inverse."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from scipy import sparse

from viscorod.solve.constraints.null_space import null_space, unit_rows
from viscorod.solve.constraints.support_state import SupportState
from viscorod.solve.formulations.system import State
from viscorod.typing import Floats

__all__ = ["FreeMotions"]


@dataclass(frozen=True)
class FreeMotions:
    """Motions that supports allow, those of them that fulfil further conditions, and how to find them in increments.

    Attributes:
        supported: the motions that supports allow as body increments of the nodes ``(6 n, supported)``.
        conditions: gradients of the conditions on them, of unit length; None without.
        basis: the motions that fulfil both ``(6 n, free)``; inverse: a left inverse of it ``(free, 6 n)``.
    """

    supported: sparse.csr_array
    conditions: sparse.csr_array | None
    basis: sparse.csr_array
    inverse: sparse.csr_array

    @classmethod
    def of(
        cls, supports: SupportState, state: State, unit: Floats, gradients: sparse.csr_array | None
    ) -> Self:
        """Return them at a state.

        Args:
            unit: of every motion that supports allow; gradients: of conditions by body increments ``(rows, 6 n)``.
        """
        supported = sparse.csr_array(supports.free_basis(state) @ sparse.diags_array(unit))
        inverse = _inverse(supported, supports.free_rows())
        if gradients is None:
            return cls(supported, None, supported, inverse)
        conditions = unit_rows(sparse.csr_array(gradients @ supported))
        allowed = sparse.csr_array(null_space(conditions))
        basis = sparse.csr_array(supported @ allowed)
        return cls(supported, conditions, basis, sparse.csr_array(allowed.T @ inverse))


def _inverse(basis: sparse.csr_array, rows: np.ndarray) -> sparse.csr_array:
    """Return the pseudo-inverse of free motions ``(6 n, free)``, each of one node; ``rows`` are theirs."""
    gram = sparse.csr_array(basis.T @ basis)
    inverse = sparse.lil_array(sparse.diags_array(1.0 / gram.diagonal()))
    coupled = sparse.coo_array(gram - sparse.diags_array(gram.diagonal()))
    for node in np.unique(rows[coupled.row[coupled.data != 0.0]] // 6):
        mine = np.flatnonzero(rows // 6 == node)
        inverse[np.ix_(mine, mine)] = np.linalg.inv(gram[mine][:, mine].toarray())
    return sparse.csr_array(inverse.tocsr() @ basis.T)
