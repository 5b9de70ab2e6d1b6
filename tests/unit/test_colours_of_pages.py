"""Colours of pages, light and dark: contrast by WCAG 2.1, 4.5:1 for text and 3:1 for lines, computed from the sheet."""

import re
from pathlib import Path

import pytest

import viscorod.pictures.viewer

STATIC = Path(viscorod.pictures.viewer.__file__).parent / "static"
SHEET = (STATIC / "viewer.css").read_text(encoding="utf-8")
COLOUR = re.compile(r"#[0-9a-fA-F]{3,8}\b")
THEMES = {
    name: dict(re.findall(r"--([\w-]+): (#\w+);", re.search(rf":root{mark} \{{(.*?)\}}", SHEET, re.S)[1]))
    for name, mark in (("light", ""), ("dark", r"\[data-dark\]"))
}
GROUNDS = {"page", "hover", "chosen", "warn", "fail"}
TEXTS = {"ink", "soft"} | {f"name-{one}" for one in ("body", "joint", "spring", "load", "x", "y", "z")}
DECORATION = {"line", "faint"}
"""Lines between rows and of grids, without which everything can be read."""
AREAS = {f"area-{k}" for k in range(4)}
"""Layers of energy that lie on each other, with a legend: they are told apart by the layers beside them."""


def luminance(colour):
    """Relative luminance of an sRGB colour, https://www.w3.org/TR/WCAG21/#dfn-relative-luminance."""
    digits = colour.lstrip("#")
    digits = "".join(2 * one for one in digits) if len(digits) == 3 else digits
    parts = [int(digits[k : k + 2], 16) / 255.0 for k in (0, 2, 4)]
    linear = [one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, other):
    dark, light = sorted((luminance(one), luminance(other)))
    return (light + 0.05) / (dark + 0.05)


def test_contrast_of_known_pairs():
    """Black on white has 21, and #777777 on white 4.48, the best known grey that fails."""
    assert contrast("#000", "#ffffff") == pytest.approx(21.0)
    assert contrast("#777777", "#fff") == pytest.approx(4.48, abs=5e-3)


@pytest.mark.parametrize("theme", THEMES)
def test_all_colours_can_be_seen(theme):
    colours = THEMES[theme]
    page = colours["page"]
    assert TEXTS | GROUNDS | DECORATION | AREAS < set(colours)
    lines = set(colours) - TEXTS - GROUNDS - DECORATION - (AREAS if theme == "light" else set())
    dim = {name: contrast(colours[name], page) for name in lines}
    dim = {name: round(value, 2) for name, value in dim.items() if value < 3.0}
    assert dim == {}
    for name in TEXTS:
        assert contrast(colours[name], page) >= 4.5, name
    for ground in GROUNDS:  # what is written on them
        assert contrast(colours["ink"], colours[ground]) >= 4.5, ground


def test_colours_have_names_that_both_pages_know():
    """No script or sheet has a colour of its own, which would stay when the page becomes dark; none is left over."""
    assert THEMES["light"].keys() == THEMES["dark"].keys()
    files = [path for kind in ("js", "css", "html") for path in STATIC.glob(f"*.{kind}")]
    sheet = r":root(\[data-dark\])? \{.*?\}"
    texts = [re.sub(sheet, "", path.read_text(encoding="utf-8"), flags=re.S) for path in files]
    for path, text in zip(files, texts, strict=True):
        assert set(COLOUR.findall(text)) <= {"#ffffff"}, path.name  # the light of the view
    for name in THEMES["light"]:
        numbered = name.rpartition("-")[0] + "-${"  # many-${k}
        assert any(f"--{name}" in text or f"--{numbered}" in text for text in texts), name
