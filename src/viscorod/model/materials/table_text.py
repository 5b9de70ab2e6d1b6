"""The text of an exported table: encodings, files that are no text, cells, and numbers with points or commas."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Callable, Iterable
from pathlib import Path

from viscorod.limits import LARGEST_TABLE
from viscorod.model.fields.definition import RefusedError, show
from viscorod.wording import missing

__all__ = ["MISSING", "SEPARATORS", "Numbers", "lines_of", "looks_like_a_number", "wide_words", "words"]

_BINARY = {
    b"PK\x03\x04": "a workbook or an archive (.xlsx, .ods, .zip)",
    b"\xd0\xcf\x11\xe0": "a workbook of Excel (.xls)",
    b"%PDF": "a PDF",
    b"\x1f\x8b": "a compressed file (.gz)",
    b"{\\rtf": "a document (.rtf)",
    b"\x89HDF": "an HDF5 file",
}
_NONE = ("-", "--", "---", "*", "****", "n.a.", "n/a", "na", "<na>", "#n/a", "none", "null", "missing")
_NO_NUMBER = (
    "nan",
    "nan()",
    "#nv",
    "#value!",
    "#num!",
    "#div/0!",
    "1.#qnan",
    "-1.#qnan",
    "1.#ind",
    "-1.#ind",
)
_TOO_LARGE = (
    *("inf", "+inf", "-inf", "infinity", "-infinity", "∞", "-∞", "1.#inf", "-1.#inf"),
    *(
        "ovl",
        "ol",
        "ovr",
        "ovld",
        "over",
        "overload",
        "overflow",
        "overrange",
        "ovrng",
        "+ovr",
        "-ovr",
        "+ol",
        "-ol",
    ),
)
MISSING = ("", *_NONE, *_NO_NUMBER, *_TOO_LARGE)
"""Cells, in small letters, that say that a point was not measured."""


def lines_of(path: Path) -> list[str]:
    """Return the lines of a text file, whatever its encoding.

    Raises:
        RefusedError: it cannot be read, is too large, or is no text.
    """
    try:
        if not path.is_file():
            raise RefusedError(missing(path), "give the path of a table of a frequency sweep")
        size = path.stat().st_size
        if size > LARGEST_TABLE:
            raise RefusedError(
                "the file is larger than any table of a measurement",
                f"give one of less than {LARGEST_TABLE // 1_000_000} MB",
                found=f"{size / 1e6:.0f} MB",
            )
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, RefusedError):
            raise
        raise RefusedError(f"it cannot be read ({error})", "check the path and its permissions") from None
    return _named_above(_decoded(content).splitlines())


def _named_above(lines: list[str]) -> list[str]:
    """Return a file of TA's Universal Analysis, which names its columns in lines "Sig1 ...", as a table."""
    names = [found[2].strip() for line in lines if (found := re.match(r"Sig(\d+)\s+(\S.*)", line))]
    start = next((k for k, line in enumerate(lines) if line.strip() == "StartOfData"), None)
    if not names or start is None:
        return lines
    return [*[""] * start, "\t".join(names), *("\t".join(line.split()) for line in lines[start + 1 :])]


def _decoded(content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        return content.decode("utf-16", errors="replace")
    what = next((what for start, what in _BINARY.items() if content.startswith(start)), None)
    head = content[:4000]
    if what is None and b"\0" in head:
        for encoding, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
            if zeros.count(0) > 0.8 * len(zeros):
                return content.decode(encoding, errors="replace")
        what = "a binary file"
    if what is not None:
        raise RefusedError(
            f"it is {what}, no text",
            "export the table as text in the program that wrote it (.csv or .txt, with names and units of the columns)",
        )
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return content.decode(encoding)
        except UnicodeDecodeError:
            continue
    return content.decode("latin-1")


def _separated(mark: str) -> Callable[[str], list[str]]:
    def cells(line: str) -> list[str]:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=mark), [])]
        except csv.Error:
            return [cell.strip() for cell in line.split(mark)]

    return cells


def wide_words(line: str) -> list[str]:
    """Return the cells between two blanks or more."""
    return re.split(r"\s{2,}", line.strip())


def _narrow(line: str) -> list[str]:
    """Return cells between blanks; a unit in brackets belongs to the name before it."""
    return re.split(r"\s+(?![(\[])", line.strip())


def words(line: str) -> list[str]:
    """Return the cells between blanks."""
    return line.split()


SEPARATORS = {
    "tabs": (_separated("\t"), _separated("\t")),
    "semicolons": (_separated(";"), _separated(";")),
    "commas": (_separated(","), _separated(",")),
    "bars": (_separated("|"), _separated("|")),
    "wide blanks": (wide_words, words),
    "blanks and units": (_narrow, words),
    "blanks": (words, words),
}
"""How lines are divided into cells: the line of the names, and those below."""


class Numbers:
    """Numbers as all cells of a table write them: with a point or a comma, and perhaps with thousands.

    Args:
        cells: of the columns that are read.

    Raises:
        RefusedError: points and commas contradict each other, or a comma may be either.
    """

    def __init__(self, cells: Iterable[str]) -> None:
        texts = {_plain(cell) for cell in cells}
        texts = {text for text in texts if re.search(r"\d", text)}
        self._decimal, self._thousand = _marks(texts)

    def of(self, cell: str) -> float | None:
        """Return the number in a cell; nan if it says that there is none, None if it is another text."""
        text = _plain(cell)
        if text.lower() in MISSING:
            return math.nan
        if self._thousand:
            text = text.replace(self._thousand, "")
        try:
            value = float(text.replace(self._decimal, "."))
        except ValueError:
            return None
        return value if math.isfinite(value) else math.nan


def looks_like_a_number(cell: str) -> bool:
    """Return whether a cell is a number in any of the ways of writing."""
    return re.fullmatch(r"[-+]?[\d.,]*\d[\d.,]*(e[-+]?\d+)?", _plain(cell).lower()) is not None


def _plain(cell: str) -> str:
    text = re.sub(r"(?<=\d)[\s'\u2019\u00a0\u202f](?=\d{3})", "", cell.strip())
    text = text.replace("\N{MINUS SIGN}", "-")
    text = re.sub(r"\s*[x×*]\s*10\s*\^?\s*\(?([-+]?\d+)\)?$", r"e\1", text)
    return re.sub(r"(?<=[\d.,])[dD](?=[-+]?\d+$)", "e", text)


def _marks(texts: set[str]) -> tuple[str, str]:
    """Return the decimal mark, and that of the thousands or an empty text."""
    grouped = {mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}(\{mark}\d{{3}})+") for mark in ",."}
    both = {text for text in texts if "," in text and "." in text}
    last = {max(",.", key=text.rindex) for text in both}
    only = {mark: {t for t in texts - both if mark in t} for mark in ",."}
    several = {mark for mark in ",." if any(t.count(mark) > 1 for t in only[mark])}
    if len(last) == 1 and not several & last:
        (decimal,) = last
        other = {",": ".", ".": ","}[decimal]
        if all(grouped[other].fullmatch(t) for t in only[other]):
            return decimal, other
    elif not last and only[","] and not only["."]:
        if several == {","}:
            return ".", ","
        if all(grouped[","].fullmatch(t) for t in only[","]):
            found = show(min(only[","]))
            raise RefusedError(
                "the comma may mark decimals or thousands; no number shows which",
                "write the numbers with a decimal point",
                found=found,
            )
        return ",", ""
    elif not last and not only[","]:
        if "." not in several:
            return ".", ""
        if all(grouped["."].fullmatch(t) for t in only["."]):
            return ",", "."
    elif not last:
        whole = {mark for mark in ",." if all(grouped[mark].fullmatch(t) for t in only[mark])}
        if len(whole) == 1 and not several - whole:
            (thousand,) = whole
            return {",": ".", ".": ","}[thousand], thousand
    raise RefusedError("the numbers have both points and commas", "write decimals one way, and no thousands")
