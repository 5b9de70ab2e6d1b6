"""Master curves: moduli measured at several temperatures as one curve over frequency, and the law of its shifts."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from viscorod.argument_names import telling
from viscorod.checks import number
from viscorod.errors import Fault, InputError
from viscorod.model.fields.definition import RefusedError
from viscorod.model.materials.dma_table import read_dma_sweeps
from viscorod.model.materials.moduli_over_frequency import DmaTable
from viscorod.one_thread import one_blas_thread
from viscorod.records.arguments import described
from viscorod.records.overlap import DECADE, Overlap, overlapped
from viscorod.records.shift_laws import LawFit, fit_arrhenius, fit_wlf
from viscorod.results.master_curve_result import MasterCurve
from viscorod.typing import Floats

__all__ = ["master_curve"]

FEWEST = 3
"""Sweeps at least."""
KNOWN = 0.5
"""Half-width of the interval of log10 a_T, decades, up to which a sweep takes part in the laws."""
HOLDS, FEWEST_OF_LAW = 0.1, 5
"""Decades by which shifts may be off a law that holds, and sweeps that a law is fitted to at least."""
ENOUGH = 0.8
"""Part of the most sweeps known beside any one that must be known beside the reference if laws are referred to it."""
WANDERS = 1.0
"""K by which a sample's temperature may change within a sweep without a word."""
SPIKED = 0.34
"""Part of the sweeps that have the same frequency off: the instrument's resonance."""
PER_DECADE = 8
"""Frequencies of the smooth curve."""
MOST_TOLD = 5
"""Sentences about the tables of sweeps."""
Sweep = tuple[float, DmaTable]
_POINT = re.compile(r"the (storage|loss) modulus at (\S+) Hz is ")


@described
@one_blas_thread()
@telling
def master_curve(
    files: str | Path | Sequence[str | Path] | Sequence[Sweep],
    *,
    reference: float | None = None,
    vertical: bool = True,
    band: tuple[float, float] | None = None,
    law_range: tuple[float, float] | None = None,
    frequency_unit: str | None = None,
    modulus_unit: str | None = None,
    title: str = "",
) -> MasterCurve:
    """Lay sweeps at several temperatures over each other: one curve, shift factors with intervals, WLF and Arrhenius.

    Storage and loss modulus of the sweep at T are b_T E(a_T omega), with the curve E of the reference temperature.
    Curve and shifts are fitted together (`viscorod.records.overlap`). Temperatures are those of the sample where a
    file has them.

    Args:
        files: a file with sweeps at several temperatures, several files, or pairs of temperature, degrees C, and
            `DmaTable`.
        reference: temperature of the curve, degrees C, the nearest sweep is taken; left out, that with the largest
            loss factor. Laws are referred to another one where its shift is not known beside others.
        vertical: whether moduli are shifted too; without it the intervals are narrower, and wrong where moduli depend
            on temperature by more than their times do.
        band: frequencies that count, Hz: those near the instrument's resonance do not.
        law_range: temperatures from which the laws are fitted, degrees C; left out, all whose shift is known to 0.5
            decades beside one of them.
        frequency_unit, modulus_unit: where the files do not say.
        title: of the result.

    Raises:
        InputError: a file cannot be read, or fewer than three sweeps are there.
    """
    sweeps, notes = _sweeps(files, frequency_unit, modulus_unit)
    if band is not None:
        sweeps = [(celsius, _within(table, *band)) for celsius, table in sweeps]
    else:
        sweeps, left_out = _without_resonance(sweeps)
        notes += left_out
    notes += _of_tables(sweeps)
    sweeps = [one for one in sweeps if len(one[1].omega) > 2]
    if len(sweeps) < FEWEST:
        raise InputError(
            Fault("files", f"{len(sweeps)} sweeps", "a master curve needs three sweeps of three frequencies or more",
                  "give sweeps at more temperatures")
        )  # fmt: skip
    celsius = np.array([one[0] for one in sweeps])
    tables = [one[1] for one in sweeps]
    first = _reference(celsius, tables, reference)
    fit = overlapped(tables, celsius, first, vertical)
    decades, covariance = fit.log_a / DECADE, fit.covariance[: len(celsius), : len(celsius)] / DECADE**2
    quantile = student.ppf(0.975, fit.freedom)
    width = quantile[: len(celsius)] * np.sqrt(np.diag(covariance))
    base, used = _law_base(covariance, first, fit.bridged)
    if law_range is not None:
        used = (celsius >= law_range[0]) & (celsius <= law_range[1])
        if not used.any():
            raise InputError(
                Fault(
                    "law_range",
                    f"{law_range[0]:g} to {law_range[1]:g} C",
                    "no sweep is there",
                    "give other temperatures",
                )
            )
        base = base if used[base] else int(np.flatnonzero(used)[np.argmin(np.diag(covariance)[used])])
    about = float(celsius[base])
    laws, used, glass = _laws(celsius, decades, covariance, base, used, shorten=law_range is None)
    doubts = [*notes, *_doubts(celsius, fit, width, used), *glass]
    if base != first and any(law is not None for law in laws.values()):
        doubts.append(
            f"the shift at the reference of {celsius[first]:.4g} C is not known beside the others: laws, and materials "
            f"by them, are referred to {about:.4g} C"
        )
    return _result(celsius, tables, first, base, fit, width, laws, used, vertical, doubts, title)


def _laws(
    celsius: Floats, decades: Floats, covariance: Floats, base: int, used: np.ndarray, *, shorten: bool
) -> tuple[dict[str, LawFit | None], np.ndarray, list[str]]:
    """Return the laws through the shifts, the sweeps that they are fitted to, and what is to be said of the others.

    Below the glass transition shifts grow less than by the law above it (Williams, Landel, Ferry 1955): where no law
    holds for all, the coldest sweeps are left out until one does.
    """

    def through(which: np.ndarray) -> dict[str, LawFit | None]:
        block = _relative(covariance, base)[np.ix_(which, which)]
        own, about = decades[which] - decades[base], float(celsius[base])
        return {
            "wlf": fit_wlf(celsius[which], own, block, about),
            "arrhenius": fit_arrhenius(celsius[which], own, block, about),
        }

    def off(laws: dict[str, LawFit | None]) -> float:
        return min((law.off for law in laws.values() if law is not None), default=np.inf)

    laws = through(used)
    left, fewer, found = off(laws), used.copy(), laws
    while shorten and off(found) > HOLDS and np.count_nonzero(fewer) > FEWEST_OF_LAW:
        coldest = int(np.flatnonzero(fewer)[0])
        if coldest >= base:
            break
        fewer[coldest] = False
        found = through(fewer)
    if off(found) <= HOLDS:
        if not np.array_equal(fewer, used):
            return found, fewer, [
                f"below {celsius[fewer].min():.4g} C the shifts leave every law (with them the better one is off by "
                f"{left:.2g} decades), as in a glass: laws are fitted above"
            ]  # fmt: skip
        return laws, used, []
    if np.isfinite(left):
        return laws, used, [f"no law holds for the shifts: the better one is off by {left:.2g} decades"]
    return laws, used, []


def _relative(covariance: Floats, base: int) -> Floats:
    """Return the covariance of shifts less that of one sweep."""
    row = covariance[base]
    return np.asarray(covariance - row[:, None] - row[None, :] + covariance[base, base])


def _law_base(covariance: Floats, first: int, bridged: np.ndarray) -> tuple[int, np.ndarray]:
    """Return the sweep that the laws are referred to, and the sweeps whose shift is known beside that.

    It is the reference of the curve, unless that has hardly a neighbour beside which its shift is known, as in a glass.
    """
    far = float(norm.ppf(0.975))
    known = np.array(
        [
            far * np.sqrt(np.maximum(np.diag(_relative(covariance, k)), 0.0)) <= KNOWN
            for k in range(len(covariance))
        ]
    )
    known = known & np.outer(bridged, bridged)
    counts = known.sum(axis=1)
    base = first if counts[first] >= ENOUGH * counts.max() else int(np.argmax(counts))
    return base, known[base]


def _sweeps(
    files: Any, frequency_unit: str | None, modulus_unit: str | None
) -> tuple[list[Sweep], list[str]]:
    """Return all sweeps by temperature, and what is to be said of how they were measured."""
    listed = [files] if isinstance(files, str | Path) else list(files)
    found: list[Sweep] = []
    notes = []
    for item in listed:
        if isinstance(item, str | Path):
            try:
                read = read_dma_sweeps(item, frequency_unit=frequency_unit, modulus_unit=modulus_unit)
            except RefusedError as error:
                raise InputError(Fault(str(item), error.found or "", error.why, error.instead)) from None
            for celsius, wander, table in read:
                found.append((celsius, table))
                if wander > WANDERS:
                    notes.append(
                        f"the sample's temperature goes {wander:.2g} K away from its mean of {celsius:.4g} C within a "
                        "sweep"
                    )
        elif not (isinstance(item, tuple) and len(item) == 2 and isinstance(item[1], DmaTable)):
            raise InputError(
                Fault(
                    "files",
                    type(item).__name__,
                    "no file of moduli",
                    "give paths, or pairs of a temperature and a table",
                )
            )
        else:
            celsius, table = item
            found.append((number("files", celsius), table))
    found.sort(key=lambda one: one[0])
    if len(notes) > 3:
        notes = [
            f"in {len(notes)} sweeps {notes[0]} (and so on): they are no isotherms",
        ]
    same = [a for (a, _), (b, _) in pairwise(found) if b - a < 0.5]
    if same:
        raise InputError(
            Fault(
                "files",
                f"{same[0]:.4g} C",
                "two sweeps have the same temperature",
                "give each temperature once",
            )
        )
    return found, notes


def _without_resonance(sweeps: list[Sweep]) -> tuple[list[Sweep], list[str]]:
    """Return the sweeps without frequencies that are off in many of them, and what is to be said of it."""
    spikes = Counter(
        float(found[2]) for _, table in sweeps for note in table.notes if (found := _POINT.match(note))
    )
    notes = []
    for hertz, times in sorted(spikes.items()):
        if times > SPIKED * len(sweeps):
            notes.append(
                f"{hertz:g} Hz is off what its neighbours lead to expect in {times} of {len(sweeps)} sweeps: that is "
                "the instrument, and it is left out (band chooses frequencies)"
            )
            sweeps = [
                (celsius, _kept(table, np.abs(table.omega / (2.0 * np.pi * hertz) - 1.0) > 5e-3))
                for celsius, table in sweeps
            ]
    return sweeps, notes


def _of_tables(sweeps: list[Sweep]) -> list[str]:
    """Return what was averaged, left out or found doubtful in the tables of the sweeps, but for single points.

    A point that is off weighs less in the curve.
    """
    found: dict[str, list[float]] = {}
    for celsius, table in sweeps:
        for doubt in table.doubts:
            if not _POINT.match(doubt) and not doubt.startswith(("measured at", "and ")):
                found.setdefault(doubt, []).append(celsius)
    told = [
        doubt if len(at) == len(sweeps) else f"at {', '.join(f'{one:.4g}' for one in at)} C: {doubt}"
        for doubt, at in found.items()
    ]
    return (
        told
        if len(told) <= MOST_TOLD
        else [*told[:MOST_TOLD], f"and {len(told) - MOST_TOLD} more such sentences"]
    )


def _kept(table: DmaTable, which: np.ndarray) -> DmaTable:
    return replace(table, omega=table.omega[which], storage=table.storage[which], loss=table.loss[which])


def _within(table: DmaTable, low: float, high: float) -> DmaTable:
    hertz = table.omega / (2.0 * np.pi)
    inside = (hertz >= low * (1.0 - 1e-9)) & (hertz <= high * (1.0 + 1e-9))
    return _kept(table, inside)


def _reference(celsius: Floats, tables: list[DmaTable], wanted: float | None) -> int:
    if wanted is None:
        return int(np.argmax([float(np.mean(one.loss / one.storage)) for one in tables]))
    nearest = int(np.argmin(np.abs(celsius - wanted)))
    if not celsius[0] - 2.0 <= wanted <= celsius[-1] + 2.0:
        raise InputError(
            Fault(
                "reference",
                f"{wanted:g}",
                "no sweep is near it",
                f"give {celsius[0]:.4g} to {celsius[-1]:.4g} C",
            )
        )
    return nearest


def _doubts(celsius: Floats, fit: Overlap, width: Floats, used: np.ndarray) -> list[str]:
    found = []
    apart = celsius[~fit.bridged]
    if len(apart):
        found.append(
            f"the moduli at {', '.join(f'{one:.4g}' for one in apart)} C have no level in common with a neighbour: "
            "their shift is that of a steady curve"
        )
    wide = celsius[width > KNOWN]
    if len(wide):
        found.append(
            f"the shift at {', '.join(f'{one:.4g}' for one in wide)} C is not known to {KNOWN:g} decades "
            "beside the reference: the moduli "
            "hardly change with frequency there"
        )
    if not used.all() and used.any():
        found.append(f"the laws are fitted from {celsius[used].min():.4g} to {celsius[used].max():.4g} C")
    return found


def _result(
    celsius: Floats, tables: list[DmaTable], first: int, base: int, fit: Overlap, width: Floats,
    laws: dict[str, LawFit | None], used: np.ndarray, lifted: bool, doubts: list[str], title: str,
) -> MasterCurve:  # fmt: skip
    import xarray as xr

    count = len(celsius)
    sweep = np.repeat(np.arange(count), [len(one.omega) for one in tables])
    log_omega = np.log(np.concatenate([one.omega for one in tables])) + fit.log_a[sweep]
    lift = np.exp(fit.log_b)
    storage, loss = (
        np.concatenate([getattr(one, name) for one in tables]) / lift[sweep] for name in ("storage", "loss")
    )
    ends = float(log_omega.min()), float(log_omega.max())
    smooth = np.linspace(*ends, max(int((ends[1] - ends[0]) / DECADE * PER_DECADE), 10))
    curve = fit.at(smooth)
    kept = {
        name: None if law is None else {"values": law.values, "low": law.low, "high": law.high, "off": law.off,
                                        "information": law.information, "reference": float(celsius[base])}
        for name, law in laws.items()
    }  # fmt: skip
    strains = {one.strain for one in tables} - {None}
    lift_width = lift * (student.ppf(0.975, fit.freedom) * np.sqrt(np.diag(fit.covariance)))[count:]
    return MasterCurve(
        xr.Dataset(
            {
                "temperature": ("sweep", celsius),
                "log_shift": ("sweep", fit.log_a / DECADE),
                "log_shift_width": ("sweep", width),
                "lift": ("sweep", lift),
                "lift_width": ("sweep", lift_width),
                "in_laws": ("sweep", used.astype(np.int64)),
                "frequency": ("point", np.exp(log_omega) / (2.0 * np.pi)),
                "storage": ("point", storage),
                "loss": ("point", loss),
                "point_sweep": ("point", sweep.astype(np.int64)),
                "curve_frequency": ("curve", np.exp(smooth) / (2.0 * np.pi)),
                "curve_storage": ("curve", curve[0]),
                "curve_loss": ("curve", curve[1]),
            },
            attrs={
                "kind": "master_curve",
                "title": title,
                "reference": float(celsius[first]),
                "vertical": int(lifted),
                "strain": str(next(iter(strains))) if len(strains) == 1 else "",
                "laws": json.dumps(kept, default=float),
                "apart": json.dumps(celsius[~fit.bridged].tolist()),
                "scatter_storage": fit.scatter[0],
                "scatter_loss": fit.scatter[1],
                "warnings": json.dumps(doubts),
            },
        )
    )
