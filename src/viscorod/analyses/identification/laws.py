"""Laws of damping compared on the same data: by criteria of information, and by records that were left out."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.identification.case_numbers import case_with, number_at
from viscorod.analyses.identification.foretold import (
    amplitude_sentences,
    foretold,
    foretold_sentences,
    swings_of,
    unlike,
)
from viscorod.analyses.identification.law_sentences import EXCLUDED, law_sentences
from viscorod.analyses.identification.law_words import Frequencies, variant
from viscorod.analyses.identification.members import members_of
from viscorod.analyses.identification.moved_numbers import moved_numbers
from viscorod.analyses.identification.record_frequencies import dominant_frequencies, held_band
from viscorod.analyses.identification.sought import Range
from viscorod.analyses.identification.told import missed, number_text
from viscorod.analyses.identification.unit_of import unit_of
from viscorod.casefile.case import Case
from viscorod.errors import InputError, SolveError
from viscorod.results.identified import Foretold
from viscorod.results.run import Run
from viscorod.solve.estimation.information import criteria
from viscorod.solve.estimation.intervals import Covariance, covariance
from viscorod.solve.estimation.noise import Noise, noise_of
from viscorod.typing import Floats

if TYPE_CHECKING:
    from viscorod.analyses.identification.search import Fitted

__all__ = ["Compared", "compared_laws", "require_laws"]

Pairs = Sequence[tuple[Case, Any]]
Fit = Callable[..., "Fitted"]
OWN = "that of the case"
"""Name of the law that the case has, which is compared too where numbers of it are sought."""
TOO_NARROW = "too narrow, it misses part of the motion"
"""What is said beside the numbers of a law whose intervals do not hold."""


@dataclass(frozen=True, eq=False)
class Compared:
    """Laws on the same data, the best first.

    Attributes:
        columns: of the data set; words: names of the laws, and their numbers; sentences: what they say.
        foretold: free decays that were left out, by every law.
        pairs, parameters: of an identification with the best law; found: as it was compared; moved: whether the
            identification with it found other numbers.
    """

    columns: dict[str, Floats]
    words: list[list[str]]
    sentences: list[str]
    foretold: list[Foretold]
    pairs: Pairs
    parameters: Mapping[str, Range]
    found: Fitted
    moved: bool = False

    def ended_in(self, last: Fitted) -> Compared:
        """Return it with the numbers of the best law as the identification gives them, and whether they have moved.

        Laws are compared as if noise had no colour, and the result accounts for it. The two are estimates of the same
        numbers; where they differ by more than they are known, the law is wrong: J. A. Hausman, Econometrica 46 (1978)
        1251-1271.
        """
        words = [[self.words[0][0], _values(last, last.known)], *self.words[1:]]
        last_known, before_known = (last.estimate.z, last.known), (self.found.estimate.z, _known(self.found))
        units = [unit_of(last.members, name) for name in last.unknowns.names]
        moved = moved_numbers(last.unknowns, last_known, before_known, units)
        if not moved:
            return replace(self, words=words)
        text = (
            f"With the colour of the noise, as here, and without it, as laws were compared, {words[0][0]} has other "
            f"numbers, farther apart than their intervals: {', '.join(moved)}. A law that held would have the same."
        )
        return replace(self, words=words, sentences=[*self.sentences, text], moved=True)


@dataclass(frozen=True, eq=False)
class _One:
    name: str
    pairs: Pairs
    parameters: Mapping[str, Range]
    found: Fitted
    prediction: Fitted | None
    foretold: list[Foretold] = field(default_factory=list)

    @property
    def likelihood(self) -> float:
        """What is least for the best: the sum of n log of the mean square of every series."""
        best = self.found.estimate
        found = 0.0
        for one, noise in zip(best.noise.series, best.noise.found, strict=True):
            if not one.certain:
                size = noise.deviations(one) / noise.factor
                square = max(float(np.mean((best.residuals[one.rows] / size) ** 2)), 1e-300)
                found += one.count * float(np.log(square)) + 2.0 * float(np.sum(np.log(size / one.noise)))
        return found


def compared_laws(
    fit: Fit,
    pairs: Pairs,
    parameters: Mapping[str, Range],
    nuisances: Mapping[str, Range],
    laws: Sequence[str],
    left_out: Pairs = (),
    report: Callable[[str], None] | None = None,
) -> Compared:
    """Fit several laws to the same records, and predict others with them.

    Every law has the same other parameters; those of the damping of the material are exchanged for its own. Sums
    of squares are in units of the noise that the best law leaves; its autocorrelation gives the effective number
    of values.

    Args:
        fit: `analyses.identification.search.fitted`.
        pairs, parameters, nuisances: of the identification.
        laws: words, see `law_words`.
        left_out: cases with records that are not fitted, but predicted; numbers of their measurement are fitted.
        report: called with a sentence after every law.

    Raises:
        InputError: a word is not known, or a case does not fit it.
    """
    swings = swings_of(left_out)
    done = []
    for law in _fitted_laws(fit, pairs, parameters, nuisances, laws, left_out, report):
        says: list[Foretold] = []
        if law.prediction is not None:
            says = foretold(law.name, law.found, _known(law.found), law.prediction, swings)
        done.append(replace(law, foretold=says))
        if report is not None:
            report(f"law {law.name}: fitted")
    if not done:
        raise SolveError("no law could be fitted", None)
    told = [one for law in done for one in law.foretold]
    apart = unlike(told, swings)
    done, columns, count = _ranked(done, apart)
    names = [one.name for one in done]
    words = [[one.name, _values(one.found, _known(one.found))] for one in done]
    shares = {one.name: _lost_outside(one) for one in done if "air_drag" in one.name}
    sentences = [
        *law_sentences(
            names,
            columns["law_aicc"],
            columns["law_prediction"],
            count,
            {name: share for name, share in shares.items() if share is not None},
            [one.name for one in done if "clamp_loss" in one.name and not _clamp_damps(one)],
            misses=bool(missed(done[0].found.estimate)),
            unsettled={one.name: one.found.estimate.unsettled for one in done},
        ),
        *foretold_sentences(told, apart, names[0]),
        *amplitude_sentences(swings_of(pairs), swings, names[0]),
    ]
    first = done[0]
    return Compared(columns, words, sentences, told, first.pairs, first.parameters, first.found)


def _fitted_laws(
    fit: Fit,
    pairs: Pairs,
    parameters: Mapping[str, Range],
    nuisances: Mapping[str, Range],
    laws: Sequence[str],
    left_out: Pairs,
    report: Callable[[str], None] | None,
) -> Iterator[_One]:
    """Fit one law after another, simple ones first: others begin with the numbers of those that are parts of them."""
    hertz = _frequencies(pairs, left_out)
    damping = tuple(f"materials.{name}.damping" for name in pairs[0][0].content.get("materials", {}))
    own = any(key.startswith(damping) for key in parameters)
    done: list[_One] = []
    for name in sorted([*laws, *([OWN] if own else [])], key=lambda name: name.count("+")):
        begin = _within(name, done)
        one = _fitted(fit, pairs, parameters, nuisances, name, left_out, hertz, begin)
        if isinstance(one, _One):
            done.append(one)
            yield one
        elif report is not None:
            report(f"law {name}: {one}")


def _ranked(done: Sequence[_One], apart: Collection[str]) -> tuple[list[_One], dict[str, Floats], float]:
    """Return fitted laws, the best first, their columns of a data set, and the effective number of measured values.

    Args:
        apart: names of laws that foretold what was not seen.
    """
    noise = _noise(min(done, key=lambda one: one.likelihood).found)
    count = noise.effective_count
    squares = {one.name: _square(noise, one.found) for one in done}
    merits = {
        one.name: criteria(squares[one.name], count, len(one.found.unknowns) + len(noise.series), noise.count)
        for one in done
    }
    least = min(merit[0] for merit in merits.values())

    def rank(one: _One) -> tuple[bool, bool, float]:
        merit = merits[one.name][0] - least
        return merit > EXCLUDED, one.name in apart, merit

    ranked = sorted(done, key=rank)
    aicc, bic = (np.array([merits[one.name][k] for one in ranked]) for k in (0, 1))
    predicted = [_error(one.prediction) if one.prediction is not None else 0.0 for one in ranked]
    columns: dict[str, Floats] = {
        "law_unknowns": np.array([float(len(one.found.unknowns)) for one in ranked]),
        "law_square": np.array([squares[one.name] for one in ranked]),
        "law_aicc": aicc - aicc.min(),
        "law_bic": bic - bic.min(),
        "law_prediction": np.array(predicted),
    }
    return ranked, columns, count


def require_laws(pairs: Pairs, laws: Sequence[str]) -> None:
    """Refuse laws that there are not, or that a case does not fit, before anything is computed.

    Raises:
        InputError: there is one.
    """
    if not laws:
        return
    hertz = _frequencies(pairs)
    for name in laws:
        _variants(pairs, name, hertz)


def _within(name: str, done: Sequence[_One]) -> Mapping[str, float]:
    """Return the numbers of the fitted law that has the most parts of another one, which is no worse than it."""
    parts = {part.strip() for part in name.split("+")}
    inner = [one for one in done if {part.strip() for part in one.name.split("+")} < parts]
    return max(inner, key=lambda one: one.name.count("+")).found.named if inner else {}


def _fitted(
    fit: Fit,
    pairs: Pairs,
    parameters: Mapping[str, Range],
    nuisances: Mapping[str, Range],
    name: str,
    left_out: Pairs,
    hertz: Frequencies,
    begin: Mapping[str, float],
) -> _One | str:
    changed, own = _variants(pairs, name, hertz)
    damping = tuple(f"materials.{material}.damping" for material in changed[0][0].content["materials"])
    kept = {
        key: value
        for key, value in parameters.items()
        if (name == OWN or not key.startswith(damping))
        and any(number_at(case, key) is not None for case, _ in changed)
    }
    try:
        found = fit(changed, {**kept, **own}, nuisances, coloured=False, begin=begin)
        prediction = None
        if left_out:
            others, _ = _variants(left_out, name, hertz)
            shared = {key: value for key, value in found.named.items() if key in kept or key in own}
            known = [case_with(case, shared) for case, _ in others]
            again = {id(case): new for (case, _), new in zip(others, known, strict=True)}
            held = [(again[id(case)], record) for case, record in others]
            prediction = fit(held, {}, nuisances, coloured=False, only_nuisances=True)
    except SolveError as error:
        return str(error)
    return _One(name, changed, {**kept, **own}, found, prediction)


def _variants(pairs: Pairs, name: str, hertz: Frequencies) -> tuple[list[tuple[Case, Any]], dict[str, Range]]:
    """Return the pairs with another law; pairs of one case share the new one."""
    if name == OWN:
        return list(pairs), {}
    made: dict[int, tuple[Case, dict[str, Range]]] = {}
    for case, _ in pairs:
        if id(case) not in made:
            made[id(case)] = variant(case, name, hertz)
    own: dict[str, Range] = {}
    for _, sought in made.values():
        own |= sought
    return [(made[id(case)][0], record) for case, record in pairs], own


def _frequencies(pairs: Pairs, left_out: Pairs = ()) -> Frequencies:
    """Return the mean frequency at which records move, and the band of all, those left out too."""
    members = members_of(pairs)
    found = [hertz for listed in dominant_frequencies(members) for hertz in listed]
    band = held_band([*members, *members_of(left_out)])
    if not found or band is None:
        raise InputError(
            "laws: the records show no frequency at which damping could be compared; give histories, modes or responses"
        )
    # one material in all cases, so that those left out have the same one
    return Frequencies(float(np.exp(np.mean(np.log(found)))), band).of_case(pairs[0][0])


def _noise(found: Fitted) -> Noise:
    best = found.estimate
    return noise_of(best.noise.series, best.residuals, best.slopes, best.noise, predicted=best.predicted)


def _square(noise: Noise, found: Fitted) -> float:
    residual = found.estimate.residuals
    return float(
        sum(
            np.sum((residual[series.rows] / one.deviations(series)) ** 2)
            for series, one in zip(noise.series, noise.found, strict=True)
        )
    )


def _error(predicted: Fitted) -> float:
    """Return the root mean square error of records left out over their noise, as told, or else over their spread."""
    best = predicted.estimate
    parts = []
    for series in best.noise.series:
        if series.certain:
            continue
        parts.append(best.residuals[series.rows] / series.noise)
    return float(np.sqrt(np.mean(np.concatenate(parts) ** 2)))


def _known(found: Fitted) -> Covariance:
    """Return what is known of the numbers of a law, which were fitted as if noise had no colour, with its colour."""
    return covariance(replace(found.estimate, noise=_noise(found)))


def _values(found: Fitted, known: Covariance) -> str:
    texts = []
    for k, one in enumerate(found.unknowns):
        if one.nuisance:
            continue
        value = float(found.estimate.values[k])
        size = 1.96 * float(known.deviations[k]) * (value if one.logarithmic else one.scale)
        key = one.name.split(",")[0]
        short = key.split(".", 2)[-1] if key.startswith("materials.") else key
        told = known.told(np.eye(len(found.unknowns))[k])
        texts.append(
            f"{short} {number_text(value, value - size, value + size, unit_of(found.members, one.name))}"
            if told
            else f"{short} not told"
        )
    worth = f" ({TOO_NARROW})" if missed(found.estimate) and any("+-" in text for text in texts) else ""
    return "; ".join(texts) + worth


def _clamp_damps(one: _One) -> bool:
    """Return whether the damping of a clamp that gives way is told from none: by two standard errors."""
    known = _known(one.found)
    for k, axis in enumerate(np.eye(len(one.found.unknowns))):
        if one.found.unknowns[k].name.startswith("springs[") and ".damping." in one.found.unknowns[k].name:
            return bool(known.told(axis)) and float(known.deviations[k]) < 0.5
    return True


def _lost_outside(one: _One) -> float | None:
    """Return the part of the lost energy that drag took in all motions of a fit; None where nothing moved in time."""
    outside = whole = 0.0
    for member in one.found.members:
        result = member.result(member.numbers(one.found.named))
        if isinstance(result, Run):
            outside += float(result.energy.outside[-1])
            whole += float(result.energy.outside[-1] + result.energy.viscous[-1])
    return outside / whole if whole > 0.0 else None
