"""What all commands have: help after ``-h``, ``--quiet``, and where they end with numbers ``--json``."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable
from contextvars import ContextVar
from typing import Annotated, Any, get_args

import typer
from typer.models import OptionInfo

__all__ = ["HELP", "add", "quiet", "wants_json"]

HELP = {"help_option_names": ["-h", "--help"]}
"""Settings of the whole command line, which the commands inherit."""
_ASKED: ContextVar[frozenset[str]] = ContextVar("asked", default=frozenset())
"""Those of the options of all commands that were given to the one that runs."""
_FLAGS: dict[str, Any] = {
    "quiet": Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")],
    "json": Annotated[bool, typer.Option("--json", help="Print numbers as JSON in place of the report.")],
}


def quiet() -> bool:
    """Return whether the command that runs prints errors only."""
    return bool(_ASKED.get())


def wants_json() -> bool:
    """Return whether the command that runs prints JSON in place of its report."""
    return "json" in _ASKED.get()


def add(
    app: typer.Typer, command: Callable[..., None], name: str | None = None, *, numbers: bool = False
) -> None:
    """Add a command, listed with the first sentence of its help, with ``--quiet``.

    Args:
        app: to which it is added; command: the function.
        name: of the command; by default that of the function.
        numbers: whether it ends with a result, which ``--json`` prints.
    """
    flags = {word: _FLAGS[word] for word in ("quiet", *(["json"] if numbers else []))}

    @functools.wraps(command)
    def run(*args: Any, **given: Any) -> None:
        before = _ASKED.set(frozenset(word for word in flags if given.pop(word, False)))
        try:
            command(*args, **given)
        finally:
            _ASKED.reset(before)

    signature = inspect.signature(command, eval_str=True)
    for parameter in signature.parameters.values():
        _name_value(parameter.annotation)
    more = [
        inspect.Parameter(word, inspect.Parameter.KEYWORD_ONLY, default=False, annotation=kind)
        for word, kind in flags.items()
    ]
    vars(run)["__signature__"] = signature.replace(parameters=[*signature.parameters.values(), *more])
    run.__annotations__ = {**command.__annotations__, **flags}
    app.command(name, short_help=_first_sentence(command))(run)


def _name_value(annotation: Any) -> None:
    """Say in words what an option takes that does not say it itself: Typer would write "<int range>"."""
    kind, *about = get_args(annotation) or (annotation,)
    taken = {int: "N", float: "NUMBER", str: "WORD"}
    for option in about:
        if isinstance(option, OptionInfo) and option.metavar is None:
            option.metavar = next((taken[one] for one in get_args(kind) or (kind,) if one in taken), None)


def _first_sentence(command: Callable[..., None]) -> str:
    text = inspect.cleandoc(command.__doc__ or "").split("\n\n")[0].replace("\n", " ")
    plain = re.sub(r"\[(\w+)\]", r"'\1'", text)  # shells complete with it, and brackets are markup to Typer
    return plain.split(". ")[0].rstrip(".") + "."
