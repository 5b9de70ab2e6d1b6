"""Rows and blocks of numbers, copied and cleared within compiled code."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import exact_part
from viscorod.typing import Floats

__all__ = ["clear", "clear_blocks", "copy", "copy_blocks"]


@exact_part
def clear(rows: Floats) -> None:
    """Set rows to zero."""
    for k in range(rows.shape[0]):
        for i in range(rows.shape[1]):
            rows[k, i] = 0.0


@exact_part
def clear_blocks(blocks: Floats) -> None:
    """Set blocks to zero."""
    for s in range(blocks.shape[0]):
        for i in range(blocks.shape[1]):
            for j in range(blocks.shape[2]):
                blocks[s, i, j] = 0.0


@exact_part
def copy_blocks(a: Floats, b: Floats) -> None:
    """Copy blocks."""
    for s in range(a.shape[0]):
        for i in range(a.shape[1]):
            for j in range(a.shape[2]):
                b[s, i, j] = a[s, i, j]


@exact_part
def copy(a: Floats, b: Floats) -> None:
    """Copy rows."""
    for k in range(a.shape[0]):
        for i in range(a.shape[1]):
            b[k, i] = a[k, i]
