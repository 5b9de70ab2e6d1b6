"""Tables as Parquet files, which keep types and have a text of their own about what they are."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viscorod.errors import InputError, let_interrupts_through
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["read_parquet", "write_parquet"]

_ABOUT = b"viscorod"
_MISSING = "Parquet files need pyarrow, which is not there; type: pip install 'viscorod[store]'"


def write_parquet(table: pd.DataFrame, about: Mapping[str, Any], path: str | Path) -> Path:
    """Write a table and what it says of itself; returns the path.

    Raises:
        InputError: pyarrow is not installed, or the place cannot be written.
    """
    arrow, parquet = _pyarrow()
    written = arrow.Table.from_pandas(table)
    written = written.replace_schema_metadata({**written.schema.metadata, _ABOUT: json.dumps(about)})
    with replacing(path, needs=written.nbytes) as new:
        parquet.write_table(written, new)
    return Path(path)


def read_parquet(path: str | Path) -> tuple[pd.DataFrame, dict[str, Any]]:
    """Return the table of a file that ``write_parquet`` wrote, and what it says of itself.

    Raises:
        InputError: pyarrow is not installed, or this is no such file or a damaged one.
    """
    _, parquet = _pyarrow()
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path} is not a file")
    try:
        found = parquet.read_table(path)
        about = json.loads((found.schema.metadata or {})[_ABOUT])
        table = found.to_pandas()
    except Exception as error:  # a damaged file brings out errors of every kind
        let_interrupts_through(error)
        why = " ".join(str(error).split())[:120] or type(error).__name__
        raise InputError(
            f"{path} is no table that viscorod wrote, or a damaged one ({why}); take another copy of it"
        ) from None
    return table, about if isinstance(about, dict) else {}


def _pyarrow() -> tuple[Any, Any]:
    try:
        return import_module("pyarrow"), import_module("pyarrow.parquet")
    except ImportError:
        raise InputError(_MISSING) from None
