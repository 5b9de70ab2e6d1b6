"""``viscorod example``: the cases that come with viscorod."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.completion import case_names
from viscorod.cli.terminal import readable_errors, say
from viscorod.errors import InputError
from viscorod.whole_files import replacing

__all__ = ["example"]


def example(
    name: Annotated[
        str | None,
        typer.Argument(
            help="Case to copy; without it, all are listed.", show_default=False, autocompletion=case_names
        ),
    ] = None,
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Folder to copy into")
    ] = Path(),
) -> None:
    """List the cases that come with viscorod, or copy one."""
    with readable_errors():
        from viscorod.casefile.shipped import needed_extra, shipped_case, shipped_cases

        if name is not None:
            target = _copied(shipped_case(name), output)
            extra = needed_extra(tomllib.loads(target.read_text(encoding="utf-8")))
            first = f"pip install {_installed(extra)}, " if extra else ""
            say(f"{target}: change it, then: {first}viscorod run {target}")
            return
        cases = shipped_cases()
        width = max(map(len, cases), default=0)
        for word, path in cases.items():
            content = tomllib.loads(path.read_text(encoding="utf-8"))
            extra = needed_extra(content)
            more = f" (needs {_installed(extra)})" if extra else ""
            typer.echo(f"{word:<{width}}  {content.get('title', '')}{more}".rstrip())


def _installed(extra: str) -> str:
    return f"'viscorod[{extra}]'"


def _copied(case: Path, folder: Path) -> Path:
    target = folder / case.name
    if target.exists():
        raise InputError(f"{target} exists already; move it, or name another folder with -o")
    with replacing(target) as new:
        new.write_bytes(case.read_bytes())
    return target
