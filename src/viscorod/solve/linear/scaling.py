"""A matrix of blocks in other units of its unknowns."""

from __future__ import annotations

from viscorod.mechanics.compilation.compiled import kernel
from viscorod.typing import Floats, Integers


@kernel
def scale_blocks(rows: Integers, columns: Integers, scales: Floats, blocks: Floats) -> None:
    """Multiply the rows and columns of a matrix by ``scales (6 N,)``; ``rows, columns`` are those of its pattern."""
    for s in range(blocks.shape[0]):
        for j in range(6):
            for i in range(6):
                blocks[s, j, i] *= scales[6 * rows[s] + i] * scales[6 * columns[s] + j]
