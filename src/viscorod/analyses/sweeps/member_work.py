"""One member of a sweep, where its worker is: its values, its computation, what is kept of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from viscorod.analyses.case_run import run_case
from viscorod.analyses.sweeps.looked import Looked
from viscorod.analyses.sweeps.processes import FAILED
from viscorod.analyses.sweeps.rows import Row
from viscorod.casefile.case import Case, case_from_dict, is_plain
from viscorod.casefile.case_keys import put_all
from viscorod.casefile.known_parts import KnownParts
from viscorod.errors import InputError, SolveError, came_of_interrupt
from viscorod.results.files.sweep_folder import SweepFolder
from viscorod.results.quantities import Quantity, evaluated
from viscorod.results.sweep_figures import figures_of
from viscorod.results.sweep_members import COMPLETED, NOT_KEPT, NOT_RUN, Found
from viscorod.solve.settings.course import Course
from viscorod.solve.settings.motion import SimulateSettings
from viscorod.whole_files import why_not

__all__ = ["MemberWork"]

Job: TypeAlias = tuple[Row, str, bool, Case | None]
"""Values of a member, its name, whether its errors are estimated, and its case where that was read already."""

OUTPUTS = 200
"""Stored states of a run whose case gives no output_interval."""
UNFINISHED = ("interrupted", NOT_RUN)
"""Outcomes of members that are computed again by the next call."""


def member_content(
    content: Mapping[str, Any], source: Path | None, row: Row, keep: bool, known: KnownParts | None = None
) -> tuple[dict[str, Any], str]:
    """Return the content of the case file of a member, and what was chosen for it.

    Args:
        content, source: of the case; row: the values of the member.
        keep: whether its whole result is kept.
        known: parts of other members.

    Raises:
        InputError: there is no such key, or what is there is wrong.
    """
    own = _apart(dict(content))
    put_all(own, row)
    table = own.get("simulate")
    if keep and isinstance(table, dict) and "output_interval" not in table:
        settings = case_from_dict(own, source, known=known).settings
        if not isinstance(settings, SimulateSettings):
            return own, ""
        table["output_interval"] = interval = settings.duration / OUTPUTS
        return own, f"output_interval = {interval:g} s, a {OUTPUTS}th of the duration: the case gives none"
    return own, ""


def member_case(
    content: Mapping[str, Any], source: Path | None, title: str, row: Row, keep: bool, known: KnownParts
) -> tuple[Case, str]:
    """Return the case of a member, and what was chosen for it; the arguments are those of `member_content`.

    Raises:
        InputError: a key or a value is wrong.
    """
    own, note = member_content(content, source, row, keep, known)
    numbers = all(type(value) in (int, float) for value in row.values())
    plain = numbers and known.judge(content, is_plain)
    return case_from_dict({"title": title, **own}, source, known=known, plain=plain), note


def _apart(value: Any) -> Any:
    """Return a content of its own: tables and lists are copied, what they hold never changes."""
    if isinstance(value, dict):
        return {key: _apart(item) for key, item in value.items()}
    return [_apart(item) for item in value] if isinstance(value, list) else value


@dataclass(frozen=True)
class MemberWork:
    """What is done with the values of a member, where its worker is.

    Attributes:
        content, title, source: of the case.
        quantities: that are computed of its result.
        keep: keep that result.
        folder: of the sweep, if it has one.
        known: parts of the members before, where they are computed.
    """

    content: Mapping[str, Any]
    title: str
    source: Path | None
    quantities: tuple[Quantity, ...]
    keep: bool
    folder: SweepFolder | None
    known: KnownParts = field(default_factory=KnownParts, compare=False, repr=False)

    def __call__(self, job: Job, tell: Callable[[float], None], stopped: Callable[[], bool]) -> Found:
        """Compute one member and record it."""
        row, name, errors, read = job
        try:
            case = self._case(row)[0] if read is None else read
        except InputError as error:
            found: Found = None, str(error), "refused"
        else:
            found = _compute(case, errors, tell, stopped)
        result, message, outcome = found
        numbers, wrong = evaluated(self.quantities, result if outcome == COMPLETED else None)
        doubts = result.warnings if result is not None and outcome == COMPLETED else []
        parts = {
            "message": "; ".join(filter(None, [message, *wrong, *(f"warning: {text}" for text in doubts)])),
            "outcome": outcome,
            "quantities": numbers,
            "measured": {} if self.keep and self.folder is None else figures_of(result),
        }
        return self._kept(name, parts, result if self.keep else None)

    def _case(self, row: Row) -> tuple[Case, str]:
        """Return the case of a member, and what was chosen for it.

        Raises:
            InputError: a key or a value is wrong.
        """
        return member_case(self.content, self.source, self.title, row, self.keep, self.known)

    def looked_at(self, rows: Mapping[int, Row]) -> tuple[Looked, dict[int, Case]]:
        """Return what there is to say of the values of members, by their numbers, and their cases."""
        looked, read = Looked(), dict[int, Case]()
        for number, row in rows.items():
            try:
                read[number], note = self._case(row)
            except InputError as error:
                looked.refuse(error, number)
            else:
                looked.chosen |= {number: note} if note else {}
        return looked, read

    def look(self, rows: Mapping[int, Row]) -> Looked:
        """Return what there is to say of the values of members, by their numbers."""
        return self.looked_at(rows)[0]

    def died(self, job: Job, why: str) -> Found:
        """Record a member whose workers died of it, or were lost; the next call does not try it again by itself."""
        parts = {"message": why, "outcome": FAILED, "quantities": {}, "measured": {}}
        return self._kept(job[1], parts, None)

    def _kept(self, name: str, parts: Mapping[str, Any], result: Any) -> Found:
        """Return what is known of a member, on disk if there is a folder and it is finished."""
        if self.folder is None or parts["outcome"] in UNFINISHED:
            return result, *parts.values()
        try:
            return self.folder.add(name, parts, result), *parts.values()
        except OSError as error:  # a full disk, a quota; the next call computes it again
            why = f"it cannot be kept in {self.folder.path} ({why_not(error, self.folder.path / name)})"
            return None, why, NOT_KEPT, parts["quantities"], parts["measured"]


class _Stop:
    """Returns why a member is to end, if it is.

    Attributes:
        patient: it may be called after some short steps that are taken at once, as in a run by itself.
    """

    patient = True

    def __init__(self, stopped: Callable[[], bool]) -> None:
        self._stopped = stopped

    def __call__(self) -> str:
        return "the sweep was stopped" if self._stopped() else ""


class _Told:
    """Passes on which part of a member is done.

    Attributes:
        patient: that it need not be after every one of the short steps that are taken at once.
    """

    patient = True

    def __init__(self, tell: Callable[[float], None], course: Course) -> None:
        self._tell, self._course = tell, course

    def __call__(self, reached: float, _step: float) -> None:
        self._tell(self._course.part(reached))


def _compute(case: Case, errors: bool, tell: Callable[[float], None], stopped: Callable[[], bool]) -> Found:
    """Do one member; whatever goes wrong is recorded, not raised."""
    try:
        progress = _Told(tell, case.settings.course)
        return (
            run_case(case, progress=progress, stop=_Stop(stopped), errors=errors),
            "",
            "completed",
        )
    except SolveError as error:
        without = "interrupted" if stopped() else "failed"
        return error.run, str(error), without if error.run is None else error.run.outcome
    except InputError as error:
        return None, str(error), "refused"
    except KeyboardInterrupt:
        return None, "interrupted from the keyboard", "interrupted"
    except Exception as error:  # one member's defect must not cost the others their results
        if came_of_interrupt(error):
            return None, "interrupted from the keyboard", "interrupted"
        return None, f"{type(error).__name__}: {error}", FAILED
