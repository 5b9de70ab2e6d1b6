"""The page of an identification: one file that needs no network."""

from __future__ import annotations

import html
import io
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from viscorod.pictures.plots.plot_identification import (
    draw_autocorrelation,
    draw_correlation,
    draw_identification,
    draw_intervals,
)
from viscorod.pictures.style import with_prefixes
from viscorod.results.identification_report import (
    FORETOLD,
    foretold_table,
    laws_table,
    limits_text,
    programs_table,
    residuals_table,
    what_intervals_are_worth,
    with_prefix,
)
from viscorod.results.text_numbers import per_cent
from viscorod.whole_files import page_path, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from viscorod.results.identification import Identification
    from viscorod.results.identified import Number

__all__ = ["page_text", "write_page"]

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; } ul { padding-left: 1.2rem; }
.wide { overflow-x: auto; margin: .6rem 0; }
.wide svg { display: block; min-width: 42rem; max-width: 100%; height: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem 0 .2rem .9rem; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top; }
th:first-child, td:first-child { padding-left: 0; min-width: 8rem; } td.number { white-space: nowrap; }
th:first-child, td:first-child, .words { text-align: left; } th { font-weight: 600; vertical-align: bottom; }
.long { min-width: 17rem; } .open { color: #D55E00; }
pre { background: #f5f5f5; padding: .8rem; overflow-x: auto; font-size: .85rem; }
@media (prefers-color-scheme: dark) {
  :root { color-scheme: dark; } body { color: #ddd; background: #1c1c1c; }
  th, td { border-color: #444; } pre { background: #292929; } .open { color: #FF9E4A; }
  svg { filter: invert(.89) hue-rotate(180deg); }
}
"""
"""Pictures and tables that are wider than the page are moved by themselves; in the dark, pictures keep their hues."""
IN_WORDS = ("unit", "interval by", "fitted", "law")
"""Heads of columns that hold no numbers."""
OF_RESIDUALS = (
    "Noise is the standard deviation of what the model leaves, beside what was told of it; order, the terms of the "
    "autoregression that describes its colour; p(white), how probable such an autocorrelation is of noise without "
    "colour."
)
OF_LAWS = (
    "Criteria are differences from the least. Errors of what was left out are root mean squares over the noise that "
    "was told of it, or else over its standard deviation."
)


def write_page(fit: Identification, path: Path) -> Path:
    """Write the page; returns the path.

    Raises:
        InputError: the file is no ``.html``, or cannot be written.
    """
    path = page_path(path)
    text = page_text(fit).encode()
    with replacing(path, needs=len(text)) as new:
        new.write_bytes(text)
    return path


def page_text(fit: Identification) -> str:
    """Return the page as HTML, pictures inside as SVG."""
    title = html.escape(fit.title or "Identification")
    parts = [f"<h1>{title}</h1>", f"<p>{_summary(fit)}</p>"]
    if fit.sentences:
        parts += ["<h2>What to know</h2>", _list(fit.sentences)]
    parts += ["<h2>Numbers of the model</h2>", _numbers(fit.parameters)]
    if fit.combinations:
        parts += ["<h2>What the data tell of several together</h2>", _numbers(fit.combinations)]
    if fit.nuisances:
        parts += ["<h2>Numbers of the measurement</h2>", _numbers(fit.nuisances)]
    parts += ["<h2>Data and model</h2>", _picture(draw_identification(fit))]
    parts.append("<p>Bands: 95 % of noise of the size that was found lies within.</p>")
    parts += ["<h2>Intervals</h2>", _picture(draw_intervals(fit))]
    if len(fit.numbers) > 1:
        parts += ["<h2>Correlation of the numbers</h2>", _picture(draw_correlation(fit))]
    parts += ["<h2>What is left</h2>", _table(*residuals_table(fit)), f"<p>{OF_RESIDUALS}</p>"]
    coloured = draw_autocorrelation(fit)
    if coloured is not None:
        parts.append(_picture(coloured))
    if fit.laws:
        parts += ["<h2>Laws on the same data</h2>", _table(*laws_table(fit)), f"<p>{OF_LAWS}</p>"]
    if fit.foretold:
        parts += [f"<h2>{FORETOLD}</h2>", _table(*foretold_table(fit))]
    if fit.in_programs:
        parts += ["<h2>The damping in the numbers of other programs</h2>", _table(*programs_table(fit))]
    if fit.warnings:
        parts += ["<h2>Warnings</h2>", _list(fit.warnings)]
    parts += ["<h2>The case with these numbers</h2>"]
    parts += [f"<pre>{html.escape(text)}</pre>" for text in fit.words("cases")]
    body = "\n".join(parts)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style></head>\n'
        f"<body>\n{body}\n</body></html>\n"
    )


def _summary(fit: Identification) -> str:
    sizes, starts = fit.data.sizes, int(fit.data.attrs["starts"])
    text = (
        f"{sizes['value']} values in {sizes['series']} series; intervals of {per_cent(100.0 * fit.level, 4)}"
    )
    text += f"{what_intervals_are_worth(fit)}."
    if starts > 1:
        text += f" {fit.data.attrs['agreeing_starts']} of {starts} starts ended in this minimum."
    return text


def _list(texts: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{html.escape(text)}</li>' for text in texts)}</ul>"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    kinds = [' class="words"' if name in IN_WORDS else "" for name in header]
    head = "".join(f"<th{kind}>{html.escape(cell)}</th>" for cell, kind in zip(header, kinds, strict=True))
    body = "".join(
        f"<tr>{''.join(_cell(cell, name) for cell, name in zip(row, header, strict=True))}</tr>"
        for row in rows
    )
    return f'<div class="wide"><table><tr>{head}</tr>{body}</table></div>'


def _cell(text: str, head: str) -> str:
    """Return a cell; names may be parted after dots, and what a law fitted stands in lines of its own."""
    kinds = ["words"] if head in IN_WORDS else ["number"] if head else []
    kinds += ["long"] * (head == "fitted")
    if "infinite" in text or text.startswith("not told"):
        kinds.append("open")
    shown = html.escape(text).replace("+-", "±")
    shown = shown.replace("; ", "<br>") if head == "fitted" else shown
    shown = shown if head else re.sub(r"([._](?=\w))", r"\1<wbr>", shown)
    kind = ' class="{}"'.format(" ".join(kinds)) if kinds else ""
    return f"<td{kind}>{shown}</td>"


def _numbers(numbers: dict[str, Number]) -> str:
    by, units = (any(getattr(one, word) for one in numbers.values()) for word in ("how", "unit"))
    rows = [
        [
            name,
            f"{one.value:.6g}",
            *limits_text(one),
            *([one.unit] if units else []),
            *([one.how] if by else []),
        ]
        for name, number in numbers.items()
        for one in [with_prefix(number)]
    ]
    header = ["", "value", "low", "high", *(["unit"] if units else []), *(["interval by"] if by else [])]
    return _table(header, rows)


def _picture(picture: Figure) -> str:
    """Return a picture, whose title is that of the page."""
    with_prefixes(picture)
    picture.suptitle("")
    file = io.StringIO()
    picture.savefig(file, format="svg", metadata={"Date": None})
    return f'<div class="wide">{re.sub(r"^.*?(?=<svg)", "", file.getvalue(), flags=re.DOTALL)}</div>'
