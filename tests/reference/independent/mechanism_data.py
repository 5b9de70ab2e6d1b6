"""Read the tables of mechanisms."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .galerkin import Array


def table(name: str) -> dict[str, Array]:
    """Columns of a table by their names."""
    lines = (Path(__file__).parents[1] / "data" / f"{name}.csv").read_text().splitlines()
    head, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    return dict(zip(head, np.array(rows, dtype=float).T, strict=True))
