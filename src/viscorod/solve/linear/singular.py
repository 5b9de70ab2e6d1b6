"""What a factorisation says of a matrix that has no inverse."""

from __future__ import annotations


class SingularMatrixError(ArithmeticError):
    """The factorisation met a zero pivot; ``row`` is the unknown it belongs to, as nodes are numbered."""

    def __init__(self, row: int) -> None:
        super().__init__(f"zero pivot at unknown {row}")
        self.row = row
