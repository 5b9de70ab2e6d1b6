"""Write the Python of all pages, and of the README, into files that a type checker reads.

    python docs/typed_lines.py docs/_build/typed && mypy docs/_build/typed/docs_lines

A page is a program; where it imports viscorod again, another one begins. Every line keeps its number, so that what mypy
says leads to the page: ``docs_lines/howto_python_1.py:57`` is line 57 of ``docs/howto/python.md``.
"""

import re
import shutil
import sys
from pathlib import Path

DOCS = Path(__file__).parent
BLOCK = re.compile(
    r"^```(?:\{code-cell\} ipython3|python)\n(.*?)^```", re.DOTALL | re.MULTILINE
)
NEW = re.compile(r"^import viscorod as vr$", re.MULTILINE)
DRAWN_BY_XARRAY = re.compile(r"(?:history|joint)\(.*\.plot\(\)")
"""Its types refuse the method that its own documentation calls so."""


def programs(text):
    """Yield the programs of a page, as lines with the numbers of those of the page."""
    count = text.count("\n") + 1
    lines = [""] * count
    for found in BLOCK.finditer(text):
        if NEW.search(found[1]) and NEW.search("\n".join(lines)):
            yield lines
            lines = [""] * count
        first = text.count("\n", 0, found.start(1))
        for number, line in enumerate(found[1].splitlines(), first):
            if line.startswith(("%", "!", ":tags:")):
                continue
            drawn = DRAWN_BY_XARRAY.search(line) is not None
            lines[number] = (
                f"{line.partition('  #')[0]}  # type: ignore" if drawn else line
            )
    if any(lines):
        yield lines


def main():
    """Write the files into a folder of their own."""
    folder = Path(sys.argv[1]) / "docs_lines"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    pages = [DOCS.parent / "README.md", *sorted(DOCS.rglob("*.md"))]
    for page in pages:
        if "_build" in page.parts:
            continue
        name = (
            page.relative_to(DOCS.parent)
            .with_suffix("")
            .as_posix()
            .removeprefix("docs/")
            .replace("/", "_")
        )
        for number, lines in enumerate(programs(page.read_text(encoding="utf-8")), 1):
            (folder / f"{name}_{number}.py").write_text(
                "\n".join(lines) + "\n", encoding="utf-8"
            )


if __name__ == "__main__":
    main()
