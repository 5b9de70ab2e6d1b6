"""The report of an ensemble: what its values were drawn from, quantiles, indices, errors, failures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from viscorod.errors import InputError
from viscorod.results.sweep_members import NOT_RUN
from viscorod.results.text_numbers import number, prefixed
from viscorod.results.text_table import page, table
from viscorod.results.told_members import told_members

if TYPE_CHECKING:
    from viscorod.results.ensemble import Ensemble

__all__ = ["report_of"]

LEVELS = (0.05, 0.5, 0.95)
MOST_MESSAGES = 10
_ERRORS = (
    ("mesh_error", "Positions", "by the mesh {} of the length"),
    ("step_error", "Positions", "by the steps {} m"),
    ("frequency_error", "Frequencies", "by the mesh {} of them"),
    ("critical_load_error", "Critical loads", "by the mesh {} of them"),
)


def report_of(found: Ensemble) -> str:
    """Return the report: distributions, quantiles of all quantities, indices, how it converges, and what failed."""
    design = found.design
    count = f"{len(found.members)} members, {found.count_completed} completed"
    drawn = list(zip(design.keys, design.distributions, strict=True))
    blocks = [table(f"{found.title}: {count}" if found.title else count, ("key", "drawn from"), drawn)]
    blocks += _correlations(found)
    blocks += _quantiles(found)
    if design.indices:
        blocks += _indices(found)
    blocks.append(_errors(found))
    left = found.members.found.outcomes().count(NOT_RUN)
    if left:
        blocks.append(f"{left} member{'s were' if left > 1 else ' was'} not run")
    blocks += told_members(found.members.found.told(), MOST_MESSAGES)
    return page([*blocks, *found.notes])


def _correlations(found: Ensemble) -> list[str]:
    """Return which values are correlated, and how much."""
    design = found.design
    lines = [
        (design.keys[i], design.keys[j], f"{value:.3g}")
        for i, row in enumerate(design.correlation)
        for j, value in enumerate(row[:i])
        if value
    ]
    return [table("Correlated", ("key", "with", "correlation"), lines)] if lines else []


def _quantiles(found: Ensemble) -> list[str]:
    """Return a table of every quantity."""
    try:
        quantiles = found.quantiles(LEVELS)
    except InputError as error:
        return [str(error)]
    header = ("quantile", "value", "95 % from", "to", "first half")
    blocks = []
    for name in found.numbers:
        rows = quantiles.loc[name]
        values = rows[["value", "lower", "upper", "half"]].to_numpy()
        title, factor = prefixed(name, values[np.isfinite(values)])
        lines = [
            (f"{100.0 * level:g} %", *(number(factor * value) for value in row))
            for level, row in zip(rows.index, values, strict=True)
        ]
        blocks.append(table(f"Quantiles of {title}", header, lines))
    return [*blocks, *found.partial, *found.scarce]


def _indices(found: Ensemble) -> list[str]:
    """Return a table of every quantity, the most important value first."""
    try:
        indices = found.indices()
    except InputError as error:
        return [str(error)]
    blocks = []
    for name in indices.index.unique(level="quantity"):
        rows = indices.loc[name].sort_values("total", ascending=False)
        lines = [
            (
                str(key),
                f"{row.first:.2f} ({row.first_lower:.2f}, {row.first_upper:.2f})",
                f"{row.total:.2f} ({row.total_lower:.2f}, {row.total_upper:.2f})",
            )
            for key, row in zip(rows.index, rows.itertuples(), strict=True)
        ]
        title = f"Sobol' indices of {name.partition(' [')[0]}, and intervals of 95 %"
        blocks.append(table(title, ("key", "alone", "in all"), lines).replace("-0.00", "0.00"))
    return [*blocks, *found.without_indices]


def _errors(found: Ensemble) -> str:
    """Say what mesh and steps leave, of the members for which that was estimated."""
    columns, count = found.members.found.measured, found.count_completed
    told: dict[str, list[str]] = {}
    for name, what, error in _ERRORS:
        values = columns.get(name, np.zeros(0))
        known = values[np.isfinite(values)]
        if len(known):
            words = error.format(f"{known.max():.1g}")
            told.setdefault(what, []).append(f"{words} ({len(known)} of {count} members)")
    if not told:
        return "Errors of mesh and steps were not estimated."
    return " ".join(
        f"{what} are off, at most and as estimated, {' and '.join(parts)}." for what, parts in told.items()
    )
