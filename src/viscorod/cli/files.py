"""Files and folders that the user names: cases and results read, folders written to."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from viscorod.errors import Fault, InputError

if TYPE_CHECKING:
    from viscorod.casefile.case import Case
    from viscorod.model.rod import Rod
    from viscorod.results.any_result import AnyResult
    from viscorod.results.buckling import Buckling
    from viscorod.results.equilibrium_result import Equilibrium
    from viscorod.results.modes_result import Modes
    from viscorod.results.run import Run
    from viscorod.results.steady_result import Steady

__all__ = ["existing", "motion", "opened", "picture_at", "rod_of", "writable"]


def existing(case: Path) -> Path:
    """Return the path of a case file that exists.

    Raises:
        InputError: there is no such file, or it is a result.
    """
    if not case.is_file():
        raise InputError(f"{case} is not a file; {_hint(case)}")
    if case.suffix == ".nc":
        raise InputError(f"{case} is a result, no case file; read it with: viscorod report {case}")
    return case


def _hint(case: Path) -> str:
    """Return what was probably meant: a file beside it, or a shipped case."""
    from viscorod.casefile.shipped import shipped_cases
    from viscorod.wording import nearest

    folder = case.parent
    beside = sorted(path.stem for path in folder.glob("*.toml")) if folder.is_dir() else []
    if close := nearest(case.stem, beside):
        return f"did you mean {folder / close}.toml?"
    known = case.stem if case.stem in shipped_cases() else "NAME"
    return f"name a case file, or copy one with: viscorod example {known}"


_ENDINGS = frozenset({".csv", ".gif", ".html", ".mp4", ".nc", ".pdf", ".png", ".svg"})
"""Of names that are no folders; one named after its case file is."""


def writable(folder: Path) -> Path:
    """Return a folder that can be written, before anything is computed for it.

    Raises:
        InputError: it cannot be written, or has the name of a file.
    """
    if folder.suffix in _ENDINGS and not folder.is_dir():
        raise InputError(
            f"{folder}: this is the name of a file, and several are written into a folder: name one with -o"
        )
    there = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        raise InputError(
            f"{folder} cannot be written: {there} is not a folder you can write to; name another with -o"
        )
    return folder


def picture_at(plot: Callable[..., object], path: Path, *arguments: object) -> Path:
    """Write the picture of a result, by its method; return the path."""
    plot(path, *arguments)
    return path


def rod_of(case: Path, name: str | None) -> tuple[str, Rod]:
    """Return a rod of a case file, with its name.

    Raises:
        InputError: the file is wrong, has no such rod, or has several and none was named.
    """
    from viscorod.casefile.case import load_case
    from viscorod.model.fields.definition import did_you_mean, some_of

    rods = load_case(existing(case)).description.rods
    if name is None and len(rods) == 1:
        return next(iter(rods.items()))
    if name in rods:
        return name, rods[name]
    names = some_of(rods)
    if name is None:
        raise InputError(Fault("--rod", "", f"the case has {len(rods)} rods", f"give one of {names}"))
    advice = did_you_mean(name, rods, str)
    raise InputError(Fault("--rod", name, "the case has no such rod", f"{advice}It has {names}"))


def case_for(kind: str, path: Path) -> Case:
    """Return the case of a file that asks for an analysis, by its table.

    Raises:
        InputError: no such file, something in it is wrong, or it asks for another analysis.
    """
    from viscorod.casefile.analysis_tables import ANALYSES
    from viscorod.casefile.case import load_case

    case = load_case(existing(path))
    if case.kind != kind:
        raise InputError(
            Fault(
                case.kind,
                "",
                "the case asks for another analysis",
                f"give a table [{kind}] in its place, with {ANALYSES[kind].needs}",
            )
        )
    return case


def opened(path: Path) -> Run | Equilibrium | Steady | Modes | Buckling:
    """Return the result in a file.

    Raises:
        InputError: no such file, or it holds a sweep, a response, followed modes or periodic motions.
    """
    from viscorod.results.files.storage import load
    from viscorod.results.result import Result
    from viscorod.results.sweep_result import Sweep

    found: AnyResult | Sweep = load(path)
    if isinstance(found, Sweep):
        raise InputError(
            Fault(
                str(path),
                "",
                "this is a sweep of several runs",
                "save one of them in Python: viscorod.load(path).members[0].result.save(...)",
            )
        )
    if not isinstance(found, Result):
        raise InputError(
            Fault(
                str(path),
                "",
                f"this is a {found.what}, which has no states of a model",
                f"viscorod {found.kind} writes its pictures; in Python: viscorod.load(path).plot(...)",
            )
        )
    return found


def motion(path: Path, what: str) -> Run:
    """Return the run in a file; `what` names, for the message, what needs one.

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
