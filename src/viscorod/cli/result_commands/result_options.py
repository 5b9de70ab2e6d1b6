"""What the commands on results are given: a file, numbers of a range."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.results.run import Equilibrium, Run
    from viscorod.results.steady_result import Steady
    from viscorod.typing import Floats

__all__ = ["ResultFile", "motion", "numbers", "opened"]

ResultFile = Annotated[
    Path, typer.Argument(metavar="RUN.nc", help="File that `viscorod run` or `save` wrote.")
]

_MOST = 10_000_000


def opened(path: Path) -> Run | Equilibrium | Steady:
    """Return the result in a file.

    Raises:
        InputError: no such file, or it holds a sweep.
    """
    from viscorod.results.files.storage import load
    from viscorod.results.sweep_result import Sweep

    found = load(path)
    if isinstance(found, Sweep):
        raise InputError(
            Fault(
                str(path), "", "this is a sweep of several runs", "save one of them: sweep[0].run.save(...)"
            )
        )
    return found


def motion(path: Path, what: str) -> Run:
    """Return the run in a file; ``what`` is said to need one.

    Raises:
        InputError: no such file, or it holds no motion over time.
    """
    from viscorod.results.run import Run

    found = opened(path)
    if not isinstance(found, Run):
        raise InputError(
            Fault(
                str(path),
                f"kind = {found.kind!r}",
                f"{what} needs a motion over time",
                "give the run.nc of a case with [simulate]",
            )
        )
    return found


def numbers(option: str, text: str, unit: str) -> Floats:
    """Return the numbers of "0:1:0.01" (from, to, step; the end counts), of "0.1,0.25", or one number.

    Raises:
        InputError: it is none of these.
    """
    import numpy as np  # here, so that help is instant

    try:
        if ":" in text:
            first, last, step = map(float, text.split(":"))
            count = (last - first) / step
            if not (np.isfinite([first, last, step]).all() and 0.0 <= count < _MOST):
                raise ValueError
            return np.asarray(first + step * np.arange(int(np.floor(count + 1e-9)) + 1))
        found = np.array([float(word) for word in text.split(",")])
        if np.isfinite(found).all():
            return found
    except (ValueError, ZeroDivisionError):
        pass
    raise InputError(
        Fault(
            option,
            text,
            f"no numbers in {unit}",
            "write FROM:TO:STEP such as 0:1:0.01, or numbers such as 0.1,0.25",
        )
    )
