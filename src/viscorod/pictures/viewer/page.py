"""The page as text: scripts, styles, data. What comes from files is data and never becomes markup."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from viscorod.pictures.viewer.packing import Pack

if TYPE_CHECKING:
    from viscorod.results.result import Result
    from viscorod.results.stateless_result import StatelessResult

__all__ = ["curve_page", "heading_of", "page"]

_STYLES = ("vendor/uplot.min.css", "viewer.css")
_SCRIPTS = (
    "vendor/three.min.js",
    "vendor/uplot.min.js",
    "data.js",
    "surface.js",
    "symbols.js",
    "scene.js",
    "charts.js",
    "viewer.js",
)
_OF_CURVES = ("data.js", "curve_chart.js", "curves.js")
_LICENCES = {"three.js": "vendor/three.LICENSE", "uPlot": "vendor/uplot.LICENSE"}
_IN_SCRIPT = {"<": "\\u003c", ">": "\\u003e", "&": "\\u0026", "\u2028": "\\u2028", "\u2029": "\\u2029"}


def page(title: str, meta: Mapping[str, Any], pack: Pack) -> str:
    """Return the HTML text of a page that needs nothing else.

    The content security policy of the page blocks all requests and all scripts but its own.

    Args:
        title: of the browser's window, untrusted text.
        meta: what the scripts read as JSON; its strings are untrusted and are shown as text.
        pack: the arrays.

    Raises:
        ValueError: `meta` holds a number that is not finite.
    """
    licences = "\n\n".join(f"{name}:\n{_shipped(path)}" for name, path in _LICENCES.items())
    return _filled("page.html", _SCRIPTS, _STYLES, title, meta, pack, licences)


def curve_page(title: str, meta: Mapping[str, Any], pack: Pack) -> str:
    """Return the HTML text of a page of curves, see :func:`page`; its charts need no other's script."""
    return _filled("curves.html", _OF_CURVES, ("viewer.css", "curves.css"), title, meta, pack)


def _filled(
    template: str,
    names: Sequence[str],
    styles: Sequence[str],
    title: str,
    meta: Mapping[str, Any],
    pack: Pack,
    licences: str = "",
) -> str:
    scripts = [_shipped(name) for name in names]
    hashes = " ".join(f"'sha256-{_digest(text)}'" for text in scripts)
    policy = f"default-src 'none'; script-src {hashes}; style-src 'unsafe-inline'; img-src data: blob:"
    return _shipped(template).format_map(
        {
            "policy": policy,
            "title": html.escape(title or "viscorod"),
            "styles": "\n".join(_shipped(name) for name in styles),
            "licences": licences,
            "meta": script_json({**meta, "arrays": pack.index}),
            "data": pack.text(),
            "scripts": "\n".join(f"<script>{text}</script>" for text in scripts),
        }
    )


HEADINGS = {
    "simulate": "Motion",
    "equilibrium": "Static equilibrium",
    "steady": "Steady rotation",
    "modes": "Modes",
    "buckling": "Critical loads",
    "campbell": "Campbell diagram",
    "stability": "Stability",
    "periodic": "Periodic motions",
    "response": "Frequency response",
}
"""What stands above a result without a title, by its kind."""


def heading_of(result: Result | StatelessResult) -> str:
    """Return what stands above the page of a result without a title."""
    return HEADINGS.get(result.kind, result.kind)


def script_json(value: Any) -> str:
    """Return JSON that may stand inside a script element: no character of it can end the element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))
    for character, escaped in _IN_SCRIPT.items():
        text = text.replace(character, escaped)
    return text


def _shipped(name: str) -> str:
    return files("viscorod.pictures.viewer").joinpath("static", *name.split("/")).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii")
