"""``viscorod report``: the report of a result that is there already."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.terminal import readable_errors, told

__all__ = ["report"]


def report(
    result: Annotated[
        Path, typer.Argument(metavar="RESULT.nc", help="File, or folder of a run or of a sweep.")
    ],
) -> None:
    """Print the report of a stored result again."""
    with readable_errors():
        from viscorod.results.files.storage import load

        told(load(result))
