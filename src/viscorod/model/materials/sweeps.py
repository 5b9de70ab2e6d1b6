"""Choose one frequency sweep of measured points: by temperature, with repeated frequencies averaged."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from viscorod.limits import LARGEST_NUMBER, SMALLEST_NUMBER
from viscorod.model.fields.definition import RefusedError
from viscorod.model.materials.moduli_over_frequency import MEASURED, DmaTable, counted, listed, tidied
from viscorod.typing import Floats

__all__ = ["Points", "every_sweep", "one_sweep", "side_by_side"]

_JUMP = 2.0
"""Change of the temperature [K] from row to row that begins another sweep."""
_NEAR = 2.0
"""Distance [K] of the wanted temperature from that of a sweep."""
_ISOTHERM = 1.0
"""Gap [K] that divides rows which are not in the order of sweeps."""


@dataclass(frozen=True, eq=False)
class Points:
    """Measured points in the order of a file; every array (n,), nan where a value is missing.

    Attributes:
        line: in the file.
        omega: angular frequency, rad/s.
        storage, loss: moduli, Pa.
        temperature, set_temperature: degrees C.
        group: number of the sweep, where the file has it.
        block: number of the table within the file.
        strain: "shear" or "extension", or None.
        notes: one sentence each.
    """

    line: np.ndarray
    omega: Floats
    storage: Floats
    loss: Floats
    temperature: Floats
    set_temperature: Floats
    group: Floats
    block: np.ndarray
    strain: str | None = None
    notes: tuple[str, ...] = field(default=())

    def at(self, which: np.ndarray) -> Points:
        """Return some of the points."""
        names = ("line", "omega", "storage", "loss", "temperature", "set_temperature", "group", "block")
        return replace(self, **{name: getattr(self, name)[which] for name in names})

    @property
    def degrees(self) -> Floats:
        """The temperature that names a sweep: the set one where it is known."""
        return np.where(np.isfinite(self.set_temperature), self.set_temperature, self.temperature)


def one_sweep(parts: list[Points], temperature: float | None = None) -> DmaTable:
    """Return the only sweep, or that at a temperature [C].

    Raises:
        RefusedError: there are several and none is chosen, or none near the temperature; or what is called one sweep
            has different moduli at one frequency.
    """
    points, notes, left_out = _usable(parts)
    sweeps = _with_frequencies(_sweeps(points), notes)
    sweep = _chosen(sweeps, temperature, notes)
    return tidied(sweep.omega, sweep.storage, sweep.loss, points.strain, [*notes, *left_out])


def every_sweep(parts: list[Points]) -> list[tuple[float, float, DmaTable]]:
    """Return all sweeps by increasing temperature: mean of the sample [C], how far it went from it [K], and the table.

    Raises:
        RefusedError: a sweep has no temperature.
    """
    points, notes, left_out = _usable(parts)
    found = []
    for sweep in _with_frequencies(_sweeps(points), notes):
        known = sweep.temperature[np.isfinite(sweep.temperature)]
        degrees = known if known.size else sweep.degrees
        mean = float(degrees.mean())
        if not math.isfinite(mean):
            raise RefusedError(
                "the file has no column of temperatures",
                "add one, or give the temperature of each file",
                at=("temperature",),
            )
        table = tidied(sweep.omega, sweep.storage, sweep.loss, points.strain, [*notes, *left_out])
        found.append((mean, float(np.abs(degrees - mean).max()), table))
    return sorted(found, key=lambda one: one[0])


def _usable(parts: list[Points]) -> tuple[Points, list[str], list[str]]:
    """Return the points of a file that have numbers, with notes on what was read, and on what is left out."""
    points = _joined(parts)
    notes = list(points.notes)
    usable = (points.omega > SMALLEST_NUMBER) & (points.storage > SMALLEST_NUMBER) & (points.loss >= 0.0)
    known = np.isfinite(points.degrees)
    if known.sum() > 0.5 * len(known):
        usable &= known
    usable &= (
        (points.omega < LARGEST_NUMBER) & (points.storage < LARGEST_NUMBER) & (points.loss < LARGEST_NUMBER)
    )
    if not usable.any():
        raise RefusedError(
            "no row has a frequency > 0, a storage modulus > 0 and a loss modulus >= 0",
            "check the columns of the file",
        )
    without = points.at(~usable)
    left_out = []
    if without.line.size:
        count = without.line.size
        left_out.append(
            f"{counted(count, 'row')} of the file {'has' if count == 1 else 'have'} no usable numbers (missing, or "
            f"not positive) and {'is' if count == 1 else 'are'} left out: {listed('line', without.line)}"
        )
    return points.at(usable), notes, left_out


def _joined(parts: list[Points]) -> Points:
    names = ("line", "omega", "storage", "loss", "temperature", "set_temperature", "group", "block")
    arrays = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    notes = tuple(dict.fromkeys(note for part in parts for note in part.notes))
    return Points(**arrays, strain=parts[0].strain, notes=notes)


def side_by_side(parts: list[Points]) -> Points:
    """Return the points of columns that stand side by side, those of one row together by frequency."""
    if len(parts) == 1:
        return parts[0]
    joined = _joined(parts)
    one_each = all(len(np.unique(part.omega)) == 1 for part in parts)
    return joined.at(np.lexsort((joined.omega, joined.line))) if one_each else joined


def _sweeps(points: Points) -> list[Points]:
    """Divide rows into sweeps; those at the same temperature are one."""
    count = len(points.omega)
    starts = [0]
    up = 0
    for k in range(1, count):
        step = int(np.sign(points.omega[k] - points.omega[k - 1]))
        jump = abs(points.temperature[k] - points.temperature[k - 1]) > _JUMP
        other = any(
            values[k] != values[k - 1] and math.isfinite(values[k])
            for values in (points.set_temperature, points.group, points.block)
        )
        if step == 0 or (up and step != up) or jump or other:
            starts.append(k)
            up = 0
        else:
            up = step
    runs = [np.arange(a, b) for a, b in pairwise([*starts, count])]
    degrees = points.degrees
    if not np.isfinite(degrees).all():
        return _by_number(points)
    if np.median([len(run) for run in runs]) < 2 and len(np.unique(points.omega)) > 1:
        order = np.argsort(degrees, kind="stable")
        gaps = np.flatnonzero(np.diff(degrees[order]) > _ISOTHERM) + 1
        runs = [np.sort(run) for run in np.split(order, gaps)]
    means = np.array([degrees[run].mean() for run in runs])
    order = np.argsort(means, kind="stable")
    sweeps: list[list[int]] = []
    last = -math.inf
    for k in order:
        if means[k] - last > _ISOTHERM / 2.0:
            sweeps.append([])
            last = means[k]
        sweeps[-1].extend(runs[k].tolist())
    return [points.at(np.array(sorted(sweep))) for sweep in sweeps]


def _by_number(points: Points) -> list[Points]:
    """Divide rows without temperatures by the numbers of their sweeps, or of their tables in the file.

    A table that is printed on several pages goes on from one to the next, and no frequency comes again.
    """
    if len(np.unique(points.omega)) == len(points.omega):
        return [points]
    numbers = np.column_stack([points.block, np.nan_to_num(points.group, nan=-1.0)])
    _, member = np.unique(numbers, axis=0, return_inverse=True)
    return [points.at(member == k) for k in range(int(member.max()) + 1)]


def _with_frequencies(sweeps: list[Points], notes: list[str]) -> list[Points]:
    """Return the sweeps that have several frequencies."""
    kept = [sweep for sweep in sweeps if len(np.unique(sweep.omega)) > 1]
    single = [sweep for sweep in sweeps if len(np.unique(sweep.omega)) == 1]
    if not kept and len(single) > 1:
        hertz = sorted({float(sweep.omega[0]) / (2.0 * math.pi) for sweep in single})
        first, last = (single[k].degrees.mean() for k in (0, -1))
        raise RefusedError(
            f"the file is a sweep over temperature, at {listed('', np.array(hertz))} Hz",
            "give a sweep over frequency at one temperature",
            found=f"{len(single)} temperatures from {first:.4g} to {last:.4g} C",
        )
    if kept and single:
        notes.append(
            f"{counted(len(single), 'sweep')} of one frequency only, not taken as sweeps over frequency"
        )
    return kept or sweeps


def _chosen(sweeps: list[Points], temperature: float | None, notes: list[str]) -> Points:
    """Return the only sweep, or that nearest to a temperature."""
    degrees = np.array([float(sweep.degrees.mean()) for sweep in sweeps])
    measured = bool(np.isfinite(degrees).all())
    if temperature is None and len(sweeps) == 1:
        (sweep,) = sweeps
    elif not measured and len(sweeps) > 1:
        raise RefusedError(
            f"the file has {len(sweeps)} sweeps, and no column of temperatures to choose one by",
            "keep one sweep in the file",
        )
    elif temperature is None:
        raise RefusedError(
            f"the file has sweeps at {len(sweeps)} temperatures: {listed('', degrees, 30)} C",
            "choose one by the key temperature, such as temperature = "
            f"{degrees[int(np.argmin(np.abs(degrees - 20.0)))]:.4g}",
        )
    elif not measured:
        raise RefusedError(
            "the file has no column of temperatures",
            "leave it out",
            found=f"{temperature:g}",
            at=("temperature",),
        )
    else:
        nearest = int(np.argmin(np.abs(degrees - temperature)))
        sweep = sweeps[nearest]
        if abs(degrees[nearest] - temperature) > _NEAR:
            raise RefusedError(
                f"the file has no sweep within {_NEAR:g} K of it",
                f"give one of {listed('', degrees, 30)} C",
                found=f"{temperature:g}",
                at=("temperature",),
            )
    if measured:
        notes.append(_at_temperature(sweep, len(sweeps)))
    return sweep


def _at_temperature(sweep: Points, count: int) -> str:
    known = sweep.temperature[np.isfinite(sweep.temperature)]
    text = f"{MEASURED}{sweep.degrees.mean():.4g} C"
    if count > 1:
        text += f", one of {count} sweeps in the file"
    if known.size and max(known.max() - known.min(), np.abs(known - sweep.degrees.mean()).max()) > 1.0:
        text += f"; the sample had {known.min():.4g} to {known.max():.4g} C meanwhile"
    return text
