"""Pictures that results write."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure


def written(plot: Callable[..., Any], path: Path, *arguments: Any) -> Path:
    """Write the picture of a result, by its method; return the path. The method returns the figure."""
    assert isinstance(plot(path, *arguments), Figure)
    return path
