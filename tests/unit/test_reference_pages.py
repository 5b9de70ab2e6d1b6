"""The reference shows every public name, and none that does not exist."""

from __future__ import annotations

import importlib
import re
from pathlib import Path

import pytest

import viscorod
import viscorod.damping

PAGES = Path(__file__).parents[2] / "docs" / "reference"
DIRECTIVE = re.compile(
    r"^\.\. (?:auto|py:)(class|function|exception|data|module):: ([\w.]+)\n(?:   :members:(.*)\n)?",
    re.MULTILINE,
)


def found(name):
    """The object with a dotted name."""
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(module), last)


def shown():
    """The objects that the pages show, each by the dotted name under which it is shown."""
    objects = {}
    for page in sorted(PAGES.glob("*.md")):
        for kind, name, members in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            if kind != "module":
                objects[name] = found(name)
                continue
            module = importlib.import_module(name)
            for member in members.replace(",", " ").split() or getattr(module, "__all__", ()):
                objects[f"{name}.{member}"] = getattr(module, member)
    return objects


@pytest.fixture(scope="module")
def documented():
    return {id(value) for value in shown().values()}


@pytest.mark.parametrize("package", [viscorod, viscorod.damping], ids=lambda package: package.__name__)
def test_every_public_name_is_in_the_reference(package, documented):
    missing = [name for name in package.__all__ if id(getattr(package, name)) not in documented]
    assert missing == []


def test_public_names_have_docstrings():
    assert [name for name, value in shown().items() if not (value.__doc__ or "").strip()] == []
