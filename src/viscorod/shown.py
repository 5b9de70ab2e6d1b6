"""How objects show themselves: in one line, and in a notebook by their name, facts and a small drawing."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from viscorod.argument_names import KnownArguments
from viscorod.quantity_text import number, scaled

__all__ = ["Shown", "card", "counted", "span"]


class Shown(KnownArguments):
    """What gives an object one line for `repr` and a card for notebooks."""

    def _facts(self) -> Iterable[str]:
        """Yield what it is, in short phrases."""
        return ()

    def _drawing(self) -> str:
        """Return a small drawing as SVG; empty where there is none."""
        return ""

    def _named(self) -> str:
        """Return what stands before the facts: the class, and the title if there is one."""
        title = getattr(self, "title", "")
        return type(self).__name__ + (f" {title!r}" if isinstance(title, str) and title else "")

    def __repr__(self) -> str:
        """Return one line."""
        try:
            facts = ", ".join(self._facts())
            name = self._named()
        except Exception:  # a debugger shows objects that are not whole yet
            return f"<{type(self).__name__}>"
        return " ".join(f"<{name}{': ' if facts else ''}{facts}>".split())

    def _repr_html_(self) -> str:
        """Return a card for a notebook."""
        return card(self._named(), self._facts(), self._drawing())


def card(name: str, facts: Iterable[str], drawing: str) -> str:
    """Return name, facts and drawing as HTML that is readable on light and on dark pages."""
    lines = "".join(f"<div>{escape(fact)}</div>" for fact in facts)
    return (
        '<div style="display:flex;gap:16px;align-items:center;margin:4px 0">'
        f"{drawing}<div><div><b>{escape(name)}</b></div>{lines}</div></div>"
    )


def counted(number: int, noun: str, several: str = "") -> str:
    """Return a number with its noun: "1 body", "2 bodies"."""
    return f"{number} {noun if number == 1 else several or noun + 's'}"


def span(low: float, high: float, unit: str) -> str:
    """Return a range with its unit: "0 to 2 s"."""
    factor, unit = scaled(unit, (low, high))
    ends = [number(factor * value, 4) for value in ((low, high) if high != low else (low,))]
    return f"{' to '.join(ends)} {unit}".rstrip()
