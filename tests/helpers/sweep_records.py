"""What the folder of a sweep holds, as its writers left it."""

import json
from pathlib import Path
from typing import Any

__all__ = ["records_in"]


def records_in(folder: Path) -> list[dict[str, Any]]:
    """Return the records of all members in a sweep's folder, writer by writer.

    A line that a killed writer cut off has no end and is no record, wherever it was cut.
    """
    lines = [
        line
        for path in sorted((folder / "members").glob("*.jsonl"))
        for line in path.read_text().splitlines(keepends=True)
    ]
    return [json.loads(line) for line in lines if line.endswith("}\n")]
