"""``viscorod plot``: one picture of a result."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from viscorod.cli.completion import words
from viscorod.cli.files import motion, opened
from viscorod.cli.options import ResultFile, output_option
from viscorod.cli.terminal import readable_errors, written
from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.results.result import Result

__all__ = ["plot"]

KINDS = ("tip", "energy", "strain", "space-time", "modes", "phase")
_TAKES = {
    "place": ("tip", "phase"),
    "axis": ("tip", "phase"),
    "rod": ("strain", "space-time"),
    "component": ("strain", "space-time"),
    "quantity": ("space-time",),
    "count": ("modes",),
    "about": ("modes",),
}


def plot(
    result: ResultFile,
    what: Annotated[str, typer.Option(metavar="KIND", help=", ".join(KINDS), autocompletion=words(*KINDS))],
    output: Annotated[
        Path | None,
        output_option("FILE", "Picture, .png, .pdf or .svg [default: KIND.png beside the result]"),
    ] = None,
    place: Annotated[
        str | None, typer.Option(help="Of tip and phase [default: what moves most]", show_default=False)
    ] = None,
    axis: Annotated[
        str | None,
        typer.Option(
            help="Of tip and phase: x, y or z [default: that of most motion]",
            show_default=False,
            autocompletion=words("x", "y", "z"),
        ),
    ] = None,
    rod: Annotated[str | None, typer.Option(help="Of strain and space-time.")] = None,
    component: Annotated[
        str | None,
        typer.Option(
            help="Of strain and space-time: shear_1, shear_2, stretch, bend_1, bend_2 or twist.",
            autocompletion=words("shear_1", "shear_2", "stretch", "bend_1", "bend_2", "twist"),
        ),
    ] = None,
    quantity: Annotated[
        str | None,
        typer.Option(
            help="Of space-time: strain, section_force or dissipation [default: section_force]",
            show_default=False,
            autocompletion=words("strain", "section_force", "dissipation"),
        ),
    ] = None,
    count: Annotated[
        int | None, typer.Option(min=1, help="Number of modes [default: 6]", show_default=False)
    ] = None,
    about: Annotated[
        str | None,
        typer.Option(
            help="Of modes: equilibrium (at t = 0-), released (just after t = 0) or reference "
            "[default: equilibrium]",
            show_default=False,
            autocompletion=words("equilibrium", "released", "reference"),
        ),
    ] = None,
) -> None:
    """Draw one picture of a result.

    tip: displacement of one place with its decay. energy: the account. strain: the largest of every component, and one
    along a rod. space-time: one component over arc length and time. modes: small vibrations of the model, which is
    rebuilt from the result. phase: velocity over displacement.
    """
    with readable_errors():
        given = {
            "place": place,
            "axis": axis,
            "rod": rod,
            "component": component,
            "quantity": quantity,
            "count": count,
            "about": about,
        }
        if what not in KINDS:
            raise InputError(Fault("--what", what, "no such picture", f"give one of {', '.join(KINDS)}"))
        for option, value in given.items():
            if value is not None and what not in _TAKES[option]:
                raise InputError(
                    Fault(
                        f"--{option}", str(value), f"goes with {' and '.join(_TAKES[option])}", "leave it out"
                    )
                )
        target = output or result.with_name(f"{what}.png")
        found = opened(result) if what in ("modes", "strain") else motion(result, f"--what {what}")
        if what == "modes":
            _draw_modes(found, target, count or 6, about)
        else:
            taken = {key: value for key, value in given.items() if value is not None}
            getattr(found, f"plot_{what.replace('-', '_')}")(target, **taken)
        written([target], first=True)


def _draw_modes(result: Result, target: Path, count: int, about: str | None) -> None:
    """Draw the modes of the model that the result was computed from, or of the rotation that it is."""
    from viscorod.analyses.case_run import as_model
    from viscorod.casefile.case import case_from_dict
    from viscorod.results.steady_result import Steady

    if isinstance(result, Steady):
        if about is not None:
            raise InputError(
                f"--about: {about}: the modes of a steady rotation are those about its own shape"
            )
        result.plot_modes(target, count)
        return
    content = json.loads(result.data.attrs.get("case", "{}"))
    try:
        case = case_from_dict({**content, "equilibrium": {}})
    except InputError as error:
        raise InputError(f"the model in this result cannot be rebuilt for its modes: {error}") from None
    model = as_model(case.description)
    model.modes(count, about=cast(Any, about or "equilibrium"), title=result.title).plot(target)
