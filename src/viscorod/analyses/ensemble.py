"""Ensembles: one case with uncertain values, and what its results are worth."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from viscorod.analyses.sweep import sweep
from viscorod.analyses.sweeps.points import (
    distribution_text,
    points_of,
    require_distributions,
    uniform_points,
)
from viscorod.analyses.sweeps.rows import key_and_unit
from viscorod.argument_names import telling
from viscorod.casefile.case import Case
from viscorod.errors import Fault, InputError, SolveError
from viscorod.results.ensemble import Ensemble
from viscorod.results.ensemble_design import Design
from viscorod.results.files.sweep_folder import SweepFolder
from viscorod.results.quantities import Quantities
from viscorod.typing import Floats

__all__ = ["ensemble"]

Progress: TypeAlias = Callable[[float], None]


@telling
def ensemble(
    case: Case | str | Path,
    distributions: Mapping[str, Any],
    n: int,
    *,
    quantities: Quantities,
    seed: int = 0,
    correlation: Any = None,
    indices: bool = False,
    constants: Mapping[str, Any] | None = None,
    fields: bool = False,
    executor: Any = None,
    workers: int | None = None,
    folder: str | Path | None = None,
    members: slice | None = None,
    errors: int | None = None,
    retry: bool = False,
    progress: Progress | bool | None = None,
) -> Ensemble:
    """Compute a case many times with uncertain values: quantiles of its quantities, and what their spread is due to.

    Values are drawn at the points of a scrambled Sobol' sequence (``scipy.stats.qmc``). Member k has the same values
    whatever computes it, and the members of a smaller ``n`` are the first ones of a larger one, so that a folder goes
    on with what it has.

    Args:
        case: a case, or the path of its file; it must be right as it stands.
        distributions: key of the case file -> frozen distribution of SciPy, such as ``scipy.stats.norm(1e6, 5e4)``, in
            SI units, or in the unit behind the key: ``"sections.strip.height [mm]"``.
        n: number of points, a power of two.
        quantities: as of ``viscorod.sweep``.
        seed: of the scrambling.
        correlation: of the distributions, in their order: the correlation matrix of the normal numbers from which a
            Gaussian copula makes them (for normal distributions their own).
        indices: compute Sobol' indices. That takes n (keys + 2) members, and independent distributions.
        constants, fields, executor, workers, folder, members, errors, retry, progress: as of ``viscorod.sweep``.

    Returns:
        The members, with quantiles, indices and pictures of them.

    Raises:
        InputError: something is wrong; nothing has been computed.
        SolveError: it was interrupted; ``run`` holds what was computed.
    """
    require_distributions(distributions)
    if not quantities:
        why, instead = "there is nothing to tell of", 'give {"ratio": ("decrement", "beam.end", "y")}'
        raise InputError(Fault("quantities", "", why, instead))
    if indices and correlation is not None:
        why = "parts of a variance belong to independent numbers"
        raise InputError(Fault("indices", "true", why, "leave out the correlation, or the indices"))
    count = len(distributions)
    uniform = uniform_points(n, count * (2 if indices else 1), seed)
    rows = _saltelli_rows(uniform, count) if indices else uniform
    columns = points_of(rows, distributions, correlation)
    correlated = () if correlation is None else np.asarray(correlation, dtype=float).tolist()
    drawn = [(*key_and_unit(head), distribution_text(found)) for head, found in distributions.items()]
    design = Design(
        tuple(key for key, _, _ in drawn),
        tuple(f"{text} {unit}".strip() for _, unit, text in drawn),
        int(n),
        int(seed),
        bool(indices),
        tuple(map(tuple, correlated)),
    )
    try:
        found = sweep(
            case,
            {key: column.tolist() for key, column in columns.items()},
            constants=constants,
            quantities=quantities,
            fields=fields,
            executor=executor,
            workers=workers,
            folder=None if folder is None else SweepFolder(Path(folder).absolute(), design.record),
            members=members,
            errors=errors,
            retry=retry,
            progress=progress,
        )
    except SolveError as error:
        raise SolveError(str(error), Ensemble.of_sweep(error.run, design)) from None
    except InputError as error:
        raise InputError(
            [_of_drawn(fault, design) for fault in error.problems], heading=error.heading
        ) from None
    return Ensemble.of_sweep(found, design)


def _saltelli_rows(uniform: Floats, d: int) -> Floats:
    """Return for every point its rows A, B and AB_1 ... AB_d, which is A with one column of B ``(n (d + 2), d)``."""
    a, b = uniform[:, :d], uniform[:, d:]
    rows = np.repeat(a[:, None, :], d + 2, axis=1)
    rows[:, 1] = b
    for i in range(d):
        rows[:, 2 + i, i] = b[:, i]
    return rows.reshape(-1, d)


def _of_drawn(fault: Fault, design: Design) -> Fault:
    """Return a fault with what to do where its value was drawn; a fault without a value is one of the key."""
    if fault.where not in design.keys or not fault.found:
        return fault
    drawn = design.distributions[design.keys.index(fault.where)]
    advice = f"{drawn} gives such values; truncnorm, lognorm or uniform can be kept within what is allowed"
    return replace(fault, instead=f"{fault.instead}; {advice}" if fault.instead else advice)
