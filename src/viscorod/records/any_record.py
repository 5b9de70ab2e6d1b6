"""What all records of measurements have in common."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np

from viscorod.argument_names import KnownArguments
from viscorod.errors import Fault, InputError
from viscorod.records.arguments import described
from viscorod.records.unknown import Unknown, resolved
from viscorod.typing import Floats

__all__ = ["AnyRecord", "deviations", "finite", "increasing"]

UNITS = {"release_time": "s", "delay": "s", "orientation": "rad", "marker": "m"}
"""Of unknowns of measurements, without the axis."""
AXIS = re.compile("_[123xyz]$")
STEP = 1e-4
"""Step of the differences by unknowns, as a part of their usual size."""


class AnyRecord(KnownArguments, ABC):
    """A record of a measurement: numbers in SI, their noise, and what is unknown of how they were measured.

    Attributes:
        name: of the record, the beginning of the names of its unknowns.
        observed: all that was measured as one row of real numbers (n,), SI.
        noise: standard deviation of the noise of each of them (n,), or None where it is not known.
        nuisances: the unknowns by full name, "tip.offset".
    """

    kind: ClassVar[str]
    analysis: ClassVar[str]
    """Kind of the result that it is compared with: "simulate", "response", "modes", "equilibrium" or "material"."""

    name: str
    observed: Floats
    noise: Floats | None
    nuisances: dict[str, Unknown]

    @abstractmethod
    def predicted(self, result: Any, nuisances: Mapping[str, float] | None = None) -> Floats:
        """Return what a result says that should have been measured (n,), beside `observed`.

        Args:
            result: of the analysis that `analysis` names.
            nuisances: values of unknowns by full name; those left out have their start.

        Raises:
            InputError: the result is of another kind, or does not reach as far as the record.
        """

    @property
    @abstractmethod
    def axes(self) -> tuple[tuple[str, str], ...]:
        """Names and SI units of what was measured, as many numbers each, in the order of `observed`."""

    def unit_of(self, unknown: Unknown) -> str:
        """Return the SI unit of an unknown of the measurement, "1" of a plain number."""
        own = self.axes[0][1]
        if unknown.name == "drift":
            return f"{own}/s"
        return own if unknown.name == "offset" else UNITS.get(AXIS.sub("", unknown.name), "1")

    @described
    def by_nuisances(self, result: Any, nuisances: Mapping[str, float] | None = None) -> dict[str, Floats]:
        """Return the derivatives of `predicted` by the unknowns of the measurement (n,) each, central differences.

        Unknowns with a key are numbers of the case, and are left out: their derivatives are those of the result.
        """
        values = self.values_of(nuisances)
        found = {}
        for full, unknown in self.nuisances.items():
            if unknown.key is not None:
                continue
            step = STEP * self.usual_size(unknown)
            ends = [
                self.predicted(result, {**values, full: values[full] + side * step}) for side in (1.0, -1.0)
            ]
            found[full] = (ends[0] - ends[1]) / (2.0 * step)
        return found

    def values_of(self, nuisances: Mapping[str, float] | None) -> dict[str, float]:
        """Return the values of the unknowns of the measurement: those given, or their starts; others are ignored."""
        given = nuisances or {}
        return {
            full: float(given.get(full, unknown.start or 0.0))
            for full, unknown in self.nuisances.items()
            if unknown.key is None
        }

    def nuisance(self, word: str, values: Mapping[str, float], default: float = 0.0) -> float:
        """Return the value of the unknown with a word, or what holds where the record has none."""
        full = next((full for full, one in self.nuisances.items() if one.name == word), None)
        return default if full is None else float(values[full])

    def usual_size(self, unknown: Unknown) -> float:
        """Return a size of an unknown by which differences are taken."""
        if np.isfinite(unknown.deviation):
            return unknown.deviation
        span = (unknown.high or 0.0) - (unknown.low or 0.0)
        return 1.0 if not np.isfinite(span) else span

    def __str__(self) -> str:
        counts = len(self.observed) // len(self.axes)
        what = " and ".join(f"{name} [{unit}]" if unit else name for name, unit in self.axes)
        noise = "not known" if self.noise is None else f"{float(np.median(self.noise)):.3g} (median)"
        unknown = ", ".join(one.name for one in self.nuisances.values()) or "nothing"
        return f"{type(self).__name__} {self.name}: {counts} of {what}{self._over()}; noise {noise}; unknown: {unknown}"

    def _over(self) -> str:
        """Return over what it was measured, in words with a blank before."""
        return ""

    def __repr__(self) -> str:
        return f"<{self}>"

    def _named(
        self, name: str, unknown: Sequence[str | Unknown], known: dict[str, tuple[float, float, float]]
    ) -> None:
        if not isinstance(name, str) or not name:
            raise InputError(Fault("name", repr(name), "a record has a name", "give a text such as 'tip'"))
        self.name = name
        self.nuisances = resolved(name, unknown, known)

    def _needs(self, result: Any, *kinds: str) -> None:
        kind = getattr(result, "kind", type(result).__name__)
        if kind not in kinds:
            raise InputError(
                f"record {self.name}: it is compared with a result of {' or '.join(kinds)}, and this is one of {kind}"
            )


def finite(where: str, values: Any, dims: int = 1) -> Floats:
    """Return finite numbers of a number of dimensions.

    Raises:
        InputError: they are none; the message says where.
    """
    try:
        given = np.asarray(values)
        found = np.array(values, dtype=float) if given.dtype.kind in "fiubO" else None
    except (TypeError, ValueError, OverflowError):
        found = None
    if found is None:
        raise InputError(Fault(where, "", "these are no numbers", "give a list of numbers"))
    if found.ndim != dims or found.size == 0:
        raise InputError(
            Fault(
                where,
                f"shape {found.shape}",
                "another shape is needed",
                f"give numbers in {dims} dimension(s)",
            )
        )
    bad = np.argwhere(~np.isfinite(found))
    if len(bad):
        place = ", ".join(str(k) for k in bad[0])
        raise InputError(
            Fault(
                f"{where}[{place}]",
                str(found[tuple(bad[0])]),
                "a record has no gaps",
                "leave samples without a number out, or cut a window without them",
            )
        )
    return found


def increasing(where: str, values: Any, instead: str = "sort the samples, each once") -> Floats:
    """Return increasing numbers (n,).

    Args:
        where: of the argument, for messages; instead: what to do.
        values: that are given.

    Raises:
        InputError: they do not increase; the message says from where on.
    """
    found = finite(where, values)
    bad = np.flatnonzero(np.diff(found) <= 0.0)
    if len(bad):
        k = int(bad[0]) + 1
        raise InputError(
            Fault(
                f"{where}[{k}]",
                f"{found[k]:g}",
                f"it does not come after {found[k - 1]:g}",
                instead,
            )
        )
    return found


def deviations(where: str, noise: Any, shape: tuple[int, ...]) -> Floats | None:
    """Return standard deviations of noise as one row, from one number or as many as there are samples; None of None.

    Raises:
        InputError: they are not positive, or of another number.
    """
    if noise is None:
        return None
    given = np.ndim(noise) if hasattr(noise, "__array__") else int(isinstance(noise, list | tuple))
    found = finite(where, noise, given)
    try:
        full = np.array(np.broadcast_to(found, shape))
    except ValueError:
        raise InputError(
            Fault(
                where,
                f"shape {found.shape}",
                f"the samples have shape {shape}",
                "give one number, or as many",
            )
        ) from None
    if not ((full > 0.0) & np.isfinite(full)).all():
        raise InputError(
            Fault(where, "", "standard deviations are positive", "leave it out where it is not known")
        )
    return full.ravel()
