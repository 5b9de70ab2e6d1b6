"""What a direct solver of block matrices offers, and how it fails."""

from __future__ import annotations

from typing import Protocol

from viscorod.typing import Floats


class SingularMatrixError(ArithmeticError):
    """The factorisation met a zero pivot; ``row`` is the unknown it belongs to, as nodes are numbered."""

    def __init__(self, row: int) -> None:
        super().__init__(f"zero pivot at unknown {row}")
        self.row = row


class Solver(Protocol):
    """Factorises matrices of one pattern with ``N`` block rows, real or complex, in an order of its own."""

    @property
    def description(self) -> str:
        """What it does, for reports."""

    def factorise(self, blocks: Floats) -> None:
        """Factorise the matrix with the values ``blocks (b, 6, 6)``, which stay as they are.

        Raises:
            SingularMatrixError: a pivot is exactly zero.
        """

    def solve(self, b: Floats) -> None:
        """Solve with the factors in place; ``b (6 N,)`` or ``(N, 6)``, contiguous and of the type of the matrix."""
