"""The search of an identification: from the starts, and led by the first cycles where these end out of step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from viscorod.analyses.identification.case_numbers import case_with
from viscorod.analyses.identification.case_predictions import CasePredictions
from viscorod.analyses.identification.faults_without_time import of_another_kind
from viscorod.analyses.identification.finer_steps import finer, moved_by, on_meshes_of
from viscorod.analyses.identification.growing_windows import growing_windows, out_of_step
from viscorod.analyses.identification.members import Member, members_of
from viscorod.analyses.identification.sought import Range, series_of, sought
from viscorod.casefile.case import Case
from viscorod.errors import Fault, InputError, SolveError
from viscorod.solve.estimation.intervals import Covariance, covariance
from viscorod.solve.estimation.least_squares import Estimate, estimate
from viscorod.solve.estimation.unknowns import Unknowns
from viscorod.typing import Floats

__all__ = ["Fitted", "fitted"]

BETTER = 0.5
"""Sum of squares by which a search that the first cycles led is taken in place of that from the start."""
REFINED = 4
"""Times that steps are made ten times as fine."""
Pairs = Sequence[tuple[Case, Any]]


@dataclass(frozen=True, eq=False)
class Fitted:
    """A fit before it is a result: what was fitted, the estimate, what is known of it."""

    members: list[Member]
    estimate: Estimate
    known: Covariance

    @property
    def unknowns(self) -> Unknowns:
        """The unknowns."""
        return self.estimate.unknowns

    @property
    def named(self) -> dict[str, float]:
        """The fitted numbers by name."""
        return dict(zip(self.unknowns.names, self.estimate.values.tolist(), strict=True))

    def cases(self) -> list[Case]:
        """Return the cases with the fitted numbers, settings as they were."""
        return [case_with(member.case, member.numbers(self.named)) for member in self.members]


def fitted(
    pairs: Sequence[tuple[Case, Any]],
    parameters: Mapping[str, Range],
    nuisances: Mapping[str, Range],
    *,
    starts: int = 1,
    robust: bool = False,
    coloured: bool = True,
    seed: int = 0,
    report: Callable[[str], None] | None = None,
    only_nuisances: bool = False,
    begin: Mapping[str, float] | None = None,
) -> Fitted:
    """Fit, and return what `identify` makes a result of.

    With ``only_nuisances`` there may be no parameters; the first start is at the unknowns of ``begin``. Where model and
    record end out of step, the search is tried once more, led by the first cycles. Steps are refined until they do not
    move the numbers.
    """
    given = _Search(parameters, nuisances, robust, seed, only_nuisances)
    found = given.fitted(members_of(pairs), starts, begin or {}, coloured=coloured, report=report)
    if starts == 1 and out_of_step(found) and not of_another_kind(found.members, found.estimate):
        led = _led_by_first_cycles(given, pairs, found, coloured=coloured)
        if led is not None and _misfit(led) < BETTER * _misfit(found):
            if report is not None:
                squares = f"{_misfit(led):.6g} in place of {_misfit(found):.6g}"
                report(f"led by the first cycles: sum of squares {squares}")
            found = led
    found = _with_finer_steps(given, pairs, found, coloured=coloured, report=report)
    return replace(found, estimate=replace(found.estimate, evaluations=sum(given.evaluations)))


def _with_finer_steps(
    given: _Search, pairs: Pairs, found: Fitted, *, coloured: bool, report: Callable[[str], None] | None
) -> Fitted:
    """Return the fit with steps whose errors do not move its numbers, of cases that leave their tolerance open."""
    for _ in range(REFINED):
        refined = finer(pairs, found, given=False)
        try:
            moved = [] if refined is None else moved_by(found, refined)
            if refined is None or not moved:
                break
            if report is not None:
                report(f"steps ten times as fine, which had moved {', '.join(name for name, _ in moved)}")
            pairs = refined
            found = given.fitted(on_meshes_of(found, pairs), 1, found.named, coloured=coloured)
        except (SolveError, InputError):
            break
    return found


@dataclass(frozen=True)
class _Search:
    """What is sought, and how; with the evaluations of every fit so far."""

    parameters: Mapping[str, Range]
    nuisances: Mapping[str, Range]
    robust: bool
    seed: int
    only_nuisances: bool
    evaluations: list[int] = field(default_factory=list)

    def fitted(
        self,
        members: list[Member],
        starts: int,
        begin: Mapping[str, float],
        *,
        coloured: bool,
        report: Callable[[str], None] | None = None,
        exact: bool = True,
    ) -> Fitted:
        unknowns, beliefs = sought(members, self.parameters, self.nuisances, free=self.only_nuisances)
        measured, series = series_of(members, unknowns, beliefs)
        if len(measured) <= len(unknowns):
            found = f"{len(measured)} values for {len(unknowns)} unknowns"
            raise InputError(
                Fault("records", found, "there must be more values", "measure more, or seek less")
            )
        best = estimate(
            CasePredictions(members, unknowns, [number for number, *_ in beliefs], exact=exact),
            measured,
            series,
            unknowns,
            starts=starts,
            robust=self.robust,
            coloured=coloured,
            seed=self.seed,
            report=report,
            begin=_coordinates(unknowns, begin),
        )
        self.evaluations.append(best.evaluations)
        return Fitted(members, best, covariance(best))


def _led_by_first_cycles(given: _Search, pairs: Pairs, first: Fitted, *, coloured: bool) -> Fitted | None:
    """Return a fit whose start is that of the first cycles; None where these cannot be fitted."""
    begin: dict[str, float] = {}
    try:
        for short in growing_windows(pairs):
            led = given.fitted(on_meshes_of(first, short), 1, begin, coloured=False, exact=False)
            begin = led.named
        return given.fitted(on_meshes_of(first, pairs), 1, begin, coloured=coloured) if begin else None
    except (SolveError, InputError):
        return None


def _misfit(found: Fitted) -> float:
    """Return the sum of squares over the noise that was told, or the spread of the values."""
    best = found.estimate
    off = best.measured - best.predicted
    return sum(float(np.sum((off[one.rows] / one.noise) ** 2)) for one in best.noise.series)


def _coordinates(unknowns: Unknowns, named: Mapping[str, float]) -> Floats:
    """Return where a search begins: at numbers that are known, else at the starts."""
    return unknowns.coordinates(np.array([named.get(one.name, one.start) for one in unknowns]))
