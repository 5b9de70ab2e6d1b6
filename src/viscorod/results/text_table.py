"""Tables as plain text, which terminals, logs and documents all show alike."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(title: str, header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table: the title, then indented columns, names to the left and numbers to the right."""
    widths = [max(len(row[k]) for row in (header, *rows)) for k in range(len(header))]
    lines = [title]
    for row in (header, *rows):
        numbers = (cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True))
        lines.append("  " + "  ".join([row[0].ljust(widths[0]), *numbers]).rstrip())
    return "\n".join(lines)


def listed(heading: str, sentences: Iterable[str]) -> str:
    """Return sentences in a list below a heading."""
    return "\n".join([heading, *(f"  - {text}" for text in sentences)])
