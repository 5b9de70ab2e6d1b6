"""A table of moduli over frequency from measured points: each frequency once, what is doubtful told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from viscorod.model.fields.definition import RefusedError
from viscorod.quantity_text import per_cent
from viscorod.typing import Floats

__all__ = ["MEASURED", "DmaTable", "beside_slope", "counted", "listed", "tidied"]

_REPEAT = 1.25
"""Largest ratio of storage moduli at one frequency that the scatter of one sweep explains."""
_SAME = 1e-4
"""Relative difference of frequencies that are taken for one; 20 a decade differ by 0.12."""
_OTHER_UNIT, _SLOPE = 30.0, 0.02
"""Times by which a loss factor must be beside what the slope of the storage modulus means for another unit to be spoken
of, and the least slope that says anything of small ones."""
_SPIKE = {"storage": 1.1, "loss": 1.25}
"""Ratio of a point to what its neighbours lead to expect, from which on it is told."""
MEASURED = "measured at "
"""How the note on the temperature of a sweep begins."""
_STIFFEST = 2e12
"""Pa; diamond has 1.2e12."""


@dataclass(frozen=True, eq=False)
class DmaTable:
    """Storage and loss modulus over frequency.

    Attributes:
        omega: increasing angular frequencies (n,), rad/s.
        storage, loss: moduli (n,), Pa.
        strain: "shear" or "extension" where the names of the columns show it, else None.
        notes: what was chosen, averaged, left out or found doubtful on reading, one sentence each.
    """

    omega: Floats
    storage: Floats
    loss: Floats
    strain: str | None = None
    notes: tuple[str, ...] = ()

    @property
    def doubts(self) -> tuple[str, ...]:
        """The notes without that of the temperature of a sweep that was steady."""
        return tuple(note for note in self.notes if not (note.startswith(MEASURED) and "; " not in note))


def tidied(
    omega: Floats, storage: Floats, loss: Floats, strain: str | None = None, notes: Sequence[str] = ()
) -> DmaTable:
    """Return a table by increasing frequency, each once, with notes on what was averaged and what is doubtful.

    Raises:
        RefusedError: the storage moduli at one frequency differ by more than scatter explains.
    """
    found = list(notes)
    order = np.argsort(omega, kind="stable")
    omega, storage, loss = _averaged(omega[order], storage[order], loss[order], found)
    found += _spikes(omega, storage, loss)
    if storage.max() > _STIFFEST:
        found.append(
            f"the storage modulus goes up to {storage.max():.4g} Pa, which no material has: check its unit"
        )
    return DmaTable(omega, storage, loss, strain, tuple(found))


def _averaged(
    omega: Floats, storage: Floats, loss: Floats, notes: list[str]
) -> tuple[Floats, Floats, Floats]:
    """Return increasing frequencies, each once: moduli at one frequency are averaged, which is added to the notes.

    Raises:
        RefusedError: the storage moduli at one frequency differ by more than scatter explains.
    """
    first = np.concatenate([[True], np.diff(omega) > _SAME * omega[1:]])
    if first.all():
        return omega, storage, loss
    member = np.cumsum(first) - 1
    count = np.bincount(member)
    hertz = omega[first] / (2.0 * math.pi)
    least = np.full(len(count), np.inf)
    most = np.zeros(len(count))
    np.minimum.at(least, member, storage)
    np.maximum.at(most, member, storage)
    worst = int(np.argmax(most / least))
    if most[worst] > _REPEAT * least[worst]:
        raise RefusedError(
            "one frequency has different storage moduli, so this is not one sweep at one temperature",
            "keep one sweep in the table; a file with a column of temperatures may have several (key temperature)",
            found=f"{least[worst]:.4g} and {most[worst]:.4g} Pa at {hertz[worst]:.4g} Hz",
        )
    repeated = count > 1
    notes.append(
        f"{counted(int(repeated.sum()), 'frequency')} stand{'s' if repeated.sum() == 1 else ''} more than once "
        f"({listed('', hertz[repeated])} Hz): the moduli there are averaged; the storage moduli differ by up to "
        f"{per_cent(100.0 * (most[worst] / least[worst] - 1.0))}"
    )
    means = [np.bincount(member, weights=values) / count for values in (omega, storage, loss)]
    return means[0], means[1], means[2]


def beside_slope(omega: Floats, storage: Floats, tangent: Floats, *, of_loss: bool = False) -> list[str]:
    """Tell of a loss factor far from what the slope of the storage modulus means: percent, or units of moduli.

    Booij, Thoone, Rheol. Acta 21 (1982) 15-24: tan delta is nearly pi/2 d(ln E')/d(ln omega).

    Args:
        omega, storage, tangent: of the rows (n,).
        of_loss: whether it was a loss modulus that was given.
    """
    known = (omega > 0.0) & (storage > 0.0) & np.isfinite(tangent)
    if np.ptp(np.log(omega[known])) < 1.0 if known.any() else True:
        return []
    slope = max(float(np.polyfit(np.log(omega[known]), np.log(storage[known]), 1)[0]), 0.0)
    usual, means = float(np.median(tangent[known])), 0.5 * math.pi * slope
    if of_loss:
        # what flows has no limit to its loss factor, and a slope that is no more than scatter says nothing
        too_large = usual > max(_OTHER_UNIT * means, 0.3) and slope < 1.0
        if not too_large and not (slope > _SLOPE and 0.0 < usual < means / _OTHER_UNIT):
            return []
        return [
            f"the loss modulus is {usual:.3g} times the storage modulus, and the slope of the storage modulus over "
            f"frequency means {means:.2g} times: if one of them has another unit (Pa, kPa, MPa), the file must say so"
        ]
    if usual < 0.3 or usual < 10.0 * means:
        return []
    return [
        f"tan delta of {usual:.4g} is far more than the slope of the storage modulus over frequency means "
        f"({means:.2g}): if it is in percent, the file must say so (tan delta [%])"
    ]


def _spikes(omega: Floats, storage: Floats, loss: Floats) -> list[str]:
    """Tell of points that stand up or down from a line through their neighbours, in logarithms.

    A lone point off by r leaves its neighbours off by -r/2; a bend of the curve does not.
    """
    if len(omega) < 6:
        return []
    x = np.log(omega)
    found = []
    for name, values in (("storage", storage), ("loss", loss)):
        if (values <= 0.0).any():
            continue
        y = np.log(values)
        off = np.zeros(len(y))
        off[1:-1] = y[1:-1] - (y[:-2] + (y[2:] - y[:-2]) * (x[1:-1] - x[:-2]) / (x[2:] - x[:-2]))
        for end, one, two in ((0, 1, 2), (-1, -2, -3)):
            off[end] = y[end] - (y[one] + (y[one] - y[two]) * (x[end] - x[one]) / (x[one] - x[two]))
        usual = 4.0 * float(np.median(np.abs(off)))
        large = np.abs(off) > max(math.log(_SPIKE[name]), usual)
        against = np.ones(len(y), dtype=bool)
        against[1:] &= off[:-1] * off[1:] <= -0.25 * off[1:] ** 2
        against[:-1] &= off[1:] * off[:-1] <= -0.25 * off[:-1] ** 2
        for k in np.flatnonzero(large & against):
            found.append(
                f"the {name} modulus at {omega[k] / (2.0 * math.pi):.4g} Hz is {100.0 * math.expm1(off[k]):+.2g} % off "
                "what its neighbours lead to expect; it is kept (band leaves out the ends)"
            )
    return found if len(found) <= 5 else [*found[:5], f"and {len(found) - 5} more such points"]


def counted(count: int, noun: str) -> str:
    """Return how many there are, with the noun in its number."""
    plural = noun[:-1] + "ies" if noun.endswith("y") else noun + "s"
    return f"{count} {noun if count == 1 else plural}"


def listed(noun: str, values: Floats | np.ndarray, most: int = 6) -> str:
    """Return values in words after a noun, which may be empty: the first ones, and how many more there are."""
    texts = [f"{value:.4g}" if isinstance(value, float) else str(value) for value in values.tolist()]
    rest = len(texts) - most
    text = ", ".join(texts[:most]) + (f" and {rest} more" if rest > 0 else "")
    return f"{noun} {text}" if noun else text
