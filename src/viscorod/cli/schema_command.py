"""``viscorod schema``: the JSON Schema of case files."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from viscorod.cli.options import output_option
from viscorod.cli.terminal import readable_errors, say
from viscorod.whole_files import replacing

__all__ = ["schema"]


def schema(
    output: Annotated[Path | None, output_option("FILE", "File to write [default: print it]")] = None,
) -> None:
    """Write the JSON Schema of case files, for completion and checks in an editor."""
    with readable_errors():
        import json

        from viscorod.casefile.json_schema import case_schema

        text = json.dumps(case_schema(), indent=2, ensure_ascii=False) + "\n"
        if output is None:
            typer.echo(text, nl=False)
            return
        with replacing(output) as new:
            new.write_text(text, encoding="utf-8")
        say(f"{output}: name it in a case file: #:schema {output}")
