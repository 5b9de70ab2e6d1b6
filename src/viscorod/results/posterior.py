"""What an identification knows of its numbers, as distributions: for `ensemble`, and as draws for arviz."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from viscorod.errors import Fault, InputError
from viscorod.typing import Floats
from viscorod.wording import show

if TYPE_CHECKING:
    import xarray as xr

    from viscorod.results.identification import Identification

__all__ = ["correlation_of", "distributions_of", "posterior_tree"]

BINS = 100
"""Quantiles by which the distribution of draws is kept at most."""


def posterior_tree(fit: Identification) -> xr.DataTree:
    """Return the draws as groups of one variable per unknown, dimensions chain and draw.

    Raises:
        InputError: there are none.
    """
    import xarray as xr

    draws = _draws(fit)
    if not draws.size:
        raise InputError(
            Fault(
                "posterior",
                "",
                "no draws were made",
                "give identify draws=2000 (pip install viscorod[posterior])",
            )
        )
    names = [str(name) for name in fit.data["unknown"].values]
    units = [str(unit) for unit in fit.data["unknown_unit"].values]
    along = ("chain", "draw")
    places = {"chain": np.arange(draws.shape[0]), "draw": np.arange(draws.shape[1])}
    values = {
        name: (along, draws[:, :, k], {"units": unit})
        for k, (name, unit) in enumerate(zip(names, units, strict=True))
    }
    density = {"lp": (along, np.asarray(fit.data["draw_density"].values, dtype=float))}
    attrs = {"inference_library": "emcee", "modeling_interface": "viscorod"}
    groups = {
        "posterior": xr.Dataset(values, places, attrs),
        "sample_stats": xr.Dataset(density, places, attrs),
    }
    return xr.DataTree.from_dict({f"/{name}": data for name, data in groups.items()})


def distributions_of(
    fit: Identification, *, nuisances: bool, names: Sequence[str] | None = None
) -> dict[str, Any]:
    """Return distributions by key; of several keys that are one number, one each.

    Raises:
        InputError: the data do not tell one.
    """
    from scipy import stats

    draws = _draws(fit)
    found: dict[str, Any] = {}
    chosen = _chosen(fit, nuisances, names)
    for k, keys in chosen:
        name = str(fit.data["unknown"].values[k])
        number = fit.numbers[name]
        if not number.told:
            raise InputError(
                Fault(
                    name,
                    "",
                    "the data do not tell it: it has no distribution",
                    f"leave it out, names={_told(fit, chosen)}, and give the ensemble one of yours if you know more",
                )
            )
        if draws.size:
            mine = draws[:, :, k].ravel()
            edges = np.unique(
                np.quantile(mine, np.linspace(0.0, 1.0, min(BINS, max(len(mine) // 20, 2)) + 1))
            )
            parts = np.histogram(mine, edges)
            one = stats.rv_histogram(parts, density=False)
        elif fit.data["relative"].values[k]:
            one = stats.lognorm(number.standard_error / number.value, scale=number.value)
        else:
            one = stats.norm(number.value, number.standard_error)
        found |= dict.fromkeys(keys, one)
    return found


def correlation_of(fit: Identification, *, nuisances: bool, names: Sequence[str] | None = None) -> Floats:
    """Return the correlation of the normal numbers behind the distributions, in their order."""
    from scipy import stats

    draws = _draws(fit)
    chosen = _chosen(fit, nuisances, names)
    rows = [k for k, keys in chosen for _ in keys]
    if draws.size:
        flat = draws.reshape(-1, draws.shape[-1])
        scores = stats.norm.ppf((stats.rankdata(flat, axis=0) - 0.5) / len(flat))
        matrix = np.atleast_2d(np.corrcoef(scores.T))
    else:
        covariance = np.asarray(fit.data["covariance"].values, dtype=float)
        size = np.sqrt(np.diag(covariance))
        size = np.where(size > 0.0, size, 1.0)
        matrix = covariance / np.outer(size, size)
    matrix = 0.5 * (matrix + matrix.T)
    np.fill_diagonal(matrix, 1.0)
    return np.asarray(matrix[np.ix_(rows, rows)])


def _draws(fit: Identification) -> Floats:
    return np.asarray(fit.data["draw"].values, dtype=float)


def _told(fit: Identification, chosen: list[tuple[int, list[str]]]) -> list[str]:
    """Return the names of those that the data tell."""
    known = [str(fit.data["unknown"].values[k]) for k, _ in chosen]
    return [name for name in known if fit.numbers[name].told]


def _chosen(fit: Identification, nuisances: bool, names: Sequence[str] | None) -> list[tuple[int, list[str]]]:
    """Return the numbers of unknowns that a case has, with their keys, or of those that are wanted."""
    every: dict[str, tuple[int, list[str]]] = {}
    for k, name in enumerate(map(str, fit.data["unknown"].values)):
        if fit.data["nuisance"].values[k] and not (nuisances and _is_key(fit, name)):
            continue
        every[name] = k, [key.strip() for key in name.split(",")]
    wanted = list(every) if names is None else [names] if isinstance(names, str) else list(names)
    for name in wanted:
        if name not in every:
            raise InputError(
                Fault("names", show(name), "there is no such unknown", f"give some of {list(every)}")
            )
    return [found for name, found in every.items() if name in wanted]


def _is_key(fit: Identification, name: str) -> bool:
    """Return whether a nuisance is a key of a case and not the name of an unknown of a record."""
    return not any(name.startswith(f"{record}.") for record in fit.words("records"))
