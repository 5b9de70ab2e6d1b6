"""The data set of an identification."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.analyses.identification.laws import Compared
from viscorod.analyses.identification.named_combinations import Combination
from viscorod.analyses.identification.told import at_signal, whiteness
from viscorod.analyses.identification.unit_of import unit_of
from viscorod.results.identification import Identification
from viscorod.results.identified import Foretold
from viscorod.solve.estimation.intervals import Interval
from viscorod.solve.estimation.posterior import Draws
from viscorod.typing import Floats

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.analyses.identification.search import Fitted

__all__ = ["fit_dataset"]


def fit_dataset(
    found: Fitted,
    limits: Sequence[Interval],
    told: Sequence[Combination],
    programs: Sequence[Combination],
    attrs: Mapping[str, Any],
    compared: Compared | None,
    chains: Draws | None = None,
) -> xr.Dataset:
    """Return all that is known of a fit as one data set."""
    import xarray as xr

    columns: dict[str, Any] = {}
    columns |= _of_unknowns(found, limits) | _of_values(found) | _of_series(found)
    for word, listed in (("combination", told), ("program_number", programs)):
        prefix = "program" if word == "program_number" else word
        columns |= {
            f"{prefix}_value": _floats(one.value for one in listed),
            f"{prefix}_low": _floats(one.low for one in listed),
            f"{prefix}_high": _floats(one.high for one in listed),
        }
    columns |= {f"law_{word}": np.zeros(0) for word in ("unknowns", "square", "aicc", "bic", "prediction")}
    told_of = compared.foretold if compared is not None else []
    columns |= {name: _floats(one.numbers[k] for one in told_of) for k, name in enumerate(Foretold.COLUMNS)}
    size = len(found.unknowns)
    z = chains.z if chains is not None else np.zeros((0, 0, size))
    columns["draw"] = found.unknowns.values(z.reshape(-1, size)).reshape(z.shape)
    columns["draw_density"] = chains.density if chains is not None else np.zeros((0, 0))
    if compared is not None:
        columns |= compared.columns
    known = Identification.variables()
    variables = {name: (known[name][0], columns[name]) for name in known}
    words = {
        "combinations": json.dumps([[one.name, one.unit] for one in told]),
        "laws": json.dumps(compared.words if compared is not None else []),
        "foretold": json.dumps([[one.law, one.record] for one in told_of]),
        "program_numbers": json.dumps([one.name for one in programs]),
        "program_units": json.dumps([one.unit for one in programs]),
    }
    return xr.Dataset(variables, attrs={**attrs, **words, "kind": Identification.kind})


def _words(words: Any) -> np.ndarray:
    listed = [str(word) for word in words]
    return np.array(listed, dtype=f"<U{max(map(len, listed), default=1)}")


def _floats(values: Any) -> Floats:
    return np.array(list(values), dtype=float)


def _of_unknowns(found: Fitted, limits: Sequence[Interval]) -> dict[str, Any]:
    unknowns, known = found.unknowns, found.known
    logarithmic = np.array([one.logarithmic for one in unknowns])
    size = np.where(logarithmic, 1.0, [one.scale for one in unknowns])
    low_open = np.array([not np.isfinite(one.low) or (one.low == 0.0 and not one.told) for one in limits])
    high_open = np.array([not np.isfinite(one.high) for one in limits])
    low_open |= np.array([log and one.low <= 0.0 for log, one in zip(logarithmic, limits, strict=True)])
    return {
        "unknown": _words(unknowns.names),
        "unknown_unit": _words(unit_of(found.members, one.name) for one in unknowns),
        "nuisance": _floats(one.nuisance for one in unknowns),
        "start": _floats(one.start for one in unknowns),
        "estimate": found.estimate.values,
        "relative": logarithmic.astype(float),
        "standard_error": known.deviations * size,
        "low": np.where(low_open, 0.0, [one.low for one in limits]),
        "high": np.where(high_open, 0.0, [one.high for one in limits]),
        "low_open": low_open.astype(float),
        "high_open": high_open.astype(float),
        "interval_by": _words(one.how for one in limits),
        "covariance": known.matrix * np.outer(size, size),
        "unseen": known.unseen.reshape(-1, len(unknowns)),
    }


def _of_values(found: Fitted) -> dict[str, Any]:
    best = found.estimate
    deviation, number, place = (np.zeros(len(best.measured)) for _ in range(3))
    for k, (series, noise) in enumerate(zip(best.noise.series, best.noise.found, strict=True)):
        deviation[series.rows] = noise.deviations(series)
        number[series.rows] = k
    begin = 0
    for at, _ in _places(found):
        place[begin : begin + len(at)] = at
        begin += len(at)
    return {
        "measured": best.measured,
        "predicted": best.predicted,
        "deviation": deviation,
        "white": best.noise.whitened(best.residuals),
        "place": place,
        "series_of": number,
    }


def _places(found: Fitted) -> Iterator[tuple[Floats, str]]:
    """Yield where the values of every record stand, and the unit of that."""
    for member in found.members:
        for record in member.records:
            count = len(record.observed)
            for word, unit in (("times", "s"), ("loads", "N"), ("frequencies", "Hz")):
                own = getattr(record, word, None)
                if own is not None and record.analysis != "modes":
                    yield np.tile(np.asarray(own, dtype=float), count // len(own)), unit
                    break
            else:
                numbers = np.arange(1.0, count + 1.0)
                if record.analysis == "modes":
                    numbers = np.tile(
                        np.arange(1.0, len(record.frequencies) + 1.0), count // len(record.frequencies)
                    )
                yield numbers, ""


def _axes(found: Fitted) -> list[tuple[int, str, str]]:
    """Return where every measured quantity begins among the values, its name and its unit."""
    listed: list[tuple[int, str, str]] = []
    begin = 0
    for member in found.members:
        for record in member.records:
            each = len(record.observed) // len(record.axes)
            listed += [(begin + k * each, name, unit) for k, (name, unit) in enumerate(record.axes)]
            begin += len(record.observed)
    return listed


def _of_series(found: Fitted) -> dict[str, Any]:
    best = found.estimate
    pairs = list(zip(best.noise.series, best.noise.found, strict=True))
    units: dict[int, str] = {}
    begin = 0
    for at, unit in _places(found):
        units |= dict.fromkeys(range(begin, begin + len(at)), unit)
        begin += len(at)
    axes = _axes(found)
    pieces = [[one for start, *one in axes if s.rows.start <= start < s.rows.stop] for s, _ in pairs]
    quantities = [", ".join(name for name, _ in listed) for listed in pieces]
    quantity_units = [listed[0][1] if listed else "" for listed in pieces]
    typical = [float(np.median(series.noise)) for series, _ in pairs]
    return {
        "series": _words(series.label for series, _ in pairs),
        "quantity": _words(quantities),
        "quantity_unit": _words(quantity_units),
        "place_unit": _words(units.get(series.rows.start, "") for series, _ in pairs),
        "noise": _floats(noise.factor * size for (_, noise), size in zip(pairs, typical, strict=True)),
        "noise_told": _floats(
            size if series.told else 0.0 for (series, _), size in zip(pairs, typical, strict=True)
        ),
        "noise_order": _floats(len(noise.terms) for _, noise in pairs),
        "effective_count": _floats(
            series.count * noise.effective_part(series.count) for series, noise in pairs
        ),
        "whiteness": _floats(whiteness(best)),
        "at_signal": _floats(at_signal(best)),
    }
