"""The error of a factorisation that meets a singular matrix."""

from __future__ import annotations


class SingularMatrixError(ArithmeticError):
    """The factorisation met a zero pivot; ``row`` is the unknown it belongs to, as nodes are numbered."""

    def __init__(self, row: int) -> None:
        super().__init__(f"zero pivot at unknown {row}")
        self.row = row
