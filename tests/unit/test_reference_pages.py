"""The reference shows every public name, and none that does not exist."""

from __future__ import annotations

import importlib
import re
import shlex
from pathlib import Path

import pytest
import typer

import viscorod
import viscorod.programs
from viscorod.casefile.shipped import shipped_cases
from viscorod.cli.app import app

PAGES = Path(__file__).parents[2] / "docs" / "reference"
CLASSES = PAGES / "classes"
CELL = re.compile(r"^```\{code-cell\} ipython3\n(.*?)^```", re.DOTALL | re.MULTILINE)
WIDTH = 88
"""Characters of a line of code that a page shows whole."""
PRINTED = 80
"""Characters of a line of a report."""
DIRECTIVE = re.compile(
    r"^\.\. (?:auto|py:)(class|function|exception|data|module):: ([\w.]+)\n(?:   :members:(.*)\n)?",
    re.MULTILINE,
)


def found(name):
    """The object with a dotted name."""
    module, _, last = name.rpartition(".")
    return getattr(importlib.import_module(module), last)


def shown(pages):
    """The objects that pages show, each by the dotted name under which it is shown."""
    objects = {}
    for page in pages:
        for kind, name, members in DIRECTIVE.findall(page.read_text(encoding="utf-8")):
            if kind != "module":
                objects[name] = found(name)
                continue
            module = importlib.import_module(name)
            for member in members.replace(",", " ").split() or getattr(module, "__all__", ()):
                objects[f"{name}.{member}"] = getattr(module, member)
    return objects


def names_of(package):
    """The public names of a package, without the other package that is one of them."""
    return sorted(set(package.__all__) - {"programs"})


@pytest.mark.parametrize(
    ("package", "alias"), [(viscorod, "vr"), (viscorod.programs, "vd")], ids=["viscorod", "programs"]
)
def test_every_public_name_has_a_page_that_uses_it(package, alias):
    """One page shows its docstring and has it in a code cell, which another test runs."""
    used = set()
    for page in CLASSES.glob("*.md"):
        code = "\n".join(CELL.findall(page.read_text(encoding="utf-8")))
        described = {id(value) for value in shown([page]).values()}
        words = set(re.findall(rf"\b{alias}\.(\w+)", code))
        used |= {name for name in words & set(names_of(package)) if id(getattr(package, name)) in described}
    assert [name for name in names_of(package) if name not in used] == []


@pytest.mark.parametrize("package", [viscorod, viscorod.programs], ids=lambda package: package.__name__)
def test_every_public_name_is_in_the_table_of_contents(package):
    """Each page too is named there, once."""
    text = (PAGES / "index.md").read_text(encoding="utf-8")
    contents = set(re.findall(r"`(\w+)`", text.partition("## The data set")[0]))
    assert [name for name in names_of(package) if name not in contents] == []
    assert sorted(re.findall(r"^classes/(\w+)$", text, re.MULTILINE)) == sorted(
        page.stem for page in CLASSES.glob("*.md")
    )


def test_public_names_have_docstrings():
    pages = PAGES.rglob("*.md")
    assert [name for name, value in shown(pages).items() if not (value.__doc__ or "").strip()] == []


def lines_beyond(width, kinds):
    """The lines on all pages that are longer, in blocks of these kinds (a regular expression)."""
    return [
        f"{page.relative_to(PAGES.parent)}: {line}"
        for page in sorted(PAGES.parent.rglob("*.md"))
        for block in re.findall(
            rf"^```{kinds}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        )
        for line in block.splitlines()
        if len(line) > width
    ]


def test_code_of_the_pages_fits_their_width():
    """Longer lines are cut at the edge of a page."""
    assert lines_beyond(WIDTH, r"(?:python|\{code-cell\} ipython3)") == []


def test_reports_on_pages_are_as_wide_as_they_are_printed():
    """Reports wrap at 80 columns, so a wider one on a page is older than that."""
    assert lines_beyond(PRINTED, "text") == []


def test_words_of_the_glossary_exist():
    """Public names, and names of the source in the modules that the last table gives."""
    text = (PAGES.parent / "explanation" / "glossary.md").read_text(encoding="utf-8")
    public, _, source = text.partition("## Words in the code")
    missing = [name for name in re.findall(r"`([A-Z]\w+)[`(.]", public) if not hasattr(viscorod, name)]
    rows = re.findall(r"^\| `?(\w+)`? \| `([\w.]+)` \|", source, re.MULTILINE)
    for name, module in rows:
        found_there = importlib.import_module(f"viscorod.{module}")
        if name[0].isupper() and not hasattr(found_there, name):
            missing.append(f"{module}.{name}")
    assert len(rows) > 10
    assert missing == []


def commands():
    """The commands of all pages, without their comments; the README's too."""
    docs = PAGES.parent
    for page in [docs.parent / "README.md", *sorted(docs.rglob("*.md"))]:
        text = page.read_text(encoding="utf-8")
        for block in re.findall(r"^```console\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            for line in block.splitlines():
                for part in line.removeprefix("$ ").partition("  #")[0].split("&&"):
                    if part.strip().startswith("viscorod "):
                        yield page.stem, part.strip()


@pytest.mark.parametrize(("page", "text"), sorted(set(commands())))
def test_commands_of_the_pages_exist(page, text):
    """Each command and each of its options is known."""
    command = typer.main.get_command(app)
    for word in shlex.split(text.replace("[", "").replace("]", ""))[1:]:
        if word.startswith("-"):
            known = {option for parameter in command.params for option in parameter.opts} | {"--help"}
            assert word.partition("=")[0] in known, f"{page}: {text}"
        elif hasattr(command, "commands"):
            assert word in command.commands, f"{page}: {text}"
            command = command.commands[word]


MODULES = ("architecture", "decisions", "extend", "glossary")
"""Pages that also name modules, such as `model.fields`."""
PYTHON_PAGES = [page for page in sorted(PAGES.parent.rglob("*.md")) if page.stem not in MODULES]


@pytest.mark.parametrize("page", PYTHON_PAGES, ids=lambda page: page.stem)
def test_names_in_the_text_of_pages_exist(page):
    """What stands as `vr.name`, `model.name` or `run.name` in a sentence or a table can be typed."""
    text = re.sub(r"^```.*?^```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    owners = {"vr": viscorod, "model": viscorod.Model, "run": viscorod.Run}
    set_on_objects = {"rods", "bodies", "loads", "supports", "materials", "sections", "joints", "springs"}
    files = {"nc", "png", "html", "partial", "vtkhdf", "toml"}
    missing = [
        f"{owner}.{name}"
        for code in re.findall(r"`([^`\n]+)`", text)
        for owner, name in re.findall(r"\b(vr|model|run)\.([a-z_A-Z]\w*)", code)
        if not hasattr(owners[owner], name) and name not in set_on_objects | files
    ]
    assert missing == []


def test_pages_that_use_a_shipped_case_say_how_to_copy_it():
    """Before the code in which it stands: a reader begins with an empty folder."""
    shipped, docs, missing = set(shipped_cases()), PAGES.parent, []
    for page in sorted(path for path in docs.rglob("*.md") if "_build" not in path.parts):
        text = page.read_text(encoding="utf-8")
        for block in re.finditer(r"^```[^\n]*\n(.*?)^```", text, re.DOTALL | re.MULTILINE):
            for use in re.finditer(r"([\w-]+)\.toml", block[1]):
                if (
                    use[1] in shipped
                    and f"viscorod example {use[1]}" not in text[: block.start(1) + use.start()]
                ):
                    missing.append(f"{page.relative_to(docs)}: {use[0]}")
    assert missing == []
