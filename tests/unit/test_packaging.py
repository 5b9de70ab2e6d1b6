"""What installers, indexes and citations are told agrees with itself."""

from __future__ import annotations

import re
import tomllib
from importlib.metadata import metadata
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def dependencies(lines):
    return {re.split(r"[<>=\[]", line)[0].strip(): line.partition(">=")[2].split(",")[0] for line in lines}


def test_citation_and_changelog_have_the_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.search(r"^version: (.*)$", citation, re.MULTILINE)[1] == PROJECT["version"]
    heading = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)[1]
    assert heading == PROJECT["version"].partition(".dev")[0]


def test_recipe_for_conda_asks_for_what_the_package_asks_for():
    lines = (ROOT / "packaging" / "conda" / "recipe.yaml").read_text(encoding="utf-8").splitlines()
    run = lines[lines.index("  run:") + 1 :]
    run = run[: run.index("")]
    needed, optional = run[: run.index("  run_constraints:")], run[run.index("  run_constraints:") + 1 :]
    asked = dependencies(line.strip("- ") for line in needed)
    asked["matplotlib"] = asked.pop("matplotlib-base")
    assert asked.pop("python") == "${{ python_min }}"
    assert asked == dependencies(PROJECT["dependencies"])
    extras = PROJECT["optional-dependencies"]
    known = dependencies(extras["store"]) | {"dask": dependencies(extras["cluster"])["dask"]}
    known.pop("xarray")  # which is needed in any case, there of an earlier version
    assert dependencies(line.strip("- ") for line in optional) == known


@pytest.mark.parametrize("extra", [name for name in PROJECT["optional-dependencies"] if name != "all"])
def test_every_extra_is_explained(extra):
    page = (ROOT / "docs" / "howto" / "install.md").read_text(encoding="utf-8")
    assert f"| `{extra}` |" in page


def test_links_of_the_readme_lead_somewhere_on_a_package_index():
    """The installed metadata, which an index shows, has no link to a file beside it."""
    text = metadata("viscorod").get_payload() or metadata("viscorod")["Description"]
    assert "](https://" in text
    assert re.findall(r"\]\((?!https?:)[^)]+\)", text) == []
