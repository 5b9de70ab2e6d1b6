"""The page that goes through the papers names tests and public names that exist."""

import inspect
import re
from pathlib import Path

import pytest

import viscorod as vr

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "explanation" / "papers.md").read_text(encoding="utf-8")
ROWS = [
    [cell.strip() for cell in line.strip("|").split(" | ")]
    for line in PAGE.splitlines()
    if line.startswith("| ") and not line.startswith("| item")
]


def has(owner, name):
    """Whether a class or module has a name: an attribute, a field or an annotation."""
    if hasattr(owner, name):
        return True
    fields = getattr(owner, "model_fields", {}) | getattr(owner, "__dataclass_fields__", {})
    return name in fields or name in getattr(owner, "__annotations__", {})


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_every_call_and_every_test_exists(row):
    _, _, calls, tests = row
    names = re.findall(r"`([^`]+)`", calls)
    assert names
    for call in names:
        word, _, given = call.rstrip(")").partition("(")
        owner, path = vr, word.split(".")
        for k, name in enumerate(path):
            assert has(owner, name), f"{call}: no {name}"
            if k + 1 < len(path):
                owner = getattr(owner, name)
        for keyword in re.findall(r"(\w+)=", given):
            assert keyword in inspect.signature(getattr(owner, path[-1])).parameters, f"{call}: no {keyword}"
    found = re.findall(r"`([^`]+)`", tests)
    assert found
    for test in found:
        file, _, function = test.partition("::")
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        if function:
            assert re.search(rf"^def {function}\(", text, re.MULTILINE), test


def test_all_three_papers_are_there():
    for heading, least in (("(LLT)", 23), ("(LW)", 18), ("(AWP)", 30)):
        part = PAGE.split(heading, 1)[1].split("\n## ", 1)[0]
        assert part.count("\n| ") - 1 >= least
