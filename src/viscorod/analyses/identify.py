"""Identification: numbers of cases from records of measurements, with intervals that hold."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from viscorod.analyses.identification.case_predictions import CasePredictions
from viscorod.analyses.identification.common_faults import common_faults
from viscorod.analyses.identification.faults_without_time import faults_without_time
from viscorod.analyses.identification.finer_steps import steps_told
from viscorod.analyses.identification.fit_dataset import fit_dataset
from viscorod.analyses.identification.in_programs import in_programs
from viscorod.analyses.identification.laws import compared_laws, require_laws
from viscorod.analyses.identification.named_combinations import Combination, combinations
from viscorod.analyses.identification.record_frequencies import dominant_frequencies
from viscorod.analyses.identification.search import Fitted, fitted
from viscorod.analyses.identification.sought import Range
from viscorod.analyses.identification.told import missed, sentences_of
from viscorod.analyses.identification.unit_of import unit_of
from viscorod.argument_names import telling
from viscorod.casefile.case import Case
from viscorod.casefile.toml_text import toml_text
from viscorod.errors import Fault, InputError, SolveError
from viscorod.model.fields.definition import show
from viscorod.one_thread import one_blas_thread
from viscorod.records.held_samples import HELD, without_held
from viscorod.records.motion_record import Record
from viscorod.results.identification import Identification
from viscorod.solve.estimation.intervals import Interval, intervals
from viscorod.solve.estimation.least_squares import Scaled, searched
from viscorod.solve.estimation.posterior import drawn
from viscorod.typing import Floats

__all__ = ["identify"]

HELD_WITHIN = 1e-9
"""Distance between bounds, in logarithms, of a number that a profile holds."""
Pairs = Sequence[tuple[Case, Any]]


@one_blas_thread()
@telling
def identify(
    case: Case | Pairs,
    records: Any = None,
    parameters: Mapping[str, Range] | Sequence[str] = (),
    nuisances: Mapping[str, Range] | Sequence[str] = (),
    *,
    starts: int = 1,
    robust: bool = False,
    coloured: bool = True,
    level: float = 0.95,
    profile: bool = True,
    seed: int = 0,
    laws: Sequence[str] = (),
    left_out: Pairs = (),
    draws: int = 0,
    report: Callable[[str], None] | None = None,
) -> Identification:
    """Find numbers of cases so that they predict what was measured, with intervals.

    The unknowns minimise the sum of squares of measured less predicted values over their noise, which is estimated
    from what is left; the residuals of regular histories may be correlated in time (an autoregression, feasible
    generalised least squares). Positive numbers are sought by their logarithms. Rods keep the mesh that they have
    at the start.

    Args:
        case: a case whose analysis gives what was measured; or a list of pairs (case, record or records), where several
            cases share parameters.
        records: of the one case: a record, or several.
        parameters: key of a number of the cases -> its start, ``(low, start, high)``, or None for what the case
            has; or a list of keys. "a, b" are two numbers that are equal. Keys are those of the case file, as in
            `sweep`.
        nuisances: the same for numbers that are not wanted but not known either: more keys of the case, or the names of
            unknowns of records ("tip.release_time", or "release_time" of all records) where another start or
            bounds than theirs are wanted. Unknowns of records are always fitted.
        starts: how many starts are tried; those after the first are spread between the bounds, or within a factor of
            ten.
        robust: let residuals beyond 1.35 standard deviations count less (Huber).
        coloured: whether the noise of regular histories may be correlated in time.
        level: probability of the intervals.
        profile: check Laplace's intervals by the sum of squares at their ends, and take the profile likelihood
            where they are skewed; not of a model that misses part of the motion, whose intervals do not hold.
        seed: of the further starts.
        laws: of damping that are compared on the same records, in place of that of the case: "elastic",
            "kelvin_voigt", "flat_loss" (a loss factor that does not depend on frequency), "branches 2" (Maxwell
            branches, 1 to 8), and with these, after a "+", "air_drag" and "clamp_loss"; that of the case is one more
            where numbers of it are among the parameters. The result is that of the law that comes off best.
        left_out: pairs of cases and records that are not fitted; laws are compared by how they predict them.
        draws: of the posterior, by Markov chains (the extra ``viscorod[posterior]``), each one evaluation or so; 0 for
            none.
        report: called with a sentence after every search.

    Returns:
        The numbers, their intervals, what is left, and what the data cannot tell.

    Raises:
        InputError: a key, a range or a record is wrong; nothing has been computed.
        SolveError: no start can be computed.
    """
    began = time.perf_counter()
    _require_settings(level, starts, draws)
    pairs, wanted, other = pairs_of(case, records), as_ranges(parameters), as_ranges(nuisances)
    aside = pairs_of(left_out, None) if left_out else []
    pairs, held = _without_held(pairs)
    aside, held_aside = _without_held(aside)
    require_laws([*pairs, *aside], laws)
    compared = compared_laws(fitted, pairs, wanted, other, laws, aside, report) if laws else None
    if compared is not None:
        pairs, wanted = list(compared.pairs), dict(compared.parameters)
    found = fitted(
        pairs,
        wanted,
        other,
        starts=starts,
        robust=robust,
        coloured=coloured,
        seed=seed,
        report=report,
        begin=compared.found.named if compared is not None else None,
    )
    # those of a model that misses the motion do not hold in any case, and its sum of squares has no shape to follow
    limits = _intervals(found, level, profile=profile and not missed(found.estimate))
    told, programs, no_programs = _told_of_laws(found, level)
    units = {name: unit_of(found.members, name) for name in found.unknowns.names}
    sentences = [
        *held,
        *held_aside,
        *common_faults(found.members, found.estimate),
        *faults_without_time(found.members, found.estimate),
        *sentences_of(found.estimate, found.known, limits, told, units),
        *steps_told(found, pairs),
        *no_programs,
    ]
    if compared is not None:
        compared = compared.ended_in(found)
        sentences = [*compared.sentences, *sentences]
    attrs = _course(found) | {
        "level": level,
        "robust": int(robust),
        "wall_time_s": time.perf_counter() - began,
        "sentences": json.dumps(sentences),
        "missed": json.dumps(missed(found.estimate, moved=compared is not None and compared.moved)),
    }
    chains = drawn(found.estimate, found.known, _square(found), draws, seed) if draws else None
    return Identification(fit_dataset(found, limits, told, programs, attrs, compared, chains))


def _require_settings(level: float, starts: int, draws: int) -> None:
    """Refuse numbers of an identification that are out of their range."""
    if not 0.0 < level < 1.0:
        raise InputError(Fault("level", show(level), "it lies between 0 and 1", "give 0.95"))
    if isinstance(starts, bool) or not isinstance(starts, int) or starts < 1:
        raise InputError(Fault("starts", show(starts), "a whole number of at least 1 is needed", "give 1"))
    if isinstance(draws, bool) or not isinstance(draws, int) or draws < 0:
        raise InputError(Fault("draws", show(draws), "a whole number of at least 0 is needed", "give 2000"))


def _told_of_laws(found: Fitted, level: float) -> tuple[list[Combination], list[Combination], list[str]]:
    """Return what the data tell of the damping of the first case.

    Returns:
        Combinations of its numbers that they tell, its damping in the words of other programs, and sentences where
        these have none.
    """
    case, hertz = found.cases()[0], dominant_frequencies(found.members)[0]
    numbers = found.unknowns, found.estimate.z, found.known
    return combinations(case, *numbers, hertz, level), *in_programs(case, *numbers, hertz, level)


def _course(found: Fitted) -> dict[str, Any]:
    """Return the attributes of a fit about how it was found."""
    cases = found.cases()
    return {
        "title": cases[0].title,
        "outcome": "completed",
        "evaluations": found.estimate.evaluations,
        "starts": found.estimate.starts,
        "agreeing_starts": found.estimate.agreeing,
        "unsettled": found.estimate.unsettled,
        "cases": json.dumps([toml_text({"title": one.title, **one.content}) for one in cases]),
        "records": json.dumps([record.name for member in found.members for record in member.records]),
        "doubts": json.dumps([text for member in found.members for text in member.doubts]),
    }


def pairs_of(case: Case | Pairs, records: Any) -> list[tuple[Case, Any]]:
    """Return the pairs of cases and records.

    Raises:
        InputError: something else was given.
    """
    if isinstance(case, Case):
        given = list(records) if isinstance(records, list | tuple) else [records]
        pairs = [(case, record) for record in given]
    else:
        if records is not None:
            raise InputError(Fault("records", "", "pairs of cases and records have theirs", "leave it out"))
        pairs = [
            (one, record)
            for one, several in case
            for record in (several if isinstance(several, list | tuple) else [several])
        ]
    faults = [
        Fault(f"records[{k}]", show(record), "this is no record", "give a viscorod.Record")
        for k, (_, record) in enumerate(pairs)
        if not (hasattr(record, "observed") and hasattr(record, "predicted"))
    ]
    faults += [
        Fault(f"cases[{k}]", show(one), "this is no case", "give what viscorod.load_case returns")
        for k, (one, _) in enumerate(pairs)
        if not isinstance(one, Case)
    ]
    if not pairs:
        faults.append(Fault("records", "", "there is none", "give at least one"))
    names = [getattr(record, "name", "") for _, record in pairs]
    faults += [
        Fault(f"records[{k}].name", show(name), "another record has this name", "give each its own name")
        for k, name in enumerate(names)
        if name in names[:k]
    ]
    if faults:
        raise InputError(faults)
    return pairs


def _without_held(pairs: Pairs) -> tuple[list[tuple[Case, Any]], list[str]]:
    """Return pairs whose histories have the first of samples that were held, and a sentence on each that had."""
    found, told = [], []
    for case, record in pairs:
        free, held = without_held(record) if isinstance(record, Record) else (record, 1)
        found.append((case, free))
        if held > 1:
            told.append(f"Every value of {record.name} {HELD.format(held)}.")
    return found, told


def as_ranges(given: Mapping[str, Range] | Sequence[str]) -> dict[str, Range]:
    """Return the keys with what is said of them."""
    if isinstance(given, Mapping):
        return {str(key): value for key, value in given.items()}
    return dict.fromkeys([given] if isinstance(given, str) else map(str, given))


def _scaled(found: Fitted) -> Scaled:
    """Return the predictions of a fit by the coordinates of its unknowns."""
    unknowns = found.unknowns
    believed = [one.label for one in found.estimate.noise.series if one.certain]
    numbers = [unknowns.names.index(label.removesuffix(" beforehand")) for label in believed]
    return Scaled(CasePredictions(found.members, unknowns, numbers), unknowns, held=found.estimate.z)


def _square(found: Fitted, scaled: Scaled | None = None) -> Callable[[Floats], float]:
    """Return the sum of squares of a fit in units of its noise, as a function of the coordinates."""
    best, predictions = found.estimate, scaled or _scaled(found)

    def square(z: Floats) -> float:
        white = best.noise.whitened(best.measured - predictions.values(z))
        return float(white @ white)

    return square


def _intervals(found: Fitted, level: float, *, profile: bool) -> list[Interval]:
    best, unknowns = found.estimate, found.unknowns
    scaled = _scaled(found)
    square = _square(found, scaled)

    def profiled(k: int, value: float, start: Floats) -> tuple[float, Floats]:
        low, high = (bound.copy() for bound in unknowns.bounds)
        low[k], high[k] = value - HELD_WITHIN, value + HELD_WITHIN
        begin = np.where(np.arange(len(start)) == k, value, start)
        z = searched(scaled, best.measured, best.noise, (low, high), begin, unknowns.start)
        return square(z), z

    if not profile:
        return intervals(best, found.known, level)
    try:
        return intervals(best, found.known, level, square, profiled)
    except (SolveError, InputError):  # the model cannot be computed that far away
        return intervals(best, found.known, level)
