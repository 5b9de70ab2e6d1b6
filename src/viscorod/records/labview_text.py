"""Measurement files of LabVIEW (.lvm) as tables: heads, segments, and times that are not written.

A file has one head and, before every segment of samples, one more with units, dimensions, start and step. Segments
with the same channels are one table.
"""

from __future__ import annotations

from itertools import pairwise, zip_longest

from viscorod.model.fields.definition import RefusedError, show

__all__ = ["labview_table"]

END = "***End_of_Header***"


def labview_table(lines: list[str]) -> list[str]:
    """Return the lines of a measurement file of LabVIEW as those of a table; other files as they are.

    Raises:
        RefusedError: its segments have different channels.
    """
    ends = [k for k, line in enumerate(lines) if line.startswith(END)]
    if not ends:
        return lines
    common = _head(lines[: ends[0]])
    mark = {"Comma": ",", "Semicolon": ";"}.get(common.get("Separator", ["Tab"])[0], "\t")
    # a line of names follows the head of every segment; a file without heads of segments has it after its own
    starts = ends[1:] or ends
    out = [""] * len(lines)
    first: list[str] | None = None
    for begin, (end, following) in zip([0, *starts], pairwise([*starts, len(lines)]), strict=False):
        head = common | _head(lines[begin:end], mark)
        titles, kept = _titles(lines, end, head, mark)
        if first is None:
            first = titles
            out[end + 1] = "\t".join(titles)
        elif titles != first:
            raise RefusedError(
                f"the segment from line {end + 2} has other channels than the first",
                "save one segment a file",
                found=show(", ".join(titles)),
            )
        last = following if following == len(lines) else _begin_of_head(lines, end, following)
        for number, line in enumerate(lines[end + 2 : last]):
            cells = [cell for k, cell in enumerate(line.split(mark)) if k in kept]
            if cells and not cells[0].strip() and any(cell.strip() for cell in cells[1:]):
                cells[0] = _time_of(head, number)
            out[end + 2 + number] = "\t".join(cells)
    return out


def _head(lines: list[str], mark: str = "\t") -> dict[str, list[str]]:
    return {cells[0]: cells[1:] for line in lines if len(cells := line.rstrip().split(mark)) > 1 and cells[0]}


def _titles(lines: list[str], end: int, head: dict[str, list[str]], mark: str) -> tuple[list[str], set[int]]:
    """Return the names of the columns with their units, and which cells are theirs."""
    names = lines[end + 1].rstrip(mark + " ").split(mark) if len(lines) > end + 1 else []
    kept = [k for k, name in enumerate(names) if name != "Comment"]
    time = "s" if head.get("X_Dimension", ["Time"])[0] == "Time" else ""
    listed = head.get("Y_Unit_Label", [])
    if sum(names[k] == "X_Value" for k in kept) > 1:  # every channel has times of its own, and units in pairs
        units = [
            time if names[k] == "X_Value" else listed[k - 1] if 0 < k <= len(listed) else "" for k in kept
        ]
    else:
        units = [time, *listed]
    pairs = zip_longest((names[k] for k in kept), units[: len(kept)], fillvalue="")
    return [f"{name} [{unit.strip()}]" if unit.strip() else name for name, unit in pairs], set(kept)


def _begin_of_head(lines: list[str], end: int, following: int) -> int:
    """Return the line with which the head of the next segment begins."""
    for k in range(end + 2, following):
        if lines[k].split("\t")[0].strip() in ("Channels", "Samples", "Notes", "Date", "Description"):
            return k
    return following


def _time_of(head: dict[str, list[str]], number: int) -> str:
    """Return the time of a sample of a file that has no times (X_Columns No): start and number of steps."""
    start, step = (
        float((head.get(key, [""])[0] or usual).replace(",", "."))
        for key, usual in (("X0", "0"), ("Delta_X", "nan"))
    )
    text = repr(start + number * step)
    return text.replace(".", ",") if head.get("Decimal_Separator", ["."])[0] == "," else text
