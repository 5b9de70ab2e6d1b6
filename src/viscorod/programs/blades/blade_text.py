"""Read BeamDyn's input files line by line, as its own reader does: values first, comments after them."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.typing import Floats

__all__ = ["Lines"]


def _number(text: str) -> float | None:
    """Return a finite number as Fortran writes it (1.0D+03, 1.0+103), or None."""
    plain = re.sub(r"(?<=[\d.])(?:[dD]|(?=[-+]\d+$))", "e", text)
    try:
        value = float(plain)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


class Lines:
    """The lines of a BeamDyn input file, taken one after the other.

    Args:
        path: of the file.

    Raises:
        InputError: the file cannot be read.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self._lines = self.path.read_text(encoding="utf-8", errors="replace").splitlines()
        except OSError as error:
            raise InputError(
                Fault(str(path), "", f"the file cannot be read ({error.strerror})", "check the path")
            ) from None
        self._next = 0

    def skip(self, count: int = 1) -> str:
        """Pass over comment lines and return the last of them."""
        line = ""
        for _ in range(count):
            line = self._take("a comment line")
        return line

    def skip_blank(self) -> None:
        """Pass over empty lines."""
        while self._next < len(self._lines) and not self._lines[self._next].strip():
            self._next += 1

    def find(self, word: str) -> None:
        """Go to the line whose second word is `word`, as in ``49  kp_total - number of key points``."""
        for index, line in enumerate(self._lines):
            parts = line.split()
            if len(parts) > 1 and parts[1].lower() == word.lower():
                self._next = index
                return
        raise InputError(
            Fault(str(self.path), "", f"there is no line with {word}", "give a BeamDyn primary input file")
        )

    def whole(self, what: str, low: int = 0) -> int:
        """Take a line and return the whole number it starts with."""
        (value,) = self.numbers(1, what)
        if value != int(value) or value < low:
            raise self.problem(f"{value:g}", f"{what} is a whole number", f"give a whole number >= {low}")
        return int(value)

    def numbers(self, count: int, what: str) -> Floats:
        """Take a line and return the `count` numbers it starts with."""
        line = self._take(what)
        parts = line.replace(",", " ").split()
        values = [value for part in parts[:count] if (value := _number(part)) is not None]
        if len(parts) > count and _number(parts[count]) is not None:
            raise self.problem(
                repr(line.strip()[:60]),
                f"{what} is expected here, and the line has more numbers than {count}",
                f"give {count} {'number' if count == 1 else 'numbers'} in this line",
            )
        if len(values) != count:
            raise self.problem(
                repr(line.strip()[:60]), f"{what} is expected here", f"give {count} numbers in this line"
            )
        return np.array(values)

    def problem(self, found: str, why: str, instead: str) -> InputError:
        """Return an error about the line that was taken last."""
        return InputError(Fault(f"{self.path}, line {self._next}", found, why, instead))

    def _take(self, what: str) -> str:
        if self._next >= len(self._lines):
            raise InputError(
                Fault(
                    f"{self.path}, line {self._next}",
                    "the end of the file",
                    f"{what} is expected here",
                    "give a complete file",
                )
            )
        self._next += 1
        return self._lines[self._next - 1]
