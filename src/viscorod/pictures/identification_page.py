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
from viscorod.results.identification_report import (
    FORETOLD,
    foretold_table,
    laws_table,
    limits_text,
    what_intervals_are_worth,
    with_prefix,
)
from viscorod.whole_files import replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from viscorod.results.identification import Identification
    from viscorod.results.identified import Number

__all__ = ["page_text", "write_page"]

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 68rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.2rem; }
table { border-collapse: collapse; margin: .6rem 0; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top; }
th:first-child, td:first-child { text-align: left; overflow-wrap: anywhere; min-width: 8rem; }
th { font-weight: 600; } .words { text-align: left; }
.open { color: #D55E00; } svg { max-width: 100%; height: auto; }
pre { background: #f5f5f5; padding: .8rem; overflow-x: auto; font-size: .85rem; }
@media (prefers-color-scheme: dark) {
  :root { color-scheme: dark; } body { color: #ddd; background: #1c1c1c; }
  th, td { border-color: #444; } pre { background: #292929; } .open { color: #FF9E4A; }
  svg { background: #fff; border-radius: 4px; }
}
"""


def write_page(fit: Identification, path: Path) -> Path:
    """Write the page; returns the path.

    Raises:
        InputError: the file cannot be written.
    """
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
    parts.append("<p>The band beside is what noise of the size that was found fills 95 % of the time.</p>")
    parts += ["<h2>Intervals</h2>", _picture(draw_intervals(fit))]
    if len(fit.numbers) > 1:
        parts += ["<h2>Correlation of the numbers</h2>", _picture(draw_correlation(fit))]
    coloured = draw_autocorrelation(fit)
    if coloured is not None:
        parts += ["<h2>What is left</h2>", _picture(coloured)]
    if fit.laws:
        parts += ["<h2>Laws on the same data</h2>", _laws(fit)]
    if fit.foretold:
        parts += [f"<h2>{FORETOLD}</h2>", _table(*foretold_table(fit))]
    if fit.in_programs:
        parts += [
            "<h2>The damping in the numbers of other programs</h2>",
            _numbers(fit.in_programs, prefixes=False),
        ]
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
    text = f"{sizes['value']} values in {sizes['series']} series; intervals of {fit.level:.0%}"
    text += f"{what_intervals_are_worth(fit)}."
    if starts > 1:
        text += f" {fit.data.attrs['agreeing_starts']} of {starts} starts ended in this minimum."
    return text


def _list(texts: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{html.escape(text)}</li>' for text in texts)}</ul>"


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(f"<tr>{''.join(_cell(cell) for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def _cell(text: str) -> str:
    kind = ' class="open"' if "infinite" in text or text.startswith("not told") else ""
    return f"<td{kind}>{html.escape(text)}</td>"


def _numbers(numbers: dict[str, Number], *, prefixes: bool = True) -> str:
    """Return a table; what is typed into other programs stays in SI, without prefixes."""
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
        for one in [with_prefix(number) if prefixes else number]
    ]
    header = ["", "value", "low", "high", *(["unit"] if units else []), *(["interval by"] if by else [])]
    return _table(header, rows)


def _laws(fit: Identification) -> str:
    found = _table(*laws_table(fit, "error of what was left out"))
    return found + "<p>Criteria are less the least of them; errors are over the noise.</p>"


def _picture(picture: Figure) -> str:
    file = io.StringIO()
    picture.savefig(file, format="svg", metadata={"Date": None})
    text = file.getvalue()
    return re.sub(r"^.*?(?=<svg)", "", text, flags=re.DOTALL)
